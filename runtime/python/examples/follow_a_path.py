"""An arm of four hinges with servos, whose hand draws a circle on a wall. Servos lag behind by damping / stiffness."""

import numpy as np

import atoll

LENGTHS = [0.3, 0.4, 0.4, 0.2]  # m, of the links, which point up at first
DT = 1 / 120

world = atoll.World()
link = world.add_body(type="static", shape=atoll.Box([0.2, 0.2, 0.05]), position=[0, 0, -0.05])
height, servos = 0.0, []
for place, length in enumerate(LENGTHS):
    carrier = link
    shape = atoll.Capsule(radius=0.04, half_height=length / 2 - 0.04)
    link = world.add_body(shape=shape, position=[0, 0, height + length / 2], mass=5 * length)
    motor = atoll.JointMotor(max_force=500, servo=atoll.JointServo(stiffness=20000, damping=400))
    hinge = atoll.HingeJoint(atoll.JointAxis(motor=motor))
    axis = [0, 0, 1] if place == 0 else [0, 1, 0]
    servos.append(world.add_joint(atoll.joint_at(world, hinge, carrier, link, [0, 0, height], axis)))
    height += length
hand = world.add_body(shape=atoll.Sphere(0.03), position=[0, 0, height], mass=0.5)
world.add_joint(atoll.joint_at(world, atoll.FixedJoint(), link, hand, [0, 0, height]))

arm = atoll.Mechanism(world, hand)
arm.set([0, 0.5, 0.8, 0.5], np.zeros(4))  # bent, so that it can go either way
worst = 0.0
for step in range(600):
    angle = np.pi / 2 * step * DT
    target = np.array([0.6, 0.2 * np.sin(angle), 0.6 + 0.2 * np.cos(angle)])
    for servo, q in zip(servos, arm.inverse_kinematics(hand, [0, 0, 0], target).q, strict=True):
        world.set_servo_target(servo, q)
    world.step(DT)
    if step >= 120:  # it has come to the circle by then
        worst = max(worst, float(np.linalg.norm(world.positions[hand] - target)))
lag = 0.2 * np.pi / 2 * 400 / 20000
found = f"{1000 * worst:.1f} mm off, as its servos lag by {1000 * lag:.1f} mm"
print(f"the hand follows within a centimetre: {worst < 0.01}, {found}")
