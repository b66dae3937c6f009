"""What all worlds of a batch tell and take in one call, as arrays by place."""

from __future__ import annotations

import numpy as np
import pytest

import atoll

WORLDS = 5


def batch_of(*bodies: atoll.BodyDef, joints: list[atoll.SceneJoint] | None = None, falls: bool = False) -> atoll.Batch:
    scene = atoll.Scene(
        gravity=[0, 0, -10 if falls else 0],
        dt=1 / 240,
        bodies=[atoll.SceneBody(definition=body) for body in bodies],
        joints=joints or [],
    )
    return atoll.Batch(scene, WORLDS)


def test_arrays_are_read_as_the_numbers_that_are_asked_for() -> None:
    batch = atoll.Batch("slider-crank", WORLDS)
    batch.step(count=3)
    for name in ("positions", "contact_torques", "joint_speeds", "joint_forces"):
        numbers = batch.read(name)
        assert numbers.dtype == np.float64 and numbers.flags.writeable
        assert np.array_equal(numbers, getattr(batch, name))
        single = batch.read(name, np.float32)
        assert single.dtype == np.float32 and np.array_equal(single, numbers.astype(np.float32))
    with pytest.raises(atoll.Error, match="found \"speeds\"; expected of positions, .*, joint_torques"):
        batch.read("speeds")


def test_several_arrays_are_read_as_one_by_one() -> None:
    batch = atoll.Batch("slider-crank", WORLDS)
    batch.step(count=3)
    names = ["joint_speeds", "orientations", "joint_forces", "positions"]
    for name, numbers in zip(names, batch.read_all(names), strict=True):
        assert np.array_equal(numbers, batch.read(name)), name
    for name, numbers in zip(names, batch.read_all(names, np.float32, worlds=[3, 0]), strict=True):
        assert np.array_equal(numbers, batch.read(name, np.float32)[[3, 0]]), name
    assert [of.shape[0] for of in batch.read_all(names, worlds=np.zeros(WORLDS, dtype=bool))] == [0, 0, 0, 0]
    with pytest.raises(atoll.Error, match="found \"speeds\"; expected of positions, .*, joint_torques"):
        batch.read_all(["positions", "speeds"])


def test_contacts_of_all_worlds_are_those_of_each() -> None:
    batch = atoll.Batch("pile:bodies=6", WORLDS)
    for place, world in enumerate(batch):
        world.gravity = [0, 0, -5 - place]
    batch.step(count=90)
    points = batch.contact_points()
    assert len(points) > 4 * WORLDS
    for place, world in enumerate(batch):
        of_world, alone = points[points["world"] == place], world.contact_forces()
        assert alone.dtype.names is not None
        for name in alone.dtype.names:
            assert np.array_equal(of_world[name], alone[name])


def test_sensors_count_what_is_in_them_in_each_world() -> None:
    gate = atoll.BodyDef(type="static", shape=atoll.Box([1, 1, 1]), sensor=True)
    batch = batch_of(*[atoll.BodyDef(shape=atoll.Sphere(0.1), position=[3 + i, 0, 0]) for i in range(2)], gate)
    speeds = np.zeros((WORLDS, 3, 3))
    speeds[:, :2, 0] = -np.arange(WORLDS)[:, None]
    batch.set_velocities(speeds, np.zeros_like(speeds))
    batch.step(count=240)  # 1 s: the balls are at 3 - i and 4 - i
    assert batch.sensor_counts([2])[:, 0].tolist() == [0, 0, 1, 2, 2]
    with pytest.raises(atoll.Error, match="not a sensor"):
        batch.sensor_counts([0])
    with pytest.raises(atoll.Error, match="found body 3; expected one below 3"):
        batch.sensor_counts([3])


def test_balls_bounce_as_their_restitution_says() -> None:
    """Off the ground at e times the speed at which they come, where the larger e of two bodies counts."""
    ball = atoll.BodyDef(shape=atoll.Sphere(0.5), position=[0, 0, 0.6], velocity=[0, 0, -4])
    batch = batch_of(atoll.BodyDef(type="static", shape=atoll.HalfSpace()), ball)
    restitution = np.linspace(0.2, 1, WORLDS)
    batch.set_body_numbers("restitution", [1], restitution)
    batch.step(count=48)
    assert batch.velocities[:, 1, 2] == pytest.approx(4 * restitution, rel=1e-3)


