#!/usr/bin/env python3
"""Bench, not a test: how often the stated 95 % ellipse holds the light on 25 measured materials, which the model
describes only about.

    merl_coverage.py [--halflight BUILD/halflight] [--data FOLDER] [--sources factors,networks] [--mode hdr|ldr]
                     [--angles 15,35,55,75,88] [--radius R] [--frames FOLDER] [--each]

Frames are balls in perspective under a light so many degrees from the view, 4 x 4 samples a pixel: `hdr` with noise of
0.3 % and 0.2 % of the median lit radiance, `ldr` one exposure of 12 bits whose highlights clip. Materials are the
factor tables (npf.npz) and the networks (nbrdf.npz) of FOLDER, both fits of the MERL database. With --frames the
frames are kept there, to measure another build on the same. The ball's pose and the camera are exact, so that the
ellipse is the noise's and the model's alone. Columns, over the answers called ok:

    inside   share whose ellipse holds the light
    m2       d' C^-1 d: median (1.39 where the ellipse is true), 90th percentile (4.6) and largest
    error    of the direction [deg]: median and largest
    axis     of the ellipse, major half [deg]: median
    worst    largest (error - 0.2 deg) in stated deviations along the major axis
"""
import argparse
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import merl_table as mt  # noqa: E402

PROJECT = pathlib.Path(__file__).resolve().parent.parent.parent
SIZE, FOCAL, OVERSAMPLE, BACKGROUND, RADIUS_M = 256, 1400.0, 4, 0.002, 0.025
TURN_DEG = 137.5  # between one angle's lights and the next, about the view
INSIDE = 5.991464547


class Networks:
    """Sztrajman et al. 2021: six numbers of half and difference vector through 21 + 21 ReLU, exp(.) - 1."""

    def __init__(self, path):
        z = np.load(path)
        self.names, self.w = [str(n) for n in z["names"]], z["W"].astype(float)

    def radiance(self, name, n, s, v):
        w, layers, at = self.w[self.names.index(name)], [], 0
        for shape in ((6, 21), (21,), (21, 21), (21,), (21, 3), (3,)):
            layers.append(w[at : at + np.prod(shape)].reshape(shape))
            at += int(np.prod(shape))
        light, view = mt.in_frame_of(n, s), mt.in_frame_of(n, v)
        theta, diff, phi = mt.angles(light, view)
        x = np.stack([np.sin(theta), 0 * theta, np.cos(theta), np.sin(diff) * np.cos(phi), np.sin(diff) * np.sin(phi), np.cos(diff)], 1)
        for k in (0, 2):
            x = np.maximum(x @ layers[k] + layers[k + 1], 0)
        brdf = np.maximum(np.exp(x @ layers[4] + layers[5]) - 1, 0)
        return np.where(((light[:, 2] > 0) & (view[:, 2] > 0))[:, None], brdf * np.clip(light[:, 2:], 0, None), 0)


def geometry(radius_px):
    at = np.array([160.0 - 127.5, -60.0, FOCAL])  # off the axis, the frame cut out about it
    camera = {"format": "halflight-camera", "version": 1, "model": "pinhole", "width": SIZE, "height": SIZE, "fx": FOCAL, "fy": FOCAL,
              "cx": 127.5 - at[0], "cy": 127.5 - at[1], "distortion": [0, 0, 0, 0, 0]}
    center = mt.unit(at) * RADIUS_M / np.sin(np.arctan(radius_px / FOCAL))
    return camera, {"format": "halflight-sphere", "version": 1, "center_m": center.tolist(), "radius_m": RADIUS_M}


def render(camera, ball, shade):
    center = np.array(ball["center_m"])
    px, py = np.meshgrid(np.arange(SIZE, dtype=float), np.arange(SIZE, dtype=float))
    total = np.zeros((SIZE * SIZE, 3))
    for k in range(OVERSAMPLE**2):
        dx, dy = [(i + 0.5) / OVERSAMPLE - 0.5 for i in divmod(k, OVERSAMPLE)]
        rays = mt.unit(np.stack([(px + dx - camera["cx"]) / FOCAL, (py + dy - camera["cy"]) / FOCAL, 1 + 0 * px], -1).reshape(-1, 3))
        along = rays @ center
        inside = along**2 - (center @ center - RADIUS_M**2)
        hit = inside > 0
        p = rays[hit] * (along[hit] - np.sqrt(inside[hit]))[:, None]
        sample = np.full((SIZE * SIZE, 3), BACKGROUND)
        sample[hit] = shade((p - center) / RADIUS_M, -rays[hit])
        total += sample
    return (total / OVERSAMPLE**2).reshape(SIZE, SIZE, 3)


