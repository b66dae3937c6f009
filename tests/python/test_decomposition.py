"""Meshes of robots that are taken apart into convex hulls."""

import numpy as np
import pytest

import atoll

# An L lies on the floor, 1 m thick, with arms of 2 m: 3 m^3, of which the notch would be half a cubic metre more.
OUTLINE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
NOTCH = (1.45, 1.45)


def mesh(open_end: bool = False) -> tuple[str, str]:
    vertices = [(x, y, z) for z in (0, 1) for x, y in OUTLINE]
    ends = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(a, c, b) for a, b, c in ends]
    if not open_end:
        faces += [(a + 6, b + 6, c + 6) for a, b, c in ends]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, j + 6), (i, j + 6, i + 6)]
    return _listed(vertices), _listed(faces)


def _listed(rows: list[tuple[int, int, int]]) -> str:
    return " ".join(str(number) for row in rows for number in row)


def model(body: str = "", open_end: bool = False) -> str:
    vertices, faces = mesh(open_end)
    inertia = 'inertia="shell"' if open_end else ""
    return f"""<mujoco model="notch"><asset><mesh name="l" vertex="{vertices}" face="{faces}" {inertia}/></asset><worldbody>
        <geom name="floor" type="plane" size="0 0 1"/>{body}
        <body name="ball" pos="{NOTCH[0]} {NOTCH[1]} 1.5"><freejoint/><geom size="0.3"/></body></worldbody></mujoco>"""


FIXED = '<geom name="l" type="mesh" mesh="l"/>'
MOVING = '<body name="l"><freejoint/><geom name="l" type="mesh" mesh="l" density="1000"/></body>'


@pytest.mark.parametrize("body", [FIXED, MOVING])
@pytest.mark.parametrize("hull_error, height", [(None, 1.3), (0.02, 0.3)])
def test_ball_falls_into_the_notch_of_several_hulls(body: str, hull_error: float | None, height: float) -> None:
    robot = atoll.load_mjcf(model(body), hull_error=hull_error)
    shapes = [body.definition.shape for body in robot.scene.bodies]
    children = [child.shape for shape in shapes if isinstance(shape, atoll.Compound) for child in shape.children]
    hulls = [shape for shape in shapes + children if isinstance(shape, atoll.ConvexHull)]
    assert sum(hull.volume for hull in hulls) == pytest.approx(3 if hull_error else 3.5, rel=0.02)
    world = robot.build()
    for _ in range(600):
        world.step(1 / 240)
    assert world.positions[world.bodies[robot.bodies["ball"]]][2] == pytest.approx(height, abs=0.02)


def test_receipt_tells_how_far_hulls_are_off() -> None:
    [one] = [str(line) for line in atoll.load_mjcf(model(FIXED)).receipt.lines if "hull" in str(line)]
    assert "12 points" not in one and "+16.7% of its volume" in one
    [many] = [str(line) for line in atoll.load_mjcf(model(FIXED), hull_error=0.02).receipt.lines if "hull" in str(line)]
    assert " hulls by CoACD" in many and "where one hull has +16.7%" in many


def test_bound_that_one_hull_keeps_takes_nothing_apart() -> None:
    loose = atoll.load_mjcf(model(FIXED), hull_error=0.2)
    plain = atoll.load_mjcf(model(FIXED))
    assert len(loose.scene.bodies) == len(plain.scene.bodies)


def test_mesh_that_is_open_has_one_hull() -> None:
    robot = atoll.load_mjcf(model(FIXED, open_end=True), hull_error=0.02)
    [line] = [str(line) for line in robot.receipt.lines if "hull" in str(line)]
    assert "the hull of its points" in line and "%" not in line


def test_same_hulls_each_time() -> None:
    first, second = (atoll.load_mjcf(model(FIXED), hull_error=0.02) for _ in range(2))
    for a, b in zip(first.scene.bodies, second.scene.bodies, strict=True):
        if isinstance(a.definition.shape, atoll.ConvexHull):
            assert isinstance(b.definition.shape, atoll.ConvexHull)
            assert np.array_equal(a.definition.shape.vertices, b.definition.shape.vertices)


@pytest.mark.parametrize("bound", [0, -1, float("nan"), float("inf")])
def test_bounds_that_are_none(bound: float) -> None:
    with pytest.raises(atoll.Error, match="hull_error is .*; expected a finite number > 0, or None"):
        atoll.load_mjcf(model(FIXED), hull_error=bound)
