#!/usr/bin/env python3
"""Bad input, as a user meets it: each case must end with status 2, one sentence on stderr that names what is wrong, and
nothing written. bad_input.py --rigcal BIN"""
import argparse
import json
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
        self.out = folder / "out"
        self.options = []

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

    def refine(self, out=None, source="--images"):
        out = out or self.out
        command = [self.rigcal, "refine", source, str(self.folder), "--cameras", str(self.par), "--out", str(out),
                   "--masks", self.masks, "--expected-error-px", "4", "--rounds", "1"] + self.options
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
    return ["truth_par.txt", "line 4"]


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
    return ["2 views", "at least 3"]


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
    return ["masks/" + path.name, "the mask is"]


def over_exposed(case):
    import cv2
    path = str(case.image(2))
    cv2.imwrite(path, cv2.convertScaleAbs(cv2.imread(path), alpha=8))
    return [case.image(2).name, "over-exposed", "50 %"]


def out_is_a_recording(case):
    case.out = case.folder
    return ["is a recording"]


def mask_pattern_without_masks(case):
    case.options += ["--mask-from-name", "a=b"]
    return ["--mask-from-name", "folder of masks"]


CASES = [out_is_a_recording, mask_pattern_without_masks, missing_image, truncated_png, unreadable_image, differing_size, principal_point_outside, too_few_numbers,
         not_a_number, no_rotation, looking_away, two_views, skew, no_par_file, mask_of_wrong_size,
         over_exposed]


def edit_list(case, edit):
    path = case.folder / "recording.json"
    recording = json.loads(path.read_text())
    edit(recording)
    path.write_text(json.dumps(recording))


def list_truncated(case):
    path = case.folder / "recording.json"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return ["recording.json", "line"]


def list_missing(case):
    (case.folder / "recording.json").unlink()
    return ["recording.json"]


def list_of_a_newer_version(case):
    edit_list(case, lambda recording: recording.update(version=2))
    return ["recording.json", "version 2"]


def recording_empty(case):
    edit_list(case, lambda recording: recording.update(views=[]))
    return ["recording.json", "empty"]


def recording_of_a_chart(case):
    edit_list(case, lambda recording: [view.update(subject="chart") for view in recording["views"]])
    return ["recording.json", "6 views", "object"]


def recording_not_closed(case):
    edit_list(case, lambda recording: recording.update(closed=False))
    return ["recording.json", "not closed"]


def recorded_image_missing(case):
    case.image(2).unlink()
    return [case.image(2).name]


def recorded_image_changed(case):
    case.image(2).write_bytes(case.image(3).read_bytes())
    return [case.image(2).name, "SHA-256"]


def picture_without_camera(case):
    lines = case.lines()
    name = lines.pop().split()[0]
    case.par.write_text("\n".join(["5"] + lines[1:]) + "\n")
    return ["truth_par.txt", name]


def camera_without_picture(case):
    case.edit_par(2, 0, "other.png")
    return ["truth_par.txt", "other.png"]


# Those that `recording check` must find too, and those that lie between recording and cameras.
SPOILT_RECORDINGS = [list_truncated, list_missing, list_of_a_newer_version, recording_empty, recording_not_closed,
                     recorded_image_missing, recorded_image_changed]
RECORDING_CASES = SPOILT_RECORDINGS + [recording_of_a_chart, picture_without_camera, camera_without_picture]


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


def recordings(rigcal, root):
    """Recordings that are spoilt: refined and checked; pictures that make none; options that contradict each other."""
    good = True
    for spoil in RECORDING_CASES:
        case = Case(rigcal, root / "set", root / spoil.__name__)
        words = spoil(case)
        good &= judge(spoil.__name__, case.refine(source="--recording"), words, case.folder / "out")
        check = subprocess.run([rigcal, "recording", "check", str(case.folder)], capture_output=True, text=True)
        found = check.returncode == 2 and words[0] in check.stdout + check.stderr
        if found != (spoil in SPOILT_RECORDINGS):
            print(f"FAIL {spoil.__name__}: recording check says {check.returncode} {check.stdout}{check.stderr}")
            good = False
    case = Case(rigcal, root / "set", root / "both")
    done = subprocess.run([rigcal, "refine", "--recording", str(case.folder), "--camera-from-name", "(cam0)", "--cameras",
                           str(case.par), "--out", str(case.folder / "out")], capture_output=True, text=True)
    refused = done.returncode == 2 and "--camera-from-name" in done.stderr and not (case.folder / "out").exists()
    print(f"{'ok  ' if refused else 'FAIL'} recording and camera-from-name: {done.stderr.splitlines()[0]}")
    return good and refused & imports(rigcal, root)


