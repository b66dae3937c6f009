"""Joints of a compiled model."""

from __future__ import annotations

import math

import numpy as np

from .. import _core
from .compiled import Compiled, xyzw
from .filters import Filters
from .groups import Group
from .quaternions import inverse, product, turn_to, turned
from .robot import Coordinate

Kind = _core.BallJoint | _core.SixDofJoint | _core.HingeJoint | _core.SliderJoint
_FAR = 1e15  # m or rad, from which on an end of a range is none: as far as coordinates are computed with
_TURNS = (
    "springs, dampers and a range about three axes, of twice the sine of half the angle: "
    "0.4% weaker at 18 degrees, 10% at 90; the range is wider where they turn together"
)


class Joints:
    """Makes the joints of a scene, and the coordinates that these have."""

    def __init__(self, model: Compiled, filters: Filters, bodies: list[_core.SceneBody]) -> None:
        self.model, self.filters, self.bodies = model, filters, bodies
        self.scene: list[_core.SceneJoint] = []
        self.coordinates: list[Coordinate] = []

    def add(self, part: Group | int, body: int, first: int, second: int) -> str:
        """Between bodies at these places of the scene, of which the second is to be carried. Returns its name."""
        of, at_first, at_second = self._joined(part, body) if isinstance(part, Group) else self._single(part, body)
        m = self.model.arrays

        def frame(place: int, pose: _core.Pose) -> _core.Pose:
            body_def = self.bodies[place].definition
            back = inverse(body_def.orientation)
            at = turned(back, pose.position - np.asarray(body_def.position))
            return _core.Pose(at, product(back, pose.orientation))

        definition = _core.JointDef(
            kind=of,
            frame_first=frame(first, at_first),
            frame_second=frame(second, at_second),
            # The world may be touched by a body that a joint holds to it.
            collide=self.filters.parents_touch or int(m.body_weldid[m.body_parentid[body]]) == 0,
        )
        joints = part.joints if isinstance(part, Group) else [part]
        name = ", ".join(self.model.name("JOINT", joint) for joint in joints)
        self.scene.append(_core.SceneJoint(name=name, definition=definition, first=first, second=second))
        return name

    def _joined(self, group: Group, body: int) -> tuple[_core.SixDofJoint, _core.Pose, _core.Pose]:
        """The joint that a group makes, and its two frames in the world."""
        m, data, hinge = self.model.arrays, self.model.data, int(self.model.mujoco.mjtJoint.mjJNT_HINGE)
        axes = [_core.JointAxis(range=_core.JointRange(0, 0)) for _ in range(6)]
        turn, anchor, slid = np.zeros(4), np.array(data.xpos[body]), np.zeros(3)
        self.model.mujoco.mju_mat2Quat(turn, group.axes.flatten())
        for joint, coordinate in zip(group.joints, group.coordinates, strict=True):
            name, value = self.model.name("JOINT", joint), float(data.qpos[m.jnt_qposadr[joint]])
            axes[coordinate] = self._axis(joint, name, value)
            if int(m.jnt_type[joint]) == hinge:
                anchor = np.array(data.xanchor[joint])
                self.coordinates.append(Coordinate(name, len(self.scene), "hinge", axis=coordinate))
            else:
                slid += value * np.array(data.xaxis[joint])
                self.coordinates.append(Coordinate(name, len(self.scene), "slide", axis=coordinate))
        at_rest = product(xyzw(data.xquat[m.body_parentid[body]]), xyzw(m.body_quat[body]))
        first = _core.Pose(anchor - slid, product(at_rest, xyzw(turn)))
        second = _core.Pose(anchor, product(xyzw(data.xquat[body]), xyzw(turn)))
        return _core.SixDofJoint(axes[:3], axes[3:], group.turns), first, second

    def _single(self, joint: int, body: int) -> tuple[Kind, _core.Pose, _core.Pose]:
        m, kinds = self.model.arrays, self.model.mujoco.mjtJoint
        name, kind = self.model.name("JOINT", joint), int(m.jnt_type[joint])
        anchor, axis = np.array(self.model.data.xanchor[joint]), np.array(self.model.data.xaxis[joint])
        value = float(self.model.data.qpos[m.jnt_qposadr[joint]])
        turn = turn_to(axis)
        at_first, turn_second = anchor, turn
        of: Kind
        if kind == kinds.mjJNT_BALL:
            of = self._ball(joint, name)
            turn_second = xyzw(self.model.data.xquat[body])
            place = int(m.jnt_qposadr[joint])
            turn = product(turn_second, inverse(xyzw(self.model.data.qpos[place : place + 4])))
        elif kind == kinds.mjJNT_HINGE:
            of = _core.HingeJoint(self._axis(joint, name, value))
            turn_second = product(turn, [math.sin(value / 2), 0, 0, math.cos(value / 2)])
            self.coordinates.append(Coordinate(name, len(self.scene), "hinge"))
        else:
            of = _core.SliderJoint(self._axis(joint, name, value))
            at_first = anchor - value * axis
            self.coordinates.append(Coordinate(name, len(self.scene), "slide"))
        return of, _core.Pose(at_first, turn), _core.Pose(anchor, turn_second)

    def _ball(self, joint: int, name: str) -> _core.BallJoint | _core.SixDofJoint:
        m, dof, place = (
            self.model.arrays,
            int(self.model.arrays.jnt_dofadr[joint]),
            int(self.model.arrays.jnt_qposadr[joint]),
        )
        friction, stiffness, damping = (
            float(m.dof_frictionloss[dof]),
            float(m.jnt_stiffness[joint]),
            float(m.dof_damping[dof]),
        )
        armature, limited = float(m.dof_armature[dof]), bool(m.jnt_limited[joint])
        if not (stiffness or damping or armature or limited):
            self.model.receipt.exact("joint", name)
            return _core.BallJoint(friction)
        body = int(m.jnt_bodyid[joint])
        alone = joint == m.body_jntadr[body] + m.body_jntnum[body] - 1
        if not alone or not np.array_equal(m.qpos_spring[place : place + 4], [1, 0, 0, 0]):
            self.model.receipt.left_out("joint", name, "the range, spring and armature of a ball that others turn")
            return _core.BallJoint(friction)
        turn = _core.JointAxis(armature=armature, friction=friction)
        if limited:
            end = 2 * math.sin(min(float(m.jnt_range[joint][1]), math.pi) / 2)
            turn.range = _core.JointRange(-end, end)
        if stiffness or damping:
            turn.spring = _core.JointSpring(stiffness=stiffness, damping=damping)
        self.model.receipt.taken_as("joint", name, _TURNS)
        locked = _core.JointAxis(range=_core.JointRange(0, 0))
        return _core.SixDofJoint(offset=[locked] * 3, turn=[turn] * 3)

    def _axis(self, joint: int, name: str, value: float) -> _core.JointAxis:
        m, dof = self.model.arrays, int(self.model.arrays.jnt_dofadr[joint])
        axis = _core.JointAxis(armature=float(m.dof_armature[dof]), friction=float(m.dof_frictionloss[dof]))
        if m.jnt_limited[joint]:
            lower, upper = (float(x) for x in m.jnt_range[joint])
            beyond = max(lower - value, value - upper)
            if beyond > 0:
                note = f"{beyond:.3g} m or rad beyond the range of the joint, which is pushed into it"
                self.model.receipt.taken_as("pose", name, note)
            axis.range = _core.JointRange(lower if lower > -_FAR else -math.inf, upper if upper < _FAR else math.inf)
        stiffness, damping = float(m.jnt_stiffness[joint]), float(m.dof_damping[dof])
        if stiffness > 0 or damping > 0:
            rest = float(m.qpos_spring[m.jnt_qposadr[joint]])
            axis.spring = _core.JointSpring(stiffness=stiffness, damping=damping, rest=rest)
        if np.any(m.jnt_stiffnesspoly[joint]) or np.any(m.dof_dampingpoly[dof]):
            self.model.receipt.left_out("joint", name, "the part of its stiffness or damping that isn't linear")
        else:
            self.model.receipt.exact("joint", name)
        return axis
