"""Surfaces: what holds between two materials, friction by its direction, and surfaces that turn."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import atoll


def _sliding(material: atoll.Material, velocity: list[float]) -> tuple[atoll.World, atoll.BodyId]:
    world = atoll.World()
    world.add_body(type="static", shape=atoll.HalfSpace(), material=atoll.Material(friction=1, id=1))
    crate = world.add_body(shape=atoll.Box([0.5, 0.5, 0.1]), position=[0, 0, 0.1], velocity=velocity, material=material)
    return world, crate


def test_a_pair_of_materials_has_a_friction_of_its_own() -> None:
    world, crate = _sliding(atoll.Material(id=2), [4, 0, 0])
    world.set_material_pair(atoll.MaterialPair(first=1, second=2, friction=0.1))
    for _ in range(60):
        world.step(1 / 60)
    assert world.velocity(crate)[0] == pytest.approx(4 - 9.81 * 0.1, abs=0.02)
    assert [(pair.first, pair.second, pair.restitution) for pair in world.material_pairs] == [(1, 2, None)]
    scene = atoll.Scene(material_pairs=world.material_pairs)
    assert pickle.loads(pickle.dumps(scene)).material_pairs[0].friction == 0.1


def test_friction_has_a_direction() -> None:
    skate = atoll.Material(friction=0.01, friction_across=0.64, friction_direction=[1, 0, 0])
    for velocity, friction in ([4.0, 0, 0], 0.1), ([0.0, 4, 0], 0.8):
        world, crate = _sliding(skate, velocity)
        for _ in range(20):
            world.step(1 / 60)
        assert np.linalg.norm(world.velocity(crate)) == pytest.approx(4 - 9.81 * friction / 3, abs=0.05)


def test_a_surface_turns_on_its_body() -> None:
    world, crate = _sliding(atoll.Material(), [0, 0, 0])
    world.set_surface_velocity(world.bodies[0], [0, 0, 0], angular=[0, 0, 2])
    for _ in range(120):
        world.step(1 / 60)
    assert world.angular_velocity(crate)[2] == pytest.approx(2, abs=0.01)
    assert world.definition(world.bodies[0]).surface_angular_velocity[2] == 2
