"""Worlds: what is asked and told, and how errors are."""

from __future__ import annotations

import contextlib
import copy
import math
import pickle
import threading
from collections.abc import Callable

import numpy as np
import pytest

import atoll

from conftest import DT


def test_what_falls_falls_as_it_should() -> None:
    world = atoll.World(gravity=[0, 0, -10])
    ball = world.add_body(shape=atoll.Sphere(0.1), position=[1, 2, 50], velocity=[3, 0, 0])
    for _ in range(60):
        world.step(DT)
    # Exact for constant acceleration but for rounding.
    assert world.positions[ball] == pytest.approx([1 + 3, 2, 50 - 5], abs=1e-6)
    assert world.velocity(ball) == pytest.approx([3, 0, -10], abs=1e-5)


def test_definitions_have_the_defaults_of_cpp() -> None:
    body = atoll.BodyDef()
    assert body.type == atoll.BodyType.DYNAMIC
    assert body.density == 1000 and body.mass is None
    assert body.material.friction == 0.6
    assert list(body.orientation) == [0, 0, 0, 1]
    assert atoll.Settings().substeps == 4
    assert [atoll.WheelCoordinate.SUSPENSION, atoll.WheelCoordinate.SPIN] == [0, 2], "as JointState numbers them"
    spring = atoll.WheelJoint().suspension.spring
    assert spring is not None and spring.hertz == 2


def test_parts_of_definitions_are_copies_that_live_on() -> None:
    body = atoll.BodyDef(shape=atoll.Box([1, 2, 3]))
    box, material = body.shape, body.material
    body.shape = atoll.Sphere(9)
    material.friction = 0.1
    assert isinstance(box, atoll.Box) and list(box.half_extents) == [1, 2, 3]
    assert body.material.friction == 0.6
    scene = atoll.load_scene("pile:bodies=3")
    bodies = scene.bodies
    scene.bodies = []
    assert len(bodies) > 3 and bodies[0].definition.density == 1000


def test_smooth_solids_go_around() -> None:
    shapes: list[atoll.Ellipsoid | atoll.TaperedCapsule] = [
        atoll.Ellipsoid([0.1, 0.2, 0.3]),
        atoll.TaperedCapsule([0.3, 0.2], 0.4),
    ]
    world = atoll.World()
    world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
    for i, shape in enumerate(shapes):
        world.add_body(shape=shape, position=[2 * i, 0, 1])
    taken = [body.definition.shape for body in atoll.scene_of(world).bodies[1:]]
    assert isinstance(taken[0], atoll.Ellipsoid) and list(taken[0].half_axes) == [0.1, 0.2, 0.3]
    assert isinstance(taken[1], atoll.TaperedCapsule) and list(taken[1].radii) == [0.3, 0.2]
    assert taken[1].half_height == 0.4
    assert atoll.mass_properties(shapes[0]).volume == pytest.approx(4 / 3 * math.pi * 0.006)
    for shape in shapes:
        assert repr(pickle.loads(pickle.dumps(shape))) == repr(shape) == repr(copy.deepcopy(shape))
    with pytest.raises(atoll.Error, match="TaperedCapsule.half_height is 0.04"):
        world.add_body(shape=atoll.TaperedCapsule([0.3, 0.2], 0.04))


def test_bodies_are_added_by_definition_or_by_name_of_field() -> None:
    first, second = atoll.World(), atoll.World()
    first.add_body(atoll.BodyDef(shape=atoll.Capsule(0.2, 0.4), position=(0, 0, 1), mass=3))
    second.add_body(shape=atoll.Capsule(0.2, 0.4), position=np.array([0, 0, 1]), mass=3)
    assert first.state_hash() == second.state_hash()


