"""A sweep in parts, which workers of an ensemble's engine run: the same rows, in the same order, with who ran them."""

from __future__ import annotations

import itertools
import os
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from . import _core
from ._ensemble import stopping
from ._ensemble.engines import Answer, Call, Engine, calls_at_a_time
from ._ensemble.run import make_engine

Column = tuple[str, str]  #: its name, and what its texts stand for
Table = tuple[list[Column], list[list[str]]]

#: Configurations of a part, besides the scene's own, which every part runs once more as others are compared with it:
#: a fifth of the runs of a part. Larger parts waste less, but share long sweeps less evenly among workers.
PART_SIZE = 4
#: Times that a part whose worker was lost is submitted again.
MOST_RETRIES = 10

# No two parts have the same, so that answers to a sweep that was interrupted aren't taken for those to the next one.
_tickets = itertools.count(1)


class Stopped(Exception):
    """What a worker was doing is no longer wanted."""


@dataclass
class _Part:
    scene: str | _core.Scene
    scene_index: int
    begin: int
    end: int
    size: int  #: of the scene's whole plan
    losses: int = 0

    def __str__(self) -> str:
        name = self.scene if isinstance(self.scene, str) else self.scene.name
        return f"{name}, settings {self.begin} to {self.end - 1} of {self.size}"


@dataclass(frozen=True)
class _Measured:
    worker: str
    columns: list[Column]
    rows: list[list[str]]


def run_part(
    scene: str | _core.Scene, lists: Mapping[str, Sequence[str]], options: Mapping[str, Any], part: tuple[int, int, int]
) -> Table:
    """On a worker."""
    return _core.measure_sweep([scene], lists, **options, peers=[], peer_limit=None, on_work=_end_if_asked, part=part)


def measure_on(
    engine: str | Engine,
    workers: int | None,
    address: str | None,
    scenes: Sequence[str | _core.Scene],
    lists: Mapping[str, Sequence[str]],
    options: Mapping[str, Any],
    on_work: Callable[[int, int], None],
) -> Table:
    """What `_core.measure_sweep` gives, and a last column `worker`. `options` are those without peers. Raises Error,
    EngineError, and what workers raised.
    """
    sent = [_without_file(scene, options["seed"]) for scene in scenes]
    sizes = _core.sweep_sizes(sent, lists, **{name: options[name] for name in ("quick", "steps", "seed")})
    parts = [part for index, size in enumerate(sizes) for part in _parts(sent[index], index, size)]
    used = make_engine(engine, workers, address)
    try:
        measured = _measure(used, parts, lists, options, on_work)
    except BaseException:
        if used is engine:
            used.stop()
        raise
    finally:
        if used is not engine:
            used.close()
    return _merge([[piece for piece, part in zip(measured, parts) if part.scene_index == i] for i in range(len(sizes))])


def _without_file(scene: str | _core.Scene, seed: int) -> str | _core.Scene:
    """Other machines may lack the file of a scene."""
    return _core.load_scene(scene, seed) if isinstance(scene, str) and os.path.exists(scene) else scene


def _parts(scene: str | _core.Scene, index: int, size: int) -> Iterator[_Part]:
    """All have the scene's own configuration, which is the first."""
    for begin in range(1, max(size, 2), PART_SIZE):
        yield _Part(scene, index, begin if size > 1 else 0, min(begin + PART_SIZE, size), size)


def _measure(
    engine: Engine,
    parts: Sequence[_Part],
    lists: Mapping[str, Sequence[str]],
    options: Mapping[str, Any],
    on_work: Callable[[int, int], None],
) -> list[_Measured]:
    """In the order of the parts."""
    measured: dict[int, _Measured] = {}
    waiting = deque(range(len(parts)))
    under_way: dict[int, int] = {}  # parts by ticket
    while waiting or under_way:
        while waiting and len(under_way) < calls_at_a_time(engine):
            index, ticket = waiting.popleft(), next(_tickets)
            under_way[ticket], part = index, parts[index]
            engine.submit(Call(ticket, run_part, (part.scene, lists, options, (part.begin, part.end, part.size))))
        for answer in engine.wait(0.2):
            if answer.ticket not in under_way:  # of a sweep that was interrupted
                continue
            index = under_way.pop(answer.ticket)
            if answer.lost:
                _count_loss(parts[index], answer)
                waiting.appendleft(index)
            elif answer.error is not None:
                raise answer.error
            else:
                measured[index] = _Measured(answer.worker, *answer.value)
                on_work(sum(parts[i].end - parts[i].begin for i in measured), sum(part.end - part.begin for part in parts))
    return [measured[index] for index in range(len(parts))]


def _count_loss(part: _Part, answer: Answer) -> None:
    part.losses += 1
    if part.losses > MOST_RETRIES:
        raise _core.Error(f"sweep: {part}: workers were lost {part.losses} times, at last: {answer.lost}")


def _end_if_asked(done: int, of: int) -> None:
    if stopping.asked():
        raise Stopped


def _merge(scenes: Sequence[Sequence[_Measured]]) -> Table:
    """From the parts of each scene, in order, to the table of the undivided sweep."""
    columns: list[Column] = []
    for pieces in scenes:
        of_scene: list[Column] = []
        for piece in pieces:
            _add_columns(of_scene, piece.columns)
        columns += [column for column in of_scene if column not in columns]
    columns = [column for column in columns if column != _INDEX]
    rows: list[list[str]] = []
    for pieces in scenes:
        by_configuration: dict[int, list[str]] = {}
        for piece in pieces:
            for row in piece.rows:
                cells = dict(zip(piece.columns, row, strict=True))
                merged = [*(cells.get(column, "") for column in columns), piece.worker]
                by_configuration.setdefault(int(cells[_INDEX]), merged)
        rows += [by_configuration[index] for index in sorted(by_configuration)]
    return [*columns, ("worker", "text")], rows


def _add_columns(known: list[Column], more: Sequence[Column]) -> None:
    """New ones go ahead of what they are ahead of in `more`: the errors of a part whose runs broke are missing."""
    place = len(known)
    for column in reversed(more):
        if column in known:
            place = known.index(column)
        else:
            known.insert(place, column)


_INDEX: Column = ("configuration", "integer")
