"""Calibrations by halflight, mrcal and OpenCV of the same corners, as one table.

mrcal solves without a board's warp and without regularisation; outliers are left to nobody, so that
all three minimise the same sum of squares. Deviations: halflight's from its file, mrcal's from the
Jacobian of its optimizer_callback times the deviation of its residuals, OpenCV's as it states them.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import cv2
import mrcal
import numpy as np

NAMES = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")


def rotation(r):
    return cv2.Rodrigues(np.asarray(r, float))[0]


def board(columns, rows, square):
    y, x = np.mgrid[:rows, :columns]
    return np.stack([x.ravel() * square, y.ravel() * square, np.zeros(x.size)], 1)


def simulate(seed, theta, size, columns, rows, square, views, noise):
    """Corners (views, rows*columns, 2), NaN where outside; boards tilted by up to 45 degrees."""
    rng = np.random.default_rng(seed)
    points, out = board(columns, rows, square), []
    camera = np.array([[theta[0], 0, theta[2]], [0, theta[1], theta[3]], [0, 0, 1]])
    while len(out) < views:
        at = np.array([rng.uniform(-0.16, 0.16), rng.uniform(-0.12, 0.12), rng.uniform(0.3, 0.55)])
        r = rng.uniform(-0.55, 0.55, 3)
        t = at - rotation(r) @ points.mean(0)
        q = cv2.projectPoints(points, r, t, camera, np.array(theta[4:]))[0][:, 0]
        q = q + rng.normal(0, noise, q.shape)
        inside = ((q > 0) & (q < np.array(size) - 1)).all(1)
        if inside.mean() < 0.6:
            continue
        q[~inside] = np.nan
        out.append(q)
    return np.array(out)


def photos(folder):
    files = sorted(folder.glob("left[0-9][0-9].jpg"))
    out = []
    for file in files:
        grey = cv2.imread(str(file), 0)
        found, corners = cv2.findChessboardCorners(grey, (9, 6))
        if found:  # the window stays within the squares
            criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 60, 1e-4)
            out.append(cv2.cornerSubPix(grey, corners, (5, 5), (-1, -1), criteria)[:, 0])
    return np.array(out, float)


def write_vnl(corners, file):
    rows = ["# filename x y level"]
    for v, view in enumerate(corners):
        for x, y in view:
            rows.append(f"view{v:02d}.png - - -" if np.isnan(x) else f"view{v:02d}.png {x:.9f} {y:.9f} 0")
    file.write_text("\n".join(rows) + "\n")


def by_halflight(command, corners, size, columns, rows, square, asked, tmp):
    write_vnl(corners, tmp / "corners.vnl")
    args = [command, "calibrate", "--corners", tmp / "corners.vnl", "--image-size", f"{size[0]}x{size[1]}", "--target",
            f"chessboard:{columns}x{rows}:{square}", "--outlier-sigmas", "0", "--view-ratio", "0", "--json"]
    for x, y, d in asked:
        args += ["--uncertainty-at", f"{x},{y}" + (f",{d}" if d else "")]
    start = time.perf_counter()
    done = subprocess.run([str(a) for a in args], capture_output=True, text=True)
    spent = time.perf_counter() - start
    if done.returncode not in (0, 3):
        sys.exit(done.stderr)
    d = json.loads(done.stdout)
    theta = np.array([d[k] for k in NAMES[:4]] + d["distortion"])
    projected = [np.array(p["covariance"]) for p in d["projection_uncertainty"][-len(asked):]]
    return theta, np.sqrt(np.diag(d["covariance"])), d["rms_px"], projected, spent


def by_mrcal(corners, size, square, columns, rows, start_at, asked):
    """From OpenCV's focal length and poses, as mrcal's own seeding loses its way in boards seen in part."""
    n = len(corners)
    observations = np.full((n, rows * columns, 3), -1.0)
    seen = ~np.isnan(corners[..., 0])
    observations[seen, :2] = corners[seen]
    observations[seen, 2] = 1
    observations = observations.reshape(n, rows, columns, 3)
    theta, poses = start_at
    seed = np.array([*theta[:4], 0, 0, 0, 0, 0])
    indices = np.array([[i, 0, -1] for i in range(n)], np.int32)
    start = time.perf_counter()
    inputs = dict(lensmodel="LENSMODEL_OPENCV5", intrinsics=seed[None, :].copy(), extrinsics_rt_fromref=np.zeros((0, 6)),
                  frames_rt_toref=poses.copy(), points=None, observations_board=observations,
                  indices_frame_camintrinsics_camextrinsics=indices, observations_point=None,
                  indices_point_camintrinsics_camextrinsics=None, imagersizes=np.array([size], np.int32),
                  calibration_object_spacing=square, calobject_warp=None, do_optimize_calobject_warp=False, do_optimize_extrinsics=True,
                  do_optimize_frames=True,
                  do_apply_regularization=False, do_apply_outlier_rejection=False, verbose=False)
    inputs.update(do_optimize_intrinsics_core=True, do_optimize_intrinsics_distortions=True)
    mrcal.optimize(**inputs)
    b, x, jacobian, _ = mrcal.optimizer_callback(**inputs)
    jacobian = jacobian.toarray()
    scale = np.ones(b.size)
    mrcal.unpack_state(scale, **inputs)
    used = np.repeat(seen.ravel(), 2)
    sigma = np.std(x[:used.size][used])
    cov = np.linalg.inv(jacobian.T @ jacobian) * sigma**2
    sd = np.sqrt(np.diag(cov))[:9] * scale[:9]
    spent = time.perf_counter() - start
    model = mrcal.cameramodel(optimization_inputs=inputs, icam_intrinsics=0)
    projected = []
    for px, py, d in asked:
        ray = mrcal.unproject(np.array([px, py], float), *model.intrinsics(), normalize=True)
        projected.append(mrcal.projection_uncertainty(ray * (d if d else 1), model, atinfinity=not d,
                                                      observed_pixel_uncertainty=sigma))
    rms = np.sqrt((x[:used.size][used] ** 2).sum() / seen.sum())
    return inputs["intrinsics"][0], sd, rms, projected, spent


def by_opencv(corners, size, columns, rows, square):
    points = board(columns, rows, square)
    seen = [~np.isnan(c[:, 0]) for c in corners]
    start = time.perf_counter()
    rms, k, d, r, t, sd, _, _ = cv2.calibrateCameraExtended(
        [points[s].astype(np.float32) for s in seen], [c[s].astype(np.float32)[:, None] for c, s in zip(corners, seen)],
        size, None, None)
    spent = time.perf_counter() - start
    theta = np.array([k[0, 0], k[1, 1], k[0, 2], k[1, 2], *d.ravel()[:5]])
    poses = np.array([np.concatenate([a.ravel(), b.ravel()]) for a, b in zip(r, t)])
    return theta, sd.ravel()[:9], rms, poses, spent


def table(title, truth, ours, mrcals, opencvs, asked):
    print(f"\n{title}")
    print(f"{'':4} {'truth':>11} {'halflight':>12} {'+-':>9} {'mrcal':>12} {'+-':>9} {'OpenCV':>12} {'+-':>9}"
          f" {'joint s.d.':>10} {'sd ratio':>8}")
    worst, ratios = 0, []
    for i, name in enumerate(NAMES):
        apart = abs(ours[0][i] - mrcals[0][i]) / np.hypot(ours[1][i], mrcals[1][i])
        ratio = ours[1][i] / mrcals[1][i]
        worst, ratios = max(worst, apart), ratios + [ratio]
        known = f"{truth[i]:11.6g}" if truth is not None else f"{'':11}"
        print(f"{name:4} {known} {ours[0][i]:12.7g} {ours[1][i]:9.2g} {mrcals[0][i]:12.7g} {mrcals[1][i]:9.2g} "
              f"{opencvs[0][i]:12.7g} {opencvs[1][i]:9.2g} {apart:10.1e} {ratio:8.3f}")
    print(f"rms  {'':11} {ours[2]:12.6f} {'':9} {mrcals[2]:12.6f} {'':9} {opencvs[2]:12.6f}")
    print(f"time {'':11} {ours[4]:11.3f}s {'':9} {mrcals[4]:11.3f}s {'':9} {opencvs[4]:11.3f}s")
    for (x, y, d), a, b in zip(asked, ours[3], mrcals[3]):
        one, two = (np.sqrt(np.linalg.eigvalsh(c)[::-1]) for c in (a, b))
        ratios += list(one / two)
        print(f"projection at {x:5.0f},{y:5.0f} {'infinity' if not d else f'{d:g} m':>9}: halflight {one[0]:.4f} {one[1]:.4f} px, "
              f"mrcal {two[0]:.4f} {two[1]:.4f} px, ratio {one[0] / two[0]:.3f} {one[1] / two[1]:.3f}")
    return worst, ratios


def main():
    command, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    tmp = pathlib.Path(tempfile.mkdtemp())
    truth = (700.0, 702.0, 322.3, 236.8, -0.18, 0.06, 0.0008, -0.0005, 0.02)
    size, square = (640, 480), 0.023
    asked = [(319.5, 239.5, 0), (20, 20, 0), (600, 400, 0), (319.5, 239.5, 0.4), (20, 20, 0.4), (600, 400, 2)]
    cases = [("simulated, 20 views of 10 x 10 corners, 0.1 px", truth, simulate(5, truth, size, 10, 10, square, 20, 0.1),
              10, 10, square),
             ("simulated, 60 views of 10 x 10 corners, 0.2 px", truth, simulate(6, truth, size, 10, 10, square, 60, 0.2),
              10, 10, square)]
    if folder.is_dir():
        cases.append(("chessboard photos, left", None, photos(folder), 9, 6, 0.025))
    worst, ratios = 0, []
    for title, known, corners, columns, rows, side in cases:
        ours = by_halflight(command, corners, size, columns, rows, side, asked, tmp)
        opencvs = by_opencv(corners, size, columns, rows, side)
        mrcals = by_mrcal(corners, size, side, columns, rows, (opencvs[0], opencvs[3]), asked)
        w, r = table(title, known, ours, mrcals, opencvs, asked)
        worst, ratios = max(worst, w), ratios + r
    good = worst <= 1 and 0.8 <= min(ratios) and max(ratios) <= 1.2
    print(f"\nworst difference to mrcal {worst:.1e} joint deviations; our deviations {min(ratios):.3f} to {max(ratios):.3f} of mrcal's: "
          f"{'ok' if good else 'MISSED'}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
