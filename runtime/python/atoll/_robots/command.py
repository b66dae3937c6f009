"""`atoll import ROBOT -o SCENE.json`, which the command hands over to `python -m atoll import`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from .. import _core
from .mjcf import load_mjcf
from .receipt import Receipt, Verdict
from .robot import Robot
from .urdf import load_urdf

_DONE, _LEFT_OUT, _BAD_INPUT = 0, 1, 3


def main(words: Sequence[str]) -> int:
    given = _parser().parse_args(words)
    try:
        robot = _load(given)
        robot.scene.write(str(given.output))
        _write(robot.receipt, given.receipt)
    except (_core.Error, OSError) as error:
        print(f"import: {error}", file=sys.stderr)
        return _BAD_INPUT
    left_out = robot.receipt.of(Verdict.LEFT_OUT)
    if given.strict and left_out:
        print(f"import: {len(left_out)} elements are left out, the first is {left_out[0]}", file=sys.stderr)
        return _LEFT_OUT
    return _DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="atoll import",
        description="Makes a scene file of a robot model (URDF, or MuJoCo's MJCF), and says what became of each of its "
        "elements. `atoll run` and `atoll view` take that file, which has all shapes in it.",
    )
    parser.add_argument("robot", metavar="ROBOT.xml", type=Path)
    parser.add_argument("-o", "--output", metavar="SCENE.json", type=Path, required=True)
    parser.add_argument("--pose", metavar="NAME", help="keyframe of an MJCF file to start in")
    parser.add_argument("--fixed-base", action="store_true", help="hold the first link of a URDF to the world")
    parser.add_argument("--self-collision", action="store_true", help="let the links of a URDF touch each other")
    parser.add_argument(
        "--packages", metavar="DIR", action="append", default=[],
        help="folder of packages that meshes of a URDF are in; may be given several times",
    )  # fmt: skip
    parser.add_argument(
        "--hull-error", metavar="PART", type=float, help="take meshes apart whose convex hulls are off by more than this "
        "part of their volume, as 0.1",
    )  # fmt: skip
    parser.add_argument(
        "--receipt", metavar="FILE", type=Path, help="write what became of each element there, as JSON if it ends so, "
        "and not to the standard output",
    )  # fmt: skip
    parser.add_argument("--strict", action="store_true", help="exit status 1 if anything is left out")
    return parser


def _load(given: argparse.Namespace) -> Robot:
    try:
        tag = next(element.tag for _, element in ElementTree.iterparse(given.robot, events=("start",)))
    except ElementTree.ParseError as error:
        raise _core.Error(f"ROBOT.xml is {given.robot}; expected a robot model: {error}") from None
    if tag != "robot":
        for option in ("fixed_base", "self_collision", "packages"):
            if getattr(given, option):
                raise _core.Error(f"--{option.replace('_', '-')} is given with an MJCF file; expected a URDF")
        return load_mjcf(given.robot, given.pose, given.hull_error)
    if given.pose is not None:
        raise _core.Error(f"--pose is {given.pose}; expected none for a URDF, which has no keyframes")
    return load_urdf(given.robot, given.packages, given.fixed_base, given.self_collision, given.hull_error)


def _write(receipt: Receipt, path: Path | None) -> None:
    if path is None:
        print(receipt.text())
    else:
        path.write_text((receipt.json() if path.suffix == ".json" else receipt.text()) + "\n")
