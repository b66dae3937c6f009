"""`atoll ensemble PLAN.json --out DIR`, which the command hands over to `python -m atoll ensemble`."""

from __future__ import annotations

import argparse
import math
import shutil
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from .. import _core
from . import EnsembleError
from .driver import Options, Tally
from .plan import PlanError, read_plan
from .run import ENGINES, Outcome, gather, run_ensemble
from .slurm import how_to_submit, write_script

_DONE, _FAILED, _BAD_PLAN = 0, 1, 3


def main(words: Sequence[str]) -> int:
    given = _parser().parse_args(words)
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda came, _: _note(signals, came))
    try:
        return _run(given, signals)
    except (PlanError, _core.SceneError) as error:
        return _say(error, _BAD_PLAN)
    except EnsembleError as error:
        return _say(error, _FAILED)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="atoll ensemble",
        description="Runs the jobs of a plan: scenes with parameters and seeds. What is done is kept, so that the same "
        "command goes on after a crash or Ctrl-C. Writes a table with a row a job, the same to the byte however it was run.",
    )
    parser.add_argument("plan", metavar="PLAN.json", type=Path)
    parser.add_argument("--out", metavar="DIR", type=Path, required=True, help="folder of results, made if missing")
    parser.add_argument("--engine", choices=[*ENGINES, "slurm"], default="local",
                        help="processes of this machine; a Ray cluster; or a script for Slurm is written (default local)")
    parser.add_argument("--workers", metavar="N", type=_count, help="jobs at a time (default: one a core, with Slurm one a task)")
    parser.add_argument("--address", metavar="HOST:PORT", help="of the Ray cluster (default: RAY_ADDRESS, or this machine alone)")
    parser.add_argument("--interval", metavar="S", type=_seconds, default=10.0,
                        help="seconds until a job's snapshot is saved: what may be lost of it (default 10)")
    parser.add_argument("--verify", metavar="SHARE", type=_share, default=0.01,
                        help="of jobs that are run once more by another worker (default 0.01; the first of each is as well)")
    parser.add_argument("--trust-all", action="store_true",
                        help="ask workers again that computed other bits before: what was wrong is mended")
    parser.add_argument("--job-time", metavar="S", type=_seconds_of_job, default=86400.0,
                        help="seconds of a worker until a job is given up, without a row (default 86400, a day)")
    parser.add_argument("--job-memory", metavar="MB", type=_megabytes,
                        help="MB of data that a job's process may have until it is given up (default: what there is)")
    parser.add_argument("--not-shared", action="store_true",
                        help="DIR is not on a folder that all workers share: snapshots go through the engine")
    parser.add_argument("--slurm-option", metavar="OPTION", action="append", default=[],
                        help='of sbatch, as "--slurm-option=--time=02:00:00"; may be given several times')
    parser.add_argument("--tasks", metavar="N", type=_count, default=10, help="of Slurm's array (default 10)")
    parser.add_argument("--part", metavar="I/N", type=_part, help="run only jobs I, I + N, ... (I from 0)")
    parser.add_argument("--gather", action="store_true", help="write the table of all parts, and run nothing")
    parser.add_argument("--csv-only", action="store_true", help="write no Parquet (default: where PyArrow is installed)")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    return parser


def _run(given: argparse.Namespace, signals: list[int]) -> int:
    parquet = False if given.csv_only else None
    if given.gather:
        table, files, missing = gather(given.plan, given.out, parquet)
        print(f"{len(table.rows)} jobs: {', '.join(map(str, files))}")
        return _say(f"{missing} jobs have no result yet", _FAILED) if missing else _DONE
    if given.engine == "slurm":
        return _write_slurm(given)
    with _Progress(not given.quiet and sys.stderr.isatty()) as progress:
        outcome = run_ensemble(
            given.plan,
            given.out,
            engine=given.engine,
            workers=given.workers,
            address=given.address,
            options=_options(given),
            parquet=parquet,
            part=given.part,
            watch=progress,
            stop=lambda: bool(signals),
        )
    _report(outcome)
    if not outcome.finished:
        name = signal.Signals(signals[0]).name
        return _say(f"interrupted by {name} after {outcome.done} of {outcome.jobs} jobs; the same command goes on", 128 + signals[0])
    return _FAILED if outcome.given_up or outcome.failed or outcome.distrusted else _DONE


