#!/usr/bin/env python3
"""rigcal capture with a robot arm: this program plays the arm's, with the cameras of the simulated studio.
arm_capture.py --rigcal BIN"""
import argparse
import json
import os
import pathlib
import pty
import re
import socket
import subprocess
import sys
import tempfile
import threading

HANG_S = 300  # far beyond what anything here takes
RIG = """[positioner]
kind = "arm"
carries = "object"
driver = "arm"
address = "{address}"
settle_s = {settle_s}
move_timeout_s = {timeout_s}
[sim]
num_cameras = 2
width_px = 96
height_px = 72
"""
POSES = {"00": "0.5 0 1 1 0 0 0", "01": "0.45 0.1 1 0.6 0 0.8 0", "over-head": "0.5 -0.125 1.25 0 0 0.6 0.8"}


class Capture:
    """A running rigcal capture, its arm's program, and what it says."""

    def __init__(self, bench, out, *words, timeout_s=HANG_S, stdin=subprocess.DEVNULL, address="127.0.0.1:0"):
        rig = bench.root / f"{out}.toml"
        rig.write_text(RIG.format(address=address, timeout_s=timeout_s, settle_s=0))
        self.out = bench.root / out
        self.text, self.socket = "", None
        self.running = subprocess.Popen([bench.rigcal, "capture", "--run-dir", str(bench.root / "run"), "--rig", str(rig),
                                         "--out", str(self.out), *words], stdin=stdin, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, bufsize=1)
        self.watchdog = threading.Timer(HANG_S, self.running.kill)
        self.watchdog.start()

    def read_until(self, pattern):
        for line in self.running.stderr:
            self.text += line
            if found := re.search(pattern, line):
                return found
        return None

    def connect(self):
        """As the arm's program: to the port that the capture says."""
        found = self.read_until(r"waits for its program on 127\.0\.0\.1:(\d+)")
        self.address = ("127.0.0.1", int(found.group(1)))
        self.socket = socket.create_connection(self.address, timeout=HANG_S)
        self.lines = self.socket.makefile("r", newline="\n")
        return self

    def say(self, line):
        self.socket.sendall(line.encode() + b"\n")

    def hear(self):
        return self.lines.readline().rstrip("\n")

    def go(self, name, pose=None):
        self.say(f"pose {name} {pose or POSES[name]}")
        return self.hear()

    def leave(self):
        self.lines.close()
        self.socket.close()

    def finish(self):
        self.text += self.running.stderr.read() + self.running.stdout.read()  # the watchdog ends both
        status = self.running.wait()
        self.watchdog.cancel()
        return status

    def recording(self):
        return json.loads((self.out / "recording.json").read_text())


class Bench:
    def __init__(self, rigcal, root):
        self.rigcal, self.root, self.failures = rigcal, root, 0

    def check(self, name, good, what=""):
        self.failures += not good
        print(f"{'ok  ' if good else 'FAIL'} {name} {what}", flush=True)

    def whole(self, folder):
        return subprocess.run([self.rigcal, "recording", "check", str(folder)], capture_output=True, text=True,
                              timeout=HANG_S).returncode == 0


def recorded_pose(stop, kind):
    pose = stop[f"base_from_flange_{kind}"]
    return pose["translation_m"] + [pose["rotation"][part] for part in "wxyz"]


def same_poses(recording):
    for stop in recording["stops"]:
        sent = [float(word) for word in POSES[stop["id"]].split()]
        for kind in ("commanded", "reported"):
            if max(abs(a - b) for a, b in zip(recorded_pose(stop, kind), sent)) > 1e-12:
                return False
    return True


def a_whole_recording(bench):
    capture = Capture(bench, "first").connect()
    answers = [capture.go(name) for name in POSES]
    bench.check("every pose is answered", answers == [f"done {name}" for name in POSES], answers)
    capture.say("end")
    status = capture.finish()
    bench.check("captured", status == 0 and bench.whole(capture.out), capture.text)
    recording = capture.recording()
    bench.check("its stops", [stop["id"] for stop in recording["stops"]] == list(POSES) and same_poses(recording))
    views = [(view["file"], view["stop"]) for view in recording["views"]]
    bench.check("its views", views == [(f"cam{c}_{name}.png", name) for name in POSES for c in range(2)], views)


def the_end_by_closing(bench):
    capture = Capture(bench, "closed").connect()
    capture.go("00")
    capture.leave()
    status = capture.finish()
    bench.check("the end by closing", status == 0 and bench.whole(capture.out), capture.text)


