"""What would happen if? From one saved state a ball is thrown in many ways, and the best one is taken."""

import pickle

import numpy as np

import atoll

world = atoll.World()
world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
target = np.array([6.0, 2.0, 0.5])
ball = world.add_body(shape=atoll.Sphere(0.1), position=[0, 0, 1.5], material=atoll.Material(restitution=0.5))
start = world.save()


def closest(velocity: np.ndarray) -> float:
    world.restore(start)
    world.set_velocity(ball, velocity, [0, 0, 0])
    nearest = np.inf
    for _ in range(90):
        world.step(1 / 60)
        nearest = min(nearest, float(np.linalg.norm(world.positions[ball] - target)))
    return nearest


random = np.random.default_rng(3)
tried = random.uniform([2, 0, 0], [9, 4, 7], (300, 3))
best = min(tried, key=closest)
print(f"{best.round(2)} m/s gets within {100 * closest(best):.1f} cm")

# The same bits after a pickle, in another world.
first = world.state_hash()
world.restore(pickle.loads(pickle.dumps(start)))
assert closest(best) == closest(best) and world.state_hash() == first
