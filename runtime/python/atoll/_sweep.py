"""Error against run time over settings: `sweep()`, by the code of the command `atoll sweep`."""

from __future__ import annotations

import csv
import enum
import html
import importlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, Union

import numpy as np
from numpy.typing import NDArray

from . import _core

if TYPE_CHECKING:
    from ._ensemble.engines import Engine

_T = TypeVar("_T")
Values = Union[_T, Sequence[_T], NDArray[Any]]  #: of a setting: one, or several
Cell = Union[str, bool, int, float, None]  #: None where a run has none


class SweepTable:
    """What a sweep measured, a row a run. Its columns are those of the command's results.csv: `scene`, `engine`, `label`
    (what differs from the scene's own settings), `default`, `outcome` ("done", or how it ended otherwise), `why`, `steps`,
    `dt` (s), a column a setting, `options` (of other engines), `cpu_s_per_simulated_s` (the median; `cpu_min`, `cpu_max`),
    `ms_per_step` (wall time; `ms_min`, `ms_max`), and the errors of all runs, in SI units. With an engine of workers there
    is a last one, `worker`: who ran it.
    """

    def __init__(self, columns: Sequence[tuple[str, str]], cells: Sequence[Sequence[str]]) -> None:
        self.columns: list[str] = [name for name, _ in columns]
        self._kinds = dict(columns)
        readers = [_READERS[kind] for _, kind in columns]
        self.rows: list[dict[str, Cell]] = [
            {name: read(text) for name, read, text in zip(self.columns, readers, row, strict=True)} for row in cells
        ]

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Cell]]:
        return iter(self.rows)

    def __getitem__(self, column: str) -> NDArray[Any]:
        """A column as an array, shape (rows,): of bool, int64, float64 or text. A number that a run has not is NaN."""
        if column not in self._kinds:
            raise _core.Error(f'SweepTable: found the column "{column}"; expected one of {", ".join(self.columns)}')
        cells = [row[column] for row in self.rows]
        kind = self._kinds[column]
        if kind == "integer" and None not in cells:
            return np.array(cells, dtype=np.int64)
        if kind in ("integer", "number"):
            return np.array([math.nan if cell is None else cell for cell in cells], dtype=np.float64)
        return np.array(cells, dtype=np.bool_ if kind == "flag" else np.str_)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame of it. Raises ImportError where pandas is not installed."""
        return importlib.import_module("pandas").DataFrame({name: self[name] for name in self.columns})

    def write_csv(self, path: str | Path) -> None:
        """To a file. What a run has not is empty."""
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, self.columns)
            writer.writeheader()
            writer.writerows(self.rows)

    def _repr_html_(self) -> str:
        # Without columns in which there is nothing.
        shown = [name for name in self.columns if any(row[name] not in (None, "") for row in self.rows)]
        head = "".join(f"<th>{html.escape(name)}</th>" for name in shown)
        lines = (
            "<tr>" + "".join(f"<td>{html.escape(_words(row[name]))}</td>" for name in shown) + "</tr>" for row in self.rows
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(lines)}</tbody></table>"

    def __repr__(self) -> str:
        scenes = len({row["scene"] for row in self.rows})
        return f"<SweepTable of {len(self)} runs, {scenes} scenes, {len(self.columns)} columns>"


def sweep(
    scenes: str | _core.Scene | Sequence[str | _core.Scene],
    *,
    substeps: Values[int] | None = None,
    target: Values[float | str] | None = None,
    iterations: Values[int] | None = None,
    dt: Values[float | str] | None = None,
    friction: Values[_core.FrictionModel | str] | None = None,
    warm_start: Values[bool | str] | None = None,
    relax_iterations: Values[int] | None = None,
    stabilisation: Values[_core.Stabilisation | str] | None = None,
    contact_solver: Values[_core.ContactSolver | str] | None = None,
    joint_solver: Values[_core.JointSolver | str] | None = None,
    tolerance: Values[float] | None = None,
    threads: Values[int] | None = None,
    simd: Values[_core.Simd | str] | None = None,
    quick: bool = False,
    steps: int | None = None,
    repeats: int | None = None,
    time: float | None = None,
    seed: int = 1,
    peers: Sequence[str] = (),
    peer_limit: float | None = None,
    progress: bool = True,
    engine: str | Engine | None = None,
    workers: int | None = None,
    address: str | None = None,
) -> SweepTable:
    """Runs scenes over settings, and measures what error each comes to in what time.

    `scenes`: a Scene, or one as load_scene() takes it, or several. Of each first its own settings, then all pairs of
    `substeps` and `iterations`, and every other setting for itself, as the command does: `dt` in s (or "1/60"),
    `target` in m, of penetrations and gaps of joints (or "off"), `warm_start` whether impulses are those of the step
    before, `tolerance` in m/s with the most iterations. Where none are given, those are tried that make a difference in
    the scene. Each run is made once for its errors, and at least
    `repeats` times (3, or 1 if `quick`) for its time, each of `time` s of stepping or more (0.03, or 0.02 if `quick`).
    `quick`: a coarse grid. `steps`: at the scene's own dt, by default the scene's, or fewer of large ones. `peers`:
    programs that drive other engines, of which a run is stopped after `peer_limit` s (25, or 6 if `quick`).
    `progress`: a bar, where tqdm is installed and there is a terminal or notebook to show it in.

    `engine`: spreads the runs over workers, as `atoll.sweep("pile", engine="local", workers=4)`: "local", processes of
    this machine, "ray", a cluster at `address`, or an engine that there is. The column `worker` tells who ran what, and
    times are those of the machine that it is on: workers that share one slow each other down. Parts of the sweep whose
    workers are lost are run again.

    Errors are the same on every machine. Raises Error on a value that a setting doesn't take, SceneError, and
    EnsembleError where an engine can't be used.
    """
    given: dict[str, object] = {
        "substeps": substeps,
        "target": target,
        "iterations": iterations,
        "dt": dt,
        "friction": friction,
        "warm_start": warm_start,
        "relax_iterations": relax_iterations,
        "stabilisation": stabilisation,
        "contact_solver": contact_solver,
        "joint_solver": joint_solver,
        "tolerance": tolerance,
        "threads": threads,
        "simd": simd,
    }
    sources = [scenes] if isinstance(scenes, (str, _core.Scene)) else list(scenes)
    lists = {name: _texts(values) for name, values in given.items() if values is not None}
    options: dict[str, Any] = {"quick": quick, "steps": steps, "repeats": repeats, "time": time, "seed": seed}
    if engine is None and (workers is not None or address is not None):
        raise _core.Error("sweep: found workers or an address without an engine; expected one that has them")
    if engine is not None and (peers or peer_limit is not None):
        raise _core.Error("sweep: found peers with an engine of workers; expected them on one machine, without an engine")
    with _Bar(progress) as bar:
        if engine is None:
            columns, cells = _core.measure_sweep(
                sources, lists, **options, peers=list(peers), peer_limit=peer_limit, on_work=bar.update
            )
        else:
            from ._sweep_parts import measure_on

            columns, cells = measure_on(engine, workers, address, sources, lists, options, bar.update)
    return SweepTable(columns, cells)


class _Bar:
    """A bar of tqdm's, or none."""

    def __init__(self, wanted: bool) -> None:
        self._bar: Any = None
        self._tqdm: Any = None
        if wanted:
            try:
                self._tqdm = importlib.import_module("tqdm.auto").tqdm
            except ImportError:
                pass

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *reason: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def update(self, done: int, of: int) -> None:
        if self._tqdm is None:
            return
        if self._bar is None:
            layout = "{l_bar}{bar}| {elapsed}<{remaining}"
            self._bar = self._tqdm(total=of, desc="sweep", bar_format=layout, leave=False, disable=None)
        self._bar.update(done - self._bar.n)


def _texts(values: object) -> list[str]:
    """As options of the command have them."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        values = [values]
    return [_text(value) for value in values]


def _text(value: object) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "on" if value else "off"
    if isinstance(value, enum.Enum):
        return value.name.lower()
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value)


def _words(cell: Cell) -> str:
    if cell is None:
        return ""
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)


_READERS: dict[str, Callable[[str], Cell]] = {
    "text": str,
    "flag": lambda text: text == "1",
    "integer": lambda text: int(text) if text else None,
    "number": lambda text: float(text) if text else None,
}
