"""Inertias that no body can have, and the nearest that one can."""

from __future__ import annotations

import numpy as np

from .quaternions import Floats

_THICKNESS = 1e-3  # m, the radius of gyration that a point or rod is given across itself
_LEAST_MOMENT = 1e-14  # kg m^2, below which MuJoCo takes a moment of inertia for none
_ROUNDING = 1e-9  # of the largest second moment: keeps a repaired inertia clear of the bound


def second_moments(inertia: Floats) -> Floats:
    """The second moments of mass, kg m^2, shape (3, 3), of an inertia: they are positive definite for every body with
    volume, and only then do principal moments of inertia satisfy the triangle inequality.

    Wensing, Kim, Slotine: Linear Matrix Inequalities for Physically-Consistent Inertial Parameter Identification, 2018,
    section III.
    """
    return np.asarray(np.trace(inertia) / 2 * np.eye(3) - inertia, dtype=np.float64)


def nearest(inertia: Floats, mass: float) -> tuple[Floats, str]:
    """The inertia of a body nearest to the given one, kg m^2, shape (3, 3), symmetric, and what was wrong with it, which
    is empty if nothing was. mass: kg, > 0.

    Nearest in the Frobenius norm of second moments: their negative eigenvalues become 0. A point or a rod is a body, but
    its inertia has no inverse: it gets a radius of gyration of 1 mm.
    """
    moments = np.linalg.eigvalsh(inertia)
    second, axes = np.linalg.eigh(second_moments(inertia))
    wrong = []
    if moments[0] < 0:
        wrong.append("it is not positive definite")
    elif second[0] < 0:
        wrong.append("a moment is larger than the sum of the others")
    if wrong:
        second = np.maximum(second, _ROUNDING * max(second[-1], 0.0))
    if second[0] + second[1] < _LEAST_MOMENT:
        wrong.append("it is that of a point or a rod")
        second = np.maximum(second, max(mass * _THICKNESS**2, _LEAST_MOMENT))
    if not wrong:
        return inertia, ""
    repaired = axes @ np.diag(np.sum(second) - second) @ axes.T
    return (repaired + repaired.T) / 2, " and ".join(wrong)


def moments_of(inertia: Floats) -> str:
    """Principal moments, for people."""
    return ", ".join(f"{x:.3g}" for x in np.linalg.eigvalsh(inertia))
