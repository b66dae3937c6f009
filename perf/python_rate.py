#!/usr/bin/env python3
"""What Python costs, and what a batch saves: steps of a world from Python against those of the command, and many worlds
in a batch against as many worlds one by one.

usage: python_rate.py COMMAND [--repeats N]     with the package `atoll` on PYTHONPATH; COMMAND is the atoll command

Each pair is measured in turns, so that what else the machine does hits both; medians of the repeats.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import time
from collections.abc import Callable

import numpy as np

import atoll

SCENE = "islands:count=1,base=6"  # 21 bodies
CONTACTS = "pile:bodies=1000"


def seconds_of(run: Callable[[], object]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


def medians(repeats: int, **runs: Callable[[], float]) -> dict[str, float]:
    found: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(repeats):
        for name, run in runs.items():
            found[name].append(run())
    return {name: statistics.median(values) for name, values in found.items()}


def steps_from_python(count: int) -> float:
    """ms a step."""
    scene = atoll.load_scene(CONTACTS)
    world = scene.build()
    return 1e3 * seconds_of(lambda: [world.step(scene.dt) for _ in range(count)]) / count


def steps_of_command(command: str, count: int) -> float:
    text = subprocess.run(
        [command, "run", CONTACTS, "--steps", str(count), "--threads", "1", "--format", "json"],
        check=True, capture_output=True, text=True,
    ).stdout
    return float(json.loads(text)["ms_per_step"]["mean"])


def one_by_one(worlds: list[atoll.World], count: int) -> float:
    """World steps a second."""

    def run() -> None:
        for _ in range(count):
            for world in worlds:
                world.step(1 / 60)

    return len(worlds) * count / seconds_of(run)


def in_batch(batch: atoll.Batch, calls: int, count: int) -> float:
    def run() -> None:
        for _ in range(calls):
            batch.step(1 / 60, count)

    return len(batch) * calls * count / seconds_of(run)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--worlds", type=int, default=4096)
    options = parser.parse_args()

    steps = medians(
        options.repeats,
        python=lambda: steps_from_python(200),
        command=lambda: steps_of_command(options.command, 200),
    )
    print(f"{CONTACTS}: {steps['python']:.3f} ms a step from Python, {steps['command']:.3f} by the command")

    scene = atoll.load_scene(SCENE)
    separate = [scene.build() for _ in range(options.worlds)]
    one = atoll.Batch(scene, options.worlds, threads=1)
    two = atoll.Batch(scene, options.worlds, threads=2)
    warm = scene.build()
    rates = medians(
        options.repeats,
        separate=lambda: one_by_one(separate, 4),
        batch=lambda: in_batch(one, 4, 1),
        batch_of_four=lambda: in_batch(one, 1, 4),
        two_threads=lambda: in_batch(two, 4, 1),
        two_threads_of_four=lambda: in_batch(two, 1, 4),
        one_warm=lambda: 4 * 4096 / seconds_of(lambda: warm.steps(4 * 4096)),
    )
    for name, rate in rates.items():
        print(f"{name.replace('_', ' '):20} {rate:9.0f} world steps/s, {rate / rates['separate']:5.2f} x separate ones")

    half = np.arange(options.worlds) % 100 == 0
    reset = medians(
        options.repeats,
        step=lambda: 1e3 * seconds_of(lambda: one.step(1 / 60)),
        reset=lambda: 1e3 * seconds_of(lambda: one.reset(half)),
    )
    print(f"a step of all: {reset['step']:.1f} ms; a reset of 1%: {reset['reset']:.2f} ms")


if __name__ == "__main__":
    main()
