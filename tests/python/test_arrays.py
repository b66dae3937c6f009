"""Views over a world's memory, and arrays that are passed in."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

import atoll

from conftest import DT


def test_views_follow_the_world_without_copies() -> None:
    world = atoll.World()
    ball = world.add_body(shape=atoll.Sphere(0.5), position=[0, 0, 100])
    positions = world.positions
    again = world.positions
    assert positions.shape == (1, 3) and positions.dtype == np.float64
    assert positions.ctypes.data == again.ctypes.data
    world.step(DT)
    assert positions[ball, 2] < 100
    assert positions[ball, 2] == world.pose(ball).position[2]
    with pytest.raises(ValueError, match="read-only"):
        positions[0, 0] = 1


def test_views_go_through_dlpack_and_stay_read_only() -> None:
    world = atoll.World()
    world.add_body(shape=atoll.Sphere(0.5), position=[0, 0, 100])
    view = np.from_dlpack(world.positions)
    assert np.shares_memory(view, world.positions) and not view.flags.writeable
    world.step(DT)
    assert view[0, 2] == world.positions[0, 2] < 100
    with pytest.raises(ValueError, match="read-only"):
        view[0, 0] = 1
    with pytest.raises(BufferError, match="readonly"):  # as who doesn't know of read-only arrays asks
        world.positions.__dlpack__()
    copied = np.from_dlpack(world.positions, copy=True)
    copied[0, 0] = 1
    assert world.positions[0, 0] == 0
    alone = np.from_dlpack(atoll.Batch("stack:height=2", 2).positions)  # which is nobody else's
    alone[0, 0] = 1
    last = world.positions[0].copy()
    del world
    gc.collect()
    assert np.array_equal(view[0], last)


def test_views_outlive_bodies_that_are_added() -> None:
    world = atoll.World()
    world.add_body(position=[1, 2, 3])
    views = [world.positions]
    for i in range(2000):
        world.add_body(position=[i, 0, 0])
        if i % 100 == 0:
            views.append(world.positions)
    for view in views:
        assert list(view[0]) == [1, 2, 3]
    assert len(world.positions) == 2001


def test_views_outlive_their_world_and_what_is_restored() -> None:
    world = atoll.World()
    for i in range(500):
        world.add_body(position=[i, 0, 0])
    empty = atoll.World().save()
    view = world.positions
    world.restore(empty)
    assert world.body_count == 0
    assert view.sum() == sum(range(500))
    gone = weakref.ref(view)
    del world
    gc.collect()
    assert view[499, 0] == 499
    copied = view[499]
    del view
    gc.collect()
    assert copied[0] == 499
    assert gone() is not None or copied.base is not None


def test_views_can_be_read_whatever_becomes_of_the_world() -> None:
    """Where they can't, a build with the address sanitizer says so."""
    random = np.random.default_rng(8)
    world = atoll.World()
    saved = [world.save()]
    views = []
    for _ in range(400):
        choice = random.integers(7)
        if choice < 3:
            for _ in range(random.integers(1, 40)):
                world.add_body(shape=atoll.Sphere(0.4), position=random.uniform(-20, 20, 3))
        elif choice == 3 and world.bodies:
            world.remove_body(world.bodies[random.integers(world.body_count)])
        elif choice == 4:
            saved.append(world.save())
        elif choice == 5:
            world.restore(saved[random.integers(len(saved))])
        else:
            world.step(DT)
        for name in ("positions", "orientations", "velocities", "angular_velocities"):
            view = getattr(world, name)
            views.append(view)
            for body in world.bodies[:3]:
                assert np.array_equal(world.positions[body], world.centre_of_mass(body))
    sizes = [len(view) for view in views]
    assert max(sizes) > 300
    del world
    gc.collect()
    for view, size in zip(views, sizes, strict=True):
        assert len(view.copy()) == size and np.isfinite(view).all()


def test_arrays_are_set_in_one_call() -> None:
    world = atoll.World(gravity=[0, 0, 0])
    ids = [world.add_body() for _ in range(5)]
    positions = np.arange(15.0).reshape(5, 3) * 10
    upright = np.tile([0.0, 0, 0, 1], (5, 1))
    world.set_poses(positions, upright)
    assert np.array_equal(world.positions, positions)
    world.set_velocities(np.ones((2, 3)), np.zeros((2, 3)), bodies=[ids[1], ids[3]])
    assert world.velocities.sum() == 6
    world.apply_forces(np.full((5, 3), 1000.0), np.zeros((5, 3)))
    world.apply_forces(np.full((5, 3), 1000.0))
    world.step(DT)
    assert world.velocity(ids[0]) == pytest.approx([2000 / 1000 * DT] * 3, rel=1e-5)
    with pytest.raises(atoll.Error):
        world.set_poses(positions[:4], upright)
    with pytest.raises(TypeError):
        world.set_poses(positions[:, :2], upright)


def test_other_numbers_are_converted() -> None:
    world = atoll.World(gravity=[0, 0, 0])
    world.add_body()
    world.set_velocities(np.array([[1, 2, 3]], dtype=np.float32), np.zeros((1, 6))[:, ::2])
    assert list(world.velocities[0]) == [1, 2, 3]


def test_contacts_are_structured_arrays(world: atoll.World) -> None:
    forces = world.contact_forces()
    assert len(forces) == 4
    weight = world.mass(world.bodies[1]) * 9.81
    assert forces["normal_force"].sum() == pytest.approx(weight, rel=1e-3)
    assert np.all(forces["a"]["index"] == 0) and np.all(forces["b"]["index"] == 1)
    assert forces["normal"][0] == pytest.approx([0, 0, 1])
    assert [forces["position"][:, 0].min(), forces["position"][:, 0].max()] == pytest.approx([-0.5, 0.5], abs=1e-4)
    pairs = world.pair_forces()
    assert pairs["force"][0] == pytest.approx([0, 0, weight], rel=1e-3, abs=1e-2)


def test_rays_in_arrays_are_those_one_by_one(world: atoll.World) -> None:
    random = np.random.default_rng(1)
    origins = random.uniform(-1, 1, (200, 3)) + [0, 0, 3]
    directions = random.normal(size=(200, 3))
    found = world.cast_rays(origins, directions, max_distance=50)
    assert 20 < found["hit"].sum() < 200
    for origin, direction, record in zip(origins, directions, found):
        hit = world.cast_ray(origin, direction, 50)
        assert bool(record["hit"]) == (hit is not None)
        if hit is not None:
            assert record["distance"] == hit.distance and record["body"]["index"] == hit.body.index
            assert np.array_equal(record["point"], hit.point)


def test_dlpack_hands_views_on_without_copies(world: atoll.World) -> None:
    view = world.positions
    handed = np.from_dlpack(view)
    assert handed.ctypes.data == view.ctypes.data
