#!/usr/bin/env python3
"""The paper's figures 1-5 and 7-11 again, each as a picture and as rows of a table.

    python3 tests/bench/figures.py build/halflight OUT [--merl FOLDER]

FOLDER holds MERL .binary files (gold-metallic-paint.binary, ...); without it the factor tables of the
same materials in ../shared/data/merl are used, where they are there. Needs python3-numpy and
python3-matplotlib. Frame of the samples: x right, y up, z to the viewer, v = (0, 0, 1).
"""
import argparse
import json
import pathlib
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

RADIUS = 50
V = np.array([0.0, 0.0, 1.0])
COLOURS = ("#d55e00", "#009e73", "#0072b2")  # Okabe and Ito


def unit(a):
    a = np.asarray(a, float)
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def line_angle(a, b):
    a, b = unit(a), unit(b)
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), abs(a @ b))))


def sphere():
    """Normals of a ball that fills an image, and which pixels it covers."""
    g = (np.arange(2 * RADIUS) + 0.5) / RADIUS - 1
    x, y = np.meshgrid(g, -g)
    inside = x * x + y * y < 1
    z = np.sqrt(np.clip(1 - x * x - y * y, 0, 1))
    return np.stack([x, y, z], -1), inside


NORMALS, INSIDE = sphere()


class Factors:
    """rhoD + rhoS D(theta_h) F(theta_d) G(theta_i) G(theta_o) / (cos cos), tables by degree (Bagher et al. 2016)."""

    def __init__(self, path):
        z = np.load(path)
        self.names = [str(n) for n in z["names"]]
        self.t = {k: z[k].astype(float) for k in ("rhoD", "rhoS", "D", "G1", "F")}

    def image(self, name, light):
        i, s, n = self.names.index(name), unit(light), NORMALS[INSIDE]
        h = unit(s + V)
        nl, nv, nh = n @ s, n @ V, n @ h
        deg = lambda c: np.degrees(np.arccos(np.clip(c, 0, 1)))
        d = lerp(self.t["D"][i], np.sqrt(deg(nh) / 90) * 90)
        f = lerp(self.t["F"][i], deg(np.full_like(nh, V @ h)))
        g = lerp(self.t["G1"][i], deg(nl)) * lerp(self.t["G1"][i], deg(nv))
        out = self.t["rhoD"][i] * np.clip(nl, 0, None)[:, None]
        out = out + self.t["rhoS"][i] * d * f * g / np.clip(nv, 1e-3, 1)[:, None]
        image = np.zeros(NORMALS.shape)
        image[INSIDE] = np.where((nl > 0)[:, None], out, 0) / np.pi
        return image


def lerp(table, x):
    x = np.clip(x, 0, len(table) - 1.001)
    i = x.astype(int)
    f = (x - i)[:, None]
    return table[i] * (1 - f) + table[i + 1] * f


class Measured:
    """A folder of MERL .binary files, drawn by the command."""

    def __init__(self, folder, work):
        self.folder, self.work = pathlib.Path(folder), work
        self.names = [p.stem for p in self.folder.glob("*.binary")]

    def image(self, name, light):
        out = self.work / "measured.pfm"
        command("render", self.folder / f"{name}.binary", "--light=" + numbers(light), "--sphere-px", RADIUS, "--out", out)
        image = read_pfm(out)
        return np.where(np.isfinite(image), image, 0)


def numbers(a):
    return ",".join(f"{x:.17g}" for x in a)


def command(*args):
    p = subprocess.run([BINARY, *map(str, args)], capture_output=True, text=True)
    if p.returncode not in (0, 3):
        sys.exit(f"halflight {' '.join(map(str, args))}: exit {p.returncode}\n{p.stderr}")
    return p.stdout


def read_pfm(path):
    with open(path, "rb") as f:
        kind, size, scale = f.readline().strip(), f.readline().split(), float(f.readline())
        a = np.frombuffer(f.read(), "<f4" if scale < 0 else ">f4").reshape(int(size[1]), int(size[0]), -1)[::-1]
    return np.repeat(a, 3, 2) if kind == b"Pf" else a


