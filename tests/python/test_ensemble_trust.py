"""Ensembles tell what is wrong with functions, meshes, databases and jobs without end, and go on with the rest."""

from __future__ import annotations

import itertools
import json
import math
import os
import pickle
import random
import sqlite3
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import atoll
from atoll._ensemble import EnsembleError
from atoll._ensemble.driver import Options
from atoll._ensemble.job import Point, run_part
from atoll._ensemble.messages import is_plain, read_answer, read_call, write_answer, write_call
from atoll._ensemble.plan import read_plan
from atoll._ensemble.run import Outcome, run_ensemble

from conftest import LONG_TESTS

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
SMALL: dict[str, Any] = {"scene": "pile:bodies=3", "steps": 10}


def run(out: Path, plan: Any, **options: Any) -> Outcome:
    return run_ensemble(plan, out, workers=2, parquet=False, options=Options(**options))


@pytest.fixture
def this_module(monkeypatch: pytest.MonkeyPatch) -> str:
    """Its name, by which workers can import it."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    return Path(__file__).stem


def mesh_plan(folder: Path, obj: str) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "hull.obj").write_text(obj)
    body = {"shape": {"type": "hull", "file": "hull.obj"}, "position": [0, 0, 9], "angular_velocity": [1, 2, 3]}
    (folder / "scene.json").write_text(json.dumps({"format": "atoll-scene", "version": 1, "bodies": [body]}))
    (folder / "plan.json").write_text(json.dumps({"scene": "scene.json", "steps": 10}))
    return folder / "plan.json"


def test_a_mesh_lies_beside_its_scene_and_its_content_makes_the_result(tmp_path: Path) -> None:
    plan = mesh_plan(tmp_path / "plan", TETRAHEDRON)
    first = run(tmp_path / "out", plan)
    assert first.done == 1 and first.failed == 0 and first.table is not None, first
    scene = atoll.load_scene(str(tmp_path / "plan" / "scene.json"))
    world = scene.build()
    for _ in range(10):
        world.step(scene.dt)
    assert first.table.rows[0]["state_hash"] == f"{world.state_hash():016x}"
    second = run(tmp_path / "out", mesh_plan(tmp_path / "plan", TETRAHEDRON.replace("0 0 1", "0 0 2")))
    assert second.tally.done_before == 0 and second.table is not None
    assert second.table.rows[0]["state_hash"] != first.table.rows[0]["state_hash"]


def test_another_version_makes_other_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    [job] = read_plan(SMALL).jobs()
    before = job.key
    monkeypatch.setattr("atoll._core.version", "0.0.0")
    assert job.key != before


def nothing(world: atoll.World, scene: atoll.Scene) -> Any:
    return None


def text(world: atoll.World, scene: atoll.Scene) -> Any:
    return {"name": "text"}


def state_hash(world: atoll.World, scene: atoll.Scene) -> Any:
    return {"state_hash": 0}


def job_name(world: atoll.World, scene: atoll.Scene) -> Any:
    return {"job": 1}


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (nothing, "nothing: returned None; expected a dict of numbers by name"),
        (text, "text: returned 'text' as name; expected a number"),
        (state_hash, "state_hash: returned the name 'state_hash'; expected text that no other column has"),
        (job_name, "job_name: returned the name 'job'"),
    ],
)
def test_a_wrong_observe_costs_its_rows_alone(tmp_path: Path, this_module: str, function: Callable[..., Any], said: str) -> None:
    studies = [{**SMALL, "observe": f"{this_module}:{function.__name__}"}, SMALL]
    outcome = run(tmp_path, {"studies": studies})
    assert outcome.table is not None
    bad, good = outcome.table.rows
    assert (bad["outcome"], good["outcome"]) == ("failed", "done")
    assert said in bad["why"]


def place_anywhere(scene: atoll.Scene, parameters: dict[str, Any]) -> None:
    bodies = scene.bodies
    for body in bodies:
        definition = body.definition
        if definition.type == atoll.BodyType.DYNAMIC:
            definition.position = definition.position + random.random()
            body.definition = definition
    scene.bodies = bodies


def test_a_random_setup_is_blamed_and_no_worker(tmp_path: Path, this_module: str) -> None:
    outcome = run(tmp_path, {**SMALL, "setup": f"{this_module}:place_anywhere", "seeds": 4}, verify=1)
    assert not outcome.distrusted and outcome.table is not None
    assert [row["outcome"] for row in outcome.table.rows] == ["failed"] * 4
    assert "place_anywhere: two runs of one process differ" in outcome.table.rows[0]["why"]
    assert run(tmp_path, {**SMALL, "seeds": 4}, verify=1).failed == 0


def test_a_plan_without_functions_travels_as_text(this_module: str) -> None:
    def refuse(content: Any) -> Any:
        raise AssertionError("a pickle")

    [job] = read_plan({**SMALL, "keep": {"observables": ["max_height"], "series": 5, "state": True}}).jobs()
    call = write_call(run_part, (job, Point(3, 2**64 - 1), math.inf, "folder", b"\x00\xff", "name", 9), refuse)
    function, arguments = read_call(call, refuse)
    assert (function, arguments) == (run_part, (job, Point(3, 2**64 - 1), math.inf, "folder", b"\x00\xff", "name", 9))
    assert arguments[0].key == job.key
    part = run_part(job, None, math.inf, None)
    assert part.snapshot and part.series and part.result
    answer = write_answer(call, part, None, refuse)
    assert read_answer(call, answer, refuse) == (part, None)
    _, error = read_answer(call, write_answer(call, None, atoll.SceneError("why"), refuse), refuse)
    assert isinstance(error, atoll.SceneError) and str(error) == "why"
    _, error = read_answer(call, b"P" + pickle.dumps(part), refuse)  # no pickle is taken for an answer to it
    assert "can't be read" in str(error)
    [own] = read_plan({**SMALL, "observe": f"{this_module}:nothing"}).jobs()
    assert not is_plain(write_call(run_part, (own, None, 1.0, None), pickle.dumps))
    forged = write_call(run_part, (replace(own, code=""), None, 1.0, None), pickle.dumps)
    with pytest.raises(ValueError, match="a call that runs no functions"):
        read_call(forged, refuse)


def test_hostile_text_of_plans_and_answers_is_told(tmp_path: Path) -> None:
    """As a fuzzer does, but for its eyes: bytes of what is right turn, go and come again."""
    path = tmp_path / "plan.json"
    plan = {**SMALL, "parameters": {"mass": {"uniform": [1, 2]}, "dt": [0.01]}, "sample": {"count": 2, "seed": 3}}
    [job, _] = read_plan(plan).jobs()
    call = write_call(run_part, (job, None, math.inf, None), pickle.dumps)
    answer = write_answer(call, run_part(job, None, math.inf, None), None, pickle.dumps)
    chosen = random.Random(1)
    for _ in range(2000 if LONG_TESTS else 200):
        path.write_bytes(mutated(json.dumps(plan).encode(), chosen))
        try:
            assert len(read_plan(path)) >= 1
        except (atoll.Error, EnsembleError) as error:
            assert str(error)
        part, wrong = read_answer(call, mutated(answer, chosen), pickle.loads)
        assert (part is None) != (wrong is None)


def mutated(text: bytes, chosen: random.Random) -> bytes:
    for _ in range(chosen.choice((1, 1, 2, 8))):
        at = chosen.randrange(len(text))
        end = min(len(text), at + chosen.choice((1, 1, 4, 30)))
        kind = chosen.randrange(4)
        if kind == 0:
            text = text[:at] + bytes(chosen.randrange(256) for _ in range(end - at)) + text[end:]
        elif kind == 1:
            text = text[:at] + text[end:] or b"{"
        elif kind == 2:
            text = text[:end] + text[at:]
        else:
            piece = chosen.choice((b"null", b"-1", b"1e308", b"[]", b"{}", b'""', b"true", b"9" * 400))
            text = text[:at] + piece + text[end:]
    return text


def loop(world: atoll.World, scene: atoll.Scene) -> Any:
    while True:
        time.sleep(0.01)


def take_all(world: atoll.World, scene: atoll.Scene) -> Any:
    return {"size": len(bytearray(4_000_000_000))}


@pytest.mark.parametrize(
    ("function", "options", "said"),
    [
        (loop, {"job_seconds": 2.0}, "took longer than its limit"),
        (take_all, {"job_memory": 2_000_000_000}, "needs more memory than its limit of 2000 MB"),
    ],
)
def test_a_job_beyond_its_limit_is_given_up(
    tmp_path: Path, this_module: str, function: Callable[..., Any], options: dict[str, Any], said: str
) -> None:
    outcome = run(tmp_path, {"studies": [{**SMALL, "observe": f"{this_module}:{function.__name__}"}, SMALL]}, **options)
    assert outcome.finished and outcome.done == 1 and len(outcome.given_up) == 1
    assert said in outcome.given_up[0]


def test_flipped_bytes_in_the_database_are_told(tmp_path: Path) -> None:
    plan = {**SMALL, "seeds": 20, "keep": {"observables": ["max_height"], "series": 5}}
    run(tmp_path, plan)
    path = tmp_path / "ensemble.db"
    whole = path.read_bytes()
    table = (tmp_path / "results.csv").read_bytes()
    refused = 0
    seeds = 20 if LONG_TESTS else 5
    for seed, size in itertools.product(range(seeds), (1, 30, 1000)):
        chosen = random.Random(seed)
        damaged = bytearray(whole)
        for _ in range(size):
            damaged[chosen.randrange(len(damaged))] ^= 1 << chosen.randrange(8)
        path.write_bytes(damaged)
        try:
            run(tmp_path, plan)
        except EnsembleError as error:
            assert "ensemble.db" in str(error)
            refused += 1
    assert refused > seeds
    path.write_bytes(whole)
    run(tmp_path, plan)
    assert (tmp_path / "results.csv").read_bytes() == table


def test_a_row_that_is_none_is_told(tmp_path: Path) -> None:
    run(tmp_path, SMALL)
    with sqlite3.connect(tmp_path / "ensemble.db") as database:
        database.execute("UPDATE results SET row = '[1]'")
    with pytest.raises(EnsembleError, match="ensemble.db: is damaged: found"):
        run(tmp_path, SMALL)
