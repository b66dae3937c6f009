"""URDF as scenes: by MuJoCo's compiler, with what that refuses repaired and what it drops told."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

from .. import _core
from .compiled import Compiled, compiler
from .decomposition import check_hull_error
from .links import Links, number
from .mesh_files import MeshFiles, Packages, Unreadable
from .mjcf import read
from .receipt import Receipt
from .robot import Robot

_Element = ElementTree.Element
_READ = {
    "robot": {"link", "joint", "material", "mujoco"},
    "link": {"inertial", "visual", "collision"},
    "joint": {"parent", "child", "origin", "axis", "limit", "dynamics", "mimic"},
}
_COMPILER = {
    "fusestatic": "false",
    "discardvisual": "true",
    "strippath": "false",
    "inertiafromgeom": "false",
    "balanceinertia": "false",
    "boundmass": "0",
    "boundinertia": "0",
}


def load_urdf(
    source: str | Path,
    packages: Packages = (),
    fixed_base: bool = False,
    self_collision: bool = False,
    hull_error: float | None = None,
) -> Robot:
    """A URDF as a scene, by MuJoCo's compiler, which takes `pip install atoll[robots]`.

    source: a file, or the text of one. packages: folders of packages by their names, or folders to look for them in, for
    `package://` in names of meshes; the folders above the file are looked in as well. fixed_base: whether the first link
    is held to the world. One named "world" always is. self_collision: whether links may touch each other, except those that
    a joint connects. Shapes in many files overlap, and would be pushed apart. hull_error: as of load_mjcf().

    The scene has a body for each link that moves by itself: what is fixed to it is part of it. Shapes are those of
    `collision`, meshes as their convex hulls. What can't be simulated is repaired as little as possible, and the receipt
    says from what to what: an inertia that no body has becomes the nearest that one has; a link without mass that
    carries none becomes part of its parent; one that carries mass gets a thousandth of that. Raises Error if the file
    isn't a URDF, a number in it isn't one, or the compiler refuses it.
    """
    check_hull_error("load_urdf", hull_error)
    model, root = compile_urdf(source, packages, fixed_base, self_collision)
    robot = read(model, hull_error)
    _name_limits(root, robot)
    return robot


def compile_urdf(
    source: str | Path, packages: Packages = (), fixed_base: bool = False, self_collision: bool = False
) -> tuple[Compiled, _Element]:
    """What MuJoCo makes of a URDF once it is repaired, and that as XML."""
    mujoco = compiler()
    path = None if str(source).lstrip().startswith("<") else Path(source)
    root = _parse(source, path)
    receipt = Receipt(root.get("name") or (path.stem if path else "robot"))
    root.set("name", receipt.model)
    meshes = MeshFiles((path.parent if path else Path()).resolve(), packages)
    _tell_of_extensions(root, receipt)
    _take_shapes(root, meshes, receipt)
    _take_limits(root, receipt)
    links = Links(root, receipt)
    links.repair()
    links.free_floating()
    if not fixed_base:
        links.free_base()
    _leave_fixed_mimics(root, receipt)
    settings = root.find("mujoco")
    settings = ElementTree.SubElement(root, "mujoco") if settings is None else settings
    options = settings.find("compiler")
    options = ElementTree.SubElement(settings, "compiler") if options is None else options
    options.attrib.pop("meshdir", None)
    options.attrib.update(_COMPILER)
    try:
        spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"), assets=meshes.assets)
        for mesh in spec.meshes:  # which give no masses here, and may be flat
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        if not self_collision:
            receipt.taken_as("contacts", "of links", "none with each other: self_collision is off")
            for geom in spec.geoms:
                geom.contype, geom.conaffinity = 1, 0
        model = spec.compile()
    except ValueError as error:
        raise _core.Error(f"load_urdf: MuJoCo refuses the model: {error}") from None
    return Compiled(mujoco, model, None, receipt), root


def _parse(source: str | Path, path: Path | None) -> _Element:
    try:
        root = ElementTree.fromstring(str(source)) if path is None else ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise _core.Error(f"load_urdf: source is {path or 'a text'}; expected a URDF: {error}") from None
    if root.tag != "robot":
        raise _core.Error(f"load_urdf: source begins with <{root.tag}>; expected a URDF, which begins with <robot>")
    return root


def _tell_of_extensions(root: _Element, receipt: Receipt) -> None:
    """Leaves out, by kind, what is not of the format or does not concern motion."""
    for kind, elements in (("robot", [root]), ("link", root.findall("link")), ("joint", root.findall("joint"))):
        found = Counter(part.tag for element in elements for part in element if part.tag not in _READ[kind])
        for tag, count in found.items():
            receipt.left_out(tag, f"{count} in a {kind}", "it is not read")
        for element in elements:
            for part in [part for part in element if part.tag not in _READ[kind]]:
                element.remove(part)
    if root.find("link") is None:
        receipt.left_out("robot", receipt.model, "it has no links")
        root.append(ElementTree.Element("link", name="world"))


def _take_shapes(root: _Element, meshes: MeshFiles, receipt: Receipt) -> None:
    """Gives each collision a name of its own, and its mesh as an asset."""
    for link in root.findall("link"):
        name = link.get("name", "")
        for visual in link.findall("visual"):
            receipt.exact("visual that only shows", name)
            link.remove(visual)
        for place, collision in enumerate(link.findall("collision")):
            own = f"{name}/{place}"
            mesh = collision.find("geometry/mesh")
            collision.set("name", own)
            if mesh is None:
                continue
            try:
                mesh.set("filename", meshes.read(mesh.get("filename", ""), mesh.get("scale", "")))
            except Unreadable as error:
                receipt.left_out("geom", own, str(error))
                link.remove(collision)
    for material in root.findall("material"):
        root.remove(material)


def _take_limits(root: _Element, receipt: Receipt) -> None:
    for joint in root.findall("joint"):
        name, limit = joint.get("name", ""), joint.find("limit")
        if limit is None:
            continue
        bounded = joint.get("type") in ("revolute", "prismatic")
        lower, upper = number(limit, "lower", name), number(limit, "upper", name)
        if bounded and lower >= upper:
            receipt.taken_as("range", name, f"none: [{lower:g}, {upper:g}] has no room")
            for bound in ("lower", "upper"):
                limit.attrib.pop(bound, None)
        limit_texts = [f"{what} {value}" for what in ("effort", "velocity") if (value := limit.get(what))]
        if limit_texts:
            receipt.taken_as("limit", name, f"{' and '.join(limit_texts)} of its coordinate, to which nothing holds it")


def _leave_fixed_mimics(root: _Element, receipt: Receipt) -> None:
    """MuJoCo makes equalities of joints that mimic others, if both move along one coordinate."""
    moving = {j.get("name") for j in root.findall("joint") if j.get("type") in ("revolute", "continuous", "prismatic")}
    for joint in root.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and not {joint.get("name"), mimic.get("joint")} <= moving:
            receipt.left_out(
                "mimic", joint.get("name", ""), f"it or {mimic.get('joint')} is fixed, or has several coordinates"
            )
            joint.remove(mimic)


def _name_limits(root: _Element, robot: Robot) -> None:
    limits = {joint.get("name"): limit for joint in root.findall("joint") if (limit := joint.find("limit")) is not None}
    for place, coordinate in enumerate(robot.coordinates):
        limit = limits.get(coordinate.name)
        if limit is not None:
            force, speed = (number(limit, what, coordinate.name) for what in ("effort", "velocity"))
            robot.coordinates[place] = dataclasses.replace(
                coordinate, max_force=force or math.inf, max_speed=speed or math.inf
            )
