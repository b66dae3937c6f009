"""Generalised coordinates: those of MuJoCo's models are held against MuJoCo's own numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import mujoco  # type: ignore[import-untyped]
import numpy as np
import pytest
from numpy.typing import NDArray
from test_robots import ARM

import atoll

Floats = NDArray[np.float64]

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"

CREATURE = """
<mujoco><option gravity="1 -2 -9"/><worldbody>
  <body name="trunk" pos=".3 .2 1" quat=".9 .1 .2 .3"><freejoint name="root"/>
    <inertial pos=".02 .1 .2" mass="3" fullinertia=".05 .06 .04 .003 .002 .001"/>
    <body name="a" pos=".2 0 .1" euler="20 30 40"><joint name="shoulder" type="ball" pos=".01 .02 .03"/>
      <geom type="capsule" size=".04 .15" pos="0 0 .2"/>
      <body name="b" pos=".1 0 .4"><joint name="elbow" axis="0 1 1" armature=".03"/><geom type="box" size=".03 .04 .2"/>
        <body name="c" pos="0 .1 .2" euler="10 0 50"><joint name="grip" type="slide" axis="1 1 0"/>
          <geom size=".05"/></body></body></body>
    <body name="d" pos="-.2 0 .1"><joint name="hip" type="ball"/><geom type="capsule" size=".04 .15" pos="0 .1 .2"/>
      <body name="e" pos="0 0 .3"><joint name="knee" axis="1 0 0" ref="20"/><geom type="box" size=".03 .04 .2"/></body>
    </body>
  </body>
</worldbody></mujoco>"""

SLIDERS = """
<mujoco><worldbody>
  <body><joint name="a" axis="0 0 1"/><geom size=".1" mass="1" pos=".1 0 0"/></body>
  <body pos="1 0 0"><joint name="b" axis="0 1 0"/><geom size=".1" mass="1" pos="0 0 .2"/></body>
  <body pos="2 0 0"><joint name="c" type="slide" axis="1 0 1" armature=".5"/><geom size=".1" mass="2"/></body>
