"""A session to time a replay with: replay_session.py FOLDER [FRAMES [DISTINCT]]

Frames of 640 x 480, 16-bit PNG, three channels; a ball of 100 px radius, a body and a Beckmann-like lobe
over n.v, lit from DISTINCT (24) directions; further frames are hard links to those. Noise: read 0.001, shot
0.003 at radiance 1, rounded to 12 bits as a sensor does; fixed seed. truth.json holds the directions.
"""
import json
import os
import sys

import cv2
import numpy as np

WIDTH, HEIGHT, OVERSAMPLE, FOCAL = 640, 480, 3, 1400.0
CENTER, RADIUS = np.array([0.002, -0.001, 0.2817]), 0.02
BODY, LOBE_WIDTH, SCALE = np.array([0.5, 0.2, 0.08]), 0.2, 0.45


def rays():
    at = (np.arange(OVERSAMPLE) + 0.5) / OVERSAMPLE - 0.5
    x = (np.arange(WIDTH)[:, None] + at).ravel() - (WIDTH - 1) / 2
    y = (np.arange(HEIGHT)[:, None] + at).ravel() - (HEIGHT - 1) / 2
    ray = np.stack([*np.meshgrid(x / FOCAL, y / FOCAL), np.ones((len(y), len(x)))], -1)
    return ray / np.linalg.norm(ray, axis=-1, keepdims=True)


def draw(ray, light):
    along = ray @ CENTER
    left = along**2 - CENTER @ CENTER + RADIUS**2
    hit = left > 0
    r = ray[hit]
    n = ((along[hit] - np.sqrt(left[hit]))[:, None] * r - CENTER) / RADIUS
    h = light - r
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    ns, nv = np.maximum(0, n @ light), -np.sum(n * r, -1)
    cos = np.clip(np.sum(n * h, -1), 1e-6, 1)
    lobe = np.exp((1 - 1 / cos**2) / LOBE_WIDTH**2) / (4 * np.maximum(nv, 1e-3)) * (ns > 0)
    image = np.full((*ray.shape[:2], 3), 0.1)
    image[hit] = BODY * ns[:, None] + lobe[:, None]
    return image.reshape(HEIGHT, OVERSAMPLE, WIDTH, OVERSAMPLE, 3).mean((1, 3))


def lights(count):
    k = np.arange(count)
    polar, azimuth = np.radians(12 + 58 * k / max(count - 1, 1)), 2.39996 * k
    return np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), -np.cos(polar)], -1)


def main():
    folder = sys.argv[1]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 48
    distinct = min(count, int(sys.argv[3]) if len(sys.argv) > 3 else 24)
    os.makedirs(folder, exist_ok=True)
    random = np.random.default_rng(7)
    ray, directions, frames = rays(), lights(distinct), []
    for i in range(count):
        name = f"{i:05d}.png"
        path = os.path.join(folder, name)
        if os.path.exists(path):
            os.unlink(path)
        if i < distinct:
            image = draw(ray, directions[i])
            image = image + random.normal(size=image.shape) * np.sqrt(1e-6 + 9e-6 * image)
            levels = np.clip(np.round(SCALE * image * 4095), 0, 4095).astype(np.uint16)
            cv2.imwrite(path, (levels * 16 + levels // 256)[..., ::-1])
        else:
            os.link(os.path.join(folder, f"{i % distinct:05d}.png"), path)
        frames.append({"file": name, "label": f"L{i:05d}", "exposure_us": 1000.0, "gain": 1.0})
    camera = {"format": "halflight-camera", "version": 1, "model": "pinhole", "width": WIDTH, "height": HEIGHT,
              "fx": FOCAL, "fy": FOCAL, "cx": (WIDTH - 1) / 2, "cy": (HEIGHT - 1) / 2, "distortion": [0, 0, 0, 0, 0]}
    session = {"format": "halflight-session", "version": 1, "camera": "camera.json", "sphere": None,
               "radius_m": RADIUS, "frames": frames}
    truth = {"lights": [{"label": f["label"], "direction": directions[i % distinct].tolist(), "intensity": 1}
                        for i, f in enumerate(frames)]}
    for name, value in ("camera", camera), ("session", session), ("truth", truth):
        with open(os.path.join(folder, name + ".json"), "w", encoding="utf-8") as out:
            json.dump(value, out)


main()
