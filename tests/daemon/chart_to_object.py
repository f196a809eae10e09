#!/usr/bin/env python3
"""The whole chain on a simulated turntable: chart -> seed with a rig -> another recording of an object, at stops with other
errors -> refine with the rig's poses and with free ones, against the truth; then with a camera bumped between the two, and
with one stop that slipped. chart_to_object.py --rigcal BIN [--full] [--scene NAME] [--keep DIR] [--threads N]

--full: 3 cameras x 12 stops of 1280 x 960 pixels and 15 boards held by hand a camera, instead of a small set."""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

# Seen on the small set: 0.016 px with the rig, 0.035 px with free poses, from 0.2 px.
MAX_RIG_PX, MAX_FREE_PX = 0.05, 0.10
MAX_FULL_PX = {"textured": 0.05, "plaster": 0.10}  # issue 3, point 3
WORSE_THAN_FREE_PX = 0.005  # what two runs of one set may differ by
MAX_CHART_RMS_PX = 0.15     # issue 3, point 2
MAX_AXIS_DEG, MAX_AXIS_MM = 0.01, 0.02  # issue 3, point 2: on the board; the direction about which the table really turned
BUMPED, SLIPPED = 1, 3      # the camera that is bumped, the stop that slips
BUMP_DEG, SLIP_DEG = 0.5, 1.0
RIG_ERRORS = ["--step-error-deg", "0.03", "--wobble-deg", "0.02", "--run-out-mm", "0.01"]


class Bench:
    def __init__(self, args, root):
        self.args, self.root, self.failures = args, root, 0
        size = (3, 12, 1280, 960, 15, 0.2) if args.full else (2, 8, 640, 480, 6, 0.2)
        self.cameras, self.stops, width, height, self.held, self.bow_mm = size
        self.studio = ["--scene", args.scene, "--cameras", self.cameras, "--stops", self.stops, "--width", width, "--height", height,
                       "--distortion=-0.12,0.05,0.0005,-0.0003", "--linear", "--bits", "16", "--recording"] + RIG_ERRORS

    def check(self, name, good, what):
        self.failures += not good
        print(f"{'ok  ' if good else 'FAIL'} {name}: {what}", flush=True)

    def run(self, *words, may_fail=False):
        done = subprocess.run([self.args.rigcal, *map(str, words)], capture_output=True, text=True)
        if done.returncode not in ((0, 2, 3) if may_fail else (0,)):
            raise RuntimeError(f"rigcal {words[0]}: status {done.returncode}: {done.stderr}")
        return done

    def refine(self, recording, out, *more, threads=None):
        done = self.run("refine", "--recording", self.root / recording, "--cameras", self.root / "seed/calibration.json", "--out",
                        self.root / out, "--threads", threads or self.args.threads, *more, may_fail=True)
        return done, json.loads((self.root / out / "report.json").read_text())

    def error_px(self, recording, out):
        compared = self.run("compare", "--reference", self.root / recording / "truth_calibration.json", "--estimate",
                            self.root / out / "calibration.json", "--points", self.root / recording / "points.txt", "--json")
        return json.loads(compared.stdout)["mean_px"]


def seed_from_the_chart(bench):
    board = bench.root / "board.toml"
    bench.run("chart", "print", "--family", "tag36h11", "--columns", 4, "--rows", 3, "--tag-mm", 36, "--gap-mm", 11, "--out",
              bench.root / "board.pdf")
    bench.run("sim", "render", *bench.studio, "--chart", board, "--hand-held", bench.held, "--board-tilt-deg", 25, "--bow-mm",
              bench.bow_mm, "--random-seed", 1, "--out", bench.root / "chart")
    done = bench.run("seed", "--recording", bench.root / "chart", "--chart", board, "--rig", bench.root / "chart/rig.toml", "--out",
                     bench.root / "seed", "--threads", bench.args.threads)
    report = json.loads((bench.root / "seed/report.json").read_text())
    truth = json.loads((bench.root / "chart/truth_calibration.json").read_text())
    off = max(abs(found["fx_px"] / true["fx_px"] - 1) for found, true in zip(report["cameras"], truth["cameras"]))
    bench.check("seed", report["rms_px"] <= MAX_CHART_RMS_PX,
                f"{report['rms_px']:.3f} px RMS, focal length {100 * off:.4f} % off; {done.stdout.strip().splitlines()[-1]}")


