"""Ensembles come to the same table whatever happens to those who compute them."""

from __future__ import annotations

import csv
import fcntl
import importlib
import itertools
import json
import math
import os
import random
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
import pytest

import atoll
from atoll._ensemble import EnsembleError, stopping
from atoll._ensemble.driver import MOST_LOSSES, Options, Tally
from atoll._ensemble.engines import Answer, Call, LocalEngine
from atoll._ensemble.job import Part, make_scene, run_part
from atoll._ensemble.plan import PlanError, read_plan
from atoll._ensemble.run import Outcome, gather, run_ensemble
from atoll._ensemble.store import Store
from atoll._ensemble.table import has_parquet

from conftest import long_test

PLAN: dict[str, Any] = {
    "studies": [
        {
            "scene": "pile:bodies=100",
            "steps": 150,
            "parameters": {"material.friction": {"uniform": [0.2, 0.8]}, "mass": [0.5, 2]},
            "sample": {"count": 4, "seed": 3},
        },
        {"scene": "ragdolls:count=3", "steps": 100, "seeds": 4, "parameters": {"settings.substeps": [2, 4]}},
    ],
    "keep": {"observables": ["max_height", "mean_speed"], "series": 30},
}
JOBS = 16
HANGS = 600  #: s, after which what should have ended is taken to hang


class Tables(NamedTuple):
    results: bytes
    series: bytes


def run(out: Path, plan: dict[str, Any] = PLAN, **options: Any) -> Outcome:
    engine = options.pop("engine", "local")
    return run_ensemble(plan, out, engine=engine, workers=2, parquet=False, options=Options(**options))


def tables(out: Path) -> Tables:
    series = out / "series.csv"
    return Tables((out / "results.csv").read_bytes(), series.read_bytes() if series.exists() else b"")


def rows_of(written: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(written.decode().splitlines()))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Tables:
    out = tmp_path_factory.mktemp("undisturbed")
    outcome = run(out)
    assert (outcome.done, outcome.failed, outcome.finished) == (JOBS, 0, True)
    return tables(out)


# --- What is computed


def max_height(world: atoll.World) -> float:
    return max(float(world.positions[body.index][2]) for body in world.bodies if world.type(body) == atoll.BodyType.DYNAMIC)


def test_rows_are_what_the_runs_come_to(undisturbed: Tables) -> None:
    rows = rows_of(undisturbed.results)
    moments = {(row["job"], int(row["step"])): row for row in rows_of(undisturbed.series)}
    observed = 0
    jobs = list(read_plan(PLAN).jobs())
    assert [row["job"] for row in rows] == [job.key for job in jobs]
    for job, row in zip(jobs, rows, strict=True):
        scene = make_scene(job)
        world = scene.build()
        for step in range(job.steps + 1):
            if step > 0:
                world.step(scene.dt)
            if step % 30 == 0:
                moment = moments[job.key, step]
                assert float(moment["time"]) == step * scene.dt
                assert float(moment["max_height"]) == max_height(world)
                observed += 1
        assert row["state_hash"] == f"{world.state_hash():016x}"
        assert float(row["max_height"]) == max_height(world)
    assert len({row["state_hash"] for row in rows}) == JOBS
    assert observed == len(moments) == 8 * 6 + 8 * 4


def test_frame_has_a_row_a_job_in_the_order_of_the_plan(undisturbed: Tables) -> None:
    pytest.importorskip("pandas")
    frame = atoll.ensemble(PLAN, workers=2, verify=0)
    assert list(frame["job"]) == [job.key for job in read_plan(PLAN).jobs()]
    assert frame["penetration_max"].max() < 0.1


