#!/usr/bin/env python3
"""How fast Atoll and other engines with Python packages run the same scenes, and how large their errors are.

    pip install . mujoco pybullet rapier3d
    python perf/python_peers.py

prints a Markdown table. Engines that can't be imported are left out. mjbatch is measured too where it is installed: it
pins a version of mujoco, so it needs an environment of its own. Only steps are timed, not building or starting over.
Every engine takes four substeps a step, without sleeping, and without damping of bodies and joints. Atoll is measured
at others' errors, too: its pile with 16 substeps, stacks and carts with one.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import atoll
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FRICTION = 0.6
GRAVITY = 9.81  # m/s^2
DENSITY = 1000.0  # kg/m^3
SUBSTEPS = 4  # the default of Atoll and of Rapier
BOXES_DT = 1 / 60  # s, of piles and stacks
CART_DT = 0.02  # s
CART_HALF, CART_MASS = np.array([0.2, 0.1, 0.1]), 1.0  # half extents (m), kg
POLE_HALF, POLE_MASS = np.array([0.02, 0.02, 0.5]), 0.1
START_ANGLE = 0.05  # rad, of the pole
POLE_START = POLE_HALF[2] * np.array([np.sin(START_ANGLE), 0, np.cos(START_ANGLE)])  # its centre; its foot is at 0
ROLLOUT_WORLDS = 64  # worlds a call of mujoco.rollout, which writes all states: 0.9 GB for 1024 stacks


def engine(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        print(f"python_peers: leaves out {name}: {error}", file=sys.stderr)


os.environ.setdefault("RAYON_NUM_THREADS", "1")  # of Rapier's global pool, which is made once
pybullet, mujoco, mjbatch, rapier = map(engine, ("pybullet", "mujoco", "mjbatch", "rapier3d"))
rollout = mujoco and engine("mujoco.rollout")


@dataclass
class Boxes:
    """Equal boxes and static walls on the ground z = 0."""

    half: float
    centres: Array
    walls: list[tuple[Array, Array]]  # centre and half extents, m


@dataclass
class Task:
    """So many equal worlds with boxes, or, without, with cart-poles under different forces. Only `steps` are timed."""

    worlds: int
    steps_before: int
    steps: int
    boxes: Boxes


# Result of a run: the seconds that its timed steps took, and the final state. Boxes give one row each of the first
# world, position and orientation (x, y, z, w); cart-poles give the pole's angle in each world.
Run = tuple[float, Array]
Runner = Callable[[Task, int], Run]  # the integer is the number of threads


def pile(count: int) -> Boxes:
    spacing = 0.6
    side = int(np.ceil(np.cbrt(count) - 1e-9))
    layer, place = np.divmod(np.arange(count), side**2)
    x = spacing * (place % side - (side - 1) / 2) + 0.07 * (layer % 3 - 1)
    y = spacing * (place // side - (side - 1) / 2) + 0.05 * (2 * layer % 5 - 2)
    inner, thick, high = spacing * side / 2 + 0.25, 0.5, spacing * (layer[-1] + 1) / 2 + 0.5
    walls = []
    for sign in (-1, 1):
        walls.append((np.array([sign * (inner + thick), 0, high]), np.array([thick, inner + 2 * thick, high])))
        walls.append((np.array([0, sign * (inner + thick), high]), np.array([inner, thick, high])))
    return Boxes(0.25, np.stack([x, y, 0.35 + spacing * layer], axis=1), walls)


def cart_forces(worlds: int) -> Array:
    return np.linspace(-1, 1, worlds)  # N, of each world


def overlaps(task: Task, end: Array) -> str:
    """By Atoll's audit, which shares no code with its simulation."""
    scene = atoll_scene(task.boxes)
    world, meter = scene.build(), atoll.ErrorMeter(scene)
    turns = end[:, 3:] / np.linalg.norm(end[:, 3:], axis=1, keepdims=True)
    world.set_poses(end[:, :3].copy(), turns, bodies=world.bodies[-len(end) :])
    meter.observe(0, world)
    errors = meter.errors()
    return f"overlap max {1e3 * errors['penetration_max']:.2f} mm, mean {1e3 * errors['penetration_mean']:.3f} mm"


