"""Scenes, recordings and errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import atoll


def test_built_in_scenes_are_told_and_built() -> None:
    scenes = {scene.name: scene for scene in atoll.builtin_scenes()}
    assert "pile" in scenes and scenes["pile"].help
    assert {parameter.name for parameter in scenes["pile"].parameters} >= {"bodies"}
    scene = atoll.load_scene("pile:bodies=20")
    assert len(scene.build().bodies) == len(scene.bodies)


def test_scenes_go_to_files_and_back(tmp_path: Path, world: atoll.World) -> None:
    scene = atoll.scene_of(world)
    scene.write(str(tmp_path / "scene.json"))
    again = atoll.load_scene(str(tmp_path / "scene.json")).build()
    assert np.array_equal(again.positions, world.positions)
    scene.name = "yard"
    assert atoll.parse_scene(scene.text()).text() == scene.text()


def test_recordings_are_replayed_and_looked_at(tmp_path: Path) -> None:
    path = str(tmp_path / "pile.recording")
    scene = atoll.load_scene("pile:bodies=30")
    world = scene.build()
    with world.record(path):
        hashes, heights = [world.state_hash()], [world.positions[:, 2].copy()]
        for _ in range(40):
            world.step(scene.dt)
            hashes.append(world.state_hash())
            heights.append(world.positions[:, 2].copy())
    assert not world.is_recording

    assert atoll.is_recording(path)
    result = atoll.replay(path, threads=2)
    assert result.divergence is None and result.steps == 40 and result.hash == hashes[-1]
    playback = atoll.Playback(path)
    for step in (40, 3, 20, 0, 39):
        playback.seek(step)
        assert playback.step == step and playback.state_hash() == hashes[step]
        assert np.array_equal(playback.positions[:, 2], heights[step])
    with pytest.raises(atoll.Error, match="expected one in"):
        playback.seek(41)
    assert atoll.find_first_difference(path, path).difference is None


def test_errors_are_measured() -> None:
    scene = atoll.load_scene("stack:height=4")
    world = scene.build()
    meter = atoll.ErrorMeter(scene)
    for step in range(60):
        world.step(scene.dt)
        meter.observe((step + 1) * scene.dt, world)
    errors = meter.errors()
    assert 0 < errors["penetration_max"] < 5e-3 and not meter.fell()