@pytest.mark.parametrize(
    "call",
    [
        (lambda: atoll.World().add_body(density=-1), "BodyDef.density is -1"),
        (lambda: atoll.World(threads=0), "threads is 0"),
        (lambda: atoll.World().step(0), "dt"),
        (lambda: atoll.World().pose(atoll.BodyId(3)), "index 3"),
        (lambda: atoll.World(settings=atoll.Settings(substeps=0)), "substeps is 0"),
        (lambda: atoll.ConvexHull(np.zeros((3, 3))), "points"),
        (lambda: atoll.load_scene("no-such-scene"), "no-such-scene"),
        (lambda: atoll.World().contact_events(), "contact_events"),
        (lambda: atoll.World().cast_ray([0, 0, 0], [0, 0, 0]), "direction"),
        (lambda: atoll.World().cast_rays(np.zeros((2, 3)), np.ones((3, 3))), "2 origins and 3 directions"),
    ],
)
def test_errors_name_the_field_and_the_value(call: tuple[Callable[[], object], str]) -> None:
    make, words = call
    with pytest.raises(atoll.Error, match=words):
        make()


def test_what_is_no_vector_is_a_type_error() -> None:
    for wrong in ([1, 2], [1, 2, 3, 4], "abc", [1, 2, "x"], 3, None):
        with pytest.raises(TypeError):
            atoll.World().add_body(position=wrong)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        atoll.World().add_body(positon=[0, 0, 0])  # type: ignore[call-overload]


def test_scene_errors_are_errors_and_value_errors() -> None:
    assert issubclass(atoll.SceneError, atoll.Error) and issubclass(atoll.Error, ValueError)
    with pytest.raises(atoll.SceneError):
        atoll.parse_scene("{")


def test_reprs_say_what_is_not_as_usual(world: atoll.World) -> None:
    assert repr(atoll.Sphere(2)) == "Sphere(radius=2.0)"
    assert repr(atoll.Material()) == "Material()"
    assert repr(world) == "<World of 2 bodies, 0 joints>"
    assert "contacts" in repr(world.step(DT))
    assert repr(world.bodies[1]) == "BodyId(1, 0)"


def test_definitions_and_snapshots_are_pickled(world: atoll.World) -> None:
    body = world.definition(world.bodies[1])
    for copied in (pickle.loads(pickle.dumps(body)), copy.deepcopy(body)):
        assert repr(copied) == repr(body)
    joint = atoll.JointDef(kind=atoll.HingeJoint(atoll.JointAxis(motor=atoll.JointMotor(speed=2, max_force=5))))
    assert repr(pickle.loads(pickle.dumps(joint))) == repr(joint)
    assert pickle.loads(pickle.dumps(atoll.FixedJoint())) is not None
    settings = atoll.Settings(substeps=7, contact_hertz=20)
    assert repr(pickle.loads(pickle.dumps(settings))) == repr(settings)
    settings.contact_hertz = None
    settings.target = atoll.ErrorTarget(penetration=1e-3, motion=0.5, max_substeps=9)
    assert "target=ErrorTarget(penetration=0.001, motion=0.5, max_substeps=9)" in repr(settings)
    for copied_settings in (pickle.loads(pickle.dumps(settings)), copy.deepcopy(settings), copy.copy(settings)):
        assert repr(copied_settings) == repr(settings)

    before = world.save()
    world.steps(20, DT)
    after = world.state_hash()
    world.restore(pickle.loads(pickle.dumps(before)))
    world.steps(20, DT)
    assert world.state_hash() == after
    with pytest.raises(atoll.Error, match="damaged|expected"):
        damaged = bytearray(before.__getstate__())
        damaged[-1] ^= 1
        atoll.Snapshot.__new__(atoll.Snapshot).__setstate__(bytes(damaged))


def refused_while_it_steps(world: atoll.World, count: int) -> int:
    """Asks a world that another thread steps until it has been told so many times that it can't now."""
    refused = 0
    enough = threading.Event()

    def step() -> None:
        while not enough.is_set():
            with contextlib.suppress(atoll.Error):  # it was asked as the step began
                world.step(DT)

    thread = threading.Thread(target=step)
    thread.start()
    try:
        for _ in range(10_000_000):
            try:
                world.state_hash()
            except atoll.Error as error:
                assert "step" in str(error)
                refused += 1
                if refused == count:
                    break
    finally:
        enough.set()
        thread.join()
    return refused


