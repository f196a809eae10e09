#!/usr/bin/env python3
"""The mrcal export, read and projected by mrcal's library (C, by ctypes: its Python package brings 70 others)."""
import ctypes

import cv2
import numpy

import export_reading

try:
    mrcal = ctypes.CDLL("libmrcal.so.2")
    missing = None
except OSError:
    missing = "Debian's libmrcal2 is not installed"


class LensModel(ctypes.Structure):
    # mrcal_lensmodel_t: the type, then a union of configurations, of which the largest is one double (CAHVORE)
    _fields_ = [("type", ctypes.c_int), ("configuration", ctypes.c_double)]


class CameraModel(ctypes.Structure):
    # mrcal_cameramodel_t; the intrinsics follow
    _fields_ = [("rt_cam_ref", ctypes.c_double * 6), ("imagersize", ctypes.c_uint * 2), ("lensmodel", LensModel)]


def numbers(array):
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def projected(path, points, size_px):
    mrcal.mrcal_read_cameramodel_file.restype = ctypes.POINTER(CameraModel)
    model = mrcal.mrcal_read_cameramodel_file(str(path).encode())
    assert model, f"{path}: mrcal cannot read it"
    assert tuple(model.contents.imagersize) == size_px
    rt = numpy.array(model.contents.rt_cam_ref)
    in_cam = numpy.ascontiguousarray(points @ cv2.Rodrigues(rt[:3])[0].T + rt[3:])
    pixels = numpy.empty((len(points), 2))
    intrinsics = ctypes.cast(ctypes.addressof(model.contents) + ctypes.sizeof(CameraModel), ctypes.POINTER(ctypes.c_double))
    mrcal.mrcal_project.restype = ctypes.c_bool
    assert mrcal.mrcal_project(numbers(pixels), None, None, numbers(in_cam), len(points),
                               ctypes.byref(model.contents.lensmodel), intrinsics)
    return pixels


def test(exports):
    folder = exports.export("full", "mrcal")
    calibration = exports.calibration("full")
    sizes = {camera["id"]: (camera["width_px"], camera["height_px"]) for camera in calibration["cameras"]}
    seen = [projected(folder / view["name"].replace(".png", ".cameramodel"), exports.points, sizes[view["name"].split("_")[0]])
            for view in calibration["views"]]
    exports.compare("mrcal", seen, exports.pixels("full"))


if __name__ == "__main__":
    export_reading.run(test, missing)
