#!/usr/bin/env python3
"""Formats that no program in Debian reads: readers written from the formats' descriptions, with the projection that each
format itself defines. YAML, JSON and XML are parsed by Python's libraries."""
import json
import xml.etree.ElementTree

import numpy
import yaml

import export_reading


def homogeneous(points):
    return numpy.c_[points, numpy.ones(len(points))]


def radial(x, y, *k):
    r2 = x * x + y * y
    return 1 + sum(coefficient * r2 ** (i + 1) for i, coefficient in enumerate(k))


def middlebury(path, exports):
    lines = path.read_text().splitlines()
    assert int(lines[0]) == len(lines) - 1
    seen = []
    for line in lines[1:]:
        numbers = numpy.array(line.split(" ")[1:], float)
        assert len(numbers) == 21
        k, r, t = numbers[:9].reshape(3, 3), numbers[9:18].reshape(3, 3), numbers[18:]
        p = (exports.points @ r.T + t) @ k.T
        seen.append(p[:, :2] / p[:, 2:])
    return seen


def pmvs(folder, exports):
    seen = []
    for line in (folder / "views.txt").read_text().splitlines():
        words = (folder / f"txt/{line.split()[0]}.txt").read_text().split()
        assert words[0] == "CONTOUR"
        p = numpy.array(words[1:], float).reshape(3, 4)
        assert abs(numpy.linalg.norm(p[2, :3]) - 1) < 1e-12
        x = homogeneous(exports.points) @ p.T
        assert (x[:, 2] > 0).all()  # PMVS takes the sign for the side
        seen.append(x[:, :2] / x[:, 2:])
    return seen


def kalibr(path, exports):
    """Camera by camera, for the first stop: where cam0 stands is not in the file and comes from the example."""
    chain = yaml.safe_load(path.read_text())
    views = exports.calibration("no_k3")["views"]
    pose = numpy.eye(4)
    q = views[0]["cam_from_world"]["rotation"].values()
    pose[:3, :3], pose[:3, 3] = rotation(*q), views[0]["cam_from_world"]["translation"]
    seen = []
    for n in range(len(chain)):
        camera = chain[f"cam{n}"]
        own = exports.calibration("no_k3")["cameras"][n]
        assert camera["resolution"] == [own["width_px"], own["height_px"]]
        pose = numpy.array(camera["T_cn_cnm1"]) @ pose if n else pose
        x = (homogeneous(exports.points) @ pose.T)[:, :3]
        fu, fv, pu, pv = camera["intrinsics"]
        x, y = x[:, 0] / x[:, 2], x[:, 1] / x[:, 2]
        assert camera["camera_model"] == "pinhole"
        k1, k2, r1, r2 = camera["distortion_coeffs"] if camera["distortion_model"] == "radtan" else (0, 0, 0, 0)
        d, rr = radial(x, y, k1, k2), x * x + y * y
        xd = x * d + 2 * r1 * x * y + r2 * (rr + 2 * x * x)
        yd = y * d + 2 * r2 * x * y + r1 * (rr + 2 * y * y)
        seen.append(numpy.c_[fu * xd + pu, fv * yd + pv])
    return seen


def rotation(w, x, y, z):
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def nerfstudio(path, exports):
    """Camera to world, OpenGL axes; pixel coordinates from the corner, in which the first pixel's centre is 0.5."""
    content = json.loads(path.read_text())
    assert content["camera_model"] == "OPENCV" and "applied_transform" not in content
    seen = []
    calibration = exports.calibration("no_k3")
    sizes = {camera["id"]: (camera["width_px"], camera["height_px"]) for camera in calibration["cameras"]}
    for frame, view in zip(content["frames"], calibration["views"], strict=True):
        assert frame["file_path"] == view["name"] and (frame["w"], frame["h"]) == sizes[view["camera"]]
        x = (homogeneous(exports.points) @ numpy.linalg.inv(frame["transform_matrix"]).T)[:, :3]
        assert (x[:, 2] < 0).all()  # the camera looks along -z
        x, y = x[:, 0] / -x[:, 2], -x[:, 1] / -x[:, 2]
        d, rr = radial(x, y, frame["k1"], frame["k2"]), x * x + y * y
        xd = x * d + 2 * frame["p1"] * x * y + frame["p2"] * (rr + 2 * x * x)
        yd = y * d + frame["p1"] * (rr + 2 * y * y) + 2 * frame["p2"] * x * y
        seen.append(numpy.c_[frame["fl_x"] * xd + frame["cx"], frame["fl_y"] * yd + frame["cy"]] - 0.5)
    return seen


