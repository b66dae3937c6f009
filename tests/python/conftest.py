"""What the tests of the package share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import atoll

ROOT = Path(__file__).resolve().parents[2]
DT = 1 / 60
LONG_TESTS = os.environ.get("ATOLL_LONG_TESTS") == "1"
#: What is slow, or takes what not every machine has.
long_test = pytest.mark.skipif(not LONG_TESTS, reason="a matter of ATOLL_LONG_TESTS=1, or tests/run.sh --long")


@pytest.fixture
def world() -> atoll.World:
    """Ground, and a box that has lain on it for a while."""
    made = atoll.World()
    made.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace(), name="ground")
    made.add_body(shape=atoll.Box([0.5, 0.5, 0.5]), position=[0, 0, 0.5], name="crate")
    made.steps(30, DT)
    return made