</worldbody></mujoco>"""

SKEW = """
<mujoco><worldbody><body><joint axis="0 1 0"/><joint axis="0 1 1"/><geom size=".1" pos=".3 0 0"/>
  <body pos=".5 0 0"><joint axis="0 1 0"/><geom size=".1" pos=".2 .1 0"/></body></body></worldbody></mujoco>"""

EXACT = {
    "arm": ARM,
    "creature": CREATURE,
    "sliders": SLIDERS,
    "ant": str(ASSETS / "ant.xml"),
    "pendulum": str(ASSETS / "inverted_pendulum.xml"),
    "double pendulum": str(ASSETS / "inverted_double_pendulum.xml"),
}
# Some bodies by several joints in a row.
EXACT |= {
    name: str(ASSETS / f"{name}.xml")
    for name in ("half_cheetah", "hopper", "humanoid", "pusher_v5", "reacher", "swimmer", "walker2d_v5", "point")
}


class Twin:
    """A model in MuJoCo and in Atoll, in the same state."""

    def __init__(self, source: str) -> None:
        text = source.lstrip().startswith("<")
        compile_model = mujoco.MjModel.from_xml_string if text else mujoco.MjModel.from_xml_path
        self.model: Any = compile_model(source)
        self.data: Any = mujoco.MjData(self.model)
        self.robot = atoll.load_mjcf(source)
        self.world = self.robot.build()
        self.mechanism = self.robot.mechanism(self.world)

    def random_state(self, random: np.random.Generator) -> Floats:
        """Returns T: v of ours is T times MuJoCo's qvel, in whose free bases and balls rates are in the body's axes."""
        m, qpos, qvel = self.model, np.array(self.model.qpos0), random.uniform(-2, 2, self.model.nv)
        q, into = np.zeros(self.mechanism.nq), np.eye(m.nv)
        numbers = {joint.name: joint for joint in self.mechanism.joints}
        for joint in range(m.njnt):
            at, dof, kind = int(m.jnt_qposadr[joint]), int(m.jnt_dofadr[joint]), int(m.jnt_type[joint])
            if kind in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
                low, high = m.jnt_range[joint] if m.jnt_limited[joint] else (-1, 1)
                q[at] = qpos[at] = random.uniform(low, high)
                continue
            turn = random.normal(size=4)
            turn /= np.linalg.norm(turn)
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                q[at : at + 3] = qpos[at : at + 3] = random.uniform(-1, 1, 3)
                qpos[at + 3 : at + 7], q[at + 3 : at + 7] = turn, np.roll(turn, -1)
                into[dof + 3 : dof + 6, dof + 3 : dof + 6] = matrix(np.roll(turn, -1))
                continue
            # A ball's frame in its body is turned by f: ours is f^-1 turn f.
            ours = numbers[m.joint(joint).name]
            frame = np.asarray(self.world.joint(ours.joint).frame_second.orientation)
            qpos[at : at + 4] = turn
            q[at : at + 4] = product(product(frame * [-1, -1, -1, 1], np.roll(turn, -1)), frame)
            into[dof : dof + 3, dof : dof + 3] = matrix(frame).T @ matrix(np.roll(turn, -1))
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        mujoco.mj_forward(m, self.data)
        self.mechanism.set(q, into @ qvel)
        return into

    def body(self, name: str) -> atoll.BodyId:
        return self.world.bodies[self.robot.bodies[name]]


def matrix(q: Floats) -> Floats:
    result = np.zeros(9)
    mujoco.mju_quat2Mat(result, np.roll(q, 1))
    return result.reshape(3, 3)


def product(a: Floats, b: Floats) -> Floats:
    result = np.zeros(4)
    mujoco.mju_mulQuat(result, np.roll(a, 1), np.roll(b, 1))
    return np.roll(result, -1)


def far(found: Floats, expected: Floats) -> float:
    return float(np.abs(found - expected).max() / max(np.abs(expected).max(), 1))


def check_kinematics(twin: Twin, into: Floats, random: np.random.Generator) -> None:
    m, data, mechanism = twin.model, twin.data, twin.mechanism
    for body in range(1, m.nbody):
        if m.body_weldid[body] != body:
            continue
        ours = twin.body(m.body(body).name or str(body))
        pose = twin.world.pose(ours)
        assert far(np.asarray(pose.position), data.xpos[body]) < 1e-12
        assert far(matrix(np.asarray(pose.orientation)), data.xmat[body].reshape(3, 3)) < 1e-12
        point = random.uniform(-0.3, 0.3, 3)
        linear, angular = np.zeros((3, m.nv)), np.zeros((3, m.nv))
        mujoco.mj_jac(m, data, linear, angular, data.xpos[body] + data.xmat[body].reshape(3, 3) @ point, body)
        assert far(mechanism.jacobian(ours, point) @ into, np.vstack([linear, angular])) < 1e-12


def check_dynamics(twin: Twin, into: Floats, random: np.random.Generator, tolerance: float) -> None:
    m, data, mechanism = twin.model, twin.data, twin.mechanism
    mass, tau = np.zeros((m.nv, m.nv)), np.zeros(m.nv)
    mujoco.mj_fullM(m, data, mass)
    assert far(into.T @ mechanism.mass_matrix() @ into, mass) < tolerance
    assert far(into.T @ mechanism.bias(), data.qfrc_bias) < tolerance
    data.qacc[:] = random.uniform(-3, 3, m.nv)
    mujoco.mj_rne(m, data, 1, tau)
    tau += m.dof_armature * data.qacc
    assert far(into.T @ mechanism.inverse_dynamics(into @ data.qacc), tau) < tolerance


@pytest.mark.parametrize("source", EXACT.values(), ids=EXACT.keys())
def test_all_is_as_in_mujoco(source: str) -> None:
    twin, random = Twin(source), np.random.default_rng(1)
    assert (twin.mechanism.nq, twin.mechanism.nv) == (twin.model.nq, twin.model.nv)
    for _ in range(20):
        into = twin.random_state(random)
        check_kinematics(twin, into, random)
        check_dynamics(twin, into, random, 1e-12)


def test_joints_in_a_row_that_make_none_move_as_in_mujoco() -> None:
    twin, random = Twin(SKEW), np.random.default_rng(2)
    assert (twin.mechanism.nq, twin.mechanism.nv) == (twin.model.nq, twin.model.nv)
    for _ in range(20):
        into = twin.random_state(random)
        check_kinematics(twin, into, random)
        check_dynamics(twin, into, random, 3e-3)  # a thousandth of the mass of a body is elsewhere


def test_coordinates_are_named_in_the_models_order() -> None:
    robot = atoll.load_mjcf(CREATURE)
    mechanism = robot.mechanism(robot.build())
    assert mechanism.is_floating
    assert mechanism.names == ["trunk", "shoulder", "elbow", "grip", "hip", "knee"]
    assert [joint.q for joint in mechanism.joints] == [0, 7, 11, 12, 13, 17]
    assert [joint.v for joint in mechanism.joints] == [0, 6, 9, 10, 11, 14]
    assert mechanism.loops == []
    knee = robot.mechanism(robot.build(), "e")
    assert knee.base.index == mechanism.base.index, "any body means the tree, whose base is the model's"
    arm = atoll.load_mjcf(ARM)
    world = arm.build()
    assert arm.mechanism(world).names == [c.name for c in arm.coordinates]
    assert arm.mechanism(world, "lower").q() == pytest.approx(arm.positions(world), abs=1e-15)
    with pytest.raises(atoll.Error, match="body is 'hand'; expected one of"):
        arm.mechanism(world, "hand")


def test_an_arm_is_held_and_reaches() -> None:
    robot = atoll.load_mjcf(ARM.replace('damping="0.2"', "").replace('stiffness="2"', ""))
    world = robot.build()
    arm = robot.mechanism(world, "lower")
    arm.set([0.4, -0.6, 0.1], [0, 0, 0])
    for _ in range(100):
        arm.apply(arm.gravity())
        world.step(1 / 250)
    assert arm.q() == pytest.approx([0.4, -0.6, 0.1], abs=1e-4)
    lower = world.bodies[robot.bodies["lower"]]
    arm.set([0.9, -0.2, 0], [0, 0, 0])
    target = world.pose(lower).position + arm.jacobian(lower)[:3] @ [0.05, -0.05, 0]
    found = arm.inverse_kinematics(lower, [0, 0, 0], target)
    assert found.position_error < 0.05
    arm.set(found.q, [0, 0, 0])
    assert np.linalg.norm(world.pose(lower).position - target) == pytest.approx(found.position_error, abs=1e-12)


def test_worlds_of_a_batch_have_mechanisms() -> None:
    robot = atoll.load_mjcf(CREATURE)
    batch = atoll.Batch(robot.scene, 3)
    mechanisms = [robot.mechanism(world) for world in batch]
    for place, mechanism in enumerate(mechanisms):
        mechanism.set(mechanism.integrate(mechanism.q(), np.full(mechanism.nv, 0.1 * place)), np.zeros(mechanism.nv))
    batch.step(1e-3)
    heights = [mechanism.q()[2] for mechanism in mechanisms]
    assert heights == pytest.approx([1, 1.1, 1.2], abs=1e-4)
    del batch
    assert mechanisms[2].mass_matrix().shape == (15, 15)  # it keeps its world


def test_says_what_is_wrong() -> None:
    robot = atoll.load_mjcf(ARM)
    world = robot.build()
    arm = robot.mechanism(world)
    with pytest.raises(atoll.Error, match="Mechanism::set: q has 2 numbers; expected 3"):
        arm.set([0, 0], [0, 0, 0])
    with pytest.raises(atoll.Error, match=r"tau\[1\] is nan; expected a finite number"):
        arm.apply([0, np.nan, 0])
    with pytest.raises(TypeError, match=r"found numbers of shape \(1, 3\); expected \(n\)"):
        arm.forward_dynamics([[0, 0, 0]])
    with pytest.raises(atoll.Error, match="not in the tree; expected one of its 3 bodies"):
        arm.jacobian(arm.base)
    world.remove_joint(arm.joints[1].joint)
    with pytest.raises(atoll.Error, match="was removed; expected the structure that it was made of"):
        arm.mass_matrix()
