#!/usr/bin/env python3
"""Bad input, as a user meets it: each case must end with status 2, one sentence on stderr that names what is wrong, and
nothing written. bad_input.py --rigcal BIN"""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile


class Case:
    """A simulated set of its own that a test may spoil."""

    def __init__(self, rigcal, source, folder):
        self.rigcal = rigcal
        self.folder = folder
        shutil.copytree(source, folder)
        self.par = folder / "truth_par.txt"
        self.masks = "auto"

    def lines(self):
        return self.par.read_text().splitlines()

    def edit_par(self, view, column, value):
        lines = self.lines()
        fields = lines[1 + view].split()
        fields[column] = value
        lines[1 + view] = " ".join(fields)
        self.par.write_text("\n".join(lines) + "\n")

    def image(self, view):
        return self.folder / self.lines()[1 + view].split()[0]

    def refine(self, out=None):
        out = out or self.folder / "out"
        command = [self.rigcal, "refine", "--images", str(self.folder), "--cameras", str(self.par), "--out", str(out),
                   "--masks", self.masks, "--expected-error-px", "4", "--rounds", "1"]
        return subprocess.run(command, capture_output=True, text=True, timeout=120)


def missing_image(case):
    case.image(2).unlink()
    return [case.image(2).name]


def truncated_png(case):
    path = case.image(2)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return [path.name]


def unreadable_image(case):
    case.image(2).write_text("not a picture")
    return [case.image(2).name]


def differing_size(case):
    import cv2
    path = str(case.image(2))
    cv2.imwrite(path, cv2.imread(path)[:-8])
    return [case.image(2).name]


def principal_point_outside(case):
    for view in range(len(case.lines()) - 1):
        case.edit_par(view, 3, "5000")
    return ["5000"]


def too_few_numbers(case):
    lines = case.lines()
    lines[3] = " ".join(lines[3].split()[:-1])
    case.par.write_text("\n".join(lines) + "\n")
    return ["truth_par.txt", "4"]


def not_a_number(case):
    case.edit_par(2, 1, "nan")
    return ["truth_par.txt", "nan"]


def no_rotation(case):
    case.edit_par(2, 10, "3.0")
    return ["truth_par.txt", "rotation"]


def looking_away(case):
    for view in range(len(case.lines()) - 1):
        case.edit_par(view, 21, "-10")
    return ["look away"]


def two_views(case):
    lines = case.lines()[1:3]
    case.par.write_text("\n".join(["2"] + lines) + "\n")
    return ["2", "3"]


def skew(case):
    case.edit_par(1, 2, "0.5")
    return ["truth_par.txt", "0.5", "0.01"]


def no_par_file(case):
    case.par.unlink()
    return ["truth_par.txt"]


def mask_of_wrong_size(case):
    import cv2
    case.masks = str(case.folder / "masks")
    path = case.folder / "masks" / case.image(2).name
    cv2.imwrite(str(path), cv2.imread(str(path))[:-8])
    return [path.name]


CASES = [missing_image, truncated_png, unreadable_image, differing_size, principal_point_outside, too_few_numbers,
         not_a_number, no_rotation, looking_away, two_views, skew, no_par_file, mask_of_wrong_size]


def judge(name, done, words, out):
    complaints = []
    if done.returncode != 2:
        complaints.append(f"status {done.returncode} instead of 2")
    sentence = done.stderr.strip()
    if "\n" in sentence or not sentence.startswith("rigcal refine: "):
        complaints.append("not one sentence")
    complaints += [f"does not name '{word}'" for word in words if word not in sentence]
    if out.exists() and any(out.iterdir()):
        complaints.append(f"left {[p.name for p in out.iterdir()]} behind")
    print(f"{'ok  ' if not complaints else 'FAIL'} {name}: {sentence}" + (f"   ({'; '.join(complaints)})" if complaints else ""))
    return not complaints


def full_disk(case):
    """A results folder on a file system of 12 KiB; skipped where none can be mounted."""
    out = case.folder / "full"
    out.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=12k", "tmpfs", str(out)], capture_output=True).returncode != 0:
        print("skip full_disk: no tmpfs can be mounted here")
        return True
    try:
        done = case.refine(out)
        torn = [p.name for p in out.iterdir() if p.suffix not in (".json", ".ply", ".txt") or p.stat().st_size == 0]
        good = judge("full_disk", done, ["space"], case.folder / "out")
        if torn:
            print(f"FAIL full_disk: half-written {torn}")
        return good and not torn
    finally:
        subprocess.run(["umount", str(out)], check=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    rigcal = parser.parse_args().rigcal
    root = pathlib.Path(tempfile.mkdtemp(prefix="rigcal-bad-input-"))
    good = True
    try:
        subprocess.run([rigcal, "sim", "render", "--scene", "textured", "--motion", "turntable", "--cameras", "1", "--stops", "6",
                        "--width", "320", "--height", "240", "--random-seed", "1", "--out", str(root / "set")], check=True,
                       capture_output=True)
        for spoil in CASES:
            case = Case(rigcal, root / "set", root / spoil.__name__)
            words = spoil(case)
            good &= judge(spoil.__name__, case.refine(), words, case.folder / "out")
        case = Case(rigcal, root / "set", root / "unwritable")
        (case.folder / "file").write_text("")
        good &= judge("unwritable_out", case.refine(case.folder / "file"), ["file"], case.folder / "out")
        good &= full_disk(Case(rigcal, root / "set", root / "full"))
    finally:
        shutil.rmtree(root)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