class Bench:
    def __init__(self, source, out):
        self.source, self.out, self.rows = source, out, []

    def row(self, figure, what, value, unit_, paper=""):
        self.rows.append((figure, what, value, unit_, paper))
        print(f"{figure:8s} {what:62s} {value:9.4g} {unit_:4s} {paper}", flush=True)

    def fit(self, name, light, *options):
        """The fitted document, its file, the photo in its units, and the samples."""
        s = unit(light)
        image = self.source.image(name, light)
        keep = INSIDE & (NORMALS @ s > 0.02) & (NORMALS[..., 2] > 0.05)
        image = image / image[keep].mean()
        csv, fit = self.out / "samples.csv", self.out / "fit.json"
        np.savetxt(csv, np.c_[NORMALS[keep], image[keep]], delimiter=",", header="nx,ny,nz,r,g,b", comments="", fmt="%.9g")
        command("fit", csv, *options, "--out", fit)
        return json.loads(fit.read_text()), fit, image, keep

    def scaled(self, name, light, like):
        """The photo under another light, in the units of a fit under `like`."""
        keep = INSIDE & (NORMALS @ unit(like) > 0.02) & (NORMALS[..., 2] > 0.05)
        return self.source.image(name, light) / self.source.image(name, like)[keep].mean()

    def relit(self, fit, light, *options):
        command("relight", fit, "--light=" + numbers(unit(light)), *(options or ("--sphere-px", RADIUS)), "--out", self.out / "relit.pfm")
        return read_pfm(self.out / "relit.pfm")

    def compared(self, image, truth, light):
        keep = INSIDE & (NORMALS @ unit(light) > 0.1) & (NORMALS[..., 2] > 0.1)
        return 100 * np.abs(image - truth)[keep].mean() / truth[keep].mean()


def show(axis, image, title, white, factor=1):
    x = np.clip(factor * image / white, 0, 1)
    axis.imshow(np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055))
    axis.set_title(title, fontsize=9)
    axis.axis("off")


def curves(axis, fit, term, image, keep, title):
    """A term's curve over the data projected along it, what the other terms explain taken off."""
    t = fit["terms"][term]
    n, data = NORMALS[keep], image[keep]
    rest = sum(evaluate(fit["terms"][k], n) for k in range(len(fit["terms"])) if k != term)
    g = 1 / n[:, 2] if t.get("foreshortening", "none") != "none" else np.ones(len(n))
    cloud = (data - rest) / g[:, None]
    along = n @ np.array(t["direction"])
    some = np.random.default_rng(0).permutation(len(along))[:1500]
    value = curve_of(t)
    for c in range(3):
        axis.plot(along[some], cloud[some, c], ".", ms=1.5, alpha=0.35, color=COLOURS[c])
        axis.plot(t["curve"]["t"], value[c], "-", lw=1.5, color=COLOURS[c])
    axis.set_title(title, fontsize=9)
    axis.set_xlim(max(-0.2, along.min()), 1.02)
    top = max(np.nanmax(value), 1e-9)
    if top > 20 * max(np.percentile(data, 90), 1e-9):  # a sharp lobe is a spike on a linear axis
        axis.set_yscale("log")
        axis.set_ylim(1e-4 * top, 2 * top)
    else:
        axis.set_ylim(-0.05 * top, 1.1 * top)
    axis.set_xlabel("a . n", fontsize=8)
    axis.tick_params(labelsize=7)


def curve_of(term):
    value = np.array(term["curve"]["value"], float)
    value = np.atleast_2d(value)
    return value if value.shape[0] == 3 else np.repeat(value, 3, 0)


def evaluate(term, n):
    along = n @ np.array(term["direction"])
    g = 1 / np.clip(n[:, 2], 1e-3, 1) if term.get("foreshortening", "none") != "none" else 1
    return np.stack([g * np.interp(along, term["curve"]["t"], c) for c in curve_of(term)], 1)


def name_of(term):
    d = term["direction"]
    return term.get("name") or "(%.3f, %.3f, %.3f)" % tuple(d)


def lobes(fit):
    return [t for t in fit["terms"] if t["role"] == "lobe"]


