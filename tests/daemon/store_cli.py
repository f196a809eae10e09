#!/usr/bin/env python3
"""The calibration store from the command line, as a user meets it: add, history, show, publish, rollback, diff, export,
backup, check; and what is refused. store_cli.py --rigcal BIN"""
import argparse
import hashlib
import json
import math
import pathlib
import subprocess
import sys
import tempfile

CAMERA = {"id": "cam0", "physical_id": "cam0", "width_px": 640, "height_px": 480, "fx_px": 1000.0, "fy_px": 1000.0,
          "cx_px": 319.5, "cy_px": 239.5, "skew_px": 0.0, "k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0, "k3": 0.0}


def looking_at_origin(angle, roll):
    """cam_from_world of a camera 2 m away at an angle about z, turned about its own axis by `roll`."""
    import numpy as np
    from scipy.spatial.transform import Rotation
    out = np.array([math.cos(angle), math.sin(angle), 0])
    world_from_cam = np.column_stack([np.cross([0, 0, -1], -out), [0, 0, -1], -out])
    cam_from_world = Rotation.from_rotvec([0, 0, roll]).as_matrix() @ world_from_cam.T
    x, y, z, w = Rotation.from_matrix(cam_from_world).as_quat()
    return {"rotation": {"w": w, "x": x, "y": y, "z": z}, "translation": list(-cam_from_world @ (2 * out))}


def write_result(folder, verdict, roll=0.0, inputs=(), seed=False):
    folder.mkdir()
    views = [{"name": f"{v:02}.png", "camera": f"cam{v % 3}", "cam_from_world": looking_at_origin(0.5 * v, roll if v % 3 == 2 else 0)}
             for v in range(9)]
    calibration = {"format": "rigcal calibration", "version": 1, "frame": "", "unit": "m",
                   "cameras": [dict(CAMERA, id=f"cam{c}", physical_id=f"cam{c}") for c in range(3)], "views": views,
                   "provenance": {"program": "rigcal", "version": "0.1.0", "method": "rigcal", "options": {"rounds": "4"},
                                  "random_seed": 7, "inputs": list(inputs), "notes": []}}
    (folder / "calibration.json").write_text(json.dumps(calibration))
    report = {"format": "rigcal report", "version": 1, "verdict": verdict, "reasons": []}
    if verdict != "accepted":
        report["reasons"] = [{"check": "epipolar", "value": 1.3, "limit": 1.0, "unit": "px", "view": "02.png"}]
    if seed:
        report = {"format": "rigcal seed report", "version": 1, "contradictions": ["stop '03' contradicts the rig"] if verdict != "accepted" else []}
    (folder / "report.json").write_text(json.dumps(report))
    return folder


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


class Session:
    def __init__(self, rigcal, root):
        self.rigcal, self.root, self.failures = rigcal, root, 0

    def run(self, *words, state=None):
        command = [self.rigcal, *map(str, words), "--state", str(state or self.root / "state")]
        return subprocess.run(command, capture_output=True, text=True, timeout=120)

    def check(self, name, holds, told=""):
        print(f"{'ok  ' if holds else 'FAIL'} {name} {told}")
        self.failures += not holds

    def works(self, name, *words, says=(), state=None):
        done = self.run(*words, state=state)
        missing = [word for word in says if word not in done.stdout]
        self.check(name, done.returncode == 0 and not missing, f"{done.stderr.strip()} {missing or ''}")
        return done.stdout

    def refused(self, name, *words, says=(), state=None):
        done = self.run(*words, state=state)
        missing = [word for word in says if word not in done.stderr]
        one_sentence = done.stderr.startswith("rigcal ") and done.stderr.count("\n") == 1
        self.check(name, done.returncode == 2 and one_sentence and not missing, f"{done.returncode} {done.stderr.strip()} {missing or ''}")


def fill(s):
    """Four revisions: accepted, accepted with cam2 turned, rejected, a seed that contradicts itself."""
    recording = s.root / "recording"
    recording.mkdir()
    (recording / "recording.json").write_text(json.dumps(
        {"format": "rigcal recording", "version": 1, "id": "night-7", "closed": True, "linear": False,
         "cameras": [{"id": "cam0", "width_px": 640, "height_px": 480}], "stops": [],
         "views": [{"file": "00.png", "camera": "cam0", "subject": "object", "sha256": "a" * 64}]}))
    first = write_result(s.root / "first", "accepted", inputs=[{"file": "recording.json", "sha256": sha256(recording / "recording.json")}])
    s.works("add", "store", "add", first, "--rig", "studio", "--recording", recording, says=["revision 1 of rig 'studio': accepted"])
    second = write_result(s.root / "second", "accepted", roll=0.01,
                          inputs=[{"file": "calibration.json", "sha256": sha256(first / "calibration.json")}])
    s.works("add turned", "store", "add", second, "--rig", "studio", says=["revision 2"])
    s.works("add rejected", "store", "add", write_result(s.root / "third", "rejected"), "--rig", "studio", says=["3", "rejected"])
    s.works("add seed", "store", "add", write_result(s.root / "fourth", "inconclusive", seed=True), "--rig", "studio",
            says=["4", "inconclusive"])
    s.refused("another recording", "store", "add", second, "--rig", "studio", "--recording", recording, says=["recording.json", "not the recording"])
    s.refused("no result", "store", "add", s.root, "--rig", "studio", says=["calibration.json"])
    s.refused("no rig's name", "store", "add", first, "--rig", "a b", says=["'a b' names no rig"])


def look(s):
    s.works("history", "history", says=["    1  2", "rejected", "epipolar (02.png): 1.3 px against a limit of 1 px"])
    s.works("show", "show", "1", says=["night-7", "rounds=4", "random seed 7", "seed: none"])
    s.works("show the seed", "show", "2", says=["seed: revision 1"])
    s.works("show a contradiction", "show", "4", says=["stop '03' contradicts the rig"])
    shown = json.loads(s.works("show json", "show", "1", "--json"))
    s.check("provenance", shown["provenance"]["random_seed"] == 7 and shown["recording"]["id"] == "night-7")
    s.check("calibration byte for byte", s.works("show calibration", "show", "1", "--calibration") == (s.root / "first/calibration.json").read_text())
    s.refused("no such revision", "show", "9", says=["has no revision 9"])
    s.refused("no number", "show", "latest", says=["'latest' is no revision"])
    s.refused("no such rig", "history", "--rig", "other", says=["no rig 'other'", "studio"])
    s.refused("no store", "history", state=s.root / "nowhere", says=["nowhere/calibrations.sqlite", "no calibration store"])
    s.check("nothing was made", not (s.root / "nowhere").exists())
    diff = json.loads(s.works("diff json", "diff", "1", "2", "--json"))
    largest = max(diff["cameras"], key=lambda camera: camera["moved_px"])
    s.check("the camera that turned", largest["camera"] == "cam2" and largest["moved_px"] > 0.5, str(diff["cameras"]))
    s.works("diff", "diff", "1", "2", says=["revision 1", "cam2", "sigma not stated"])


def publish(s):
    out = s.root / "published"
    target = ["--publish-dir", out, "--format", "colmap", "--format", "opencv"]
    current = lambda: json.loads((out / "current.json").read_text())["revision"]
    s.works("publish", "publish", "1", *target, says=["publish none -> 1 by "])
    s.check("files", current()["number"] == 1 and (out / "colmap/cameras.txt").exists() and (out / "opencv.yml").exists())
    s.refused("not as expected", "publish", "2", "--expected", "none", *target, says=["revision 1 is in force, not none as expected"])
    s.refused("expected is not in force", "publish", "2", "--expected", "2", *target, says=["revision 1 is in force, not 2 as expected"])
    s.refused("in force already", "publish", "1", says=["in force already"])
    s.refused("a format twice", "publish", "2", *target, "--format", "colmap", says=["'colmap' is asked for twice"])
    s.check("nothing moved", current()["number"] == 1 and "*     1" in s.run("history").stdout)
    (out / "opencv.yml").unlink()
    s.works("files again", "publish", "1", *target, says=["in force already", "are written"])
    s.works("files were right", "publish", "1", *target, says=["were right"])
    s.check("the file is back", (out / "opencv.yml").exists())
    s.works("publish again", "publish", "2", "--expected", "1", *target, says=["publish 1 -> 2"])
    s.refused("rejected", "publish", "3", *target, says=["epipolar", "with a reason"])
    s.check("the pointer stayed", current()["number"] == 2)
    s.works("forced", "publish", "3", "--force", "checked by hand", *target, says=["2 -> 3", "checked by hand"])
    s.check("the reason is told", current()["reason"] == "checked by hand" and current()["verdict"] == "rejected")
    s.works("rollback", "rollback", *target, says=["rollback 3 -> 2"])
    s.works("rollback again", "rollback", *target, says=["rollback 2 -> 1"])
    s.check("files rolled back", current()["number"] == 1)
    s.refused("nothing before", "rollback", says=["no earlier publication"])
    s.refused("never in force", "rollback", "4", says=["never in force"])
    s.refused("formats without a folder", "publish", "2", "--format", "colmap", says=["--publish-dir"])
    s.refused("no format", "publish", "2", "--publish-dir", out, "--format", "sketch", says=["'sketch' is no format"])
    s.works("history shows it", "history", says=["*     1", "rollback 3 -> 2"])


def copies(s):
    s.works("export a revision", "export", "2", "--format", "middlebury", "--out", s.root / "two.txt")
    s.works("export a file", "export", s.root / "second/calibration.json", "--format", "middlebury", "--out", s.root / "file.txt")
    s.check("the same", (s.root / "two.txt").read_bytes() == (s.root / "file.txt").read_bytes())
    s.refused("export neither", "export", "missing.json", "--format", "opencv", "--out", s.root / "x", says=["missing.json"])
    backup = s.root / "backup/calibrations.sqlite"
    backup.parent.mkdir()
    s.works("backup", "store", "backup", backup)
    s.refused("backup again", "store", "backup", backup, says=["is there already"])
    s.works("backup is a store", "store", "check", state=backup.parent, says=["nothing is wrong"])
    s.check("with the same history", s.run("history").stdout == s.run("history", state=backup.parent).stdout)
    s.works("check", "store", "check", says=["nothing is wrong"])
    import sqlite3
    spoilt = sqlite3.connect(backup)
    spoilt.executescript("DROP TRIGGER revision_is_not_changed; UPDATE revision SET report = '{}' WHERE number = 2;")
    spoilt.close()
    done = s.run("store", "check", state=backup.parent)
    s.check("check finds damage", done.returncode == 2 and "the report of revision 2 is damaged" in done.stdout and "trigger" in done.stdout)
    (s.root / "state/file").write_text("")
    s.refused("state is a file", "store", "add", s.root / "first", "--rig", "studio", state=s.root / "state/file", says=["state/file"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    with tempfile.TemporaryDirectory(prefix="rigcal-store-") as folder:
        s = Session(parser.parse_args().rigcal, pathlib.Path(folder))
        for part in (fill, look, publish, copies):
            part(s)
    sys.exit(1 if s.failures else 0)


if __name__ == "__main__":
    main()