def test_parquet_is_the_same_to_the_byte_and_tells_the_same(tmp_path: Path) -> None:
    parquet = importlib.import_module("pyarrow.parquet") if has_parquet() else pytest.skip("without PyArrow")
    for name, interval in (("whole", 10.0), ("parts", 0.005)):
        run_ensemble(PLAN, tmp_path / name, workers=2, parquet=True, options=Options(interval))
    whole, parts = (tmp_path / name / "results.parquet" for name in ("whole", "parts"))
    assert whole.read_bytes() == parts.read_bytes()
    whole_series, parts_series = (tmp_path / name / "series.parquet" for name in ("whole", "parts"))
    assert whole_series.read_bytes() == parts_series.read_bytes()
    assert parquet.read_table(whole_series).schema.names == ["job", "step", "time", "max_height", "mean_speed"]
    rows = parquet.read_table(whole).to_pylist()
    written = tables(tmp_path / "whole").results.decode().splitlines()
    assert ",".join(rows[0]) == written[0] and len(rows) == JOBS
    assert [f"{row['max_height']!r}" in line for row, line in zip(rows, written[1:], strict=True)] == [True] * JOBS


def test_parameters_change_what_they_name() -> None:
    parameters = {
        "scene.bodies": 3,
        "settings.joint_solver": "direct",
        "material.restitution": 0.5,
        "mass": 2,
        "gravity": [0, 0, -1],
        "dt": 0.01,
    }
    [job] = read_plan({"scene": "pile", "steps": 5, "parameters": parameters}).jobs()
    scene, plain = make_scene(job), atoll.load_scene("pile:bodies=3")
    assert len(scene.bodies) == len(plain.bodies)
    assert scene.settings.joint_solver == atoll.JointSolver.DIRECT
    assert (scene.dt, list(scene.gravity)) == (0.01, [0, 0, -1])
    moving = [
        (body.definition, before.definition)
        for body, before in zip(scene.bodies, plain.bodies, strict=True)
        if body.definition.type == atoll.BodyType.DYNAMIC
    ]
    assert all(body.density == 2 * before.density and body.material.restitution == 0.5 for body, before in moving)


def test_scenes_of_files_are_run_as_they_are_written(tmp_path: Path) -> None:
    scene = atoll.load_scene("stack:height=3")
    bodies = scene.bodies
    definition = bodies[-1].definition
    definition.mass, definition.inertia = 2.0, np.eye(3)
    bodies[-1].definition = definition
    scene.bodies = bodies
    scene.write(str(tmp_path / "tower.json"))
    plan = {"scene": "tower.json", "steps": 30, "parameters": {"mass": [1, 3]}}
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    plain, heavy = read_plan(tmp_path / "plan.json").jobs()
    made = [make_scene(job).bodies[-1].definition for job in (plain, heavy)]
    assert [one.mass for one in made] == [2, 6]
    assert [one.inertia[0][0] for one in made if one.inertia is not None] == [1, 3]
    (tmp_path / "tower.json").write_text(scene.text().replace("-9.81", "-9.8"))
    assert next(iter(read_plan(tmp_path / "plan.json").jobs())).key != plain.key
    (tmp_path / "plan.json").write_text(json.dumps(plan | {"parameters": {"scene.height": 4}}))
    with pytest.raises(PlanError, match="found scene.height for a file; expected a built-in scene"):
        read_plan(tmp_path / "plan.json")


def halve_friction(scene: atoll.Scene, parameters: dict[str, Any]) -> None:
    """A "setup" of a plan."""
    bodies = scene.bodies
    for body in bodies:
        definition = body.definition
        definition.material = atoll.Material(friction=parameters["user.friction"] / 2)
        body.definition = definition
    scene.bodies = bodies


def count_bodies(world: atoll.World, scene: atoll.Scene) -> dict[str, float]:
    """An "observe" of a plan."""
    return {"bodies": len(world.bodies), "scene_bodies": len(scene.bodies)}


def raise_always(world: atoll.World, scene: atoll.Scene) -> dict[str, float]:
    raise RuntimeError("this one never works")


@pytest.fixture
def this_module(monkeypatch: pytest.MonkeyPatch) -> str:
    """Its name, by which workers can import it."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    return Path(__file__).stem


def run_steps(*arguments: Any) -> Part:
    """run_part() by a clock that goes on by 1 s with each step, so that no part's length depends on the machine."""
    clock = itertools.count()
    with mock.patch("time.perf_counter", lambda: float(next(clock))):
        return run_part(*arguments)


