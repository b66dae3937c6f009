"""Rollouts of a batch: the same bits as its other calls one by one."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from numpy.typing import NDArray

import atoll

Array = NDArray[np.float64]
STEPS, COUNT = 5, 3
KEEP = ("positions", "origins", "orientations", "velocities", "angular_velocities", "joint_positions", "joint_speeds")
# A number for the cart's motor, one for the arm's servo, one for a push along x and three for a torque on the crate.
CONTROLS: list[atoll.Control] = [
    atoll.MotorSpeed(0),
    atoll.ServoTarget(1),
    atoll.BodyForce(3, atoll.Axis.X),
    atoll.BodyTorque(3),
]


def arm_and_crate() -> atoll.Scene:
    """A cart on a rail with an arm that hits a crate, which a constant force pushes along y."""
    untouched = atoll.CollisionFilter(mask=0)
    servo = atoll.JointServo(stiffness=200, damping=20)
    cart = atoll.BodyDef(shape=atoll.Box([0.2, 0.1, 0.1]), mass=2, position=[0, 0, 1.2], filter=untouched)
    crate = atoll.BodyDef(shape=atoll.Box([0.15, 0.2, 0.15]), mass=3, position=[0.4, 0, 0.15])
    bodies = [
        atoll.SceneBody(definition=atoll.BodyDef(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())),
        atoll.SceneBody(definition=cart),
        atoll.SceneBody(definition=atoll.BodyDef(shape=atoll.Capsule(0.05, 0.4), mass=1, position=[0, 0, 0.7])),
        atoll.SceneBody(definition=crate, force=[0, 2, 0]),
    ]
    rail = atoll.SliderJoint(atoll.JointAxis(motor=atoll.JointMotor(max_force=500)))
    hinge = atoll.HingeJoint(atoll.JointAxis(motor=atoll.JointMotor(max_force=60, servo=servo)))
    turned = [0, 0, np.sqrt(0.5), np.sqrt(0.5)]
    joints = [
        atoll.SceneJoint(definition=atoll.JointDef(kind=rail, frame_first=atoll.Pose([0, 0, 1.2])), first=0, second=1),
        atoll.SceneJoint(
            definition=atoll.JointDef(
                kind=hinge, frame_first=atoll.Pose([0, 0, -0.1], turned), frame_second=atoll.Pose([0, 0, 0.4], turned)
            ),
            first=1,
            second=2,
        ),
    ]
    return atoll.Scene(name="arm", dt=1 / 120, bodies=bodies, joints=joints)


def random_values(worlds: int) -> Array:
    values = np.random.default_rng(5).uniform(-1, 1, (worlds, STEPS, 6))
    return values * [1.5, 1.2, 40, 3, 3, 3]


def make_step(scene: atoll.Scene, world: atoll.World, now: Array) -> None:
    """A control step, by calls of the world."""
    world.set_motor_speed(world.joints[0], now[0])
    world.set_servo_target(world.joints[1], now[1])
    for _ in range(COUNT):
        world.apply_force(world.bodies[3], [now[2], 0, 0])
        world.apply_force(world.bodies[3], [0, 0, 0], now[3:])
        scene.apply_forces(world)
        world.step(scene.dt)


def one_by_one(batch: atoll.Batch, values: Array) -> dict[str, Array]:
    seen: dict[str, list[Array]] = {name: [] for name in KEEP}
    for step in range(values.shape[1]):
        for world, now in zip(batch, values[:, step], strict=True):
            make_step(batch.scene, world, now)
        for name in KEEP:
            seen[name].append(getattr(batch, name))
    return {name: np.stack(arrays, axis=1) for name, arrays in seen.items()}


@pytest.mark.parametrize(("worlds", "threads"), [(1, 1), (7, 1), (7, 2), (64, 3)])
def test_rollout_is_the_calls_one_by_one(worlds: int, threads: int) -> None:
    values = random_values(64)[:worlds]
    batch = atoll.Batch(arm_and_crate(), worlds, threads=threads)
    expected = one_by_one(batch, values)
    hashes = batch.hashes()
    assert np.ptp(expected["positions"][:, -1, 3, 0]) > 5e-3 or worlds == 1
    batch.reset()
    found = batch.rollout(CONTROLS, values, count=COUNT, keep=KEEP)
    assert list(found) == list(KEEP) and np.array_equal(batch.hashes(), hashes)
    for name in KEEP:
        assert np.array_equal(found[name], expected[name]), name
    # The same on places of others, and in parts.
    batch.reset()
    order = np.random.default_rng(1).permutation(worlds)
    batch.rollout(CONTROLS, values[order, :2], count=COUNT, worlds=order)
    last = batch.rollout(CONTROLS, values[order, 2:], count=COUNT, worlds=order)
    assert list(last) == ["positions", "velocities"]
    assert np.array_equal(last["positions"], expected["positions"][order, 2:])
    assert np.array_equal(batch.hashes(), hashes)


def test_controls_of_all_worlds_are_set_in_one_call() -> None:
    scene = arm_and_crate()
    set_at_once, rolled_out = atoll.Batch(scene, 7), atoll.Batch(scene, 7)
    values = random_values(7)
    for now in np.moveaxis(values, 1, 0):
        set_at_once.set_controls(CONTROLS, now[[2, 5]], worlds=[2, 5])
        set_at_once.set_controls(CONTROLS, now[[0, 1, 3, 4, 6]], worlds=[0, 1, 3, 4, 6])
        set_at_once.step()
    rolled_out.rollout(CONTROLS, values)
    assert np.array_equal(set_at_once.hashes(), rolled_out.hashes())
    before = set_at_once.hashes()
    set_at_once[6].remove_joint(set_at_once.joints[1])
    for controls, words in ((CONTROLS, "without a servo there in world 6"), (CONTROLS[:1], "7 worlds x 1 control")):
        with pytest.raises(atoll.Error, match=words):
            set_at_once.set_controls(controls, values[:, 0])
    assert np.array_equal(set_at_once.hashes()[:6], before[:6])


def test_all_worlds_may_have_the_same_values() -> None:
    values = random_values(1)
    batch = atoll.Batch(arm_and_crate(), 3)
    alike = batch.rollout(CONTROLS, values[0])["positions"]
    assert np.array_equal(alike[0], alike[1]) and np.array_equal(alike[0], alike[2])
    each = batch.rollout(CONTROLS, np.repeat(values, 3, axis=0), start="reset")["positions"]
    assert np.array_equal(alike, each)
    still = batch.rollout([], np.zeros((STEPS, 0)), start="reset", keep=["joint_positions"])
    assert still["joint_positions"].shape == (3, STEPS, 2, 6)
    nothing = batch.rollout(CONTROLS, np.zeros((0, STEPS, 6)), worlds=[])
    assert nothing["velocities"].shape == (0, STEPS, 4, 3)
    assert batch.rollout(CONTROLS, np.zeros((3, 0, 6)))["positions"].shape == (3, 0, 4, 3)
    assert batch.rollout(CONTROLS, values[0].astype(np.float32)[::2])["positions"].shape == (3, 3, 4, 3)


def test_rollouts_start_where_they_are_told() -> None:
    values = random_values(4)
    batch = atoll.Batch(arm_and_crate(), 4, threads=2)
    batch.rollout(CONTROLS, values)
    snapshots = [world.save() for world in batch]
    on = batch.rollout(CONTROLS, values)["positions"]
    from_each = batch.rollout(CONTROLS, values, start=snapshots)["positions"]
    assert np.array_equal(on, from_each)
    from_files = batch.rollout(CONTROLS, values, start=pickle.loads(pickle.dumps(snapshots)))["positions"]
    assert np.array_equal(on, from_files)
    # From the first world's for all: where the first one goes with these values.
    from_first = batch.rollout(CONTROLS, values, start=snapshots[0])["positions"]
    assert np.array_equal(from_first[0], on[0]) and not np.array_equal(from_first[1], on[1])
    alone = atoll.Batch(arm_and_crate(), 1)
    assert np.array_equal(from_first[3:], alone.rollout(CONTROLS, values[3:], start=snapshots[0])["positions"])
    # By reset, from kept starts too, and some worlds alone.
    first = atoll.Batch(arm_and_crate(), 4).rollout(CONTROLS, values)["positions"]
    assert np.array_equal(batch.rollout(CONTROLS, values, start="reset")["positions"], first)
    batch[2].restore(snapshots[2])
    batch.save_start([2])
    hashes = batch.hashes()
    assert np.array_equal(batch.rollout(CONTROLS, values[2:3], start="reset", worlds=[2])["positions"], on[2:3])
    assert list(batch.hashes() == hashes) == [True, True, False, True]


def test_what_is_planned_in_a_batch_happens_in_a_world() -> None:
    scene = arm_and_crate()
    world = scene.build()
    batch = atoll.Batch(scene, 2)
    values = random_values(2)
    plan = batch.rollout(CONTROLS, values, count=COUNT, start=world.save(), keep=["positions"])["positions"][1]
    for step, now in enumerate(values[1]):
        make_step(scene, world, now)
        assert np.array_equal(world.positions, plan[step])
    assert world.state_hash() == batch[1].state_hash()


def test_errors_leave_worlds_as_they_were() -> None:
    batch = atoll.Batch(arm_and_crate(), 3, threads=2)
    values = random_values(3)
    batch.rollout(CONTROLS, values)
    snapshot = batch[0].save()
    other = atoll.Batch("pile:bodies=4", 1)[0].save()
    bad = values.copy()
    bad[2, 4, 3] = np.nan
    far = values.copy()
    far[1, 0, 1] = 2e15
    before = batch.hashes()

    def expect(words: str, controls: list[atoll.Control], values: Array,
               start: atoll.Snapshot | list[atoll.Snapshot] | str | None = None, keep: tuple[str, ...] = ("positions",),
               count: int = 1, dt: float | None = None, worlds: list[int] | None = None) -> None:  # fmt: skip
        with pytest.raises(atoll.Error, match=words):
            batch.rollout(controls, values, start=start, keep=keep, count=count, dt=dt, worlds=worlds)
        assert np.array_equal(batch.hashes(), before)

    expect(r"shape \(3, 5, 6\); expected \(2, steps, 6\), or \(steps, 6\) for all alike", CONTROLS, values, worlds=[0, 1])
    expect(r"shape \(3, 5, 6\); expected \(3, steps, 5\)", CONTROLS[1:], values)
    expect(r"shape \(6\)", CONTROLS, np.zeros(6))
    expect(r"nan at values\[2\]\[4\]\[3\], for controls\[3\], the torque on body 3; expected a finite number", CONTROLS, bad)
    expect(r"nan at values\[4\]\[3\]", CONTROLS, bad[2])
    expect(r"2e\+15 at values\[1\]\[0\]\[1\], for controls\[1\], the target of .* of at most 1e15", CONTROLS, far)
    expect("nan", CONTROLS, bad, start="reset")
    one = np.zeros((2, 1))
    expect(r"controls\[0\], the speed of coordinate 0 of joint 2; expected a joint below 2", [atoll.MotorSpeed(2)], one)
    expect("coordinate 1 of joint 0, without a motor there in world 0", [atoll.MotorSpeed(0, 1)], one)
    expect("coordinate 0 of joint 0, without a servo there in world 0", [atoll.ServoTarget(0)], one, start="reset")
    expect(r"the force on body 4; expected a body below 4", [atoll.BodyForce(4, atoll.Axis.Y)], one)
    expect("the torque on body 0, which isn't dynamic in world 0", [atoll.BodyTorque(0, atoll.Axis.Y)], one, start=snapshot)
    expect("keep has \"speed\"; expected of positions, ", CONTROLS, values, keep=("speed",))
    expect("start is \"kept\"; expected \"reset\"", CONTROLS, values, start="kept")
    expect("empty list", CONTROLS, values, start=[])
    expect("found 2 snapshots to start at; expected one for all, or 3", CONTROLS, values, start=[snapshot, snapshot])
    expect("snapshot is empty", CONTROLS, values, start=[snapshot, snapshot, atoll.Snapshot()])
    expect("World::restore", CONTROLS, values, start=[snapshot, snapshot, other])
    expect("count of 0", CONTROLS, values, count=0)
    expect("dt of 2", CONTROLS, values, dt=2)
    expect("Batch: found place 3", CONTROLS, values[:1], worlds=[3])
    batch[1].remove_body(batch.bodies[2])
    before = batch.hashes()
    expect("joint 1, without a servo there in world 1", CONTROLS, values)
    expect("coordinate 5 of joint 0, without a motor there in world 0", [atoll.MotorSpeed(0, 5)], one, start=snapshot)
    batch[2].remove_body(batch.bodies[3])
    before = batch.hashes()
    expect("the force on body 3, which was removed in world 2", [CONTROLS[2]], one)
    expect("body 3, which the scene pushes, removed in world 2", [CONTROLS[0]], one)
    batch.rollout(CONTROLS, values, start="reset")  # which brings all of it back


def test_controls_are_values() -> None:
    assert pickle.loads(pickle.dumps(atoll.BodyForce(3, atoll.Axis.Y))).axis == atoll.Axis.Y
    assert repr(CONTROLS[2]) == "BodyForce(body=3, axis=Axis.X)"
