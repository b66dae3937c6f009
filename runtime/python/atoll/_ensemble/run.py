"""An ensemble from a plan to its table: what `atoll.ensemble()` and the command `atoll ensemble` have in common."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .. import _core
from .driver import Driver, Options, Tally, Watcher
from .engines import Engine, EngineError, LocalEngine
from .plan import Plan, PlanError, read_plan
from .store import Store, StoreError, read_results
from .table import Table, has_parquet, make_table

ENGINES = ("local", "ray")


@dataclass(frozen=True)
class Outcome:
    """Of a run of an ensemble."""

    tally: Tally
    finished: bool  #: else it was stopped
    jobs: int
    done: int  #: of all jobs, in this run or before
    failed: int  #: of these: Atoll refused their inputs, or a function of the plan raised
    given_up: list[str]  #: why there is no result of a job, in this run
    distrusted: list[tuple[str, str]]  #: workers that computed other bits, and what
    seconds: float
    files: list[Path] = field(default_factory=list)
    table: Table | None = None


def make_engine(engine: str | Engine, workers: int | None, address: str | None) -> Engine:
    """Raises EngineError."""
    if not isinstance(engine, str):
        return engine
    if workers is not None and workers < 1:
        raise EngineError(f"workers is {workers}; expected 1 or more")
    if engine == "local":
        if address is not None:
            raise EngineError(f'found the address "{address}" for processes of this machine; expected it with the engine "ray"')
        return LocalEngine(workers)
    if engine == "ray":
        from .ray_engine import RayEngine  # Ray is large, and not everybody's

        return RayEngine(address, workers)
    raise EngineError(f'found the engine "{engine}"; expected one of {", ".join(ENGINES)}')


def run_ensemble(
    plan: str | Path | Mapping[str, Any],
    out: Path,
    *,
    engine: str | Engine = "local",
    workers: int | None = None,
    address: str | None = None,
    options: Options,
    parquet: bool | None = None,
    part: tuple[int, int] | None = None,
    watch: Watcher = lambda tally, under_way: None,
    stop: Callable[[], bool] = lambda: False,
) -> Outcome:
    """Runs what is left of a plan, and writes the table of what is done. `part` is which of how many shares of the jobs
    this is of, whose table is written by `gather`. Raises PlanError, SceneError, EngineError, StoreError, DriverError.
    """
    begin = time.perf_counter()
    read = read_plan(plan)
    parquet = _wants_parquet(parquet)
    if (read.keep.state or read.keep.recording) and not options.shared:
        raise PlanError("keep: states and recordings are written by workers; expected a folder that is shared with them")
    out = out.absolute()  # workers may be in other folders
    store = Store(out, f"{part[0]}" if part else "")
    try:
        jobs = (job for number, job in enumerate(read.jobs()) if part is None or number % part[1] == part[0])
        used = make_engine(engine, workers, address)
        try:
            driver = Driver(jobs, store, used, options)
            finished = driver.run(watch, stop)
        finally:
            if used is not engine:
                used.close()
        results = {key: result.row for key, result in store.results().items()}
        distrusted = [(what.partition(": ")[0], what.partition(": ")[2]) for kind, what in store.events() if kind == "distrusted"]
        outcome = _outcome(read if part is None else None, driver, finished, results, distrusted, time.perf_counter() - begin)
        return outcome if part else _written(outcome, out, parquet)
    finally:
        store.close()


def gather(plan: str | Path | Mapping[str, Any], out: Path, parquet: bool | None = None) -> tuple[Table, list[Path], int]:
    """Writes the table of all shares of a plan that were run; how many jobs have none yet. Raises PlanError, StoreError."""
    read = read_plan(plan)
    rows: dict[str, Mapping[str, Any]] = {}
    for path in [*sorted((out / "parts").glob("*.db")), *filter(Path.exists, [out / "ensemble.db"])]:
        for key, result in read_results(path).items():
            if rows.setdefault(key, result.row) != result.row:
                raise StoreError(f"{path}: tells of job {key} what another share doesn't; expected the same of all")
    table = make_table(read, rows)
    missing = len({job.key for job in read.jobs()}) - len(table.rows)
    return table, _write(table, out, _wants_parquet(parquet)), missing


def _outcome(plan: Plan | None, driver: Driver, finished: bool, results: Mapping[str, Mapping[str, Any]],
             distrusted: list[tuple[str, str]], seconds: float) -> Outcome:
    mine = [results[key] for key in driver.keys() if key in results]
    failed = sum(row["outcome"] != "done" for row in mine)
    table = make_table(plan, results) if plan is not None else None
    return Outcome(driver.tally, finished, driver.tally.jobs, len(mine), failed, driver.given_up, distrusted, seconds, [], table)


def _written(outcome: Outcome, out: Path, parquet: bool) -> Outcome:
    assert outcome.table is not None
    outcome.files.extend(_write(outcome.table, out, parquet))
    return outcome


def _write(table: Table, out: Path, parquet: bool) -> list[Path]:
    try:
        return table.write(out, parquet)
    except OSError as error:
        raise StoreError(f"{error.filename or out}: the table can't be written: {error.strerror}; results are kept") from None


def _wants_parquet(given: bool | None) -> bool:
    if given and not has_parquet():
        raise PlanError('a table in Parquet takes PyArrow: pip install "atoll[ensemble]"')
    return has_parquet() if given is None else given
