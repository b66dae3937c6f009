#!/usr/bin/env python3
"""How much time a second of one core simulates of whole robots, in Atoll and in MuJoCo 4.0, and at which error.

    pip install .[robots,gym] mujoco-core
    python perf/robot_rates.py --menagerie DIR     # a copy of MuJoCo's menagerie, for the four robots that are from it

measures all into perf/results/robots.csv, and prints the table (robot_table.py). Rows that are measured again replace
those of the file, so it can be made in parts: --only, --runs, --worlds.

Free: .6 s without contact, ends of ranges and dry friction, which are soft in MuJoCo and rigid here; joints start at
1 rad/s to and fro, and controls stay. The error is that of the joints' coordinates at the end, against MuJoCo's
Runge-Kutta method at 1/19200 s; all steps below divide .6 s. Touching: on the model's own ground after 1.6 s, when what
falls has landed. Controls are held, or drawn anew every 1/15 s, alike in both engines. Each world has its own numbers.

Engines take turns, and each rate is a median. On one thread it goes by CPU time, on two by wall time.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its idle threads would count as CPU time of the engines
os.environ.setdefault("ATOLL_DYNAMIC_THREADS", "0")  # so that both engines keep two threads beside other programs

import argparse
import datetime
import functools
import itertools
import statistics
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import mujoco.batch
import numpy as np
from numpy.typing import NDArray

import atoll
import robot_table
from atoll._robots.compiled import Compiled
from atoll._robots.mjcf import read
from atoll._tasks.robot_scene import drive

Floats = NDArray[np.float64]

DT, SUBSTEPS = 1 / 60, 4  # s; Atoll's defaults
HELD = 4  # of Atoll's steps, as long as controls stay
FREE_STEPS = 36  # .6 s
FREE_PART = 0.25  # as Model.part
FINE_STEP = 1 / 19200  # s, of the reference
LANDED = 24  # control steps before anything is timed
STARTS = 32  # worlds that land; batches have copies of these
WORLDS = (1, 64, 1024, 4096)
LEAST = 0.1  # s, that is timed
LOWEST = -0.1  # m above the ground: what is below it is lost


@dataclass(frozen=True)
class Model:
    """A robot. Drawn controls are so large a part of their range, about those that it starts with."""

    name: str
    file: str
    part: float = 0.3
    key: int | None = None  # the keyframe that it starts in


MODELS = [
    Model("G1", "unitree_g1/scene.xml", key=0),
    Model("ANYmal C", "anybotics_anymal_c/scene.xml"),
    Model("Panda", "franka_emika_panda/scene.xml", key=0),
    Model("Shadow hand", "shadow_hand/scene_right.xml"),
    Model("Humanoid", "humanoid.xml", part=1),
    Model("Ant", "ant.xml", part=1),
    Model("HalfCheetah", "half_cheetah.xml", part=1),
    Model("Hopper", "hopper.xml", part=1),
    Model("Walker2d", "walker2d.xml", part=1),
]
TOLD = {"date": datetime.date.today().isoformat(), "atoll": atoll.__version__, "mujoco": mujoco.__version__}
TOLD["machine"] = f"{os.cpu_count()} x {robot_table.processor()}"
GYMNASIUM = Path(gymnasium.__file__).parent / "envs/mujoco/assets"


class Task:
    """A compiled model, and where it starts and what controls it has in both engines."""

    def __init__(self, model: Model, menagerie: Path, run: str) -> None:
        path = menagerie / model.file if "/" in model.file else GYMNASIUM / model.file
        self.model, self.run = model, run
        self.arrays: Any = mujoco.MjModel.from_xml_path(str(path))
        self.own = (self.arrays.opt.timestep, self.arrays.opt.integrator)
        kinds, off = mujoco.mjtJoint, mujoco.mjtDisableBit
        bends = (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE))
        self.joints = [j for j in range(self.arrays.njnt) if self.arrays.jnt_type[j] in bends]
        if run.startswith("free"):
            self.arrays.opt.disableflags |= off.mjDSBL_CONTACT | off.mjDSBL_LIMIT | off.mjDSBL_FRICTIONLOSS
            self.arrays.dof_frictionloss[:] = 0

    def start(self) -> Any:
        data = mujoco.MjData(self.arrays)
        if self.model.key is not None:
            mujoco.mj_resetDataKeyframe(self.arrays, data, self.model.key)
        if self.run.startswith("free"):
            for number, joint in enumerate(self.joints):
                hinge = self.arrays.jnt_type[joint] == int(mujoco.mjtJoint.mjJNT_HINGE)
                data.qvel[self.arrays.jnt_dofadr[joint]] = (1 if hinge else 0.1) * (-1) ** number
        return data

    def controls(self, worlds: int, count: int) -> Floats:
        """Shape (worlds, count, controls). A world's first numbers are those of any other count."""
        m, held = self.arrays, self.start().ctrl
        limited = m.actuator_ctrllimited.astype(bool)
        low, high = (np.where(limited, m.actuator_ctrlrange[:, side], 2 * side - 1) for side in (0, 1))
        if self.run.endswith("held"):
            return np.broadcast_to(held, (worlds, count, m.nu)).copy()
        drawn = [np.random.default_rng(world).uniform(low, high, (count, m.nu)) for world in range(worlds)]
        part = FREE_PART if self.run.startswith("free") else self.model.part
        return np.asarray(held + part * (np.array(drawn) - held))

    def ground(self) -> float:
        """m."""
        planes = self.arrays.geom_type == int(mujoco.mjtGeom.mjGEOM_PLANE)
        return float(self.arrays.geom_pos[planes, 2].min(initial=np.inf if planes.any() else -np.inf))


