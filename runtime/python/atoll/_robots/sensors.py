"""What sensors of a model read in a world."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .quaternions import Floats, inverse, product, turned

Kind = Literal[
    "jointpos", "jointvel", "gyro", "accelerometer", "velocimeter", "framepos", "framequat", "framexaxis", "frameyaxis",
    "framezaxis", "framelinvel", "frameangvel", "touch", "force", "torque",
]  # fmt: skip
Zone = Literal["sphere", "capsule", "ellipsoid", "cylinder", "box"]


@dataclass(frozen=True)
class Sensor:
    """A sensor by the name and kind that it has in the model."""

    name: str
    kind: Kind
    coordinate: int = -1  #: its place in Robot.coordinates, for jointpos and jointvel
    body: int = -1  #: its place in the scene, for all others
    position: tuple[float, ...] = (0.0, 0.0, 0.0)  #: m, of its frame in the body
    orientation: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)  #: of its frame in the body, x, y, z, w
    joint: int = -1  #: its place in the scene, for force and torque: the joint that carries the body
    zone: Zone | None = None  #: of touch
    size: tuple[float, ...] = ()  #: m, of the zone: radius, half lengths, as MuJoCo's
    min_value: float = -math.inf  #: that values are held to
    max_value: float = math.inf


class Frame:
    """Where a sensor is in a world, and how it moves."""

    def __init__(self, sensor: Sensor, world: _core.World) -> None:
        self.body = world.bodies[sensor.body]
        pose = world.pose(self.body)
        self.position = np.asarray(pose.position) + turned(pose.orientation, sensor.position)
        self.orientation = product(pose.orientation, sensor.orientation)
        self.angular = np.asarray(world.angular_velocity(self.body))
        arm = self.position - np.asarray(world.centre_of_mass(self.body))
        self.linear = np.asarray(world.velocity(self.body)) + np.cross(self.angular, arm)

    def inwards(self, vector: ArrayLike) -> Floats:
        """From the world's axes to its own."""
        return turned(inverse(self.orientation), vector)


def read(sensor: Sensor, world: _core.World) -> Floats:
    """Of any but jointpos, jointvel and accelerometer."""
    frame = Frame(sensor, world)
    if sensor.kind == "framepos":
        value = frame.position
    elif sensor.kind == "framequat":
        value = frame.orientation
    elif sensor.kind in ("framexaxis", "frameyaxis", "framezaxis"):
        value = turned(frame.orientation, np.eye(3)["xyz".index(sensor.kind[5])])
    elif sensor.kind == "framelinvel":
        value = frame.linear
    elif sensor.kind == "frameangvel":
        value = frame.angular
    elif sensor.kind == "gyro":
        value = frame.inwards(frame.angular)
    elif sensor.kind == "velocimeter":
        value = frame.inwards(frame.linear)
    elif sensor.kind == "touch":
        value = np.array([_touch(sensor, frame, world)])
    else:
        value = _load(sensor, frame, world)
    return np.asarray(np.clip(value, sensor.min_value, sensor.max_value), dtype=np.float64)


def _touch(sensor: Sensor, frame: Frame, world: _core.World) -> float:
    """N, of points on its body that are in its zone."""
    forces = world.contact_forces()
    own = [np.array(forces[side]["index"]) == frame.body.index for side in ("a", "b")]
    total = 0.0
    for force in forces[own[0] | own[1]]:
        if _within(sensor, frame.inwards(np.asarray(force["position"]) - frame.position)):
            total += float(force["normal_force"])
    return total


def _within(sensor: Sensor, point: Floats) -> bool:
    size = np.array(sensor.size)
    if sensor.zone == "sphere":
        return bool(point @ point <= size[0] ** 2)
    if sensor.zone == "capsule":
        along = point - [0, 0, np.clip(point[2], -size[1], size[1])]
        return bool(along @ along <= size[0] ** 2)
    if sensor.zone == "ellipsoid":
        return bool(np.sum((point / size) ** 2) <= 1)
    if sensor.zone == "cylinder":
        return bool(point[:2] @ point[:2] <= size[0] ** 2 and abs(point[2]) <= size[1])
    return bool(np.all(np.abs(point) <= size))


def _load(sensor: Sensor, frame: Frame, world: _core.World) -> Floats:
    """N or N m, of what carries its body, on the body and about the sensor."""
    joint = world.joints[sensor.joint]
    state, definition = world.joint_state(joint), world.joint(joint)
    force = np.asarray(state.force)
    if sensor.kind == "force":
        return frame.inwards(force)
    second = world.pose(definition.second)
    at = np.asarray(second.position) + turned(second.orientation, definition.frame_second.position)
    return frame.inwards(np.asarray(state.torque) + np.cross(at - frame.position, force))
