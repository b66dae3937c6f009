"""Several joints in one body, which are one joint of the scene where they are at right angles."""

from __future__ import annotations

from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np
import pytest

import atoll

from test_robots import errors_of

#: A trunk in a plane; a shoulder of two hinges; a hip of three, left-handed; and a wrist that leans.
BODY = """
<mujoco><compiler angle="radian"/>
<default><geom contype="0" conaffinity="0"/><joint limited="false"/></default>
<worldbody>
  <body name="trunk" pos="0 0 1.25">
    <joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1" ref="1.25" damping="3"/>
    <joint name="turn" axis="0 1 0" stiffness="2" armature=".01"/><geom type="box" size=".2 .1 .3"/>
    <body name="arm" pos="0 .2 .3">
      <joint name="lift" axis="2 1 1" pos="0 0 .02" damping=".1"/>
      <joint name="swing" axis="0 -1 1" pos="0 0 .02" stiffness="4" springref=".3"/>
      <geom type="capsule" fromto="0 0 0 .1 .1 -.3" size=".04"/>
      <body name="hand" pos=".1 .1 -.3">
        <joint name="nod" axis="0 1 0"/>LEAN<geom type="box" size=".05 .1 .02" pos="0 0 -.1"/>
      </body></body>
    <body name="leg" pos="0 -.1 -.3" quat="1 .1 -.2 .3">
      <joint name="hip_x" axis="1 0 0" armature=".01" damping=".2"/>
      <joint name="hip_z" axis="0 0 1" armature=".02" range="-1 .6"/>
      <joint name="hip_y" axis="0 1 0" armature=".03" stiffness="1"/>
      <geom type="capsule" fromto="0 0 0 .05 0 -.4" size=".06"/></body></body>
</worldbody>
<actuator>ACTUATORS</actuator>
<keyframe><key name="bent" qpos=".3 1.1 .4 -.5 .7 .2 LEANS .4 -.3 .6"/></keyframe></mujoco>"""
SERVOS = '<position joint="hip_x" kp="30" kv="1"/><position joint="hip_z" kp="20"/><velocity joint="turn" kv="2"/>'
MOTORS = "".join(f'<motor joint="{name}"/>' for name in ("x", "z", "turn", "lift", "swing", "hip_x", "hip_z", "hip_y"))


def body(actuators: str = "", leans: bool = False) -> str:
    lean = ("LEANS", ".1" if leans else ""), ("LEAN", '<joint name="lean" axis="0 1 1"/>' if leans else "")
    text = BODY.replace("ACTUATORS", actuators)
    for what, by in lean:
        text = text.replace(what, by)
    return text


def test_joints_at_right_angles_are_one() -> None:
    robot = atoll.load_mjcf(body(leans=True))
    kinds = {joint.name: joint.definition.kind for joint in robot.scene.joints}
    assert list(kinds) == ["x, z, turn", "lift, swing", "nod", "lean", "hip_x, hip_z, hip_y"]
    assert isinstance(kinds["lean"], atoll.HingeJoint)
    hip = kinds["hip_x, hip_z, hip_y"]
    assert isinstance(hip, atoll.SixDofJoint) and hip.turns == atoll.SixDofTurns.ANGLES_XZY
    names = ["x", "z", "turn", "lift", "swing", "nod", "lean", "hip_x", "hip_z", "hip_y"]
    assert [of.name for of in robot.coordinates] == names
    bent = atoll.load_mjcf(body(leans=True), "bent")
    world = bent.build()
    qpos = [0.3, 1.1, 0.4, -0.5, 0.7, 0.2, 0.1, 0.4, -0.3, 0.6]
    assert bent.positions(world) == pytest.approx(qpos, abs=1e-12)
    assert bent.mechanism(world).q() == pytest.approx(qpos, abs=1e-12)
    between = [body for body in robot.scene.bodies if not body.name and body.definition.type == atoll.BodyType.DYNAMIC]
    assert len(between) == 1, "of the hand's"


# A middle hinge that may come to lie along the others, an angle that doesn't count from 0, and hinges elsewhere.
@pytest.mark.parametrize(
    ("before", "after"), [('range="-1 .6"', ""), ('name="hip_y"', 'name="hip_y" ref=".1"'), ('name="hip_y"', 'pos="0 0 .1"')]
)
def test_others_stay_apart(before: str, after: str) -> None:
    robot = atoll.load_mjcf(body(leans=True).replace(before, after))
    assert len(robot.scene.joints) > 5


@pytest.mark.parametrize("actuators", ["", SERVOS])
def test_they_move_as_those_of_mujoco(actuators: str) -> None:
    coarse, fine = errors_of(body(actuators), [1 / 240, 1 / 960])
    assert coarse < 1e-5 and fine < 1e-6


def test_forces_push_along_one_coordinate() -> None:
    text = body(MOTORS)
    model: Any = mujoco.MjModel.from_xml_string(text)
    robot = atoll.load_mjcf(text, "bent")
    controls, dt = np.random.default_rng(3).uniform(-3, 3, model.nu), 1e-5
    data, speeds = mujoco.MjData(model), []
    for given in (0 * controls, controls):
        mujoco.mj_resetDataKeyframe(model, data, 0)
        data.qvel[:] = 0
        data.ctrl[:] = given
        mujoco.mj_forward(model, data)
        world = robot.build()
        robot.control(world, given)
        world.step(dt)
        speeds.append((robot.rates(world), np.array(data.qacc)))
    pushed = (speeds[1][0] - speeds[0][0]) / dt
    assert pushed == pytest.approx(speeds[1][1] - speeds[0][1], rel=1e-3, abs=1e-3)
