"""Runs the jobs of an ensemble on an engine: what is left of a plan, part by part, until all are done.

A part of a job that is lost is run again from the last snapshot, and comes to the same bits. All attempts are held to
each other by the hashes that they tell of the same steps, and some jobs are run once more by other workers. Where two
differ a third one decides; whoever is wrong is named and asked no more, and what it computed alone is set aside.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from .. import _core
from . import EnsembleError
from .engines import Answer, Call, Engine, LocalEngine, calls_at_a_time
from .job import FunctionError, LimitError, Part, Point, read_if_there, run_part, snapshot_path, state_path
from .plan import Job
from .store import Progress, Result, Store
from .table import row_of
from .whole_file import write_whole

#: Times in a row that a job's workers may be lost at the same step until it is given up.
MOST_LOSSES = 10
#: s, in which results are committed at least. A commit waits for the disk, 10 to 50 ms.
COMMIT_EVERY = 2.0


@dataclass(frozen=True)
class Options:
    interval: float = 10.0  #: s, after which a job's snapshot is saved: what may be lost of it
    verify: float = 0.01  #: the share of jobs that are run once more; of each worker the first one is as well
    shared: bool = True  #: workers read and write the folder themselves
    trust_all: bool = False  #: also those that computed other bits before
    job_seconds: float = 86400.0  #: of a worker, that a job may take until it is given up
    job_memory: int | None = None  #: bytes of data that its process may have; None: as many as there are


@dataclass
class Tally:
    """Of a run, for its report."""

    jobs: int = 0
    done_before: int = 0
    done: int = 0
    lost_parts: int = 0
    lost_seconds: float = 0.0  #: at most, that workers had spent on these
    longest_lost: float = 0.0  #: of these, on one
    begun_anew: int = 0
    compared: int = 0  #: jobs that two workers came to the same bits of
    set_aside: int = 0
    steps: int = 0
    step_seconds: float = 0.0
    call_seconds: float = 0.0  #: of workers, with scenes, errors and snapshots
    snapshot_seconds: float = 0.0
    snapshots: int = 0
    snapshot_bytes: int = 0


class Watcher(Protocol):
    def __call__(self, tally: Tally, under_way: int) -> None: ...


class DriverError(EnsembleError):
    """An ensemble that can't go on; what is done is kept."""


@dataclass(frozen=True)
class _Attempt:
    """At a job: the one that makes its result, or one after it that is to come to the same."""

    job: Job
    key: str
    at: Point | None = None  #: where it goes on
    workers: tuple[str, ...] = ()  #: that got it there
    seconds: float = 0.0
    losses: int = 0  #: in a row, at this point
    verifies: tuple[str, ...] = ()  #: who computed the result that it is held to

    @property
    def name(self) -> str:
        """Of its snapshots."""
        return f"{self.key}-check" if self.verifies else self.key


