"""A planet under a force law, called in each substep: how well an orbit closes."""

import numpy as np

import atoll


def gravity(forces: atoll.Forces) -> None:
    away = forces.world.positions[planet]
    forces.add(planet, -away / np.linalg.norm(away) ** 3)


for substeps in (4, 16, 64):
    world = atoll.World(gravity=[0, 0, 0], settings=atoll.Settings(substeps=substeps))
    planet = world.add_body(shape=atoll.Sphere(0.01), mass=1, position=[1, 0, 0], velocity=[0, 1.2, 0])
    axis = 1 / (2 - 1.2**2)
    period = 2 * np.pi * axis**1.5
    for _ in range(500):
        world.step(period / 500, gravity)
    print(f"{substeps:2} substeps: {np.linalg.norm(world.positions[planet] - [1, 0, 0]):.1e} m off after a turn")
