#!/usr/bin/env python3
"""The COLMAP exports, read by COLMAP 3.8, which also measures how far its own projections of known points lie from where
this program sees them; the Bundler export against COLMAP's own; rigs and frames, which COLMAP knows from 3.12 on, by a
reader written from its source (src/colmap/scene/reconstruction_io_{text,binary}.cc)."""
import os
import shutil
import struct
import subprocess

import numpy

import export_reading
from export_read_by_described import rotation

CORNER = 0.5               # COLMAP's pixels begin at the corner of the first one
MAX_POSE_DIFFERENCE = 1e-9
missing = None if shutil.which("colmap") else "Debian's colmap is not installed"


def colmap(command, *options):
    done = subprocess.run(["colmap", command, *map(str, options)], capture_output=True, text=True, timeout=60,
                          env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
    assert done.returncode == 0, f"colmap {command}: {done.stdout}{done.stderr}"


def as_text(model):
    """The model after COLMAP has read and written it."""
    out = model.with_name(model.name + ".text")
    out.mkdir()
    colmap("model_converter", "--input_path", model, "--output_path", out, "--output_type", "TXT")
    return out


def lines(path):
    return [line for line in path.read_text().splitlines() if not line.startswith("#")]


def add_points(model, points, pixels):
    """Every point, seen in every image at pixels[view][point]."""
    images = lines(model / "images.txt")
    text, ids = "", []
    for head in images[::2]:
        view = int(head.split()[0]) - 1
        ids.append(view + 1)
        text += head + "\n" + " ".join(f"{x:.17g} {y:.17g} {i + 1}" for i, (x, y) in enumerate(pixels[view])) + "\n"
    (model / "images.txt").write_text(text)
    (model / "points3D.txt").write_text("".join(
        f"{i + 1} {x:.17g} {y:.17g} {z:.17g} 0 0 0 -1 " + " ".join(f"{v} {i}" for v in ids) + "\n"
        for i, (x, y, z) in enumerate(points)))


def colmaps_error_px(model, points, pixels):
    """Mean distance of COLMAP's projections from the pixels; its worst point."""
    add_points(model, points, pixels)
    filtered = model.with_name(model.name + ".filtered")
    filtered.mkdir()
    colmap("point_filtering", "--input_path", model, "--output_path", filtered, "--min_tri_angle", "0")
    kept = lines(as_text(filtered) / "points3D.txt")
    assert len(kept) == len(points)
    return max(float(line.split()[7]) for line in kept)


def reprojection(exports, form):
    model = as_text(exports.export("full", form))
    names = [line.split()[9] for line in lines(model / "images.txt")[::2]]
    assert sorted(names) == sorted(view["name"] for view in exports.calibration("full")["views"])
    read = [line.split()[1:4] for line in sorted(lines(model / "cameras.txt"))]
    expected = [[kind, str(camera["width_px"]), str(camera["height_px"])]
                for kind, camera in zip(("FULL_OPENCV", "OPENCV", "PINHOLE"), exports.calibration("full")["cameras"])]
    exports.check(f"{form} models and sizes", read == expected, f"{read}")
    copy = shutil.copytree(model, model.with_name(model.name + ".copy"))
    error_px = colmaps_error_px(model, exports.points, exports.pixels("full") + CORNER)
    exports.check(form, 0 <= error_px < export_reading.MAX_DIFFERENCE_PX, f"COLMAP's error is {error_px:.2g} px")
    flipped_px = colmaps_error_px(copy, exports.points, exports.pixels("full"))
    exports.check(f"{form} without the half pixel", abs(flipped_px - numpy.hypot(CORNER, CORNER)) < 1e-6,
                  f"COLMAP's error is {flipped_px:.2g} px: it does measure")


def bundler(exports):
    """COLMAP writes the same cameras as Bundler files; principal points it leaves out, the rest must be the same."""
    folder, model = exports.export("radial", "bundler"), exports.export("radial", "colmap")
    # Bundler's lens is COLMAP's RADIAL, which the exporter does not use.
    text = ""
    for line in lines(model / "cameras.txt"):
        n = line.split()
        k = n[8:10] if n[1] == "OPENCV" else ["0", "0"]
        text += " ".join([n[0], "RADIAL", n[2], n[3], n[4], n[6], n[7], *k]) + "\n"
    (model / "cameras.txt").write_text(text)
    colmap("model_converter", "--input_path", model, "--output_path", exports.root / "by_colmap", "--output_type", "Bundler")
    theirs = (exports.root / "by_colmap.bundle.out").read_text().split("\n", 1)[1]
    own = (folder / "bundle.out").read_text().split("\n", 1)[1]
    listed = (exports.root / "by_colmap.list.txt").read_text().splitlines()
    mine = (folder / "list.txt").read_text().splitlines()
    theirs, own = (numpy.array(text.split()[2:], float).reshape(len(mine), 15) for text in (theirs, own))
    difference = numpy.abs(theirs[[listed.index(name) for name in mine]] - own).max()
    exports.check("bundler", difference < 1e-9, f"COLMAP's own differs by at most {difference:.2g}")


class Words:
    """rigs.txt and frames.txt, word by word."""

    def __init__(self, path):
        self.rows = [line.split() for line in lines(path)]

    def rigs(self):
        for row in self.rows:
            sensors, rest = {int(row[3]): numpy.eye(4)}, row[4:]
            assert row[2] == "CAMERA"
            while rest:
                assert rest[0] == "CAMERA" and rest[2] == "1"
                sensors[int(rest[1])] = matrix(map(float, rest[3:10]))
                rest = rest[10:]
            assert len(sensors) == int(row[1])
            yield int(row[0]), sensors

    def frames(self):
        for row in self.rows:
            rest = row[10:]
            assert len(rest) == 3 * int(row[9]) and set(rest[::3]) == {"CAMERA"}
            yield int(row[0]), int(row[1]), matrix(map(float, row[2:9])), list(zip(map(int, rest[1::3]), map(int, rest[2::3])))


class Bytes:
    """rigs.bin and frames.bin, little endian, without gaps."""

    def __init__(self, path):
        self.bytes = path.read_bytes()

    def take(self, kinds):
        values = struct.unpack_from("<" + kinds, self.bytes)
        self.bytes = self.bytes[struct.calcsize("<" + kinds):]
        return values

    def rigs(self):
        for _ in range(self.take("Q")[0]):
            rig, count, kind, reference = self.take("IIiI")
            sensors = {reference: numpy.eye(4)}
            assert kind == 0  # a camera
            for _ in range(count - 1):
                kind, sensor, has_pose = self.take("iIB")
                assert kind == 0 and has_pose == 1
                sensors[sensor] = matrix(self.take("7d"))
            yield rig, sensors
        assert not self.bytes

    def frames(self):
        for _ in range(self.take("Q")[0]):
            frame, rig = self.take("II")
            pose = matrix(self.take("7d"))
            seen = []
            for _ in range(self.take("I")[0]):
                kind, sensor, image = self.take("iIQ")
                assert kind == 0
                seen.append((sensor, image))
            yield frame, rig, pose, seen
        assert not self.bytes


def matrix(numbers):
    w, x, y, z, *t = numbers
    b_from_a = numpy.eye(4)
    b_from_a[:3, :3], b_from_a[:3, 3] = rotation(w, x, y, z), t
    return b_from_a


def rigs_and_frames(exports, form, reader, ending):
    """One rig of three cameras, four frames, and sensor_from_rig * rig_from_world is every image's pose."""
    folder = exports.export("no_k3", form)
    rigs = dict(reader(folder / f"rigs.{ending}").rigs())
    views = exports.calibration("no_k3")["views"]
    worst, images = 0, []
    frames = list(reader(folder / f"frames.{ending}").frames())
    for _, rig, rig_from_world, seen in frames:
        for sensor, image in seen:
            view = views[image - 1]["cam_from_world"]
            pose = matrix([*view["rotation"].values(), *view["translation"]])
            worst = max(worst, numpy.abs(rigs[rig][sensor] @ rig_from_world - pose).max())
            images.append(image)
    whole = [set(rig) for rig in rigs.values()] == [{1, 2, 3}] and sorted(images) == list(range(1, 13)) and len(frames) == 4
    exports.check(f"{form} rigs and frames", whole and worst < MAX_POSE_DIFFERENCE,
                  f"{len(rigs)} rig, {len(frames)} frames, poses differ by at most {worst:.2g}")


def test(exports):
    reprojection(exports, "colmap")
    reprojection(exports, "colmap-bin")
    bundler(exports)
    rigs_and_frames(exports, "colmap", Words, "txt")
    rigs_and_frames(exports, "colmap-bin", Bytes, "bin")


if __name__ == "__main__":
    export_reading.run(test, missing)
