"""Small tasks whose scenes are made here."""

from __future__ import annotations

import gymnasium
import numpy as np
from numpy.typing import NDArray

from .. import _core
from .environments import Array, Bools, Task

Floats = NDArray[np.float32]


def _quarter_turn_about_z() -> list[float]:
    return [0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)]


class CartPole(Task):
    """A pole on a cart that a force of up to 10 N along its rail keeps upright: 1 a step as long as it is, and the cart
    within 2.4 m. The bodies and bounds are those of Barto, Sutton and Anderson ("Neuronlike adaptive elements that can
    solve difficult learning control problems", 1983): a cart of 1 kg, a pole of 0.1 kg and 1 m.

    Seen are the cart's place (m) and speed (m/s), the pole's angle (rad) and rate (rad/s).
    """

    def __init__(self) -> None:
        untouched = _core.CollisionFilter(mask=0)
        static = _core.BodyType.STATIC
        self.scene = _core.Scene(
            name="cart-pole",
            dt=0.02,
            bodies=[
                _core.SceneBody(
                    name="rail", definition=_core.BodyDef(type=static, shape=_core.Sphere(0.05), filter=untouched)
                ),
                _core.SceneBody(
                    name="cart", definition=_core.BodyDef(shape=_core.Box([0.2, 0.1, 0.1]), mass=1, filter=untouched)
                ),
                _core.SceneBody(
                    name="pole",
                    definition=_core.BodyDef(
                        shape=_core.Box([0.02, 0.02, 0.5]), mass=0.1, position=[0, 0, 0.5], filter=untouched
                    ),
                ),
            ],
            joints=[
                _core.SceneJoint(definition=_core.JointDef(kind=_core.SliderJoint()), first=0, second=1),
                _core.SceneJoint(
                    definition=_core.JointDef(
                        kind=_core.HingeJoint(),
                        frame_first=_core.Pose(orientation=_quarter_turn_about_z()),
                        frame_second=_core.Pose([0, 0, -0.5], _quarter_turn_about_z()),
                    ),
                    first=1,
                    second=2,
                ),
            ],
        )
        top = np.array([4.8, np.inf, 0.42, np.inf], dtype=np.float32)
        self.observation_space = gymnasium.spaces.Box(-top, top, dtype=np.float32)
        self.action_space = gymnasium.spaces.Box(-1, 1, (1,), dtype=np.float32)

    def draw(self, random: np.random.Generator) -> Array:
        return random.uniform(-0.05, 0.05, 4)

    def begin(self, batch: _core.Batch, places: NDArray[np.int64], drawn: Array) -> None:
        x, speed, angle, rate = drawn.T
        origins, linear, angular = (np.zeros((len(places), 3, 3)) for _ in range(3))
        orientations = np.zeros((len(places), 3, 4))
        orientations[..., 3] = 1
        origins[:, 1, 0] = x
        origins[:, 2] = np.stack([x + 0.5 * np.sin(angle), 0 * x, 0.5 * np.cos(angle)], axis=-1)
        orientations[:, 2, 1], orientations[:, 2, 3] = np.sin(angle / 2), np.cos(angle / 2)
        linear[:, 1, 0] = speed
        linear[:, 2] = np.stack([speed + 0.5 * rate * np.cos(angle), 0 * x, -0.5 * rate * np.sin(angle)], axis=-1)
        angular[:, 2, 1] = rate
        batch.set_poses(origins, orientations, worlds=places)
        batch.set_velocities(linear, angular, worlds=places)

    def act(self, batch: _core.Batch, actions: Array) -> None:
        forces = np.zeros((len(batch), 3, 3))
        forces[:, 1, 0] = 10 * np.clip(actions[:, 0], -1, 1)
        batch.apply_forces(forces)

    def observe(self, batch: _core.Batch) -> Floats:
        x, speed = batch.read_joint(0)
        angle, rate = batch.read_joint(1)
        return np.stack([x, speed, angle, rate], axis=-1).astype(np.float32)

    def judge(self, batch: _core.Batch, actions: Array) -> tuple[Array, Bools]:
        x, _ = batch.read_joint(0)
        angle, _ = batch.read_joint(1)
        fell = (np.abs(x) > 2.4) | (np.abs(angle) > np.deg2rad(12))
        return np.ones(len(batch)), fell


