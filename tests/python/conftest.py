"""What the tests of the package share."""

from __future__ import annotations

from pathlib import Path

import pytest

import atoll

ROOT = Path(__file__).resolve().parents[2]
DT = 1 / 60


@pytest.fixture
def world() -> atoll.World:
    """Ground, and a box that has lain on it for a while."""
    made = atoll.World()
    made.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace(), name="ground")
    made.add_body(shape=atoll.Box([0.5, 0.5, 0.5]), position=[0, 0, 0.5], name="crate")
    made.steps(30, DT)
    return made
