"""Which shapes of a compiled model may touch, as categories and masks."""

from __future__ import annotations

from typing import Any

from .. import _core

ALL = 0xFFFFFFFF  #: the mask of what may touch anything
_OTHERS = 1  # the category of bodies that are not of the model, with which all shapes may collide
_MOST = 31  # classes, a bit each beside that


class Filters:
    """MuJoCo lets two shapes touch if the contype of either has a bit of the other's conaffinity, unless their bodies
    are excluded, or one carries the other by joints. Shapes that are alike in all are a class here, with a bit of its
    own."""

    def __init__(self, mujoco: Any, model: Any) -> None:
        self.model = model
        self.parents_touch = bool(model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
        self.left_out: list[str] = []
        excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature}
        weld = [int(w) for w in model.body_weldid]
        self._excluded = {frozenset((weld[a], weld[b])) for a, b in excluded} | self._carried(weld)
        self._classes: dict[tuple[int, int, int], int] = {}
        for geom in self._geoms():
            self._classes.setdefault(self._class(geom), len(self._classes))
        if len(self._classes) > _MOST:
            kinds = f"their shapes are of {len(self._classes)} kinds, and there is room for {_MOST}"
            self.left_out.append(f"all {len(excluded)}: {kinds}")
            self._excluded.clear()
            self._classes.clear()
            for geom in self._geoms():
                self._classes.setdefault(self._class(geom), min(len(self._classes), _MOST - 1))
            if len(self._classes) > _MOST:
                self.left_out.append(f"contype and conaffinity tell {len(self._classes)} kinds apart: the last are one")

    def _carried(self, weld: list[int]) -> set[frozenset[int]]:
        """What several joints in a row hold to its parent: no one of these says that the two don't touch."""
        m = self.model
        if self.parents_touch:
            return set()
        several = {body: weld[m.body_parentid[body]] for body in set(weld) if m.body_jntnum[body] > 1}
        return {frozenset(pair) for pair in several.items() if pair[1] != 0}

    def _geoms(self) -> list[int]:
        m = self.model
        return [g for g in range(m.ngeom) if m.geom_contype[g] or m.geom_conaffinity[g]]

    def _class(self, geom: int) -> tuple[int, int, int]:
        """contype, conaffinity, and the body if any is excluded from touching it."""
        m = self.model
        body = int(m.body_weldid[m.geom_bodyid[geom]])
        named = any(body in pair for pair in self._excluded)
        return int(m.geom_contype[geom]), int(m.geom_conaffinity[geom]), body if named else -1

    def _touch(self, a: tuple[int, int, int], b: tuple[int, int, int]) -> bool:
        return bool(a[0] & b[1] or b[0] & a[1]) and frozenset((a[2], b[2])) not in self._excluded

    def of(self, geom: int) -> _core.CollisionFilter:
        own = self._class(geom)
        mask = _OTHERS + sum(1 << bit + 1 for other, bit in self._classes.items() if self._touch(own, other))
        return _core.CollisionFilter(category=1 << self._classes[own] + 1, mask=mask)
