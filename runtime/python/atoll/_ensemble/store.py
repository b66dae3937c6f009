"""What lasts of an ensemble: results, how far jobs are, and what happened, in an SQLite file with one writer.

A result is written once, with all that the table tells of it. What is not committed as a process is killed is computed
again, and comes to the same.
"""

from __future__ import annotations

import fcntl
import json
import os
import sqlite3
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import EnsembleError
from .job import FIRST_COLUMNS, Moment, Point

_VERSION = 1
_SCHEMA = """
CREATE TABLE IF NOT EXISTS results (
  key TEXT PRIMARY KEY, worker TEXT NOT NULL, checked_by TEXT NOT NULL, seconds REAL NOT NULL, row TEXT NOT NULL
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS progress (
  key TEXT PRIMARY KEY, step INTEGER NOT NULL, hash TEXT NOT NULL, workers TEXT NOT NULL, seconds REAL NOT NULL
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS checks (
  key TEXT NOT NULL, step INTEGER NOT NULL, hash TEXT NOT NULL, worker TEXT NOT NULL, PRIMARY KEY (key, step)
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS series (
  key TEXT NOT NULL, step INTEGER NOT NULL, row TEXT NOT NULL, PRIMARY KEY (key, step)
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS distrusted (worker TEXT PRIMARY KEY, why TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS events (time REAL NOT NULL, kind TEXT NOT NULL, what TEXT NOT NULL);
"""


class StoreError(EnsembleError):
    """The folder of an ensemble can't be used; what is in it stays as it is."""


@dataclass(frozen=True)
class Progress:
    """How far a job is that is not done."""

    point: Point | None
    workers: tuple[str, ...]  #: that computed it
    seconds: float


@dataclass(frozen=True)
class Result:
    worker: str  #: those that computed it, by commas
    checked_by: str  #: who came to the same, or ""
    seconds: float
    row: dict[str, Any]


@contextmanager
def _reading(path: Path, doing: str = "read") -> Iterator[None]:
    """Raises StoreError where what is read can't be, or is not what was written."""
    try:
        yield
    except sqlite3.Error as error:
        raise StoreError(f"{path}: can't be {doing}: {error}") from None
    except (ValueError, TypeError, OverflowError) as error:
        raise StoreError(
            f"{path}: is damaged: found {error}; expected what an ensemble wrote: with the file moved away, all begins anew"
        ) from None


