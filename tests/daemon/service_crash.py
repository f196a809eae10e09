#!/usr/bin/env python3
"""SIGKILL at random moments of jobs and publications: the store opens every time, what is in force is whole, no picture is lost,
current.json is never torn, and no job is taken for running. service_crash.py --rigcal BIN --rigcald BIN --openapi FILE [--times N]
[--random-seed S]"""
import argparse
import hashlib
import json
import pathlib
import random
import signal
import sys
import tempfile
import threading
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from service import HANG_S, QUICK, Bench  # noqa: E402

LONGEST_S = 4  # a recalibration with one round takes about as long


def pictures_of(state):
    """What recordings list: file and SHA-256."""
    listed = {}
    for path in state.glob("recordings/*/recording.json"):
        for view in json.loads(path.read_text())["views"]:
            listed[path.parent / view["file"]] = view["sha256"]
    return listed


def publish_until_killed(bench):
    """A person who changes his mind all the time."""
    try:
        while True:
            revisions = [head["number"] for head in bench.get("/api/v1/calibrations")["revisions"]]
            for revision in revisions[:2]:
                bench.ask("POST", f"/api/v1/calibrations/{revision}/publish", json.dumps({"by": "anna", "reason": "to and fro"}))
    except (OSError, ValueError, KeyError):
        pass  # the service is gone


def torn(bench, stop, found):
    """Reads current.json all the time."""
    while not stop.is_set():
        try:
            json.loads((bench.state / "published/current.json").read_text())
        except ValueError as error:
            found.append(str(error))


def survives(bench, moment_s):
    before = pictures_of(bench.state)
    stop, found = threading.Event(), []
    reader = threading.Thread(target=torn, args=(bench, stop, found))
    reader.start()
    person = threading.Thread(target=publish_until_killed, args=(bench,))
    person.start()
    bench.run("recalibrate", *QUICK)
    time.sleep(moment_s)
    bench.stop(signal.SIGKILL)
    stop.set()
    reader.join(HANG_S)
    person.join(HANG_S)
    before.update(pictures_of(bench.state))
    bench.start()
    wrong = found
    if "nothing is wrong" not in (said := bench.store("store", "check").stdout):
        wrong.append(said)
    in_force = bench.get("/api/v1/calibrations")["in_force"]
    current = json.loads((bench.state / "published/current.json").read_text())
    if current["revision"]["number"] != in_force:
        wrong.append(f"current.json shows {current['revision']['number']}, {in_force} is in force")
    wrong += [f"{path} is lost" for path, sha256 in before.items()
              if not path.exists() or hashlib.sha256(path.read_bytes()).hexdigest() != sha256]
    states = [job["state"] for job in bench.get("/api/v1/jobs?count=500")["jobs"]]
    if "running" in states or "queued" in states:
        wrong.append(f"jobs are {states}")
    bench.check(f"killed after {moment_s:.2f} s", not wrong, f"{states[0]}, {len(before)} pictures {wrong}")


def main():
    parser = argparse.ArgumentParser()
    for option in ("--rigcal", "--rigcald", "--openapi"):
        parser.add_argument(option, required=True)
    parser.add_argument("--times", type=int, default=200)
    parser.add_argument("--random-seed", type=int, default=1)
    args = parser.parse_args()
    moments = random.Random(args.random_seed)
    with tempfile.TemporaryDirectory(prefix="rigcal_crash_") as root:
        bench = Bench(args, pathlib.Path(root))
        try:
            bench.start()
            bench.check("seeded", bench.run("seed-chart", "--wait").returncode == 0)
            bench.check("refined", bench.run("recalibrate", "--wait", *QUICK).returncode in (0, 3))
            for _ in range(args.times):
                survives(bench, moments.uniform(0, LONGEST_S))
        finally:
            if bench.daemon and bench.daemon.poll() is None:
                bench.daemon.kill()
                bench.daemon.wait()
            if bench.failures:
                bench.log.seek(0)
                print(bench.log.read())
    return 1 if bench.failures else 0


if __name__ == "__main__":
    sys.exit(main())
