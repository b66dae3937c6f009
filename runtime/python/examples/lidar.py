"""A scanner in a heap of rocks: 3600 rays at once, as a picture of characters."""

import numpy as np

import atoll

scene = atoll.load_scene("rocks:bodies=80")
world = scene.build(threads=2)
world.steps(120, scene.dt)

azimuth = np.linspace(-np.pi, np.pi, 120, endpoint=False)
height = np.linspace(0.35, -0.65, 30)
across, up = np.meshgrid(azimuth, height)
directions = np.stack([np.cos(across), np.sin(across), up], axis=-1).reshape(-1, 3)
origins = np.tile([0.0, 0.0, 4.0], (len(directions), 1))
hits = world.cast_rays(origins, directions, max_distance=12)

shades = np.array(list(" .:-=+*#%@"))
near = np.where(hits["hit"], 1 - hits["distance"] / 12, 0)
for line in shades[(near * 9.99).astype(int)].reshape(across.shape):
    print("".join(line))
print(f"{hits['hit'].sum()} of {len(hits)} rays met {len(np.unique(hits['body']['index'][hits['hit']]))} bodies")