def sinking(task: Task, end: Array) -> str:
    sinks = task.boxes.centres[:, 2] - end[:, 2]
    stands = max(np.abs(sinks).max(), np.linalg.norm(end[:, :2], axis=1).max()) < task.boxes.half
    return f"sinks {1e3 * sinks.max():.3g} mm, {'stands' if stands else 'FELL'}"


@functools.cache
def exact_angles(worlds: int, steps: int) -> Array:
    """By the equations of Barto, Sutton and Anderson (1983), without friction, and with the pole's inertia as a box."""
    force = cart_forces(worlds)
    total, half = CART_MASS + POLE_MASS, POLE_HALF[2]
    inertia = (POLE_HALF[0] ** 2 + half**2) / 3 + half**2  # about the hinge, of 1 kg

    def slope(state: Array) -> Array:
        angle, rate = state
        push = (force + POLE_MASS * half * rate**2 * np.sin(angle)) / total
        turns = half * (GRAVITY * np.sin(angle) - np.cos(angle) * push)
        return np.stack([rate, turns / (inertia - POLE_MASS * (half * np.cos(angle)) ** 2 / total)])

    state = np.stack([np.full(worlds, START_ANGLE), np.zeros(worlds)])
    h = CART_DT / 200  # of the midpoint method: the error is below 1e-6 rad
    for _ in range(200 * steps):
        state = state + h * slope(state + h / 2 * slope(state))
    return state[0]


def angle_error(task: Task, end: Array) -> str:
    return f"angle off by {1e3 * np.abs(end - exact_angles(task.worlds, task.steps)).max():.3f} mrad"


def repeat(step: Callable[[], object], count: int) -> float:
    """Seconds."""
    begin = time.perf_counter()
    for _ in range(count):
        step()
    return time.perf_counter() - begin


# Atoll: default settings
def atoll_scene(boxes: Boxes) -> atoll.Scene:
    material, static = atoll.Material(friction=FRICTION), atoll.BodyType.STATIC
    bodies = [atoll.BodyDef(type=static, shape=atoll.HalfSpace(), material=material)]
    for centre, half in boxes.walls:
        bodies.append(atoll.BodyDef(type=static, shape=atoll.Box(half), position=centre, material=material))
    for centre in boxes.centres:
        cube = atoll.Box([boxes.half] * 3)
        bodies.append(atoll.BodyDef(shape=cube, position=centre, density=DENSITY, material=material))
    return atoll.Scene(bodies=[atoll.SceneBody(definition=b) for b in bodies], gravity=[0, 0, -GRAVITY], dt=BOXES_DT)


def with_substeps(scene: atoll.Scene, substeps: int) -> atoll.Scene:
    settings = scene.settings
    settings.substeps = substeps
    scene.settings = settings
    return scene


def atoll_pile(task: Task, threads: int, substeps: int = SUBSTEPS) -> Run:
    world = with_substeps(atoll_scene(task.boxes), substeps).build(threads=threads)
    world.steps(task.steps_before, BOXES_DT)
    seconds = repeat(lambda: world.steps(task.steps, BOXES_DT), 1)
    return seconds, np.concatenate([world.origins, world.orientations], axis=1)[-len(task.boxes.centres) :]


def atoll_stack(task: Task, threads: int, substeps: int = SUBSTEPS) -> Run:
    batch = atoll.Batch(with_substeps(atoll_scene(task.boxes), substeps), task.worlds, threads=threads)
    seconds = repeat(lambda: batch.step(count=task.steps), 1)
    return seconds, np.concatenate([batch.origins[0], batch.orientations[0]], axis=1)[-len(task.boxes.centres) :]


