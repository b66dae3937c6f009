"""URDFs: repairs are the least, what MuJoCo drops is told, and files of meshes are found."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

import atoll
from atoll._robots import Verdict
from atoll._robots.inertia import nearest, second_moments

SPHERE = '<collision><geometry><sphere radius=".1"/></geometry></collision>'


def inertial(mass: float, moments: tuple[float, float, float] = (1, 1, 1)) -> str:
    x, y, z = moments
    return (
        f'<inertial><mass value="{mass}"/><inertia ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def joint(kind: str, parent: str, child: str, more: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>'
    return f'<joint name="{parent}{child}" type="{kind}">{ends}{more}</joint>'


def urdf(links: dict[str, str], *joints: str) -> str:
    made = "".join(f'<link name="{name}">{inside}</link>' for name, inside in links.items())
    return f'<robot name="test">{made}{"".join(joints)}</robot>'


def notes(robot: atoll.Robot, verdict: Verdict = Verdict.TAKEN_AS) -> dict[tuple[str, str], str]:
    return {(line.element, line.name): line.note for line in robot.receipt.of(verdict)}


def test_a_repaired_inertia_is_the_nearest_that_a_body_has() -> None:
    random = np.random.default_rng(1)
    for _ in range(50):
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        given = axes @ np.diag(random.uniform(-0.2, 1, 3)) @ axes.T
        given = (given + given.T) / 2
        taken, wrong = nearest(given, 1.0)
        wanted = second_moments(given)
        assert bool(wrong) == (np.linalg.eigvalsh(wanted)[0] < 0)
        moments = np.linalg.eigvalsh(taken)
        assert moments[0] > 0 and moments[0] + moments[1] >= moments[2]
        distance = np.linalg.norm(second_moments(taken) - wanted)
        for _ in range(50):
            factor = random.normal(size=(3, 3)) * random.uniform(0, 0.1)
            other = np.linalg.cholesky(second_moments(taken)) + factor
            assert np.linalg.norm(other @ other.T - wanted) >= distance - 1e-9


def test_a_triangle_inequality_is_mended_by_half_of_what_it_lacks() -> None:
    taken, wrong = nearest(np.diag([1.0, 2.0, 5.0]), 1.0)  # second moments 3, 2, -1
    assert np.diag(taken) == pytest.approx([2, 3, 5], rel=1e-8)
    assert wrong == "a moment is larger than the sum of the others"
    point, wrong = nearest(np.zeros((3, 3)), 2.0)
    assert point == pytest.approx(2.0 * 2e-6 * np.eye(3))  # a radius of gyration of 1 mm along each axis
    assert "point" in wrong


def test_masses_are_repaired_and_told() -> None:
    links = {
        "base": inertial(4, (1, 1, 3)),
        "tool": "",  # fixed: a frame
        "between": "",
        "arm": inertial(2) + SPHERE,
        "finger": SPHERE,
        "nail": "",
    }
    joints = [
        joint("fixed", "base", "tool"),
        joint("continuous", "base", "between"),
        joint("continuous", "between", "arm"),
        joint("continuous", "arm", "finger"),
        joint("continuous", "finger", "nail"),
    ]
    robot = atoll.load_urdf(urdf(links, *joints))
    remarks = notes(robot)
    assert "moments of 1.5, 1.5, 3 kg m^2, from 1, 1, 3" in remarks["inertial", "base"]
    assert remarks["inertial", "between"].startswith("0.002 kg")
    assert ("inertial", "tool") not in remarks
    assert {name for kind, name in notes(robot, Verdict.LEFT_OUT) if kind == "joint"} == {"armfinger", "fingernail"}
    assert [c.name for c in robot.coordinates] == ["basebetween", "betweenarm"]
    assert robot.bodies["nail"] == robot.bodies["arm"]
    world = robot.build()
    masses = {name: world.mass(world.bodies[place]) for name, place in robot.bodies.items()}
    assert masses["base"] == 4 and masses["between"] == pytest.approx(0.002) and masses["arm"] == 2


def test_the_base_is_free_unless_it_is_held() -> None:
    links = {"base": inertial(1) + SPHERE, "arm": inertial(1)}
    for fixed, fallen in ((False, 9.81 / 2), (True, 0)):
        robot = atoll.load_urdf(urdf(links, joint("fixed", "base", "arm")), fixed_base=fixed)
        world = robot.build()
        world.steps(480, 1 / 480)
        heights = [world.pose(body).position[2] for body in world.bodies]
        assert heights == pytest.approx([-fallen], abs=0.02)
    links["world"] = ""
    held = atoll.load_urdf(urdf(links, joint("fixed", "world", "base"), joint("continuous", "base", "arm")))
    assert [c.name for c in held.coordinates] == ["basearm"]
    assert held.scene.bodies[held.bodies["base"]].definition.type == atoll.BodyType.STATIC


def test_links_touch_each_other_only_if_asked_to() -> None:
    links = {"a": inertial(1) + SPHERE, "b": inertial(1) + SPHERE, "c": inertial(1) + SPHERE}
    text = urdf(links, joint("continuous", "a", "b"), joint("continuous", "b", "c", '<origin xyz=".05 0 0"/>'))
    for touch in (False, True):
        world = atoll.load_urdf(text, self_collision=touch).build()
        world.gravity = np.zeros(3)
        world.step(1e-3)
        assert bool(len(world.contact_forces())) == touch


def test_joints_and_their_limits_are_read() -> None:
    links = {name: inertial(1) + SPHERE for name in "abcdef"}
    origin = '<origin xyz="0 0 1" rpy=".1 -.2 .3"/>'
    robot = atoll.load_urdf(
        urdf(
            links,
            joint("revolute", "a", "b", '<limit lower="-1" upper="2" effort="3" velocity="4"/>'),
            joint("prismatic", "b", "c", '<limit lower="0" upper="0"/><dynamics damping=".5" friction=".25"/>'),
            joint("planar", "c", "d", origin),
            joint("floating", "d", "e", origin),
            joint("continuous", "e", "f", '<mimic joint="ab" multiplier="2"/>'),
        )
    )
    read = {c.name: c for c in robot.coordinates}
    kinds = {"ab": "hinge", "bc": "slide", "cd_TX": "slide", "cd_TY": "slide", "cd_RZ": "hinge", "ef": "hinge"}
    assert {name: c.kind for name, c in read.items()} == kinds
    assert (read["ab"].max_force, read["ab"].max_speed) == (3, 4)
    assert read["ef"].max_force == math.inf
    first, second = (robot.scene.joints[read[name].joint].definition.kind for name in ("ab", "bc"))
    assert isinstance(first, atoll.HingeJoint) and isinstance(second, atoll.SliderJoint)
    assert (first.angle.range.lower, first.angle.range.upper) == (-1, 2)
    assert second.offset.range.upper == math.inf
    assert second.offset.spring is not None and second.offset.spring.damping == 0.5
    assert second.offset.motor is None and second.offset.friction == 0.25
    assert "no room" in notes(robot)["range", "bc"]
    assert any(kind == "equality" for kind, _ in notes(robot))
    mimic = robot.scene.joints[-1]
    assert isinstance(mimic.definition.kind, atoll.TendonJoint)
    assert mimic.terms == [read["ef"].joint, read["ab"].joint]
    assert [term.polynomial[:2] for term in mimic.definition.kind.terms] == [[0, 1], [0, -2]]
    # One that floats starts where it stands on its parent, and nothing holds it there.
    world = robot.build()
    roll, pitch, yaw = 0.1, -0.2, 0.3
    turn_x = np.array([[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]])
    turn_y = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    turn_z = np.array([[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]])
    turn = turn_z @ turn_y @ turn_x
    stands = np.array([0, 0, 1]) + turn @ [0, 0, 1]
    assert world.pose(world.bodies[robot.bodies["e"]]).position == pytest.approx(stands, abs=1e-12)
    assert len(robot.scene.joints) == 5, "the three of what is planar are one"


def stl(folder: Path) -> Path:
    """A tetrahedron with edges of 1 along the axes, as text."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    lines = ["solid tetrahedron"]
    for face in ([0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]):
        vertices = [f"vertex {x} {y} {z}" for x, y, z in corners[face]]
        lines += ["facet normal 0 0 0", "outer loop", *vertices, "endloop", "endfacet"]
    path = folder / "part.stl"
    path.write_text("\n".join([*lines, "endsolid"]))
    return path