def a_scanner_before_and_a_second_program(bench):
    capture = Capture(bench, "visited").connect()
    with socket.create_connection(capture.address, timeout=HANG_S) as scanner:
        scanner.sendall(b"GET / HTTP/1.0\r\n\r\n")
        heard = scanner.makefile().readline()
        bench.check("a scanner is told what is expected", heard.startswith("error - 'GET / HTTP/1.0' is neither"), heard)
    capture.go("00")
    with socket.create_connection(capture.address, timeout=HANG_S) as second:
        second.sendall(b"pose 01 0 0 0 1 0 0 0\n")
        heard = second.makefile().read()
        bench.check("a second program is refused", heard == "error - another program moves the arm already, this "
                    "connection is closed\n", heard)
    bench.check("and the first goes on", capture.go("01") == "done 01")
    capture.say("end")
    bench.check("to its end", capture.finish() == 0 and bench.whole(capture.out), capture.text)


def an_interrupted_one_is_resumed(bench):
    capture = Capture(bench, "resumed").connect()
    capture.go("00")
    refused = capture.go("01", "0 0 0 1 0 0 0.1")
    bench.check("a bad pose is refused", refused.startswith("error 01 the quaternion of pose '01' has the length"), refused)
    status = capture.finish()
    kept = "after stop '00': the quaternion" in capture.text and "2 views are kept" in capture.text
    bench.check("and what was taken is kept", status == 2 and kept and not capture.recording()["closed"], capture.text)
    before = (capture.out / "cam0_00.png").read_bytes()
    again = Capture(bench, "resumed", "--resume").connect()
    answers = [again.go(name) for name in POSES]
    again.say("end")
    good = again.finish() == 0 and bench.whole(again.out) and answers == [f"done {name}" for name in POSES]
    bench.check("resumed by the same program", good and (again.out / "cam0_00.png").read_bytes() == before, again.text)


def a_program_that_disappears(bench):
    capture = Capture(bench, "lost").connect()
    capture.go("00")
    capture.socket.sendall(b"pose 01 0.5")
    capture.leave()
    status = capture.finish()
    named = "after stop '00', in the middle of a line" in capture.text
    bench.check("a program that disappears", status == 2 and named and len(capture.recording()["views"]) == 2, capture.text)


def a_program_that_says_nothing(bench):
    capture = Capture(bench, "silent", timeout_s=5).connect()
    status = capture.finish()
    heard = capture.hear()
    bench.check("a silent program", status == 2 and "no program has sent a pose" in capture.text and heard == "",
                capture.text + heard)


def poses_from_a_file(bench):
    (bench.root / "poses.txt").write_text("# the ring\n" + "".join(f"{name} {POSES[name]}\n" for name in POSES))
    capture = Capture(bench, "listed", address="poses.txt")
    status = capture.finish()
    good = status == 0 and bench.whole(capture.out) and [stop["id"] for stop in capture.recording()["stops"]] == list(POSES)
    bench.check("poses from a file", good and same_poses(capture.recording()), capture.text)


def an_arm_moved_by_hand(bench):
    """At a terminal the operator says that the arm is there."""
    operator, terminal = pty.openpty()
    capture = Capture(bench, "by_hand", stdin=terminal, address="poses.txt")
    os.close(terminal)
    asked = []
    while found := capture.read_until(r"bring it to stop '(\S+)' \((\d) of 3\), then press Enter"):
        asked.append(found.group(1))
        os.write(operator, b"\n")
    status = capture.finish()
    bench.check("an arm moved by hand", status == 0 and asked == list(POSES) and bench.whole(capture.out), capture.text)
    os.close(operator)


def a_replay(bench):
    out = bench.root / "replayed"
    done = subprocess.run([bench.rigcal, "capture", "--replay", str(bench.root / "first"), "--out", str(out)],
                          capture_output=True, text=True, timeout=HANG_S)
    same = done.returncode == 0 and all((out / path.name).read_bytes() == path.read_bytes()
                                        for path in (bench.root / "first").iterdir())
    bench.check("a replay is the same recording", same, done.stderr)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rigcal_arm_") as root:
        bench = Bench(os.path.abspath(args.rigcal), pathlib.Path(root))
        for part in (a_whole_recording, the_end_by_closing, a_scanner_before_and_a_second_program,
                     an_interrupted_one_is_resumed, a_program_that_disappears, a_program_that_says_nothing,
                     poses_from_a_file, an_arm_moved_by_hand, a_replay):
            part(bench)
    return 1 if bench.failures else 0


if __name__ == "__main__":
    sys.exit(main())