def atoll_carts(task: Task, threads: int, substeps: int = SUBSTEPS) -> Run:
    """The scene of atoll.gym.CartPole, which needs gymnasium."""
    apart = atoll.CollisionFilter(mask=0)
    start = {"position": POLE_START, "orientation": [0, np.sin(START_ANGLE / 2), 0, np.cos(START_ANGLE / 2)]}
    rail = atoll.BodyDef(type=atoll.BodyType.STATIC, shape=atoll.Sphere(0.05), filter=apart)
    cart = atoll.BodyDef(shape=atoll.Box(CART_HALF), mass=CART_MASS, filter=apart)
    pole = atoll.BodyDef(shape=atoll.Box(POLE_HALF), mass=POLE_MASS, filter=apart, **start)
    turned = [0, 0, np.sqrt(0.5), np.sqrt(0.5)]  # takes the hinge's axis from x to y
    top, foot = atoll.Pose(orientation=turned), atoll.Pose([0, 0, -POLE_HALF[2]], turned)
    slider = atoll.JointDef(kind=atoll.SliderJoint())
    hinge = atoll.JointDef(kind=atoll.HingeJoint(), frame_first=top, frame_second=foot)
    joints = [atoll.SceneJoint(definition=joint, first=i, second=i + 1) for i, joint in enumerate((slider, hinge))]
    bodies = [atoll.SceneBody(definition=body) for body in (rail, cart, pole)]
    scene = atoll.Scene(gravity=[0, 0, -GRAVITY], dt=CART_DT, bodies=bodies, joints=joints)
    batch = atoll.Batch(with_substeps(scene, substeps), task.worlds, threads=threads)
    pushes = [atoll.BodyForce(1, axis=atoll.Axis.X)]
    forces = cart_forces(task.worlds)[:, None, None]  # one control step
    seconds = repeat(lambda: batch.rollout(pushes, forces, count=task.steps, dt=CART_DT), 1)
    return seconds, batch.read_joint(1)[0]


