#!/usr/bin/env python3
"""fit_ppr.py NPF.npz: errors of two-term fits to 25 measured materials, beside R's ppr on the same samples.

The tables are factors of MERL materials (Bagher et al. 2016): rhoD + rhoS D(th) F(td) G(ti) G(to) / (cos cos).
Orthographic balls of 100 px, view (0,0,1), three lights. Ours is the mean over all channels, R's on their
mean. Needs Rscript and HALFLIGHT.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

LIGHTS = ((1, 1, 1), (10, 10, 1), (25, 25, 1))
HERE = pathlib.Path(__file__).resolve().parent


def unit(a):
    return np.asarray(a, float) / np.linalg.norm(a)


def lerp(table, x):
    x = np.clip(x, 0, len(table) - 1.001)
    i = x.astype(int)
    return table[i] * (1 - x + i)[:, None] + table[i + 1] * (x - i)[:, None]


def radiance(t, i, n, s):
    """(N,3) BRDF x cos of lit, seen normals under the view (0,0,1)."""
    h = unit(s + np.array([0, 0, 1.0]))
    deg = lambda c: np.degrees(np.arccos(np.clip(c, 0, 1)))
    d = lerp(t["D"][i], np.sqrt(deg(n @ h) / 90) * 90)
    f = lerp(t["F"][i], np.full(len(n), deg(h[2])))
    g = lerp(t["G1"][i], deg(n @ s)) * lerp(t["G1"][i], deg(n[:, 2]))
    return t["rhoD"][i] * (n @ s)[:, None] + t["rhoS"][i] * d * f * g / n[:, 2:]


def ball(radius=50):
    g = np.arange(-radius + 0.5, radius, 1.0)
    x, y = np.meshgrid(g, -g)
    k = x * x + y * y < radius * radius
    x, y = x[k] / radius, y[k] / radius
    return np.stack([x, y, np.sqrt(1 - x * x - y * y)], 1)


def main():
    path = pathlib.Path(sys.argv[1])
    if not path.exists():
        print(f"no {path}: the materials' table is left out")
        return 0
    z = np.load(path)
    tables = {k: z[k].astype(float) for k in ("rhoD", "rhoS", "D", "G1", "F")}
    names, n, ratios = [str(x) for x in z["names"]], ball(), []
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for light in LIGHTS:
            s = unit(light)
            keep = (n @ s > 0.02) & (n[:, 2] > 0.05)
            for i, name in enumerate(names):
                rad = radiance(tables, i, n[keep], s)
                file = pathlib.Path(folder) / f"{name}-{light[0]}.csv"
                np.savetxt(file, np.c_[n[keep], rad / rad.mean()], delimiter=",", header="nx,ny,nz,r,g,b", comments="", fmt="%.9g")
                files.append((name, light, file))
        r = subprocess.run(["Rscript", HERE / "fit_ppr.R", "2", "5", *[f for _, _, f in files]], capture_output=True, text=True, check=True)
        theirs = {line.split()[0]: float(line.split()[2]) for line in r.stdout.splitlines()}
        print(f"\n{'two terms, mean |fit - data| / mean data, %':44s}" + "".join(f"{str(l):>26s}" for l in LIGHTS))
        print(f"{'':44s}" + "".join(f"{'R':>10s}{'ours':>8s}{'ratio':>8s}" for _ in LIGHTS))
        rows = {}
        for name, light, file in files:
            p = subprocess.run([os.environ["HALFLIGHT"], "fit", file, "--model", "pursuit", "--terms", "2", "--json"], capture_output=True, text=True, check=False)
            ours, other = json.loads(p.stdout)["relative_error"], theirs[str(file)]
            ratios.append(ours / other)
            rows.setdefault(name, []).append((other, ours))
        for name, row in rows.items():
            print(f"{name:44s}" + "".join(f"{100 * a:10.2f}{100 * b:8.2f}{b / a:8.2f}" for a, b in row))
    print(f"ratio to R's: median {np.median(ratios):.2f}, largest {max(ratios):.2f}, of {len(ratios)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
