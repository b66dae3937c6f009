"""Equalities of joints, fixed tendons and their actuators, beside MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest

import atoll
from atoll._robots.receipt import Verdict

mujoco = pytest.importorskip("mujoco")

GRIPPER = """
<mujoco model="gripper"><compiler angle="radian"/><option gravity="0 0 -9.81"/>
<default><geom contype="0" conaffinity="0"/><equality solref=".001 1" solimp=".999 .9999 .0001"/></default>
<worldbody><body name="palm" pos="0 0 1">
  <joint name="lift" axis="0 1 0" damping=".5"/><geom type="box" size=".1 .1 .02" pos=".1 0 0" mass="1"/>
  <body name="left" pos=".1 0 -.1"><joint name="left" type="slide" axis="1 0 0" ref=".02" damping="3"/>
    <geom type="box" size=".01 .02 .1" mass=".2"/></body>
  <body name="right" pos="-.1 0 -.1"><joint name="right" type="slide" axis="-1 0 0" damping="3"/>
    <geom type="box" size=".01 .02 .1" mass=".3"/></body>
</body></worldbody>
<equality><joint name="mimic" joint1="right" joint2="left" polycoef="0 .8 3 0 0"/></equality>
<actuator><position name="close" joint="left" kp="200" kv="10"/></actuator></mujoco>"""

FINGER = """
<mujoco model="finger"><compiler angle="radian"/><option gravity="0 0 -9.81"/>
<default><geom contype="0" conaffinity="0"/><joint damping=".02" axis="0 1 0"/></default>
<worldbody><body name="near" pos="0 0 1"><joint name="near"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".03" mass=".4"/>
  <body name="far" pos=".3 0 0"><joint name="far" ref=".1"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" mass=".2"/>
</body></body></worldbody>
<tendon><fixed name="flexor" stiffness="2" damping=".1" springlength=".3" armature=".003">
  <joint joint="near" coef="1"/><joint joint="far" coef="-.6"/></fixed>
  <fixed name="stop" limited="true" range="-5 5"><joint joint="near" coef="1"/></fixed>
  <fixed name="rub" frictionloss=".05" solreffriction=".001 1" solimpfriction=".999 .9999 .0001"><joint joint="near" coef="1"/><joint joint="far" coef="1"/></fixed></tendon>
<actuator><position name="pull" tendon="flexor" kp="6" kv=".2" gear="1.5"/><motor name="push" tendon="stop" gear=".5"/></actuator>
</mujoco>"""


def of_mujoco(text: str, seconds: float, controls: list[float]) -> np.ndarray:
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = 1e-4
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    data.ctrl[:] = controls
    path = []
    for step in range(1, round(seconds / model.opt.timestep) + 1):
        mujoco.mj_step(model, data)
        if step % 100 == 0:
            path.append(data.qpos.copy())
    return np.array(path)


def of_atoll(robot: atoll.Robot, seconds: float, controls: list[float]) -> np.ndarray:
    world = robot.build()
    path = []
    for _ in range(round(seconds / 0.01)):
        for _ in range(10):
            robot.control(world, controls)
            world.step(1e-3)
        path.append(robot.positions(world))
    return np.array(path)


def verdicts(robot: atoll.Robot, element: str) -> dict[str, Verdict]:
    return {line.name: line.verdict for line in robot.receipt.lines if line.element == element}


def test_a_mimicking_gripper_moves_as_mujocos() -> None:
    robot = atoll.load_mjcf(GRIPPER)
    assert verdicts(robot, "equality") == {"mimic": Verdict.TAKEN_AS}
    ours, theirs = of_atoll(robot, 0.6, [0.1]), of_mujoco(GRIPPER, 0.6, [0.1])
    lift, left, right = ours.T
    assert left.max() > 0.05
    # From where the model has them at first: the left one counts from 0.02 m.
    assert right == pytest.approx(0.8 * (left - 0.02) + 3 * (left - 0.02) ** 2, abs=1e-6)
    assert np.abs(ours - theirs).max() < 2e-4  # m and rad


def test_a_finger_on_tendons_moves_as_mujocos() -> None:
    robot = atoll.load_mjcf(FINGER)
    assert set(verdicts(robot, "tendon").values()) == {Verdict.EXACT}
    assert verdicts(robot, "actuator") == {"pull": Verdict.EXACT, "push": Verdict.TAKEN_AS}
    assert [(a.coordinate, a.kind) for a in robot.actuators] == [(-1, "position"), (-1, "force")]
    controls = [0.9, 0.4]
    ours, theirs = of_atoll(robot, 0.5, controls), of_mujoco(FINGER, 0.5, controls)
    assert np.ptp(ours, axis=0).min() > 0.3
    assert np.abs(ours - theirs).max() < 1e-3  # rad


def test_a_joint_that_follows_nobody_stays() -> None:
    robot = atoll.load_mjcf(
        GRIPPER.replace('joint2="left" polycoef="0 .8 3 0 0"', 'polycoef=".03 0 0 0 0"').replace(
            'name="right" type', 'ref=".01" name="right" type'
        )
    )
    assert of_atoll(robot, 0.1, [0])[-1][2] == pytest.approx(0.04, abs=1e-6)


def test_what_tendons_cant_be_is_told() -> None:
    many = "".join(f'<joint joint="j{i}" coef="1"/>' for i in range(5))
    bodies = "".join(f'<body pos="{i} 0 0"><joint name="j{i}"/><geom size=".1"/></body>' for i in range(5))
    robot = atoll.load_mjcf(
        f'<mujoco><worldbody>{bodies}</worldbody><tendon><fixed name="wide">{many}</fixed>'
        '<fixed name="slack" stiffness="1" springlength="0 1"><joint joint="j0" coef="1"/></fixed></tendon></mujoco>'
    )
    notes = {line.name: line.note for line in robot.receipt.lines if line.element == "tendon"}
    assert "runs over 5 joints" in notes["wide"] and "slack" in notes["slack"]


def test_robots_with_tendons_are_files() -> None:
    for text in (GRIPPER, FINGER):
        robot = atoll.load_mjcf(text)
        world = robot.build()
        again = atoll.parse_scene(robot.scene.text()).build()
        world.steps(20, 0.005)
        again.steps(20, 0.005)
        assert world.state_hash() == again.state_hash()
