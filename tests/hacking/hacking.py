#!/usr/bin/env python3
"""Runs the commands of HACKING.md (its indented lines) in the project's folder, in order; each must succeed. `$WORK` is a folder that
is removed afterwards. hacking.py --source DIR"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

HANGS_AFTER_S = 300
MIN_COMMANDS = 5  # fewer are a page that was not understood


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--source", required=True, type=pathlib.Path)
    source = parser.parse_args().source
    commands = [line.strip() for line in (source / "HACKING.md").read_text().splitlines() if line.startswith("    ")]
    failures = 0
    with tempfile.TemporaryDirectory(prefix="rigcal-hacking-") as work:
        for command in commands:
            done = subprocess.run(["bash", "-c", command], cwd=source, env=dict(os.environ, WORK=work), capture_output=True, text=True,
                                  timeout=HANGS_AFTER_S)
            failures += done.returncode != 0
            print(f"{'ok  ' if done.returncode == 0 else 'FAIL'} {command}", flush=True)
            if done.returncode != 0:
                print(done.stdout[-2000:], done.stderr[-2000:])
    if len(commands) < MIN_COMMANDS:
        sys.exit(f"HACKING.md has {len(commands)} commands")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
