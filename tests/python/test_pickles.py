"""What is pickled and copied is the same: by what it says, and by the bits that worlds come to with it."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import atoll

DT = 1 / 60
WAYS: list[Callable[[Any], Any]] = [lambda thing: pickle.loads(pickle.dumps(thing)), copy.deepcopy, copy.copy]


def cloud(points: int, seed: int) -> NDArray[np.float64]:
    directions = np.random.default_rng(seed).normal(size=(points, 3))
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True) * [0.4, 0.3, 0.5])


def bowl() -> atoll.TriangleMesh:
    x, y = np.meshgrid(np.linspace(-3, 3, 13), np.linspace(-3, 3, 13))
    vertices = np.stack([x.ravel(), y.ravel(), 0.1 * (x**2 + y**2).ravel()], axis=1)
    corner = np.arange(13 * 12)[np.arange(13 * 12) % 13 != 12]
    triangles = np.concatenate(
        [np.stack([corner, corner + 1, corner + 14], axis=1), np.stack([corner, corner + 14, corner + 13], axis=1)]
    )
    return atoll.TriangleMesh(vertices, triangles.astype(np.uint32), smooth_angle=0.5)


def hills() -> atoll.HeightField:
    heights = np.random.default_rng(2).uniform(0, 0.3, (9, 7))
    return atoll.HeightField(heights, 0.9, 0.7, smooth=True)


def content_of(shape: Any) -> list[Any]:
    """All that a shape says of itself."""
    if isinstance(shape, atoll.ConvexHull):
        faces = [shape.face(i) for i in range(shape.face_count)]
        return [shape.vertices.tolist(), faces, shape.simplified, shape.volume, shape.centre_of_mass.tolist()]
    if isinstance(shape, atoll.TriangleMesh):
        return [shape.vertices.tolist(), shape.triangles.tolist(), shape.closed, shape.smooth_angle]
    if isinstance(shape, atoll.HeightField):
        return [shape.heights.tolist(), shape.spacing_x, shape.spacing_y, shape.smooth]
    assert isinstance(shape, atoll.Compound)
    return [
        [content_of(child.shape), child.position.tolist(), child.orientation.tolist(), child.density_factor]
        for child in shape.children
    ]


def club() -> atoll.Compound:
    hulls = [atoll.ConvexHull(cloud(12, 3)), atoll.ConvexHull(cloud(20, 4)).scaled([1, -2, 0.5])]
    return atoll.Compound(
        [
            atoll.CompoundChild(shape=hulls[0], position=[0.5, 0, 0], density_factor=2, material=atoll.Material(friction=0.1)),
            atoll.CompoundChild(shape=hulls[1], orientation=[0, 0, 0.6, 0.8]),
            atoll.CompoundChild(shape=hulls[0], position=[-0.5, 0, 0]),
        ]
    )


SHAPES: dict[str, Callable[[], Any]] = {
    "hull": lambda: atoll.ConvexHull(cloud(30, 1)),
    "stretched hull": lambda: atoll.ConvexHull(cloud(30, 1)).scaled([-1, 2, 0.7]),
    "simplified hull": lambda: atoll.ConvexHull(cloud(500, 1)),
    "mesh": bowl,
    "mirrored mesh": lambda: bowl().scaled([-1, 1, 1.5]),
    "height field": hills,
    "compound": club,
}


def hash_with(definition: atoll.BodyDef) -> int:
    """A ball, and the body if it is dynamic, fall into a bowl, or the ball upon the body."""
    world = atoll.World()
    world.add_body(definition)
    if definition.type == atoll.BodyType.DYNAMIC:
        world.add_body(type=atoll.BodyType.STATIC, shape=bowl())
    world.add_body(shape=atoll.Sphere(0.3), position=definition.position + np.array([0.3, 0.4, 1.2]))
    world.add_body(shape=atoll.Box([0.2, 0.3, 0.1]), position=definition.position + np.array([-0.4, 0.5, 1.1]))
    world.steps(60, DT)
    assert len(world.contact_forces()) > 0
    return world.state_hash()


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_pickled_and_copied(name: str) -> None:
    shape = SHAPES[name]()
    kind = atoll.BodyType.STATIC if isinstance(shape, (atoll.TriangleMesh, atoll.HeightField)) else atoll.BodyType.DYNAMIC
    definition = atoll.BodyDef(type=kind, shape=shape, position=[0.1, 0.2, 0.0 if kind == atoll.BodyType.STATIC else 1.5])
    expected = hash_with(definition)
    for way in WAYS:
        assert content_of(way(shape)) == content_of(shape) and repr(way(shape)) == repr(shape)
        copied = way(definition)
        assert content_of(copied.shape) == content_of(shape) and hash_with(copied) == expected
    # Snapshots that were pickled find the geometry that they are of.
    world = atoll.World()
    world.add_body(definition)
    other = atoll.World()
    other.add_body(pickle.loads(pickle.dumps(definition)))
    world.steps(3, DT)
    other.restore(pickle.loads(pickle.dumps(world.save())))
    assert other.state_hash() == world.state_hash()


def test_damaged_pickles_are_refused() -> None:
    state = atoll.ConvexHull(cloud(10, 5)).__getstate__()
    for bad in (b"", state[:-1], state + b" ", state[:40] + b"\xff" + state[41:]):
        with pytest.raises(atoll.Error, match="ConvexHull::from_bytes: found"):
            atoll.ConvexHull.__new__(atoll.ConvexHull).__setstate__(bad)
    vertices, triangles, angle, materials = bowl().__getstate__()
    triangles = triangles.copy()
    triangles[5, 1] = 1000
    with pytest.raises(atoll.Error, match="triangle 5"):
        atoll.TriangleMesh.__new__(atoll.TriangleMesh).__setstate__((vertices, triangles, angle, materials))


def test_bodies_share_their_geometry_in_a_pickle_and_out_of_it() -> None:
    scene = atoll.load_scene("rocks:bodies=300")

    def hulls_of(of: atoll.Scene) -> list[atoll.ConvexHull]:
        shapes = [body.definition.shape for body in of.bodies]
        return [shape for shape in shapes if isinstance(shape, atoll.ConvexHull)]

    hulls = hulls_of(pickle.loads(pickle.dumps(scene)))
    kinds = {shape.vertices.tobytes() for shape in hulls}
    assert len({id(shape) for shape in hulls}) == len({id(shape) for shape in hulls_of(scene)}) == len(kinds) == 95
    each = sum(len(pickle.dumps(body)) for body in scene.bodies)
    assert len(pickle.dumps(scene)) < 0.5 * each
    assert scene.bodies[20].definition.shape is scene.bodies[20].definition.shape


@pytest.mark.parametrize(
    "text", ["rocks:bodies=20", "terrain:bodies=2,triangles=200", "ragdolls:count=1", "vehicle", "pushed-box"]
)
def test_scenes_are_pickled_and_copied(text: str) -> None:
    scene = atoll.load_scene(text)

    def hash_of(of: atoll.Scene) -> int:
        world = of.build()
        for _ in range(20):
            of.apply_forces(world)
            world.step(of.dt)
        return world.state_hash()

    for way in WAYS:
        copied = way(scene)
        assert copied.text() == scene.text()
        assert hash_of(copied) == hash_of(scene)


def test_a_pickled_scene_has_no_closed_form() -> None:
    scene = atoll.load_scene("pendulum")
    assert "analytic_error" in atoll.ErrorMeter(scene).errors()
    assert "analytic_error" not in atoll.ErrorMeter(pickle.loads(pickle.dumps(scene))).errors()
    assert "analytic_error" in atoll.ErrorMeter(copy.copy(scene)).errors()


def hash_in_another_process(work: tuple[atoll.Scene, atoll.Snapshot]) -> int:
    scene, start = work
    world = scene.build(threads=2)
    world.restore(start)
    world.steps(20, scene.dt)
    return world.state_hash()


def test_a_scene_and_a_snapshot_go_to_other_processes() -> None:
    scene = atoll.load_scene("rocks:bodies=12")
    world = scene.build()
    starts = []
    for _ in range(3):
        world.steps(5, scene.dt)
        starts.append(world.save())
    expected = []
    for start in starts:
        world.restore(start)
        world.steps(20, scene.dt)
        expected.append(world.state_hash())
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(hash_in_another_process, [(scene, start) for start in starts]) == expected


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy])
def test_worlds_are_copied_but_not_pickled(way: Callable[[atoll.World], atoll.World]) -> None:
    scene = atoll.load_scene("rocks:bodies=20")
    world = scene.build(threads=2)
    asked = []
    world.set_contact_filter(lambda candidate: bool(asked.append(candidate.a)) or True)  # type: ignore[func-returns-value]
    world.steps(10, scene.dt)
    branch = way(world)
    assert branch.state_hash() == world.state_hash() and branch.threads == 2 and branch.joints == world.joints
    assert repr(branch.settings) == repr(world.settings)
    calls = len(asked)
    branch.steps(20, scene.dt)
    assert len(asked) == calls and branch.state_hash() != world.state_hash()
    world.set_contact_filter(None)
    world.steps(20, scene.dt)
    assert branch.state_hash() == world.state_hash()
    with pytest.raises(TypeError, match="pickle"):
        pickle.dumps(world)
