"""Plans as it goes: a pusher brings a crate to a mark by trying 96 random plans at a time in a batch (MPPI)."""

import numpy as np

import atoll

SAMPLES, HORIZON, COUNT = 96, 16, 4  # plans, control steps in each, steps of 1/60 s in each of those
MARK = np.array([0.2, 0.9])

free = atoll.JointAxis(motor=atoll.JointMotor(max_force=80))
locked = atoll.JointAxis(range=atoll.JointRange(0, 0))
planar = atoll.SixDofJoint(offset=(free, free, locked), turn=(locked, locked, locked))
bodies = [
    atoll.BodyDef(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace()),
    atoll.BodyDef(shape=atoll.Box([0.2, 0.2, 0.15]), mass=4, position=[0, 0, 0.15]),
    atoll.BodyDef(shape=atoll.Sphere(0.12), mass=2, position=[-0.6, 0.3, 0.15]),
]
slide = atoll.JointDef(kind=planar, frame_first=atoll.Pose([0, 0, 0.15]))
scene = atoll.Scene(
    bodies=[atoll.SceneBody(definition=body) for body in bodies],
    joints=[atoll.SceneJoint(definition=slide, first=0, second=2)],
)
world, batch = scene.build(), atoll.Batch(scene, SAMPLES)
controls = [atoll.MotorSpeed(0, coordinate=0), atoll.MotorSpeed(0, coordinate=1)]
random = np.random.default_rng(7)
plan = np.zeros((HORIZON, 2))

for decision in range(90):
    tried = np.clip(plan + np.repeat(random.normal(0, 0.5, (SAMPLES, HORIZON // 4, 2)), 4, axis=1), -1, 1)
    tried[0] = plan
    seen = batch.rollout(controls, tried, count=COUNT, start=world.save(), keep=["positions"])["positions"][..., :2]
    away = np.linalg.norm(seen[:, :, 1] - MARK, axis=-1)  # of the crate from its mark
    behind = np.linalg.norm(seen[:, :, 1] - 0.3 * (MARK - seen[:, :, 1]) / away[..., None] - seen[:, :, 2], axis=-1)
    costs = (10 * away + behind).mean(axis=1)
    weights = np.exp((costs.min() - costs) / 0.02)
    plan = (weights[:, None, None] * tried).sum(axis=0) / weights.sum()
    for coordinate, speed in enumerate(plan[0]):
        world.set_motor_speed(world.joints[0], speed, coordinate)
    world.steps(COUNT, scene.dt)
    plan = np.concatenate([plan[1:], plan[-1:]])
    distance = float(np.linalg.norm(world.positions[1, :2] - MARK))
    print(f"{(decision + 1) * COUNT / 60:4.2f} s: {distance:.2f} m to go")
    if distance < 0.03:
        break
print("the crate is there" if distance < 0.03 else "it didn't get there")
