"""A model as a scene, in the coordinates and by the names that it came with."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .axes import direction
from .quaternions import Floats, turned
from .receipt import Receipt
from .sensors import Frame, Sensor, read


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of the model that a joint of the scene has."""

    name: str
    joint: int  #: the joint's place in the scene
    kind: Literal["hinge", "slide"]
    axis: int = 0  #: which of that joint's coordinates it is, as World.joint_axis() has them
    max_force: float = math.inf  #: N or N m, as a URDF's effort; nothing holds the joint to it
    max_speed: float = math.inf  #: m/s or rad/s, as a URDF's velocity; nothing holds the joint to it


@dataclass(frozen=True)
class Actuator:
    """What a control acts on: force = gain * control + bias - stiffness * position - damping * rate, within its limit,
    of a coordinate, or the length of a tendon, N or N m."""

    name: str
    coordinate: int  #: its place in Robot.coordinates; -1 of one on a tendon
    kind: Literal["position", "velocity", "force"]
    gain: float
    bias: float
    stiffness: float
    damping: float
    limit: float  #: N or N m, or infinite
    range: tuple[float, float]  #: that controls are held to
    tendon: int = -1  #: the tendon's place among the joints of the scene; -1 of one on a coordinate


@dataclass
class Robot:
    """A scene made of a model: see load_mjcf()."""

    name: str
    scene: _core.Scene
    receipt: Receipt
    bodies: dict[str, int]  #: places in the scene of the model's bodies. Those that are welded together share one.
    coordinates: list[Coordinate] = field(default_factory=list)  #: in the model's order
    actuators: list[Actuator] = field(default_factory=list)  #: in the model's order

    sensors: list[Sensor] = field(default_factory=list)  #: in the model's order

    def build(self, threads: int = 1) -> _core.World:
        """A world of the scene."""
        return self.scene.build(threads=threads)

    def positions(self, world: _core.World) -> Floats:
        """m or rad, shape (coordinates,), of a world that build() made."""
        return self._states(world, "position")

    def rates(self, world: _core.World) -> Floats:
        """m/s or rad/s, shape (coordinates,)."""
        return self._states(world, "speed")

    def mechanism(self, world: _core.World, body: str | None = None) -> _core.Mechanism:
        """The model's generalised coordinates, of a world that build() made, in the model's order.

        What hangs on the world is one tree, with all that does; a tree with a free base is one by itself. body: any
        body of the tree that is meant; by default the tree of the first joint, or the first body that moves. Raises
        Error on a body that the model hasn't, and where nothing moves.
        """
        carriers = {joint.second: joint.first for joint in self.scene.joints}
        moving = [place for place in self.bodies.values() if self._moves(place)]
        if body is not None and body not in self.bodies:
            raise _core.Error(f"Robot.mechanism: body is {body!r}; expected one of {', '.join(self.bodies)}")
        if not moving:
            raise _core.Error(f"Robot.mechanism: no body of {self.name} moves; expected one that does")
        jointed = [joint.second for joint in self.scene.joints]
        place = self.bodies[body] if body is not None else (jointed or moving)[0]
        while place in carriers:
            place = carriers[place]
        return _core.Mechanism(world, world.bodies[place])

    def _moves(self, place: int) -> bool:
        return self.scene.bodies[place].definition.type is _core.BodyType.DYNAMIC

    def control(self, world: _core.World, controls: ArrayLike) -> None:
        """Gives the actuators their controls, shape (actuators,), in units of the model: for the next step where they
        are forces, and until they are others elsewhere."""
        values = np.asarray(controls, dtype=np.float64)
        if values.shape != (len(self.actuators),):
            expected = f"({len(self.actuators)},), of the actuators"
            raise _core.Error(f"Robot.control: controls has the shape {values.shape}; expected {expected}")
        ids = world.joints
        for actuator, value in zip(self.actuators, values, strict=True):
            on_tendon = actuator.tendon >= 0
            of = None if on_tendon else self.coordinates[actuator.coordinate]
            joint, axis = ids[of.joint if of else actuator.tendon], of.axis if of else 0
            force = actuator.gain * float(np.clip(value, *actuator.range)) + actuator.bias
            if actuator.kind == "position":
                world.set_servo_target(joint, force / actuator.stiffness, axis)
            elif actuator.kind == "velocity":
                world.set_motor_speed(joint, force / actuator.damping, axis)
            else:
                push = float(np.clip(force, -actuator.limit, actuator.limit))
                self._push(world, joint, axis, push)

    def motion(self, world: _core.World) -> Floats:
        """m/s, shape (accelerometers, 3), of the places of accelerometers: for a later read()."""
        speeds = [Frame(sensor, world).linear for sensor in self.sensors if sensor.kind == "accelerometer"]
        return np.array(speeds, dtype=np.float64).reshape(-1, 3)

    def read(self, world: _core.World, before: ArrayLike | None = None, seconds: float = 0) -> dict[str, Floats]:
        """What the sensors read, by their names, in the axes and units of the model; orientations are x, y, z, w.

        before: what motion() told so many seconds ago, > 0. Accelerometers read the mean acceleration since then, without
        that of gravity, and NaN if it is left out.
        """
        states = {"jointpos": self.positions(world), "jointvel": self.rates(world)}
        count = sum(sensor.kind == "accelerometer" for sensor in self.sensors)
        speeds = np.full((count, 3), np.nan) if before is None else np.asarray(before, dtype=np.float64)
        if speeds.shape != (count, 3):
            raise _core.Error(f"Robot.read: before has the shape {speeds.shape}; expected ({count}, 3), of motion()")
        if before is not None and not seconds > 0:
            raise _core.Error(f"Robot.read: seconds is {seconds}; expected a time > 0 since motion()")
        earlier, values = iter(speeds), {}
        for sensor in self.sensors:
            if sensor.coordinate >= 0:
                value = states[sensor.kind][[sensor.coordinate]].clip(sensor.min_value, sensor.max_value)
            elif sensor.kind == "accelerometer":
                frame = Frame(sensor, world)
                change = (frame.linear - next(earlier)) / (seconds or 1)
                value = frame.inwards(change - np.asarray(world.gravity)).clip(sensor.min_value, sensor.max_value)
            else:
                value = read(sensor, world)
            values[sensor.name] = value
        return values

    def _states(self, world: _core.World, what: str) -> Floats:
        ids = world.joints
        states: list[Any] = [getattr(world.joint_state(ids[c.joint]), what)[c.axis] for c in self.coordinates]
        return np.array(states, dtype=np.float64)

    def _push(self, world: _core.World, joint: _core.JointId, axis: int, push: float) -> None:
        """Along a coordinate, N or N m: on the second body, and against it on the first. Of a linear tendon along all."""
        definition = world.joint(joint)
        if isinstance(definition.kind, _core.TendonJoint):
            for term in definition.kind.terms:
                self._push(world, term.joint, term.coordinate, push * term.polynomial[1])
            return
        first, second = world.pose(definition.first), world.pose(definition.second)
        along = push * direction(definition, axis, first, second)
        if isinstance(definition.kind, _core.HingeJoint) or axis >= 3:
            world.apply_force(definition.second, [0, 0, 0], along)
            world.apply_force(definition.first, [0, 0, 0], -along)
            return
        at = np.asarray(second.position) + turned(np.asarray(second.orientation), definition.frame_second.position)
        for body, force in ((definition.second, along), (definition.first, -along)):
            world.apply_force(body, force, np.cross(at - np.asarray(world.centre_of_mass(body)), force))
