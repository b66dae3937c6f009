"""MJCF, and what else MuJoCo's compiler reads, as scenes: from the arrays of a model that it has compiled."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from .. import _core
from .actuators import Actuators
from .bodies import Bodies
from .compiled import Compiled, compiler
from .decomposition import check_hull_error
from .equalities import Equalities
from .filters import Filters
from .robot import Robot
from .sensor_elements import SensorElements
from .tendons import Tendons

_OVERLAP = 1e-3  # m, from which on a receipt tells that shapes overlap
_SOFT = "contacts are rigid here: solref, solimp and margin do nothing"
_FRICTION = "two surfaces have the geometric mean of their coefficients here, and the larger one, or the first's, there"


def load_mjcf(source: str | Path, pose: str | int | None = None, hull_error: float | None = None) -> Robot:
    """A model of MuJoCo's as a scene, by MuJoCo's own compiler, which takes `pip install atoll[robots]`.

    source: a file (MJCF, or URDF as MuJoCo reads it), or the text of one. pose: the name or number of the keyframe that
    the scene starts in; the model's own reference pose, if left out. hull_error: of a mesh, by what part of its volume the
    convex hulls that stand for it may be off, > 0; where one is off by more CoACD takes it apart, which takes seconds. If
    left out, each mesh has one hull. The receipt tells how far each is off. The scene has the model's gravity and step, and a
    body for each of its bodies that moves by itself: what is welded to it is part of it. Angles and offsets of joints
    count as in the model. Raises Error if the compiler refuses the model, or the pose isn't one of its own.
    """
    check_hull_error("load_mjcf", hull_error)
    mujoco = compiler()
    text = str(source)
    compiled = mujoco.MjModel.from_xml_string if text.lstrip().startswith("<") else mujoco.MjModel.from_xml_path
    try:
        model = compiled(text)
    except (ValueError, OSError) as error:
        raise _core.Error(f"load_mjcf: MuJoCo refuses the model: {error}") from None
    return read(Compiled(mujoco, model, pose), hull_error)


def read(model: Compiled, hull_error: float | None = None) -> Robot:
    """Goes through a compiled model, element by element."""
    m, receipt = model.arrays, model.receipt
    robot = Robot(receipt.model, _core.Scene(name=receipt.model), receipt, {})
    scene = robot.scene
    scene.gravity = np.array(m.opt.gravity)
    scene.dt = float(m.opt.timestep)
    filters = Filters(model.mujoco, m)
    bodies = Bodies(model, filters, hull_error)
    tendons = Tendons(model, bodies)
    Equalities(model, bodies, tendons)
    robot.sensors = SensorElements(model, bodies).sensors
    scene.bodies, scene.joints = bodies.scene, bodies.joints.scene
    robot.coordinates = bodies.joints.coordinates
    for body in range(1, m.nbody):
        root, name = int(m.body_weldid[body]), model.name("BODY", body)
        if root in bodies.places:
            robot.bodies[name] = bodies.places[root]
        if root == body:
            receipt.exact("body", name)
        else:
            receipt.taken_as("body", name, f"part of {model.name('BODY', root)}, exactly")
    Actuators(model, robot, tendons).add()
    _tell_of_the_rest(model, filters)
    return robot


def _tell_of_the_rest(model: Compiled, filters: Filters) -> None:
    m, receipt = model.arrays, model.receipt
    if np.any(m.geom_contype) or np.any(m.geom_conaffinity):
        receipt.taken_as("contacts", "all", _SOFT)
        receipt.taken_as("friction", "all", _FRICTION)
    for note in filters.left_out:
        receipt.left_out("exclude", "", note)
    for (first, second), depth in _overlaps(model).items():
        receipt.taken_as(
            "pose", f"{first} and {second}", f"shapes of the two overlap by {depth:.3g} m, and are pushed apart"
        )
    for number in range(m.npair):
        _tell_of_pair(model, filters, number)
    for number in range(m.nflex):
        receipt.left_out("flex", str(number), "bodies are rigid here")
    if m.opt.density or m.opt.viscosity:
        receipt.left_out("option", "density, viscosity", "there is no fluid here")


def _tell_of_pair(model: Compiled, filters: Filters, number: int) -> None:
    m = model.arrays
    geoms = [int(ids[number]) for ids in (m.pair_geom1, m.pair_geom2)]
    names = " and ".join(model.name("GEOM", geom) for geom in geoms)
    if not filters.may_meet(*geoms):
        model.receipt.left_out("pair", names, "a joint connects their bodies, or there are too many kinds of shapes")
        return
    own = math.sqrt(math.prod(float(m.geom_friction[geom][0]) for geom in geoms))
    asked = float(m.pair_friction[number][0]) if int(m.pair_dim[number]) > 1 else 0.0
    model.receipt.taken_as("pair", names, f"shapes that touch, with the friction of their own, {own:.3g}, for {asked:.3g}")


def _overlaps(model: Compiled) -> dict[tuple[str, str], float]:
    """m, of bodies that touch in the model's pose."""
    m, data = model.arrays, model.data
    model.mujoco.mj_collision(m, data)
    found: dict[tuple[str, str], float] = {}
    for contact in data.contact:
        depth = -float(contact.dist)
        if depth > _OVERLAP:
            first, second = (model.name("BODY", int(m.geom_bodyid[geom])) for geom in contact.geom)
            found[first, second] = max(found.get((first, second), 0.0), depth)
    return found
