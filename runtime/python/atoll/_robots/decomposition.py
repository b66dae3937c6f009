"""Meshes as convex hulls: one each, or as many as a bound on the volume error takes."""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .quaternions import Floats

# CoACD's bounds on the concavity of a part, each half of the one before; its own default is 0.05.
_THRESHOLDS = (0.1, 0.05, 0.025, 0.0125)


@dataclass(frozen=True)
class Hulls:
    """What stands for a mesh, and how well."""

    hulls: list[_core.ConvexHull]
    error: float | None  #: of their volumes' sum, as a part of the mesh's; None of a mesh that isn't closed
    error_of_one: float | None  #: the same of the one hull of all its points

    @property
    def note(self) -> str:
        """For a receipt."""
        points = sum(len(hull.vertices) for hull in self.hulls)
        fewer = ", fewer than it has" if any(hull.simplified for hull in self.hulls) else ""
        if len(self.hulls) > 1:
            assert self.error is not None and self.error_of_one is not None
            return (
                f"{len(self.hulls)} hulls by CoACD, {points} points{fewer}: "
                f"{self.error:+.1%} of its volume, where one hull has {self.error_of_one:+.1%}"
            )
        error_text = "" if self.error is None else f": {self.error:+.1%} of its volume"
        return f"the hull of its points, {points} of them{fewer}{error_text}"


def check_hull_error(call: str, bound: float | None) -> None:
    if bound is not None and not 0 < bound < math.inf:
        raise _core.Error(f"{call}: hull_error is {bound}; expected a finite number > 0, or None")


def hulls_of(vertices: Floats, faces: NDArray[np.int64], bound: float | None) -> Hulls:
    """The one hull of a mesh, or, if its volume is off by more than the bound, CoACD's (Wei et al., "Approximate convex
    decomposition for 3D meshes with collision-aware concavity and tree search", ACM Trans. Graph. 41, 2022): the
    coarsest that are within it, or the finest tried. A mesh that isn't closed has no volume, and one hull."""
    whole = _core.ConvexHull(vertices)
    volume = _volume(vertices, faces)
    if volume is None or volume <= 0:
        return Hulls([whole], None, None)
    error_of_one = whole.volume / volume - 1
    best = Hulls([whole], error_of_one, error_of_one)
    if bound is None or error_of_one <= bound:
        return best
    for threshold in _THRESHOLDS:
        hulls = [_core.ConvexHull(points) for points in _parts(vertices, faces, threshold)]
        error = sum(hull.volume for hull in hulls) / volume - 1
        if best.error is None or abs(error) < abs(best.error):
            best = Hulls(hulls, error, error_of_one)
        if abs(error) <= bound:
            break
    return best


def _volume(vertices: Floats, faces: NDArray[np.int64]) -> float | None:
    """m^3, if each edge has a face on either side."""
    _, places = np.unique(vertices, axis=0, return_inverse=True)
    corners = places.reshape(-1)[faces]
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = edges[edges[:, 0] != edges[:, 1]]
    there, back = (np.unique(of, axis=0, return_counts=True) for of in (edges, edges[:, ::-1]))
    if there[0].shape != back[0].shape or np.any(there[0] != back[0]) or np.any(there[1] != back[1]):
        return None
    a, b, c = (vertices[faces[:, i]] - vertices.mean(axis=0) for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _parts(vertices: Floats, faces: NDArray[np.int64], threshold: float) -> list[Floats]:
    coacd = _library()
    coacd.set_log_level("off")
    mesh = coacd.Mesh(vertices, faces)
    return [np.asarray(points, dtype=np.float64) for points, _ in coacd.run_coacd(mesh, threshold=threshold, seed=1)]


def _library() -> Any:
    try:
        return importlib.import_module("coacd")
    except ImportError:
        raise _core.Error(
            "load_mjcf, load_urdf: there is no module coacd; expected it for hull_error: pip install atoll[robots]"
        ) from None
