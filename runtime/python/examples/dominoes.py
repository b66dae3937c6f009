"""A row of dominoes: the first is pushed, and all fall. How fast does the wave run?"""

import numpy as np

import atoll

COUNT, SPACING = 40, 0.022
world = atoll.World(settings=atoll.Settings(substeps=16))
world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
tile = atoll.Box([0.0035, 0.012, 0.024])
material = atoll.Material(friction=0.3)
row = [world.add_body(shape=tile, position=[i * SPACING, 0, 0.024], material=material) for i in range(COUNT)]
world.apply_impulse(row[0], [world.mass(row[0]) * 0.4, 0, 0], [0, 0, 0.046])

fell = np.full(COUNT, np.nan)
for step in range(600):
    world.step(1 / 240)
    spin = world.angular_velocities[[tile.index for tile in row], 1]
    fell[np.isnan(fell) & (spin > 1)] = (step + 1) / 240

middle = slice(10, 30)
speed = np.polyfit(fell[middle], SPACING * np.arange(COUNT)[middle], 1)[0]
print(f"{np.isfinite(fell).sum()} of {COUNT} fell; the wave runs at {speed:.2f} m/s")