class StepEngine(LocalEngine):
    """An ensemble's `interval` is a number of steps here."""

    def submit(self, call: Call) -> None:
        super().submit(replace(call, function=run_steps))


@pytest.fixture
def step_engine(this_module: str) -> Iterator[StepEngine]:
    made = StepEngine(2)
    yield made
    made.close()


def test_functions_of_the_plan_are_called(tmp_path: Path, this_module: str) -> None:
    plan = {
        "scene": "pile:bodies=3",
        "steps": 20,
        "setup": f"{this_module}:halve_friction",
        "observe": f"{this_module}:count_bodies",
        "parameters": {"user.friction": [0.1, 0.9]},
    }
    outcome = run(tmp_path, plan)
    assert outcome.table is not None
    assert [row["bodies"] for row in outcome.table.rows] == [8, 8]
    observed = run(tmp_path / "series", plan | {"keep": {"series": 10}})
    assert observed.done == 2
    assert [row["bodies"] for row in rows_of(tables(tmp_path / "series").series)] == ["8.0"] * 6
    failing = run(tmp_path, plan | {"observe": f"{this_module}:raise_always"})
    assert failing.failed == 2 and failing.table is not None
    assert "raise_always: RuntimeError: this one never works" in failing.table.rows[0]["why"]


def test_states_and_recordings_are_kept(tmp_path: Path, step_engine: StepEngine) -> None:
    plan = {"scene": "pile:bodies=5", "steps": 60, "keep": {"state": True, "recording": True}}
    run(tmp_path, plan, engine=step_engine, interval=20)
    [job] = read_plan(plan).jobs()
    recordings = sorted((tmp_path / "recordings" / job.key).iterdir())
    assert len(recordings) == 3
    results = [atoll.replay(str(path)) for path in recordings]
    assert sum(result.steps for result in results) == 60
    assert all(result.divergence is None for result in results)
    stored = (tmp_path / "states" / f"{job.key}.snapshot").read_bytes()
    assert f"{results[-1].hash:016x}".encode() in tables(tmp_path).results
    assert str(results[-1].hash).encode() in stored.partition(b"\n")[0]


# --- What happens to those who compute


def test_a_second_run_computes_nothing(tmp_path: Path, undisturbed: Tables) -> None:
    run(tmp_path)
    again = run(tmp_path)
    assert (again.tally.done_before, again.tally.done, again.tally.steps) == (JOBS, 0, 0)
    assert tables(tmp_path) == undisturbed


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("steps", [pytest.param(1, marks=long_test), 20])
def test_parts_come_to_the_same(
    tmp_path: Path, undisturbed: Tables, step_engine: StepEngine, shared: bool, steps: int
) -> None:
    outcome = run(tmp_path, engine=step_engine, shared=shared, interval=steps)
    assert outcome.tally.snapshots > JOBS
    assert tables(tmp_path) == undisturbed


def test_shares_of_a_plan_make_one_table(tmp_path: Path, undisturbed: Tables) -> None:
    for share in range(2):
        run_ensemble(PLAN, tmp_path, workers=1, parquet=False, options=Options(), part=(share, 3))
    assert gather(PLAN, tmp_path, parquet=False)[2] == 5
    run_ensemble(PLAN, tmp_path, workers=1, parquet=False, options=Options(), part=(2, 3))
    assert gather(PLAN, tmp_path, parquet=False)[2] == 0
    assert tables(tmp_path) == undisturbed


