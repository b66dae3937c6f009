"""Models of MuJoCo's: masses, poses and motion are those of its own compiler and integrator."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np
import pytest
from numpy.typing import NDArray

import atoll
from atoll._robots import Verdict, command
from atoll._robots.quaternions import turn_to, turned

Floats = NDArray[np.float64]

ARM = """
<mujoco model="arm">
  <compiler angle="radian"/>
  <option timestep="0.004"/>
  <default><joint damping="0.2" armature="0.02"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1"/>
    <body name="base" pos="0 0 1">
      <geom type="cylinder" size=".1 .1" mass="5"/>
      <body name="upper" pos="0 0 .1" quat=".9 .1 .2 .3">
        <inertial pos=".02 .1 .2" mass="3" fullinertia=".05 .06 .02 .003 .002 .001"/>
        <joint name="shoulder" axis="1 1 0" range="-3 3" limited="true" ref=".3" springref=".1" stiffness="2"/>
        <geom type="capsule" size=".04 .15" pos="0 0 .2" contype="0" conaffinity="0"/>
        <body name="lower" pos=".1 0 .4" euler=".3 .5 .7">
          <joint name="elbow" axis="0 1 0"/>
          <geom type="box" size=".03 .04 .2" pos="0 0 .2" density="800"/>
          <body name="flange" pos="0 0 .4"><geom type="sphere" size=".05" density="2000"/></body>
          <body name="rod" pos="0 .1 .3">
            <joint name="slide" type="slide" axis="0 .6 .8" ref=".05"/>
            <geom type="ellipsoid" size=".03 .04 .1" mass=".7"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <keyframe><key name="bent" qpos=".8 -.5 .1"/></keyframe>
</mujoco>
"""


def test_turns_lead_to_any_axis() -> None:
    random = np.random.default_rng(2)
    axes = [random.normal(size=3) for _ in range(20)]
    axes += [np.array([-1, *(10.0**-power * random.normal(size=2))]) for power in range(20)]
    axes += [np.array([sign, 0, 0]) for sign in (1.0, -1.0)]
    for axis in axes:
        axis = axis / np.linalg.norm(axis)
        turn = turn_to(axis)
        assert np.linalg.norm(turn) == pytest.approx(1, abs=1e-15)
        assert turned(turn, [1, 0, 0]) == pytest.approx(axis, abs=1e-15)


def data_of(text: str, key: int | None = None) -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    if key is not None:
        mujoco.mj_resetDataKeyframe(model, data, key)
    mujoco.mj_forward(model, data)
    return model, data


def test_bodies_weigh_and_stand_as_compiled() -> None:
    for pose, key in ((None, None), ("bent", 0)):
        model, data = data_of(ARM, key)
        robot = atoll.load_mjcf(ARM, pose)
        world = robot.build()
        assert robot.positions(world) == pytest.approx(data.qpos, abs=1e-12)
        ids = world.bodies
        for name, parts in (("upper", ["upper"]), ("lower", ["lower", "flange"]), ("rod", ["rod"])):
            body = ids[robot.bodies[name]]
            numbers = [model.body(part).id for part in parts]
            mass = sum(model.body_mass[n] for n in numbers)
            centre = sum(model.body_mass[n] * data.xipos[n] for n in numbers) / mass
            inertia = np.zeros((3, 3))
            for n in numbers:
                axes, arm = data.ximat[n].reshape(3, 3), data.xipos[n] - centre
                inertia += axes @ np.diag(model.body_inertia[n]) @ axes.T
                inertia += model.body_mass[n] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
            assert world.mass(body) == pytest.approx(mass, rel=1e-12)
            assert world.centre_of_mass(body) == pytest.approx(centre, abs=1e-12)
            frame = data.xmat[numbers[0]].reshape(3, 3)
            definition = world.definition(body)
            assert definition.inertia is not None
            assert frame @ definition.inertia @ frame.T == pytest.approx(inertia, abs=1e-12)
            assert world.pose(body).position == pytest.approx(data.xpos[numbers[0]], abs=1e-12)


def errors_of(text: str, steps: list[float]) -> list[float]:
    """rad or m, the most of a coordinate after .4 s, against MuJoCo's Runge-Kutta in fine steps."""
    seconds = 0.4
    model, data = data_of(text, 0)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.timestep = 1 / 9600
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    robot = atoll.load_mjcf(text, "bent")
    errors = []
    for step in steps:
        world = robot.build()
        for _ in range(round(seconds / step)):
            world.step(step)
        errors.append(float(np.abs(robot.positions(world) - data.qpos).max()))
    return errors


