#!/usr/bin/env python3
"""rigcal capture through the program, with the simulated studio and with recordings as devices. capture.py --rigcal BIN"""
import argparse
import fcntl
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HANG_S = 300  # far beyond what anything here takes
RIG = """[positioner]
kind = "turntable"
driver = "sim"
settle_s = 0
[[positioner.axis]]
speed_deg_s = {speed}
[stops]
count = 4
[sim]
num_cameras = 2
width_px = 96
height_px = 72
step_error_deg = 0.03
"""


class Bench:
    def __init__(self, rigcal, root):
        self.rigcal, self.root, self.failures = rigcal, root, 0
        self.rig = root / "rig.toml"
        self.rig.write_text(RIG.format(speed=720))
        self.run_dir = root / "run"

    def check(self, name, good, what=""):
        self.failures += not good
        print(f"{'ok  ' if good else 'FAIL'} {name} {what}", flush=True)

    def command(self, *words):
        return [self.rigcal, "capture", "--run-dir", str(self.run_dir), *map(str, words)]

    def capture(self, *words):
        return subprocess.run(self.command(*words), capture_output=True, text=True, timeout=HANG_S)

    def whole(self, folder):
        return subprocess.run([self.rigcal, "recording", "check", str(folder)], capture_output=True, text=True,
                              timeout=HANG_S).returncode == 0


