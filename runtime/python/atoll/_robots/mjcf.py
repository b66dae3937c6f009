"""MJCF, and what else MuJoCo's compiler reads, as scenes: from the arrays of a model that it has compiled."""

from __future__ import annotations

import importlib
import math
from pathlib import Path
from typing import Any, Union

import numpy as np

from .. import _core
from .filters import ALL, Filters
from .receipt import Receipt
from .robot import Actuator, Coordinate, Floats, Robot, inverse, product, turn_to, turned

_Solid = Union[_core.Box, _core.Sphere, _core.Capsule, _core.Cylinder, _core.ConvexHull]
_Shape = Union[_Solid, _core.HalfSpace, _core.HeightField]

_SOFT = "contacts are rigid here: solref, solimp and margin do nothing"
_FRICTION = "two surfaces have the geometric mean of their coefficients here, and the larger one, or the first's, there"
_BEAD = 0.01  # m, of bodies that nothing touches
_BETWEEN = 1e-3  # of a body's mass, for each body between it and the one that carries it
_ELLIPSOID_RINGS = 16


def load_mjcf(source: str | Path, pose: str | int | None = None) -> Robot:
    """A model of MuJoCo's as a scene, by MuJoCo's own compiler, which takes `pip install atoll[robots]`.

    source: a file (MJCF, or URDF as MuJoCo reads it), or the text of one. pose: the name or number of the keyframe that
    the scene starts in; the model's own reference pose, if left out. The scene has the model's gravity and step, and a
    body for each of its bodies that moves by itself: what is welded to it is part of it. Angles and offsets of joints
    count as in the model. Raises Error if the compiler refuses the model, or the pose isn't one of its own.
    """
    mujoco = _compiler()
    text = str(source)
    compiled = mujoco.MjModel.from_xml_string if text.lstrip().startswith("<") else mujoco.MjModel.from_xml_path
    try:
        model = compiled(text)
    except (ValueError, OSError) as error:
        raise _core.Error(f"load_mjcf: MuJoCo refuses the model: {error}") from None
    return _Reader(mujoco, model, pose).read()


def _compiler() -> Any:
    try:
        return importlib.import_module("mujoco")
    except ImportError:
        raise _core.Error(
            "load_mjcf: there is no module mujoco; expected MuJoCo's compiler: pip install atoll[robots]"
        ) from None


def _xyzw(wxyz: Any) -> Floats:
    return np.roll(np.asarray(wxyz, dtype=np.float64), -1)