class Killing(LocalEngine):
    """Kills workers as calls come and go. One that was killed is let alone until it has answered a call, so that all
    get on, however long they take to start.
    """

    def __init__(self) -> None:
        super().__init__(2)
        self._chance = random.Random(1)
        self._at_work: set[int] = set()  # places that answered since they were started
        self.killed = 0

    def submit(self, call: Call) -> None:
        self._kill()
        super().submit(call)

    def wait(self, timeout: float) -> list[Answer]:
        answers = super().wait(timeout)
        self._at_work |= {int(answer.worker.rpartition("/")[2]) for answer in answers if not answer.lost}
        self._kill()
        return answers

    def _kill(self) -> None:
        for place in sorted(self._at_work):
            if self._chance.random() < 0.2:
                time.sleep(self._chance.uniform(0, 0.02))  # into a part
                os.kill(self.process_ids()[place], signal.SIGKILL)
                self._at_work.discard(place)
                self.killed += 1


def test_workers_may_be_killed(tmp_path: Path, undisturbed: Tables) -> None:
    engine = Killing()
    try:
        outcome = run(tmp_path, engine=engine, interval=0.02)
    finally:
        engine.close()
    assert engine.killed > 0 and outcome.done == JOBS and not outcome.given_up
    assert tables(tmp_path) == undisturbed


def command(*words: object) -> list[str]:
    return [sys.executable, "-m", "atoll", "ensemble", *map(str, words)]


def wait_at_a_gate(scene: atoll.Scene, parameters: dict[str, Any]) -> None:
    """A "setup" that lets no job go on before the gate's file is there."""
    gate = Path(os.environ["ATOLL_TEST_GATES"]) / str(parameters["user.gate"])
    gate.with_suffix(".reached").touch()
    while not gate.exists() and not stopping.asked():
        time.sleep(0.01)


