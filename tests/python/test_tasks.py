"""Gymnasium's walking robots over a batch, held to Gymnasium's own environments in MuJoCo, by its model and data."""

from __future__ import annotations

import sys
import types
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import atoll
import atoll.gym
from atoll._robots.axes import axis_of, with_axis
from atoll.gym import TASKS, AutoresetMode, Locomotion, make

Floats = NDArray[np.float64]
NAMES = {"half-cheetah": "HalfCheetah", "hopper": "Hopper", "walker-2d": "Walker2d", "ant": "Ant", "humanoid": "Humanoid"}
FREE = ("ant", "humanoid")


class _NoRenderer:
    """Gymnasium asks for a window's libraries even where nothing is drawn."""

    def __init__(self, *_: Any) -> None:
        pass

    def close(self) -> None:
        pass


@pytest.fixture(autouse=True)
def without_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    name = "gymnasium.envs.mujoco.mujoco_rendering"
    module = types.ModuleType(name)
    setattr(module, "MujocoRenderer", _NoRenderer)
    monkeypatch.setitem(sys.modules, name, module)


def theirs_of(name: str) -> Any:
    return gymnasium.make(f"{NAMES[name]}-v5", disable_env_checker=True).unwrapped


def counts_of(theirs: Any) -> int:
    """Of what is seen of q and v."""
    return int(theirs.observation_structure["qpos"] + theirs.observation_structure["qvel"])


def of_unit_length(name: str, observation: Floats) -> Floats:
    """Gymnasium adds its noise to a quaternion and leaves it at that."""
    seen = observation.copy()
    if name in FREE:
        seen[..., 1:5] /= np.linalg.norm(seen[..., 1:5], axis=-1, keepdims=True)
    return seen


def actions_of(ours: atoll.gym.BatchEnv, seed: int) -> Floats:
    bound = ours.task.action_space.high
    return np.random.default_rng(seed).uniform(-bound, bound, ours.action_space.shape)


