"""Error against run time: a double pendulum, with more and more substeps, against one that is far finer."""

import time

import numpy as np

import atoll


def run(substeps: int) -> tuple[np.ndarray, float]:
    world = atoll.World(settings=atoll.Settings(substeps=substeps))
    hook = world.add_body(type=atoll.BodyType.STATIC, shape=atoll.Sphere(0.05))
    last, at = hook, 0.0
    for _ in range(2):
        rod = world.add_body(shape=atoll.Box([0.25, 0.02, 0.02]), position=[at + 0.25, 0, 0])
        world.add_joint(atoll.joint_at(world, atoll.HingeJoint(), last, rod, [at, 0, 0], [0, 1, 0]))
        last, at = rod, at + 0.5
    begin = time.perf_counter()
    world.steps(60, 1 / 60)
    return world.positions[last].copy(), time.perf_counter() - begin


exact, _ = run(1024)
for substeps in (1, 2, 4, 8, 16, 32, 64):
    place, seconds = run(substeps)
    print(f"{substeps:3} substeps: {1e3 * seconds:6.2f} ms for a second, {np.linalg.norm(place - exact):.1e} m off")