def metashape(path, exports):
    """Agisoft's user manual, frame cameras: u = w/2 + cx + x' f + x' B1 + y' B2, v = h/2 + cy + y' f."""
    chunk = xml.etree.ElementTree.parse(path).getroot().find("chunk")
    sensors = {sensor.get("id"): sensor for sensor in chunk.iter("sensor")}
    assert [e.text for e in chunk.find("transform")] == ["1 0 0 0 1 0 0 0 1", "0 0 0", "1"]
    seen = []
    for camera in chunk.iter("camera"):
        calibration = sensors[camera.get("sensor_id")].find("calibration")
        n = {element.tag: float(element.text) for element in calibration if element.text and element.text.strip()}
        w, h = (float(calibration.find("resolution").get(key)) for key in ("width", "height"))
        world_from_cam = numpy.array(camera.find("transform").text.split(), float).reshape(4, 4)
        x = (homogeneous(exports.points) @ numpy.linalg.inv(world_from_cam).T)[:, :3]
        x, y = x[:, 0] / x[:, 2], x[:, 1] / x[:, 2]
        d, rr = radial(x, y, n["k1"], n["k2"], n["k3"]), x * x + y * y
        xd = x * d + n["p1"] * (rr + 2 * x * x) + 2 * n["p2"] * x * y
        yd = y * d + n["p2"] * (rr + 2 * y * y) + 2 * n["p1"] * x * y
        u = w / 2 + n["cx"] + xd * n["f"] + xd * n["b1"] + yd * n["b2"]
        seen.append(numpy.c_[u, h / 2 + n["cy"] + yd * n["f"]] - 0.5)
    return seen


def realitycapture(folder, exports):
    """Capturing Reality's "XMP camera math"; lengths are shares of the longer side, 36 mm wide."""
    xcr = "{http://www.capturingreality.com/ns/xcr/1.1#}"
    sizes = {camera["id"]: (camera["width_px"], camera["height_px"]) for camera in exports.calibration("square")["cameras"]}
    seen = []
    for view in exports.calibration("square")["views"]:
        text = (folder / view["name"].replace(".png", ".xmp")).read_text()
        node = xml.etree.ElementTree.fromstring(text)[0][0]
        w, h = sizes[view["name"].split("_")[0]]
        scale = max(w, h)
        r = numpy.array(node.find(xcr + "Rotation").text.split(), float).reshape(3, 3)
        c = numpy.array(node.find(xcr + "Position").text.split(), float)
        k = numpy.array(node.find(xcr + "DistortionCoeficients").text.split(), float)
        assert node.get(xcr + "DistortionModel") == ("brown3t2" if k.any() else "perspective")
        assert node.get(xcr + "Skew") == "0" and node.get(xcr + "AspectRatio") == "1"
        x = (exports.points - c) @ r.T
        x, y = x[:, 0] / x[:, 2], x[:, 1] / x[:, 2]
        d, rr = radial(x, y, *k[:4]), x * x + y * y
        xd = x * d + k[4] * (rr + 2 * x * x) + 2 * k[5] * x * y
        yd = y * d + k[5] * (rr + 2 * y * y) + 2 * k[4] * x * y
        f = float(node.get(xcr + "FocalLength35mm")) / 36
        u, v = (float(node.get(xcr + "PrincipalPoint" + axis)) for axis in "UV")
        seen.append(numpy.c_[w / 2 + scale * (f * xd + u), h / 2 + scale * (f * yd + v)] - 0.5)
    return seen


