#!/usr/bin/env python3
"""rigcal devices, and rigcal capture with real drivers, against `rigcal sim serve`: GigE Vision cameras with a GRBL and
with a LinuxCNC table.  served_studio.py --rigcal BIN"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading

import cv2

HANG_S = 300  # far beyond what anything here takes
STOPS = 3
RIG = """[positioner]
kind = "turntable"
driver = "{driver}"
address = "{address}"
settle_s = 0
[[positioner.axis]]
letter = "{letter}"
[stops]
angles_deg = [0, 120, 240]
[[camera]]
id = "cam0"
driver = "genicam"
{camera}
[capture]
max_saturated = 1
min_brightness = 0
min_sharpness = 0
"""


class Studio:
    """A running `rigcal sim serve`, and what it says of its devices."""

    def __init__(self, bench, motion):
        self.serving = subprocess.Popen([bench.rigcal, "sim", "serve", "--recording", str(bench.rendered), "--motion", motion],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.watchdog = threading.Timer(HANG_S, self.serving.kill)
        self.watchdog.start()
        said = ""
        for line in self.serving.stdout:
            said += line
            if line.startswith("table:"):
                break
        self.camera, self.serial = re.search(r"GigE Vision at (\S+), serial (\S+)", said).groups()
        self.address = re.search(r"table: \S+ at ([^,]+),", said).group(1)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.serving.terminate()
        self.serving.wait()
        self.watchdog.cancel()


class Bench:
    def __init__(self, rigcal, root):
        self.rigcal, self.root, self.failures = rigcal, root, 0
        self.rendered = root / "rendered"
        subprocess.run([rigcal, "sim", "render", "--cameras", "1", "--stops", str(STOPS), "--width", "96", "--height", "72",
                        "--recording", "--out", str(self.rendered)], check=True, capture_output=True, timeout=HANG_S)

    def check(self, name, good, what=""):
        self.failures += not good
        print(f"{'ok  ' if good else 'FAIL'} {name} {what}", flush=True)

    def run(self, *words):
        return subprocess.run([self.rigcal, *map(str, words)], capture_output=True, text=True, timeout=HANG_S)

    def rig(self, name, motion, address, camera):
        path = self.root / f"{name}.toml"
        path.write_text(RIG.format(driver=motion, address=address, camera=camera, letter="X" if motion == "grbl" else "C"))
        return path


def picture_at(folder, stop):
    recording = json.loads((folder / "recording.json").read_text())
    view = next(view for view in recording["views"] if view["stop"] == recording["stops"][stop]["id"])
    return cv2.imread(str(folder / view["file"]), cv2.IMREAD_UNCHANGED)


def devices_found(bench, studio, motion):
    rig = bench.rig(f"{motion}_devices", motion, studio.address, f'address = "{studio.camera}"')
    done = bench.run("devices", "--rig", rig, "--json")
    report = json.loads(done.stdout)
    rows = {(row["driver"], row["address"]): row for row in report["devices"]}
    table = rows.get((motion, studio.address), {})
    bench.check(f"{motion}: its table is found", done.returncode == 0 and not report["missing"] and
                table.get("state") == ("alarm" if motion == "grbl" else "power off"), done.stdout + done.stderr)
    cameras = [row for row in report["devices"] if row["address"] == studio.camera]
    bench.check(f"{motion}: its camera is found", len(cameras) == 1 and cameras[0]["serial"] == studio.serial, report["devices"])
    text = bench.run("devices", "--rig", rig)
    row = re.search(rf"^positioner  {motion} +{re.escape(studio.address)} ", text.stdout, re.M)
    bench.check(f"{motion}: and in the table of all", text.returncode == 0 and row, text.stdout + text.stderr)
    other = bench.run("devices", "--rig", bench.rig("other", motion, studio.address, 'serial = "NOT-THERE"'))
    said = re.search(rf"^missing: camera 'cam0': no camera with the serial number NOT-THERE is found; found: .*"
                     rf"{re.escape(studio.serial)}", other.stdout, re.M)
    bench.check(f"{motion}: a missing camera is named", other.returncode == 3 and said, other.stdout + other.stderr)


def captured(bench, studio, motion):
    out = bench.root / f"{motion}_captured"
    rig = bench.rig(motion, motion, studio.address, f'address = "{studio.camera}"')
    done = bench.run("capture", "--run-dir", bench.root / "run", "--rig", rig, "--out", out)
    bench.check(f"{motion}: captured", done.returncode == 0, done.stdout + done.stderr)
    if done.returncode != 0:
        return
    same = [(picture_at(out, stop) == picture_at(bench.rendered, stop)).all() for stop in range(STOPS)]
    bench.check(f"{motion}: the pictures of the stops", all(same), same)
    axes = [stop["axes"][0] for stop in json.loads((out / "recording.json").read_text())["stops"]]
    far = max(abs(axis["commanded_rad"] - axis["reported_rad"]) for axis in axes)
    bench.check(f"{motion}: the reported angles", far < 1e-3 and len({axis["commanded_rad"] for axis in axes}) == STOPS, axes)
    again = bench.run("devices", "--rig", rig, "--json")
    state = [row["state"] for row in json.loads(again.stdout)["devices"] if row["address"] == studio.address]
    bench.check(f"{motion}: at rest and free afterwards", state == ["idle"], again.stdout)


def nothing_there(bench, motion, address):
    done = bench.run("devices", "--rig", bench.rig("gone", motion, address, 'serial = "NOT-THERE"'))
    bench.check(f"{motion}: a table that is gone is missing", done.returncode == 3 and
                f"missing: positioner: no {motion} is found at {address}" in done.stdout, done.stdout + done.stderr)


def bad_rig(bench):
    done = bench.run("devices", "--rig", bench.root / "none.toml")
    bench.check("a rig file that is not there", done.returncode == 2 and "none.toml" in done.stderr, done.stderr)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rigcal_served_") as root:
        bench = Bench(os.path.abspath(args.rigcal), pathlib.Path(root))
        for motion in ("grbl", "linuxcnc"):
            with Studio(bench, motion) as studio:
                devices_found(bench, studio, motion)
                captured(bench, studio, motion)
            nothing_there(bench, motion, studio.address)
        bad_rig(bench)
    return 1 if bench.failures else 0


if __name__ == "__main__":
    sys.exit(main())
