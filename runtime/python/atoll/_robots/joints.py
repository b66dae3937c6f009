"""Joints of a compiled model."""

from __future__ import annotations

import math

import numpy as np

from .. import _core
from .compiled import Compiled
from .filters import Filters
from .quaternions import Floats, inverse, product, turn_to, turned
from .robot import Coordinate

_FAR = 1e15  # m or rad, from which on an end of a range is none: as far as coordinates are computed with


class Joints:
    """Makes the joints of a scene, and the coordinates that these have."""

    def __init__(self, model: Compiled, filters: Filters, bodies: list[_core.SceneBody]) -> None:
        self.model, self.filters, self.bodies = model, filters, bodies
        self.scene: list[_core.SceneJoint] = []
        self.coordinates: list[Coordinate] = []

    def add(self, joint: int, body: int, first: int, second: int) -> None:
        """Between bodies at these places of the scene, of which the second is to be carried."""
        m, kinds = self.model.arrays, self.model.mujoco.mjtJoint
        name, kind = self.model.name("JOINT", joint), int(m.jnt_type[joint])
        anchor, axis = np.array(self.model.data.xanchor[joint]), np.array(self.model.data.xaxis[joint])
        value = float(self.model.data.qpos[m.jnt_qposadr[joint]])
        turn = turn_to(axis)
        at_first, at_second, turn_second = anchor, anchor, turn
        of: _core.BallJoint | _core.HingeJoint | _core.SliderJoint
        if kind == kinds.mjJNT_BALL:
            of = self._ball(joint, name)
        elif kind == kinds.mjJNT_HINGE:
            of = _core.HingeJoint(self._axis(joint, name))
            turn_second = product(turn, [math.sin(value / 2), 0, 0, math.cos(value / 2)])
            self.coordinates.append(Coordinate(name, len(self.scene), "hinge"))
        else:
            of = _core.SliderJoint(self._axis(joint, name))
            at_first = anchor - value * axis
            self.coordinates.append(Coordinate(name, len(self.scene), "slide"))

        def frame(place: int, position: Floats, orientation: Floats) -> _core.Pose:
            body_def = self.bodies[place].definition
            back = inverse(body_def.orientation)
            return _core.Pose(turned(back, position - np.asarray(body_def.position)), product(back, orientation))

        definition = _core.JointDef(
            kind=of,
            frame_first=frame(first, at_first, turn),
            frame_second=frame(second, at_second, turn_second),
            # The world may be touched by a body that a joint holds to it.
            collide=self.filters.parents_touch or int(m.body_weldid[m.body_parentid[body]]) == 0,
        )
        self.scene.append(_core.SceneJoint(name=name, definition=definition, first=first, second=second))

    def _ball(self, joint: int, name: str) -> _core.BallJoint:
        m, dof = self.model.arrays, int(self.model.arrays.jnt_dofadr[joint])
        left_out = [
            word
            for word, there in (
                ("damping", m.dof_damping[dof]),
                ("stiffness", m.jnt_stiffness[joint]),
                ("armature", m.dof_armature[dof]),
                ("range", m.jnt_limited[joint]),
            )
            if there
        ]
        if left_out:
            self.model.receipt.left_out("joint", name, f"the {', '.join(left_out)} of a ball joint")
        else:
            self.model.receipt.exact("joint", name)
        return _core.BallJoint(float(m.dof_frictionloss[dof]))

    def _axis(self, joint: int, name: str) -> _core.JointAxis:
        m, dof = self.model.arrays, int(self.model.arrays.jnt_dofadr[joint])
        axis = _core.JointAxis(armature=float(m.dof_armature[dof]))
        if m.jnt_limited[joint]:
            lower, upper = (float(x) for x in m.jnt_range[joint])
            axis.range = _core.JointRange(lower if lower > -_FAR else -math.inf, upper if upper < _FAR else math.inf)
        stiffness, damping = float(m.jnt_stiffness[joint]), float(m.dof_damping[dof])
        if stiffness > 0 or damping > 0:
            rest = float(m.qpos_spring[m.jnt_qposadr[joint]])
            axis.spring = _core.JointSpring(stiffness=stiffness, damping=damping, rest=rest)
        if m.dof_frictionloss[dof] > 0:
            axis.motor = _core.JointMotor(max_force=float(m.dof_frictionloss[dof]))
        if np.any(m.jnt_stiffnesspoly[joint]) or np.any(m.dof_dampingpoly[dof]):
            self.model.receipt.left_out("joint", name, "the part of its stiffness or damping that isn't linear")
        else:
            self.model.receipt.exact("joint", name)
        return axis