class PushCrate(Task):
    """A pusher slides on the ground and is to bring a crate to a mark: the reward is by how much nearer (m) the crate
    came, and 1 once it is within 5 cm, which ends the episode.

    Seen are, along x and y: from the pusher to the crate, from the crate to the mark (m), the crate's speed (m/s), and
    the cosine and sine of its heading. An action is the pusher's speed, in m/s.
    """

    steps_an_action = 3
    horizon = 200

    def __init__(self) -> None:
        static = _core.BodyType.STATIC
        motor = _core.JointMotor(max_force=60)
        free, locked = _core.JointAxis(motor=motor), _core.JointAxis(range=_core.JointRange(0, 0))
        # By their filters the ground and the pusher pass each other by.
        planar = _core.SixDofJoint(offset=(free, free, locked), turn=(locked, locked, locked))
        self.scene = _core.Scene(
            name="push-crate",
            dt=1 / 60,
            bodies=[
                _core.SceneBody(
                    name="ground",
                    definition=_core.BodyDef(type=static, shape=_core.HalfSpace(), filter=_core.CollisionFilter(mask=1)),
                ),
                _core.SceneBody(
                    name="crate",
                    definition=_core.BodyDef(
                        shape=_core.Box([0.2, 0.2, 0.15]), mass=4, position=[0, 0, 0.15], material=_core.Material(friction=0.4)
                    ),
                ),
                _core.SceneBody(
                    name="pusher",
                    definition=_core.BodyDef(
                        shape=_core.Cylinder(0.1, 0.1),
                        mass=2,
                        position=[-1, 0, 0.12],
                        filter=_core.CollisionFilter(category=2),
                    ),
                ),
            ],
            joints=[
                _core.SceneJoint(
                    definition=_core.JointDef(kind=planar, frame_first=_core.Pose([0, 0, 0.12])), first=0, second=2
                )
            ],
        )
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (8,), dtype=np.float32)
        self.action_space = gymnasium.spaces.Box(-1, 1, (2,), dtype=np.float32)
        self._marks = np.zeros((0, 2))
        self._distances = np.zeros(0)

    def draw(self, random: np.random.Generator) -> Array:
        """The crate's place and heading, the pusher's place, the mark."""
        crate = random.uniform(-0.5, 0.5, 2)
        away = random.uniform(0, 2 * np.pi, 2)
        pusher = crate + random.uniform(0.5, 0.8) * np.array([np.cos(away[0]), np.sin(away[0])])
        mark = crate + random.uniform(0.5, 1) * np.array([np.cos(away[1]), np.sin(away[1])])
        return np.concatenate([crate, random.uniform(-np.pi, np.pi, 1), pusher, mark])

    def begin(self, batch: _core.Batch, places: NDArray[np.int64], drawn: Array) -> None:
        if len(self._marks) != len(batch):
            self._marks, self._distances = np.zeros((len(batch), 2)), np.zeros(len(batch))
        origins, orientations = np.zeros((len(places), 3, 3)), np.zeros((len(places), 3, 4))
        orientations[..., 3] = 1
        origins[:, 1, :2], origins[:, 1, 2] = drawn[:, :2], 0.15
        orientations[:, 1, 2], orientations[:, 1, 3] = np.sin(drawn[:, 2] / 2), np.cos(drawn[:, 2] / 2)
        origins[:, 2, :2], origins[:, 2, 2] = drawn[:, 3:5], 0.12
        batch.set_poses(origins, orientations, worlds=places)
        self._marks[places] = drawn[:, 5:7]
        self._distances[places] = np.linalg.norm(drawn[:, :2] - drawn[:, 5:7], axis=-1)

    def act(self, batch: _core.Batch, actions: Array) -> None:
        for axis in range(2):
            batch.set_motor_speeds(0, np.ascontiguousarray(np.clip(actions[:, axis], -1, 1)), coordinate=axis)

    def observe(self, batch: _core.Batch) -> Floats:
        places, turn = batch.origins, batch.orientations[:, 1]
        heading = 2 * np.arctan2(turn[:, 2], turn[:, 3])
        seen = [
            places[:, 1, :2] - places[:, 2, :2],
            self._marks - places[:, 1, :2],
            batch.velocities[:, 1, :2],
            np.stack([np.cos(heading), np.sin(heading)], axis=-1),
        ]
        return np.concatenate(seen, axis=-1).astype(np.float32)

    def judge(self, batch: _core.Batch, actions: Array) -> tuple[Array, Bools]:
        distances = np.linalg.norm(self._marks - batch.origins[:, 1, :2], axis=-1)
        nearer, self._distances = self._distances - distances, distances
        there = distances < 0.05
        return nearer + there, there


