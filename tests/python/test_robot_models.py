"""Whole models of robots, as packages bring them: bodies weigh what the compiler says, and stand where it puts them."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import gymnasium
import mujoco  # type: ignore[import-untyped]
import numpy as np
import pytest
from numpy.typing import NDArray

import atoll
from atoll._robots import Verdict
from atoll._robots.compiled import Compiled
from atoll._robots.mjcf import read
from atoll._robots.urdf import compile_urdf

from conftest import LONG_TESTS, ROOT, long_test

Floats = NDArray[np.float64]

GYMNASIUM = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
MODELS = ROOT / "build/robot_models"
DAILY = [
    "ant", "half_cheetah", "hopper", "humanoid", "inverted_double_pendulum", "point", "pusher_v5", "reacher", "swimmer",
    "walker2d_v5",
]  # fmt: skip
#: Files of the packages that MuJoCo itself refuses: parts of models, and tests of what is wrong.
REFUSED = {
    "robosuite": 4,
    "gymnasium_robotics": 4,
    "dm_control": 8,
    "cmeel.prefix": 0,
}
CONFIGURATIONS = 100 if LONG_TESTS else 20


def compiled(path: Path) -> Compiled:
    if path.suffix == ".urdf":
        return compile_urdf(path)[0]
    return Compiled(mujoco, mujoco.MjModel.from_xml_path(str(path)), None)


def matrix(wxyz: Floats) -> Floats:
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, np.ascontiguousarray(wxyz, dtype=np.float64))
    return flat.reshape(3, 3)


def transform(position: Any, rotation: Floats) -> Floats:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = rotation, position
    return made


def frame(pose: atoll.Pose) -> Floats:
    return transform(pose.position, matrix(np.roll(pose.orientation, 1)))


def moved(kind: object, values: Floats, axes: list[int]) -> Floats:
    """Of the second frame of a joint in the first. axes: those of its coordinates that the model has, if it has angles."""
    if isinstance(kind, atoll.SixDofJoint) and kind.turns != atoll.SixDofTurns.VECTOR:
        after = np.eye(4)
        for value, axis in zip(values, axes, strict=False):
            along = np.eye(3)[axis % 3]
            turn = np.array([np.cos(value / 2), *(np.sin(value / 2) * along)])
            after = after @ (transform([0, 0, 0], matrix(turn)) if axis >= 3 else transform(value * along, np.eye(3)))
        return after
    if isinstance(kind, atoll.HingeJoint):
        return transform([0, 0, 0], matrix(np.array([np.cos(values[0] / 2), np.sin(values[0] / 2), 0, 0])))
    if isinstance(kind, atoll.SliderJoint):
        return transform([values[0], 0, 0], np.eye(3))
    return transform([0, 0, 0], matrix(values[:4]))


class Kinematics:
    """Poses of a scene's bodies, from its joints' frames alone."""

    def __init__(self, model: Any, roots: dict[int, int], robot: atoll.Robot) -> None:
        self.roots = roots
        self.places = {f"{model.joint(j).name or j}": int(model.jnt_qposadr[j]) for j in range(model.njnt)}
        self.joints = []
        reached: set[int] = set()
        for joint in robot.scene.joints:
            name = joint.name.split(", ")[0]
            if name in self.places and joint.second not in reached:
                reached.add(joint.second)
                ends = frame(joint.definition.frame_first), np.linalg.inv(frame(joint.definition.frame_second))
                axes = [of.axis for of in robot.coordinates if robot.scene.joints[of.joint].name == joint.name]
                self.joints.append(
                    (joint.first, joint.second, self.places[name], axes, joint.definition.kind, *ends)
                )

    def error(self, data: Any) -> float:
        """m or a cosine, the most of any body, of those that joints carry."""
        poses = {p: transform(data.xpos[b], data.xmat[b].reshape(3, 3)) for p, b in self.roots.items()}
        wanted = dict(poses)
        anchor = np.eye(4)
        worst = 0.0
        for first, second, place, axes, kind, before, after in self.joints:
            values = data.qpos[place : place + max(len(axes), 4)]
            poses[second] = poses.get(first, anchor) @ before @ moved(kind, values, axes) @ after
            if second in wanted:
                worst = max(worst, float(np.abs(poses[second] - wanted[second]).max()))
        return worst


def roots_of(model: Compiled, robot: atoll.Robot) -> dict[int, int]:
    """The model's bodies that others are welded to, by their places in the scene."""
    moving = [body for body in range(1, model.arrays.nbody) if model.arrays.body_weldid[body] == body]
    return {robot.bodies[model.name("BODY", body)]: body for body in moving}