class _Reader:
    """Goes through a compiled model, element by element. Names are those of its arrays."""

    def __init__(self, mujoco: Any, model: Any, pose: str | int | None) -> None:
        self.mj, self.m = mujoco, model
        self.data = mujoco.MjData(model)
        self._take_pose(pose)
        mujoco.mj_kinematics(model, self.data)
        mujoco.mj_comPos(model, self.data)
        name = model.names[: model.names.index(b"\0")].decode() or "model"
        self.robot = Robot(name, _core.Scene(name=name), Receipt(name), {})
        self.filters = Filters(mujoco, model)
        self.places: dict[int, int] = {}  # in the scene, of bodies that others are welded to
        self.geoms: dict[int, list[int]] = {}  # of these bodies, those that touch

    def _take_pose(self, pose: str | int | None) -> None:
        m = self.m
        self.data.qpos[:] = m.qpos0
        if pose is None:
            return
        number = self.mj.mj_name2id(m, self.mj.mjtObj.mjOBJ_KEY, pose) if isinstance(pose, str) else pose
        if not 0 <= number < m.nkey:
            names = [self._name("KEY", i) for i in range(m.nkey)]
            raise _core.Error(f"load_mjcf: pose is {pose!r}; expected one of the model's keyframes: {', '.join(names)}")
        self.data.qpos[:] = m.key_qpos[number]

    def _name(self, kind: str, number: int) -> str:
        return self.mj.mj_id2name(self.m, getattr(self.mj.mjtObj, f"mjOBJ_{kind}"), number) or str(number)

    @property
    def _receipt(self) -> Receipt:
        return self.robot.receipt

    def read(self) -> Robot:
        scene, m = self.robot.scene, self.m
        scene.gravity = np.array(m.opt.gravity)
        scene.dt = float(m.opt.timestep)
        self._sort_geoms()
        bodies = self._fixed()
        joints: list[_core.SceneJoint] = []
        for body in range(1, m.nbody):
            if m.body_weldid[body] == body:
                self._add_body(body, bodies, joints)
        scene.bodies, scene.joints = bodies, joints
        for body in range(1, m.nbody):
            root = int(m.body_weldid[body])
            if root in self.places:
                self.robot.bodies[self._name("BODY", body)] = self.places[root]
            if root == body:
                self._receipt.exact("body", self._name("BODY", body))
            else:
                self._receipt.taken_as("body", self._name("BODY", body), f"part of {self._name('BODY', root)}, exactly")
        self._add_actuators()
        self._tell_of_the_rest()
        return self.robot

    # Shapes.

    def _sort_geoms(self) -> None:
        m = self.m
        for geom in range(m.ngeom):
            name = self._name("GEOM", geom)
            if not m.geom_contype[geom] and not m.geom_conaffinity[geom]:
                self._receipt.exact("geom that only shows", name)
                continue
            root = int(m.body_weldid[m.geom_bodyid[geom]])
            self.geoms.setdefault(root, []).append(geom)

    def _material(self, geom: int) -> _core.Material:
        slide, twist, roll = (float(x) for x in self.m.geom_friction[geom])
        condim = int(self.m.geom_condim[geom])
        return _core.Material(
            friction=slide if condim > 1 else 0,
            torsional_friction=twist if condim > 3 else 0,
            rolling_friction=roll if condim > 4 else 0,
        )

    def _shape(self, geom: int) -> _Shape | None:
        """None of a kind that there isn't here. The receipt has its line."""
        kinds, m = self.mj.mjtGeom, self.m
        kind, size, name = int(m.geom_type[geom]), [float(x) for x in m.geom_size[geom]], self._name("GEOM", geom)
        shape: _Shape | None = None
        note = ""
        if kind == kinds.mjGEOM_SPHERE:
            shape = _core.Sphere(size[0])
        elif kind == kinds.mjGEOM_CAPSULE:
            shape = _core.Capsule(size[0], size[1])
        elif kind == kinds.mjGEOM_CYLINDER:
            shape = _core.Cylinder(size[0], size[1])
        elif kind == kinds.mjGEOM_BOX:
            shape = _core.Box(size)
        elif kind == kinds.mjGEOM_PLANE:
            shape = _core.HalfSpace([0, 0, 1], 0)
            if size[0] > 0 or size[1] > 0:
                note = "a plane without end, as MuJoCo collides with it"
        elif kind == kinds.mjGEOM_ELLIPSOID:
            shape = _core.ConvexHull(_ellipsoid(size))
            note = f"a hull of {_ELLIPSOID_RINGS**2} points on it"
        elif kind == kinds.mjGEOM_MESH:
            mesh = int(m.geom_dataid[geom])
            start, count = int(m.mesh_vertadr[mesh]), int(m.mesh_vertnum[mesh])
            hull = _core.ConvexHull(np.array(m.mesh_vert[start : start + count], dtype=np.float64))
            shape = hull
            note = f"the hull of its points, {len(hull.vertices)} of them" + (
                ", fewer than it has" if hull.simplified else ""
            )
        elif kind == kinds.mjGEOM_HFIELD:
            field = int(m.geom_dataid[geom])
            rows, columns = int(m.hfield_nrow[field]), int(m.hfield_ncol[field])
            start = int(m.hfield_adr[field])
            heights = np.array(m.hfield_data[start : start + rows * columns], dtype=np.float64).reshape(rows, columns)
            x, y, z, _ = (float(v) for v in m.hfield_size[field])
            shape = _core.HeightField(heights * z, 2 * x / (columns - 1), 2 * y / (rows - 1))
        if shape is None:
            self._receipt.left_out("geom", name, "a signed distance field")
        elif note:
            self._receipt.taken_as("geom", name, note)
        else:
            self._receipt.exact("geom", name)
        return shape

    def _place(self, geom: int) -> tuple[Floats, Floats]:
        """In the world."""
        quaternion = np.zeros(4)
        self.mj.mju_mat2Quat(quaternion, self.data.geom_xmat[geom])
        turn = _xyzw(quaternion)
        position = np.array(self.data.geom_xpos[geom])
        if int(self.m.geom_type[geom]) == self.mj.mjtGeom.mjGEOM_HFIELD:
            x, y = self.m.hfield_size[int(self.m.geom_dataid[geom])][:2]
            position = position - turned(turn, [x, y, 0])  # its frame is in the corner here
        return position, turn

    def _fixed(self) -> list[_core.SceneBody]:
        """Static bodies, one for each shape that doesn't move."""
        bodies = []
        for geom in self.geoms.get(0, []):
            shape = self._shape(geom)
            if shape is None:
                continue
            position, turn = self._place(geom)
            definition = _core.BodyDef(
                type=_core.BodyType.STATIC,
                shape=shape,
                position=position,
                orientation=turn,
                material=self._material(geom),
                filter=self.filters.of(geom),
            )
            bodies.append(_core.SceneBody(definition=definition))
        return bodies

    def _children(self, body: int) -> list[_core.CompoundChild]:
        """Of a body that moves, in its frame."""
        origin, frame = np.array(self.data.xpos[body]), _xyzw(self.data.xquat[body])
        children = []
        for geom in self.geoms.get(body, []):
            shape = self._shape(geom)
            if shape is None:
                continue
            if isinstance(shape, (_core.HalfSpace, _core.HeightField)):
                self._receipt.left_out("geom", self._name("GEOM", geom), "a surface on a body that moves")
                continue
            position, turn = self._place(geom)
            child = _core.CompoundChild(
                shape=shape,
                position=turned(inverse(frame), position - origin),
                orientation=product(inverse(frame), turn),
                material=self._material(geom),
                filter=self.filters.of(geom),
            )
            children.append(child)
        return children

    # Bodies.

    def _mass(self, body: int) -> tuple[float, Floats, Floats]:
        """kg, m and kg m^2 in the body's frame, of it and what is welded to it."""
        m, data = self.m, self.data
        parts = [part for part in range(m.nbody) if m.body_weldid[part] == body]
        mass = float(sum(m.body_mass[part] for part in parts))
        origin, frame = np.array(data.xpos[body]), np.array(data.xmat[body]).reshape(3, 3)
        if mass == 0:
            return 0, np.zeros(3), np.zeros((3, 3))
        centre = sum(m.body_mass[part] * np.array(data.xipos[part]) for part in parts) / mass
        inertia = np.zeros((3, 3))
        for part in parts:
            axes = np.array(data.ximat[part]).reshape(3, 3)
            arm = np.array(data.xipos[part]) - centre
            inertia += axes @ np.diag(m.body_inertia[part]) @ axes.T
            inertia += m.body_mass[part] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        inertia = frame.T @ inertia @ frame
        return mass, frame.T @ (centre - origin), (inertia + inertia.T) / 2

    def _add_body(self, body: int, bodies: list[_core.SceneBody], joints: list[_core.SceneJoint]) -> None:
        m, name = self.m, self._name("BODY", body)
        mass, centre, inertia = self._mass(body)
        children = self._children(body)
        shape = _core.Compound(children) if children else _core.Sphere(_BEAD)
        if not children:
            self._receipt.taken_as("body", name, f"a ball of {_BEAD} m that touches nothing: it has no shape that does")
        definition = _core.BodyDef(
            shape=shape,
            position=np.array(self.data.xpos[body]),
            orientation=_xyzw(self.data.xquat[body]),
            filter=_core.CollisionFilter(category=1, mask=ALL if children else 0),
        )
        first_joint, count = int(m.body_jntadr[body]), int(m.body_jntnum[body])
        own = [j for j in range(first_joint, first_joint + count) if int(m.jnt_type[j]) != self.mj.mjtJoint.mjJNT_FREE]
        if m.body_mocapid[body] >= 0 or mass == 0:
            definition.type = _core.BodyType.KINEMATIC
            self._receipt.taken_as("body", name, "a kinematic one: it has no mass")
        else:
            self._give_mass(definition, (1 - _BETWEEN * max(len(own) - 1, 0)) * mass, centre, inertia / mass)
            definition.gravity_scale = 1 - float(m.body_gravcomp[body])
        below = self._below(body, bodies) if own else -1
        for joint in own[:-1]:
            between = _core.BodyDef(
                shape=_core.Sphere(_BEAD),
                position=definition.position,
                orientation=definition.orientation,
                filter=_core.CollisionFilter(mask=0),
            )
            self._give_mass(between, _BETWEEN * mass, centre, inertia / mass)
            bodies.append(_core.SceneBody(definition=between))
            self._add_joint(joint, body, below, len(bodies) - 1, bodies, joints)
            note = f"a joint to a body of {_BETWEEN * mass:.3g} kg of {name}'s own that carries the next"
            self._receipt.taken_as("joint", self._name("JOINT", joint), note)
            below = len(bodies) - 1
        bodies.append(_core.SceneBody(name=name, definition=definition))
        self.places[body] = len(bodies) - 1
        if own:
            self._add_joint(own[-1], body, below, len(bodies) - 1, bodies, joints)

    @staticmethod
    def _give_mass(definition: _core.BodyDef, mass: float, centre: Floats, per_mass: Floats) -> None:
        definition.mass = mass
        definition.inertia = mass * per_mass
        definition.centre_of_mass = centre

    def _below(self, body: int, bodies: list[_core.SceneBody]) -> int:
        """The place of what carries a body; of the world, a body that nothing touches."""
        parent = int(self.m.body_weldid[self.m.body_parentid[body]])
        if parent not in self.places:
            definition = _core.BodyDef(
                type=_core.BodyType.STATIC, shape=_core.Sphere(_BEAD), filter=_core.CollisionFilter(mask=0)
            )
            bodies.append(_core.SceneBody(definition=definition))
            self.places[parent] = len(bodies) - 1
        return self.places[parent]

    # Joints.

    def _add_joint(
        self,
        joint: int,
        body: int,
        first: int,
        second: int,
        bodies: list[_core.SceneBody],
        joints: list[_core.SceneJoint],
    ) -> None:
        m, kinds = self.m, self.mj.mjtJoint
        name, kind = self._name("JOINT", joint), int(m.jnt_type[joint])
        anchor, axis = np.array(self.data.xanchor[joint]), np.array(self.data.xaxis[joint])
        value = float(self.data.qpos[m.jnt_qposadr[joint]])
        turn = turn_to(axis)
        at_first, at_second, turn_second = anchor, anchor, turn
        of: _core.BallJoint | _core.HingeJoint | _core.SliderJoint
        if kind == kinds.mjJNT_BALL:
            of = self._ball(joint, name)
        elif kind == kinds.mjJNT_HINGE:
            of = _core.HingeJoint(self._axis(joint, name))
            turn_second = product(turn, [math.sin(value / 2), 0, 0, math.cos(value / 2)])
            self.robot.coordinates.append(Coordinate(name, len(joints), "hinge"))
        else:
            of = _core.SliderJoint(self._axis(joint, name))
            at_first = anchor - value * axis
            self.robot.coordinates.append(Coordinate(name, len(joints), "slide"))

        def frame(place: int, position: Floats, orientation: Floats) -> _core.Pose:
            body_def = bodies[place].definition
            back = inverse(body_def.orientation)
            return _core.Pose(turned(back, position - np.asarray(body_def.position)), product(back, orientation))

        definition = _core.JointDef(
            kind=of,
            frame_first=frame(first, at_first, turn),
            frame_second=frame(second, at_second, turn_second),
            # The world may be touched by a body that a joint holds to it.
            collide=self.filters.parents_touch or int(m.body_weldid[m.body_parentid[body]]) == 0,
        )
        joints.append(_core.SceneJoint(name=name, definition=definition, first=first, second=second))

    def _ball(self, joint: int, name: str) -> _core.BallJoint:
        m, dof = self.m, int(self.m.jnt_dofadr[joint])
        left_out = [
            word
            for word, there in (
                ("damping", m.dof_damping[dof]),
                ("stiffness", m.jnt_stiffness[joint]),
                ("armature", m.dof_armature[dof]),
                ("range", m.jnt_limited[joint]),
            )
            if there
        ]
        if left_out:
            self._receipt.left_out("joint", name, f"the {', '.join(left_out)} of a ball joint")
        else:
            self._receipt.exact("joint", name)
        return _core.BallJoint(float(m.dof_frictionloss[dof]))

    def _axis(self, joint: int, name: str) -> _core.JointAxis:
        m, dof = self.m, int(self.m.jnt_dofadr[joint])
        axis = _core.JointAxis(armature=float(m.dof_armature[dof]))
        if m.jnt_limited[joint]:
            axis.range = _core.JointRange(float(m.jnt_range[joint][0]), float(m.jnt_range[joint][1]))
        stiffness, damping = float(m.jnt_stiffness[joint]), float(m.dof_damping[dof])
        if stiffness > 0 or damping > 0:
            rest = float(m.qpos_spring[m.jnt_qposadr[joint]])
            axis.spring = _core.JointSpring(stiffness=stiffness, damping=damping, rest=rest)
        if m.dof_frictionloss[dof] > 0:
            axis.motor = _core.JointMotor(max_force=float(m.dof_frictionloss[dof]))
        if np.any(m.jnt_stiffnesspoly[joint]) or np.any(m.dof_dampingpoly[dof]):
            self._receipt.left_out("joint", name, "the part of its stiffness or damping that isn't linear")
        else:
            self._receipt.exact("joint", name)
        return axis

    # Actuators.

    def _add_actuators(self) -> None:
        m, mj = self.m, self.mj
        places = {c.name: place for place, c in enumerate(self.robot.coordinates)}
        joints = list(self.robot.scene.joints)
        for number in range(m.nu):
            name = self._name("ACTUATOR", number)
            if int(m.actuator_trntype[number]) not in (mj.mjtTrn.mjTRN_JOINT, mj.mjtTrn.mjTRN_JOINTINPARENT):
                self._receipt.left_out("actuator", name, "it acts on no joint")
                continue
            joint = int(m.actuator_trnid[number][0])
            place = places.get(self._name("JOINT", joint))
            if place is None:
                self._receipt.left_out("actuator", name, "it acts on a ball or free joint")
                continue
            if int(m.actuator_dyntype[number]) != mj.mjtDyn.mjDYN_NONE:
                self._receipt.left_out("actuator", name, "it has dynamics of its own")
                continue
            gain, bias = int(m.actuator_gaintype[number]), int(m.actuator_biastype[number])
            if gain != mj.mjtGain.mjGAIN_FIXED or bias not in (mj.mjtBias.mjBIAS_NONE, mj.mjtBias.mjBIAS_AFFINE):
                self._receipt.left_out("actuator", name, "its gain isn't fixed, or its bias not affine")
                continue
            actuator = self._actuator(number, joint, name, place)
            self.robot.actuators.append(actuator)
            self._drive(joints[self.robot.coordinates[place].joint], actuator, name)
        self.robot.scene.joints = joints

    def _actuator(self, number: int, joint: int, name: str, place: int) -> Actuator:
        m = self.m
        gear = float(m.actuator_gear[number][0])
        gain = gear * float(m.actuator_gainprm[number][0])
        bias, by_position, by_rate = (0.0, 0.0, 0.0)
        if int(m.actuator_biastype[number]) == self.mj.mjtBias.mjBIAS_AFFINE:
            bias, by_position, by_rate = (float(x) for x in m.actuator_biasprm[number][:3])
        limits = [math.inf]
        for limited, ends, scale in (
            (m.actuator_forcelimited[number], m.actuator_forcerange[number], abs(gear)),
            (m.jnt_actfrclimited[joint], m.jnt_actfrcrange[joint], 1.0),
        ):
            if limited:
                limits.append(scale * min(abs(float(ends[0])), abs(float(ends[1]))))
                if ends[0] != -ends[1]:
                    note = f"its force in [{ends[0]}, {ends[1]}] within the smaller of both"
                    self._receipt.taken_as("actuator", name, note)
        controls = (-math.inf, math.inf)
        if m.actuator_ctrllimited[number]:
            controls = (float(m.actuator_ctrlrange[number][0]), float(m.actuator_ctrlrange[number][1]))
        return Actuator(
            name=name,
            coordinate=place,
            kind="position" if by_position < 0 else "velocity" if by_rate < 0 else "force",
            gain=gain,
            bias=gear * bias,
            stiffness=-gear * gear * by_position,
            damping=-gear * gear * by_rate,
            limit=min(limits),
            range=controls,
        )

    def _drive(self, joint: _core.SceneJoint, actuator: Actuator, name: str) -> None:
        if actuator.kind == "force":
            self._receipt.taken_as("actuator", name, "a force that Robot.control() gives to each step")
            return
        definition = joint.definition
        kind = definition.kind
        assert isinstance(kind, (_core.HingeJoint, _core.SliderJoint))
        axis = kind.angle if isinstance(kind, _core.HingeJoint) else kind.offset
        motor = axis.motor
        if motor is not None and motor.servo is not None:
            self._receipt.left_out("actuator", name, "another one has its joint")
            return
        if motor is not None:
            note = f"{motor.max_force:.3g} N or N m of friction, beside the servo of {actuator.name}"
            self._receipt.left_out("friction", joint.name, note)
        else:
            self._receipt.exact("actuator", name)
        servo = _core.JointServo(
            target=actuator.bias / actuator.stiffness if actuator.kind == "position" else 0.0,
            stiffness=actuator.stiffness,
            damping=actuator.damping,
        )
        axis.motor = _core.JointMotor(max_force=actuator.limit, servo=servo)
        definition.kind = _core.HingeJoint(axis) if isinstance(kind, _core.HingeJoint) else _core.SliderJoint(axis)
        joint.definition = definition

    def _tell_of_the_rest(self) -> None:
        m = self.m
        if np.any(m.geom_contype) or np.any(m.geom_conaffinity):
            self._receipt.taken_as("contacts", "all", _SOFT)
            self._receipt.taken_as("friction", "all", _FRICTION)
        for note in self.filters.left_out:
            self._receipt.left_out("exclude", "", note)
        for number in range(m.neq):
            self._receipt.left_out("equality", self._name("EQUALITY", number), "couplings are not read yet")
        for number in range(m.ntendon):
            self._receipt.left_out("tendon", self._name("TENDON", number), "tendons are not read yet")
        for number in range(m.npair):
            self._receipt.left_out("pair", str(number), "contacts of their own are not read yet")
        for number in range(m.nsensor):
            self._receipt.left_out("sensor", self._name("SENSOR", number), "sensors are not read yet")
        for number in range(m.nflex):
            self._receipt.left_out("flex", str(number), "bodies are rigid here")
        if m.opt.density or m.opt.viscosity:
            self._receipt.left_out("option", "density, viscosity", "there is no fluid here")


def _ellipsoid(half_axes: list[float]) -> Floats:
    """Points on it, as many along as around."""
    around = np.arange(_ELLIPSOID_RINGS) * 2 * math.pi / _ELLIPSOID_RINGS
    height = -1 + (np.arange(_ELLIPSOID_RINGS) + 0.5) * 2 / _ELLIPSOID_RINGS
    width = np.sqrt(1 - height**2)
    points = [[w * math.cos(a), w * math.sin(a), h] for h, w in zip(height, width, strict=True) for a in around]
    return np.array(points, dtype=np.float64) * np.array(half_axes, dtype=np.float64)