def files(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def listed(folder):
    return json.loads((folder / "recording.json").read_text())


def interrupt(folder, num_views):
    """Makes a whole recording one that was interrupted after some views, with what a killed program leaves."""
    recording = listed(folder)
    for view in recording["views"][num_views:]:
        (folder / view["file"]).unlink()
    stops = {view["stop"] for view in recording["views"][:num_views]}
    recording.update(closed=False, views=recording["views"][:num_views],
                     stops=[stop for stop in recording["stops"] if stop["id"] in stops])
    (folder / "recording.json").write_text(json.dumps(recording))
    (folder / ".recording.json.aB3xY9").write_text("half")


def simulated_studio(bench):
    done = bench.capture("--rig", bench.rig, "--out", bench.root / "first")
    bench.check("sim", done.returncode == 0 and bench.whole(bench.root / "first"), done.stdout + done.stderr)
    recording = listed(bench.root / "first")
    bench.check("all views", len(recording["views"]) == 8 and len(recording["stops"]) == 4 and recording["id"] == "first")
    out = bench.root / "again/first"
    bench.capture("--rig", bench.rig, "--out", out)
    bench.check("same in, same out", files(out) == files(bench.root / "first"))


def replay(bench):
    out = bench.root / "replayed"
    done = bench.capture("--replay", bench.root / "first", "--out", out)
    bench.check("replay", done.returncode == 0 and files(out) == files(bench.root / "first"), done.stderr)


def replay_of_another_order(bench):
    """A rendered set lists its views camera by camera, with other names."""
    rendered, out = bench.root / "rendered", bench.root / "rendered_again"
    subprocess.run([bench.rigcal, "sim", "render", "--cameras", "2", "--stops", "3", "--width", "96", "--height", "72",
                    "--recording", "--out", str(rendered)], check=True, capture_output=True, timeout=HANG_S)
    done = bench.capture("--replay", rendered, "--out", out)
    names = ["recording.json"] + [view["file"] for view in listed(rendered)["views"]]
    same = done.returncode == 0 and files(out) == {name: (rendered / name).read_bytes() for name in names}
    bench.check("replay in the recording's own order", same, done.stderr)


def resume(bench):
    out = bench.root / "resumed/first"
    shutil.copytree(bench.root / "first", out)
    closed = bench.capture("--rig", bench.rig, "--out", out, "--resume")
    bench.check("a closed one is not resumed", closed.returncode == 2 and "closed" in closed.stderr, closed.stderr)
    interrupt(out, 3)
    again = bench.capture("--rig", bench.rig, "--out", out)
    bench.check("an interrupted one is not written over", again.returncode == 2 and "3 views are kept" in again.stderr,
                again.stderr)
    done = bench.capture("--rig", bench.rig, "--out", out, "--resume")
    bench.check("resumed as if nothing had happened", done.returncode == 0 and files(out) == files(bench.root / "first"),
                done.stderr)


def replay_of_an_interrupted_one(bench):
    source, out = bench.root / "torn", bench.root / "torn_again"
    shutil.copytree(bench.root / "first", source)
    interrupt(source, 3)
    done = bench.capture("--replay", source, "--out", out)
    named = all(part in done.stderr for part in ("camera 'cam1'", "stop '01'", "3 views are kept"))
    bench.check("its errors are replayed", done.returncode == 2 and named and not listed(out)["closed"], done.stderr)


def chosen_stops(bench):
    out = bench.root / "chosen"
    done = bench.capture("--rig", bench.rig, "--out", out, "--stops", "90,45")
    angles = [round(stop["axes"][0]["commanded_rad"], 6) for stop in listed(out)["stops"]] if done.returncode == 0 else []
    bench.check("--stops", angles == [1.570796, 0.785398], f"{angles} {done.stderr}")


def held_rig(bench):
    lock = next(bench.run_dir.glob("rig-*.lock"))
    with open(lock, "w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        held.write("4711\nrigcald\nrigcal job capture\n")
        held.flush()
        done = bench.capture("--rig", bench.rig, "--out", bench.root / "refused")
    named = all(part in done.stderr for part in ("4711", "rigcald", "rigcal job capture"))
    bench.check("a rig that is held", done.returncode == 2 and named and not (bench.root / "refused").exists(), done.stderr)


def stopped_by_a_signal(bench):
    slow, out = bench.root / "slow.toml", bench.root / "signal/first"
    slow.write_text(RIG.format(speed=0.1))  # the second stop is a quarter of an hour away
    running = subprocess.Popen(bench.command("--rig", slow, "--out", out), stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + HANG_S
    while time.monotonic() < deadline and not ((out / "recording.json").exists() and len(listed(out)["views"]) == 2):
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    _, text = running.communicate(timeout=HANG_S)
    bench.check("stopped", running.returncode == 1 and "2 views are kept" in text and not listed(out)["closed"], text)
    done = bench.capture("--rig", bench.rig, "--out", out, "--resume")
    bench.check("and resumed", done.returncode == 0 and files(out) == files(bench.root / "first"), done.stderr)


def bad_input(bench):
    (bench.root / "none.toml").write_text('[positioner]\nkind = "turntable"\n')
    (bench.root / "by_hand.toml").write_text('[positioner]\nkind = "turntable"\n[stops]\ncount = 4\n[sim]\n')
    (bench.root / "no_stops.toml").write_text('[positioner]\nkind = "turntable"\ndriver = "sim"\n[sim]\n')
    (bench.root / "gantry.toml").write_text('[positioner]\nkind = "gantry"\ncarries = "cameras"\naxes = ["x", "z"]\n'
                                            'driver = "sim"\n[stops]\npositions_m = [[0, 0.1]]\n[sim]\n')
    for name, words, parts in (("stops without a driver", ["--rig", bench.root / "by_hand.toml"], ["by_hand.toml", "4 stops"]),
                               ("no stops", ["--rig", bench.root / "no_stops.toml"], ["no_stops.toml", "[stops]"]),
                               ("stops of two axes", ["--rig", bench.root / "gantry.toml", "--stops", "1,2"], ["2 axes"]),
                               ("no such machine", ["--rig", bench.root / "gantry.toml"], ["turntable with one axis"]),
                               ("no board", ["--rig", bench.rig, "--what", "chart"], ["names no board"]),
                               ("no cameras", ["--rig", bench.root / "none.toml"], ["[[camera]]"]),
                               ("no recording", ["--replay", bench.root / "nowhere"], ["nowhere", "no such file"]),
                               ("neither", [], ["--rig"])):
        done = bench.capture(*words, "--out", bench.root / "bad")
        good = done.returncode == 2 and all(part in done.stderr for part in parts) and not (bench.root / "bad").exists()
        bench.check(name, good, done.stderr)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rigcal_capture_") as root:
        bench = Bench(os.path.abspath(args.rigcal), pathlib.Path(root))
        for part in (simulated_studio, replay, replay_of_another_order, resume, replay_of_an_interrupted_one, chosen_stops,
                     held_rig, stopped_by_a_signal, bad_input):
            part(bench)
    return 1 if bench.failures else 0


if __name__ == "__main__":
    sys.exit(main())
