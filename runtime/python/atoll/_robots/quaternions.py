"""Turns as unit quaternions x, y, z, w."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def turned(orientation: ArrayLike, vector: ArrayLike) -> Floats:
    """A vector turned by a quaternion x, y, z, w."""
    q = np.asarray(orientation, dtype=np.float64)
    v = np.asarray(vector, dtype=np.float64)
    across = 2 * np.cross(q[:3], v)
    return np.asarray(v + q[3] * across + np.cross(q[:3], across), dtype=np.float64)


def product(a: ArrayLike, b: ArrayLike) -> Floats:
    """The turn b, and then a: quaternions x, y, z, w."""
    p, q = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    vector = p[3] * q[:3] + q[3] * p[:3] + np.cross(p[:3], q[:3])
    return np.asarray(np.append(vector, p[3] * q[3] - p[:3] @ q[:3]), dtype=np.float64)


def inverse(orientation: ArrayLike) -> Floats:
    """Of a unit quaternion x, y, z, w."""
    return np.asarray(np.asarray(orientation, dtype=np.float64) * [-1, -1, -1, 1], dtype=np.float64)


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
