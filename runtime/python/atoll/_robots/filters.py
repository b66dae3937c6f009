"""Which shapes of a compiled model may touch, as categories and masks."""

from __future__ import annotations

from collections import Counter
from typing import Any

from .. import _core

ALL = 0xFFFFFFFF  #: the mask of what may touch anything
_OTHERS = 1  # the category of bodies that are not of the model, with which all shapes may collide
_MOST = 31  # classes, a bit each beside that

_Class = tuple[int, int, int, int]


class Filters:
    """MuJoCo lets two shapes touch if the contype of either has a bit of the other's conaffinity, unless their bodies
    are excluded, or one carries the other by joints. Shapes of one contype and conaffinity are a class here, with a bit
    of its own. Of two bodies that are excluded one has classes of its own, which are not in the other's mask. Each shape
    of a `pair` is a class by itself, and in its partner's mask whatever else says that the two don't touch."""

    def __init__(self, mujoco: Any, model: Any) -> None:
        self.model = model
        self.parents_touch = bool(model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
        self.left_out: list[str] = []
        named = [(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature]
        weld = [int(w) for w in model.body_weldid]
        self._excluded = {frozenset((weld[a], weld[b])) for a, b in named} | self._carried(weld)
        self._partners: dict[int, set[int]] = {}  # of shapes that are in pairs
        for one, other in zip(map(int, model.pair_geom1), map(int, model.pair_geom2), strict=True):
            self._partners.setdefault(one, set()).add(other)
            self._partners.setdefault(other, set()).add(one)
        self._own: set[int] = set()  # bodies that have classes of their own
        self._classes = self._classes_with(self._own)
        if len(self._classes) > _MOST:
            self.left_out.append(f"contype and conaffinity tell {len(self._classes)} kinds apart: the last are one")
            self._classes = {kind: min(bit, _MOST - 1) for kind, bit in self._classes.items()}
        self._choose()

    def _carried(self, weld: list[int]) -> set[frozenset[int]]:
        """What several joints in a row hold to its parent: no one of these says that the two don't touch."""
        m = self.model
        if self.parents_touch:
            return set()
        several = {body: weld[m.body_parentid[body]] for body in set(weld) if m.body_jntnum[body] > 1}
        return {frozenset(pair) for pair in several.items() if pair[1] != 0}

    def _choose(self) -> None:
        """Gives classes of their own to bodies until each excluded pair has one such, the most excluded body first."""
        left = {pair for pair in self._excluded if len(pair) == 2}
        while left:
            count = Counter(body for pair in left for body in pair)
            body = min(count, key=lambda one: (-count[one], one))
            classes = self._classes_with({*self._own, body})
            if len(classes) > _MOST:
                self.left_out.append(f"{len(left)} pairs: they take more classes of shapes than the {_MOST} there are")
                self._excluded -= left
                return
            self._own.add(body)
            self._classes = classes
            left = {pair for pair in left if body not in pair}

    def _classes_with(self, own: set[int]) -> dict[_Class, int]:
        """Numbers of the classes, where these bodies have their own."""
        classes: dict[_Class, int] = {}
        for geom in range(self.model.ngeom):
            if self.touches(geom):
                classes.setdefault(self._class(geom, own), len(classes))
        return classes

    def _class(self, geom: int, own: set[int]) -> _Class:
        """contype, conaffinity, the body if it has classes of its own, and the shape if it has one."""
        m = self.model
        body = int(m.body_weldid[m.geom_bodyid[geom]])
        shape = geom if geom in self._partners else -1
        return int(m.geom_contype[geom]), int(m.geom_conaffinity[geom]), body if body in own else -1, shape

    def touches(self, geom: int) -> bool:
        """Whether a shape may touch any."""
        return bool(self.model.geom_contype[geom] or self.model.geom_conaffinity[geom] or geom in self._partners)

    def of(self, geom: int) -> _core.CollisionFilter:
        contype, conaffinity, _, _ = kind = self._class(geom, self._own)
        body = int(self.model.body_weldid[self.model.geom_bodyid[geom]])
        mask = _OTHERS if contype or conaffinity else 0
        for (other_contype, other_conaffinity, other, shape), bit in self._classes.items():
            match = contype & other_conaffinity or other_contype & conaffinity
            excluded = frozenset((body, other)) in self._excluded
            if match and not excluded or shape in self._partners.get(geom, ()):
                mask |= 1 << bit + 1
        return _core.CollisionFilter(category=1 << self._classes[kind] + 1, mask=mask)

    def may_meet(self, one: int, other: int) -> bool:
        """Whether their filters let two shapes of a pair touch, and no joint connects their bodies."""
        m = self.model
        bodies = {int(m.body_weldid[m.geom_bodyid[geom]]) for geom in (one, other)}
        carriers = {int(m.body_weldid[m.body_parentid[body]]) for body in bodies if m.body_jntnum[body]} - {0}
        first, second = self.of(one), self.of(other)
        let = bool(first.mask & second.category and second.mask & first.category)
        return let and (self.parents_touch or len(bodies) == 2 and not bodies & carriers)
