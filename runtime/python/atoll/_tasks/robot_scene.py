"""Scenes of walking robots: what load_mjcf() reads, made lean for a task."""

from __future__ import annotations

import math

import numpy as np

from .. import _core
from .._robots.axes import axis_of, with_axis
from .._robots.compiled import Compiled
from .._robots.robot import Robot

_SOFTEST = 1e-8  # 1/rad, of the greatest torque: by what part of it a driven torque falls as its joint turns by 1 rad


def drive(robot: Robot) -> dict[int, float]:
    """Lets batches set torques: each actuated hinge gets a servo so soft, N m/rad, that its pull is the same at all angles.

    It pulls with stiffness * (target - angle), so that a torque is a target far away; it follows the joint's axis within
    a step, which a torque in the axes of the world does not. Returns stiffnesses by the place of the coordinate.
    """
    joints, stiffnesses = list(robot.scene.joints), {}
    for actuator in robot.actuators:
        of = robot.coordinates[actuator.coordinate]
        definition = joints[of.joint].definition
        if actuator.kind != "force" or of.kind != "hinge":
            raise _core.Error(f"{robot.name}: actuator {actuator.name} is no motor of a hinge; expected one")
        stiffness = _SOFTEST * abs(actuator.gain)
        axis = axis_of(definition.kind, of.axis)
        axis.motor = _core.JointMotor(max_force=math.inf, servo=_core.JointServo(stiffness=stiffness))
        definition.kind = with_axis(definition.kind, of.axis, axis)
        joints[of.joint].definition = definition
        stiffnesses[actuator.coordinate] = stiffness
    robot.scene.joints = joints
    return stiffnesses


def grip(robot: Robot, model: Compiled) -> None:
    """Gives all that touches the ground the friction that MuJoCo has there: the larger of the two coefficients.

    A contact here has their geometric mean, so the ground keeps its own and shapes get the square of what is wanted over
    that. Shapes of the robot that meet each other have the geometric mean of these.
    """
    m = model.arrays
    ground = float(m.geom_friction[m.geom_bodyid == 0][0][0])
    bodies = list(robot.scene.bodies)
    for body in bodies:
        definition = body.definition
        shape = definition.shape
        if not isinstance(shape, _core.Compound):
            continue
        geoms = geoms_of(model, _body_named(model, body.name))
        children = list(shape.children)
        for child, geom in zip(children, geoms, strict=True):
            wanted = max(ground, float(m.geom_friction[geom][0]))
            child.material = _core.Material(friction=wanted**2 / ground)
        definition.shape = _core.Compound(children)
        body.definition = definition
    robot.scene.bodies = bodies


def _body_named(model: Compiled, name: str) -> int:
    return next(body for body in range(1, model.arrays.nbody) if model.name("BODY", body) == name)


def geoms_of(model: Compiled, root: int) -> list[int]:
    """The model's geoms by children of the compound of a body, with all that is welded to it."""
    m = model.arrays
    touches = (m.geom_contype != 0) | (m.geom_conaffinity != 0)
    return [geom for geom in range(m.ngeom) if touches[geom] and m.body_weldid[m.geom_bodyid[geom]] == root]