class Driver:
    """`jobs` are those of the plan, `store` knows which are done or begun."""

    def __init__(self, jobs: Iterable[Job], store: Store, engine: Engine, options: Options) -> None:
        self._store = store
        self._engine = engine
        self._options = options
        if options.trust_all:
            store.trust_all()
        self._distrusted = set(store.distrusted())
        self._met: set[str] = set()  # workers of which a job was verified, or is being
        self._waiting: deque[_Attempt] = deque()
        self._under_way: dict[int, _Attempt] = {}
        self._begun: dict[int, float] = {}  # s, of the clock, by ticket
        self._tickets = 0
        self._committed = time.monotonic()
        self._decider: LocalEngine | None = None
        self._obsolete: list[Path] = []  # snapshots, once what came after them is committed
        self.tally = Tally()
        self.given_up: list[str] = []
        self._jobs = {job.key: job for job in jobs}
        finished, progress = store.finished(), store.progress()
        self._finished = self._jobs.keys() & finished
        for key, job in self._jobs.items():
            if key not in finished:
                begun = progress.get(key, Progress(None, (), 0.0))
                self._waiting.append(_Attempt(job, key, begun.point, begun.workers, begun.seconds))
        self.tally.jobs = len(self._jobs)
        self.tally.done_before = len(self._finished)

    def keys(self) -> Collection[str]:
        """Of all jobs, in order."""
        return self._jobs

    def run(self, watch: Watcher, stop: Callable[[], bool]) -> bool:
        """Whether all was done: else `stop` told to end. Raises DriverError and StoreError."""
        try:
            while (self._waiting or self._under_way) and not stop():
                self._hand_out()
                self._take(self._engine.wait(0.2))
                if time.monotonic() - self._committed > min(COMMIT_EVERY, self._options.interval):
                    self._commit()
                watch(self.tally, len(self._under_way))
            stopped = bool(self._waiting or self._under_way)
            if stopped:
                self._take(self._engine.stop())
            return not stopped
        finally:
            if self._decider is not None:
                self._decider.close()
            self._commit()

    def _hand_out(self) -> None:
        while self._waiting and len(self._under_way) < calls_at_a_time(self._engine):
            attempt = self._trusted(self._waiting.popleft())
            if attempt is None:
                continue
            self._tickets += 1
            self._under_way[self._tickets] = attempt
            self._begun[self._tickets] = time.monotonic()
            avoid = self._distrusted | set(attempt.verifies)
            folder, snapshot = self._store.folder, None
            if not self._options.shared and attempt.at is not None:
                snapshot = read_if_there(snapshot_path(folder, attempt.name, attempt.at.step))
            arguments = (attempt.job, attempt.at, self._options.interval, str(folder) if self._options.shared else None,
                         snapshot, attempt.name, self._options.job_memory)  # fmt: skip
            prefer = attempt.workers[-1] if attempt.workers else ""
            left = max(0.0, self._options.job_seconds - attempt.seconds)
            self._engine.submit(Call(self._tickets, run_part, arguments, frozenset(avoid), prefer, left))

    def _take(self, answers: Iterable[Answer]) -> None:
        for answer in answers:
            attempt = self._under_way.pop(answer.ticket)
            since_submitted = time.monotonic() - self._begun.pop(answer.ticket)
            if answer.overran:
                self._give_up(attempt, f"{answer.lost} ({self._options.job_seconds:g} s a job)")
            elif answer.lost:
                self._lose(attempt, answer, answer.seconds or since_submitted)
            elif answer.worker in self._distrusted or self._trusted(attempt) is not attempt:
                self._waiting.appendleft(attempt)
            elif answer.error is not None:
                self._fail(attempt, answer)
            else:
                self._go_on(attempt, answer, answer.value)

    def _trusted(self, attempt: _Attempt) -> _Attempt | None:
        """From the beginning, where a worker that is distrusted got it to where it is."""
        if attempt.verifies and (self._distrusted & set(attempt.verifies) or attempt.key not in self._finished):
            return None
        if self._distrusted & set(attempt.workers):
            return replace(attempt, at=None, workers=(), seconds=0.0)
        return attempt

    def _lose(self, attempt: _Attempt, answer: Answer, spent: float) -> None:
        if attempt.verifies and answer.refused:
            return
        self.tally.lost_parts += 1
        self.tally.lost_seconds += spent
        self.tally.longest_lost = max(self.tally.longest_lost, spent)
        step = attempt.at.step if attempt.at else 0
        self._store.note("lost", f"{attempt.key} from step {step}, {spent:.2f} s: {answer.lost}")
        if attempt.losses + 1 < MOST_LOSSES:
            self._waiting.appendleft(replace(attempt, losses=attempt.losses + 1))
        else:
            self._give_up(attempt, f"lost {MOST_LOSSES} times in a row from step {step}: {answer.lost}")

    def _give_up(self, attempt: _Attempt, why: str) -> None:
        """It gets no row: with more time or other workers it may come to an end."""
        if not attempt.verifies:
            self._store.note("given up", f"{attempt.key}: {why}")
            self.given_up.append(f"{attempt.key}: {why}")

    def _fail(self, attempt: _Attempt, answer: Answer) -> None:
        error = answer.error
        if isinstance(error, LimitError):
            self._give_up(attempt, str(error))
            return
        if not isinstance(error, (_core.Error, FunctionError)):
            what = error if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
            raise DriverError(f"{attempt.key} on {answer.worker}: {what}")
        # The job's inputs caused this error: another attempt would end in the same way.
        if not attempt.verifies:
            self._finish(attempt, (answer.worker,), row_of(attempt.job, "failed", str(error), {}))

    def _go_on(self, attempt: _Attempt, answer: Answer, part: Part) -> None:
        self._count(answer, part)
        for text in part.notes:
            self._store.note("snapshot", text)
        if attempt.at is not None and part.first < attempt.at.step:
            self.tally.begun_anew += 1
            attempt = replace(attempt, workers=(), seconds=0.0)
        workers = tuple(dict.fromkeys([*attempt.workers, answer.worker]))
        moved = replace(attempt, at=part.last, workers=workers, losses=0, seconds=attempt.seconds + answer.seconds)
        differing = self._store.differing(attempt.key, part.checks, answer.worker)
        if differing is not None:
            self._decide(moved, answer.worker, *differing)
        elif part.result is None:
            self._keep_snapshot(snapshot_path(self._store.folder, attempt.name, part.last.step), part)
            if attempt.at is not None:
                self._obsolete.append(snapshot_path(self._store.folder, attempt.name, attempt.at.step))
            if not attempt.verifies:
                self._store.put_series(attempt.key, part.series)
                self._store.put_progress(attempt.key, Progress(part.last, workers, moved.seconds))
            self._waiting.appendleft(moved)
        else:
            if attempt.at is not None:
                self._obsolete += (self._store.folder / "snapshots").glob(f"{attempt.name}.*")
            if attempt.verifies:
                self.tally.compared += 1
                self._store.mark_checked(attempt.key, ", ".join(workers))
                return
            self._keep_snapshot(state_path(self._store.folder, attempt.key), part)
            self._store.put_series(attempt.key, part.series)
            self._finish(moved, workers, row_of(attempt.job, "done", "", part.result))
            self._verify(moved)

    def _keep_snapshot(self, path: Path, part: Part) -> None:
        if part.snapshot is not None:
            try:
                write_whole(path, part.snapshot)
            except OSError as error:
                raise DriverError(f"{path}: can't be written: {error.strerror}") from None

    def _finish(self, attempt: _Attempt, workers: tuple[str, ...], row: dict[str, Any]) -> None:
        self._store.put_result(attempt.key, Result(", ".join(workers), "", attempt.seconds, row))
        self._finished.add(attempt.key)
        self.tally.done += 1

    def _verify(self, attempt: _Attempt) -> None:
        share = self._options.verify
        new = not set(attempt.workers) <= self._met
        if share > 0 and self._engine.places() > 1 and (new or int(attempt.key[:8], 16) < share * 2**32):
            self._met |= set(attempt.workers)
            self._waiting.append(_Attempt(attempt.job, attempt.key, verifies=attempt.workers))

    def _decide(self, attempt: _Attempt, worker: str, point: Point, other: str) -> None:
        """Finds out who is wrong, of two workers that came to different states, by a new process of this machine."""
        key = attempt.key
        self._store.note("differ", f"{key}: {worker} and {other} differ in the state after step {point.step}")
        wrong = {worker, other}
        decided = self._decided(attempt) if worker != other or attempt.job.code else []
        if attempt.job.code and decided != self._decided(attempt):
            self._blame_function(attempt, point)
            return
        if worker != other:
            hashes = {check.step: check.hash for check in decided}
            if hashes.get(point.step) == point.hash:
                wrong = {other}
            elif hashes.get(point.step) == self._store.hash_of(key, point.step):
                wrong = {worker}
        for name in sorted(wrong):
            self._distrust(name, f"{key}: came to another state after step {point.step}")
        if key not in self._finished:
            self._begin_anew(key)

    def _blame_function(self, attempt: _Attempt, point: Point) -> None:
        """One process came to two states of the same inputs, so it is a function of the plan that does not go by them."""
        job, key = attempt.job, attempt.key
        functions = " or ".join(filter(None, (job.setup, job.observe)))
        why = f"{functions}: two runs of one process differ in the state after step {point.step}; expected the same of the same"
        self.tally.set_aside += key in self._finished
        self._store.drop(key)
        self._finish(attempt, attempt.workers, row_of(job, "failed", why, {}))

    def _decided(self, attempt: _Attempt) -> list[Point]:
        if self._decider is None:
            self._decider = LocalEngine(1, "decider")
        self._decider.submit(Call(0, run_part, (attempt.job, None, math.inf, None, None, f"{attempt.key}-decide"),
                                  limit=self._options.job_seconds))  # fmt: skip
        answers: list[Answer] = []
        while not answers:
            answers = self._decider.wait(1.0)
        if isinstance(answers[0].value, Part):
            return answers[0].value.checks
        raise DriverError(f"{attempt.key}: who is wrong can't be decided: {answers[0].lost or answers[0].error}")

    def _distrust(self, worker: str, why: str) -> None:
        self._distrusted.add(worker)
        self._store.distrust(worker, why)
        self._store.note("distrusted", f"{worker}: {why}")
        for key, result in self._store.results().items():
            if worker in result.worker.split(", ") and not result.checked_by:
                self.tally.set_aside += 1
                self._begin_anew(key)
        for key, progress in self._store.progress().items():
            if worker in progress.workers:
                self._store.drop(key)

    def _begin_anew(self, key: str) -> None:
        self._store.drop(key)
        self._finished.discard(key)
        at_work = [attempt for attempt in (*self._waiting, *self._under_way.values()) if not attempt.verifies]
        if key in self._jobs and all(attempt.key != key for attempt in at_work):
            self._waiting.append(_Attempt(self._jobs[key], key))

    def _count(self, answer: Answer, part: Part) -> None:
        tally = self.tally
        tally.steps += part.last.step - part.first
        tally.step_seconds += part.seconds
        tally.call_seconds += answer.seconds
        tally.snapshot_seconds += part.snapshot_seconds
        tally.snapshots += part.snapshot_bytes > 0
        tally.snapshot_bytes += part.snapshot_bytes

    def _commit(self) -> None:
        self._store.commit()
        for path in self._obsolete:
            path.unlink(missing_ok=True)
        self._obsolete.clear()
        self._committed = time.monotonic()
