"""A motor turns a crank, a rod moves a slider: the slider's stroke against the closed form."""

import numpy as np

import atoll

R, ROD, SPEED = 0.2, 0.6, 5.0
world = atoll.World(gravity=[0, 0, 0])
frame = world.add_body(type=atoll.BodyType.STATIC, shape=atoll.Sphere(0.05))
crank = world.add_body(shape=atoll.Box([R / 2, 0.02, 0.02]), position=[R / 2, 0, 0])
rod = world.add_body(shape=atoll.Box([ROD / 2, 0.02, 0.02]), position=[R + ROD / 2, 0, 0])
slider = world.add_body(shape=atoll.Box([0.05, 0.05, 0.05]), position=[R + ROD, 0, 0])

drive = atoll.HingeJoint(atoll.JointAxis(motor=atoll.JointMotor(speed=SPEED, max_force=atoll.unlimited)))
motor = world.add_joint(atoll.joint_at(world, drive, frame, crank, [0, 0, 0], [0, 0, 1]))
world.add_joint(atoll.joint_at(world, atoll.HingeJoint(), crank, rod, [R, 0, 0], [0, 0, 1]))
world.add_joint(atoll.joint_at(world, atoll.HingeJoint(), rod, slider, [R + ROD, 0, 0], [0, 0, 1]))
world.add_joint(atoll.joint_at(world, atoll.SliderJoint(), frame, slider, [R + ROD, 0, 0], [1, 0, 0]))

worst = 0.0
for _ in range(240):
    world.step(1 / 120)
    angle = world.joint_state(motor).position[0]
    expected = R * np.cos(angle) + np.sqrt(ROD**2 - (R * np.sin(angle)) ** 2)
    worst = max(worst, abs(world.positions[slider, 0] - expected))
print(f"{angle / (2 * np.pi):.2f} turns in 2 s; the slider is {1e6 * worst:.1f} um off at most")