@long_test
def test_the_driver_may_be_killed_and_stopped(tmp_path: Path, this_module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATOLL_TEST_GATES", str(tmp_path))
    signals = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
    gates = [
        {"scene": "pile:bodies=3", "steps": 20, "setup": f"{this_module}:wait_at_a_gate", "parameters": {"user.gate": [gate]}}
        for gate in range(len(signals))
    ]
    first, second = PLAN["studies"]
    gated = {**PLAN, "studies": [first, gates[0], second, gates[1], {"scene": "pile:bodies=20", "seeds": 4}, gates[2]]}
    jobs = JOBS + 4 + len(gates)
    plan, out = tmp_path / "plan.json", tmp_path / "out"
    plan.write_text(json.dumps(gated))
    words = command(plan, "--out", out, "--workers", 2, "--interval", 0.02, "--csv-only")
    for gate, number in enumerate(signals):
        reached = tmp_path / f"{gate}.reached"
        reached.unlink(missing_ok=True)  # by the worker that the gate did not hold back
        process = subprocess.Popen(
            words,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # which a shell's background ignores
        )
        while not reached.exists():
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(number)
        _, said = process.communicate(timeout=HANGS)
        if number == signal.SIGKILL:
            assert process.returncode == -signal.SIGKILL
        else:
            assert process.returncode == 128 + number
            assert b"the same command goes on" in said
        (tmp_path / str(gate)).touch()
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    assert f"{jobs} of {jobs} jobs done" in done.stdout
    run(tmp_path / "at once", gated)
    assert tables(out) == tables(tmp_path / "at once")


@long_test
def test_a_job_whose_workers_always_die_is_given_up(tmp_path: Path, this_module: str) -> None:
    plan = {"scene": "pile:bodies=3", "steps": 20, "observe": f"{this_module}:die"}
    outcome = run(tmp_path, plan)
    assert outcome.done == 0 and outcome.tally.lost_parts == MOST_LOSSES
    assert "was killed by signal 9" in outcome.given_up[0]


def die(world: atoll.World, scene: atoll.Scene) -> dict[str, float]:
    os.kill(os.getpid(), signal.SIGKILL)
    return {}


def test_two_can_not_run_it_at_once(tmp_path: Path) -> None:
    store = Store(tmp_path)
    with pytest.raises(EnsembleError, match="another process runs this ensemble"):
        run(tmp_path)
    store.close()


# --- What happens to files


def stop_once(out: Path, enough: Callable[[Tally], bool], **options: Any) -> None:
    """Stops an ensemble as soon as enough is done. Without second runs, which have snapshots of their own: all that is
    under way is of jobs that aren't done.
    """
    observed: list[bool] = []
    outcome = run_ensemble(
        PLAN,
        out,
        workers=2,
        parquet=False,
        options=Options(verify=0, **options),
        watch=lambda tally, under_way: observed.append(enough(tally)),
        stop=lambda: any(observed),
    )
    assert not outcome.finished


def stopped_midway(out: Path) -> None:
    """An ensemble of which some jobs are done, and some have snapshots."""
    stop_once(out, lambda tally: tally.done > 0)
    # Each part is one step: no job can be done by then.
    stop_once(out, lambda tally: tally.snapshots > 8, interval=0)


@pytest.mark.parametrize("harm", ["flip", *(pytest.param(harm, marks=long_test) for harm in ("cut", "empty", "remove"))])
def test_a_snapshot_that_is_corrupt_costs_its_job_alone(tmp_path: Path, undisturbed: Tables, harm: str) -> None:
    stopped_midway(tmp_path)
    snapshots = sorted((tmp_path / "snapshots").glob("*.snapshot"))
    assert snapshots
    for path in snapshots:
        content = bytearray(path.read_bytes())
        content[-5] ^= 1
        if harm == "remove":
            path.unlink()
        else:
            path.write_bytes({"flip": bytes(content), "cut": bytes(content[:-100]), "empty": b""}[harm])
    outcome = run(tmp_path)
    assert 0 < outcome.tally.begun_anew <= len(snapshots)
    store = Store(tmp_path)
    assert any(kind == "snapshot" and "begins anew" in what for kind, what in store.events())
    store.close()
    assert tables(tmp_path) == undisturbed


def test_a_full_disk_loses_nothing(tmp_path: Path, undisturbed: Tables) -> None:
    plan = tmp_path / "plan.json"
    plan.write_text(json.dumps(PLAN))
    words = command(plan, "--out", tmp_path / "out", "--workers", 2, "--interval", 0.02, "--csv-only")
    # No file may become larger: as on a disk that is full, writes fail in the middle.
    limit = 16 * 1024
    process = subprocess.run(
        words, capture_output=True, text=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    )
    assert process.returncode == 1 and len(process.stderr.splitlines()) == 1, process.stderr
    assert "File too large" in process.stderr or "can't be written" in process.stderr or "can't be opened" in process.stderr
    subprocess.run(words, check=True, capture_output=True)
    assert tables(tmp_path / "out") == undisturbed


def test_a_table_that_can_not_be_written_is_told_and_written_later(tmp_path: Path, undisturbed: Tables) -> None:
    (tmp_path / "results.csv").mkdir()
    with pytest.raises(EnsembleError, match="the table can't be written: .*; results are kept"):
        run(tmp_path)
    (tmp_path / "results.csv").rmdir()
    assert run(tmp_path).tally.done == 0
    assert tables(tmp_path) == undisturbed
    with pytest.raises(EnsembleError, match="can't be written"):
        run(Path("/proc/none"))


# --- Who computes other bits


def turn_one_bit(scene: atoll.Scene, parameters: dict[str, Any]) -> None:
    """In one of the processes that call it, for as long as that lives: a body lies one bit off."""
    global _held
    if _held is None:
        _held = open(os.environ["ATOLL_TEST_BAD_WORKER"], "a")
    try:
        fcntl.flock(_held, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return
    bodies = scene.bodies
    definition = bodies[-1].definition
    definition.position = np.nextafter(definition.position, math.inf)
    bodies[-1].definition = definition
    scene.bodies = bodies


_held: Any = None


def test_a_worker_with_wrong_bits_is_named_and_set_aside(
    tmp_path: Path, this_module: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = {"scene": "pile:bodies=10", "steps": 60, "seeds": 12, "setup": f"{this_module}:turn_one_bit"}
    (tmp_path / "lock").touch()
    with open(tmp_path / "lock") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        monkeypatch.setenv("ATOLL_TEST_BAD_WORKER", str(tmp_path / "lock"))
        run(tmp_path / "right", plan)
    wrong = run(tmp_path / "wrong", plan, verify=0.2)
    assert len(wrong.distrusted) == 1, wrong
    worker, why = wrong.distrusted[0]
    assert "/" in worker and "came to another state after step" in why
    assert wrong.tally.set_aside > 0 or wrong.tally.done == 12
    assert tables(tmp_path / "wrong") == tables(tmp_path / "right")


class Forger(LocalEngine):
    """Of whose two workers one turns a bit of all hashes that it tells."""

    def wait(self, timeout: float) -> list[Answer]:
        answers = super().wait(timeout)
        for answer in answers:
            if answer.worker.endswith("/1") and answer.value is not None:
                for number, check in enumerate(answer.value.checks):
                    answer.value.checks[number] = type(check)(check.step, check.hash ^ 1)
        return answers


def test_all_that_a_distrusted_worker_computed_is_computed_again(tmp_path: Path, undisturbed: Tables) -> None:
    engine = Forger(2)
    try:
        outcome = run(tmp_path, engine=engine, verify=0.3)
    finally:
        engine.close()
    assert [worker.rpartition("/")[2] for worker, _ in outcome.distrusted] == ["1"]
    store = Store(tmp_path)
    assert all("/1" not in result.worker for result in store.results().values())
    store.close()
    assert tables(tmp_path) == undisturbed
    assert len(run(tmp_path).distrusted) == 1
    assert not run(tmp_path, trust_all=True).distrusted


# --- Plans


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"scene": "pyle"}, "pyle"),
        ({"scene": "p" * 5000}, "ppp"),
        ({"scene": 3}, "scene: found 3; expected a scene's name"),
        ({"steps": 0}, "steps: found 0; expected an integer"),
        ({"stepps": 3}, 'found "stepps"; expected'),
        ({"seeds": [1, 1]}, "seeds: found .*; expected how many, or a list of different"),
        ({"parameters": {"frictoin": 1}}, "parameters: frictoin: no such parameter; expected"),
        ({"parameters": {"mass": -1}}, "parameters: mass: found -1; expected a number above 0"),
        ({"parameters": {"mass": 10**400}}, "parameters: mass: found 1.*; expected a number above 0"),
        ({"parameters": {"mass": {"uniform": [2, 1]}}, "sample": {"count": 2}}, "uniform: found 2 and 1"),
        ({"parameters": {"mass": {"uniform": [1, 2]}}}, 'sample: found nothing; expected an object with a "count"'),
        ({"parameters": {"mass": {"from": 1, "to": 2, "count": 1}}}, "count: found 1; expected an integer, 2 or more"),
        ({"parameters": {"mass": []}}, "mass: found an empty list"),
        ({"parameters": {"gravity": [1, 2]}}, "gravity: found .*; expected three numbers"),
        ({"parameters": {"user.x": 1}}, 'found user.x; expected it beside a "setup"'),
        ({"setup": "nothing:here"}, "setup: nothing:here can't be imported"),
        ({"keep": {"observables": ["hight"]}}, 'observables: found "hight"; expected some of max_height'),
        ({"keep": {"series": 2.5}}, "series: found 2.5; expected a number of steps, or 0"),
        ({"keep": {"series": 10}}, 'series: found nothing to tell; expected "observables", or "observe" in all studies'),
        ({"sample": {"count": 3}}, "no parameter is drawn"),
    ],
)
def test_mistakes_in_a_plan_are_told(change: dict[str, Any], said: str) -> None:
    plan: dict[str, Any] = {"scene": "pile:bodies=2", "steps": 5}
    with pytest.raises(atoll.Error, match=said):
        read_plan(plan | change)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"scene": "pile",}', r"plan\.json:1:18: "),
        ('{"scene": "pile", "scene": "stack"}', 'found "scene" twice'),
        ("[]", r"found \[\]; expected an object"),
        ("[" * 100_000, "expected JSON"),
        ('{"steps": ' + "9" * 5000 + "}", "expected JSON"),
        (None, "can't be read: No such file"),
    ],
)
def test_plans_that_are_no_plans_are_told(tmp_path: Path, text: str | None, said: str) -> None:
    path = tmp_path / "plan.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(PlanError, match=said):
        read_plan(path)
    process = subprocess.run(command(path, "--out", tmp_path / "out"), capture_output=True, text=True)
    assert process.returncode == 3 and "plan.json" in process.stderr
    assert not (tmp_path / "out").exists()