@dataclass
class Run:
    simulated: float = 0  # s, of all worlds together
    seconds: float = 0
    lost: int = 0  # bodies of Atoll's, warnings of MuJoCo's
    positions: Floats | None = None  # rad or m, of the joints of a world

    def add(self, simulated: float, seconds: float) -> None:
        self.simulated += simulated
        self.seconds += seconds


def seconds_of(run: Callable[[], object], threads: int, calls: int = 1) -> float:
    """Seconds of a core on one thread, of the clock on several."""
    clock = time.process_time if threads == 1 else time.perf_counter
    begin = clock()
    for _ in range(calls):
        run()
    return clock() - begin


def steps_of(worlds: int) -> tuple[int, int]:
    """Atoll's steps in a call that is timed, and calls: enough to be timed, and no more than a control stays."""
    return min(HELD, 8192 // worlds), 2 if worlds == 1 else max(1, 128 // worlds)


class Atoll:
    """What load_mjcf() makes of a model. Motors are soft servos with targets far away, as in atoll.gym."""

    def __init__(self, task: Task, substeps: int = SUBSTEPS) -> None:
        self.task, self.robot = task, read(Compiled(mujoco, task.arrays, task.model.key))
        motors = any(actuator.kind == "force" for actuator in self.robot.actuators)
        stiffness = drive(self.robot) if motors else {}
        settings = self.robot.scene.settings
        settings.substeps = substeps
        self.robot.scene.settings = settings
        self.servos, self.scales = [], []
        self.batch: atoll.Batch | None = None
        for actuator in self.robot.actuators:
            of = None if actuator.tendon >= 0 else self.robot.coordinates[actuator.coordinate]
            self.servos.append(atoll.ServoTarget(of.joint, of.axis) if of else atoll.ServoTarget(actuator.tendon))
            per_force = 1 / (actuator.stiffness or stiffness[actuator.coordinate])
            self.scales.append((actuator.gain * per_force, actuator.bias * per_force, *actuator.range))

    def targets(self, controls: Floats) -> Floats:
        gain, bias, low, high = np.array(self.scales).T
        return np.ascontiguousarray(gain * np.clip(controls, low, high) + bias)

    def free(self) -> Run:
        batch = atoll.Batch(self.robot.scene, 1, threads=1)
        task, mechanism = self.task, self.robot.mechanism(batch[0])
        rates, moving = task.start().qvel[task.arrays.jnt_dofadr[task.joints]], mechanism.v()
        moving[len(moving) - len(rates) :] = rates
        mechanism.set(mechanism.q(), moving)
        batch.save_start()
        targets, total = self.targets(task.controls(1, 1)), Run()
        while total.seconds < LEAST:
            batch.reset()
            run = functools.partial(batch.rollout, self.servos, targets, dt=DT, count=FREE_STEPS, keep=())
            total.add(FREE_STEPS * DT, seconds_of(run, 1))
        total.positions = self.robot.positions(batch[0])
        return total

    @functools.cached_property
    def landed(self) -> list[Any]:
        batch = atoll.Batch(self.robot.scene, STARTS, threads=1)
        batch.rollout(self.servos, self.targets(self.task.controls(STARTS, LANDED)), dt=DT, count=HELD, keep=())
        return [world.save() for world in batch]

    def batch_of(self, worlds: int, threads: int) -> atoll.Batch:
        """The last one, if it is like that: thousands of worlds take seconds to build."""
        if self.batch is None or (len(self.batch), self.batch.threads) != (worlds, threads):
            self.batch = atoll.Batch(self.robot.scene, worlds, threads=threads)
        return self.batch

    def touching(self, worlds: int, threads: int) -> Run:
        batch, total = self.batch_of(worlds, threads), Run()
        controls = self.targets(self.task.controls(STARTS, LANDED + 2)[:, LANDED:])
        roll = functools.partial(batch.rollout, self.servos, dt=DT, keep=())
        # One world lands in all ways in turn.
        for places in np.arange(STARTS)[:, None] if worlds == 1 else [np.arange(worlds) % STARTS]:
            roll(controls[places, :1], count=1, start=[self.landed[place] for place in places])
            steps, calls = steps_of(worlds)
            run = functools.partial(roll, controls[places, 1:], count=steps)
            total.add(worlds * calls * steps * DT, seconds_of(run, threads, calls))
            heights = batch.origins[..., 2]
            total.lost += sum(batch.quarantined()) + int(np.sum(~(heights >= self.task.ground() + LOWEST)))
        return total


class MuJoCo:
    """Through mj_step of one world, or mujoco.batch of many."""

    def __init__(self, task: Task, step: float, integrator: int) -> None:
        self.task, self.model = task, task.arrays
        self.step, self.integrator, self.held = step, integrator, round(HELD * DT / step)

    def start(self) -> Any:
        self.model.opt.timestep, self.model.opt.integrator = self.step, self.integrator
        return self.task.start()

    def free(self) -> Run:
        start, data, steps = self.start(), mujoco.MjData(self.model), round(FREE_STEPS * DT / self.step)
        control, total = self.task.controls(1, 1)[0, 0], Run()
        while total.seconds < LEAST:
            mujoco.mj_resetData(self.model, data)
            data.qpos[:], data.qvel[:], data.ctrl[:] = start.qpos, start.qvel, control
            total.add(steps * self.step, seconds_of(lambda: mujoco.mj_step(self.model, data, nstep=steps), 1))
        total.positions = data.qpos[self.model.jnt_qposadr[self.task.joints]].copy()
        return total

    @functools.cached_property
    def landed(self) -> Floats:
        start = self.start()
        batch = mujoco.batch.Batch(self.model, STARTS, nthread=1)
        batch.qpos, batch.qvel = start.qpos, start.qvel
        for controls in self.task.controls(STARTS, LANDED).swapaxes(0, 1):
            batch.ctrl = controls
            batch.step(nstep=self.held)
        return np.array(batch.state)

    def touching(self, worlds: int, threads: int) -> Run:
        landed, total = self.landed, Run()
        self.start()
        controls = self.task.controls(STARTS, LANDED + 2)[:, LANDED:]
        if worlds == 1:
            data, kind = mujoco.MjData(self.model), int(mujoco.mjtState.mjSTATE_INTEGRATION)
            for state, some in zip(landed, controls, strict=True):
                mujoco.mj_setState(self.model, data, state, kind)
                data.ctrl[:] = some[0]
                mujoco.mj_step(self.model, data)
                data.ctrl[:] = some[1]
                run = functools.partial(mujoco.mj_step, self.model, data, nstep=2 * self.held)
                total.add(2 * self.held * self.step, seconds_of(run, threads))
            total.lost = sum(warning.number for warning in data.warning)
            return total
        batch, places = mujoco.batch.Batch(self.model, worlds, nthread=threads), np.arange(worlds) % STARTS
        batch.state[:] = landed[places]
        batch.ctrl = controls[places, 0]
        batch.step()
        batch.ctrl, (steps, calls) = controls[places, 1], steps_of(worlds)
        steps = round(steps * DT / self.step)
        seconds = seconds_of(functools.partial(batch.step, nstep=steps), threads, calls)
        total.add(worlds * calls * steps * self.step, seconds)
        total.lost = int(np.sum(batch.warning))
        return total


def off(positions: Floats, right: Floats) -> float:
    """rad or m. Which full turn an angle is in doesn't count."""
    apart = positions - right
    return float(np.abs(apart - 2 * np.pi * np.round(apart / (2 * np.pi))).max())


def measure(task: Task, given: argparse.Namespace) -> list[dict[str, Any]]:
    """Rows of the results."""
    kinds = mujoco.mjtIntegrator
    own = (robot_table.OWN, MuJoCo(task, *task.own))
    cases: list[tuple[str, str, Any, int, int]] = []  # engine, setting, runner, worlds, threads
    right = None
    if task.run.startswith("free"):
        right = MuJoCo(task, FINE_STEP, kinds.mjINT_RK4).free().positions
        cases += [("Atoll", f"{n} substep" + "s" * (n > 1), Atoll(task, n), 1, 1) for n in (1, 2, 4, 8, 64)]
        cases.append(("MuJoCo", *own, 1, 1))
        for name, integrator in (("implicitfast", kinds.mjINT_IMPLICITFAST), ("RK4", kinds.mjINT_RK4)):
            cases += [("MuJoCo", f"{name}, {n} ms", MuJoCo(task, n / 1000, integrator), 1, 1) for n in (8, 4, 2, 1)]
    else:
        ours = Atoll(task)
        for worlds, threads in ((n, threads) for n in given.worlds for threads in ((1,) if n == 1 else given.threads)):
            cases += [("Atoll", f"{SUBSTEPS} substeps", ours, worlds, threads), ("MuJoCo", *own, worlds, threads)]
    if right is None:  # pairs take turns
        pairs = [cases[i : i + 2] for i in range(0, len(cases), 2)]
        runs_of = [[[case[2].touching(*case[3:]) for case in pair] for _ in range(given.repeats)] for pair in pairs]
        runs = [run for of_pair in runs_of for run in zip(*of_pair, strict=True)]
    else:
        runs = list(zip(*([case[2].free() for case in cases] for _ in range(given.repeats)), strict=True))
    rows = []
    for (engine, setting, _, worlds, threads), of_case in zip(cases, runs, strict=True):
        rates = sorted(run.simulated / run.seconds for run in of_case)
        row: dict[str, Any] = dict(zip(robot_table.KEY, (task.model.name, task.run, engine, setting, worlds, threads)))
        row |= {"rate": statistics.median(rates), "slowest": rates[0], "fastest": rates[-1], "lost": of_case[-1].lost}
        row["error"] = "" if right is None else off(of_case[-1].positions, right)
        columns = {of: f"{value:.4g}" if isinstance(value, float) else value for of, value in row.items()}
        rows.append(columns | {"load": f"{os.getloadavg()[0]:.1f}", **TOLD})
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--menagerie", type=Path, default=os.environ.get("MENAGERIE_ROOT", "."), help="MENAGERIE_ROOT if left out")
    add("--only", nargs="+", metavar="ROBOT", default=[model.name for model in MODELS])
    add("--runs", nargs="+", choices=robot_table.RUNS, default=robot_table.RUNS)
    add("--worlds", nargs="+", type=int, default=WORLDS)
    add("--threads", nargs="+", type=int, default=(1, 2), help="of many worlds")
    add("--repeats", type=int, default=3)
    add("--out", type=Path, default=robot_table.RESULTS)
    given = parser.parse_args()
    given.out, given.menagerie = given.out.resolve(), given.menagerie.resolve()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # MuJoCo writes what it warns of into it
        for model, run in itertools.product(MODELS, given.runs):
            if model.name in given.only:
                robot_table.add(given.out, measure(Task(model, given.menagerie, run), given))
    print(robot_table.text(given.out))


if __name__ == "__main__":
    main()
