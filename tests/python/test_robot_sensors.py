"""Sensors of models read what MuJoCo's do."""

from __future__ import annotations

from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np
import pytest
from numpy.typing import NDArray

import atoll
from atoll._robots import Verdict

Floats = NDArray[np.float64]

MODEL = """
<mujoco><compiler angle="radian"/><option timestep="1e-3" gravity="1 -2 -9"/>
  <default><geom contype="0" conaffinity="0"/></default><worldbody>
  <body name="base" pos=".1 .2 .3" euler=".3 -.2 .1">
    <joint name="shoulder" axis="0 1 1"/><geom type="box" size=".1 .05 .2" pos=".1 0 .1" mass="2"/>
    <site name="low" pos=".05 .02 -.1" euler=".5 .4 .3"/>
    <body name="cover" pos="0 .1 .1" euler="0 0 .7"><geom size=".04" mass=".3"/><site name="side" pos=".1 0 0"/></body>
    <body name="hand" pos=".2 0 .3" euler="-.2 .3 0">
      <joint name="reach" type="slide" axis="1 0 0"/><geom name="palm" type="capsule" size=".03 .1" pos="0 .05 0" mass=".7"/>
      <site name="tip" pos=".02 .1 0" quat=".8 .2 -.3 .4"/>
    </body>
  </body>
  <body name="drone" pos="1 0 1"><freejoint/><geom type="box" size=".1 .2 .05" pos=".03 0 0" mass="1.5"/>
    <site name="imu" pos=".1 .05 -.02" euler="1 .5 .2"/></body>
  </worldbody><sensor>
    <jointpos name="q0" joint="shoulder"/><jointpos name="q1" joint="reach" cutoff=".05"/>
    <jointvel name="v0" joint="shoulder"/><jointvel name="v1" joint="reach"/>
    {}
    <accelerometer name="acc_imu" site="imu"/><accelerometer name="acc_tip" site="tip"/>
    <force name="load" site="tip"/><torque name="moment" site="low"/><force name="of_cover" site="side"/>
    <rangefinder name="range" site="imu"/><framepos name="relative" objtype="site" objname="tip" reftype="site" refname="low"/>
  </sensor></mujoco>"""
KINEMATIC = ("framepos", "framequat", "framexaxis", "frameyaxis", "framezaxis", "framelinvel", "frameangvel")
PLACES = {
    "site": ("low", "side", "tip", "imu"),
    "body": ("cover", "hand"),
    "xbody": ("cover", "drone"),
    "geom": ("palm",),
}
FRAMES = "".join(
    f'<{kind} name="{kind}_{of}_{name}" objtype="{of}" objname="{name}"/>'
    for kind in KINEMATIC
    for of, names in PLACES.items()
    for name in names
) + "".join(
    f'<{kind} name="{kind}_{site}" site="{site}"/>' for kind in ("gyro", "velocimeter") for site in PLACES["site"]
)


def data_at(text: str, random: np.random.Generator) -> tuple[Any, Any]:
    """At a random state."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:] = random.uniform(-1, 1, model.nq)
    data.qpos[-4:] /= np.linalg.norm(data.qpos[-4:])
    data.qvel[:] = random.uniform(-2, 2, model.nv)
    mujoco.mj_forward(model, data)
    return model, data


def set_state(robot: atoll.Robot, world: atoll.World, model: Any, data: Any) -> None:
    """Gives bodies the poses and velocities of MuJoCo's."""
    for name, place in robot.bodies.items():
        body = model.body(name).id
        if model.body_weldid[body] != body or body == 0:
            continue
        pose = atoll.Pose(data.xpos[body], np.roll(data.xquat[body], -1))
        world.set_pose(world.bodies[place], pose)
        speeds = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, speeds, 0)
        arm = np.asarray(world.centre_of_mass(world.bodies[place])) - data.xpos[body]
        world.set_velocity(world.bodies[place], speeds[3:] + np.cross(speeds[:3], arm), speeds[:3])


def sensor_data(model: Any, data: Any, name: str) -> Floats:
    values = np.array(data.sensor(name).data)
    return np.roll(values, -1) if name.startswith("framequat") else values


def test_kinematic_sensors_read_the_same_at_random_states() -> None:
    text = MODEL.format(FRAMES)
    robot = atoll.load_mjcf(text)
    left_out = {line.name for line in robot.receipt.of(Verdict.LEFT_OUT)}
    assert left_out == {"range", "relative", "of_cover"}
    random = np.random.default_rng(4)
    for _ in range(10):
        model, data = data_at(text, random)
        world = robot.build()
        set_state(robot, world, model, data)
        read = robot.read(world)
        assert list(read) == [
            model.sensor(n).name for n in range(model.nsensor) if model.sensor(n).name not in left_out
        ]
        assert np.isnan(read["acc_imu"]).all()
        for name, value in read.items():
            if name.split("_")[0] in ("acc", "load", "moment"):
                continue
            wanted = sensor_data(model, data, name)
            if name.startswith("framequat"):
                value = value * np.sign(value @ wanted)
            assert value == pytest.approx(wanted, abs=1e-9), name


def test_accelerations_and_loads_converge_to_the_same() -> None:
    text = MODEL.format("")
    random = np.random.default_rng(5)
    model, data = data_at(text, random)
    robot = atoll.load_mjcf(text)
    errors = []
    for step in (1e-3, 1e-4):
        world = robot.build()
        set_state(robot, world, model, data)
        before = robot.motion(world)
        world.step(step)
        read = robot.read(world, before, step)
        names = ("acc_imu", "acc_tip", "load", "moment")
        errors.append(max(float(np.abs(read[name] - sensor_data(model, data, name)).max()) for name in names))
    assert errors[0] < 0.2 and errors[1] < errors[0] / 5  # of first order in the step


def test_touch_reads_what_presses_on_its_site() -> None:
    model = """
    <mujoco><worldbody><geom type="plane" size="1 1 1"/>
      <body pos="0 0 .1"><freejoint/><geom type="box" size=".3 .1 .1" mass="3"/>
        <site name="all" type="box" size=".31 .11 .11"/><site name="left" type="sphere" size=".15" pos="-.3 0 -.1"/>
        <site name="left end" type="capsule" size=".02 .12" pos="-.3 0 -.1" euler="90 0 0"/>
        <site name="corner" type="ellipsoid" size=".05 .02 .02" pos=".3 .1 -.1"/>
        <site name="middle" type="cylinder" size=".2 .2"/></body>
    </worldbody><sensor><touch name="all" site="all"/><touch name="left" site="left"/><touch name="left end" site="left end"/>
      <touch name="corner" site="corner"/><touch name="middle" site="middle"/></sensor></mujoco>"""
    robot = atoll.load_mjcf(model)
    world = robot.build()
    world.steps(240, 1 / 240)
    read = {name: float(value[0]) for name, value in robot.read(world).items()}
    weight = 3 * 9.81
    assert read["all"] == pytest.approx(weight, rel=1e-3)
    assert read["left"] == read["left end"] == pytest.approx(weight / 2, rel=1e-2)
    assert read["corner"] == pytest.approx(weight / 4, rel=1e-1)
    assert read["middle"] == 0


def test_says_what_is_wrong_with_what_was_before() -> None:
    robot = atoll.load_mjcf(MODEL.format(""))
    world = robot.build()
    with pytest.raises(atoll.Error, match=r"shape \(3,\); expected \(2, 3\)"):
        robot.read(world, [0, 0, 0], 1)
    with pytest.raises(atoll.Error, match="seconds is 0; expected a time > 0"):
        robot.read(world, robot.motion(world))
