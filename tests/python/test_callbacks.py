"""Functions of Python that have a say in a step."""

from __future__ import annotations

import gc
import weakref
from typing import Any

import numpy as np
import pytest

import atoll

from conftest import DT


def test_force_laws_are_called_in_each_substep() -> None:
    world = atoll.World(gravity=[0, 0, 0], settings=atoll.Settings(substeps=16))
    ball = world.add_body(shape=atoll.Sphere(0.1), mass=1, position=[1, 0, 0])
    times = []

    def spring(forces: atoll.Forces) -> None:
        times.append(forces.time)
        forces.add(ball, -4 * forces.world.centre_of_mass(ball))

    for _ in range(60):
        world.step(DT, spring)
    assert len(times) == 60 * 17
    assert world.positions[ball, 0] == pytest.approx(np.cos(2.0), abs=1e-4)

    def everywhere(forces: atoll.Forces) -> None:
        forces.add_all(np.full((1, 3), 1.0))
        with pytest.raises(atoll.Error, match="3 rows; expected 1"):
            forces.add_all(np.zeros((3, 3)))

    before = world.velocity(ball)
    world.step(DT, everywhere)
    assert world.velocity(ball) - before == pytest.approx([DT] * 3, rel=1e-4)


def test_what_a_law_raises_goes_through(world: atoll.World) -> None:
    def gives_up(forces: atoll.Forces) -> None:
        raise KeyError("nothing to say")

    with pytest.raises(KeyError, match="nothing to say"):
        world.step(DT, gives_up)
    world.step(DT)


def test_filters_and_modifiers() -> None:
    def fall(filtered: bool, friction: float) -> atoll.World:
        world = atoll.World()
        world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
        world.add_body(position=[0, 0, 0.6], velocity=[2, 0, 0])
        if filtered:
            world.set_contact_filter(lambda of: of.b.index != 1)

        def slippery(contact: atoll.ModifiableContact) -> None:
            assert contact.world.body_count == 2 and len(contact.points) <= 4
            contact.friction = friction

        world.set_contact_modifier(slippery)
        world.steps(60, DT)
        world.set_contact_modifier(None)
        world.set_contact_filter(None)
        return world

    assert fall(True, 0).positions[1, 2] < -3
    assert fall(False, 0).velocities[1, 0] == pytest.approx(2, abs=1e-3)
    assert fall(False, 0.9).velocities[1, 0] == pytest.approx(0, abs=1e-2)


def test_a_modifier_must_not_change_the_world(world: atoll.World) -> None:
    def meddles(contact: atoll.ModifiableContact) -> None:
        contact.world.add_body()

    world.set_contact_modifier(meddles)
    with pytest.raises(atoll.Error):
        world.step(DT)
    world.set_contact_modifier(None)
    assert world.body_count == 2


def test_what_functions_are_asked_of_is_gone_afterwards(world: atoll.World) -> None:
    contacts: list[atoll.ModifiableContact] = []
    points: list[atoll.ModifiablePoint] = []
    laws: list[atoll.Forces] = []

    def keeps(contact: atoll.ModifiableContact) -> None:
        contacts.append(contact)
        points.extend(contact.points)
        contact.points[0].enabled = np.bool_(True)  # type: ignore[assignment]

    world.set_contact_modifier(keeps)
    world.step(DT, laws.append)
    world.set_contact_modifier(None)
    assert contacts and points and laws
    for ask in (lambda: contacts[0].world, lambda: laws[0].time, lambda: points[0].separation):
        with pytest.raises(atoll.Error, match="is gone"):
            ask()


def test_query_predicates_are_asked() -> None:
    world = atoll.World(threads=2)
    for height in range(5):
        world.add_body(type=atoll.BodyType.STATIC, position=[0, 0, 2 * height])
    low = atoll.QueryFilter(predicate=lambda body, child: body.index < 3)
    hit = world.cast_ray([0, 0, 20], [0, 0, -1], filter=low)
    assert hit is not None and hit.body.index == 2
    found = world.cast_rays(np.tile([0.0, 0, 20], (64, 1)), np.tile([0.0, 0, -1], (64, 1)), filter=low)
    assert set(found["body"]["index"]) == {2}


def test_worlds_are_dropped_with_their_functions() -> None:
    class Marked:
        def __call__(self, of: atoll.ContactCandidate) -> bool:
            return True

    function = Marked()
    gone = weakref.ref(function)
    world = atoll.World()
    world.set_contact_filter(function)
    del function
    assert gone() is not None
    del world
    gc.collect()
    assert gone() is None


class Refers:
    """A function that refers to what asks it."""

    def __init__(self, to: object) -> None:
        self.to = to

    def __call__(self, of: object) -> Any:
        return True


def test_rings_of_a_world_and_its_functions_are_freed() -> None:
    world = atoll.World()
    rule, change = Refers(world), Refers(world)
    gone = [weakref.ref(rule), weakref.ref(change)]
    world.set_contact_filter(rule)
    world.set_contact_modifier(change)
    del rule, change
    gc.collect()
    assert all(function() is not None for function in gone)
    world.step(DT)
    del world
    gc.collect()
    assert all(function() is None for function in gone)


def test_rings_of_a_batch_and_functions_of_its_worlds_are_freed() -> None:
    batch = atoll.Batch("stack:height=2", 3)
    function = Refers(batch)
    gone = weakref.ref(function)
    batch[1].set_contact_filter(function)
    del function
    gc.collect()
    assert gone() is not None
    batch.step()
    del batch
    gc.collect()
    assert gone() is None


def test_functions_that_were_replaced_are_freed(world: atoll.World) -> None:
    first = Refers(world)
    gone = weakref.ref(first)
    world.set_contact_filter(first)
    world.set_contact_filter(Refers(None))
    del first
    gc.collect()
    assert gone() is None
    world.step(DT)
