#!/usr/bin/env python3
"""How far the reference calibration of `yac-aprilgrid` (plain OpenCV on another detector's corners) carries: its focal length with
other distortion models, its stated sigma, and its spread over re-drawn photographs. yac_reference.py --data DIR"""
import argparse
import csv
import pathlib

import cv2
import numpy

MODELS = {"k1 k2 p1 p2 k3 (the reference)": 0, "k1 k2 p1 p2": cv2.CALIB_FIX_K3, "k1 k2 k3": cv2.CALIB_ZERO_TANGENT_DIST,
          "rational": cv2.CALIB_RATIONAL_MODEL}
NUM_DRAWS, RANDOM_SEED = 40, 1
SIZE_PX = (640, 480)


def corners(file):
    with file.open() as stream:
        rows = [{key.strip(): float(value) for key, value in row.items()} for row in csv.DictReader(stream)]
    return (numpy.array([[row[key] for key in ("p_x", "p_y", "p_z")] for row in rows], numpy.float32),
            numpy.array([[row[key] for key in ("kp_x", "kp_y")] for row in rows], numpy.float32))


def calibrated(views, flags):
    rms_px, matrix, _, _, _, sigmas, _, _ = cv2.calibrateCameraExtended([v[0] for v in views], [v[1] for v in views], SIZE_PX, None, None,
                                                                        flags=flags)
    return rms_px, [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]], sigmas.ravel()[:4]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", required=True, type=pathlib.Path)
    folder = parser.parse_args().data / "yac-aprilgrid/mocap_data/grid0/cam0/data"
    views = [corners(file) for file in sorted(folder.glob("*.csv"))]
    for name, flags in MODELS.items():
        rms_px, (fx, fy, cx, cy), sigma = calibrated(views, flags)
        print(f"{name}: {rms_px:.3f} px RMS, fx {fx:.1f} +- {sigma[0]:.1f}, fy {fy:.1f} +- {sigma[1]:.1f}, centre {cx:.1f} {cy:.1f}")
    random = numpy.random.default_rng(RANDOM_SEED)
    drawn = [calibrated([views[i] for i in random.integers(len(views), size=len(views))], 0)[1] for _ in range(NUM_DRAWS)]
    spread = numpy.std(drawn, axis=0)
    print(f"the reference on {NUM_DRAWS} draws of {len(views)} photographs with replacement: standard deviation fx {spread[0]:.1f}, "
          f"fy {spread[1]:.1f}, centre {spread[2]:.1f} {spread[3]:.1f}")


if __name__ == "__main__":
    main()