class Store:
    """`part` is of those that several processes, with a store each, make of one plan."""

    def __init__(self, folder: Path, part: str = "") -> None:
        self.folder = folder
        self.path = folder / "parts" / f"{part}.db" if part else folder / "ensemble.db"
        try:
            for name in ("snapshots", "states", "recordings", "parts"):
                (folder / name).mkdir(parents=True, exist_ok=True)
            self._lock = open(self.path.with_suffix(".lock"), "a")
        except OSError as error:
            raise StoreError(f"{error.filename or folder}: can't be written: {error.strerror}") from None
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise StoreError(f"{folder}: another process runs this ensemble; expected it to end first") from None
        self._database = _open(self.path)
        if not part:
            for left in (folder / "snapshots").glob("*.part"):
                left.unlink(missing_ok=True)

    def close(self) -> None:
        self._database.close()
        self._lock.close()

    def commit(self) -> None:
        """Raises StoreError where the disk is full, or fails: what was committed before is kept."""
        try:
            self._database.commit()
        except (sqlite3.Error, UnicodeDecodeError) as error:  # the latter on names in SQLite's message
            raise StoreError(f"{self.path}: can't be written: {error}") from None

    def note(self, kind: str, what: str) -> None:
        self._write("INSERT INTO events VALUES (?, ?, ?)", (time.time(), kind, what))

    def events(self) -> list[tuple[str, str]]:
        with _reading(self.path):
            return list(self._database.execute("SELECT kind, what FROM events ORDER BY rowid"))

    def results(self) -> dict[str, Result]:
        with _reading(self.path):
            return dict(_results(self._database))

    def finished(self) -> set[str]:
        """Keys of jobs with a result."""
        with _reading(self.path):
            return {key for (key,) in self._database.execute("SELECT key FROM results")}

    def put_result(self, key: str, result: Result) -> None:
        row = json.dumps(result.row)
        self._write("INSERT INTO results VALUES (?, ?, ?, ?, ?)", (key, result.worker, result.checked_by, result.seconds, row))
        self._write("DELETE FROM progress WHERE key = ?", (key,))

    def mark_checked(self, key: str, by: str) -> None:
        self._write("UPDATE results SET checked_by = ? WHERE key = ?", (by, key))

    def drop(self, key: str) -> None:
        """All that is known of a job: it begins anew."""
        for table in ("results", "progress", "checks", "series"):
            self._write(f"DELETE FROM {table} WHERE key = ?", (key,))

    def progress(self) -> dict[str, Progress]:
        with _reading(self.path):
            rows = self._database.execute("SELECT key, step, hash, workers, seconds FROM progress")
            return {
                key: Progress(Point(int(step), int(state, 16)), tuple(map(str, json.loads(workers))), float(seconds))
                for key, step, state, workers, seconds in rows
            }

    def put_progress(self, key: str, progress: Progress) -> None:
        point = progress.point or Point(0, 0)
        values = (key, point.step, f"{point.hash:016x}", json.dumps(progress.workers), progress.seconds)
        self._write("INSERT OR REPLACE INTO progress VALUES (?, ?, ?, ?, ?)", values)

    def put_series(self, key: str, series: Iterable[Moment]) -> None:
        """Some of a job's moments, which may be known."""
        for moment in series:
            self._write("INSERT OR REPLACE INTO series VALUES (?, ?, ?)", (key, moment.step, json.dumps(moment.observed)))

    def series(self, keys: Iterable[str]) -> dict[str, list[Moment]]:
        """Of each of these jobs."""
        with _reading(self.path):
            return dict(_series(self._database, keys))

    def differing(self, key: str, points: Iterable[Point], worker: str) -> tuple[Point, str] | None:
        """Keeps the hashes that a worker came to; the first that another one had come to otherwise, and which that is."""
        for point in points:
            known = self._check(key, point.step)
            if known is None:
                self._write("INSERT INTO checks VALUES (?, ?, ?, ?)", (key, point.step, f"{point.hash:016x}", worker))
            elif known[0] != point.hash:
                return point, known[1]
        return None

    def hash_of(self, key: str, step: int) -> int | None:
        known = self._check(key, step)
        return None if known is None else known[0]

    def _check(self, key: str, step: int) -> tuple[int, str] | None:
        """A hash, and the worker that told it."""
        with _reading(self.path):
            found = self._database.execute("SELECT hash, worker FROM checks WHERE key = ? AND step = ?", (key, step)).fetchone()
            return None if found is None else (int(found[0], 16), str(found[1]))

    def distrusted(self) -> dict[str, str]:
        """Why, by worker."""
        with _reading(self.path):
            return dict(self._database.execute("SELECT worker, why FROM distrusted"))

    def distrust(self, worker: str, why: str) -> None:
        self._write("INSERT OR REPLACE INTO distrusted VALUES (?, ?)", (worker, why))
        self._write("DELETE FROM checks WHERE worker = ?", (worker,))

    def trust_all(self) -> None:
        self._write("DELETE FROM distrusted", ())

    def _write(self, statement: str, values: tuple[object, ...]) -> None:
        try:
            self._database.execute(statement, values)
        except (sqlite3.Error, UnicodeDecodeError) as error:  # the latter on names in SQLite's message
            raise StoreError(f"{self.path}: can't be written: {error}") from None


def read_results(path: Path) -> dict[str, Result]:
    """Of a store that may be written to at the same time."""
    with _reading(path), sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True) as database:
        return dict(_results(database))


def _results(database: sqlite3.Connection) -> Iterator[tuple[str, Result]]:
    for key, worker, checked_by, seconds, row in database.execute("SELECT * FROM results"):
        observed = _object(row)
        if not observed.keys() >= set(FIRST_COLUMNS):
            raise ValueError(f"a row of {', '.join(observed)}")
        yield str(key), Result(str(worker), str(checked_by), float(seconds), observed)


def read_series(path: Path, keys: Iterable[str]) -> dict[str, list[Moment]]:
    """Of a store that may be written to at the same time."""
    with _reading(path), sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True) as database:
        return dict(_series(database, keys))


def _series(database: sqlite3.Connection, keys: Iterable[str]) -> Iterator[tuple[str, list[Moment]]]:
    for key in keys:
        rows = database.execute("SELECT step, row FROM series WHERE key = ? ORDER BY step", (key,))
        yield key, [Moment(int(step), _object(row)) for step, row in rows]


def _object(text: str) -> dict[str, Any]:
    found = json.loads(text)
    if not isinstance(found, dict):
        raise ValueError(f"{found!r} for an object")
    return found


def _open(path: Path) -> sqlite3.Connection:
    with _reading(path, "opened"):
        database = sqlite3.connect(path, timeout=30)
        # Readers see whole commits, which last once they return. A rollback journal is safe on shared folders as well.
        database.execute("PRAGMA synchronous = FULL")
        [(version,)] = database.execute("PRAGMA user_version")
        if version not in (0, _VERSION):
            raise StoreError(f"{path}: is of version {version}; expected {_VERSION}")
        database.executescript(_SCHEMA)
        database.execute(f"PRAGMA user_version = {_VERSION}")
        database.commit()
    return database
