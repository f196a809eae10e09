#!/usr/bin/env python3
"""Does `rigcal validate` accept good cameras and no bent ones, on photographs? Each camera file is judged as it is and bent by a
random projectivity, so strong that object points lie 2 to 10 px off (mean, after the best similarity).

honesty.py --rigcal BIN --tools DIR --images DIR --points FILE [--camera-from-name REGEX] [--random-seed N] [--json FILE] PAR...

--tools is the folder with gt_error.py (../shared/tools). Bent cameras reach the program in turns as one set of intrinsics a physical camera
(the median of its views) and as a camera of its own for each view; skew, which no camera file may hold, is dropped.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

KINDS = ("all", "affine", "plane at infinity")
EACH_VIEW = "(.*)"
MIN_ERROR_PX, MAX_ERROR_PX = 2, 10
WEAKEST = 1e-4  # of the random matrix that is added to the identity; doubled twice until strong enough, then bisected
STRENGTH_STEPS = 30


def decompose(p):
    """K, R, t of a 3x4 matrix: P[:, :3] = K R."""
    q, r = np.linalg.qr(np.linalg.inv(p[:, :3]))
    k, rotation = np.linalg.inv(r), q.T
    signs = np.diag(np.sign(np.diag(k)))
    k, rotation = k @ signs, signs @ rotation
    scale = k[2, 2]
    if np.linalg.det(rotation) < 0:
        rotation, scale = -rotation, -scale
    return k / k[2, 2], rotation, np.linalg.inv(k) @ p[:, 3] * (k[2, 2] / scale)


def bent_by(cameras, camera_of_view, change, shared):
    names, ks, rs, ts = cameras
    out = [decompose(k @ np.c_[r, t] @ change) for k, r, t in zip(ks, rs, ts)]
    new_k = np.array([k for k, _, _ in out])
    new_k[:, 0, 1] = 0
    if shared:
        for camera in set(camera_of_view):
            members = [i for i, c in enumerate(camera_of_view) if c == camera]
            new_k[members] = np.median(new_k[members], axis=0)
    return names, new_k, np.array([r for _, r, _ in out]), np.array([t for _, _, t in out])


def bend(gt_error, cameras, camera_of_view, points, target_px, kind, shared, rng):
    change = rng.standard_normal((4, 4))
    if kind == "affine":
        change[3] = 0
    if kind == "plane at infinity":
        change[:3], change[3, 3] = 0, 0
    mean = points["X"].mean(0)
    size = np.sqrt(((points["X"] - mean) ** 2).sum(1).mean())
    unit = np.eye(4) / size
    unit[:3, 3], unit[3, 3] = -mean / size, 1
    some = np.linspace(0, len(points["X"]) - 1, 100).astype(int)
    few = {"X": points["X"][some], "vis": points["vis"][some] if points["vis"] is not None else None}
    weak, strong = WEAKEST, None
    strength = weak
    for _ in range(STRENGTH_STEPS):
        bent = bent_by(cameras, camera_of_view, np.linalg.inv(unit) @ (np.eye(4) + strength * change) @ unit, shared)
        error_px = gt_error(cameras, few, bent)["mean"]
        if abs(error_px / target_px - 1) < 0.05:
            break
        weak, strong = (strength, strong) if error_px < target_px else (weak, strength)
        strength = np.sqrt(weak * strong) if strong else 4 * weak
    return bent, error_px


def validate(args, par, camera_from_name):
    command = [args.rigcal, "validate", "--images", args.images, "--cameras", str(par), "--json", "--threads", "1"]
    if camera_from_name:
        command += ["--camera-from-name", camera_from_name]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 3):
        return f"refused: {done.stderr.strip()}", []
    report = json.loads(done.stdout)
    return report["verdict"], [f"{r['check']} {r['value']:.3g}>{r['limit']:.3g}" for r in report["reasons"]]


def judge_all(args, folder):
    """A row for each camera file as it is and one for it bent."""
    sys.path.insert(0, args.tools)
    from common import load_par, load_points, save_par
    from gt_error import gt_error

    points = load_points(args.points)
    rng = np.random.default_rng(args.random_seed)
    rows = []
    for number, file in enumerate(args.cameras):
        cameras = load_par(file)
        matrices = {tuple(k.ravel()): i for i, k in reversed(list(enumerate(cameras[1])))}
        camera_of_view = [matrices[tuple(k.ravel())] for k in cameras[1]]
        verdict, reasons = validate(args, file, args.camera_from_name)
        rows.append({"file": file, "bent_px": 0, "verdict": verdict, "reasons": reasons})
        shared, kind = number % 2 == 0, KINDS[number // 2 % len(KINDS)]
        target_px = rng.uniform(MIN_ERROR_PX, MAX_ERROR_PX)
        bent, error_px = bend(gt_error, cameras, camera_of_view, points, target_px, kind, shared, rng)
        par = folder / f"bent{number}_par.txt"
        save_par(par, *bent)
        bent_verdict, bent_reasons = validate(args, par, args.camera_from_name if shared else EACH_VIEW)
        rows.append({"file": par.name, "bent_px": error_px, "shared": shared, "kind": kind, "verdict": bent_verdict,
                     "reasons": bent_reasons})
        print(f"{file}: {verdict} {'; '.join(reasons[:3])}\n  bent by {error_px:.1f} px ({kind}, {'shared' if shared else 'per view'}): "
              f"{bent_verdict} {'; '.join(bent_reasons[:3])}", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    for name in ("rigcal", "tools", "images", "points"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--camera-from-name", default="")
    parser.add_argument("--random-seed", type=int, default=0)
    parser.add_argument("--json")
    parser.add_argument("cameras", nargs="+")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rigcal-honesty-") as folder:
        rows = judge_all(args, pathlib.Path(folder))
    for name, group in (("unbent", [r for r in rows if not r["bent_px"]]), ("bent", [r for r in rows if r["bent_px"]])):
        print(f"{name}: {sum(r['verdict'] == 'accepted' for r in group)} of {len(group)} accepted")
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