def _options(given: argparse.Namespace) -> Options:
    return Options(
        interval=given.interval,
        verify=given.verify,
        shared=not given.not_shared,
        trust_all=given.trust_all,
        job_seconds=given.job_time,
        job_memory=None if given.job_memory is None else 1_000_000 * given.job_memory,
    )


def _write_slurm(given: argparse.Namespace) -> int:
    read_plan(given.plan)
    script = write_script(
        given.plan,
        given.out,
        tasks=given.tasks,
        workers=given.workers or 1,
        command=[sys.executable, "-m", "atoll"],
        options=given.slurm_option,
    )
    print(how_to_submit(script), end="")
    return _DONE


def _report(outcome: Outcome) -> None:
    tally = outcome.tally
    before = f", {tally.done_before} of them before" if tally.done_before else ""
    print(f"{outcome.done} of {outcome.jobs} jobs done{before}; {outcome.failed} failed")
    if tally.done:
        busy = max(tally.call_seconds, 1e-9)
        print(
            f"{tally.done} in {outcome.seconds:.1f} s: {tally.done / outcome.seconds:.3g} a second; workers were busy for "
            f"{busy:.1f} s, {100 * tally.step_seconds / busy:.1f}% of it with steps, {100 * tally.snapshot_seconds / busy:.2f}% "
            f"with snapshots"
        )
    if tally.lost_parts or tally.begun_anew or tally.compared:
        print(
            f"{tally.lost_parts} parts of {tally.lost_seconds:.1f} s lost and run again, {tally.longest_lost:.2f} s at most; "
            f"{tally.begun_anew} jobs begun anew, {tally.compared} held to a second run"
        )
    for worker, why in outcome.distrusted:
        _say(f"{worker} computes other bits and is not asked any more: {why}", 0)
    for why in outcome.given_up:
        _say(f"given up: {why}", 0)
    for path in outcome.files:
        print(path)


class _Progress:
    """A line on a terminal."""

    def __init__(self, shown: bool) -> None:
        self._shown = shown
        self._begin = self._last = time.monotonic()

    def __enter__(self) -> _Progress:
        return self

    def __exit__(self, *reason: object) -> None:
        if self._shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    def __call__(self, tally: Tally, under_way: int) -> None:
        now = time.monotonic()
        if not self._shown or now - self._last < 0.2:
            return
        self._last = now
        done = tally.done_before + tally.done - tally.set_aside
        rate = tally.done / (now - self._begin)
        left = f"{_span((tally.jobs - done) / rate)} left" if rate > 0 else "..."
        line = f"{done} of {tally.jobs} jobs, {under_way} under way, {rate:.3g} a second, {left}"
        print("\r\033[K" + line[: shutil.get_terminal_size().columns - 1], end="", file=sys.stderr, flush=True)


def _span(seconds: float) -> str:
    if seconds < 90:
        return f"{math.ceil(seconds)} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def _note(signals: list[int], came: int) -> None:
    if signals:
        # The second one ends the process at once.
        signal.signal(came, signal.SIG_DFL)
        signal.raise_signal(came)
    signals.append(came)


def _say(what: object, status: int) -> int:
    print(f"atoll: {what}", file=sys.stderr)
    return status


def _number(kind: type[int] | type[float], lowest: float, highest: float, expected: str) -> Callable[[str], float]:
    """A type of argparse's, for numbers of a range."""

    def number(text: str) -> float:
        value = kind(text)
        if not lowest <= value <= highest:
            raise argparse.ArgumentTypeError(f"found {text}; expected {expected}")
        return value

    return number


_count = _number(int, 1, 100_000, "an integer from 1 to 100000")
_seconds = _number(float, 0.01, 86400, "0.01 to 86400")
_seconds_of_job = _number(float, 0.01, 1e9, "0.01 to 1000000000")
_megabytes = _number(int, 1, 1_000_000_000, "an integer from 1 to 1000000000")
_share = _number(float, 0, 1, "0 to 1")


def _part(text: str) -> tuple[int, int]:
    part, slash, of = text.partition("/")
    if not (slash and part.isdigit() and of.isdigit() and int(part) < int(of)):
        raise argparse.ArgumentTypeError(f"found {text}; expected I/N, with I from 0 to N - 1")
    return int(part), int(of)
