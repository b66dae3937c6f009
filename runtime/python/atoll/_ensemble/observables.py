"""What a job's world looks like, in numbers: SI units, of dynamic bodies."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .. import _core

_Rows = NDArray[np.float64]


def _heights(world: _core.World, rows: NDArray[np.intp]) -> _Rows:
    """m, of centres of mass, against gravity or else along z."""
    size = float(np.linalg.norm(world.gravity))
    up = -np.asarray(world.gravity) / size if size > 0 else np.array([0.0, 0.0, 1.0])
    heights: _Rows = world.positions[rows] @ up
    return heights


def _speeds(world: _core.World, rows: NDArray[np.intp]) -> _Rows:
    speeds: _Rows = np.sqrt((world.velocities[rows] ** 2).sum(axis=1))
    return speeds


def _masses(world: _core.World, rows: NDArray[np.intp]) -> _Rows:
    return np.array([world.mass(body) for body in world.bodies if _is_dynamic(world, body)])


#: Each of a world and the rows of its dynamic bodies, of which there is one at least.
OBSERVABLES: dict[str, Callable[[_core.World, NDArray[np.intp]], float]] = {
    "max_height": lambda world, rows: float(_heights(world, rows).max()),
    "mean_height": lambda world, rows: float(_heights(world, rows).mean()),
    "max_speed": lambda world, rows: float(_speeds(world, rows).max()),
    "mean_speed": lambda world, rows: float(_speeds(world, rows).mean()),
    "moving_energy": lambda world, rows: float((0.5 * _masses(world, rows) * _speeds(world, rows) ** 2).sum()),
    "mass": lambda world, rows: float(_masses(world, rows).sum()),
}


def observe(world: _core.World, names: tuple[str, ...]) -> dict[str, float]:
    rows = np.array([body.index for body in world.bodies if _is_dynamic(world, body)], dtype=np.intp)
    if rows.size == 0:
        return {name: 0.0 for name in names}
    return {name: OBSERVABLES[name](world, rows) for name in names}


def _is_dynamic(world: _core.World, body: _core.BodyId) -> bool:
    return world.type(body) == _core.BodyType.DYNAMIC