def test_a_step_lets_other_threads_of_python_run() -> None:
    assert refused_while_it_steps(atoll.load_scene("pile:bodies=400").build(), 1000) == 1000


def test_two_threads_in_one_world_are_told() -> None:
    world = atoll.load_scene("pile:bodies=400").build()
    assert refused_while_it_steps(world, 1) == 1
    world.step(DT)


def test_joints_hold_and_tell() -> None:
    world = atoll.World()
    post = world.add_body(type=atoll.BodyType.STATIC, shape=atoll.Sphere(0.1))
    arm = world.add_body(shape=atoll.Box([0.5, 0.05, 0.05]), position=[0.5, 0, 0], mass=2)
    motor = atoll.JointMotor(speed=1.5, max_force=atoll.unlimited)
    hinge = world.add_joint(
        atoll.joint_at(world, atoll.HingeJoint(atoll.JointAxis(motor=motor)), post, arm, [0, 0, 0], [0, 0, 1])
    )
    world.steps(60, DT)
    state = world.joint_state(hinge)
    assert state.position[0] == pytest.approx(1.5, rel=1e-3)
    assert state.force[2] == pytest.approx(2 * 9.81, rel=1e-2)
    assert hinge in world and world.joints == [hinge]
    world.set_motor_speed(hinge, -1)
    world.steps(60, DT)
    assert world.joint_state(hinge).speed[0] == pytest.approx(-1, rel=1e-3)
    definition = world.joint(hinge)
    definition.break_force = 1
    world.set_joint(hinge, definition)
    world.set_name(hinge, "elbow")
    world.set_user_data(hinge, 5)
    assert (world.name(hinge), world.user_data(hinge)) == ("elbow", 5) and world.find_joint("elbow") == hinge
    world.step(DT)
    assert world.joint_state(hinge).broken
    world.remove_joint(hinge)
    assert hinge not in world


def test_settings_and_gravity_are_set_as_a_whole(world: atoll.World) -> None:
    settings = world.settings
    settings.substeps = 9
    assert world.settings.substeps == 4
    world.settings = settings
    world.gravity = [0, 0, 0]
    assert world.settings.substeps == 9 and not world.gravity.any()


def test_targets_are_held_or_told() -> None:
    assert not atoll.ErrorTarget().is_set() and atoll.ErrorTarget().max_substeps == 128
    world = atoll.load_scene("stack:height=4").build()
    assert world.step(DT).counts.body_substeps == 0 and world.missed_targets() == []
    settings = world.settings
    settings.target = atoll.ErrorTarget(penetration=1e-4)
    world.settings = settings
    world.steps(60, DT)
    counts = world.step(DT).counts
    assert counts.island_bodies == 4 and counts.body_substeps == 4 * counts.max_substeps
    assert world.missed_targets() == [] and counts.missed_targets == 0
    assert counts.max_substeps > 4

    settings.target = atoll.ErrorTarget(penetration=1e-7, min_substeps=1, max_substeps=3)
    world.settings = settings
    assert world.settings.target.max_substeps == 3
    world.steps(3, DT)
    (island,) = world.missed_targets()
    assert island.error == atoll.TargetError.PENETRATION and island.measured > 1e-7
    assert island.lowest == world.bodies[1] and (island.bodies, island.contacts, island.joints) == (4, 4, 0)
    assert island.substeps == 3 and "most substeps" in island.why and "why=" in repr(island)

    settings.stabilisation = atoll.Stabilisation.BAUMGARTE
    with pytest.raises(atoll.Error, match="target"):
        world.settings = settings
    with pytest.raises(atoll.Error, match="max_substeps is 1; expected min_substeps, 2, or more"):
        atoll.World(settings=atoll.Settings(target=atoll.ErrorTarget(motion=1, min_substeps=2, max_substeps=1)))