def openmvg(folder, exports):
    """sfm_data.json 0.3: cereal's pointers, x = R (X - C), one focal length."""
    content = json.loads((folder / "sfm_data.json").read_text())
    pointers, types, intrinsics = [], {}, {}
    for view in content["views"]:
        assert view["value"]["polymorphic_id"] == 0x40000000
        pointers.append(view["value"]["ptr_wrapper"]["id"])
    for entry in content["intrinsics"]:
        value = entry["value"]
        if value["polymorphic_id"] & 0x80000000:  # a new type, with its name
            types[value["polymorphic_id"] & 0x7fffffff] = value["polymorphic_name"]
        else:
            assert "polymorphic_name" not in value
        pointers.append(value["ptr_wrapper"]["id"])
        intrinsics[entry["key"]] = (types[value["polymorphic_id"] & 0x7fffffff], value["ptr_wrapper"]["data"])
    assert pointers == [0x80000000 + 1 + i for i in range(len(pointers))]
    poses = {entry["key"]: entry["value"] for entry in content["extrinsics"]}
    seen = []
    for entry in content["views"]:
        view = entry["value"]["ptr_wrapper"]["data"]
        own = exports.calibration("square")["cameras"][view["id_intrinsic"]]
        assert (view["width"], view["height"]) == (own["width_px"], own["height_px"])
        kind, camera = intrinsics[view["id_intrinsic"]]
        pose = poses[view["id_pose"]]
        x = (exports.points - pose["center"]) @ numpy.array(pose["rotation"]).T
        x, y = x[:, 0] / x[:, 2], x[:, 1] / x[:, 2]
        k1, k2, k3, t1, t2 = {"pinhole": lambda: [0] * 5, "pinhole_radial_k3": lambda: camera["disto_k3"] + [0, 0],
                              "pinhole_brown_t2": lambda: camera["disto_t2"]}[kind]()
        d, rr = radial(x, y, k1, k2, k3), x * x + y * y
        xd = x * d + t2 * (rr + 2 * x * x) + 2 * t1 * x * y
        yd = y * d + t1 * (rr + 2 * y * y) + 2 * t2 * x * y
        seen.append(numpy.array(camera["principal_point"]) + camera["focal_length"] * numpy.c_[xd, yd])
    return seen


def bundler(folder, exports):
    """p = -P / P.z, p' = f r(p) p, from the picture's middle, y up."""
    lines = (folder / "bundle.out").read_text().splitlines()
    assert lines[0] == "# Bundle file v0.3" and lines[1].split()[1] == "0"
    sizes = {camera["id"]: (camera["width_px"], camera["height_px"]) for camera in exports.calibration("radial")["cameras"]}
    seen = []
    for v, name in enumerate((folder / "list.txt").read_text().splitlines()):
        n = numpy.array(" ".join(lines[2 + 5 * v:7 + 5 * v]).split(), float)
        f, k1, k2, r, t = n[0], n[1], n[2], n[3:12].reshape(3, 3), n[12:]
        x = exports.points @ r.T + t
        p = -x[:, :2] / x[:, 2:]
        p = f * radial(p[:, 0], p[:, 1], k1, k2)[:, None] * p
        w, h = sizes[name.split("_")[0]]
        seen.append(numpy.c_[w / 2 + p[:, 0], h / 2 - p[:, 1]] - 0.5)  # from the corner, then this program's pixels
    assert len(seen) == int(lines[1].split()[0])
    return seen


def test(exports):
    for read, example in ((middlebury, "skewed"), (pmvs, "skewed"), (nerfstudio, "no_k3"), (metashape, "bent"),
                          (realitycapture, "square"), (openmvg, "square"), (bundler, "radial")):
        name = read.__name__
        exports.compare(name, read(exports.export(example, name), exports), exports.pixels(example))
    exports.compare("kalibr", kalibr(exports.export("no_k3", "kalibr"), exports), exports.pixels("no_k3")[:3])


if __name__ == "__main__":
    export_reading.run(test)