def test_motion_converges_to_that_of_runge_and_kutta() -> None:
    assert max(errors_of(ARM, [1 / 60, 1 / 240])) < 1e-4
    for armature in ('armature="0.02"', ""):
        for damping in ('damping="0.2"', ""):
            arm = ARM.replace('damping="0.2"', damping).replace('armature="0.02"', armature)
            coarse, fine = errors_of(arm, [1 / 240, 1 / 960])
            assert fine < coarse / 12, (armature, damping)  # of second order: a sixteenth


def test_servos_and_velocities_and_forces_drive() -> None:
    model = """
    <mujoco><option gravity="0 0 0"/><default><geom contype="0" conaffinity="0" size=".1"/></default><worldbody>
      <body><joint name="a" axis="0 0 1"/><geom mass="1"/></body>
      <body pos="1 0 0"><joint name="b" axis="0 0 1"/><geom mass="1"/></body>
      <body pos="2 0 0"><joint name="c" type="slide" axis="1 0 0"/><geom mass="2"/></body>
    </worldbody><actuator>
      <position name="p" joint="a" kp="3" kv=".2" gear="2"/>
      <velocity name="v" joint="b" kv=".5"/>
      <motor name="m" joint="c" gear="4" ctrlrange="-1 1" ctrllimited="true"/>
    </actuator></mujoco>"""
    compiled, data = data_of(model)
    data.ctrl[:] = [0.6, 1.5, 9]
    compiled.opt.timestep = 1e-4
    compiled.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    for _ in range(5000):
        mujoco.mj_step(compiled, data)
    robot = atoll.load_mjcf(model)
    assert [a.kind for a in robot.actuators] == ["position", "velocity", "force"]
    world = robot.build()
    for _ in range(500):
        robot.control(world, [0.6, 1.5, 9])
        world.step(1e-3)
    assert robot.positions(world) == pytest.approx(data.qpos, abs=2e-3)
    assert robot.rates(world) == pytest.approx(data.qvel, abs=2e-3)
    with pytest.raises(atoll.Error, match=r"shape \(2,\); expected \(3,\)"):
        robot.control(world, [0, 0])


@pytest.mark.parametrize(
    "flag", ["gravity", "contact", "limit", "frictionloss", "spring", "damper", "equality", "constraint", "actuation"]
)
def test_flags_switch_off(flag: str) -> None:
    """Each force of a slider by itself: it stays at rest, or moves on, where the flag is off."""
    parts = {
        "gravity": ('<option gravity="1 0 0"/>', "", "", ""),
        "contact": ("", "", '<body pos=".15 0 0"><geom size=".1"/></body>', ""),
        "limit": ("", 'range=".5 1"', "", ""),
        "frictionloss": ("", 'frictionloss="1e3"', "", ""),
        "spring": ("", 'stiffness="100" springref="1"', "", ""),
        "damper": ("", 'damping="1e3"', "", ""),
        "equality": ("", "", "", '<equality><connect body1="a" body2="world" anchor="0 0 0"/></equality>'),
        "actuation": (
            "",
            "",
            "",
            '<actuator><position joint="j" kp="100" ctrlrange=".5 1" ctrllimited="true"/></actuator>',
        ),
    }
    parts["constraint"] = parts["limit"]
    option, joint, body, more = parts[flag]
    positions = []
    for value in ("enable", "disable"):
        robot = atoll.load_mjcf(f"""
        <mujoco><option gravity="0 0 0"><flag {flag}="{value}"/></option>{option}<worldbody>
          <body name="a"><joint name="j" type="slide" axis="1 0 0" {joint}/><geom size=".1"/></body>{body}
        </worldbody>{more}</mujoco>""")
        world = robot.build()
        world.set_velocity(world.bodies[robot.bodies["a"]], [0.1, 0, 0], [0, 0, 0])
        for _ in range(60):
            if robot.actuators:
                robot.control(world, [0.5])
            world.step(1 / 240)
        positions.append(float(robot.positions(world)[0]))
    assert positions[1] == pytest.approx(0.1 * 60 / 240, rel=1e-6)
    assert abs(positions[0] - positions[1]) > 1e-3


def test_a_start_beyond_a_range_or_in_another_shape_is_told() -> None:
    robot = atoll.load_mjcf("""
    <mujoco><compiler angle="radian"/><worldbody>
      <body name="a"><joint name="j" range=".2 1"/><geom size=".1" pos=".3 0 0"/></body>
      <body name="b" pos=".45 0 0"><freejoint/><geom size=".1"/></body></worldbody></mujoco>""")
    by_name = {line.name: line.note for line in robot.receipt.lines if line.element == "pose"}
    assert by_name["j"].startswith("0.2 m or rad beyond") and "overlap by 0.05 m" in by_name["a and b"]


