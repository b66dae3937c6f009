"""Robots that are dropped stay whole, and move by no more than their fall and their springs can give."""

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
from atoll._robots.compiled import Compiled
from atoll._robots.mjcf import read

from conftest import DT, ROOT, long_test

Floats = NDArray[np.float64]

GYMNASIUM = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
MODELS = ROOT / "build/robot_models"
FALL = 0.3  # m, or whatever length a model counts in
SECONDS = 2


def on_a_floor(path: Path) -> Any:
    """The model, with a floor so far below what it collides with. Raises ValueError if MuJoCo refuses it."""
    spec = mujoco.MjSpec.from_file(str(path))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    collides = [
        geom
        for geom in range(model.ngeom)
        if (model.geom_contype[geom] or model.geom_conaffinity[geom]) and model.body_weldid[model.geom_bodyid[geom]]
    ]
    lowest = min((data.geom_xpos[geom][2] - model.geom_rbound[geom] for geom in collides), default=0.0)
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(name="a floor", type=plane, size=[0, 0, 0.1], pos=[0, 0, lowest - FALL])
    return spec.compile()


def matrix(xyzw: Floats) -> Floats:
    flat = np.zeros(9)
    mujoco.mju_quat2Mat(flat, np.ascontiguousarray(np.roll(xyzw, 1)))
    return flat.reshape(3, 3)


def kinetic_energy(world: atoll.World) -> float:
    total = 0.0
    for body in world.bodies:
        if world.type(body) != atoll.BodyType.DYNAMIC:
            continue
        inertia = world.definition(body).inertia
        assert inertia is not None
        spin = matrix(world.pose(body).orientation).T @ np.asarray(world.angular_velocity(body))
        total += 0.5 * world.mass(body) * float(np.sum(np.square(world.velocity(body))))
        total += 0.5 * float(spin @ np.asarray(inertia) @ spin)
    return total


def stored(robot: atoll.Robot, model: Any) -> float:
    """J: in the model's springs and servos where it begins."""
    total = 0.0
    positions = robot.positions(robot.build())
    for actuator in robot.actuators:
        if actuator.kind == "position":
            off = positions[actuator.coordinate] - actuator.bias / actuator.stiffness
            total += 0.5 * actuator.stiffness * off * off
    for joint in range(model.njnt):
        stiffness, place = float(np.ravel(model.jnt_stiffness[joint])[0]), int(model.jnt_qposadr[joint])
        if stiffness > 0:
            total += 0.5 * stiffness * float(model.qpos0[place] - model.qpos_spring[place]) ** 2
    return total


def height_energy(world: atoll.World) -> float:
    """J, against gravity."""
    moving = [body for body in world.bodies if world.type(body) == atoll.BodyType.DYNAMIC]
    centres = [world.mass(body) * np.asarray(world.centre_of_mass(body)) for body in moving]
    return -float(np.asarray(world.gravity) @ np.sum(centres, axis=0)) if moving else 0.0


def check(path: Path) -> None:
    model = on_a_floor(path)
    robot = read(Compiled(mujoco, model, None))
    world = robot.build()
    mass = sum(world.mass(body) for body in world.bodies if world.type(body) == atoll.BodyType.DYNAMIC)
    start = height_energy(world)
    # Shapes that overlap as the model begins are pushed apart, which may lift it, and wind up its springs.
    dropped = mass * float(np.linalg.norm(world.gravity)) * FALL + 1e-9
    given = stored(robot, model) + dropped
    for _ in range(round(SECONDS / DT / 4)):
        world.steps(4, DT)
        assert not world.quarantined(), path.name
        assert kinetic_energy(world) <= given + max(start - height_energy(world), 0), path.name


@pytest.fixture(autouse=True)
def folder_for_logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes what it warns of into the folder that it runs in."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", ["ant", "half_cheetah", "hopper", "humanoid", "pusher_v5", "walker2d_v5"])
def test_models_of_gymnasium_fall_and_stay_whole(name: str) -> None:
    check(GYMNASIUM / f"{name}.xml")


@long_test
@pytest.mark.parametrize("package", ["robosuite", "gymnasium_robotics", "dm_control"])
def test_models_of_packages_fall_and_stay_whole(package: str) -> None:
    folder = MODELS / package
    if not folder.exists():
        pytest.skip("tests/run.sh --long installs the packages that have the models")
    fallen, failed = 0, []
    for path in sorted(folder.rglob("*.xml")):
        if ElementTree.parse(path).getroot().tag != "mujoco":
            continue
        try:
            check(path)
            fallen += 1
        except AssertionError as error:
            failed.append(str(error).splitlines()[0])
        except (ValueError, atoll.Error):
            pass  # parts of models, as test_robot_models.py counts them
    assert not failed, "\n".join(failed)
    assert fallen >= 20
