#!/usr/bin/env python3
"""`rigcal sim render` of a chart, as a user meets it: the recording is whole, options given as nothing change no byte, and what
cannot be is refused. sim_chart.py --rigcal BIN"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

BOARD = 'family = "tag36h11"\ncolumns = 4\nrows = 3\ntag_m = 0.036\ngap_m = 0.011\nthickness_m = 0.005\n'
SMALL = ["--cameras", "2", "--stops", "2", "--width", "160", "--height", "120"]
# options -> words of the sentence that refuses them
REFUSED = [
    (["--wobble-deg", "6"], ["wobble-deg is 6", "0 .. 5"]),
    (["--run-out-mm", "-1"], ["run-out-mm is -1", "0 .. 10"]),
    (["--bump", "2:1"], ["bump's camera is 2", "0 .. 1"]),
    (["--bump", "cam1:nan"], ["bump's angle", "-20 .. 20"]),
    (["--bump", "1"], ["--bump is '1'", "1:0.5"]),
    (["--slip", "0:200"], ["slip's angle", "-180 .. 180"]),
    (["--slip", "x:1"], ["--slip is 'x:1'"]),
    (["--chart", "missing.toml"], ["missing.toml"]),
    (["--chart", "BOARD", "--bow-mm", "11"], ["bow-mm is 11", "-10 .. 10"]),
    (["--chart", "BOARD", "--bow-mm", "1,2,3"], ["--bow-mm has 3 values"]),
    (["--chart", "BOARD", "--hand-held", "201"], ["hand-held is 201", "0 .. 200"]),
    (["--chart", "BOARD", "--board-tilt-deg", "90"], ["board-tilt-deg is 90", "-60 .. 60"]),
    (["--hand-held", "3"], ["--hand-held", "--chart"]),
]


def bytes_of(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    rigcal = parser.parse_args().rigcal
    failures = []

    def check(name, good, what=""):
        if not good:
            failures.append(name)
        print(f"{'ok  ' if good else 'FAIL'} {name} {what}", flush=True)

    def run(*words):
        return subprocess.run([rigcal, *map(str, words)], capture_output=True, text=True, timeout=300)

    with tempfile.TemporaryDirectory() as name:
        root = pathlib.Path(name)
        board = root / "board.toml"
        board.write_text(BOARD)
        chart = root / "chart"
        done = run("sim", "render", *SMALL, "--chart", board, "--hand-held", "2", "--wobble-deg", "0.04", "--recording", "--out", chart)
        check("render", done.returncode == 0 and "8 pictures" in done.stdout, done.stderr.strip() or done.stdout.strip())
        done = run("recording", "check", chart)
        check("recording check", done.returncode == 0, done.stdout.strip())
        views = json.loads((chart / "recording.json").read_text())["views"]
        held = [view["file"] for view in views if "stop" not in view]
        check("held", held == [f"cam{c}_hand{i:02}.png" for c in range(2) for i in range(2)], held)
        check("subject", all(view["subject"] == "chart" for view in views))
        rig = (chart / "rig.toml").read_text()
        check("rig", "wobble_sigma_deg = 0.04\n" in rig and "step_sigma_deg = 0.0286" in rig, repr(rig))

        plain = ["sim", "render", *SMALL, "--step-error-deg", "0.1", "--recording"]
        run(*plain, "--out", root / "plain")
        run(*plain, "--wobble-deg", "0", "--run-out-mm", "0", "--threads", "2", "--out", root / "zero")
        check("unused options", len(bytes_of(root / "plain")) > 8 and bytes_of(root / "plain") == bytes_of(root / "zero"))

        for options, words in REFUSED:
            given = [board if word == "BOARD" else word for word in options]
            done = run("sim", "render", *SMALL, *given, "--out", root / "refused")
            said = all(word in done.stderr for word in words)
            check(" ".join(options), done.returncode == 2 and said and not (root / "refused").exists(), done.stderr.strip())
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