def imports(rigcal, root):
    source, out = root / "plain", root / "imported"
    source.mkdir()
    for path in (root / "set").glob("*.png"):
        shutil.copy(path, source)
    good = True

    def refused(name, words, *more):
        done = subprocess.run([rigcal, "recording", "import", "--images", str(source), "--what", "object", "--out", str(out)] +
                              list(more), capture_output=True, text=True)
        fits = (done.returncode == 2 and done.stderr.startswith("rigcal recording import: ") and done.stderr.count("\n") == 1
                and all(word in done.stderr for word in words) and not list(root.glob(".imported*")))
        print(f"{'ok  ' if fits else 'FAIL'} {name}: {done.stderr.strip()}")
        return fits

    good &= refused("import_pattern", ["cam1", "cam0_stop00.png"], "--camera-from-name", "(cam1)")
    good &= refused("import_angles", ["angles.txt"], "--stop-from-name", "stop([0-9]+)", "--angles-deg", "angles.txt")
    good &= refused("import_one_stop", ["cam0_stop01.png", "stop '0'"], "--stop-from-name", "stop(0)")
    (source / "cam0_stop05.png").write_text("not a picture")
    good &= refused("import_unreadable", ["cam0_stop05.png"])
    if out.exists():
        print("FAIL an import that was refused left its folder behind")
        good = False
    out.mkdir()
    (out / "precious").write_text("")
    good &= refused("import_over_something", ["imported", "not empty"])
    return good


def rigcal_refuses(name, words, command, unchanged):
    """Status 2 and one sentence with the words; the file `unchanged` stays as it is."""
    before = unchanged.read_bytes()
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    fits = (done.returncode == 2 and done.stderr.count("\n") == 1 and all(word in done.stderr for word in words)
            and unchanged.read_bytes() == before)
    print(f"{'ok  ' if fits else 'FAIL'} {name}: {done.stderr.strip()}")
    return fits


def results_over_inputs(rigcal, root):
    """Nothing is written over what a person made, and no number passes that is none."""
    case = Case(rigcal, root / "set", root / "over")
    good = rigcal_refuses("export_over_its_input", ["truth_par.txt"],
                          [rigcal, "export", case.par, "--format", "middlebury", "--out", case.par], case.par)
    board = root / "board.toml"
    printed = [rigcal, "chart", "print", "--family", "tag36h11", "--columns", "4", "--rows", "3", "--tag-mm", "30", "--gap-mm", "9",
               "--out", root / "board.pdf"]
    subprocess.run(list(map(str, printed)), check=True, capture_output=True)
    board.write_text(board.read_text().replace("thickness_m = 0", "thickness_m = 0.004"))
    good &= rigcal_refuses("print_over_an_edited_board", ["board.toml"], printed, board)
    for option in ("--expected-error-px", "--aspect-sigma", "--holdout"):
        done = subprocess.run([rigcal, "refine", "--images", str(case.folder), "--cameras", str(case.par), "--out", str(case.out),
                               option, "nan"], capture_output=True, text=True)
        fits = done.returncode == 2 and option in done.stderr and not case.out.exists()
        print(f"{'ok  ' if fits else 'FAIL'} {option} nan: {done.stderr.splitlines()[0]}")
        good &= fits
    prior = case.folder / "prior_par.txt"
    lines = case.lines()
    prior.write_text("\n".join([str(len(lines) - 2)] + lines[2:]) + "\n")
    return good & rigcal_refuses("prior_without_a_view", ["prior_par.txt", lines[1].split()[0]],
                                 [rigcal, "validate", "--images", case.folder, "--cameras", case.par, "--prior", prior], prior)


def is_whole(path):
    if path.suffix == ".json":
        return bool(json.loads(path.read_text()))
    return path.suffix in (".ply", ".txt") and path.stat().st_size > 0


def full_disk(case):
    """A results folder on a file system of 12 KiB; skipped where none can be mounted."""
    out = case.folder / "full"
    out.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=12k", "tmpfs", str(out)], capture_output=True).returncode != 0:
        print("skip full_disk: no tmpfs can be mounted here")
        return True
    try:
        done = case.refine(out)
        torn = [p.name for p in out.iterdir() if p.name.startswith(".") or not is_whole(p)]
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
                        "--width", "320", "--height", "240", "--random-seed", "1", "--recording", "--out", str(root / "set")],
                       check=True, capture_output=True)
        for spoil in CASES:
            case = Case(rigcal, root / "set", root / spoil.__name__)
            words = spoil(case)
            good &= judge(spoil.__name__, case.refine(), words, case.folder / "out")
        good &= recordings(rigcal, root)
        case = Case(rigcal, root / "set", root / "unwritable")
        (case.folder / "file").write_text("")
        good &= judge("unwritable_out", case.refine(case.folder / "file"), ["a folder is needed"], case.folder / "out")
        good &= results_over_inputs(rigcal, root)
        good &= full_disk(Case(rigcal, root / "set", root / "full"))
    finally:
        shutil.rmtree(root)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
