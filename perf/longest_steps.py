#!/usr/bin/env python3
"""The longest step of every built-in scene over the median one.

usage: python3 perf/longest_steps.py ATOLL [SCENE...]

Each scene runs as `atoll run SCENE` does, by one thread, so often that the least of its longest steps is the scene's
and not the machine's.
"""
import json
import re
import subprocess
import sys

RUNS = 3


def report(atoll, scene):
    command = [atoll, "run", scene, "--threads", "1", "--format", "json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    atoll = sys.argv[1]
    scenes = sys.argv[2:]
    if not scenes:
        listed = subprocess.run([atoll, "scenes"], check=True, capture_output=True, text=True).stdout
        scenes = re.findall(r"^([a-z0-9-]+)  ", listed, re.MULTILINE)
    print(f"{'scene':<20} {'bodies':>6} {'median ms':>10} {'p99 / median':>13} {'longest / median':>17} {'in step':>8}")
    for scene in scenes:
        runs = [report(atoll, scene) for _ in range(RUNS)]
        best = min(runs, key=lambda run: run["ms_per_step"]["max"])
        ms = best["ms_per_step"]
        print(f"{scene:<20} {best['bodies']:>6} {ms['median']:>10.4f} {ms['p99'] / ms['median']:>13.1f} "
              f"{ms['max'] / ms['median']:>17.1f} {ms['longest_step']:>8} of {best['steps']}", flush=True)


main()