def test_reports_tell_phases_and_features(world: atoll.World) -> None:
    # In all but steps that something else interrupted.
    reports = [world.step(DT) for _ in range(50)]
    assert any(math.isclose(sum(report.phase_ms.values()), report.ms, rel_tol=0.5) for report in reports)
    report = reports[-1]
    assert list(report.phase_ms)[0] == "plan"
    assert report.features["friction"].run and not report.features["joint_solver"].run
    assert report.counts.contacts == 1 and report.counts.points == 4


def test_queries_say_how_deep_and_which_way_out() -> None:
    world = atoll.World()
    box = world.add_body(atoll.BodyDef(shape=atoll.Box([1, 2, 3]), type=atoll.BodyType.STATIC))
    (near,) = world.nearby(atoll.Sphere(0.5), [0.9, 0, 0])
    assert near.body == box
    assert near.distance == pytest.approx(-0.6)
    assert near.normal == pytest.approx([1, 0, 0])
    assert near.on_body == pytest.approx([1, 0, 0])
    closest = world.closest_point(None, [0, 1.75, 0], 1)
    assert closest is not None
    assert closest.distance == pytest.approx(-0.25)
    ray = world.cast_ray([0, 1.75, 0], [1, 0, 0])
    assert ray is not None
    assert ray.started_inside
    assert ray.depth == pytest.approx(0.25)
    assert ray.normal == pytest.approx([0, 1, 0])
    assert world.nearby(atoll.Sphere(0.5), [3, 0, 0]) == []
    assert [each.distance for each in world.nearby(atoll.Sphere(0.5), [3, 0, 0], 2)] == pytest.approx([1.5])


def test_instruments_read_what_holds_a_crate_up() -> None:
    settings = atoll.Settings(accelerations=True, contact_events=True, contact_event_force=1)
    world = atoll.World(settings=settings)
    ground = world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
    crate = world.add_body(shape=atoll.Box([0.5, 0.5, 0.5]), position=[0, 0, 0.5], mass=2)
    for _ in range(60):
        world.step(DT)
    assert world.proper_acceleration(crate) == pytest.approx([0, 0, 9.81], abs=1e-3)
    assert world.accelerations.shape == world.angular_accelerations.shape == (2, 3)
    wrench = world.contact_wrench(crate)
    assert wrench.force == pytest.approx([0, 0, 2 * 9.81], abs=0.02)
    assert world.contact_wrenches[crate] == pytest.approx(np.concatenate([wrench.force, wrench.torque]))
    (event,) = world.contact_events()
    assert (event["a"]["index"], event["b"]["index"]) == (ground.index, crate.index)
    assert event["persists"] and not event["began"]
    assert event["impulse"] == pytest.approx(2 * 9.81 * DT, rel=1e-3)


def test_a_sensor_tells_what_passes_through() -> None:
    world = atoll.World(gravity=[0, 0, 0])
    gate = atoll.BodyDef(type=atoll.BodyType.STATIC, shape=atoll.Box([0.005, 1, 1]), continuous=True, sensor=True)
    world.add_body(gate)
    world.add_body(shape=atoll.Sphere(0.01), position=[-1, 0, 0], velocity=[400, 0, 0])
    world.step(DT)
    assert world.sensor_events()["entered"].tolist() == [True, False]


def test_materials_combine_by_their_rules() -> None:
    slippery = atoll.Material(friction=0, friction_rule=atoll.CombineRule.MULTIPLY)
    world = atoll.World()
    world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace(), material=atoll.Material(friction=1))
    crate = world.add_body(position=[0, 0, 0.5], velocity=[1, 0, 0], material=slippery)
    for _ in range(30):
        world.step(DT)
    assert world.velocity(crate)[0] == pytest.approx(1, abs=1e-6)
    assert world.material(crate).friction_rule == atoll.CombineRule.MULTIPLY
