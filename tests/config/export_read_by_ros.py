#!/usr/bin/env python3
"""The ROS export, read by ROS's own camera_calibration_parsers; plumb_bob is OpenCV's model."""
import cv2
import numpy

import export_reading

try:
    import camera_calibration_parsers
    missing = None
except ImportError:
    missing = "Debian's python3-camera-calibration-parsers is not installed"


def test(exports):
    folder = exports.export("full", "ros")
    calibration = exports.calibration("full")
    seen = []
    for view in calibration["views"]:
        name = view["name"].split("_")[0]
        read_name, info = camera_calibration_parsers.readCalibration(str(folder / f"{name}.yaml"))
        width_px, height_px = next((c["width_px"], c["height_px"]) for c in calibration["cameras"] if c["id"] == name)
        assert read_name == name and (info.width, info.height) == (width_px, height_px)
        assert info.distortion_model == "plumb_bob" and list(info.R) == [1, 0, 0, 0, 1, 0, 0, 0, 1]
        k = numpy.reshape(info.K, (3, 3))
        assert (numpy.reshape(info.P, (3, 4)) == numpy.c_[k, numpy.zeros(3)]).all()
        w, x, y, z = view["cam_from_world"]["rotation"].values()
        angle = 2 * numpy.arctan2(numpy.linalg.norm((x, y, z)), w)
        rvec = numpy.array((x, y, z)) / numpy.linalg.norm((x, y, z)) * angle  # poses are not in the format
        seen.append(cv2.projectPoints(exports.points, rvec, numpy.array(view["cam_from_world"]["translation"]), k,
                                      numpy.array(info.D))[0][:, 0])
    exports.compare("ros", seen, exports.pixels("full"))


if __name__ == "__main__":
    export_reading.run(test, missing)
