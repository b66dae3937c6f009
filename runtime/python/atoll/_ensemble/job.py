"""Runs a part of a job: from its start or a snapshot, until it ends, time is up or it is asked to stop.

What comes out depends on the job alone. Where a part ends depends on time, but no state does: a job that was run in
other parts, or twice, or elsewhere passes through the same states, which their hashes tell.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .. import _core
from . import stopping
from .observables import observe
from .plan import Job, function_of
from .snapshot_file import BadSnapshot, SnapshotBytes, pack, unpack
from .whole_file import write_whole

#: Of a job's steps, after which its state's hash is told: where two attempts are compared.
CHECKS = 8

#: Columns that are told of all jobs, ahead of others.
FIRST_COLUMNS = ("job", "outcome", "why", "scene", "seed")
_TAKEN = (*FIRST_COLUMNS, "step", "time")


class FunctionError(Exception):
    """What a function of the plan raised, or did that it may not."""


class LimitError(Exception):
    """A job needs more than its limit."""


@dataclass(frozen=True)
class Point:
    """A state that a job passed through."""

    step: int
    hash: int


@dataclass(frozen=True)
class Moment:
    """Of a job's series."""

    step: int
    observed: dict[str, float]  #: observables by name, and the time in s


@dataclass(frozen=True)
class Part:
    """Of a job, that was run at a time."""

    first: int  #: the step that it began after
    last: Point
    checks: list[Point]
    series: list[Moment]
    result: dict[str, Any] | None  #: of a job that is done
    snapshot: bytes | None  #: of its last point, where there is no folder
    notes: list[str] = field(default_factory=list)
    seconds: float = 0.0  #: in steps
    snapshot_seconds: float = 0.0  #: to save, write, read and restore
    snapshot_bytes: int = 0


@dataclass
class _Running:
    """What a process keeps of the job that it ran last: the same may come back at once."""

    key: str
    point: Point
    scene: _core.Scene
    world: _core.World


_running: _Running | None = None


def make_scene(job: Job) -> _core.Scene:
    """Raises SceneError, or what its "setup" raises."""
    parameters = job.parameters
    if job.source.text is not None:
        scene = _core.parse_scene(job.source.text, job.source.name)
    else:
        inner = [f"{name.removeprefix('scene.')}={value}" for name, value in parameters.items() if name.startswith("scene.")]
        scene = _core.load_scene(_with_parameters(job.source.name, inner), job.seed)
    if "dt" in parameters:
        scene.dt = float(parameters["dt"])  # type: ignore[arg-type]
    if "gravity" in parameters:
        scene.gravity = parameters["gravity"]  # type: ignore[assignment]
    settings = {name.removeprefix("settings."): value for name, value in parameters.items() if name.startswith("settings.")}
    if settings:
        # Through a scene file's text, which says what is wrong with a setting.
        document = json.loads(_core.Scene(settings=scene.settings, bodies=[_core.SceneBody()]).text())
        document["settings"] |= settings
        scene.settings = _core.parse_scene(json.dumps(document), "settings").settings
    _change_bodies(scene, parameters)
    if job.setup:
        _call(job.setup, scene, dict(parameters))
    return scene


def _call(address: str, *arguments: object) -> Any:
    try:
        return function_of(address)(*arguments)
    except MemoryError:
        raise
    except Exception as error:
        raise FunctionError(f"{address}: {type(error).__name__}: {error}") from None


def _with_parameters(name: str, inner: list[str]) -> str:
    if not inner:
        return name
    changed = {text.partition("=")[0] for text in inner}
    base, _, given = name.partition(":")
    kept = [text for text in given.split(",") if text and text.partition("=")[0] not in changed]
    return f"{base}:{','.join([*kept, *inner])}"


def _change_bodies(scene: _core.Scene, parameters: dict[str, Any]) -> None:
    material = {name.removeprefix("material."): value for name, value in parameters.items() if name.startswith("material.")}
    factor = parameters.get("mass", 1.0)
    if not material and factor == 1.0:
        return
    bodies = scene.bodies
    for body in bodies:
        definition = body.definition
        if material:
            changed = definition.material
            for name, value in material.items():
                setattr(changed, name, float(value))
            definition.material = changed
        if definition.type == _core.BodyType.DYNAMIC:
            definition.density *= factor
            if definition.mass is not None:
                definition.mass *= factor
            if definition.inertia is not None:
                definition.inertia = factor * definition.inertia
        body.definition = definition
    scene.bodies = bodies


@contextmanager
def _memory_limit(size: int | None) -> Iterator[None]:
    """Raises LimitError where the process would have more than `size` bytes of data, or more than there is."""
    before = resource.getrlimit(resource.RLIMIT_DATA)
    address_space = before[0] if size is None else size
    try:
        resource.setrlimit(resource.RLIMIT_DATA, (address_space, before[1]))
        yield
    except MemoryError:
        limit = "there is" if size is None else f"its limit of {size / 1e6:.0f} MB"
        raise LimitError(f"needs more memory than {limit}") from None
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


def run_part(job: Job, start: Point | None, seconds: float, folder: str | None, snapshot: bytes | None = None,
             name: str = "", memory: int | None = None) -> Part:
    """Goes on from `start`, whose snapshot is `snapshot`, or in `folder` under `name` (by default the key); from the
    beginning without one, or where it can't be used, which a note then says. Ends after `seconds` s or soon after.
    Raises LimitError where it takes more than `memory` bytes.
    """
    with _memory_limit(memory):
        return _run_part(job, start, seconds, folder, snapshot, name)


