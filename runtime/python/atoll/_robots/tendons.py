"""Fixed tendons and equalities of joints of a compiled model, which couple coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import Polynomial

from .. import _core
from .bodies import Bodies
from .compiled import Compiled

_MOST_TERMS = 4
_RIGID = "a tendon, which is rigid: solref and solimp do nothing"


class Tendons:
    """Adds the tendons of a scene. Angles and offsets of joints count in it as in the model."""

    def __init__(self, model: Compiled, bodies: Bodies) -> None:
        self.model, self.bodies = model, bodies
        self.places: dict[int, int] = {}  # in the scene, by number of the model's tendon
        for number in range(model.arrays.ntendon):
            self._add_tendon(number)

    def add_equality(self, number: int, name: str) -> None:
        """Has a joint follow a polynomial of another, both counted from where the model has them at first."""
        m = self.model.arrays
        leader, follower = int(m.eq_obj2id[number]), int(m.eq_obj1id[number])
        factors = np.array(m.eq_data[number][:5])
        parts = [(follower, np.array([-self._at_first(follower), 1.0]))]
        if leader >= 0:
            since = Polynomial([-self._at_first(leader), 1.0])
            parts.append((leader, -Polynomial(factors)(since).coef))
        else:
            parts[0][1][0] -= factors[0]
        # A leader by which nothing changes is none.
        moving = [part for part in parts if np.any(part[1][1:])]
        moving[0][1][0] += sum(part[1][0] for part in parts if not np.any(part[1][1:]))
        axis = _core.JointAxis(range=_core.JointRange(0, 0))
        why_not = self._add(name, moving, axis)
        if why_not:
            self.model.receipt.left_out("equality", name, why_not)
        else:
            self.model.receipt.taken_as("equality", name, _RIGID)

    def _add_tendon(self, number: int) -> None:
        m, receipt, name = self.model.arrays, self.model.receipt, self.model.name("TENDON", number)
        wraps = range(int(m.tendon_adr[number]), int(m.tendon_adr[number]) + int(m.tendon_num[number]))
        if any(int(m.wrap_type[wrap]) != self.model.mujoco.mjtWrap.mjWRAP_JOINT for wrap in wraps):
            receipt.left_out("tendon", name, "it winds: tendons of a scene are sums of coordinates")
            return
        place = len(self.bodies.joints.scene)
        parts = [(int(m.wrap_objid[wrap]), np.array([0.0, float(m.wrap_prm[wrap])])) for wrap in wraps]
        why_not = self._add(name, [part for part in parts if part[1][1]], self._axis(number, name))
        if why_not:
            receipt.left_out("tendon", name, why_not)
            return
        self.places[number] = place

    def _axis(self, number: int, name: str) -> _core.JointAxis:
        m = self.model.arrays
        axis = _core.JointAxis(
            friction=float(m.tendon_frictionloss[number]), armature=float(m.tendon_armature[number])
        )
        if m.tendon_limited[number]:
            lower, upper = (float(end) for end in m.tendon_range[number])
            axis.range = _core.JointRange(lower, upper)
        stiffness, damping = float(m.tendon_stiffness[number]), float(m.tendon_damping[number])
        lower, upper = (float(end) for end in m.tendon_lengthspring[number])
        slack = stiffness > 0 and lower < upper
        if stiffness > 0 or damping > 0:
            rest = (lower + upper) / 2
            axis.spring = _core.JointSpring(stiffness=0 if slack else stiffness, damping=damping, rest=rest)
        if slack:
            self.model.receipt.left_out("tendon", name, "its spring, which is slack over a part of its length")
        elif any(np.any(getattr(m, f"tendon_{what}poly")[number]) for what in ("stiffness", "damping")):
            self.model.receipt.left_out("tendon", name, "the part of its stiffness or damping that isn't linear")
        else:
            self.model.receipt.exact("tendon", name)
        return axis

    def _at_first(self, joint: int) -> float:
        m = self.model.arrays
        return float(m.qpos0[m.jnt_qposadr[joint]])

    def _add(self, name: str, parts: Sequence[tuple[int, np.ndarray]], axis: _core.JointAxis) -> str:
        """Adds a sum of polynomials of joints' coordinates. Returns why it can't be, or nothing."""
        scene = self.bodies.joints.scene
        if not 0 < len(parts) <= _MOST_TERMS:
            return f"it runs over {len(parts)} joints; tendons of a scene over 1 to {_MOST_TERMS}"
        coordinates = {c.name: c for c in self.bodies.joints.coordinates}
        joints = [self.model.name("JOINT", joint) for joint, _ in parts]
        if any(joint not in coordinates for joint in joints):
            return "one of its joints is a ball, or free, or couldn't be read"
        over = [coordinates[joint] for joint in joints]
        terms = [
            _core.TendonTerm(coordinate=c.axis, polynomial=list(np.pad(f, (0, 5 - len(f)))))
            for c, (_, f) in zip(over, parts, strict=True)
        ]
        of = scene[over[0].joint]
        definition = _core.JointDef(kind=_core.TendonJoint(terms, axis), collide=True)
        scene.append(
            _core.SceneJoint(
                name=self._own_name(name),
                definition=definition,
                first=of.first,
                second=of.second,
                terms=[c.joint for c in over],
            )
        )
        return ""

    def _own_name(self, name: str) -> str:
        """Names of a scene's joints are each one's own; those of a model by kind of element."""
        taken = {joint.name for joint in self.bodies.joints.scene}
        return "" if name in taken else name
