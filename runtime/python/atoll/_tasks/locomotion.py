"""Robots that learn to walk: Gymnasium's own models, observations, rewards and ends of episodes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import gymnasium
import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._robots import mjcf
from .._robots.compiled import Compiled, compiler
from .body_terms import BodyTerms
from .coordinates import Coordinates, State
from .environments import Array, Bools, Seen, Task
from .robot_scene import drive, grip


@dataclass(frozen=True, kw_only=True)
class Rules:
    """The numbers of a task of Gymnasium's, and the steps in which it is simulated here.

    The steps were set by motion without contacts and ends of joints over 0.3 s, at rates of 3 rad/s and torques of 30%,
    against MuJoCo's RK4 in steps of 1/19200 s: off by 3e-3 (HalfCheetah, where MuJoCo's own steps are off by 3e-2), 1e-3
    (Hopper), 6e-3 (Walker2d), 6e-2 (Ant) and 2e-2 (Humanoid), m and rad, root of the sum of squares.
    """

    file: str  #: of the model, among Gymnasium's
    frame: float  #: s, of an action
    steps: int = 1  #: of an action
    substeps: int  #: of each step
    planar: bool = False  #: moves in a plane
    hidden: int = 2  #: of the first numbers of q, which aren't seen
    max_speed: float = math.inf  #: m/s or rad/s, at which speeds that are seen are cut off
    noise: float  #: of q and v as an episode begins
    uniform_speeds: bool = True  #: else they are normal
    forward: float = 1.0  #: reward, of 1 m/s
    effort: float  #: cost, of the square of a control
    healthy: float = 0.0  #: reward, of each action
    heights: tuple[float, float] = (-math.inf, math.inf)  #: m, of the root, between which it goes on
    angles: tuple[float, float] = (-math.inf, math.inf)  #: rad, likewise, of a planar robot
    numbers_a_body: int = 0  #: that are seen beside q and v
    sees_torques: bool = False
    contact_effort: float = 0.0  #: cost, of the square of a contact force
    max_contact: float = math.inf  #: N or N m, by which contact forces are cut off
    max_contact_cost: float = math.inf


class Locomotion(Task):
    """A task of Gymnasium's version 5, with its defaults: forward along x, upright, with little effort.

    Seen are q, without the place on the ground, and v, as MuJoCo counts them. An action is a control of each motor, which
    is cut off at its range. Episodes begin as Gymnasium's with the same seed do.

    Contacts and ends of joints are rigid here and soft there, and ground and feet have MuJoCo's friction. Gymnasium's
    quaternions are not of unit length in the first observation; these are.
    """

    horizon = 1000
    rules: Rules

    def __init__(self) -> None:
        model = self._model()
        m = model.arrays
        robot = mjcf.read(model)
        grip(robot, model)
        stiffness = drive(robot)
        self._actuators = robot.actuators
        self._drives = np.array([[*of.range, of.gain, of.bias, stiffness[of.coordinate]] for of in self._actuators]).T
        self._start = np.array(m.qpos0)
        self._counts = int(m.nq), int(m.nv)
        root = robot.bodies[model.name("BODY", 1)]
        self.coordinates = Coordinates(robot, root, self.rules.planar)
        driven = [robot.coordinates[of.coordinate] for of in self._actuators]
        self._servos = [_core.ServoTarget(of.joint, of.axis) for of in driven]
        self.terms = BodyTerms(robot, model, len(robot.scene.bodies))
        self.steps_an_action = self.rules.steps
        self.scene = robot.scene
        self.scene.dt = self.rules.frame / self.rules.steps
        settings = self.scene.settings
        settings.substeps = self.rules.substeps
        self.scene.settings = settings
        low, high = np.array(m.actuator_ctrlrange, dtype=np.float32).T
        self.action_space = gymnasium.spaces.Box(low, high, dtype=np.float32)
        self._places = np.zeros(0)  # m, along x, before an action
        self._state: State | None = None  # read last, while nothing has moved since
        size = sum(self._counts) - self.rules.hidden + self.rules.numbers_a_body * (int(m.nbody) - 1)
        size += len(self.coordinates.of) if self.rules.sees_torques else 0
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (size,), dtype=np.float64)

    def _model(self) -> Compiled:
        mujoco = compiler()
        assets = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
        return Compiled(mujoco, mujoco.MjModel.from_xml_path(str(assets / self.rules.file)), None)

    def draw(self, random: np.random.Generator) -> Array:
        """q and v, by the calls that Gymnasium makes."""
        q = self._start + random.uniform(-self.rules.noise, self.rules.noise, self._counts[0])
        if self.rules.uniform_speeds:
            return np.concatenate([q, random.uniform(-self.rules.noise, self.rules.noise, self._counts[1])])
        return np.concatenate([q, self.rules.noise * random.standard_normal(self._counts[1])])

    def begin(self, batch: _core.Batch, places: NDArray[np.int64], drawn: Array) -> None:
        if len(self._places) != len(batch):
            self._places = np.zeros(len(batch))
        q, v = np.split(drawn, self._counts[:1], axis=1)
        self.coordinates.set(batch, places, q, v)
        begun = self.coordinates.read(batch, places)
        if self._state is not None and len(self._state.q) == len(batch):
            self._state.put(places, begun)
        else:
            self._state = None
        self._places[places] = self._along(begun)

    def act(self, batch: _core.Batch, actions: Array) -> None:
        self._state = None
        batch.set_controls(self._servos, self._targets(actions))

    def _targets(self, actions: Array) -> Array:
        """rad, of servos that then pull with the torques of these actions."""
        low, high, gains, biases, stiffnesses = self._drives.astype(actions.dtype)
        return np.asarray((gains * np.clip(actions, low, high) + biases) / stiffnesses)

    def advance(self, batch: _core.Batch, actions: Array, worlds: Bools | None) -> None:
        stepped = slice(None) if worlds is None else worlds
        names = self.coordinates.columns
        targets = np.ascontiguousarray(self._targets(actions)[stepped, None])
        kept = batch.rollout(self._servos, targets, count=self.steps_an_action, keep=names, worlds=worlds)
        state = self.coordinates.state_of([kept[name][:, 0] for name in names], stepped, len(batch))
        if worlds is None:
            self._state = state
        elif self._state is not None:
            self._state.put(stepped, state)

    def observe(self, batch: _core.Batch) -> Seen:
        return np.hstack(self._seen(self._read(batch)))

    def judge(self, batch: _core.Batch, actions: Array) -> tuple[Array, Bools]:
        return self._judge(batch, self._read(batch), actions)

    def _read(self, batch: _core.Batch) -> State:
        if self._state is None:
            self._state = self.coordinates.read(batch)
        return self._state

    def _seen(self, state: State) -> list[Array]:
        return [state.q[:, self.rules.hidden :], np.clip(state.v, -self.rules.max_speed, self.rules.max_speed)]

    def _judge(self, batch: _core.Batch, state: State, actions: Array) -> tuple[Array, Bools]:
        now = self._along(state)
        speeds, self._places = (now - self._places) / self.rules.frame, now
        goes_on = self._goes_on(state)
        rewards = self.rules.forward * speeds + self.rules.healthy * goes_on - self.rules.effort * np.sum(actions**2, axis=1)
        return rewards, ~goes_on

    def _along(self, state: State) -> Array:
        """m, along x, of what is to come forward; an array of its own."""
        return state.q[:, 0].copy()

    def _goes_on(self, state: State) -> Bools:
        height, angle = state.q[:, 1], state.q[:, 2]
        upright = (self.rules.angles[0] < angle) & (angle < self.rules.angles[1])
        return np.asarray((self.rules.heights[0] < height) & (height < self.rules.heights[1]) & upright)


class HalfCheetah(Locomotion):
    """Gymnasium's HalfCheetah-v5."""

    rules = Rules(
        file="half_cheetah.xml", planar=True, hidden=1, frame=0.05, steps=2, substeps=2, noise=0.1, uniform_speeds=False,
        effort=0.1,
    )  # fmt: skip


