#!/usr/bin/env python3
"""A whole recording from GigE Vision cameras on loopback: what arrives, at what speed, and what becomes of it when packets are lost or
a camera goes away. The studio is rendered once, `rigcal sim serve` plays its cameras and a GRBL table, `rigcal capture` takes it.

gige_studio.py --rigcal BIN --out DIR [--width 4000] [--height 3000] [--cameras 3] [--stops 12] [--only NAME,...]
"""
import argparse
import json
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time

import cv2

HANG_S = 1800  # far beyond what anything here takes
GONE_S = 3
REPORTED_S = 15  # a camera that stays away is reported within that, from its last picture
RIG = """[positioner]
kind = "turntable"
driver = "grbl"
address = "{table}"
settle_s = 0.2
[stops]
count = {stops}
[capture]
retakes = {retakes}
"""
CAMERA = """[[camera]]
id = "{id}"
driver = "genicam"
serial = "{serial}"
address = "{address}"
packet_bytes = {packet_bytes}
exposure_us = 5000
"""


class Studio:
    """A running `rigcal sim serve`."""

    def __init__(self, args, folder, *words):
        self.running = subprocess.Popen([args.rigcal, "sim", "serve", "--recording", str(folder), *words], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.cameras, self.table = [], None
        while self.table is None:
            line = self.running.stdout.readline()
            if not line:
                sys.exit("sim serve ended before it served")
            camera = re.match(r"camera (\S+): GigE Vision at (\S+), serial (\S+)", line)
            if camera:
                self.cameras.append(camera.groups())
            if line.startswith("table: "):
                self.table = line.split()[3].rstrip(",")

    def tell(self, line):
        self.running.stdin.write(line + "\n")
        self.running.stdin.flush()

    def end(self):
        self.running.send_signal(signal.SIGINT)
        said, _ = self.running.communicate(timeout=HANG_S)
        return [line for line in said.splitlines() if line.startswith("camera ")]


def capture(args, studio, out, packet_bytes=8000, retakes=2, meanwhile=None):
    rig = pathlib.Path(f"{out}.toml")
    text = RIG.format(table=studio.table, stops=args.stops, retakes=retakes)
    for name, address, serial in studio.cameras:
        text += CAMERA.format(id=name, serial=serial, address=address, packet_bytes=packet_bytes)
    rig.write_text(text)
    command = [args.rigcal, "capture", "--run-dir", str(out.parent / "run"), "--rig", str(rig), "--out", str(out)]
    if meanwhile:
        watcher = threading.Thread(target=meanwhile, daemon=True)
        watcher.start()
    done = subprocess.run(command, capture_output=True, text=True, timeout=HANG_S)
    return done.returncode, done.stdout + done.stderr


def pictures(folder):
    recording = json.loads((folder / "recording.json").read_text())
    return recording, {(view["camera"], view.get("stop")): view["file"] for view in recording["views"]}


def same(served, taken):
    """Of how many pictures; those that are not what was rendered."""
    _, rendered = pictures(served)
    recording, got = pictures(taken)
    wrong = []
    for key, name in got.items():
        a = cv2.imread(str(served / rendered[key]), cv2.IMREAD_UNCHANGED)
        b = cv2.imread(str(taken / name), cv2.IMREAD_UNCHANGED)
        if a is None or b is None or a.shape != b.shape or (a != b).any():
            wrong.append(name)
    return recording, len(got), wrong


def last_line(text):
    return text.strip().splitlines()[-1] if text.strip() else ""


class Trials:
    def __init__(self, args):
        self.args, self.out, self.failed = args, pathlib.Path(args.out), 0
        self.out.mkdir(parents=True, exist_ok=True)
        self.served = self.out / "rendered"
        self.whole = args.cameras * args.stops

    def check(self, name, good, text):
        self.failed += not good
        print(f"{name}: {'as it should' if good else 'WRONG'}: {text}", flush=True)

    def render(self):
        if (self.served / "recording.json").exists():
            return
        subprocess.run([self.args.rigcal, "sim", "render", "--recording", "--linear", "--background", "backdrop", "--cameras",
                        str(self.args.cameras), "--stops", str(self.args.stops), "--width", str(self.args.width), "--height",
                        str(self.args.height), "--samples", "1", "--out", str(self.served)], check=True)

    def whole_recording(self, name, words, **how):
        studio = Studio(self.args, self.served, *words)
        status, said = capture(self.args, studio, self.out / name, **how)
        told = studio.end()
        recording, count, wrong = same(self.served, self.out / name)
        good = status == 0 and recording["closed"] and count == self.whole and not wrong
        self.check(name, good, f"{count} pictures, {len(wrong)} not as rendered; {last_line(said)}")
        print("   " + "\n   ".join(told), flush=True)
        return said

    def plain(self):
        self.whole_recording("plain", [])

    def loss_1500(self):
        self.whole_recording("loss_1500", ["--loss", "0.01"], packet_bytes=1500)

    def loss_8000(self):
        self.whole_recording("loss_8000", ["--loss", "0.001"])

    def no_resend(self):
        said = self.whole_recording("no_resend", ["--loss", "0.0003", "--no-resend"], retakes=30)
        retaken = re.search(r"(\d+) retaken", said)
        self.check("no_resend, retaken", retaken and int(retaken[1]) > 0, retaken[0] if retaken else said)

    def once_half_is_taken(self, name, action):
        """Does it in the middle of the capture."""
        end = time.monotonic() + HANG_S
        while len(list((self.out / name).glob("*.png"))) < self.whole // 2 and time.monotonic() < end:
            time.sleep(0.05)
        action()

    def back(self):
        studio = Studio(self.args, self.served)

        def meanwhile():
            studio.tell(f"kill {studio.cameras[1][0]}")
            time.sleep(GONE_S)
            studio.tell(f"revive {studio.cameras[1][0]}")

        status, said = capture(self.args, studio, self.out / "back", meanwhile=lambda: self.once_half_is_taken("back", meanwhile))
        studio.end()
        recording, count, wrong = same(self.served, self.out / "back")
        good = status == 0 and recording["closed"] and count == self.whole and not wrong and "0 cameras brought back" not in said
        self.check("back", good, f"{count} pictures, {len(wrong)} not as rendered; {last_line(said)}")

    def gone(self):
        studio = Studio(self.args, self.served)
        killed = []

        def meanwhile():
            studio.tell(f"kill {studio.cameras[1][0]}")
            killed.append(time.monotonic())

        status, said = capture(self.args, studio, self.out / "gone", meanwhile=lambda: self.once_half_is_taken("gone", meanwhile))
        seconds = time.monotonic() - killed[0] if killed else HANG_S
        studio.end()
        recording, count, wrong = same(self.served, self.out / "gone")
        good = (status != 0 and not recording["closed"] and self.whole // 2 <= count < self.whole and not wrong
                and seconds < REPORTED_S and studio.cameras[1][0] in said)
        self.check("gone", good, f"after {seconds:.1f} s, {count} pictures kept, {len(wrong)} not as rendered; {said.strip()}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--width", type=int, default=4000)
    parser.add_argument("--height", type=int, default=3000)
    parser.add_argument("--cameras", type=int, default=3)
    parser.add_argument("--stops", type=int, default=12)
    parser.add_argument("--only", default="plain,loss_1500,loss_8000,no_resend,back,gone")
    trials = Trials(parser.parse_args())
    trials.render()
    for name in trials.args.only.split(","):
        getattr(trials, name)()
    return 1 if trials.failed else 0


if __name__ == "__main__":
    sys.exit(main())
