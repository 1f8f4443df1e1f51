"""The command's MERL tables against the database's published reader, restated in numpy (merl_table.py).

    merl_reference.py HALFLIGHT

Random tables drawn by `render --lookup nearest`, cell for cell; tables that `brdf` writes, against the formula of
the fit; and, where the factor tables of MERL materials are at hand, tables of those drawn by `render`."""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import merl_table as mt

FACTORS = pathlib.Path("../shared/data/merl/npf.npz")
VIEW = np.array([0.0, 0.0, 1.0])
failed = []


def run(*words):
    done = subprocess.run([sys.argv[1], *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: exit status {done.returncode}: {done.stderr}")


def at_most(what, value, limit):
    print(f"{'ok' if value <= limit else 'FAILED':7}{what}: {value:.3g} <= {limit:g}")
    if not value <= limit:
        failed.append(what)


def drawn(table, light, radius, *options):
    out = table.with_suffix(".pfm")
    run("render", table, "--light=" + ",".join(map(str, light)), "--sphere-px", radius, "--out", out, *options)
    n, inside = mt.ball(radius)
    return n, mt.read_pfm(out)[inside].astype(float)


def error(got, want, keep):
    return np.abs(got[keep] - want[keep]).mean() / want[keep].mean()


def nearest(folder):
    """Every pixel is the cell that the published reader takes, away from the cells' edges."""
    table, rng = folder / "random.binary", np.random.default_rng(5)
    brdf = rng.uniform(0, 1, mt.DIMS + (3,))
    mt.write(table, brdf)
    for light in ((1, 1, 1), (-1, 0.3, 0.2), (10, 10, 1), (0.1, -0.2, 1)):
        n, got = drawn(table, light, 40, "--lookup", "nearest")
        s = mt.unit(light)
        incoming, outgoing = mt.in_frame_of(n, s), mt.in_frame_of(n, VIEW)
        place = np.stack(mt.cells(*mt.angles(incoming, outgoing)), -1)
        clear = (np.abs(place - np.round(place)) > 1e-6).all(-1) & (n @ s > 1e-6)
        want = mt.look_up(brdf, incoming, outgoing) * (n @ s)[:, None]
        at_most(f"nearest cell, light {light}, {clear.sum()} pixels, largest difference",
                np.abs(got[clear] - want[clear]).max(), 1e-6)
        at_most(f"nearest cell, light {light}, pixels at a cell's edge, share", 1 - clear.sum() / (n @ s > 1e-6).sum(), 0.02)


def fitted(folder):
    """`brdf` of a body and a foreshortened lobe: its BRDF at the cells' centres, reciprocal and asymmetric angles alike."""
    t = np.cos(np.pi / 2 * np.linspace(1, 0, 121) ** 2)
    t[0] = 0
    lobe = lambda x: 0.4 * x**20
    light = mt.unit((1, 1, 1)).tolist()
    half = mt.unit(np.array(light) + VIEW).tolist()
    fit = {"format": "halflight-fit", "version": 1, "model": "dichromatic", "light": {"direction": light, "given": True},
           "terms": [{"role": "linear", "name": "s", "direction": light, "plane": [1, 0],
                      "curve": {"t": [0, 1], "value": [[0, 0.2], [0, 0.1], [0, 0.05]]}},
                     {"role": "lobe", "name": "h", "direction": half, "plane": [1, 1], "foreshortening": "1/(n.v)",
                      "curve": {"t": t.tolist(), "value": [lobe(t).tolist()] * 3}}]}
    (folder / "fit.json").write_text(json.dumps(fit))
    run("brdf", folder / "fit.json", "--out", folder / "fit.binary")
    brdf = mt.read(folder / "fit.binary")
    incoming, outgoing = mt.centers()
    above = (incoming[..., 2] > 0.01) & (outgoing[..., 2] > 0.01)
    half = mt.unit(incoming + outgoing)[above]
    want = np.array([0.2, 0.1, 0.05]) + (lobe(half[:, 2]) / (incoming[above, 2] * outgoing[above, 2]))[:, None]
    at_most("brdf at the cells' centres, mean relative difference", (np.abs(brdf[above] - want) / want).mean(), 1e-5)
    at_most("brdf: cells without a value", float((~(brdf >= 0)).sum()), 0)
    for new in ((1, 1, 1), (-1, 1, 1), (10, 3, 1)):
        n, got = drawn(folder / "fit.binary", new, 40)
        s = mt.unit(new)
        x = n @ mt.unit(s + VIEW)
        want = np.array([0.2, 0.1, 0.05]) * (n @ s)[:, None] + (lobe(x) / n[:, 2])[:, None]
        at_most(f"fit, brdf, render: light {new}, mean relative error", error(got, want, (n @ s > 0.02) & (n[:, 2] > 0.05)), 1e-3)


def factors(folder):
    """Tables of materials: what `render` draws of them is the materials' own radiance, to the tables' resolution."""
    source = mt.Factors(FACTORS)
    for name in ("gold-metallic-paint", "natural-209", "green-plastic"):
        mt.write(folder / "material.binary", source.as_table(name))
        for light in ((1, 1, 1), (10, 10, 1)):
            n, got = drawn(folder / "material.binary", light, 50)
            s = mt.unit(light)
            want = source.radiance(name, n, s, VIEW)
            # a highlight of a few pixels is a few cells wide
            at_most(f"{name}, light {light}, mean relative error", error(got, want, (n @ s > 0.02) & (n[:, 2] > 0.05)), 0.01)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        nearest(folder)
        fitted(folder)
        if FACTORS.exists():
            factors(folder)
        else:
            print(f"skipped: the materials of {FACTORS}, which is not here")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