def sheet(rows, columns):
    figure, axes = plt.subplots(rows, columns, figsize=(2.6 * columns, 2.6 * rows), constrained_layout=True, squeeze=False)
    return figure, axes


def knot(path):
    """A tube along a (2,3) torus knot, as the complex geometry."""
    u = np.linspace(0, 2 * np.pi, 241)[:-1]
    w = np.linspace(0, 2 * np.pi, 33)[:-1]
    r = 2 + np.cos(3 * u)
    centre = np.stack([r * np.cos(2 * u), r * np.sin(2 * u), -np.sin(3 * u)], 1)
    along = unit(np.roll(centre, -1, 0) - np.roll(centre, 1, 0))
    side = unit(np.cross(along, unit(centre)))
    up = np.cross(along, side)
    normal = np.cos(w)[None, :, None] * side[:, None] + np.sin(w)[None, :, None] * up[:, None]
    point = centre[:, None] + 0.45 * normal
    with open(path, "w") as f:
        for p in point.reshape(-1, 3):
            f.write("v %.6f %.6f %.6f\n" % tuple(p))
        for p in normal.reshape(-1, 3):
            f.write("vn %.6f %.6f %.6f\n" % tuple(p))
        a, b = point.shape[:2]
        for i in range(a):
            for k in range(b):
                q = [1 + (i + di) % a * b + (k + dk) % b for di, dk in ((0, 0), (1, 0), (1, 1), (0, 1))]
                f.write("f " + " ".join(f"{x}//{x}" for x in q) + "\n")


def figure_1(b):
    fit, _, image, keep = b.fit("gold-metallic-paint", (1e-9, 0, 1), "--model", "ridge")
    b.row("1", "gold-metallic-paint, colocated: direction to v", line_angle(fit["terms"][0]["direction"], V), "deg", "paper 0.7")
    figure, ax = sheet(1, 2)
    show(ax[0, 0], image, "input", np.percentile(image[INSIDE], 99.5))
    curves(ax[0, 1], fit, 0, image, keep, "1-D curve and data")
    return figure


def figure_2(b):
    figure, ax = sheet(2, 3)
    for i, (name, paper) in enumerate((("green-plastic", 0.19), ("gray-plastic", 0.14))):
        fit, _, image, keep = b.fit(name, (1, 1, 1), "--model", "dichromatic")
        d = unit(lobes(fit)[0]["direction"])
        d = d * np.sign(d[2])
        b.row("2", f"{name}: light from the lobe's direction", line_angle(2 * (d @ V) * d - V, (1, 1, 1)), "deg", f"paper {paper}")
        show(ax[i, 0], image, name, np.percentile(image[INSIDE], 99))
        for k in range(min(2, len(fit["terms"]))):
            curves(ax[i, 1 + k], fit, k, image, keep, f"{fit['terms'][k]['role']}: {fit['identifiability']['verdict']}")
    return figure


def figure_3(b):
    figure, ax = sheet(2, 3)
    t, seen = np.linspace(0.3, 0.999, 200), []
    for i, light in enumerate(((1, 1, 1), (-1, 1, 1))):
        fit, _, image, keep = b.fit("violet-acrylic", light, "--model", "dichromatic", "--light=" + numbers(unit(light)))
        lobe = lobes(fit)[0]
        b.row("3", f"violet-acrylic {light}: lobe to h", line_angle(lobe["direction"], unit(light) + V), "deg", "paper 3")
        seen.append(np.array([np.interp(t, lobe["curve"]["t"], c) for c in curve_of(lobe)]))
        show(ax[i, 0], image, f"input {light}", np.percentile(image[INSIDE], 99))
        for k in range(min(2, len(fit["terms"]))):
            curves(ax[i, 1 + k], fit, k, image, keep, name_of(fit["terms"][k]))
    b.row("3", "violet-acrylic: curves of the two lights differ", 100 * np.linalg.norm(seen[0] - seen[1]) / np.linalg.norm(seen[0]), "%")
    return figure


