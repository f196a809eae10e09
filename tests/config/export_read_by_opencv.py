#!/usr/bin/env python3
"""The OpenCV export and undistort.yml, read and applied by OpenCV."""
import cv2
import numpy

import export_reading
from export_read_by_described import bundler, openmvg


def open_cv(exports):
    file = cv2.FileStorage(str(exports.export("full", "opencv")), cv2.FILE_STORAGE_READ)
    cameras, views = file.getNode("cameras"), file.getNode("views")
    seen = []
    for v in range(views.size()):
        view = views.at(v)
        camera = cameras.at(int(view.getNode("camera").real()))
        seen.append(cv2.projectPoints(exports.points, view.getNode("rvec").mat(), view.getNode("tvec").mat(),
                                      camera.getNode("camera_matrix").mat(),
                                      camera.getNode("distortion_coefficients").mat())[0][:, 0])
    exports.compare("opencv", seen, exports.pixels("full"))


def undistorted(exports, form, read):
    """Where OpenCV takes the photograph's pixels by undistort.yml is where the exported camera sees the points."""
    folder = exports.export("full", form, "--undistorted")
    file = cv2.FileStorage(str(folder / "undistort.yml"), cv2.FILE_STORAGE_READ)
    cameras = file.getNode("cameras")
    exact = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-14)
    expected = []
    for view, pixels in zip(exports.calibration("full")["views"], exports.pixels("full")):
        names = [camera["id"] for camera in exports.calibration("full")["cameras"]]
        camera = cameras.at(view["camera"] if isinstance(view["camera"], int) else names.index(view["camera"]))
        k, distortion, new_k = (camera.getNode(key).mat() for key in ("camera_matrix", "distortion_coefficients",
                                                                      "new_camera_matrix"))
        expected.append(cv2.undistortPointsIter(pixels.reshape(-1, 1, 2), k, distortion, None, new_k, exact)[:, 0])
    exports.compare(f"{form} --undistorted", read(folder, exports), numpy.array(expected))


def test(exports):
    open_cv(exports)
    undistorted(exports, "bundler", bundler)
    undistorted(exports, "openmvg", openmvg)


if __name__ == "__main__":
    export_reading.run(test)