@pytest.mark.parametrize("name", NAMES)
def test_spaces_and_starts_are_those_of_gymnasium(name: str) -> None:
    theirs, alone = theirs_of(name), gymnasium.make(f"atoll/{NAMES[name]}-v0")
    many = gymnasium.make_vec(f"atoll/{NAMES[name]}-v0", num_envs=3, threads=1)
    assert alone.observation_space == many.single_observation_space == theirs.observation_space
    assert alone.action_space == many.single_action_space == theirs.action_space
    assert np.isclose(TASKS[name]().scene.dt * TASKS[name]().steps_an_action, theirs.dt)
    observations, _ = many.reset(seed=4)
    assert np.array_equal(alone.reset(seed=5)[0], observations[1])
    for number in range(3):
        expected, _ = theirs.reset(seed=4 + number)
        seen = counts_of(theirs)
        assert observations[number][:seen] == pytest.approx(of_unit_length(name, expected)[:seen], abs=1e-9)
        assert observations[number][seen:] == pytest.approx(expected[seen:], abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_states_read_as_they_were_set_and_as_mujoco_sees_them(name: str) -> None:
    theirs, envs = theirs_of(name), make(name, 4, AutoresetMode.DISABLED, threads=1)
    task = envs.task
    assert isinstance(task, Locomotion)
    envs.reset(seed=0)
    random = np.random.default_rng(2)
    q = task.draw(random)[: theirs.model.nq] + random.uniform(-1.5, 1.5, (4, theirs.model.nq))
    v = random.uniform(-3, 3, (4, theirs.model.nv))
    places = np.array([3, 1], dtype=np.int64)
    task.begin(envs.batch, places, np.hstack([q, v])[places])
    observations = task.observe(envs.batch)
    for place in places:
        turn = q[place].copy()
        if name in FREE:
            turn[3:7] /= np.linalg.norm(turn[3:7])
        theirs.set_state(turn, v[place])
        assert observations[place] == pytest.approx(theirs._get_obs(), abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_rewards_and_ends_are_gymnasiums_of_the_same_states(name: str) -> None:
    theirs, envs = theirs_of(name), make(name, 16, AutoresetMode.DISABLED, threads=1)
    task = envs.task
    assert isinstance(task, Locomotion)
    envs.reset(seed=1)
    for step in range(8):
        before = task.coordinates.read(envs.batch)
        actions = actions_of(envs, step)
        observations, rewards, ended, _, _ = envs.step(actions)
        after = task.coordinates.read(envs.batch)
        for place in range(16):
            theirs.data.ctrl[:] = actions[place]
            moved = []
            for state in (before, after):
                theirs.set_state(state.q[place], state.v[place])
                centre = theirs.model.body_mass @ theirs.data.xipos[:, 0] / theirs.model.body_mass.sum()
                moved.append(centre if name == "humanoid" else state.q[place, 0])
            if name in FREE:
                theirs.data.cfrc_ext[1:] = observations[place].reshape(-1)[-6 * (theirs.model.nbody - 1) :].reshape(-1, 6)
            reward, _ = theirs._get_rew((moved[1] - moved[0]) / theirs.dt, actions[place])
            assert rewards[place] == pytest.approx(reward, abs=1e-7)
            assert ended[place] == (name != "half-cheetah" and not theirs.is_healthy)
            seen, expected = counts_of(theirs), theirs._get_obs()
            assert observations[place][:seen] == pytest.approx(expected[:seen], abs=1e-9)
            # Joints of moving bodies open a little, where those of coordinates can't.
            assert observations[place][seen:] == pytest.approx(expected[seen:], abs=1e-3)
        envs.reset(options={"reset_mask": ended})


def stripped(task: Locomotion, model: Any) -> None:
    """Takes out what differs by intent: contacts and ends of joints."""
    mujoco = pytest.importorskip("mujoco")
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    joints, bodies = list(task.scene.joints), list(task.scene.bodies)
    for of in task.coordinates.of:
        definition = joints[of.joint].definition
        axis = axis_of(definition.kind, of.axis)
        axis.range = atoll.JointRange(-np.inf, np.inf)
        definition.kind = with_axis(definition.kind, of.axis, axis)
        joints[of.joint].definition = definition
    for body in bodies:
        untouched = body.definition
        untouched.shape, untouched.filter = atoll.Sphere(0.01), atoll.CollisionFilter(mask=0)
        body.definition = untouched
    task.scene.joints, task.scene.bodies = joints, bodies


# rad and m, root of the mean square sum after 0.4 s. The time steps are ours; MuJoCo's are short enough to be exact.
@pytest.mark.parametrize(
    ("name", "error"), [("half-cheetah", 4e-3), ("hopper", 3e-5), ("walker-2d", 2e-3), ("ant", 3e-3), ("humanoid", 1e-2)]
)
def test_driven_motion_is_that_of_mujoco_with_short_steps(name: str, error: float) -> None:
    mujoco = pytest.importorskip("mujoco")
    theirs, task = theirs_of(name), TASKS[name]()
    assert isinstance(task, Locomotion)
    model = theirs.model
    stripped(task, model)
    frames, worlds = round(0.4 / theirs.dt), 3
    random = np.random.default_rng(0)
    q = model.qpos0 + random.uniform(-0.1, 0.1, (worlds, model.nq))
    v = 0.3 * random.normal(size=(worlds, model.nv))
    if name in FREE:
        q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    controls = 0.1 * random.uniform(-1, 1, (frames, worlds, model.nu)) * model.actuator_ctrlrange[:, 1]
    envs = atoll.gym.BatchEnv(task, worlds, AutoresetMode.DISABLED, threads=1)
    envs.reset(seed=0)
    task.begin(envs.batch, np.arange(worlds), np.hstack([q, v]))
    for control in controls:
        task.act(envs.batch, control)
        envs.batch.step(count=task.steps_an_action)
    model.opt.integrator, steps = mujoco.mjtIntegrator.mjINT_RK4, round(theirs.dt / 0.0005)
    model.opt.timestep = theirs.dt / steps
    off = []
    for world in range(worlds):
        mujoco.mj_resetData(model, theirs.data)
        theirs.set_state(q[world], v[world])
        for control in controls[:, world]:
            theirs.data.ctrl[:] = control
            mujoco.mj_step(model, theirs.data, nstep=steps)
        off.append(np.sum((task.coordinates.read(envs.batch).q[world] - theirs.data.qpos) ** 2))
    assert np.sqrt(np.mean(off)) < error


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_that_lies_still_weighs_what_it_does(name: str) -> None:
    """The root's joint carries nothing, and no body has another mass than the model's."""
    envs = make(name, 1, AutoresetMode.DISABLED, threads=1)
    envs.reset(seed=0)
    envs.batch.step(dt=0.01, count=800)
    world = envs.batch[0]
    forces = world.contact_forces()
    on_ground = forces[forces["a"]["index"] == 0]
    moving = [body for body in envs.batch.bodies if world.definition(body).type == atoll.BodyType.DYNAMIC]
    weight = 9.81 * sum(world.mass(body) for body in moving)
    assert on_ground["normal_force"].sum() == pytest.approx(weight, rel=0.02)
    assert weight == pytest.approx(9.81 * theirs_of(name).model.body_mass.sum(), rel=1e-9)


def test_a_cheetah_that_rolls_over_counts_its_turns() -> None:
    envs = make("half-cheetah", 2, AutoresetMode.DISABLED, threads=1)
    envs.reset(seed=0)
    task = envs.task
    assert isinstance(task, Locomotion)
    q, v = np.zeros((2, 9)), np.zeros((2, 9))
    q[:, 1], v[:, 1], v[:, 2] = 20, 5, (12, -12)
    task.begin(envs.batch, np.arange(2), np.hstack([q, v]))
    theirs = theirs_of("half-cheetah")
    theirs.set_state(q[0], v[0])
    for _ in range(30):
        theirs.do_simulation(np.zeros(6), theirs.frame_skip)
        observations, *_ = envs.step(np.zeros((2, 6)))
    assert theirs.data.qpos[2] > 3 * np.pi
    assert observations[:, 1] == pytest.approx(theirs.data.qpos[2] * np.array([1, -1]), rel=0.1)


@pytest.mark.parametrize("name", ("hopper", "ant"))
def test_controls_beyond_the_range_of_a_motor_are_cut_off(name: str) -> None:
    ends = []
    for size in (1, 7):
        envs = make(name, 2, AutoresetMode.DISABLED, threads=1)
        envs.reset(seed=3)
        observations, *_ = envs.step(size * np.sign(actions_of(envs, 1)))
        ends.append(observations)
    assert np.array_equal(ends[0], ends[1])


def test_an_ant_that_stands_still_feels_what_it_does_in_mujoco() -> None:
    theirs, envs = theirs_of("ant"), make("ant", 2, AutoresetMode.DISABLED, threads=1)
    envs.reset(seed=0)
    task = envs.task
    assert isinstance(task, Locomotion)
    q = theirs.model.qpos0.copy()
    q[2], q[7:] = 0.6, (0, 1, 0, -1, 0, -1, 0, 1)
    theirs.set_state(q, np.zeros(14))
    task.begin(envs.batch, np.arange(2), np.tile(np.append(q, np.zeros(14)), (2, 1)))
    for _ in range(60):
        theirs.do_simulation(np.zeros(8), theirs.frame_skip)
        envs.step(np.zeros((2, 8)))
    forces = task.terms.contact(envs.batch, task.coordinates.read(envs.batch).motion)
    assert np.abs(theirs.data.cfrc_ext[:, 5]).max() > 2
    assert forces[1][:, 5] == pytest.approx(theirs.data.cfrc_ext[1:, 5], rel=1e-3, abs=1e-3)
