"""Turns as unit quaternions x, y, z, w: of one thing, or rows of many."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def cross(a: Floats, b: Floats) -> Floats:
    """As numpy.cross() of vectors with three numbers, in a third of its time where there are few."""
    return np.asarray(a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]])


def turned(orientations: ArrayLike, vectors: ArrayLike) -> Floats:
    """Vectors, shape (..., 3), turned by quaternions, shape (..., 4)."""
    q, v = np.asarray(orientations, dtype=np.float64), np.asarray(vectors, dtype=np.float64)
    across = 2 * cross(q[..., :3], v)
    return np.asarray(v + q[..., 3:] * across + cross(q[..., :3], across))


def product(a: ArrayLike, b: ArrayLike) -> Floats:
    """The turns b, and then a."""
    p, q = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    axes = p[..., 3:] * q[..., :3] + q[..., 3:] * p[..., :3] + cross(p[..., :3], q[..., :3])
    real = p[..., 3:] * q[..., 3:] - np.sum(p[..., :3] * q[..., :3], axis=-1, keepdims=True)
    return np.concatenate([axes, real], axis=-1)


def inverse(orientations: ArrayLike) -> Floats:
    return np.asarray(np.asarray(orientations, dtype=np.float64) * [-1, -1, -1, 1])


def matrices(orientations: Floats) -> Floats:
    """Shape (..., 3, 3)."""
    columns = [turned(orientations, np.broadcast_to(axis, (*orientations.shape[:-1], 3))) for axis in np.eye(3)]
    return np.stack(columns, axis=-1)


def turn_to(axis: ArrayLike) -> Floats:
    """The shortest turn of the x axis to a unit vector, as a quaternion x, y, z, w."""
    a = np.asarray(axis, dtype=np.float64)
    if a[0] >= 0:
        q = np.append(np.cross([1, 0, 0], a), 1 + a[0])
        return np.asarray(q / np.linalg.norm(q), dtype=np.float64)
    across = math.sqrt(a[1] ** 2 + a[2] ** 2)  # 1 + a[0] would cancel
    half = math.sqrt((1 - a[0]) / 2)
    if across == 0:
        return np.array([0.0, 0.0, 1.0, 0.0])
    return np.array([0.0, -a[2] / across * half, a[1] / across * half, across / (2 * half)])