# MuJoCo: the integrator implicitfast, which its documentation recommends; else its defaults (Newton's method, pyramidal
# friction cones, soft contacts). It has no substeps, so its time step is a quarter of the others' steps. All steps of a
# world are one call, so Python costs next to nothing. Worlds run one by one, by mujoco.rollout or by mjbatch.
def mujoco_model(dt: float, world: str, actuators: str = "") -> Any:
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
        <size memory="1G"/> <option timestep="{dt / SUBSTEPS}" gravity="0 0 {-GRAVITY}" integrator="implicitfast"/>
        <default><geom friction="{FRICTION} 0.005 0.0001" density="{DENSITY}"/></default>
        <worldbody>{world}</worldbody> <actuator>{actuators}</actuator>
    </mujoco>""")


def mujoco_one_by_one(model: Any, qpos: Array, control: Array, task: Task, threads: int) -> Run:
    data = mujoco.MjData(model)  # reset for each world
    seconds, ends = 0.0, np.zeros_like(qpos)
    for world in range(task.worlds):
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.ctrl[:] = qpos[world], control[world]
        mujoco.mj_step(model, data, nstep=SUBSTEPS * task.steps_before)
        seconds += repeat(lambda: mujoco.mj_step(model, data, nstep=SUBSTEPS * task.steps), 1)
        ends[world] = data.qpos
    return seconds, ends


def mujoco_rolled_out(model: Any, qpos: Array, control: Array, task: Task, threads: int) -> Run:
    data = [mujoco.MjData(model) for _ in range(threads)]
    starts = np.zeros((task.worlds, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS.value)))
    places = slice(1, 1 + model.nq)  # a state is the time, qpos, and the rest, which is 0 here
    starts[:, places] = qpos
    seconds, ends = 0.0, np.zeros_like(qpos)
    with rollout.Rollout(nthread=threads) as pool:
        for first in range(0, task.worlds, ROLLOUT_WORLDS):
            some = slice(first, first + ROLLOUT_WORLDS)
            states = np.ones((len(starts[some]), SUBSTEPS * task.steps, starts.shape[1]))
            given = {"control": control[some, None, :], "nstep": SUBSTEPS * task.steps, "state": states}
            seconds += repeat(lambda: pool.rollout(model, data, starts[some], **given), 1)
            ends[some] = states[:, -1, places]
    return seconds, ends


def mujoco_batched(model: Any, qpos: Array, control: Array, task: Task, threads: int) -> Run:
    batch = mjbatch.Batch(model, task.worlds, num_threads=threads)
    positions = batch.bind("qpos")
    positions[:], batch.bind("ctrl")[:] = qpos, control
    return repeat(lambda: batch.step(nstep=SUBSTEPS * task.steps), 1), np.array(positions)


def mujoco_boxes(way: Callable[..., Run], task: Task, threads: int) -> Run:
    parts = ['<geom type="plane" size="0 0 1"/>']
    for (x, y, z), (a, b, c) in task.boxes.walls:
        parts.append(f'<geom type="box" pos="{x} {y} {z}" size="{a} {b} {c}"/>')
    box = f'<freejoint/><geom type="box" size="{task.boxes.half} {task.boxes.half} {task.boxes.half}"/>'
    parts += [f'<body pos="{x} {y} {z}">{box}</body>' for x, y, z in task.boxes.centres]
    model = mujoco_model(BOXES_DT, "".join(parts))
    seconds, ends = way(model, np.tile(model.qpos0, (task.worlds, 1)), np.zeros((task.worlds, 0)), task, threads)
    return seconds, ends[0].reshape(-1, 7)[:, [0, 1, 2, 4, 5, 6, 3]]  # it has w first


def mujoco_carts(way: Callable[..., Run], task: Task, threads: int) -> Run:
    # No collisions: contype and conaffinity are 0. The pole's angle is 0 where it stands upright.
    apart = 'type="box" contype="0" conaffinity="0"'
    world = f"""<body><joint name="rail" type="slide" axis="1 0 0"/>
        <geom {apart} size="0.2 0.1 0.1" mass="{CART_MASS}"/>
        <body><joint type="hinge" axis="0 1 0"/><geom {apart} pos="0 0 0.5" size="0.02 0.02 0.5" mass="{POLE_MASS}"/>
        </body></body>"""
    model = mujoco_model(CART_DT, world, '<motor joint="rail"/>')
    qpos, control = np.tile([0, START_ANGLE], (task.worlds, 1)), cart_forces(task.worlds)[:, None]
    seconds, ends = way(model, qpos, control, task, threads)
    return seconds, ends[:, 1]


# PyBullet: its default time step of 1/240 s four times a step (for carts 0.005 s), and its default 50 iterations. Boxes
# have maximal coordinates, as in its own example of many bodies, createMultiBodyBatch.py; reduced ones are slower.
def bullet_start(dt: float) -> Any:
    if not pybullet.isConnected():
        pybullet.connect(pybullet.DIRECT)
    pybullet.resetSimulation()
    pybullet.setGravity(0, 0, -GRAVITY)
    pybullet.setTimeStep(dt / SUBSTEPS)
    return pybullet


def bullet_boxes(task: Task, threads: int) -> Run:
    p, boxes = bullet_start(BOXES_DT), task.boxes
    bodies = [p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))]
    for centre, half in boxes.walls:
        bodies.append(p.createMultiBody(0, p.createCollisionShape(p.GEOM_BOX, halfExtents=half), basePosition=centre))
    box, mass = p.createCollisionShape(p.GEOM_BOX, halfExtents=[boxes.half] * 3), DENSITY * (2 * boxes.half) ** 3
    for centre in boxes.centres:
        bodies.append(p.createMultiBody(mass, box, basePosition=centre, useMaximalCoordinates=True))
    for body in bodies:  # the friction between two bodies is the product of theirs
        p.changeDynamics(body, -1, lateralFriction=np.sqrt(FRICTION), linearDamping=0, angularDamping=0)
    start, seconds, ends = p.saveState(), 0.0, []
    for _ in range(task.worlds):
        p.restoreState(start)
        repeat(p.stepSimulation, SUBSTEPS * task.steps_before)
        seconds += repeat(p.stepSimulation, SUBSTEPS * task.steps)
        ends = ends or [p.getBasePositionAndOrientation(body) for body in bodies[-len(boxes.centres) :]]
    return seconds, np.array([np.concatenate(end) for end in ends])


def bullet_carts(task: Task, threads: int) -> Run:
    p = bullet_start(CART_DT)
    level, halves = [0, 0, 0, 1], (CART_HALF, POLE_HALF)
    shapes = [p.createCollisionShape(p.GEOM_BOX, halfExtents=half) for half in halves]
    body = p.createMultiBody(  # its base, 0 among the parents, is static
        linkMasses=[CART_MASS, POLE_MASS], linkCollisionShapeIndices=shapes, linkVisualShapeIndices=[-1, -1],
        linkPositions=[[0, 0, 0]] * 2, linkOrientations=[level] * 2, linkParentIndices=[0, 1],
        linkInertialFramePositions=[[0, 0, 0], [0, 0, POLE_HALF[2]]], linkInertialFrameOrientations=[level] * 2,
        linkJointTypes=[p.JOINT_PRISMATIC, p.JOINT_REVOLUTE], linkJointAxis=[[1, 0, 0], [0, 1, 0]],
    )
    for link, half, mass in ((0, CART_HALF, CART_MASS), (1, POLE_HALF, POLE_MASS)):
        p.setCollisionFilterGroupMask(body, link, 0, 0)
        inertia = mass / 3 * (np.sum(half**2) - half**2)
        p.changeDynamics(body, link, localInertiaDiagonal=inertia, linearDamping=0, angularDamping=0, jointDamping=0)
        p.setJointMotorControl2(body, link, p.VELOCITY_CONTROL, force=0)  # joints have a motor that brakes by default

    def step(force: float) -> None:
        p.setJointMotorControl2(body, 0, p.TORQUE_CONTROL, force=force)  # holds for one of its steps
        p.stepSimulation()

    seconds, angles = 0.0, []
    for force in cart_forces(task.worlds):
        p.resetJointState(body, 0, 0, 0)
        p.resetJointState(body, 1, START_ANGLE, 0)
        seconds += repeat(functools.partial(step, force), SUBSTEPS * task.steps)
        angles.append(p.getJointState(body, 1)[0])
    return seconds, np.array(angles)


# Rapier: default settings, in single precision; its four solver iterations are substeps. Joints are its impulse joints.
# One thread is that of its global pool: a step of a small world in a pool of its own takes three times as long, because
# it is handed to another thread. Worlds one by one are restored from a snapshot of the start.
def rapier_world(dt: float) -> Any:
    world = rapier.PhysicsWorld(gravity=(0, 0, -GRAVITY))
    world.integration_parameters.dt = dt
    world.integration_parameters.num_solver_iterations = SUBSTEPS
    return world


def rapier_boxes(task: Task, threads: int) -> Run:
    world, boxes = rapier_world(BOXES_DT), task.boxes
    world.add_collider(rapier.Collider.halfspace((0, 0, 1)).friction(FRICTION))
    for centre, half in boxes.walls:
        world.add_collider(rapier.Collider.cuboid(*half).translation(centre).friction(FRICTION))
    handles = []
    for centre in boxes.centres:
        box = rapier.Collider.cuboid(boxes.half, boxes.half, boxes.half).friction(FRICTION).density(DENSITY)
        handles.append(world.add_body(rapier.RigidBody.dynamic().translation(centre).can_sleep(False), [box]))
    start, seconds = world.snapshot(), 0.0
    for _ in range(task.worlds):
        world = rapier.PhysicsWorld.restore(start)
        if threads > 1:
            world.set_num_threads(threads)
        repeat(world.step, task.steps_before)
        seconds += repeat(world.step, task.steps)
    poses = [(world.rigid_bodies[handle].translation, world.rigid_bodies[handle].rotation) for handle in handles]
    return seconds, np.array([[at.x, at.y, at.z, turn.i, turn.j, turn.k, turn.w] for at, turn in poses])


def rapier_carts(task: Task, threads: int) -> Run:
    world = rapier_world(CART_DT)
    bodies = [rapier.RigidBody.fixed()]
    for mass, half in ((CART_MASS, CART_HALF), (POLE_MASS, POLE_HALF)):  # without colliders, so without collisions
        mass_of = rapier.MassProperties(mass=mass, principal_inertia=mass / 3 * (np.sum(half**2) - half**2))
        bodies.append(rapier.RigidBody.dynamic().can_sleep(False).additional_mass_properties(mass_of))
    bodies[2] = bodies[2].translation(POLE_START).rotation((0, START_ANGLE, 0))
    rail, cart, pole = map(world.add_body, bodies)
    foot = (0, 0, -POLE_HALF[2])
    world.impulse_joints.insert(rail, cart, rapier.PrismaticJoint.builder((1, 0, 0)).build())
    world.impulse_joints.insert(cart, pole, rapier.RevoluteJoint.builder((0, 1, 0)).local_anchor2(foot).build())
    start, seconds, angles = world.snapshot(), 0.0, []
    for force in cart_forces(task.worlds):
        world = rapier.PhysicsWorld.restore(start)
        world.rigid_bodies[cart].add_force((force, 0, 0))  # stays until it is reset
        seconds += repeat(world.step, task.steps)
        turn = world.rigid_bodies[pole].rotation
        angles.append(2 * np.arctan2(turn.j, turn.w))
    return seconds, np.array(angles)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--boxes", type=int, default=1000, help="in the pile")
    add("--stacks", type=int, default=1024, help="worlds")
    add("--carts", type=int, default=4096, help="worlds")
    add("--steps-scale", type=float, default=1, help="times the steps of all scenes")
    add("--repeats", type=int, default=5, help="runs, of which the median rate is told")
    add("--only", nargs="+", metavar="ENGINE", help="as the table names them")
    given = parser.parse_args()
    before, pile_steps, stack_steps, cart_steps = (max(1, round(given.steps_scale * n)) for n in (100, 200, 100, 50))
    stack = Boxes(0.5, np.array([[0, 0, i + 0.5] for i in range(20)]), [])
    scenes: dict[str, tuple[Task, Callable[[Task, Array], str]]] = {
        "pile": (Task(1, before, pile_steps, pile(given.boxes)), overlaps),
        "stack": (Task(given.stacks, 0, stack_steps, stack), sinking),
        "cart-pole": (Task(given.carts, 0, cart_steps, Boxes(0, np.zeros((0, 3)), [])), angle_error),
    }
    part, one, rolled, batched = functools.partial, mujoco_one_by_one, mujoco_rolled_out, mujoco_batched
    # Name and module; threads and runner of the pile; threads and runners of stacks and carts.
    engines: list[tuple[str, Any, tuple[int, ...], Any, tuple[int, ...], Runner, Runner]] = [
        ("atoll", atoll, (1, 2), atoll_pile, (1, 2), atoll_stack, atoll_carts),
        ("atoll, 16 substeps", atoll, (1, 2), part(atoll_pile, substeps=16), (), atoll_stack, atoll_carts),
        ("atoll, 1 substep", atoll, (), None, (1, 2), part(atoll_stack, substeps=1), part(atoll_carts, substeps=1)),
        ("mujoco", mujoco, (1,), part(mujoco_boxes, one), (1,), part(mujoco_boxes, one), part(mujoco_carts, one)),
        ("mujoco-rollout", rollout, (), None, (1, 2), part(mujoco_boxes, rolled), part(mujoco_carts, rolled)),
        ("mjbatch", mjbatch, (), None, (1, 2), part(mujoco_boxes, batched), part(mujoco_carts, batched)),
        ("pybullet", pybullet, (1,), bullet_boxes, (1,), bullet_boxes, bullet_carts),
        ("rapier", rapier, (1, 2), rapier_boxes, (1,), rapier_boxes, rapier_carts),
    ]
    rows: dict[str, list[tuple[str, int, Any]]] = {scene: [] for scene in scenes}
    for name, module, pile_threads, run_pile, threads, run_stack, run_carts in engines:
        if module and (not given.only or name in given.only):
            rows["pile"] += [(name, number, run_pile) for number in pile_threads]
            rows["stack"] += [(name, number, run_stack) for number in threads]
            rows["cart-pole"] += [(name, number, run_carts) for number in threads]
    print("| scene | engine | threads | world steps/s | error |\n|---|---|---:|---:|---|")
    for scene, (task, error) in scenes.items():
        # Interleaved, so that noise of the machine hits all engines alike.
        repeats = [[run(task, number) for _, number, run in rows[scene]] for _ in range(given.repeats)]
        for (name, number, _), runs in zip(rows[scene], zip(*repeats, strict=True), strict=True):
            rate = task.worlds * task.steps / statistics.median(seconds for seconds, _ in runs)
            print(f"| {scene} | {name} | {number} | {rate:,.1f} | {error(task, runs[-1][1])} |", flush=True)


main()
