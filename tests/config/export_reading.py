"""What the tests of exports share: export an example, read it back with something that is not of this project, project
points with the reader's own model, and compare with where the program itself sees them."""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy

MAX_DIFFERENCE_PX = 1e-6  # 17 digits leave about 1e-12; half a pixel or a flipped axis is 0.5 and more
SKIPPED = 77              # SKIP_RETURN_CODE in CMakeLists.txt


class Exports:
    """The examples of tests/config/export_examples.h in a folder, and a count of what went wrong with their exports."""

    def __init__(self, rigcal, examples, root):
        self.rigcal, self.root, self.failures = rigcal, root, 0
        subprocess.run([examples, str(root)], check=True)
        self.points = numpy.array(json.loads((root / "points.json").read_text()))

    def calibration(self, example):
        return json.loads((self.root / f"{example}.json").read_text())

    def pixels(self, example):
        return numpy.array(json.loads((self.root / f"{example}.pixels.json").read_text()))

    def export(self, example, form, *more):
        out = self.root / f"{example}.{form}{''.join(more)}"
        subprocess.run([self.rigcal, "export", str(self.root / f"{example}.json"), "--format", form, "--out", str(out), *more],
                       check=True, capture_output=True)
        return out

    def check(self, name, good, what):
        self.failures += not good
        print(f"{'ok  ' if good else 'FAIL'} {name}: {what}", flush=True)

    def compare(self, name, read_px, own_px):
        difference = numpy.abs(numpy.asarray(read_px) - own_px).max()
        self.check(name, difference < MAX_DIFFERENCE_PX, f"at most {difference:.2g} px (limit {MAX_DIFFERENCE_PX})")


def run(test, missing=None):
    """`missing`: a sentence when the reader is not installed."""
    if missing and not os.environ.get("RIGCAL_NEEDS_READERS"):
        print(f"skipped: {missing}")
        sys.exit(SKIPPED)
    if missing:
        print(f"FAIL reader: {missing}")
        sys.exit(1)
    parser = argparse.ArgumentParser()
    parser.add_argument("--rigcal", required=True)
    parser.add_argument("--examples", required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        exports = Exports(arguments.rigcal, arguments.examples, pathlib.Path(folder))
        test(exports)
        sys.exit(1 if exports.failures else 0)
