#!/usr/bin/env python3
"""Rig files and old recordings, as a user meets them: `rig check`, `rig keys`, `recording prune`. rig_file.py --rigcal BIN"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

from store_cli import sha256, write_result

RIG = """[positioner]
kind = "turntable"
[stops]
count = 12
[chart]
board = "board.toml"
[keep]
max_count = 1
"""
BOARD = 'family = "tag36h11"\ncolumns = 4\nrows = 3\ntag_m = 0.02\ngap_m = 0.005\n'


def run(rigcal, *arguments):
    done = subprocess.run([rigcal, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout, done.stderr


def expect(what, outcome, status, *parts):
    """0 when the command ended with this status and said all parts."""
    said = outcome[1] + outcome[2]
    missing = [part for part in parts if part not in said]
    if outcome[0] == status and not missing:
        return 0
    print(f"{what}: status {outcome[0]} (expected {status}), not said: {missing}\n{said}")
    return 1


def check_rig_file(rigcal, folder):
    rig = folder / "rig.toml"
    rig.write_text(RIG)
    wrong = expect("no board", run(rigcal, "rig", "check", rig), 2, "board.toml: there is no such file")
    (folder / "board.toml").write_text(BOARD)
    wrong += expect("whole", run(rigcal, "rig", "check", rig), 0, "positioner: turntable", "stops: 12", "at most 1")
    (folder / "board.toml").write_text(BOARD.replace("0.02", "20"))
    wrong += expect("bad board", run(rigcal, "rig", "check", rig), 2, "board.toml line 4: tag_m = 20")
    bad = folder / "bad.toml"
    bad.write_text(RIG.replace("count = 12", "counts = 12"))
    outcome = run(rigcal, "rig", "check", bad)
    wrong += expect("unknown key", outcome, 2, "rigcal rig check: ", "bad.toml line 4: counts: unknown in [stops]")
    wrong += 0 if len(outcome[2].splitlines()) == 1 else expect("one sentence", outcome, None)
    wrong += expect("no file", run(rigcal, "rig", "check", folder / "none.toml"), 2, "none.toml: there is no such file")
    keys = pathlib.Path(__file__).resolve().parents[2] / "docs" / "rig_keys.md"
    return wrong + expect("keys", run(rigcal, "rig", "keys"), 0, keys.read_text())


def record(folder, day):
    folder.mkdir(parents=True)
    (folder / "00.png").write_bytes(b"x" * 1000)
    (folder / "recording.json").write_text(json.dumps({
        "format": "rigcal recording", "version": 1, "id": folder.name, "closed": True, "linear": False,
        "cameras": [{"id": "left", "width_px": 8, "height_px": 6}], "stops": [],
        "views": [{"file": "00.png", "camera": "left", "subject": "object", "sha256": "a" * 64,
                   "taken_at": f"2025-01-{day:02}T12:00:00Z"}]}))


def check_prune(rigcal, folder):
    rig, recordings = folder / "rig.toml", folder / "recordings"
    for day, name in enumerate(("used", "first", "second", "third"), 1):
        record(recordings / name, day)
    listed = {"file": "recording.json", "sha256": sha256(recordings / "used/recording.json")}
    made = run(rigcal, "store", "add", write_result(folder / "result", "accepted", inputs=[listed]), "--rig", "studio",
               "--state", folder / "state")
    wrong = expect("a revision of the oldest", made, 0, "revision 1")
    prune = ["recording", "prune", "--rig", rig, "--recordings", recordings, "--keep", "first,other", "--state", folder / "state"]
    wrong += expect("dry run", run(rigcal, *prune, "--dry-run"), 0, "would go: ", "second: the oldest of 4 recordings",
                    "used: the oldest of 4 recordings (limit 1), stays because a revision was made from it",
                    "'other'", "2 would go, 2 left")
    wrong += expect("dry run twice", run(rigcal, *prune, "--dry-run"), 0, "2 would go, 2 left")
    wrong += expect("no store", run(rigcal, *prune[:-1], folder / "none"), 2, "there is no calibration store")
    (folder / "torn").mkdir()
    (folder / "torn/calibrations.sqlite").write_text("this is no database, it is much rather a letter to a friend")
    wrong += expect("a store that cannot be read", run(rigcal, *prune[:-1], folder / "torn"), 2, "torn")
    wrong += expect("prune", run(rigcal, *prune), 0, "gone: ", "2 gone, 2 left")
    left = sorted(path.name for path in recordings.iterdir())
    if left != ["first", "used"]:
        print(f"left: {left}")
        wrong += 1
    return wrong + expect("no folder", run(rigcal, "recording", "prune", "--rig", rig, "--recordings", folder / "none",
                                           "--state", folder / "state"), 2, "none: cannot be read as a folder")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    rigcal = parser.parse_args().rigcal
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        wrong = check_rig_file(rigcal, folder) + check_prune(rigcal, folder)
    print(f"{wrong} failures")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