def test_nothing_is_dropped_without_a_line() -> None:
    robot = atoll.load_mjcf("""
    <mujoco model="odds"><worldbody><site name="eye" pos="0 0 1"/>
      <body name="x"><joint name="j"/><joint name="k" axis="0 1 1"/><geom name="g" size=".1"/><site name="s"/></body>
      <body name="y" pos="1 0 0"><joint name="l" type="ball" damping="1"/><geom size=".1"/></body>
    </worldbody>
    <tendon><spatial name="t"><site site="eye"/><site site="s"/></spatial>
      <fixed name="u"><joint joint="j" coef="1"/></fixed></tendon>
    <equality><joint name="e" joint1="j" joint2="k"/><tendon name="f" tendon1="t" tendon2="u"/></equality>
    <actuator><motor name="pull" tendon="t"/><general name="m" joint="j" dyntype="filter" dynprm="1"/></actuator>
    <sensor><magnetometer name="turn" site="s"/></sensor></mujoco>""")
    left_out = {(line.element, line.name) for line in robot.receipt.of(Verdict.LEFT_OUT)}
    expected = {("tendon", "t"), ("equality", "f"), ("actuator", "pull"), ("actuator", "m")}
    assert left_out == expected | {("sensor", "turn")}
    taken = {(line.element, line.name) for line in robot.receipt.of(Verdict.TAKEN_AS)}
    assert ("joint", "j") in taken  # one of two in a body: another one carries the other
    assert ("joint", "l") in taken  # a damped ball
    assert ("equality", "e") in taken  # a tendon
    assert len(robot.coordinates) == 2
    assert "tendon t: left out" in robot.receipt.text()
    assert '"name": "turn"' in robot.receipt.json()


def test_scenes_of_robots_are_files(tmp_path: Path) -> None:
    robot = atoll.load_mjcf(ARM, "bent")
    robot.scene.write(str(tmp_path / "arm.json"))
    again = atoll.load_scene(str(tmp_path / "arm.json")).build()
    world = robot.build()
    for _ in range(50):
        world.step(1 / 240)
        again.step(1 / 240)
    assert world.state_hash() == again.state_hash()


def imports(*words: str | Path) -> int:
    return command.main([str(word) for word in words])