class StackBoxes(Task):
    """A gantry with a gripper is to put one box of 10 cm upon another: the reward is by how much nearer (m) the box came
    to its place, and 1 once it rests there and the gripper has let go, which ends the episode.

    All happens above a line. Seen are the gripper's place (x, z), how far it is open, from the gripper to the box and
    from the box to its place (x, z), and the box's speed (x, z), in m and m/s. An action is the gripper's speed along x
    and z, in units of 0.5 m/s, and where it is below 0 the gripper closes, else it opens.
    """

    steps_an_action = 2
    horizon = 300
    _half = 0.05  # m, of a box
    _high = 0.45  # m, where the carriage starts
    _travel = (-1.0, 1.0)  # m, from there
    _height = (-_high + 0.15, 0.2)
    _closed, _opened = 0.04, 0.09  # m, of a finger from the middle

    def __init__(self) -> None:
        def servo(axis_range: _core.JointRange, target: float, stiffness: float, force: float) -> _core.JointAxis:
            gains = _core.JointServo(target=target, stiffness=stiffness, damping=0.1 * stiffness)
            return _core.JointAxis(range=axis_range, motor=_core.JointMotor(max_force=force, servo=gains))

        locked = _core.JointAxis(range=_core.JointRange(0, 0))

        def box(x: float) -> _core.BodyDef:
            material = _core.Material(friction=0.8)
            return _core.BodyDef(
                shape=_core.Box([self._half] * 3), mass=0.3, position=[x, 0, self._half], material=material
            )

        ground = _core.BodyDef(type=_core.BodyType.STATIC, shape=_core.HalfSpace())
        bodies = [
            _core.SceneBody(name="ground", definition=ground),
            _core.SceneBody(name="lower", definition=box(0.2)),
            _core.SceneBody(name="upper", definition=box(-0.2)),
        ]
        # A counterweight carries all that the motors move.
        bodies.append(
            _core.SceneBody(
                name="carriage",
                definition=_core.BodyDef(
                    shape=_core.Box([0.03, 0.03, 0.02]), mass=2, position=[0, 0, self._high], gravity_scale=0
                ),
            )
        )
        travel, height = _core.JointRange(*self._travel), _core.JointRange(*self._height)
        gantry = _core.SixDofJoint(
            offset=(servo(travel, 0, 4000, 200), locked, servo(height, 0, 4000, 200)), turn=(locked, locked, locked)
        )
        joints = [
            _core.SceneJoint(
                definition=_core.JointDef(kind=gantry, frame_first=_core.Pose([0, 0, self._high])), first=0, second=3
            )
        ]
        for side in (-1, 1):
            reach = sorted([side * self._closed, side * self._opened])
            bodies.append(
                _core.SceneBody(
                    name="left" if side < 0 else "right",
                    definition=_core.BodyDef(
                        shape=_core.Box([0.01, 0.03, 0.04]),
                        mass=0.2,
                        position=[side * self._opened, 0, self._high - 0.1],
                        gravity_scale=0,
                        material=_core.Material(friction=1.2),
                    ),
                )
            )
            finger = _core.SliderJoint(servo(_core.JointRange(*reach), side * self._opened, 1500, 15))
            joints.append(
                _core.SceneJoint(
                    definition=_core.JointDef(kind=finger, frame_first=_core.Pose([0, 0, -0.1])),
                    first=3,
                    second=len(bodies) - 1,
                )
            )
        self.scene = _core.Scene(name="stack-boxes", dt=1 / 60, bodies=bodies, joints=joints)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (9,), dtype=np.float32)
        self.action_space = gymnasium.spaces.Box(-1, 1, (3,), dtype=np.float32)
        self._targets = np.zeros((0, 2))  # of the gripper, from where it starts
        self._distances = np.zeros(0)

    def draw(self, random: np.random.Generator) -> Array:
        """Where the two boxes are."""
        return np.array([random.uniform(0.1, 0.35), random.uniform(-0.35, -0.1)])

    def begin(self, batch: _core.Batch, places: NDArray[np.int64], drawn: Array) -> None:
        if len(self._targets) != len(batch):
            self._targets, self._distances = np.zeros((len(batch), 2)), np.zeros(len(batch))
        origins, orientations = batch.origins[places], batch.orientations[places]
        origins[:, 1:3, 0] = drawn
        batch.set_poses(origins, orientations, worlds=places)
        self._targets[places] = 0
        self._distances[places] = np.linalg.norm(self._to_place(batch)[places], axis=-1)

    def act(self, batch: _core.Batch, actions: Array) -> None:
        seconds = self.steps_an_action * self.scene.dt
        low, high = zip(self._travel, self._height)
        self._targets = np.clip(self._targets + 0.5 * seconds * np.clip(actions[:, :2], -1, 1), low, high)
        batch.set_servo_targets(0, np.ascontiguousarray(self._targets[:, 0]), coordinate=0)
        batch.set_servo_targets(0, np.ascontiguousarray(self._targets[:, 1]), coordinate=2)
        reach = np.where(actions[:, 2] < 0, self._closed, self._opened)
        batch.set_servo_targets(1, -reach)
        batch.set_servo_targets(2, reach)

    def _to_place(self, batch: _core.Batch) -> Array:
        places = batch.origins
        return (places[:, 1] + [0, 0, 2 * self._half] - places[:, 2])[:, ::2]

    def _open(self, batch: _core.Batch) -> Array:
        return batch.read_joint(2)[0] - batch.read_joint(1)[0]

    def observe(self, batch: _core.Batch) -> Floats:
        places = batch.origins
        gripper = places[:, 3, ::2] - [0, 0.1]
        seen = [
            gripper,
            self._open(batch)[:, None],
            places[:, 2, ::2] - gripper,
            self._to_place(batch),
            batch.velocities[:, 2, ::2],
        ]
        return np.concatenate(seen, axis=-1).astype(np.float32)

    def judge(self, batch: _core.Batch, actions: Array) -> tuple[Array, Bools]:
        distances = np.linalg.norm(self._to_place(batch), axis=-1)
        nearer, self._distances = self._distances - distances, distances
        rests = np.linalg.norm(batch.velocities[:, 2], axis=-1) < 0.01
        done = (distances < 0.03) & rests & (self._open(batch) > 0.15)
        return nearer + done, done
