#!/usr/bin/env python3
"""Does the nightly drift check find a camera that moved, and nothing else? (issue 5, "What must be shown", 5.) Simulated turntable with
three cameras. Once: chart -> seed with a rig -> refine on an object: the calibration in force. A night: another object, fresh step
errors, wobble, run-out and noise, a few stops; undisturbed, or with one camera turned about a random axis so that the object's image
moves by 0.3 px on average.

drift_nights.py --rigcal BIN --work DIR [--nights 0-99] [--kind undisturbed,turned] [--random-seed N] [--stops 4] [--threads N] [--summary]

One line of JSON a night in DIR/nights.jsonl; a night that has its line is not done again, so that it can be stopped at any time.
--summary: the counts alone. Status 1 when the counts of 100 nights each break the limits, or for the nights done their shares.

--random-seed: everything that is drawn. The default, 1, was never used while the check was made (that was 900)."""
import argparse
import collections
import json
import pathlib
import shutil
import subprocess
import sys

CAMERAS, WIDTH, HEIGHT, SHIFT_PX = 3, 640, 480, 0.3
STUDIO = ["--scene", "textured", "--cameras", CAMERAS, "--width", WIDTH, "--height", HEIGHT, "--distortion=-0.12,0.05,0.0005,-0.0003",
          "--linear", "--bits", 16, "--recording", "--step-error-deg", 0.03, "--wobble-deg", 0.02, "--run-out-mm", 0.01]
CHART = {"columns": 4, "rows": 3, "tag-mm": 36, "gap-mm": 11}
CHART_STOPS, HAND_HELD, OBJECT_STOPS = 8, 12, 12
OBJECTS = ("textured", "plaster", "thin")
NIGHTS_APART = 10  # random seeds of one night: undisturbed, turned
MAX_DRIFTING, MAX_INCONCLUSIVE, MIN_FOUND = 0.01, 0.05, 0.95


def run(args, *words, status=(0,)):
    done = subprocess.run([args.rigcal, *map(str, words)], capture_output=True, text=True)
    if done.returncode not in status:
        raise RuntimeError(f"rigcal {' '.join(map(str, words))}: status {done.returncode}: {done.stderr}")
    return done


def seed_of(args, number):
    return 1_000_000 * args.random_seed + number


def put_in_force(args):
    """The calibration in force, made once; each step leaves its folder only when it is whole."""
    work, board = args.work, args.work / "board.toml"

    def step(name, *words, status=(0,)):
        if (work / name).exists():
            return
        shutil.rmtree(work / "making", ignore_errors=True)
        run(args, *words, "--out", work / "making", status=status)
        (work / "making").rename(work / name)

    if not board.exists():
        run(args, "chart", "print", "--family", "tag36h11", *[w for k, v in CHART.items() for w in ("--" + k, v)], "--out", work / "board.pdf")
    step("chart", "sim", "render", *STUDIO, "--stops", CHART_STOPS, "--chart", board, "--hand-held", HAND_HELD, "--board-tilt-deg", 25, "--bow-mm",
         0.2, "--random-seed", seed_of(args, 900_001))
    step("seed", "seed", "--recording", work / "chart", "--chart", board, "--rig", work / "chart/rig.toml")
    step("object", "sim", "render", *STUDIO, "--stops", OBJECT_STOPS, "--random-seed", seed_of(args, 900_002))
    step("inforce", "refine", "--recording", work / "object", "--cameras", work / "seed/calibration.json", "--poses", "rig", "--threads",
         args.threads, status=(0, 3))
    report = json.loads((work / "inforce/report.json").read_text())
    if report["verdict"] != "accepted":
        raise RuntimeError(f"the calibration that is to be in force is {report['verdict']}: {report['reasons']}")


def one_night(args, kind, night):
    folder, out = args.work / "night", args.work / "night-out"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.rmtree(out, ignore_errors=True)
    turned = kind == "turned"
    camera = f"cam{night % CAMERAS}"
    scene = [*STUDIO, "--stops", args.stops, "--object", OBJECTS[night // CAMERAS % len(OBJECTS)], "--object-variant", NIGHTS_APART * night + turned + 1,
             "--random-seed", seed_of(args, NIGHTS_APART * night + turned)]
    run(args, "sim", "render", *scene, *(["--bump-px", f"{camera}:{SHIFT_PX}"] if turned else []), "--out", folder, "--threads", args.threads)
    done = run(args, "drift-check", "--recording", folder, "--cameras", args.work / "inforce/calibration.json", "--out", out, "--threads",
               args.threads, status=(0, 3))
    drift = json.loads((out / "drift.json").read_text())
    row = {"kind": kind, "night": night, "object": scene[scene.index("--object") + 1], "state": drift["state"], "suspects": drift["suspects"],
           "told": drift["which_is_told"], "sentence": drift["sentences"][0],
           "cameras": {c["camera"]: [round(c["moved_px"], 4), round(c["sigma_px"], 4), round(c["chi_square"], 1), c["num_features"]] for c in drift["cameras"]},
           "seconds": round(json.loads((out / "timing.json").read_text())["total_seconds"], 1)}
    if turned:
        row["turned"] = camera
        row["found"] = drift["state"] == "drifting" and drift["suspects"] == [camera] and drift["which_is_told"]
    return row


def rows_of(log):
    if not log.exists():
        return []
    whole = log.read_text().splitlines(keepends=True)
    return [json.loads(line) for line in whole if line.endswith("\n")]  # a last line without its end was interrupted


def summary(rows):
    good = True
    for kind in ("undisturbed", "turned"):
        of_kind = [row for row in rows if row["kind"] == kind]
        if not of_kind:
            continue
        states = collections.Counter(row["state"] for row in of_kind)
        share = {state: count / len(of_kind) for state, count in states.items()}
        line = f"{kind}: {len(of_kind)} nights, " + ", ".join(f"{count} {state}" for state, count in sorted(states.items()))
        if kind == "turned":
            found = sum(row["found"] for row in of_kind)
            line += f"; {found} found with the right camera"
            good = good and found >= MIN_FOUND * len(of_kind)
        else:
            good = good and share.get("drifting", 0) <= MAX_DRIFTING and share.get("inconclusive", 0) <= MAX_INCONCLUSIVE
            good = good and share.get("failed", 0) == 0
        print(line)
        for row in of_kind:
            if (row["state"] != "ok") if kind == "undisturbed" else not row["found"]:
                print(f"  {kind} {row['night']} ({row['object']}): {row['sentence']} {row['cameras']}")
    return good


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--rigcal", required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--nights", default="0-99")
    parser.add_argument("--kind", default="undisturbed,turned")
    parser.add_argument("--random-seed", type=int, default=1)
    parser.add_argument("--stops", type=int, default=4)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--summary", action="store_true")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    log = args.work / "nights.jsonl"
    rows = rows_of(log)
    if not args.summary:
        put_in_force(args)
        log.write_text("".join(json.dumps(row) + "\n" for row in rows))
        first, last = (int(part) for part in args.nights.split("-"))
        done = {(row["kind"], row["night"]) for row in rows}
        for night in range(first, last + 1):
            for kind in args.kind.split(","):
                if (kind, night) in done:
                    continue
                rows.append(one_night(args, kind, night))
                with log.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
                print(json.dumps(rows[-1]), flush=True)
    sys.exit(0 if summary(rows) else 1)


if __name__ == "__main__":
    main()