class Hopper(Locomotion):
    """Gymnasium's Hopper-v5."""

    rules = Rules(
        file="hopper.xml", planar=True, hidden=1, max_speed=10.0, frame=0.008, substeps=1, noise=5e-3, effort=1e-3,
        healthy=1.0, heights=(0.7, math.inf), angles=(-0.2, 0.2),
    )  # fmt: skip

    def _goes_on(self, state: State) -> Bools:
        slow = np.all(np.abs(np.hstack([state.q[:, 2:], state.v])) < 100, axis=1)
        return np.asarray(super()._goes_on(state) & slow)


class Walker2d(Locomotion):
    """Gymnasium's Walker2d-v5."""

    rules = Rules(
        file="walker2d_v5.xml", planar=True, hidden=1, max_speed=10.0, frame=0.008, substeps=2, noise=5e-3, effort=1e-3,
        healthy=1.0, heights=(0.8, 2.0), angles=(-1.0, 1.0),
    )  # fmt: skip


class FreeLocomotion(Locomotion):
    """Of a robot with a free root, which sees the contact forces of all its bodies.

    They are of the end of an action, where Gymnasium's are of the start of MuJoCo's last step.
    """

    def begin(self, batch: _core.Batch, places: NDArray[np.int64], drawn: Array) -> None:
        if len(self._places) != len(batch):
            self._contacts = np.zeros((len(batch), len(self.terms.places), 6))
        self._contacts[places] = 0
        super().begin(batch, places, drawn)

    def _seen(self, state: State) -> list[Array]:
        return [*super()._seen(state), self._contacts.reshape(len(state.q), -1)]

    def _judge(self, batch: _core.Batch, state: State, actions: Array) -> tuple[Array, Bools]:
        contacts = self.terms.contact(batch, state.motion)
        self._contacts = np.clip(contacts, -self.rules.max_contact, self.rules.max_contact)
        rewards, ended = super()._judge(batch, state, actions)
        return rewards - self._contact_cost(), ended

    def _contact_cost(self) -> Array:
        return np.asarray(self.rules.contact_effort * np.sum(self._contacts**2, axis=(1, 2)))


