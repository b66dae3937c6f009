"""Equalities of a compiled model, as joints and tendons."""

from __future__ import annotations

import numpy as np

from .. import _core
from .bodies import Bodies
from .compiled import Compiled, xyzw
from .quaternions import Floats, product, turned
from .tendons import Tendons

_RIGID = "which is rigid: solref, solimp and torquescale do nothing"


class Equalities:
    """Adds the joints that close loops, hold bodies together, or have one joint follow another."""

    def __init__(self, model: Compiled, bodies: Bodies, tendons: Tendons) -> None:
        self.model, self.bodies, self.tendons = model, bodies, tendons
        for number in range(model.arrays.neq):
            self._add(number)

    def _add(self, number: int) -> None:
        m, kinds, receipt = self.model.arrays, self.model.mujoco.mjtEq, self.model.receipt
        name, kind = self._name(number), int(m.eq_type[number])
        if kind not in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD, kinds.mjEQ_JOINT):
            receipt.left_out("equality", name, "it is of tendons or flexes, which no joint of a scene holds")
            return
        if not m.eq_active0[number]:
            receipt.left_out("equality", name, "it is not active at first")
            return
        if kind == kinds.mjEQ_JOINT:
            self.tendons.add_equality(number, name)
            return
        weld = kind == kinds.mjEQ_WELD
        (first, frame_first), (second, frame_second) = self._ends(number, weld)
        if first == second:
            receipt.exact("equality", name)  # between parts of one body
            return
        types = [self.bodies.scene[place].definition.type for place in (first, second)]
        if _core.BodyType.DYNAMIC not in types:
            receipt.left_out("equality", name, "neither of its bodies is moved by forces")
            return
        definition = _core.JointDef(
            kind=_core.FixedJoint() if weld else _core.BallJoint(),
            frame_first=frame_first,
            frame_second=frame_second,
            collide=True,
        )
        self.bodies.joints.scene.append(_core.SceneJoint(name=name, definition=definition, first=first, second=second))
        receipt.taken_as("equality", name, f"a {'fixed' if weld else 'ball'} joint, {_RIGID}")

    def _name(self, number: int) -> str:
        """Its own, or those of the two that it is about."""
        m = self.model.arrays
        name = self.model.name("EQUALITY", number)
        if name != str(number):
            return name
        kind = "JOINT" if int(m.eq_type[number]) == self.model.mujoco.mjtEq.mjEQ_JOINT else "BODY"
        if kind == "BODY" and int(m.eq_objtype[number]) != self.model.mujoco.mjtObj.mjOBJ_BODY:
            return name
        both = (int(m.eq_obj1id[number]), int(m.eq_obj2id[number]))
        return " and ".join(self.model.name(kind, one) for one in both if one >= 0)

    def _ends(self, number: int, weld: bool) -> list[tuple[int, _core.Pose]]:
        """Places in the scene, and the frames that are to come together in the bodies there."""
        m, unturned = self.model.arrays, np.array([0.0, 0.0, 0.0, 1.0])
        ids = (int(m.eq_obj1id[number]), int(m.eq_obj2id[number]))
        if int(m.eq_objtype[number]) == self.model.mujoco.mjtObj.mjOBJ_SITE:
            return [self._end(int(m.site_bodyid[s]), m.site_pos[s], xyzw(m.site_quat[s])) for s in ids]
        data = m.eq_data[number]
        if not weld:
            return [self._end(body, data[3 * n : 3 * n + 3], unturned) for n, body in enumerate(ids)]
        return [self._end(ids[0], data[3:6], xyzw(data[6:10])), self._end(ids[1], data[:3], unturned)]

    def _end(self, body: int, position: Floats, turn: Floats) -> tuple[int, _core.Pose]:
        place = self.bodies.place_of(body)
        offset, frame = self.model.in_root(body)
        return place, _core.Pose(offset + turned(frame, position), product(frame, turn))
