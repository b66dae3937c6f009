"""Scenes of walking robots: what load_mjcf() reads, made lean for a task."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .. import _core
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
        definition = joints[robot.coordinates[actuator.coordinate].joint].definition
        kind = definition.kind
        if actuator.kind != "force" or not isinstance(kind, _core.HingeJoint):
            raise _core.Error(f"{robot.name}: actuator {actuator.name} is no motor of a hinge; expected one")
        stiffness = _SOFTEST * abs(actuator.gain)
        axis = kind.angle
        axis.motor = _core.JointMotor(max_force=math.inf, servo=_core.JointServo(stiffness=stiffness))
        definition.kind = _core.HingeJoint(axis)
        joints[robot.coordinates[actuator.coordinate].joint].definition = definition
        stiffnesses[actuator.coordinate] = stiffness
    robot.scene.joints = joints
    return stiffnesses


def join_planar_root(robot: Robot, model: Compiled) -> None:
    """Makes one joint of the three that hold a root to its plane: slides along x and z, and a hinge about y at its origin.

    So there are no bodies between them, whose masses the model does not have.
    """
    m = model.arrays
    kinds, axes = [int(kind) for kind in m.jnt_type[:3]], np.array(m.jnt_axis[:3])
    slide, hinge = int(model.mujoco.mjtJoint.mjJNT_SLIDE), int(model.mujoco.mjtJoint.mjJNT_HINGE)
    planar = kinds == [slide, slide, hinge] and np.array_equal(axes, np.eye(3)[[0, 2, 1]])
    if not planar or np.any(m.jnt_bodyid[:3] != 1) or np.any(m.jnt_pos[2]) or np.any(m.dof_damping[:3]):
        raise _core.Error(f"{robot.name}: the root isn't free along x and z and about y; expected slides and a hinge")
    bodies, joints = list(robot.scene.bodies), list(robot.scene.joints)
    root, anchor = robot.bodies[model.name("BODY", 1)], joints[0].first
    left_out = {joints[0].second, joints[1].second}
    kept = [place for place in range(len(bodies)) if place not in left_out]
    places = {old: new for new, old in enumerate(kept)}
    definition = bodies[root].definition
    assert definition.mass is not None and definition.inertia is not None
    mass = float(m.body_mass[1])
    definition.mass, definition.inertia = mass, mass / definition.mass * definition.inertia
    bodies[root].definition = definition
    free, locked = _core.JointAxis(), _core.JointAxis(range=_core.JointRange(0, 0))
    plane = _core.SixDofJoint(offset=[free, locked, free], turn=[locked, free, locked])
    frame = _core.Pose(definition.position)
    held = _core.JointDef(kind=plane, frame_first=frame, collide=True)
    made = [_core.SceneJoint(name="root", definition=held, first=places[anchor], second=places[root])]
    for joint in joints[3:]:
        made.append(
            _core.SceneJoint(
                name=joint.name, definition=joint.definition, first=places[joint.first], second=places[joint.second]
            )
        )
    robot.scene.bodies, robot.scene.joints = [bodies[place] for place in kept], made
    robot.bodies = {name: places[place] for name, place in robot.bodies.items()}
    robot.coordinates = [replace(of, joint=of.joint - 2) for of in robot.coordinates[3:]]
    robot.actuators = [replace(of, coordinate=of.coordinate - 3) for of in robot.actuators]


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