def develop(image, mode, rng):
    mean = image.mean(2)
    ball = mean[np.abs(mean - BACKGROUND) > 1e-9 * BACKGROUND]
    lit = ball[ball > 0.02 * np.percentile(ball, 90)]
    if mode == "hdr":
        deviation = np.hypot(0.003 * image, 0.002 * np.median(lit))
        return np.maximum(image + rng.normal(size=image.shape) * deviation, 0)
    exposed = image * 0.6 / np.percentile(lit, 90)
    electrons = rng.poisson(np.minimum(exposed, 4) * 20000) + rng.normal(size=image.shape) * 5
    return np.round(np.clip(electrons / 20000, 0, 1) * 4095) / 4095


def write_pfm(path, image):
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % image.shape[1::-1])
        f.write(np.ascontiguousarray(image[::-1], "<f4").tobytes())


def light_at(ball, angle_deg, number):
    """So far from the direction in which the ball is seen."""
    toward = -mt.unit(ball["center_m"])
    x = mt.unit(np.cross((0, 1, 0), toward))
    y = np.cross(toward, x)
    a, b = np.radians(angle_deg), np.radians(20 + TURN_DEG * number)
    return np.cos(a) * toward + np.sin(a) * (np.cos(b) * x + np.sin(b) * y)


def measure(command, light):
    p = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if p.returncode not in (0, 3):
        sys.exit(f"{' '.join(map(str, command))}: {p.stderr.strip()}")
    out = json.loads(p.stdout)
    if not out.get("lights"):
        return None
    answer = out["lights"][0]
    s = np.array(answer["direction"])
    off = np.array(answer["tangent_basis"]) @ (light - s)
    covariance = np.array(answer["covariance_rad2"])
    return {"ok": out["status"] == "ok", "m2": float(off @ np.linalg.solve(covariance, off)),
            "error": float(np.degrees(np.arctan2(np.linalg.norm(np.cross(s, light)), s @ light))),
            "axis": float(np.degrees(np.sqrt(INSIDE * np.linalg.eigvalsh(covariance)[1])))}


def row(what, found):
    ok = [f for f in found if f and f["ok"]]
    if not ok:
        return f"{what:28s} {len(found):3d} {0:3d}"
    m2, error, axis = (np.array([f[k] for f in ok]) for k in ("m2", "error", "axis"))
    worst = ((error - 0.2) / (axis / np.sqrt(INSIDE))).max()
    return (f"{what:28s} {len(found):3d} {len(ok):3d}  {np.mean(m2 <= INSIDE):6.3f} {np.median(m2):8.3f} {np.percentile(m2, 90):8.2f} {m2.max():9.2f}"
            f" {np.median(error):8.4f} {error.max():8.4f} {np.median(axis):8.4f} {worst:7.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--halflight", default=PROJECT / "build" / "halflight")
    parser.add_argument("--data", type=pathlib.Path, default=PROJECT.parent / "shared" / "data" / "merl")
    parser.add_argument("--sources", default="factors,networks")
    parser.add_argument("--mode", choices=("hdr", "ldr"), default="hdr")
    parser.add_argument("--angles", default="15,35,55,75,88")
    parser.add_argument("--radius", type=float, default=90)
    parser.add_argument("--frames", type=pathlib.Path)
    parser.add_argument("--each", action="store_true", help="a line for every frame")
    a = parser.parse_args()
    angles = [float(x) for x in a.angles.split(",")]
    camera, ball = geometry(a.radius)
    every = []
    with tempfile.TemporaryDirectory() as tmp:
        work, frames = pathlib.Path(tmp), a.frames or pathlib.Path(tmp)
        frames.mkdir(parents=True, exist_ok=True)
        for name, what in (("camera", camera), ("sphere", ball)):
            (work / f"{name}.json").write_text(json.dumps(what))
        print(f"{'':28s} all  ok  inside   m2: median  90 %  largest    error   largest   axis   worst")
        for source in a.sources.split(","):
            of = mt.Factors(a.data / "npf.npz") if source == "factors" else Networks(a.data / "nbrdf.npz")
            found = {}
            for i, name in enumerate(of.names):
                for j, angle in enumerate(angles):
                    light = light_at(ball, angle, j)
                    frame = frames / f"{source}-{a.mode}-{a.radius:g}-{name}-{angle:g}.pfm"
                    if not a.frames or not frame.exists():
                        image = render(camera, ball, lambda n, v: of.radiance(name, n, light, v))
                        write_pfm(frame, develop(image, a.mode, np.random.default_rng(1000 * i + j)))
                    extra = ["--saturation", "1"] if a.mode == "ldr" else []
                    found[name, angle] = measure([a.halflight, "estimate", frame, "--camera", work / "camera.json", "--sphere", work / "sphere.json", "--json", *extra], light)
                    if a.each:
                        print(row(f"  {name[:19]} {angle:g}", [found[name, angle]]), flush=True)
                    if not a.frames:
                        frame.unlink()
                print(row(f"{source[:-1]} {name[:20]}", [found[name, x] for x in angles]), flush=True)
            for angle in angles:
                print(row(f"{source} at {angle:g} deg", [found[name, angle] for name in of.names]))
            print(row(f"{source}, {a.mode}", list(found.values())))
            every += found.values()
    print(row(f"all, {a.mode}", every))


if __name__ == "__main__":
    main()
