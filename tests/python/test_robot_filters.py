"""Who may touch whom in a scene of a model is as MuJoCo has it."""

from __future__ import annotations

import mujoco  # type: ignore[import-untyped]
import numpy as np
import pytest

import atoll
from atoll._robots import Verdict


def touching(robot: atoll.Robot) -> set[tuple[str, str]]:
    """The names of bodies that touch after a first step."""
    world = robot.build()
    settings = world.settings
    settings.contact_events = True
    world.settings = settings
    world.gravity = np.zeros(3)
    world.step(1e-3)
    ids = {world.bodies[place].index: name for name, place in robot.bodies.items()}
    return {(ids[int(p["a"]["index"])], ids[int(p["b"]["index"])]) for p in world.contact_events()}


def test_who_may_touch_is_as_compiled() -> None:
    model = """
    <mujoco><worldbody>
      <geom name="floor" type="plane" size="1 1 1"/>
      <body name="a" pos="0 0 1"><freejoint/><geom size=".1" contype="1" conaffinity="2"/></body>
      <body name="b" pos="0 0 1.05"><freejoint/><geom size=".1" contype="4" conaffinity="1"/></body>
      <body name="c" pos="0 0 1.1"><freejoint/><geom size=".1" contype="2" conaffinity="4"/></body>
    </worldbody><contact><exclude body1="b" body2="c"/></contact></mujoco>"""
    assert touching(atoll.load_mjcf(model)) == {("a", "b"), ("a", "c")}


def test_more_pairs_are_excluded_than_there_are_classes() -> None:
    """Balls about one place, of which the first may not touch any, and each may not touch the next."""
    balls = [f'<body name="b{n}" pos="0 0 {n * 1e-3}"><freejoint/><geom size=".1"/></body>' for n in range(44)]
    pairs = {(0, n) for n in range(1, 44)} | {(n, n + 1) for n in range(43)}
    excludes = [f'<exclude body1="b{a}" body2="b{b}"/>' for a, b in sorted(pairs)]
    inside = f"<worldbody>{''.join(balls)}</worldbody><contact>{''.join(excludes)}</contact>"
    robot = atoll.load_mjcf(f"<mujoco>{inside}</mujoco>")
    assert not robot.receipt.of(Verdict.LEFT_OUT)
    expected = {(f"b{a}", f"b{b}") for b in range(44) for a in range(b) if (a, b) not in pairs}
    assert touching(robot) == expected

    all_pairs = [f'<exclude body1="b{a}" body2="b{b}"/>' for b in range(44) for a in range(b)]
    robot = atoll.load_mjcf(f"<mujoco>{inside.replace(''.join(excludes), ''.join(all_pairs))}</mujoco>")
    (line,) = robot.receipt.of(Verdict.LEFT_OUT)
    assert line.note.startswith("91 pairs")  # of the 14 bodies that have no class of their own
    assert len(touching(robot)) == 91


def test_all_shapes_touch_what_is_not_of_the_model() -> None:
    ball = '<body pos="{} 0 1"><freejoint/><geom size=".1" contype="{}" conaffinity="{}"/></body>'
    classes = [(1, 1), (2, 0), (0, 4)]
    balls = "".join(ball.format(*place) for place in ((0, *classes[0]), (1, *classes[1]), (2, *classes[2])))
    world = atoll.load_mjcf(f"<mujoco><worldbody>{balls}</worldbody></mujoco>").build()
    world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
    world.steps(240, 1 / 240)
    assert [world.pose(body).position[2] for body in world.bodies[:3]] == pytest.approx([0.1] * 3, abs=1e-3)


@pytest.mark.parametrize("joints", ['<joint axis="1 0 0"/>', '<joint axis="1 0 0"/><joint axis="0 1 0"/>'])
@pytest.mark.parametrize("filtered", [True, False])
def test_a_parent_touches_its_children_as_compiled(joints: str, filtered: bool) -> None:
    model = f"""
    <mujoco><option><flag filterparent="{"enable" if filtered else "disable"}"/></option><worldbody>
      <body name="a"><freejoint/><geom size=".1"/>
        <body name="b">{joints}<geom size=".1" pos=".1 0 0"/>
          <body name="c">{joints}<geom size=".1" pos=".05 .1 0"/></body></body></body></worldbody></mujoco>"""
    compiled = mujoco.MjModel.from_xml_string(model)
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    pairs = {tuple(compiled.body(compiled.geom_bodyid[g]).name for g in c.geom) for c in data.contact}
    assert pairs == ({("a", "c")} if filtered else {("a", "b"), ("a", "c"), ("b", "c")})
    assert touching(atoll.load_mjcf(model)) == pairs