def relighting(b, figure_name, name, old, new, models, paper=""):
    """Input, relit by each model, truth, three times the errors."""
    truth = b.scaled(name, new, old)
    white = np.percentile(truth[INSIDE], 99)
    figure, ax = sheet(len(models), 4)
    for i, (what, options) in enumerate(models):
        fit, path, image, _ = b.fit(name, old, *options, "--light=" + numbers(unit(old)))
        relit = b.relit(path, new)
        error = b.compared(relit, truth, new)
        b.row(figure_name, f"{name} {old} -> {new}: {what}", error, "%", paper if i == 0 else "")
        b.row(figure_name, f"{name} {old}: fit, {what}", 100 * fit["relative_error"], "%")
        show(ax[i, 0], image, f"input {old}", np.percentile(image[INSIDE], 99))
        show(ax[i, 1], relit, f"{what}, {new}", white)
        show(ax[i, 2], truth, "ground truth", white)
        show(ax[i, 3], np.abs(relit - truth) * (NORMALS @ unit(new) > 0.02)[..., None], f"error x 3, mean {error:.1f} %", white, 3)
    return figure


def figure_4(b):
    return relighting(b, "4", "specular-yellow-phenolic", (1, 1, 1), (-1, 1, 1), [("1-lobe", ["--model", "dichromatic"])])


def figure_5(b):
    return relighting(b, "5", "green-metallic-paint", (1, 1, 1), (-1, 1, 1),
                      [("1-lobe", ["--model", "dichromatic"]), ("Torrance-Sparrow", ["--model", "torrance-sparrow"])])


def figure_7(b):
    name, light = "ipswich-pine-221", (10, 10, 1)
    h = unit(unit(light) + V)
    one, _, image, keep = b.fit(name, light, "--model", "dichromatic", "--light=" + numbers(unit(light)))
    two, path, _, _ = b.fit(name, light, "--model", "pursuit", "--terms", 2)
    b.row("7", f"{name}: 1-lobe fit", 100 * one["relative_error"], "%", "paper 4.76")
    b.row("7", f"{name}: 2-term fit, light unknown", 100 * two["relative_error"], "%", "paper 2.14")
    b.row("7", f"{name}: nearest term to h", min(line_angle(t["direction"], h) for t in two["terms"]), "deg", "paper 2")
    b.row("7", f"{name}: nearest term to s", min(line_angle(t["direction"], light) for t in two["terms"]), "deg", "paper 2")
    known, path, _, _ = b.fit(name, light, "--model", "pursuit", "--terms", 2, "--light=" + numbers(unit(light)))
    new = (-1, 1, 1)
    truth, relit = b.scaled(name, new, light), b.relit(path, new)
    b.row("7", f"{name} {light} -> {new}: relit by 2 terms", b.compared(relit, truth, new), "%")
    figure, ax = sheet(2, 4)
    show(ax[0, 0], image, f"input {light}", np.percentile(image[INSIDE], 99))
    curves(ax[0, 1], one, len(one["terms"]) - 1, image, keep, "1-lobe: " + name_of(one["terms"][-1]))
    for k in range(2):
        curves(ax[0, 2 + k], two, k, image, keep, "2 terms: " + name_of(two["terms"][k]))
    white = np.percentile(truth[INSIDE], 99)
    show(ax[1, 0], relit, f"relit {new}", white)
    show(ax[1, 1], truth, "ground truth", white)
    show(ax[1, 2], np.abs(relit - truth) * (NORMALS @ unit(new) > 0.02)[..., None], "error x 3", white, 3)
    ax[1, 3].axis("off")
    return figure


def figure_8(b):
    name, light, new = "natural-209", (25, 25, 1), (-1, 1, 1)
    figure = relighting(b, "8", name, light, new, [("2 terms", ["--model", "pursuit", "--terms", 2])])
    fit, path, _, _ = b.fit(name, light, "--model", "pursuit", "--terms", 2)
    h = unit(unit(light) + V)
    b.row("8", f"{name}: 2-term fit, light unknown", 100 * fit["relative_error"], "%", "paper 2.61")
    b.row("8", f"{name}: nearest term to h", min(line_angle(t["direction"], h) for t in fit["terms"]), "deg", "paper 2")
    return figure