def test_the_command_writes_scene_and_receipt(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, scene, receipt = tmp_path / "arm.xml", tmp_path / "arm.json", tmp_path / "receipt.json"
    model.write_text(ARM)
    assert imports(model, "-o", scene, "--pose", "bent", "--strict") == 0
    assert capsys.readouterr().out.startswith("arm: exact: ")
    world = atoll.load_scene(str(scene)).build()
    assert world.state_hash() == atoll.load_mjcf(ARM, "bent").build().state_hash()

    model.write_text(
        ARM.replace('<option timestep="0.004"/>', '<option timestep="0.004" density="1.2"/>'),
    )
    assert imports(model, "-o", scene, "--receipt", receipt) == 0
    assert capsys.readouterr().out == ""
    lines = json.loads(receipt.read_text())["lines"]
    assert [line["name"] for line in lines if line["verdict"] == "left out"] == ["density, viscosity"]
    assert imports(model, "-o", scene, "--strict", "--receipt", receipt.with_suffix(".txt")) == 1
    assert "option density, viscosity: left out" in receipt.with_suffix(".txt").read_text()

    model.write_text('<robot name="r"><link name="world"/></robot>')
    assert imports(model, "-o", scene, "--fixed-base") == 0
    capsys.readouterr()
    for words, said in (
        ((model, "-o", scene, "--pose", "home"), "--pose is home; expected none for a URDF"),
        ((tmp_path / "none.xml", "-o", scene), "No such file"),
        ((scene, "-o", scene), "expected a robot model"),
    ):
        assert imports(*words) == 3
        assert said in capsys.readouterr().err


def test_says_what_is_wrong() -> None:
    with pytest.raises(atoll.Error, match="MuJoCo refuses the model"):
        atoll.load_mjcf("<mujoco><worldbody><body/></worldbody><oops/></mujoco>")
    with pytest.raises(atoll.Error, match="pose is 'sitting'; expected one of the model's keyframes: bent"):
        atoll.load_mjcf(ARM, "sitting")


LOOP = """
<mujoco><option timestep="0.002"/><default><geom contype="0" conaffinity="0"/></default><worldbody>
  <body name="crank" pos="0 0 1"><joint name="turn" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .1 0 0" size=".01"/>
    <body name="rod" pos=".1 0 0"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".01"/>
      <body name="tip" pos=".3 0 0"><geom size=".02"/></body></body></body>
  <body name="slider" pos=".4 0 1"><joint name="slide" type="slide" axis="1 0 0"/><geom type="box" size=".03 .03 .03"/>
    <site name="pin"/></body>
  <body name="load" pos=".5 .1 1.2" euler="10 20 30"><freejoint/><geom type="box" size=".02 .03 .04"/></body>
</worldbody><equality>
  <connect name="loop" body1="tip" body2="slider" anchor="0 0 0"/>
  <weld name="carried" body1="slider" body2="load"/>
  <connect name="off" body1="crank" body2="load" anchor="0 0 0" active="false"/>
  <joint name="follows" joint1="turn" joint2="slide" active="false"/>
</equality></mujoco>"""


def test_loops_are_closed_by_joints() -> None:
    robot = atoll.load_mjcf(LOOP)
    by_name = {line.name: line.verdict for line in robot.receipt.lines if line.element == "equality"}
    assert by_name == {
        "loop": Verdict.TAKEN_AS,
        "carried": Verdict.TAKEN_AS,
        "off": Verdict.LEFT_OUT,
        "follows": Verdict.LEFT_OUT,
    }
    world = robot.build()
    start = world.pose(world.bodies[robot.bodies["load"]])
    for _ in range(240):
        world.step(1 / 240)
    # A crank of .1 m and a rod of .3 m: where the slider is follows from the angle.
    angle = robot.positions(world)[0]
    stroke = 0.1 * np.cos(angle) + (0.3**2 - (0.1 * np.sin(angle)) ** 2) ** 0.5
    slider = robot.positions(world)[-1]
    assert abs(angle) > 0.5 and 0.4 + slider == pytest.approx(stroke, abs=1e-5)
    load = world.pose(world.bodies[robot.bodies["load"]])
    assert load.position == pytest.approx(np.asarray(start.position) + [slider, 0, 0], abs=1e-5)
    assert load.orientation == pytest.approx(np.asarray(start.orientation), abs=1e-4)


def test_ball_joints_spring_damp_and_stop() -> None:
    model = """
    <mujoco><option gravity="0 0 0" integrator="RK4" timestep="1e-4"/><compiler angle="radian"/><worldbody>
      <body name="a" euler=".3 .2 .1"><joint name="j" type="ball" {}/><geom type="box" size=".1 .2 .3" density="1000"/></body>
    </worldbody></mujoco>"""
    spring = model.format('stiffness="40" damping=".8" armature=".1"')
    compiled, data = data_of(spring)
    robot = atoll.load_mjcf(spring)
    world = robot.build()
    body = world.bodies[robot.bodies["a"]]
    turning = np.array([0.05, 0.1, -0.08])
    data.qvel[:] = turning  # in the body's frame
    rotation = data.xmat[1].reshape(3, 3).copy()
    world.set_velocity(body, [0, 0, 0], rotation @ turning)
    for _ in range(10000):
        mujoco.mj_step(compiled, data)
    for _ in range(1000):
        world.step(1e-3)
    assert np.linalg.norm(data.qpos[1:]) > 5e-3
    assert np.roll(world.pose(body).orientation, 1) == pytest.approx(data.xquat[1], abs=2e-5)

    robot = atoll.load_mjcf(model.format('range="0 .5" limited="true"'))
    world = robot.build()
    body = world.bodies[robot.bodies["a"]]
    start = world.pose(body).orientation
    world.set_velocity(body, [0, 0, 0], rotation @ [1, 0, 0])
    for _ in range(240):
        world.step(1 / 240)
    apart = 2 * np.arccos(min(1.0, abs(float(start @ world.pose(body).orientation))))
    assert apart == pytest.approx(0.5, abs=1e-3)


def test_joints_rub_beside_their_servos() -> None:
    """As near to its target as where the servo pulls by less than the friction, and as MuJoCo's comes on the way."""
    text = """
    <mujoco>
      <option gravity="0 0 0" timestep="0.0005" integrator="RK4"/>
      <worldbody>
        <body>
          <joint name="turn" axis="0 0 1" damping="3" frictionloss="2" solreffriction="0.001 1"/>
          <geom type="box" size=".3 .1 .1" mass="10" contype="0" conaffinity="0"/>
        </body>
      </worldbody>
      <actuator><position name="servo" joint="turn" kp="20"/></actuator>
    </mujoco>
    """
    robot = atoll.load_mjcf(text)
    hinge = robot.scene.joints[0].definition.kind
    assert isinstance(hinge, atoll.HingeJoint)
    motor = hinge.angle.motor
    assert hinge.angle.friction == 2
    assert motor is not None and motor.servo is not None and motor.servo.stiffness == 20
    assert not [line for line in robot.receipt.lines if line.verdict == Verdict.LEFT_OUT]

    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.ctrl[0] = 1
    world = robot.build()
    robot.control(world, [1.0])
    for _ in range(240):
        world.step(1 / 240)
    while data.time < 1:
        mujoco.mj_step(model, data)
    assert robot.positions(world) == pytest.approx(data.qpos, abs=2e-3)
    for _ in range(2000):
        world.step(1 / 240)
    assert 20 * abs(1 - robot.positions(world)[0]) <= 2.02
    assert abs(robot.rates(world)[0]) < 1e-6
