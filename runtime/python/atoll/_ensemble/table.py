"""The tables of an ensemble, as CSV and Parquet: a row a job in the order of the plan, and a row a moment of each.

They hold only what a job determines, so they are the same to the byte however the jobs were run.
"""

from __future__ import annotations

import csv
import importlib
import importlib.util
import io
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .job import FIRST_COLUMNS, Moment
from .plan import Job, Plan
from .whole_file import write_whole


@dataclass(frozen=True)
class Table:
    columns: list[str]
    rows: list[dict[str, Any]]

    def write(self, path: Path, parquet: bool) -> list[Path]:
        """As CSV under this path and, if asked for, as Parquet beside it, each whole or as it was. Raises OSError."""
        files = {path: self._csv()}
        if parquet:
            files[path.with_suffix(".parquet")] = self._parquet()
        for path, content in files.items():
            write_whole(path, content, lasting=True)
        return list(files)

    def frame(self) -> Any:
        """A pandas.DataFrame. Raises ImportError where pandas is not installed."""
        return importlib.import_module("pandas").DataFrame(self.rows, columns=self.columns)

    def _csv(self) -> bytes:
        text = io.StringIO(newline="")
        writer = csv.DictWriter(text, self.columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: _cell(value) for name, value in row.items()} for row in self.rows)
        return text.getvalue().encode()

    def _parquet(self) -> bytes:
        pa: Any = importlib.import_module("pyarrow")
        parquet: Any = importlib.import_module("pyarrow.parquet")
        columns = {name: _column([row[name] for row in self.rows]) for name in self.columns}
        sink = pa.BufferOutputStream()
        parquet.write_table(pa.table(columns), sink)
        content: bytes = sink.getvalue().to_pybytes()
        return content


def make_table(plan: Plan, keys: Collection[str], results: Mapping[str, Mapping[str, Any]]) -> Table:
    """Of those jobs of a plan, whose keys come in its order, that are done: rows by key, as `row_of` makes them."""
    found = {key: results[key] for key in keys if key in results}
    observed = dict.fromkeys(name for row in found.values() for name in row)
    columns = list(dict.fromkeys([*FIRST_COLUMNS, *plan.parameters(), *(name for name in observed if name not in FIRST_COLUMNS)]))
    return Table(columns, [{name: found[key].get(name) for name in columns} for key in keys if key in found])


def make_series(keys: Iterable[str], results: Mapping[str, Mapping[str, Any]], series: Mapping[str, list[Moment]]) -> Table:
    """Of jobs that came to their end."""
    whole = [key for key in keys if key in results and results[key]["outcome"] == "done"]
    rows = [{"job": key, "step": moment.step, **moment.observed} for key in whole for moment in series[key]]
    columns = list(dict.fromkeys(["job", "step", "time", *(name for row in rows for name in row)]))
    return Table(columns, [{name: row.get(name) for name in columns} for row in rows])


def row_of(job: Job, outcome: str, why: str, observed: Mapping[str, Any]) -> dict[str, Any]:
    first = dict(zip(FIRST_COLUMNS, (job.key, outcome, why, job.source.name, job.seed), strict=True))
    return {**first, **job.parameters, **observed}


def has_parquet() -> bool:
    return importlib.util.find_spec("pyarrow") is not None


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, (int, float, list, dict)) else str(value)


def _column(values: list[Any]) -> list[Any]:
    """Of one type: numbers of both kinds as floats, what mixes with text as text."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float} and float in kinds:
        return [None if value is None else float(value) for value in values]
    if len(kinds) > 1 or kinds & {dict}:
        return [None if value is None else _cell(value) for value in values]
    return values
