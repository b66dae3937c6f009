"""Robots move as MuJoCo has them at a fine step: by a third of the error, at most, that its own integrator makes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import mujoco  # type: ignore[import-untyped]
import numpy as np
import pytest
from numpy.typing import NDArray

from atoll._robots.compiled import Compiled
from atoll._robots.mjcf import read

from conftest import ROOT, long_test

Floats = NDArray[np.float64]

GYMNASIUM = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
MODELS = ROOT / "build/robot_models"
STEP = 1 / 240
FINE_STEP = 1 / 19200

ARM = """
<mujoco><compiler angle="radian"/>
<default><geom contype="0" conaffinity="0"/><joint damping=".5" armature=".02"/></default>
<worldbody>
  <body pos="0 0 1"><joint name="a" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0 .1 .3" size=".05"/>
    <body pos="0 .1 .3"><joint name="b" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .4 0 0" size=".04"/>
      <body pos=".4 0 0"><joint name="c" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .3 0 .1" size=".03"/>
        <body pos=".3 0 .1"><joint name="d" axis="1 0 0"/><geom type="capsule" fromto="0 0 0 .05 .1 0" size=".02"/>
        </body></body></body></body>
</worldbody>
<actuator>
  <position joint="a" kp="400" kv="20" forcerange="-80 80"/><position joint="b" kp="400" kv="20"/>
  <position joint="c" kp="200" kv="10"/><position joint="d" kp="50" kv="2"/>
</actuator></mujoco>"""

#: A wrist of a few grams that carries a hand, with a damper that stops the wrist alone within a substep.
WRIST = """
<mujoco><compiler angle="radian"/>
<default><geom contype="0" conaffinity="0"/><joint damping=".05" armature=".0002"/></default>
<worldbody>
  <body><joint axis="0 1 0" damping=".5"/><geom type="sphere" size=".012" mass=".01"/>
    <body pos=".03 0 0"><joint axis="0 0 1" damping=".5"/><geom type="box" size=".05 .04 .01" pos=".05 0 0" mass=".3"/>
      <body pos=".1 0 0"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .045 0 0" size=".009" mass=".03"/>
        <body pos=".045 0 0"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .025 0 0" size=".008" mass=".017"/>
        </body></body></body></body>
</worldbody></mujoco>"""


def prepared(model: Any) -> Any:
    """Without what is soft in MuJoCo and rigid here: contacts, ends of ranges and dry friction."""
    off = mujoco.mjtDisableBit
    model.opt.disableflags |= int(off.mjDSBL_CONTACT) | int(off.mjDSBL_LIMIT) | int(off.mjDSBL_FRICTIONLOSS)
    model.dof_frictionloss[:] = 0
    return model


def coordinates(model: Any) -> list[int]:
    kinds = mujoco.mjtJoint
    return [j for j in range(model.njnt) if model.jnt_type[j] in (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE))]


def rates(model: Any) -> Floats:
    """1 rad/s to and fro, so that what falls freely bends as well."""
    values = np.zeros(model.nv)
    for number, joint in enumerate(coordinates(model)):
        size = 1 if model.jnt_type[joint] == int(mujoco.mjtJoint.mjJNT_HINGE) else 0.1
        values[model.jnt_dofadr[joint]] = size * (-1) ** number
    return values


def by_mujoco(model: Any, step: float, integrator: Any, seconds: float, controls: Floats) -> Floats:
    model.opt.timestep, model.opt.integrator = step, integrator
    data = mujoco.MjData(model)
    data.qvel[:] = rates(model)
    data.ctrl[:] = controls
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
    return np.array([data.qpos[model.jnt_qposadr[joint]] for joint in coordinates(model)])


def by_atoll(model: Any, seconds: float, controls: Floats) -> Floats:
    robot = read(Compiled(mujoco, model, None))
    world = robot.build()
    mechanism = robot.mechanism(world)
    at_start = rates(model)[[model.jnt_dofadr[joint] for joint in coordinates(model)]]
    moving = mechanism.v()
    moving[len(moving) - len(at_start) :] = at_start
    mechanism.set(mechanism.q(), moving)
    if robot.actuators:
        robot.control(world, controls[: len(robot.actuators)])
    world.steps(round(seconds / STEP), STEP)
    return robot.positions(world)


def off(positions: Floats, right: Floats) -> float:
    """rad or m. Which full turn an angle is in doesn't count: one on which nothing acts isn't followed over them."""
    apart = positions - right
    return float(np.abs(apart - 2 * np.pi * np.round(apart / (2 * np.pi))).max())


def check(model: Any, seconds: float = 1, controls: Floats | None = None) -> float:
    """Returns our error, rad."""
    given = np.zeros(model.nu) if controls is None else controls
    kinds = mujoco.mjtIntegrator
    right = by_mujoco(prepared(model), FINE_STEP, kinds.mjINT_RK4, seconds, given)
    theirs = off(by_mujoco(model, STEP, kinds.mjINT_IMPLICITFAST, seconds, given), right)
    ours = off(by_atoll(model, seconds, given), right)
    assert ours <= theirs / 3, f"off by {ours:.1e}, implicitfast by {theirs:.1e}"
    return ours


@pytest.fixture(autouse=True)
def folder_for_logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes what it warns of into the folder that it runs in."""
    monkeypatch.chdir(tmp_path)


LIMP = ["ant", "half_cheetah", "hopper", "humanoid", "inverted_double_pendulum", "walker2d_v5"]


@pytest.mark.parametrize("name", LIMP)
def test_limp_models_of_gymnasium_fall_alike(name: str) -> None:
    check(mujoco.MjModel.from_xml_path(str(GYMNASIUM / f"{name}.xml")))


def test_a_limp_arm_and_one_on_servos_move_alike() -> None:
    limp = mujoco.MjModel.from_xml_string(ARM[: ARM.index("<actuator>")] + "</mujoco>")
    assert check(limp) < 1e-4
    check(mujoco.MjModel.from_xml_string(ARM), seconds=0.25, controls=np.array([0.5, -0.4, 0.6, -0.3]))


def test_a_damper_of_a_light_wrist_counts_the_hand() -> None:
    check(mujoco.MjModel.from_xml_string(WRIST))


@long_test
@pytest.mark.parametrize("name", ["iiwa", "jaco", "kinova3", "panda", "sawyer", "ur5e"])
def test_limp_arms_of_robosuite_fall_alike(name: str) -> None:
    path = MODELS / "robosuite/models/assets/robots" / name / "robot.xml"
    if not path.exists():
        pytest.skip("tests/run.sh --long installs the packages that have the models")
    check(mujoco.MjModel.from_xml_path(str(path)))
