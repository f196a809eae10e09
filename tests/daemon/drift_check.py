#!/usr/bin/env python3
"""`rigcal drift-check` as an operator meets it, on a small simulated turntable: chart -> seed with a rig -> an undisturbed night, one
with a camera bumped, one with a stop that slipped; bad input. drift_check.py --rigcal BIN [--keep DIR]"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

STUDIO = ["--cameras", 3, "--width", 480, "--height", 360, "--samples", 2, "--linear", "--bits", 16, "--recording", "--step-error-deg", 0.03,
          "--wobble-deg", 0.02, "--run-out-mm", 0.01]
STOPS = 4
BUMPED, BUMP_PX = 1, 2.0
SLIPPED, SLIP_DEG = 2, 1.0
LIMIT_PX = 0.5  # far from what an undisturbed night shows (0.05 px) and from the bump


class Bench:
    def __init__(self, rigcal, root):
        self.rigcal, self.root, self.failures = rigcal, root, 0

    def check(self, name, good, what=""):
        self.failures += not good
        print(f"{'ok  ' if good else 'FAIL'} {name}: {what}", flush=True)

    def run(self, *words, status=(0,)):
        done = subprocess.run([self.rigcal, *map(str, words)], capture_output=True, text=True, timeout=500)
        if done.returncode not in status:
            raise RuntimeError(f"rigcal {words[0]}: status {done.returncode}: {done.stderr}")
        return done

    def night(self, name, seed, *faults):
        self.run("sim", "render", *STUDIO, "--stops", STOPS, "--object-variant", seed, "--random-seed", seed, "--out", self.root / name, *faults)

    def drift_check(self, name, *more, out=None, cameras="seed/calibration.json"):
        out = self.root / (out or name + "-out")
        done = self.run("drift-check", "--recording", self.root / name, "--cameras", self.root / cameras, "--out", out, "--expected-error-px",
                        4, *more, status=(0, 2, 3))
        file = out / "drift.json"
        return done, json.loads(file.read_text()) if file.exists() else None


def seed_from_the_chart(bench):
    board = bench.root / "board.toml"
    bench.run("chart", "print", "--family", "tag36h11", "--columns", 4, "--rows", 3, "--tag-mm", 36, "--gap-mm", 11, "--out",
              bench.root / "board.pdf")
    bench.run("sim", "render", *STUDIO, "--stops", 6, "--chart", board, "--hand-held", 4, "--board-tilt-deg", 25, "--random-seed", 1, "--out",
              bench.root / "chart")
    bench.run("seed", "--recording", bench.root / "chart", "--chart", board, "--rig", bench.root / "chart/rig.toml", "--out", bench.root / "seed")


def told(drift):
    return [f"{c['camera']} {c['moved_px']:.3f} +- {c['sigma_px']:.3f}" for c in drift["cameras"]]


def nights(bench):
    bench.night("quiet", 2)
    done, drift = bench.drift_check("quiet", "--limit-px", LIMIT_PX)
    bench.check("undisturbed", done.returncode == 0 and drift["state"] == "ok" and not drift["suspects"] and done.stdout.startswith("ok: "),
                f"{done.stdout.splitlines()[0]} {told(drift)}")
    again, same = bench.drift_check("quiet", "--limit-px", LIMIT_PX, "--threads", 1, out="again")
    bench.check("threads", (bench.root / "again/drift.json").read_bytes() == (bench.root / "quiet-out/drift.json").read_bytes())

    bench.night("bumped", 3, "--bump-px", f"cam{BUMPED}:{BUMP_PX}")
    (bench.root / "rig.toml").write_text(f'[positioner]\nkind = "turntable"\n[drift]\nlimit_px = {LIMIT_PX}\n')
    done, drift = bench.drift_check("bumped", "--rig", bench.root / "rig.toml", "--earlier", bench.root / "quiet-out/drift.json", "--json")
    moved = {c["camera"]: c["moved_px"] for c in drift["cameras"]}
    bench.check("bumped", done.returncode == 3 and drift["state"] == "drifting" and drift["suspects"] == [f"cam{BUMPED}"]
                and drift["which_is_told"] and 0.7 * BUMP_PX < moved[f"cam{BUMPED}"] < 1.4 * BUMP_PX and drift["limit_px"] == LIMIT_PX
                and json.loads(done.stdout) == drift, f"{drift['sentences'][0]} {told(drift)}")
    before, after = ([c["holdout"][key] for c in drift["cameras"]] for key in ("before_px", "after_px"))
    bench.check("hold-out", sum(before) > 1.2 * sum(after), f"{before} px before, {after} px after")

    bench.night("slipped", 4, "--slip", f"{SLIPPED}:{SLIP_DEG}")
    done, drift = bench.drift_check("slipped", "--limit-px", LIMIT_PX)
    bench.check("slipped", done.returncode == 3 and drift["state"] == "failed" and not drift["suspects"]
                and f"stop {SLIPPED:02}: step error" in drift["sentences"][0], f"{drift['sentences'][0]} {told(drift)}")


def bad_input(bench):
    for name, recording, options, cameras, words in (
            ("no rig", "quiet", [], "chart/truth_par.txt", ["truth_par.txt", "no rig"]),
            ("no recording", "seed", [], "seed/calibration.json", ["recording.json"]),
            ("a limit", "quiet", ["--limit-px", 0], "seed/calibration.json", ["limit-px", "0.01"]),
            ("not a drift check", "quiet", ["--earlier", bench.root / "seed/report.json"], "seed/calibration.json", ["report.json"]),
            ("a chart", "chart", [], "seed/calibration.json", ["chart", "object"])):
        done, drift = bench.drift_check(recording, *options, out="refused", cameras=cameras)
        sentence = done.stderr.strip()
        bench.check(name, done.returncode == 2 and drift is None and all(word in sentence for word in words), sentence)


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--rigcal", required=True)
    parser.add_argument("--keep")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rigcal-drift-") as folder:
        root = pathlib.Path(args.keep or folder)
        root.mkdir(parents=True, exist_ok=True)
        bench = Bench(args.rigcal, root)
        seed_from_the_chart(bench)
        nights(bench)
        bad_input(bench)
        sys.exit(1 if bench.failures else 0)


if __name__ == "__main__":
    main()