def test_shapes_are_as_large_as_each_world_says() -> None:
    """A solid lies on the ground with its middle at its radius or half extent. A ball's inertia grows as r^2: mass stays."""
    bodies = [atoll.BodyDef(position=[3 * i, 0, 1], mass=2) for i in range(3)]
    bodies[0].shape, bodies[2].shape = atoll.Sphere(0.5), atoll.Capsule(0.2, 0.3)
    batch = batch_of(atoll.BodyDef(type="static", shape=atoll.HalfSpace()), *bodies, falls=True)
    sizes = np.linspace(0.2, 0.6, WORLDS)
    batch.set_body_numbers("radius", [1], sizes)
    batch.set_body_numbers("half_extent_z", [2], sizes)
    batch.set_body_numbers("half_height", [3], sizes)
    batch.step(count=480)
    heights = batch.positions[:, 1:, 2]
    expected = np.stack([sizes, sizes, 0.2 + sizes], axis=1)
    assert heights == pytest.approx(expected, abs=5e-3)
    for place, size in enumerate(sizes):
        ball = batch[place].definition(batch.bodies[1])
        assert ball.mass == pytest.approx(2) and ball.inertia is not None
        assert ball.inertia[0, 0] == pytest.approx(0.4 * 2 * size**2)
    batch.reset()
    start = batch[0].definition(batch.bodies[1]).shape
    assert isinstance(start, atoll.Sphere) and start.radius == 0.5
    with pytest.raises(atoll.Error, match="found a shape without such a size"):
        batch.set_body_numbers("radius", [2], sizes)
    with pytest.raises(atoll.Error, match="World::set_shape: shape.*radius"):
        batch.set_body_numbers("radius", [1], -sizes)


def test_bodies_are_damped_as_each_world_says() -> None:
    """dv/dt = -c v, along and about."""
    apart = [[0, 0, 0], [0, 9, 0]]
    batch = batch_of(*[atoll.BodyDef(position=at, velocity=[3, 0, 0], angular_velocity=[0, 0, 3]) for at in apart])
    damping = np.linspace(0, 1, 2 * WORLDS).reshape(WORLDS, 2)
    batch.set_body_numbers(atoll.BodyNumber.LINEAR_DAMPING, [0, 1], damping)
    batch.set_body_numbers("angular-damping", [1, 0], damping / 2)
    batch.step(count=240)
    assert batch.velocities[:, :, 0] == pytest.approx(3 * np.exp(-damping), rel=2e-3)
    assert batch.angular_velocities[:, ::-1, 2] == pytest.approx(3 * np.exp(-damping / 2), rel=2e-3)


def test_motors_pull_as_hard_as_each_world_says() -> None:
    """v = F t / m, until the motor has its speed."""
    bodies = [atoll.BodyDef(type="static"), atoll.BodyDef(mass=2)]
    rail = atoll.SliderJoint(atoll.JointAxis(motor=atoll.JointMotor(speed=3, max_force=1)))
    joint = atoll.SceneJoint(definition=atoll.JointDef(kind=rail), first=0, second=1)
    batch = batch_of(*bodies, joints=[joint])
    forces = np.linspace(2, 10, WORLDS)
    batch.set_joint_numbers("max_force", [0], forces[1:], worlds=range(1, WORLDS))
    batch.set_joint_numbers("max_force", [0], forces[:1], worlds=[0])
    batch.step(count=240)
    assert batch.joint_speeds[:, 0, 0] == pytest.approx(np.minimum(3, forces / 2), rel=1e-3)
    with pytest.raises(atoll.Error, match="found no servo along the coordinate"):
        batch.set_joint_numbers("servo_damping", [0], forces)
    with pytest.raises(atoll.Error, match="found joint 1; expected one below 1"):
        batch.set_joint_numbers("friction", [1], forces)
    with pytest.raises(atoll.Error, match="found 5 numbers of joint; expected 10"):
        batch.set_joint_numbers("friction", [0, 0], forces)
