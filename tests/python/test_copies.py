"""What looks like a view of a world, batch or scene and is a copy says so where it is written to."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

import atoll


def _set_settings(world: atoll.World, scene: atoll.Scene) -> None:
    world.settings.substeps = 8


def _set_target(world: atoll.World, scene: atoll.Scene) -> None:
    settings = world.settings
    settings.target.penetration = 1e-3


def _set_definition(world: atoll.World, scene: atoll.Scene) -> None:
    world.definition(world.bodies[0]).mass = 3


def _set_body_of_scene(world: atoll.World, scene: atoll.Scene) -> None:
    scene.bodies[0].definition.velocity = np.ones(3)


def _set_bodies_of_scene(world: atoll.World, scene: atoll.Scene) -> None:
    for body in scene.bodies:
        body.definition.material.friction = 0.1


def _set_by_name(world: atoll.World, scene: atoll.Scene) -> None:
    setattr(world.material(world.bodies[0]), "friction", 0.1)


@pytest.mark.parametrize(
    "set_copy, field",
    [
        (_set_settings, "Settings.substeps"),
        (_set_target, "ErrorTarget.penetration"),
        (_set_definition, "BodyDef.mass"),
        (_set_body_of_scene, "BodyDef.velocity"),
        (_set_bodies_of_scene, "Material.friction"),
        (_set_by_name, "Material.friction"),
    ],
)
def test_a_copy_that_nobody_keeps_cannot_be_set(
    set_copy: Callable[[atoll.World, atoll.Scene], None], field: str
) -> None:
    scene = atoll.load_scene("stack:height=2")
    world = scene.build()
    with pytest.raises(atoll.Error, match=rf"{field}: set on a copy .* world\.settings = copy"):
        set_copy(world, scene)


def test_copies_that_are_kept_are_set_wherever_they_are_kept() -> None:
    holder, materials = SimpleNamespace(material=atoll.Material()), [atoll.Material()]
    by_name = {"ice": atoll.Material()}
    holder.material.friction = 0.1
    materials[0].friction = 0.2
    by_name["ice"].friction = 0.3
    for material in materials:
        material.restitution = 0.5
    kept = [holder.material, materials[0], by_name["ice"]]
    assert [material.friction for material in kept] == [0.1, 0.2, 0.3] and materials[0].restitution == 0.5


def test_lists_of_a_scene_are_its_own() -> None:
    scene = atoll.load_scene("stack:height=2")
    count = len(scene.bodies)
    for body in scene.bodies:
        body.force = [0, 0, 5]
    scene.bodies.append(atoll.SceneBody(name="late", definition=atoll.BodyDef(position=[9, 0, 9], mass=2)))
    world = scene.build()
    assert len(world.bodies) == count + 1 and [body.name for body in copy.deepcopy(scene).bodies][-1] == "late"
    assert [list(body.force) for body in pickle.loads(pickle.dumps(scene)).bodies[:count]] == [[0, 0, 5]] * count
    scene.gravity = [0, 0, 0]
    scene.bodies[-1].force = [0, 0, 6]
    world = scene.build()
    scene.apply_forces(world)
    world.step(0.1)
    assert world.velocities[world.bodies[-1], 2] == pytest.approx(6 / 2 * 0.1, rel=1e-6)
    scene.bodies.append("no body")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"Scene\.bodies: found something else in it; expected SceneBody"):
        scene.build()


def test_a_range_does_not_drop_the_spring_of_a_suspension_unsaid() -> None:
    world = atoll.World()
    car, wheel = world.add_body(position=[0, 0, 1]), world.add_body(shape=atoll.Sphere(0.3))
    joint = atoll.WheelJoint(suspension=atoll.JointAxis(range=atoll.JointRange(-0.1, 0.1)))
    with pytest.raises(atoll.Error, match=r"kind\.suspension has a range, but no spring.*expected a spring or a motor"):
        world.add_joint(atoll.joint_at(world, joint, car, wheel, [0, 0, 0]))


def test_arrays_that_are_copies_are_read_only_and_handed_on_as_copies() -> None:
    batch = atoll.Batch("stack:height=2", 2)
    for array in (batch.positions, batch.orientations[:, 1], batch.velocities, batch.contact_forces):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0
    positions = batch.positions
    for taken in (np.from_dlpack(positions), np.from_dlpack(positions[:, 1:]), positions.copy()):
        before = positions.copy()
        taken[:] = 7
        assert np.array_equal(positions, before)
    for computed in (positions + 0, positions.sum(axis=1), np.maximum(positions, 0)):
        assert type(computed) is np.ndarray and computed.flags.writeable
    assert isinstance(positions.sum(), float)
