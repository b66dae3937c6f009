"""Many worlds at once."""

from __future__ import annotations

import gc

import numpy as np
import pytest

import atoll

SCENE = "pile:bodies=12"


def thrown(worlds: int, threads: int) -> atoll.Batch:
    batch = atoll.Batch(SCENE, worlds, threads=threads)
    velocities = np.zeros((worlds, len(batch.bodies), 3))
    velocities[:, -1, 0] = np.arange(worlds) % 5
    batch.set_velocities(velocities, np.zeros_like(velocities))
    batch.save_start()
    return batch


def test_worlds_are_as_by_themselves() -> None:
    batch = thrown(7, 2)
    batch.step(count=40)
    scene = atoll.load_scene(SCENE)
    for place in range(7):
        world = scene.build()
        moving = [body for body in world.bodies if world.type(body) != atoll.BodyType.STATIC]
        still = np.zeros((len(moving), 3))
        velocities = still.copy()
        velocities[-1, 0] = place % 5
        world.set_velocities(velocities, still, bodies=moving)
        world.steps(40, scene.dt)
        assert world.state_hash() == batch.hashes()[place] == batch[place].state_hash()
        assert np.array_equal(batch.positions[place], world.positions)
    assert np.array_equal(thrown(64, 3).hashes()[:5], thrown(5, 1).hashes())


def test_masks_and_places_choose_worlds() -> None:
    batch = thrown(6, 2)
    start = batch.hashes()
    batch.step(count=3, worlds=np.array([True, False, True, False, False, False]))
    batch.step(count=3, worlds=[4])
    assert list(batch.hashes() == start) == [False, True, False, True, False, True]
    batch.step(worlds=np.zeros(6, dtype=bool))
    batch.step(worlds=[])
    batch.reset(np.array([True, False, False, False, False, False]))
    batch.reset([2, 4])
    assert np.array_equal(batch.hashes(), start)
    with pytest.raises(atoll.Error, match="mask of 2; expected one of 6"):
        batch.reset(np.array([True, False]))
    with pytest.raises(atoll.Error, match="place 6"):
        batch.reset([6])
    with pytest.raises(atoll.Error, match="place -1"):
        batch.reset([-1])
    with pytest.raises(IndexError):
        batch[6]
    assert len(list(batch)) == len(batch) == 6 and batch[-1].state_hash() == start[5]


def test_single_worlds_can_be_changed_and_start_from_there() -> None:
    batch = atoll.Batch(SCENE, 8, threads=2)
    for place, world in enumerate(batch):
        world.gravity = [0, 0, -1 - place]
        world.set_mass(batch.bodies[-1], 1 + place)
    batch.save_start()
    batch.step(count=5)
    falls = batch.velocities[:, -1, 2]
    assert np.all(np.diff(falls) < 0)
    batch.reset()
    batch.step(count=5)
    assert np.array_equal(falls, batch.velocities[:, -1, 2])
    assert batch[3].mass(batch.bodies[-1]) == 4


def test_what_differs_from_world_to_world_is_set_by_arrays() -> None:
    """A box slides by v^2 / (2 mu g), whatever its mass."""
    ground = atoll.BodyDef(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
    box = atoll.BodyDef(shape=atoll.Box([0.5, 0.5, 0.1]), position=[0, 0, 0.1], velocity=[3, 0, 0])
    batch = atoll.Batch(atoll.Scene(bodies=[atoll.SceneBody(definition=body) for body in (ground, box)]), 6)
    friction, gravity = np.linspace(0.3, 0.8, 6), np.linspace(4, 12, 6)
    batch.set_gravities(np.stack([0 * gravity, 0 * gravity, -gravity], axis=1))
    batch.set_masses(1, np.geomspace(1, 1000, 6))
    for body in range(2):
        batch.set_frictions(body, friction)
    batch.save_start()
    batch.step(count=240)
    exact = 3**2 / (2 * friction * gravity)
    assert batch.positions[:, 1, 0] == pytest.approx(exact, rel=0.01)
    batch.reset([2, 4])
    batch.step(count=240, worlds=[2, 4])
    assert batch.positions[:, 1, 0] == pytest.approx(exact, rel=0.01)
    with pytest.raises(atoll.Error, match="found body 2; expected one below 2"):
        batch.set_masses(2, friction)
    with pytest.raises(atoll.Error, match="static or kinematic"):
        batch.set_masses(0, np.ones(6))


def test_joints_are_driven_in_each_world() -> None:
    batch = atoll.Batch("slider-crank", 4)
    motor = next(
        i
        for i, joint in enumerate(batch.scene.joints)
        if isinstance(joint.definition.kind, atoll.HingeJoint) and joint.definition.kind.angle.motor is not None
    )
    batch.set_motor_speeds(motor, np.array([1.0, 2, 3, 4]))
    batch.step(count=2)
    positions, speeds = batch.read_joint(motor)
    assert speeds == pytest.approx([1, 2, 3, 4], rel=0.02) and np.all(positions > 0)
    assert batch.joint_positions.shape == (4, len(batch.joints), 6)
    assert np.array_equal(batch.joint_positions[:, motor, 0], positions)
    assert np.array_equal(batch.joint_speeds[:, motor, 0], speeds)


def test_forces_act_in_the_next_step() -> None:
    batch = atoll.Batch("free-flight", 3)
    forces = np.zeros((3, len(batch.bodies), 3))
    mass = batch[0].mass(batch.bodies[0])
    forces[1, 0, 1] = mass
    before = batch.velocities
    batch.apply_forces(forces)
    batch.step(0.01)
    assert batch.velocities[1, 0, 1] - before[1, 0, 1] == pytest.approx(0.01 + (batch.velocities - before)[0, 0, 1])


def test_worlds_and_views_outlive_their_batch() -> None:
    batch = atoll.Batch(SCENE, 3)
    world = batch[1]
    view = batch[2].positions
    places = batch.positions
    del batch
    gc.collect()
    world.step()
    assert view.shape == places[2].shape and np.array_equal(view, places[2])
