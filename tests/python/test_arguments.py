"""What arguments are taken, and what is said of those that are not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import atoll


@pytest.mark.parametrize(
    "call, keyword, words",
    [
        (atoll.Settings, "substep", "Settings: no field 'substep'; did you mean 'substeps'?"),
        (atoll.BodyDef, "masss", "BodyDef: no field 'masss'; did you mean 'mass'?"),
        (atoll.Box, "half_extend", "Box: no field 'half_extend'; did you mean 'half_extents'?"),
        (atoll.Sphere, "zzz", "Sphere: no field 'zzz'; expected of radius"),
        (atoll.World, "gravty", "World: no field 'gravty'; did you mean 'gravity'?"),
        (atoll.World().add_body, "postion", "World.add_body: no argument 'postion'; did you mean 'position'?"),
        (atoll.World().steps, "dtt", "World.steps: no argument 'dtt'; did you mean 'dt'?"),
        (atoll.load_scene, "sead", "load_scene: no argument 'sead'; did you mean 'seed'?"),
    ],
)
def test_a_misspelt_keyword_is_named_with_what_may_be_meant(
    call: Callable[..., object], keyword: str, words: str
) -> None:
    with pytest.raises(TypeError) as raised:
        call(**{keyword: 1})
    assert str(raised.value) == words


def test_other_errors_of_types_are_as_they_are() -> None:
    with pytest.raises(TypeError, match="incompatible function arguments"):
        atoll.Settings(substeps="four")  # type: ignore[arg-type]

    def filter_by(candidate: atoll.ContactCandidate) -> bool:
        raise TypeError("no field of mine")

    world = atoll.load_scene("stack:height=2").build()
    world.set_contact_filter(filter_by)
    with pytest.raises(TypeError, match="^no field of mine$"):
        world.steps(count=1)


def test_enums_are_taken_by_their_names() -> None:
    world = atoll.World(settings=atoll.Settings(stabilisation="split-impulse", friction="Pyramid"))
    assert world.settings.stabilisation is atoll.Stabilisation.SPLIT_IMPULSE
    assert world.settings.friction is atoll.FrictionModel.PYRAMID
    body = world.add_body(type="static", shape=atoll.HalfSpace())
    assert world.type(body) is atoll.BodyType.STATIC
    definition = world.definition(body)
    definition.type = "KINEMATIC"
    assert definition.type is atoll.BodyType.KINEMATIC
    assert atoll.Material(friction_rule="geometric_mean").friction_rule is atoll.CombineRule.GEOMETRIC_MEAN
    assert atoll.BodyForce(1, axis="z").axis is atoll.Axis.Z
    assert repr(atoll.MotionLocks.plane("y")) == repr(atoll.MotionLocks.plane(atoll.Axis.Y))


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: atoll.BodyDef(type="statik"), "BodyDef: found 'statik' for BodyType; expected of static, kin"),
        (lambda: atoll.World().add_body(type=""), "World.add_body: found '' for BodyType; expected of static, "),
        (lambda: setattr(atoll.Settings(), "simd", "avx"), "Settings.simd: found 'avx' for Simd; expected of auto, "),
        (lambda: atoll.MotionLocks.plane("w"), "MotionLocks.plane: found 'w' for Axis; expected of x, y, z"),
    ],
)
def test_a_name_that_is_none_of_an_enum_is_refused_with_the_names(call: Callable[[], Any], words: str) -> None:
    with pytest.raises(TypeError) as raised:
        call()
    assert str(raised.value).startswith(words)


class OfAnotherLibrary(np.ndarray[Any, np.dtype[Any]]):
    """As trimesh's arrays are: numpy's, by a class of its own."""


@pytest.mark.parametrize(
    "vertices, triangles",
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        (np.eye(3, dtype=np.float32), np.array([[0, 1, 2]])),
        (np.asfortranarray(np.eye(3)), np.array([[0, 1, 2]], "u1")),
        (np.eye(3).view(OfAnotherLibrary), np.array([[0, 1, 2]]).view(OfAnotherLibrary)),
        (np.eye(6)[::2, ::2], np.array([[0.0, 1.0, 2.0]])),
    ],
)
def test_arrays_are_taken_as_numpy_takes_them(vertices: Any, triangles: Any) -> None:
    mesh = atoll.TriangleMesh(vertices, triangles)
    assert np.array_equal(mesh.vertices, vertices)
    assert mesh.triangles.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: atoll.ConvexHull([0, 1, 2]), "ConvexHull: found numbers of shape (3,); expected (n, 3)"),
        (lambda: atoll.HeightField([1, 2]), "HeightField: found numbers of shape (2,); expected (n, m)"),
        (lambda: atoll.ConvexHull([[0, 1], [2]]), "ConvexHull: found what makes no array of numbers: ValueError"),
        (lambda: atoll.ConvexHull("box"), "ConvexHull: found what makes no array of numbers: ValueError"),
        (
            lambda: atoll.TriangleMesh(np.eye(3), [[0, 1, -1]]),
            "TriangleMesh: found numbers that are no indices; expected whole ones from 0 on",
        ),
    ],
)
def test_what_is_no_array_of_the_shape_is_refused_with_both_shapes(call: Callable[[], Any], words: str) -> None:
    with pytest.raises(TypeError) as raised:
        call()
    assert str(raised.value).startswith(words)