def meshes_of(robot: atoll.Robot) -> list[np.ndarray]:
    found = []
    for body in robot.scene.bodies:
        shape = body.definition.shape
        if isinstance(shape, atoll.Compound):
            for child in shape.children:
                assert isinstance(child.shape, atoll.ConvexHull)
                found.append(np.asarray(child.shape.vertices))
    return found


def with_mesh(uri: str, scale: str = "1 1 1") -> str:
    mesh = f'<collision><geometry><mesh filename="{uri}" scale="{scale}"/></geometry></collision>'
    return urdf({"base": inertial(1) + mesh})


def test_packages_are_found(tmp_path: Path) -> None:
    inside = tmp_path / "arm" / "meshes"
    inside.mkdir(parents=True)
    stl(inside)
    beside = tmp_path / "arm" / "urdf"
    beside.mkdir()
    file = beside / "arm.urdf"
    for uri in ("package://arm/meshes/part.stl", "package:///arm/meshes/part.stl", "../meshes/part.stl"):
        file.write_text(with_mesh(uri, "2 2 -3"))
        (points,) = meshes_of(atoll.load_urdf(file))
        edges = sorted(np.linalg.norm(a - b) for n, a in enumerate(points) for b in points[:n])
        assert edges == pytest.approx(sorted([2, 2, 3, 8**0.5, 13**0.5, 13**0.5]), rel=1e-6)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    file = elsewhere / "b.urdf"
    file.write_text(with_mesh("package://hand/meshes/part.stl"))
    left_out = notes(atoll.load_urdf(file), Verdict.LEFT_OUT)
    assert left_out == {("geom", "base/0"): "there is no file package://hand/meshes/part.stl"}
    assert len(meshes_of(atoll.load_urdf(file, packages={"hand": tmp_path / "arm"}))) == 1
    (tmp_path / "arm").rename(tmp_path / "elsewhere" / "hand")
    assert len(meshes_of(atoll.load_urdf(file, packages=[elsewhere]))) == 1


DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-01-01T00:00:00</created><modified>2026-01-01T00:00:00</modified>
  <unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
  <source id="p"><float_array id="a" count="12">0 0 0 100 0 0 0 200 0 0 0 300</float_array><technique_common>
    <accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
    <param name="Z" type="float"/></accessor></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  <triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><translate>5 0 0</translate><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_collada_is_read_in_its_unit(tmp_path: Path) -> None:
    (tmp_path / "part.dae").write_text(DAE)
    robot = atoll.load_urdf(with_mesh(str(tmp_path / "part.dae")))
    if importlib.util.find_spec("collada") is None:
        assert "takes the module collada" in notes(robot, Verdict.LEFT_OUT)["geom", "base/0"]
        return
    (points,) = meshes_of(robot)
    edges = sorted(np.linalg.norm(a - b) for n, a in enumerate(points) for b in points[:n])
    assert edges == pytest.approx(sorted([1, 2, 3, 5**0.5, 10**0.5, 13**0.5]), rel=1e-6)


def test_meshes_that_are_not_read_are_told(tmp_path: Path) -> None:
    for name, content, why in (
        ("part.mesh", b"", "is not of .stl, .obj or .dae"),
        ("part.stl", b"solid x vertex 1 2", "is broken"),
    ):
        (tmp_path / name).write_bytes(content)
        left_out = notes(atoll.load_urdf(with_mesh(str(tmp_path / name))), Verdict.LEFT_OUT)
        assert why in left_out["geom", "base/0"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<mujoco/>", "begins with <mujoco>; expected a URDF"),
        ("<robot", "expected a URDF: "),
        (urdf({"a": ""}, joint("fixed", "a", "b")), "child of ab is 'b'; expected the name of a link"),
        (urdf({"a": "", "b": ""}), r"links without a parent are \['a', 'b'\]; expected one"),
        (urdf({"a": "", "b": ""}, joint("fixed", "a", "b"), joint("fixed", "b", "a")), r"are \[\]; expected one"),
        (urdf({"a": inertial(math.nan)}), "value of a is 'nan'; expected a finite number"),
        (urdf({"a": inertial(1)}, "<joint/>"), "parent of None is ''; expected the name of a link"),
    ],
)
def test_says_what_is_wrong(text: str, said: str) -> None:
    with pytest.raises(atoll.Error, match=said):
        atoll.load_urdf(text)
