"""Measured materials in numpy alone, by the published layout and reader (BRDFRead.cpp of the MERL database)
and by the factor tables of npf.npz: an independent side for the test and the bench of measured materials."""
import struct

import numpy as np

DIMS = (90, 90, 180)
SCALE = np.array([1.0, 1.15, 1.66]) / 1500


def unit(a):
    a = np.asarray(a, float)
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def write(path, brdf):
    """brdf: shape (90, 90, 180, 3) [1/sr], negative where not measured."""
    with open(path, "wb") as f:
        f.write(struct.pack("<3i", *DIMS))
        np.ascontiguousarray(np.moveaxis(brdf / SCALE, -1, 0), "<f8").tofile(f)


def read(path):
    with open(path, "rb") as f:
        dims = struct.unpack("<3i", f.read(12))
        values = np.frombuffer(f.read(), "<f8").reshape((3,) + dims)
    return np.moveaxis(values, 0, -1) * SCALE


def rotate(vector, axis, angle):
    axis, angle = np.broadcast_to(np.asarray(axis, float), vector.shape), np.asarray(angle)[..., None]
    along = (vector * axis).sum(-1, keepdims=True) * axis
    return vector * np.cos(angle) + along * (1 - np.cos(angle)) + np.cross(axis, vector) * np.sin(angle)


def angles(light, view):
    """theta_half, theta_diff, phi_diff of unit vectors about the normal (0,0,1), as the reader turns them."""
    half = unit(light + view)
    theta, phi = np.arccos(np.clip(half[..., 2], -1, 1)), np.arctan2(half[..., 1], half[..., 0])
    diff = rotate(rotate(light, (0, 0, 1), -phi), (0, 1, 0), -theta)
    return theta, np.arccos(np.clip(diff[..., 2], -1, 1)), np.arctan2(diff[..., 1], diff[..., 0])


def cells(theta_half, theta_diff, phi_diff):
    """Cell of each, as real numbers: the reader cuts them off."""
    degrees = theta_half / (np.pi / 2) * 90
    phi = np.where(phi_diff < 0, phi_diff + np.pi, phi_diff)
    return np.sqrt(degrees * 90), theta_diff / (np.pi / 2) * 90, phi / np.pi * 180


def look_up(brdf, light, view):
    at = [np.clip(x.astype(int), 0, n - 1) for x, n in zip(cells(*angles(light, view)), DIMS)]
    return brdf[at[0], at[1], at[2]]


def centers():
    """Light and view, shape (90, 90, 180, 3), that have a cell's centre as their angles."""
    theta, diff, phi = np.meshgrid(((np.arange(90) + 0.5) / 90) ** 2 * np.pi / 2, (np.arange(90) + 0.5) * np.pi / 180,
                                   (np.arange(180) + 0.5) * np.pi / 180, indexing="ij")
    x, y, z = np.sin(diff) * np.cos(phi), np.sin(diff) * np.sin(phi), np.cos(diff)
    turn = lambda x, y, z: np.stack([np.cos(theta) * x + np.sin(theta) * z, y, np.cos(theta) * z - np.sin(theta) * x], -1)
    return turn(x, y, z), turn(-x, -y, z)


def in_frame_of(n, a):
    """a in a frame whose z is n; isotropic materials do not care how it is turned."""
    t = unit(np.cross(n, np.where(np.abs(n[..., :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])))
    a = np.broadcast_to(a, n.shape)
    return np.stack([(a * t).sum(-1), (a * np.cross(n, t)).sum(-1), (a * n).sum(-1)], -1)


def ball(radius):
    """Normals of an image that a ball fills, x right, y up, z to the viewer, and where it is in the image."""
    g = np.arange(-radius + 0.5, radius, 1.0)
    x, y = np.meshgrid(g, -g)
    inside = x * x + y * y < radius * radius
    x, y = x[inside] / radius, y[inside] / radius
    return np.stack([x, y, np.sqrt(1 - x * x - y * y)], 1), inside


def read_pfm(path):
    with open(path, "rb") as f:
        kind, size, scale = f.readline().strip(), f.readline().split(), float(f.readline())
        a = np.frombuffer(f.read(), "<f4" if scale < 0 else ">f4").reshape(int(size[1]), int(size[0]), -1)[::-1]
    return np.repeat(a, 3, 2) if kind == b"Pf" else a


class Factors:
    """Bagher, Snyder and Nowrouzezahrai 2016: BRDF pi = rhoD + rhoS D(theta_half) F(theta_diff) G1(theta_i)
    G1(theta_o) / (cos cos), tables of 90 with D binned by the root of theta_half."""

    def __init__(self, path):
        z = np.load(path)
        self.names = [str(n) for n in z["names"]]
        self.table = {k: z[k].astype(float) for k in ("rhoD", "rhoS", "D", "G1", "F")}

    def brdf(self, name, light, view):
        """Light and view about the normal (0,0,1), both above the horizon; any shape (..., 3)."""
        i, t = self.names.index(name), self.table
        half = unit(light + view)
        degrees = lambda c: np.degrees(np.arccos(np.clip(c, 0, 1)))
        d = _lerp(t["D"][i], np.sqrt(degrees(half[..., 2]) / 90) * 90)
        f = _lerp(t["F"][i], degrees((view * half).sum(-1)))
        g = _lerp(t["G1"][i], degrees(light[..., 2])) * _lerp(t["G1"][i], degrees(view[..., 2]))
        return (t["rhoD"][i] + t["rhoS"][i] * d * f * g / (light[..., 2] * view[..., 2])[..., None]) / np.pi

    def radiance(self, name, n, s, v):
        """BRDF x cos of unit normals (N,3) under light s seen along v; 0 where either is behind."""
        light, view = in_frame_of(n, s), in_frame_of(n, v)
        lit = (light[:, 2] > 0) & (view[:, 2] > 0)
        out = np.zeros(n.shape)
        out[lit] = self.brdf(name, light[lit], view[lit]) * light[lit, 2:]
        return out

    def as_table(self, name):
        """Cells whose centre is below the horizon are not measured."""
        light, view = centers()
        above = (light[..., 2] > 0) & (view[..., 2] > 0)
        out = np.full(DIMS + (3,), -1.0)
        out[above] = self.brdf(name, light[above], view[above])
        return out


def _lerp(table, x):
    x = np.clip(x, 0, len(table) - 1.001)
    i = x.astype(int)
    f = (x - i)[..., None]
    return table[i] * (1 - f) + table[i + 1] * f
