#!/usr/bin/env python3
"""How near to the truth does `rigcal refine` come? Disturbs the true cameras of a set, refines, compares; one line a run.

accuracy.py --rigcal BIN --tools DIR --images DIR --truth PAR --points FILE --error-px 6 [--seeds 0-19] [--er 7|auto]
            [--perturb "--shared-k --square"] [--json FILE] [-- further options of refine]

--tools is the folder with perturb.py (../shared/tools); its cameras are what the figures in docs/benchmarks.md start from.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time


def run_seed(args, seed, folder):
    start = folder / f"start{seed}_par.txt"
    out = folder / f"out{seed}"
    subprocess.run(["/usr/bin/python3", f"{args.tools}/perturb.py", args.truth, args.points, str(start), str(args.error_px),
                    str(seed)] + args.perturb.split(), check=True, stdout=subprocess.DEVNULL)
    command = [args.rigcal, "refine", "--images", args.images, "--cameras", str(start), "--out", str(out)] + args.refine
    if args.er != "auto":
        command += ["--expected-error-px", args.er]
    begin = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True)
    seconds = time.monotonic() - begin
    if done.returncode not in (0, 3):
        print(f"seed {seed}: exit {done.returncode}: {done.stderr.strip()}", flush=True)
        return None
    report = json.loads((out / "report.json").read_text())
    row = {"seed": seed, "verdict": report["verdict"], "seconds": seconds, "er": report["expected_error_px"],
           "reasons": [f"{r['check']} {r['value']:.3g}>{r['limit']:.3g} {r.get('view', '')}" for r in report["reasons"]]}
    compare = subprocess.run([args.rigcal, "compare", "--reference", args.truth, "--estimate", str(out / "calibration.json"),
                              "--points", args.points, "--projective", "--json"], capture_output=True, text=True, check=True)
    compared = json.loads(compare.stdout)
    row["similarity"] = compared["mean_px"]
    row["projectivity"] = compared["projective"]["mean_px"]
    return row


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    for name in ("rigcal", "tools", "images", "truth", "points"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--error-px", type=float, required=True)
    parser.add_argument("--seeds", default="0-19")
    parser.add_argument("--er", default="auto")
    parser.add_argument("--perturb", default="")
    parser.add_argument("--json")
    parser.add_argument("--keep")
    parser.add_argument("refine", nargs="*")
    args = parser.parse_args()
    first, last = (args.seeds.split("-") * 2)[:2]
    rows = []
    folder = pathlib.Path(args.keep or tempfile.mkdtemp(prefix="rigcal-accuracy-"))
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(int(first), int(last) + 1):
        row = run_seed(args, seed, folder)
        if row:
            rows.append(row)
            print(f"seed {seed:2d}: {row['similarity']:.3f} px ({row['projectivity']:.3f} after a projectivity) {row['verdict']:12s} "
                  f"Er {row['er']:.1f} {row['seconds']:.1f} s {'; '.join(row['reasons'][:3])}", flush=True)
    if not rows:
        sys.exit("no run ended")
    errors = [row["similarity"] for row in rows]
    accepted = [row["similarity"] for row in rows if row["verdict"] == "accepted"]
    print(f"{len(rows)} runs: median {statistics.median(errors):.3f} mean {statistics.mean(errors):.3f} max {max(errors):.3f} px; after a "
          f"projectivity median {statistics.median(r['projectivity'] for r in rows):.3f}; accepted {len(accepted)}"
          + (f", worst accepted {max(accepted):.3f} px" if accepted else ""))
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