def _run_part(job: Job, start: Point | None, seconds: float, folder: str | None, snapshot: bytes | None, name: str) -> Part:
    global _running
    key = job.key
    name = name or key
    notes: list[str] = []
    begin = time.perf_counter()
    running, _running = _running, None
    moved_bytes = 0
    if running is None or start is None or (running.key, running.point) != (key, start):
        scene = make_scene(job)
        running = _Running(key, Point(0, 0), scene, scene.build())
        if start is not None:
            try:
                path = snapshot_path(Path(folder), name, start.step) if folder else None
                stored = path.read_bytes() if path else snapshot or b""
                moved_bytes = len(stored)
                _restore(running, SnapshotBytes(stored, str(path or "snapshot")), start)
            except (OSError, BadSnapshot) as error:
                notes.append(f"{key}: {error}; begins anew")
                running = _Running(key, Point(0, 0), scene, scene.build())
    scene, world = running.scene, running.world
    snapshot_seconds = time.perf_counter() - begin if moved_bytes else 0.0

    steps = job.steps or scene.steps
    every = max(1, steps // CHECKS)
    first = step = running.point.step
    checks: list[Point] = []
    series = [_moment(job, scene, world, 0)] if job.keep.series and first == 0 else []
    recording = _begin_recording(job, world, folder, first) if name == key else None
    begin = time.perf_counter()
    end = begin + seconds
    forced = any(body.force.any() for body in scene.bodies)
    while step < steps:
        if forced:
            scene.apply_forces(world)
        world.step(scene.dt)
        step += 1
        if step % every == 0 or step == steps:
            checks.append(Point(step, world.state_hash()))
        if job.keep.series and step % job.keep.series == 0:
            series.append(_moment(job, scene, world, step))
        if time.perf_counter() >= end or stopping.asked():
            break
    stepped = time.perf_counter() - begin
    if recording is not None:
        world.stop_recording()
        os.replace(recording, recording.with_suffix(""))

    begin = time.perf_counter()
    last = Point(step, world.state_hash())
    packed = None
    if step < steps or job.keep.state:
        packed = pack(key, last.step, last.hash, world.save())
        moved_bytes += len(packed)
    if folder is not None and packed is not None:
        # Not lasting: what a machine that fails makes of it, its checksum tells.
        write_whole(snapshot_path(Path(folder), name, step) if step < steps else state_path(Path(folder), key), packed)
    snapshot_seconds += time.perf_counter() - begin
    result = _result(job, scene, world, last) if step == steps else None
    if result is None:
        _running = _Running(key, last, scene, world)
    return Part(first, last, checks, series, result, None if folder else packed, notes, stepped, snapshot_seconds, moved_bytes)


def _restore(running: _Running, stored: SnapshotBytes, start: Point) -> None:
    point, snapshot = unpack(stored, running.key)
    if point != (start.step, start.hash):
        raise BadSnapshot(f"{stored.origin} is of step {point[0]}, not {start.step}")
    try:
        running.world.restore(snapshot)
    except _core.Error as error:
        raise BadSnapshot(f"{stored.origin} can't be restored: {error}") from None
    if running.world.state_hash() != start.hash:
        raise BadSnapshot(f"{stored.origin} restores to another state than was saved")
    running.point = start


def _begin_recording(job: Job, world: _core.World, folder: str | None, first: int) -> Path | None:
    if not job.keep.recording or folder is None:
        return None
    path = Path(folder) / "recordings" / job.key / f"{first:09}.recording.part"
    if first == 0:  # of attempts that ended elsewhere
        shutil.rmtree(path.parent, ignore_errors=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    world.record(str(path))
    return path


def _result(job: Job, scene: _core.Scene, world: _core.World, last: Point) -> dict[str, Any]:
    result: dict[str, Any] = {"steps": last.step, "state_hash": f"{last.hash:016x}", "quarantined": len(world.quarantined())}
    if job.keep.errors:
        meter = _core.ErrorMeter(scene, every_step=False)
        meter.observe(last.step * scene.dt, world)
        result |= meter.errors()
    return _observe(job, scene, world, result)


def _moment(job: Job, scene: _core.Scene, world: _core.World, step: int) -> Moment:
    return Moment(step, _observe(job, scene, world, {"time": step * scene.dt}))


def _observe(job: Job, scene: _core.Scene, world: _core.World, known: dict[str, Any]) -> dict[str, Any]:
    """What is known, and observables. A function may add columns, not change them."""
    observed = known | observe(world, job.keep.observables)
    if not job.observe:
        return observed
    found = _call(job.observe, world, scene)
    if not isinstance(found, Mapping):
        raise FunctionError(f"{job.observe}: returned {_short(found)}; expected a dict of numbers by name")
    for name, value in found.items():
        if not isinstance(name, str) or name in observed or name in _TAKEN or name in job.parameters:
            raise FunctionError(f"{job.observe}: returned the name {_short(name)}; expected text that no other column has")
        try:
            observed[name] = float(value)
        except (TypeError, ValueError, OverflowError):
            raise FunctionError(f"{job.observe}: returned {_short(value)} as {name}; expected a number") from None
    return observed


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) < 60 else text[:57] + "..."


def snapshot_path(folder: Path, name: str, step: int) -> Path:
    """Of a step of its own: who is late with another one, as a machine that was given up, overwrites nothing."""
    return folder / "snapshots" / f"{name}.{step}.snapshot"


def state_path(folder: Path, key: str) -> Path:
    return folder / "states" / f"{key}.snapshot"


def read_if_there(path: Path) -> bytes | None:
    return path.read_bytes() if path.exists() else None
