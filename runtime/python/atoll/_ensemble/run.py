"""An ensemble from a plan to its table: what `atoll.ensemble()` and the command `atoll ensemble` have in common."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .driver import Driver, Options, Tally, Watcher
from .engines import Engine, EngineError, LocalEngine
from .job import Moment
from .plan import Plan, PlanError, read_plan
from .store import Store, StoreError, read_results, read_series
from .table import Table, has_parquet, make_series, make_table

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
    files: list[Path]
    table: Table | None  #: of a whole plan


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
        done = [results[key] for key in driver.keys() if key in results]
        tables: dict[str, Table] = {}
        if part is None:
            series = store.series(driver.keys()) if read.keep.series else {}
            tables = _tables(read, driver.keys(), results, series)
        return Outcome(
            tally=driver.tally,
            finished=finished,
            jobs=len(driver.keys()),
            done=len(done),
            failed=sum(row["outcome"] != "done" for row in done),
            given_up=driver.given_up,
            distrusted=list(store.distrusted().items()),
            seconds=time.perf_counter() - begin,
            files=_write(tables, out, parquet),
            table=tables.get("results.csv"),
        )
    finally:
        store.close()


def gather(plan: str | Path | Mapping[str, Any], out: Path, parquet: bool | None = None) -> tuple[Table, list[Path], int]:
    """Writes the table of all shares of a plan that were run; how many jobs have none yet. Raises PlanError, StoreError."""
    read = read_plan(plan)
    rows: dict[str, Mapping[str, Any]] = {}
    series: dict[str, list[Moment]] = {}
    for path in [*sorted((out / "parts").glob("*.db")), *filter(Path.exists, [out / "ensemble.db"])]:
        found = read_results(path)
        for key, result in found.items():
            if rows.setdefault(key, result.row) != result.row:
                raise StoreError(f"{path}: tells of job {key} what another share doesn't; expected the same of all")
        if read.keep.series:
            series |= read_series(path, found)
    keys = dict.fromkeys(job.key for job in read.jobs())
    tables = _tables(read, keys, rows, series)
    table = tables["results.csv"]
    return table, _write(tables, out, _wants_parquet(parquet)), len(keys) - len(table.rows)


def _tables(
    plan: Plan, keys: Collection[str], results: Mapping[str, Mapping[str, Any]], series: Mapping[str, list[Moment]]
) -> dict[str, Table]:
    """By the names of their files."""
    tables = {"results.csv": make_table(plan, keys, results)}
    if plan.keep.series:
        tables["series.csv"] = make_series(keys, results, series)
    return tables


def _write(tables: Mapping[str, Table], out: Path, parquet: bool) -> list[Path]:
    try:
        return [path for name, table in tables.items() for path in table.write(out / name, parquet)]
    except OSError as error:
        raise StoreError(f"{error.filename or out}: the table can't be written: {error.strerror}; results are kept") from None


def _wants_parquet(given: bool | None) -> bool:
    if given and not has_parquet():
        raise PlanError('a table in Parquet takes PyArrow: pip install "atoll[ensemble]"')
    return has_parquet() if given is None else given
