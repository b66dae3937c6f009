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


def test_pairs_touch_whatever_else_says_that_they_do_not() -> None:
    """Shapes without bits of their own, of which one also meets a shape of an excluded body; and one that isn't in any."""
    body = '<body name="{0}" pos="0 0 {1}"><freejoint/><geom name="{0}" size=".1" contype="{2}" conaffinity="{2}"/></body>'
    bodies = [("a", 1.0, 0), ("b", 1.01, 0), ("c", 1.02, 1), ("d", 1.03, 0), ("e", 1.04, 1)]
    model = f"""
    <mujoco><worldbody>{"".join(body.format(*one) for one in bodies)}</worldbody><contact>
      <pair geom1="a" geom2="b" friction=".5 .5 .005 .0001 .0001"/><pair geom1="c" geom2="b"/>
      <exclude body1="b" body2="c"/></contact></mujoco>"""
    compiled = mujoco.MjModel.from_xml_string(model)
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    pairs = {tuple(sorted(compiled.body(compiled.geom_bodyid[g]).name for g in c.geom)) for c in data.contact}
    assert pairs == {("a", "b"), ("b", "c"), ("c", "e")}
    robot = atoll.load_mjcf(model)
    assert touching(robot) == pairs
    first, second = (line for line in robot.receipt.lines if line.element == "pair")
    assert first.note == "shapes that touch, with the friction of their own, 1, for 0.5"
    assert second.verdict is Verdict.TAKEN_AS
    # Nothing else touches them, as a floor that isn't of the model.
    world = robot.build()
    world.add_body(type=atoll.BodyType.STATIC, shape=atoll.HalfSpace())
    world.steps(240, 1 / 240)
    heights = {name: world.positions[world.bodies[place]][2] for name, place in robot.bodies.items()}
    assert heights["d"] < -1 < 0 < heights["e"]


def test_pair_that_a_joint_connects_is_left_out() -> None:
    robot = atoll.load_mjcf("""
    <mujoco><worldbody><body name="a"><freejoint/><geom name="a" size=".1"/>
      <body name="b"><joint type="hinge"/><geom name="b" size=".1"/></body></body></worldbody>
    <contact><pair geom1="a" geom2="b"/></contact></mujoco>""")
    (line,) = [line for line in robot.receipt.lines if line.element == "pair"]
    assert line.verdict is Verdict.LEFT_OUT