class Ant(FreeLocomotion):
    """Gymnasium's Ant-v5."""

    rules = Rules(
        file="ant.xml", frame=0.05, steps=2, substeps=2, noise=0.1, uniform_speeds=False, effort=0.5, healthy=1.0,
        heights=(0.2, 1.0), numbers_a_body=6, contact_effort=5e-4, max_contact=1.0,
    )  # fmt: skip

    def _goes_on(self, state: State) -> Bools:
        return np.asarray((self.rules.heights[0] <= state.q[:, 2]) & (state.q[:, 2] <= self.rules.heights[1]))


class Humanoid(FreeLocomotion):
    """Gymnasium's Humanoid-v5. What moves forward is its centre of mass."""

    rules = Rules(
        file="humanoid.xml", frame=0.015, substeps=3, noise=1e-2, forward=1.25, effort=0.1, healthy=5.0, heights=(1.0, 2.0),
        numbers_a_body=10 + 6 + 6, sees_torques=True, contact_effort=5e-7, max_contact_cost=10.0,
    )  # fmt: skip

    def begin(self, batch: _core.Batch, places: NDArray[np.int64], drawn: Array) -> None:
        if len(self._places) != len(batch):
            self._torques = np.zeros((len(batch), len(self.coordinates.of)))
        self._torques[places] = 0
        super().begin(batch, places, drawn)

    def _targets(self, actions: Array) -> Array:
        for actuator, controls in zip(self._actuators, actions.T, strict=True):
            self._torques[:, actuator.coordinate] = actuator.gain * np.clip(controls, *actuator.range)
        return super()._targets(actions)

    def _seen(self, state: State) -> list[Array]:
        *rest, contacts = super()._seen(state)
        bodies = (self.terms.inertia(state.motion), self.terms.velocity(state.motion))
        return [*rest, *(of.reshape(len(state.q), -1) for of in bodies), self._torques, contacts]

    def _along(self, state: State) -> Array:
        return self.terms.centre(state.motion)[:, 0]

    def _goes_on(self, state: State) -> Bools:
        return np.asarray((self.rules.heights[0] < state.q[:, 2]) & (state.q[:, 2] < self.rules.heights[1]))

    def _contact_cost(self) -> Array:
        return np.minimum(super()._contact_cost(), self.rules.max_contact_cost)