def between(robot: atoll.Robot, place: int) -> int:
    """Bodies that carry it and aren't of the model."""
    carriers, own = {joint.second: joint.first for joint in robot.scene.joints}, set(robot.bodies.values())
    place, count = carriers.get(place, -1), 0
    while place in carriers and place not in own:
        place, count = carriers[place], count + 1
    return count


def check_masses(model: Any, roots: dict[int, int], robot: atoll.Robot) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    world = robot.build()
    for place, body in roots.items():
        if world.type(world.bodies[place]) != atoll.BodyType.DYNAMIC:
            continue
        parts = [n for n in range(model.nbody) if model.body_weldid[n] == body]
        mass = sum(model.body_mass[n] for n in parts)
        centre = sum(model.body_mass[n] * data.xipos[n] for n in parts) / mass
        inertia = np.zeros((3, 3))
        for n in parts:
            axes, arm = data.ximat[n].reshape(3, 3), data.xipos[n] - centre
            inertia += axes @ np.diag(model.body_inertia[n]) @ axes.T
            inertia += model.body_mass[n] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        turn = data.xmat[body].reshape(3, 3)
        share = 1 - 1e-3 * between(robot, place)
        definition = world.definition(world.bodies[place])
        assert definition.inertia is not None and definition.centre_of_mass is not None
        assert world.mass(world.bodies[place]) == pytest.approx(share * mass, rel=1e-9)
        assert definition.centre_of_mass == pytest.approx(turn.T @ (centre - data.xpos[body]), abs=1e-9)
        size = float(np.abs(inertia).max())
        assert definition.inertia == pytest.approx(share * turn.T @ inertia @ turn, abs=1e-9 * size)


def check(path: Path) -> atoll.Robot:
    """Raises ValueError if MuJoCo refuses the file."""
    model = compiled(path)
    robot = read(model)
    arrays = model.arrays
    roots = roots_of(model, robot)
    check_masses(arrays, roots, robot)
    kinematics = Kinematics(arrays, roots, robot)
    data = mujoco.MjData(arrays)
    random = np.random.default_rng(7)
    keyframes = list(arrays.key_qpos)
    for number in range(CONFIGURATIONS + len(keyframes)):
        data.qpos[:] = keyframes[number] if number < len(keyframes) else random.uniform(-2, 2, arrays.nq)
        mujoco.mj_normalizeQuat(arrays, data.qpos)
        mujoco.mj_kinematics(arrays, data)
        assert kinematics.error(data) < 1e-9, path.name
    for number in range(len(keyframes)):
        at_key = read(Compiled(mujoco, arrays, number))
        world = at_key.build()
        data.qpos[:] = keyframes[number]
        mujoco.mj_normalizeQuat(arrays, data.qpos)
        mujoco.mj_kinematics(arrays, data)
        for place, body in kinematics.roots.items():
            assert world.pose(world.bodies[place]).position == pytest.approx(data.xpos[body], abs=1e-9)
    return robot


@pytest.fixture(autouse=True)
def folder_for_logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes what it warns of into the folder that it runs in."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", DAILY)
def test_models_of_gymnasium_are_read(name: str) -> None:
    robot = check(GYMNASIUM / f"{name}.xml")
    assert robot.coordinates
    assert {line.element for line in robot.receipt.of(Verdict.LEFT_OUT)} <= {"tendon", "option"}


@long_test
@pytest.mark.parametrize("package", REFUSED)
def test_models_of_packages_are_read(package: str) -> None:
    folder = MODELS / package
    if not folder.exists():
        pytest.skip("tests/run.sh --long installs the packages that have the models")
    urdf = package == "cmeel.prefix"
    refused, read_ones = [], 0
    for path in sorted(folder.rglob("*.urdf" if urdf else "*.xml")):
        if not urdf and ElementTree.parse(path).getroot().tag != "mujoco":
            continue
        try:
            check(path)
            read_ones += 1
        except (ValueError, atoll.Error) as error:
            refused.append(f"{path.name}: {error}")
    assert len(refused) == REFUSED[package], "\n".join(refused)
    assert read_ones >= 30
