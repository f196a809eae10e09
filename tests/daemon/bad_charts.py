#!/usr/bin/env python3
"""Bad charts, as an operator meets them: `rigcal seed` on recordings that are spoilt, one way each. Status 2 and one sentence that
names what is wrong and where, nothing written. bad_charts.py --rigcal BIN"""
import argparse
import hashlib
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import cv2
import numpy


class Case:
    """A copy of the recording that a test may spoil."""

    def __init__(self, rigcal, source, board, folder):
        self.rigcal, self.folder, self.out = rigcal, folder, folder.parent / (folder.name + "-out")
        shutil.copytree(source, folder)
        self.list = folder / "recording.json"
        self.board = folder.parent / (folder.name + ".toml")
        shutil.copy(board, self.board)

    def pictures(self):
        return [self.folder / view["file"] for view in json.loads(self.list.read_text())["views"]]

    def spoil(self, change):
        """Changes every picture; the list of the recording is made to fit."""
        recording = json.loads(self.list.read_text())
        for view in recording["views"]:
            path = self.folder / view["file"]
            cv2.imwrite(str(path), change(cv2.imread(str(path), cv2.IMREAD_UNCHANGED)))
            view["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
        self.list.write_text(json.dumps(recording))

    def edit_list(self, edit):
        recording = json.loads(self.list.read_text())
        edit(recording)
        self.list.write_text(json.dumps(recording))

    def edit_board(self, before, after):
        text = self.board.read_text()
        assert before in text
        self.board.write_text(text.replace(before, after))

    def seed(self):
        return subprocess.run([self.rigcal, "seed", "--recording", str(self.folder), "--chart", str(self.board), "--out",
                               str(self.out)], capture_output=True, text=True, timeout=300)


def blurred(case):
    case.spoil(lambda picture: cv2.GaussianBlur(picture, (0, 0), 8))
    return ["is blurred"]


def over_exposed(case):
    case.spoil(lambda picture: cv2.convertScaleAbs(picture, alpha=12))
    return ["over-exposed"]


def in_a_mirror(case):
    case.spoil(lambda picture: picture[:, ::-1])
    return ["mirrored"]


def two_boards_with_the_same_ids(case):
    def twice(picture):
        half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        return numpy.vstack([numpy.hstack([half, half]), numpy.zeros_like(numpy.hstack([half, half]))])
    case.spoil(twice)
    return ["are there twice"]


def wrong_tag_size(case):
    case.edit_board("gap_m = 0.011", "gap_m = 0.02")
    return ["gap between tags", "0.556"]


def ratio_for_a_length(case):
    case.edit_board("gap_m = 0.011", "gap_m = 0.3")
    return ["line", "ratio"]


def foreign_ids(case):
    case.edit_board("first_id = 0", "first_id = 100")
    return ["not on the board", "100 to 111"]


def unknown_key(case):
    case.edit_board("columns = ", "colums = ")
    return ["line", "colums", "known are family"]


def empty(case):
    case.edit_list(lambda recording: recording.update(views=[]))
    return ["none of its 0 pictures"]


def truncated_list(case):
    case.list.write_bytes(case.list.read_bytes()[: case.list.stat().st_size // 2])
    return ["recording.json", "line"]


def changed_picture(case):
    first, second = case.pictures()[:2]
    first.write_bytes(second.read_bytes())
    return [first.name, "SHA-256"]


def missing_picture(case):
    case.pictures()[0].unlink()
    return [case.pictures()[0].name]


CASES = [blurred, over_exposed, in_a_mirror, two_boards_with_the_same_ids, wrong_tag_size, ratio_for_a_length, foreign_ids, unknown_key,
         empty, truncated_list, changed_picture, missing_picture]


def judge(name, done, words, out):
    sentence = done.stderr.strip()
    complaints = [f"does not name '{word}'" for word in words if word not in sentence]
    if done.returncode != 2:
        complaints.append(f"status {done.returncode} instead of 2")
    if "\n" in sentence or not sentence.startswith("rigcal seed: "):
        complaints.append("not one sentence")
    if out.exists() and any(out.iterdir()):
        complaints.append(f"left {[p.name for p in out.iterdir()]} behind")
    print(f"{'FAIL' if complaints else 'ok  '} {name}: {sentence}" + (f"   ({'; '.join(complaints)})" if complaints else ""), flush=True)
    return not complaints


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--rigcal", required=True)
    rigcal = parser.parse_args().rigcal
    with tempfile.TemporaryDirectory(prefix="rigcal-bad-charts-") as name:
        root = pathlib.Path(name)
        subprocess.run([rigcal, "chart", "print", "--columns", "4", "--rows", "3", "--tag-mm", "36", "--gap-mm", "11", "--out",
                        str(root / "board.pdf")], check=True, capture_output=True)
        subprocess.run([rigcal, "sim", "render", "--chart", str(root / "board.toml"), "--cameras", "1", "--stops", "3", "--hand-held", "5",
                        "--width", "640", "--height", "480", "--recording", "--out", str(root / "set")], check=True, capture_output=True)
        good = True
        for number, spoil in enumerate(CASES):  # folders have numbers: a message must not find its word in a path
            case = Case(rigcal, root / "set", root / "board.toml", root / f"case{number}")
            words = spoil(case)
            good &= judge(spoil.__name__, case.seed(), words, case.out)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
