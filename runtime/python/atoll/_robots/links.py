"""Links of a URDF, as clusters that fixed joints make, and repairs of their masses and inertias."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np

from .. import _core
from .inertia import moments_of, nearest
from .quaternions import Floats
from .receipt import Receipt

_SHARE = 1e-3  # of the mass that it carries, for a link that moves and has none
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


class Links:
    """Repairs the inertials of a document in place, and tells a receipt."""

    def __init__(self, root: ElementTree.Element, receipt: Receipt) -> None:
        self.root, self.receipt = root, receipt
        self.links = {link.get("name", ""): link for link in root.findall("link")}
        self.above: dict[str, ElementTree.Element] = {}  # the joint of each link that has a parent
        for joint in root.findall("joint"):
            for end in ("parent", "child"):
                if self._end(joint, end) not in self.links:
                    message = f"{end} of {joint.get('name')} is {self._end(joint, end)!r}; expected the name of a link"
                    raise _core.Error(f"load_urdf: {message}")
            self.above[self._end(joint, "child")] = joint
        bases = [name for name in self.links if name not in self.above]
        if len(bases) != 1:
            raise _core.Error(f"load_urdf: links without a parent are {bases}; expected one, and no loops")
        self.base = bases[0]
        self.masses: dict[str, float] = {}
        self.moments: dict[str, float] = {}  # kg m^2, the mean principal moment

    def repair(self) -> None:
        for name, link in self.links.items():
            self._repair(name, link)
        self._place_massless()

    def free_base(self) -> None:
        """Lets the first link move, unless that is the world itself."""
        if self.base == "world":
            return
        if sum(self.masses.values()) == 0:
            self.receipt.taken_as("base", self.base, "a fixed one: nothing of the robot has a mass")
            return
        joint = ElementTree.SubElement(self.root, "joint", name=f"{self.base}_free", type="floating")
        ElementTree.SubElement(joint, "parent", link=self._world())
        ElementTree.SubElement(joint, "child", link=self.base)

    def free_floating(self) -> None:
        """Hangs links that float from others on the world, where these start: MuJoCo has free bodies there only."""
        for name, joint in self.above.items():
            if joint.get("type") != "floating" or self._end(joint, "parent") == "world":
                continue
            position, turn = self._start(name)
            parent, origin = joint.find("parent"), joint.find("origin")
            assert parent is not None
            parent.set("link", self._world())
            origin = ElementTree.SubElement(joint, "origin") if origin is None else origin
            origin.set("xyz", " ".join(map(repr, position.tolist())))
            origin.set("rpy", " ".join(map(repr, _roll_pitch_yaw(turn).tolist())))

    def _start(self, name: str) -> tuple[Floats, Floats]:
        """Where a link is in the base, m, and how it is turned, as a matrix, while all joints are at 0."""
        position, turn = np.zeros(3), np.eye(3)
        while name in self.above:
            origin = self.above[name].find("origin")
            own = _rotation(_vector(origin, "rpy", name))
            position, turn = _vector(origin, "xyz", name) + own @ position, own @ turn
            name = self._end(self.above[name], "parent")
        return position, turn

    def _world(self) -> str:
        if self.base != "world" and self.root.find("link[@name='world']") is None:
            ElementTree.SubElement(self.root, "link", name="world")
        return "world"

    @staticmethod
    def _end(joint: ElementTree.Element, end: str) -> str:
        found = joint.find(end)
        return "" if found is None else found.get("link", "")

    def _repair(self, name: str, link: ElementTree.Element) -> None:
        """Leaves a link with an inertial that a body can have, or without one."""
        self.masses[name] = self.moments[name] = 0.0
        inertial = link.find("inertial")
        if inertial is None:
            return
        mass = number(inertial.find("mass"), "value", name)
        tensor = inertial.find("inertia")
        xx, xy, xz, yy, yz, zz = (number(tensor, key, name) for key in _MOMENTS)
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if mass <= 0:
            link.remove(inertial)
            if mass < 0 or np.any(inertia):
                given = f"a mass of {mass:g} kg and moments of {moments_of(inertia)} kg m^2"
                self.receipt.taken_as("inertial", name, f"none, from {given}")
            return
        repaired, wrong = nearest(inertia, mass)
        if wrong:
            note = f"moments of {moments_of(repaired)} kg m^2, from {moments_of(inertia)}: {wrong}"
            self.receipt.taken_as("inertial", name, note)
            if tensor is None:
                tensor = ElementTree.SubElement(inertial, "inertia")
            _set_moments(tensor, repaired)
        self.masses[name], self.moments[name] = mass, float(np.trace(repaired)) / 3

    def _place_massless(self) -> None:
        """Joins what moves no mass to its parent, and gives what has none but carries some a share of that."""
        heads = {name: self._head(name) for name in self.links}
        own = {head: 0.0 for head in heads.values()}
        for name, mass in self.masses.items():
            own[heads[name]] += mass
        below: dict[str, list[str]] = {head: [] for head in own}
        for head in own:
            if head in self.above:
                below[heads[self._end(self.above[head], "parent")]].append(head)
        for head in own:
            if own[head] > 0 or head == self.base == "world":
                continue
            carried = self._carried(head, own, below)
            joint = self.above.get(head)
            if carried:
                mass = _SHARE * sum(own[other] for other in carried)
                moment = _SHARE * sum(self.moments[n] for n, h in heads.items() if h in carried)
                self._give(head, mass, moment)
            elif joint is not None:
                parent = self._end(joint, "parent")
                self.receipt.left_out(
                    "joint", joint.get("name", ""), f"{head} has no mass and carries none: part of {parent}"
                )
                joint.set("type", "fixed")

    def _head(self, name: str) -> str:
        """The first link of those that are fixed together."""
        seen = 0
        while name in self.above and self.above[name].get("type") == "fixed":
            name, seen = self._end(self.above[name], "parent"), seen + 1
            if seen > len(self.links):
                raise _core.Error(f"load_urdf: {name} is above itself; expected links in a tree")
        return name

    @staticmethod
    def _carried(head: str, own: dict[str, float], below: dict[str, list[str]]) -> list[str]:
        """The nearest that have masses."""
        found, left = [], list(below[head])
        while left:
            other = left.pop()
            if own[other] > 0:
                found.append(other)
            else:
                left += below[other]
        return found

    def _give(self, name: str, mass: float, moment: float) -> None:
        inertial = ElementTree.SubElement(self.links[name], "inertial")
        ElementTree.SubElement(inertial, "mass", value=repr(mass))
        _set_moments(ElementTree.SubElement(inertial, "inertia"), moment * np.eye(3))
        self.masses[name] = mass
        self.receipt.taken_as(
            "inertial", name, f"{mass:.3g} kg and moments of {moment:.3g} kg m^2, from none: it carries mass"
        )


def number(element: ElementTree.Element | None, attribute: str, name: str) -> float:
    """The value of an attribute, 0 where there is none. Raises Error, with the name, if it isn't finite."""
    text = "0" if element is None else element.get(attribute, "0")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _core.Error(f"load_urdf: {attribute} of {name} is {text!r}; expected a finite number")
    return value


def _set_moments(tensor: ElementTree.Element, inertia: Floats) -> None:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    for key, value in zip(_MOMENTS, (xx, xy, xz, yy, yz, zz), strict=True):
        tensor.set(key, repr(float(value)))


def _vector(origin: ElementTree.Element | None, attribute: str, name: str) -> Floats:
    text = "0 0 0" if origin is None else origin.get(attribute, "0 0 0")
    try:
        vector = np.array(text.split(), dtype=np.float64)
    except ValueError:
        vector = np.zeros(0)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)):
        raise _core.Error(f"load_urdf: {attribute} of {name} is {text!r}; expected three finite numbers")
    return vector


def _rotation(angles: Floats) -> Floats:
    """About the fixed axes x, y and z, in this order."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.array(rows)


def _roll_pitch_yaw(turn: Floats) -> Floats:
    across = math.hypot(turn[0, 0], turn[1, 0])
    pitch = math.atan2(-turn[2, 0], across)
    if across < 1e-9:  # roll and yaw turn about one axis: all is roll
        return np.array([math.atan2(-turn[1, 2], turn[1, 1]), pitch, 0.0])
    return np.array([math.atan2(turn[2, 1], turn[2, 2]), pitch, math.atan2(turn[1, 0], turn[0, 0])])
