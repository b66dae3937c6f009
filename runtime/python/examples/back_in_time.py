"""Records a run, and goes back in it to where a wall began to fall."""

import tempfile
from pathlib import Path

import atoll

scene = atoll.load_scene("wall:base=8")
world = scene.build()
with tempfile.TemporaryDirectory() as folder:
    path = str(Path(folder) / "wall.recording")
    with world.record(path):
        world.steps(60, scene.dt)
        stones = world.bodies[1:]
        top = max(stones, key=lambda stone: world.positions[stone, 2])
        ball = world.add_body(shape=atoll.Sphere(0.5), position=[0, -8, 2.5], velocity=[0, 25, 0], density=8000)
        world.steps(120, scene.dt)

    replayed = atoll.replay(path, threads=2)
    print(f"replayed {replayed.steps} steps, {'the same bits' if replayed.divergence is None else 'others'}")
    playback = atoll.Playback(path)
    playback.seek(playback.steps)
    while abs(playback.velocities[top.index]).max() > 0.05 and playback.step > 0:
        playback.seek(playback.step - 1)
    print(f"the topmost stone began to move in step {playback.step + 1}, with the ball at {playback.positions[ball]}")