def test_a_job_of_bad_inputs_is_a_row_that_says_why(tmp_path: Path) -> None:
    outcome = run(tmp_path, {"scene": "pile:bodies=2", "steps": 5, "parameters": {"settings.substeps": [2, -1]}})
    assert outcome.table is not None and outcome.failed == 1
    good, bad = outcome.table.rows
    assert (good["outcome"], bad["outcome"]) == ("done", "failed")
    assert "substeps" in bad["why"] and "-1" in bad["why"]


def samples(method: str, count: int, seed: int = 1) -> np.ndarray[Any, np.dtype[np.float64]]:
    parameters = {"mass": {"uniform": [1, 2]}, "material.friction": {"log_uniform": [0.1, 1]}}
    plan = {"scene": "stack", "parameters": parameters, "sample": {"count": count, "method": method, "seed": seed}}
    return np.array([list(job.parameters.values()) for job in read_plan(plan).jobs()], dtype=np.float64)


def test_a_latin_hypercube_has_one_sample_in_each_row_and_column() -> None:
    pytest.importorskip("scipy")
    found = samples("latin-hypercube", 20)
    unit = np.stack([found[:, 0] - 1, np.log10(found[:, 1]) + 1], axis=1)
    for column in np.floor(unit * 20).astype(int).T:
        assert sorted(column) == list(range(20))


