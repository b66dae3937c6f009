"""Many runs of a plan that survive whatever happens to their workers: see `atoll.ensemble`."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .engines import Engine


class EnsembleError(Exception):
    """An ensemble that can't go on, as a folder or an engine can't be used. What is done is kept."""


def ensemble(
    plan: str | Path | Mapping[str, Any],
    *,
    out: str | Path | None = None,
    engine: str | Engine = "local",
    workers: int | None = None,
    address: str | None = None,
    interval: float = 10.0,
    verify: float = 0.01,
    shared: bool = True,
    job_seconds: float = 86400.0,
    job_memory: int | None = None,
) -> Any:
    """Runs the jobs of a plan, and gives a pandas.DataFrame with a row a job, in the order of the plan.

    `plan`: a JSON file, or what one holds; the guide of the package tells what. `out`: a folder of what is done, from
    which the same call goes on after a crash; a temporary one by default. `engine`: "local", processes of this machine,
    or "ray", a cluster at `address`. `workers`: jobs at a time, by default one a core. `interval`: s, until a job's
    snapshot is saved, which is what may be lost of it. `verify`: the share of jobs that are run once more, by another
    worker. `shared`: whether all workers see `out`. `job_seconds`, `job_memory`: what a job may take of a worker's time
    (s) and memory (bytes, by default as much as there is) until it is given up, without a row.

    The frame is the same however its jobs were run. Raises Error on a plan that can't be run, and EnsembleError where
    the folder or the engine can't be used; what is done is kept.
    """
    from .driver import Options
    from .run import run_ensemble

    with tempfile.TemporaryDirectory(prefix="atoll-") as temporary:
        folder = Path(out) if out is not None else Path(temporary)
        options = Options(interval, verify, shared, job_seconds=job_seconds, job_memory=job_memory)
        outcome = run_ensemble(plan, folder, engine=engine, workers=workers, address=address, options=options)
        assert outcome.table is not None
        return outcome.table.frame()
