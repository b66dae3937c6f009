"""Ctrl-C while many steps run in one call, and counts that there can't be."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import numpy as np
import pytest

import atoll

from conftest import DT

GRAVITY = 1e-9  # m/s^2: slow enough to fall for millions of steps


@pytest.fixture
def interrupt() -> Iterator[None]:
    """Ctrl-C soon, however the tests were started."""
    on_interrupt = signal.signal(signal.SIGINT, signal.default_int_handler)
    on_alarm = signal.signal(signal.SIGALRM, lambda number, frame: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_REAL, 0.1)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, on_alarm)
    signal.signal(signal.SIGINT, on_interrupt)


def falling() -> atoll.World:
    world = atoll.World(gravity=[0, 0, -GRAVITY], settings=atoll.Settings(sleeping=False))
    world.add_body()
    return world


def test_steps_end_between_two(interrupt: None) -> None:
    world = falling()
    with pytest.raises(KeyboardInterrupt):
        world.steps(3_000_000, DT)
    made = round(-world.velocities[0, 2] / (GRAVITY * DT))
    assert 0 < made < 3_000_000
    again = falling()
    for _ in range(made):
        again.step(DT)
    assert world.state_hash() == again.state_hash()


def test_worlds_of_a_batch_end_after_as_many_steps(interrupt: None) -> None:
    batch = atoll.Batch(atoll.scene_of(falling()), 5, threads=2)
    start = batch.hashes()[0]
    with pytest.raises(KeyboardInterrupt):
        batch.step(DT, count=3_000_000)
    assert len(np.unique(batch.hashes())) == 1 and batch.hashes()[0] != start


def test_batches_come_to_the_same_however_many_steps_a_call() -> None:
    one, other = (atoll.Batch("pile:bodies=12", 3) for _ in range(2))
    one.step(count=60)
    for _ in range(60):
        other.step()
    assert np.array_equal(one.hashes(), other.hashes())


def test_negative_counts_are_errors(world: atoll.World) -> None:
    before = world.state_hash()
    with pytest.raises(atoll.Error, match="found -1 steps; expected 0 or more"):
        world.steps(-1)
    world.steps(0)
    assert world.state_hash() == before
    with pytest.raises(atoll.Error, match="found -1 steps; expected 0 or more"):
        atoll.Batch("stack:height=2", 2).step(count=-1)