def test_samples_are_those_of_their_seed() -> None:
    assert np.array_equal(samples("random", 9), samples("random", 9))
    assert not np.array_equal(samples("random", 9), samples("random", 9, seed=2))


def test_keys_tell_jobs_apart() -> None:
    plan = {"scene": "pile:bodies=2", "steps": 5, "seeds": 3, "parameters": {"mass": [1, 2], "dt": [0.01, 0.02]}}
    keys = [job.key for job in read_plan(plan).jobs()]
    assert len(set(keys)) == 12
    assert keys == [job.key for job in read_plan(json.loads(json.dumps(plan))).jobs()]


# --- Engines


def double(number: int) -> int:
    return 2 * number


@pytest.fixture
def engine() -> Iterator[LocalEngine]:
    made = LocalEngine(2)
    yield made
    made.close()


def answers_of(engine: LocalEngine, count: int) -> list[Answer]:
    found: list[Answer] = []
    end = time.monotonic() + HANGS
    while len(found) < count and time.monotonic() < end:
        found += engine.wait(0.5)
    return found


def test_calls_get_answers(engine: LocalEngine) -> None:
    numbers: list[Callable[..., Any]] = [math.sqrt, math.log]
    for ticket in range(10):
        engine.submit(Call(ticket, numbers[ticket % 2], (float(ticket),)))
    found = sorted(answers_of(engine, 10), key=lambda answer: answer.ticket)
    assert [answer.value for answer in found[::2]] == [math.sqrt(number) for number in range(0, 10, 2)]
    engine.submit(Call(10, math.sqrt, (-1.0,)))
    assert isinstance(answers_of(engine, 1)[0].error, ValueError)


def test_calls_avoid_workers(engine: LocalEngine) -> None:
    engine.submit(Call(0, os.getpid))
    engine.submit(Call(1, time.sleep, (0.1,)))
    names = frozenset(answer.worker for answer in answers_of(engine, 2))
    assert len(names) == 2
    one = next(iter(names))
    for ticket in range(4):
        engine.submit(Call(ticket, os.getpid, (), frozenset([one])))
    assert {answer.worker for answer in answers_of(engine, 4)} == names - {one}
    engine.submit(Call(5, os.getpid, (), names))
    assert "no worker is left" in answers_of(engine, 1)[0].lost
