"""Joints of one body that make one joint of a scene, in the coordinates of the model."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .. import _core
from .compiled import Compiled
from .quaternions import Floats

_WIDEST = 1.3  # rad, of the hinge between two others: what acts along those fades from 1.318 on
_ROUNDING = 1e-9  # of cosines between axes
_ORDERS = {_core.SixDofTurns.ANGLES_XYZ: (0, 1, 2), _core.SixDofTurns.ANGLES_XZY: (0, 2, 1)}
_TURNS: dict[int, list[tuple[int, ...]]] = {0: [()], 1: [(0,), (2,)], 2: [(0, 2)], 3: [(0, 1, 2)]}  # by number of hinges


@dataclass(frozen=True)
class Group:
    """Slides, and then hinges through one point, along and about axes at right angles: as a SixDofJoint."""

    joints: Sequence[int]  #: of the model
    coordinates: Sequence[int]  #: of the SixDofJoint, that these are
    turns: _core.SixDofTurns
    axes: Floats  #: columns, of its frames in the body, where all coordinates are 0


def groups_of(model: Compiled, joints: Sequence[int]) -> Iterator[Group | int]:
    """Parts a body's joints, as long ones as there are; a joint that makes none with others is by itself."""
    while joints:
        found = (group for count in range(len(joints), 1, -1) if (group := _group(model, joints[:count])))
        first = next(found, joints[0])
        yield first
        joints = joints[len(first.joints) if isinstance(first, Group) else 1 :]


def _group(model: Compiled, joints: Sequence[int]) -> Group | None:
    m, kinds = model.arrays, model.mujoco.mjtJoint
    slides = [joint for joint in joints if int(m.jnt_type[joint]) == int(kinds.mjJNT_SLIDE)]
    hinges = [joint for joint in joints if int(m.jnt_type[joint]) == int(kinds.mjJNT_HINGE)]
    # Angles of other hinges, or from other places, have another law.
    if [*slides, *hinges] != list(joints) or len(hinges) > 3 or len(slides) > 3:
        return None
    if any(np.any(m.jnt_pos[hinge] != m.jnt_pos[hinges[0]]) or m.qpos0[m.jnt_qposadr[hinge]] for hinge in hinges):
        return None
    if len(hinges) == 3:
        lower, upper = m.jnt_range[hinges[1]]
        if not -_WIDEST <= lower < upper <= _WIDEST:
            return None
    for (turns, order), used in itertools.product(_ORDERS.items(), _TURNS[len(hinges)]):
        for along in itertools.combinations(range(3), len(slides)):
            coordinates = [*along, *(3 + order[turn] for turn in used)]
            axes = _axes([place % 3 for place in coordinates], m.jnt_axis[joints])
            if axes is not None:
                return Group(joints, coordinates, turns, axes)
    return None


def _axes(places: Sequence[int], directions: Floats) -> Floats | None:
    """The right-handed axes of which those at these places have the directions, if there are some."""
    axes = np.zeros((3, 3))
    axes[:, places] = np.transpose(directions)
    for place in set(range(3)) - set(places):
        axes[:, place] = np.cross(axes[:, place - 2], axes[:, place - 1])
    if len(set(places)) < 2:
        return None
    as_given = np.allclose(axes[:, places].T, directions, rtol=0, atol=_ROUNDING)
    right = np.allclose(axes.T @ axes, np.eye(3), rtol=0, atol=_ROUNDING) and np.linalg.det(axes) > 0
    return axes if as_given and right else None
