"""The bits of every build are those of the C++ tests."""

from __future__ import annotations

from collections import defaultdict

import pytest

import atoll

from conftest import ROOT

HASHES: dict[tuple[str, str], dict[int, int]] = defaultdict(dict)
for line in (ROOT / "tests/determinism/golden_hashes.txt").read_text().splitlines():
    if not line.startswith("#"):
        number, step, settings, name = line.split()
        HASHES[settings, name][int(step)] = int(number, 16)


class Hash:
    """As jobs/hash.h has it."""

    def __init__(self) -> None:
        self.state = 0x9E3779B97F4A7C15

    def add(self, word: int) -> None:
        product = (self.state ^ word) * 0xA0761D6478BD642F
        self.state = ((product ^ product >> 64) + 0xE7037ED1A0B428DB) % 2**64


def hash_of(world: atoll.World) -> int:
    """Of the state and the events, as the C++ tests take it."""
    found = Hash()
    found.add(world.state_hash())
    for event in world.contact_events():
        a, b = event["a"], event["b"]
        found.add(int(a["index"]) << 32 | int(b["index"]))
        found.add(int(a["generation"]) << 32 | int(b["generation"]))
        found.add(int(event["began"]))
    for joint_event in world.joint_events():
        found.add(joint_event.joint.index << 32 | joint_event.joint.generation)
        found.add(joint_event.kind.value)
    return found.state


def scene_of(settings: str, name: str) -> atoll.Scene:
    scene = atoll.load_scene(str(ROOT / name) if name.endswith(".json") else name)
    changed = scene.settings
    changed.contact_events = True
    if settings == "varied":
        changed.substeps = 3
        changed.iterations = 3
        changed.tolerance = 1e-3
        changed.friction = atoll.FrictionModel.PYRAMID
        changed.stabilisation = atoll.Stabilisation.SPLIT_IMPULSE
        changed.joint_solver = atoll.JointSolver.ITERATIVE
        changed.sleeping = True
    elif settings == "sleeping":
        changed.sleeping = True
        changed.time_to_sleep = 0.2
    scene.settings = changed
    return scene


@pytest.mark.parametrize(("settings", "name"), HASHES)
def test_hashes_are_those_of_the_file(settings: str, name: str) -> None:
    scene = scene_of(settings, name)
    world = scene.build(threads=2)
    found = {}
    for step in range(1, max(HASHES[settings, name]) + 1):
        scene.apply_forces(world)
        world.step(scene.dt)
        if step in HASHES[settings, name]:
            found[step] = hash_of(world)
    assert found == HASHES[settings, name]
