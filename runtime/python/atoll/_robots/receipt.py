"""What became of each element of a model."""

from __future__ import annotations

import enum
import json
from collections import Counter
from dataclasses import asdict, dataclass, field


class Verdict(str, enum.Enum):
    EXACT = "exact"
    TAKEN_AS = "taken as"  #: something else: the line says what, and by how much it differs
    LEFT_OUT = "left out"  #: the line says why


@dataclass(frozen=True)
class Line:
    element: str  #: its kind in the model, as "joint"
    name: str  #: its own, or its number
    verdict: Verdict
    note: str = ""

    def __str__(self) -> str:
        return f"{self.element} {self.name}: {self.verdict.value}{', ' + self.note if self.note else ''}"


@dataclass
class Receipt:
    """A line for each element of a model that a scene was made of. Nothing is dropped without one."""

    model: str  #: its name
    lines: list[Line] = field(default_factory=list)

    def exact(self, element: str, name: str) -> None:
        self.lines.append(Line(element, name, Verdict.EXACT))

    def taken_as(self, element: str, name: str, note: str) -> None:
        self.lines.append(Line(element, name, Verdict.TAKEN_AS, note))

    def left_out(self, element: str, name: str, note: str) -> None:
        self.lines.append(Line(element, name, Verdict.LEFT_OUT, note))

    def of(self, verdict: Verdict) -> list[Line]:
        return [line for line in self.lines if line.verdict is verdict]

    def text(self) -> str:
        """How many of each element were taken exactly, and a line for each of the others."""
        exact = Counter(line.element for line in self.of(Verdict.EXACT))
        counts = ", ".join(f"{count} {element}" for element, count in exact.items()) or "nothing"
        rest = [str(line) for line in self.lines if line.verdict is not Verdict.EXACT]
        return "\n".join([f"{self.model}: exact: {counts}", *rest])

    def json(self) -> str:
        lines = [{**asdict(line), "verdict": line.verdict.value} for line in self.lines]
        return json.dumps({"model": self.model, "lines": lines}, indent=1)