def figure_9(b):
    light, new = (25, 25, 1), (-1, 1, 1)
    fit, path, image, _ = b.fit("special-walnut-224", light, "--model", "pursuit", "--terms", 2, "--light=" + numbers(unit(light)))
    b.row("9", "special-walnut-224: 2-term fit", 100 * fit["relative_error"], "%")
    gloss = next((t["name"] for t in fit["terms"] if t.get("name") == "h"), name_of(fit["terms"][0]))
    knot(b.out / "knot.obj")
    drawn = ("--mesh", b.out / "knot.obj", "--size", "240x240")
    edits = [("as fitted", ()), ("gloss halved", (f"--scale={gloss}=0.5",)), ("aimed at s + 0.3 v", (f"--aim={gloss}=1,0.3",)),
             ("both", (f"--scale={gloss}=0.5", f"--aim={gloss}=1,0.3"))]
    figure, ax = sheet(1, 5)
    show(ax[0, 0], image, f"input {light}", np.percentile(image[INSIDE], 99))
    white = None
    for i, (what, options) in enumerate(edits):
        out = b.relit(path, new, *drawn, *options)
        white = white or np.percentile(out[out > 0], 99)
        show(ax[0, 1 + i], out, what, white)
    return figure


def two_terms(b, number, name, light, paper):
    fit, _, image, keep = b.fit(name, light, "--model", "pursuit", "--terms", 2)
    known, path, _, _ = b.fit(name, light, "--model", "pursuit", "--terms", 2, "--light=" + numbers(unit(light)))
    b.row(number, f"{name}: 2-term fit, light unknown", 100 * fit["relative_error"], "%", paper)
    b.row(number, f"{name}: 2-term fit, light known, along {' and '.join(name_of(t) for t in known['terms'])}", 100 * known["relative_error"], "%")
    new = (-1, 1, 1)
    truth, relit = b.scaled(name, new, light), b.relit(path, new)
    b.row(number, f"{name} {light} -> {new}: relit", b.compared(relit, truth, new), "%")
    white = np.percentile(truth[INSIDE], 99)
    figure, ax = sheet(2, 3)
    show(ax[0, 0], image, f"input {light}", np.percentile(image[INSIDE], 99))
    for k in range(2):
        curves(ax[0, 1 + k], known, k, image, keep, name_of(known["terms"][k]))
    show(ax[1, 0], relit, f"relit {new}", white)
    show(ax[1, 1], truth, "ground truth", white)
    show(ax[1, 2], np.abs(relit - truth) * (NORMALS @ unit(new) > 0.02)[..., None], "error x 3", white, 3)
    return figure


def figure_10(b):
    return two_terms(b, "10", "polyethylene", (1, 1, 1), "paper 1.57")


def figure_11(b):
    return two_terms(b, "11", "blue-fabric", (10, 10, 1), "paper 2.05")


FIGURES = {"1": figure_1, "2": figure_2, "3": figure_3, "4": figure_4, "5": figure_5, "7": figure_7, "8": figure_8, "9": figure_9,
           "10": figure_10, "11": figure_11}


def main():
    global BINARY
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("halflight")
    p.add_argument("out", type=pathlib.Path)
    p.add_argument("--merl", help="folder of MERL .binary files")
    p.add_argument("--only", help="figures, with commas")
    a = p.parse_args()
    BINARY = str(pathlib.Path(a.halflight).resolve())
    a.out.mkdir(parents=True, exist_ok=True)
    factors = pathlib.Path("../shared/data/merl/npf.npz")
    if not a.merl and not factors.exists():
        print(f"no --merl FOLDER and no {factors}: nothing to draw")
        return 0
    bench = Bench(Measured(a.merl, a.out) if a.merl else Factors(factors), a.out)
    for number, draw in FIGURES.items():
        if not a.only or number in a.only.split(","):
            figure = draw(bench)
            figure.savefig(a.out / f"figure-{int(number):02d}.png", dpi=110)
            plt.close(figure)
    with open(a.out / "figures.csv", "w") as f:
        f.write("figure,what,value,unit,paper\n")
        f.writelines(f'{n},"{what}",{value:.6g},{u},{paper}\n' for n, what, value, u, paper in bench.rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
