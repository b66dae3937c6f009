"""Bodies of a compiled model: what moves by itself, with all that is welded to it."""

from __future__ import annotations

import numpy as np

from .. import _core
from .compiled import Compiled, xyzw
from .filters import ALL, Filters
from .groups import groups_of
from .joints import Joints
from .quaternions import Floats
from .shapes import Shapes

_BEAD = 0.01  # m, of bodies that nothing touches
_BETWEEN = 1e-3  # of a body's mass, for each body between it and the one that carries it, where joints are no group


class Bodies:
    """Makes the bodies of a scene, and the joints that carry them."""

    def __init__(self, model: Compiled, filters: Filters, hull_error: float | None) -> None:
        self.model = model
        self.shapes = Shapes(model, filters, hull_error)
        self.scene = self.shapes.fixed()
        self.joints = Joints(model, filters, self.scene)
        self.places: dict[int, int] = {}  # in the scene, of bodies that others are welded to
        m = model.arrays
        for body in range(1, m.nbody):
            if m.body_weldid[body] == body:
                self._add_body(body)

    def _mass(self, body: int) -> tuple[float, Floats, Floats]:
        """kg, m and kg m^2 in the body's frame, of it and what is welded to it."""
        m, data = self.model.arrays, self.model.data
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

    def _add_body(self, body: int) -> None:
        m, name = self.model.arrays, self.model.name("BODY", body)
        mass, centre, inertia = self._mass(body)
        children = self.shapes.children(body)
        shape = _core.Compound(children) if children else _core.Sphere(_BEAD)
        if not children:
            self.model.receipt.taken_as(
                "body", name, f"a ball of {_BEAD} m that touches nothing: it has no shape that does"
            )
        definition = _core.BodyDef(
            shape=shape,
            position=np.array(self.model.data.xpos[body]),
            orientation=xyzw(self.model.data.xquat[body]),
            filter=_core.CollisionFilter(category=1, mask=ALL if children else 0),
        )
        first_joint, count = int(m.body_jntadr[body]), int(m.body_jntnum[body])
        own = [
            j
            for j in range(first_joint, first_joint + count)
            if int(m.jnt_type[j]) != self.model.mujoco.mjtJoint.mjJNT_FREE
        ]
        parts = list(groups_of(self.model, own))
        if m.body_mocapid[body] >= 0 or mass == 0:
            definition.type = _core.BodyType.KINEMATIC
            self.model.receipt.taken_as("body", name, "a kinematic one: it has no mass")
        else:
            self._give_mass(definition, (1 - _BETWEEN * max(len(parts) - 1, 0)) * mass, centre, inertia / mass)
            definition.gravity_scale = 1 - float(m.body_gravcomp[body])
        below = self.place_of(m.body_parentid[body]) if own else -1
        for part in parts[:-1]:
            between = _core.BodyDef(
                shape=_core.Sphere(_BEAD),
                position=definition.position,
                orientation=definition.orientation,
                filter=_core.CollisionFilter(mask=0),
            )
            self._give_mass(between, _BETWEEN * mass, centre, inertia / mass)
            self.scene.append(_core.SceneBody(definition=between))
            name_of = self.joints.add(part, body, below, len(self.scene) - 1)
            note = f"a joint to a body of {_BETWEEN * mass:.3g} kg of {name}'s own that carries the next"
            self.model.receipt.taken_as("joint", name_of, note)
            below = len(self.scene) - 1
        self.scene.append(_core.SceneBody(name=name, definition=definition))
        self.places[body] = len(self.scene) - 1
        if parts:
            self.joints.add(parts[-1], body, below, len(self.scene) - 1)

    @staticmethod
    def _give_mass(definition: _core.BodyDef, mass: float, centre: Floats, per_mass: Floats) -> None:
        definition.mass = mass
        definition.inertia = mass * per_mass
        definition.centre_of_mass = centre

    def place_of(self, body: int) -> int:
        """In the scene; of what is welded to the world, a body that nothing touches."""
        root = int(self.model.arrays.body_weldid[body])
        if root not in self.places:
            definition = _core.BodyDef(
                type=_core.BodyType.STATIC, shape=_core.Sphere(_BEAD), filter=_core.CollisionFilter(mask=0)
            )
            self.scene.append(_core.SceneBody(definition=definition))
            self.places[root] = len(self.scene) - 1
        return self.places[root]