def turn_of(pose):
    w, x, y, z = pose["rotation_wxyz"]
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def axis_on_the_board(bench):
    """Against the truth: where the axis goes through the print, and how the stage's vertical lay in the table on the mean of the
    stops; the mean of their wobble is part of what turned."""
    truth = json.loads((bench.root / "chart/truth.json").read_text())
    found = json.loads((bench.root / "seed/report.json").read_text())["rig"]["axis_on_board"]
    board_from_world = turn_of(truth["chart"]["world_from_board"]).T
    origin = -board_from_world @ numpy.array(truth["chart"]["world_from_board"]["translation_m"])
    axis = board_from_world[:, 2]
    point = (origin - axis * origin[2] / axis[2])[:2]
    vertical = numpy.zeros(3)
    for stop in truth["stops"]:
        wobble, angle = stop["wobble_rad"], stop["commanded_rad"]
        tilt = numpy.array([-wobble[1], wobble[0], 1])  # transposed small turn applied to +z
        turn = numpy.array([[numpy.cos(angle), numpy.sin(angle), 0], [-numpy.sin(angle), numpy.cos(angle), 0], [0, 0, 1]])
        vertical += turn @ tilt
    turned = board_from_world @ (vertical / numpy.linalg.norm(vertical))
    direction = numpy.array(found["direction_in_board"])
    off_deg = numpy.degrees(numpy.linalg.norm(numpy.cross(turned, direction)))
    off_mm = 1e3 * numpy.linalg.norm(point - found["point_in_board_m"])
    bench.check("axis", off_deg < MAX_AXIS_DEG and off_mm < MAX_AXIS_MM,
                f"{off_deg:.4f} degrees (limit {MAX_AXIS_DEG}), {off_mm:.4f} mm (limit {MAX_AXIS_MM}) off; stated sigma "
                f"{found['direction_sigma_deg']:.4f} degrees, {1e3 * found['point_sigma_m']:.4f} mm")


def object_is_refined(bench):
    bench.run("sim", "render", *bench.studio, "--random-seed", 2, "--out", bench.root / "object")
    errors = {}
    for poses in ("rig", "free"):
        done, report = bench.refine("object", poses, "--poses", poses)
        errors[poses] = bench.error_px("object", poses)
        moved = [view["moved_px"] for view in report["views"]]
        limit = MAX_FULL_PX[bench.args.scene] if bench.args.full else MAX_RIG_PX if poses == "rig" else MAX_FREE_PX
        bench.check(poses, done.returncode == 0 and errors[poses] <= limit,
                    f"{report['verdict']}, Er {report['expected_error_px']:.1f} px, moved {sum(moved) / len(moved):.3f} px, {errors[poses]:.4f} px "
                    f"from the truth (limit {limit}) {[r['check'] for r in report['reasons']]} {report.get('contradictions', '')}")
    bench.check("rig or free", errors["rig"] <= errors["free"] + WORSE_THAN_FREE_PX,
                f"{errors['rig']:.4f} px with the rig, {errors['free']:.4f} px with free poses")
    bench.refine("object", "again", "--poses", "rig", threads="1" if bench.args.threads == "2" else "2")
    same = all((bench.root / "rig" / name).read_bytes() == (bench.root / "again" / name).read_bytes()
               for name in ("calibration.json", "report.json", "patches.ply"))
    bench.check("threads", same, f"the same bytes with another number of threads: {same}")


def fault_is_named(bench, name, options, words):
    bench.run("sim", "render", *bench.studio, *options, "--random-seed", 3, "--out", bench.root / name)
    done, report = bench.refine(name, name + "-out")
    found = report["contradictions"]
    bench.check(name, len(found) == 1 and all(word in found[0] for word in words) and found[0] in done.stdout,
                f"{report['verdict']}, {bench.error_px(name, name + '-out'):.4f} px from the truth; {found}")


def bad_input(bench):
    for name, options, words in (
            ("rig without stops", ["--images", bench.root / "object", "--cameras", bench.root / "seed/calibration.json"],
             ["--poses rig", "--recording"]),
            ("cameras without a rig", ["--recording", bench.root / "object", "--cameras", bench.root / "object/truth_calibration.json"],
             ["truth_calibration.json", "no rig"]),
            ("fixed cameras", ["--recording", bench.root / "object", "--cameras", bench.root / "seed/calibration.json",
                               "--fix-cameras", "cam0"], ["--fix-cameras", "--poses free"])):
        out = bench.root / "refused"
        done = bench.run("refine", *options, "--poses", "rig", "--out", out, may_fail=True)
        sentence = done.stderr.strip()
        bench.check(name, done.returncode == 2 and "\n" not in sentence and all(w in sentence for w in words)
                    and not (out.exists() and any(out.iterdir())), f"status {done.returncode}: {sentence}")


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--rigcal", required=True)
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--scene", default="textured")
    parser.add_argument("--threads", default="2")
    parser.add_argument("--keep")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rigcal-chain-") as folder:
        root = pathlib.Path(args.keep or folder)
        root.mkdir(parents=True, exist_ok=True)
        bench = Bench(args, root)
        seed_from_the_chart(bench)
        axis_on_the_board(bench)
        object_is_refined(bench)
        fault_is_named(bench, "bump", ["--bump", f"{BUMPED}:{BUMP_DEG}"], [f"cam{BUMPED}"])
        fault_is_named(bench, "slip", ["--slip", f"{SLIPPED}:{SLIP_DEG}"], [f"stop {SLIPPED:02}"])
        bad_input(bench)
        sys.exit(1 if bench.failures else 0)


if __name__ == "__main__":
    main()
