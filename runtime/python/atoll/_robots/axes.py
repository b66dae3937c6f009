"""What acts along the coordinates of joints, and where these point."""

from __future__ import annotations

import numpy as np

from .. import _core
from .quaternions import Floats, matrices, product

Moving = _core.HingeJoint | _core.SliderJoint | _core.SixDofJoint | _core.TendonJoint


def axis_of(kind: object, coordinate: int) -> _core.JointAxis:
    """As World.joint_axis(), of a joint that load_mjcf() makes with a coordinate."""
    if isinstance(kind, _core.SixDofJoint):
        return (*kind.offset, *kind.turn)[coordinate]
    if isinstance(kind, _core.TendonJoint):
        return kind.length
    assert isinstance(kind, (_core.HingeJoint, _core.SliderJoint))
    return kind.angle if isinstance(kind, _core.HingeJoint) else kind.offset


def with_axis(kind: object, coordinate: int, axis: _core.JointAxis) -> Moving:
    """The same with another one."""
    if isinstance(kind, _core.SixDofJoint):
        axes = [*kind.offset, *kind.turn]
        axes[coordinate] = axis
        return _core.SixDofJoint(axes[:3], axes[3:], kind.turns)
    if isinstance(kind, _core.TendonJoint):
        return _core.TendonJoint(kind.terms, axis)
    assert isinstance(kind, (_core.HingeJoint, _core.SliderJoint))
    return type(kind)(axis)


def direction(definition: _core.JointDef, coordinate: int, first: _core.Pose, second: _core.Pose) -> Floats:
    """The force or torque on the second body, N or N m, that pushes along a coordinate by 1, and along no other one."""
    axes = matrices(product(first.orientation, definition.frame_first.orientation))
    kind = definition.kind
    if not isinstance(kind, _core.SixDofJoint) or coordinate < 3:
        return np.asarray(axes[:, coordinate])
    last, middle = (2, 1) if kind.turns == _core.SixDofTurns.ANGLES_XYZ else (1, 2)
    axes[:, last] = matrices(product(second.orientation, definition.frame_second.orientation))[:, last]
    axes[:, middle] = np.cross(axes[:, middle - 2], axes[:, middle - 1])
    axes[:, middle] /= np.linalg.norm(axes[:, middle]) or 1
    return np.asarray(np.linalg.pinv(axes)[coordinate - 3])
