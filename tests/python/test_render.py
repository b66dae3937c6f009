"""Pictures of worlds: what is seen where, how far away it is, and how large it looks."""

from __future__ import annotations

import math

import gymnasium
import numpy as np
import pytest

import atoll

pytest.importorskip("moderngl")

import atoll.gym  # noqa: E402
from atoll.render import BACKGROUND, Camera, Renderer  # noqa: E402

WIDTH, HEIGHT = 320, 240
FOCAL = HEIGHT / 2 / math.tan(Camera.field_of_view / 2)  # pixels


def renderer_of(world: atoll.World) -> Renderer:
    try:
        return Renderer(world, WIDTH, HEIGHT)
    except atoll.Error as error:
        pytest.skip(str(error))


def test_a_crate_is_where_it_is_and_as_large_as_it_looks(world: atoll.World) -> None:
    crate = world.find_body("crate")
    assert crate is not None
    eye = [0, -6.5, 0.5]
    picture = renderer_of(world).render(Camera(eye, [0, 0, 0.5]))
    assert picture.colour.shape == (HEIGHT, WIDTH, 3) and picture.colour.dtype == np.uint8
    seen = picture.body == crate.index
    side = FOCAL / 6  # pixels: its face is 6 m away
    assert seen.sum() == pytest.approx(side**2, rel=0.05)
    rows, columns = np.nonzero(seen)
    assert rows.mean() == pytest.approx(HEIGHT / 2, abs=1) and columns.mean() == pytest.approx(WIDTH / 2, abs=1)
    assert picture.depth[seen] == pytest.approx(6, abs=1e-3)
    # The ground is below the horizon, at the distance where the line of sight comes down to it; nothing is above.
    below = HEIGHT - 20
    assert picture.body[below, 10] == 0
    assert picture.depth[below, 10] == pytest.approx(0.5 * FOCAL / (below + 0.5 - HEIGHT / 2), rel=1e-3)
    assert picture.body[5, 10] == -1 and math.isinf(picture.depth[5, 10])
    assert tuple(picture.colour[5, 10]) == BACKGROUND
    assert not np.array_equal(picture.colour[HEIGHT // 2, WIDTH // 2], picture.colour[below, 10])


def test_what_moves_changes_or_goes_is_seen_so() -> None:
    world = atoll.World(gravity=[0, 0, 0])
    left, right = world.add_body(position=[-1, 0, 0]), world.add_body(shape=atoll.Sphere(0.5), position=[1, 0, 0])
    renderer, camera = renderer_of(world), Camera([0, -10, 0], [0, 0, 0])

    def area(body: atoll.BodyId) -> int:
        return int((renderer.render(camera).body == body.index).sum())

    ball = area(right)
    assert ball == pytest.approx(math.pi * (0.5 * FOCAL / 10) ** 2, rel=0.05)
    world.set_shape(right, atoll.Sphere(1.0))
    assert area(right) == pytest.approx(4 * ball, rel=0.06)
    world.set_pose(left, atoll.Pose([1, -3, 0]))  # in front of the ball
    assert renderer.render(camera).body[HEIGHT // 2, WIDTH // 2 + round(FOCAL / 10)] == left.index
    world.remove_body(left)
    assert not (renderer.render(camera).body == left.index).any()


def test_holes_are_seen_through() -> None:
    heights = np.zeros((5, 5))
    world = atoll.World()
    field = world.add_body(type="static", shape=atoll.HeightField(heights), position=[-2, -2, 0])
    renderer, camera = renderer_of(world), Camera([0, 0, 5], [0, 0, 0], up=[0, 1, 0])
    assert renderer.render(camera).body[HEIGHT // 2, WIDTH // 2] == field.index
    world.set_heights(field, 2, 2, np.array([[math.nan]]))
    picture = renderer.render(camera)
    assert picture.body[HEIGHT // 2, WIDTH // 2] == -1
    assert (picture.body == field.index).any()


def test_the_camera_that_it_takes_itself_sees_all_that_moves(world: atoll.World) -> None:
    far = world.add_body(shape=atoll.Sphere(1), position=[20, 30, 1])
    seen = set(np.unique(renderer_of(world).render().body))
    assert {far.index, 1} <= seen


def test_cameras_that_see_nothing_are_refused(world: atoll.World) -> None:
    renderer = renderer_of(world)
    for camera in (Camera([0, 0, 1], [0, 0, 1]), Camera([0, 0, 1], [0, 0, 0]), Camera([1, 0, 0], [0, 0, 0], near=0)):
        with pytest.raises(atoll.Error, match="Camera: .*expected"):
            renderer.render(camera)
    with pytest.raises(atoll.Error, match="found 0 x 240 pixels"):
        Renderer(world, 0, HEIGHT)


def test_environments_render(world: atoll.World) -> None:
    renderer_of(world)
    envs = atoll.gym.make("cart-pole", 2, render_mode="rgb_array")
    envs.reset(seed=1)
    before = envs.render()
    for _ in range(20):
        envs.step(np.ones(envs.action_space.shape or ()))
    after = envs.render()
    assert before is not None and after is not None and len(after) == 2
    assert before[0].shape == (480, 640, 3) and not np.array_equal(before[0], after[0])
    single = gymnasium.make("atoll/cart-pole", render_mode="rgb_array")
    single.reset(seed=1)
    picture = single.render()
    assert isinstance(picture, np.ndarray) and np.array_equal(picture, before[0])
    assert atoll.gym.make("cart-pole", 1).render() is None
    with pytest.raises(atoll.Error, match="render_mode 'human'; expected 'rgb_array'"):
        atoll.gym.make("cart-pole", 1, render_mode="human")
