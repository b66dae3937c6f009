"""Coordinates of a robot, as MuJoCo counts them, in all worlds of a batch at once."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._robots.quaternions import Floats, cross, inverse, product, turned
from .._robots.robot import Coordinate, Robot


_OF_JOINTS = ("joint_positions", "joint_speeds")
_OF_BODIES = ("origins", "orientations", "positions", "velocities", "angular_velocities")

Worlds = NDArray[np.int64] | NDArray[np.bool_] | slice


@dataclasses.dataclass
class Motion:
    """How the bodies of a scene stand and move: rows of worlds, columns of bodies."""

    origins: Floats  #: m, of the bodies' frames
    orientations: Floats  #: x, y, z, w
    velocities: Floats  #: m/s, of the origins
    angular: Floats  #: rad/s, in the axes of the world

    def at(self, body: int, point: Floats) -> tuple[Floats, Floats]:
        """Where a point of a body is, and how fast it moves, in the axes of the world; `point` in its frame."""
        arm = turned(self.orientations[:, body], np.broadcast_to(point, (len(self.origins), 3)))
        return self.origins[:, body] + arm, self.velocities[:, body] + cross(self.angular[:, body], arm)


@dataclasses.dataclass
class State:
    """Of the robot in each world: a row a world."""

    q: Floats
    v: Floats
    bodies: Motion | None  #: not read of a robot in a plane

    @property
    def motion(self) -> Motion:
        assert self.bodies is not None
        return self.bodies

    def put(self, worlds: Worlds, other: State) -> None:
        """Takes the rows of these worlds from another."""
        self.q[worlds], self.v[worlds] = other.q, other.v
        if self.bodies is not None:
            for name, rows in vars(other.motion).items():
                getattr(self.bodies, name)[worlds] = rows


class Coordinates:
    """Reads and sets q and v, shapes (worlds, nq) and (worlds, nv), of a robot with a root that moves.

    A free root comes first: position, quaternion w, x, y, z, velocity of the origin, and angular velocity in the axes of
    the root. The joints follow in the model's order, m or rad and m/s or rad/s. The root's own are the first of these
    where it moves in a plane: x, z, and the angle about y. It is counted over full turns from read() to read(), between
    which it may turn by less than half of one.
    """

    def __init__(self, robot: Robot, root: int, planar: bool) -> None:
        """root: its place in the scene."""
        self.bodies, self.root, self.planar = robot.scene.bodies, root, planar
        self.of = robot.coordinates
        self.places, self.axes = [of.joint for of in self.of], [of.axis for of in self.of]
        self.joints = robot.scene.joints
        self.centres = np.array([_centre_of(body.definition) for body in self.bodies])
        self._angles = np.zeros(0)  # rad, that were read last

    @property
    def columns(self) -> list[str]:
        """What of a batch a state is made of, by the names of its arrays."""
        return [*_OF_JOINTS, *([] if self.planar else _OF_BODIES)]

    def read(self, batch: _core.Batch, worlds: Worlds = slice(None)) -> State:
        columns = batch.read_all(self.columns, worlds=None if isinstance(worlds, slice) else worlds)
        return self.state_of(columns, worlds, len(batch))

    def state_of(self, columns: list[Floats], worlds: Worlds, count: int) -> State:
        """Of these worlds, of `count`, from their rows of the columns."""
        q, v = (of[:, self.places, self.axes] for of in columns[:2])
        if self.planar:
            q[:, 2] = self._count_turns(q[:, 2], worlds, count)
            return State(q, v, None)
        origins, orientations, positions, velocities, angular = columns[2:]
        motion = Motion(origins, orientations, velocities + cross(angular, origins - positions), angular)
        turn = orientations[:, self.root]
        q = np.hstack([origins[:, self.root], np.roll(turn, 1, axis=-1), q])
        v = np.hstack([motion.velocities[:, self.root], turned(inverse(turn), angular[:, self.root]), v])
        return State(q, v, motion)

    def _count_turns(self, angles: Floats, worlds: Worlds, count: int) -> Floats:
        if len(self._angles) != count:
            self._angles = np.zeros(count)
        before = self._angles[worlds]
        self._angles[worlds] = before + np.remainder(angles - before + np.pi, 2 * np.pi) - np.pi
        return self._angles[worlds]

    def set(self, batch: _core.Batch, worlds: NDArray[np.int64], q: Floats, v: Floats) -> None:
        """Puts all bodies of these worlds to where q and v have them; a quaternion in q may have any length > 0."""
        if self.planar:
            if len(self._angles) != len(batch):
                self._angles = np.zeros(len(batch))
            self._angles[worlds] = q[:, 2]
        motion = self.carry(q, v)
        arms = turned(motion.orientations, np.broadcast_to(self.centres, motion.origins.shape))
        linear = motion.velocities + cross(motion.angular, arms)
        batch.set_poses(motion.origins, motion.orientations, worlds=worlds)
        batch.set_velocities(linear, motion.angular, worlds=worlds)

    def carry(self, q: Floats, v: Floats) -> Motion:
        """Along the tree, from what carries to what is carried."""
        worlds = len(q)
        motion = Motion(*(np.zeros((worlds, len(self.bodies), of)) for of in (3, 4, 3, 3)))
        for place, body in enumerate(self.bodies):
            motion.origins[:, place] = body.definition.position
            motion.orientations[:, place] = body.definition.orientation
        if not self.planar:
            turn = np.roll(q[:, 3:7], -1, axis=-1)
            turn /= np.linalg.norm(turn, axis=-1, keepdims=True)
            motion.origins[:, self.root] = q[:, :3]
            motion.velocities[:, self.root], motion.angular[:, self.root] = v[:, :3], turned(turn, v[:, 3:6])
            motion.orientations[:, self.root] = turn
        angles, rates = q[:, -len(self.of) :], v[:, -len(self.of) :]
        for place in dict.fromkeys(self.places):
            own = [column for column, of in enumerate(self.places) if of == place]
            _carry(motion, self.joints[place], [self.of[column] for column in own], angles[:, own], rates[:, own])
        return motion


def _carry(motion: Motion, joint: _core.SceneJoint, own: list[Coordinate], q: Floats, v: Floats) -> None:
    """Puts the second body of a joint to where the first one and the coordinates of the joint have it."""
    first, second, definition = joint.first, joint.second, joint.definition
    anchor, speed = motion.at(first, np.asarray(definition.frame_first.position))
    axes = product(motion.orientations[:, first], _rows(definition.frame_first.orientation, len(q)))
    angular = motion.angular[:, first]
    for of, at, rate in zip(own, q.T[:, :, None], v.T[:, :, None], strict=True):
        unit = np.eye(3)[of.axis % 3]
        along = turned(axes, _rows(unit, len(q)))
        if of.kind == "slide":
            anchor = anchor + at * along
            speed = speed + cross(angular, at * along) + rate * along
        else:
            axes = product(axes, np.hstack([np.sin(at / 2) * unit, np.cos(at / 2)]))
            angular = angular + rate * along
    turn = product(axes, inverse(_rows(definition.frame_second.orientation, len(q))))
    arm = turned(turn, _rows(definition.frame_second.position, len(q)))
    motion.origins[:, second], motion.orientations[:, second] = anchor - arm, turn
    motion.velocities[:, second], motion.angular[:, second] = speed - cross(angular, arm), angular


def _rows(vector: Floats | list[float], count: int) -> Floats:
    of = np.asarray(vector, dtype=np.float64)
    return np.broadcast_to(of, (count, len(of)))


def _centre_of(definition: _core.BodyDef) -> Floats:
    return np.zeros(3) if definition.centre_of_mass is None else np.asarray(definition.centre_of_mass)
