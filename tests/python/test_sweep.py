"""Sweeps: the table has what the settings come to, under the command's names of columns."""

from __future__ import annotations

import inspect
import itertools
import os
import signal
import stat
import sys
import threading
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atoll
from atoll import _core, _sweep, _sweep_parts
from atoll._ensemble.engines import Answer, Call, LocalEngine

# The first columns of the command's results.csv: see tests/cli/sweep_test.cpp.
FIRST_COLUMNS = (
    "scene,engine,label,default,outcome,why,steps,dt,substeps,target,iterations,friction,warm_start,relax_iterations,"
    "stabilisation,contact_solver,joint_solver,tolerance,threads,simd,options,cpu_s_per_simulated_s,cpu_min,cpu_max,"
    "ms_per_step,ms_min,ms_max"
).split(",")
FEW: dict[str, Any] = {"quick": True, "steps": 20, "repeats": 1, "time": 1e-6, "progress": False, "simd": "auto"}
ONE: dict[str, Any] = {**FEW, "substeps": 4, "iterations": 1}


def test_rows_are_runs_of_the_scenes_with_the_commands_columns() -> None:
    table = atoll.sweep(["stack:height=3", "pendulum"], substeps=[2, 8], iterations=[1, 2], **FEW)
    assert table.columns[: len(FIRST_COLUMNS)] == FIRST_COLUMNS
    assert {"penetration_mean", "analytic_error", "contact_residual_max"} <= set(table.columns)
    assert len(table) == len(table.rows) == len(list(table))
    first = table.rows[0]
    assert first["scene"] == "stack:height=3,ratio=1" and first["engine"] == "Atoll" and first["label"] == "default" and first["default"] is True
    assert first["substeps"] == 4 and first["outcome"] == "done" and first["options"] == ""
    assert first["analytic_error"] is None
    stack = table["scene"] == first["scene"]
    assert set(zip(table["substeps"][stack].tolist(), table["iterations"][stack].tolist())) >= {(2, 1), (2, 2), (8, 1), (8, 2)}
    assert table["substeps"].dtype == np.int64 and table["default"].dtype == np.bool_ and table["dt"].dtype == np.float64
    assert table["tolerance"].dtype == np.float64 and table["scene"].dtype.kind == "U"
    assert np.isnan(table["analytic_error"][stack]).all() and np.isfinite(table["analytic_error"][~stack]).all()
    assert (table["ms_per_step"] > 0).all() and (table["ms_min"] <= table["ms_max"]).all()


def test_errors_are_those_of_the_audit() -> None:
    scene = atoll.load_scene("wall:base=4")
    scene.steps = 25
    table = atoll.sweep(scene, **{**ONE, "steps": None, "substeps": [1, 8]})
    for label, substeps in [("default", 4), ("1 substep", 1), ("8 substeps", 8)]:
        (row,) = (row for row in table if row["label"] == label)
        settings = scene.settings
        settings.substeps = substeps
        scene.settings = settings
        world, meter = scene.build(), atoll.ErrorMeter(scene)
        for step in range(1, 26):
            world.step(scene.dt)
            meter.observe(step * scene.dt, world)
        for name, error in meter.errors().items():
            assert row[name] == error


def test_settings_are_taken_in_any_form() -> None:
    table = atoll.sweep(
        "stack:height=2",
        dt=[1 / 30, "1/120"],
        target=[1e-3, "off"],
        friction=[atoll.FrictionModel.PYRAMID],
        stabilisation=[atoll.Stabilisation.SPLIT_IMPULSE],
        warm_start=[True, False],
        relax_iterations=np.arange(2),
        tolerance=1e-3,
        threads=2,
        **ONE,
    )
    labels = list(table["label"])
    assert labels[0] == "default" and len(labels) == len(set(labels))
    for label in ("dt 1/30 s", "dt 1/120 s", "target 1 mm", "friction pyramid", "warm start off", "0 relax iterations", "2 threads"):
        assert label in labels
    assert "split_impulse" in table["stabilisation"]
    assert set(table["steps"][table["dt"] == 1 / 30]) == {10}


def test_what_a_sweep_does_not_take_is_told() -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"substeps": [0]}, r'sweep: substeps: found "0", expected an integer in \[1, 1024\]'),
        ({"iterations": 1.5}, r'sweep: iterations: found "1.5", expected an integer'),
        ({"friction": "wedge"}, r'sweep: friction: found "wedge", expected cone or pyramid'),
        ({"warm_start": 1}, r'sweep: warm_start: found "1", expected on or off'),
        ({"steps": 0}, r"sweep: steps is 0; expected a number above 0"),
        ({"repeats": -1}, r"sweep: repeats is -1"),
        ({"time": float("nan")}, r"sweep: time is nan"),
        ({"peer_limit": 0}, r"sweep: peer_limit is 0"),
        ({"peers": ["/nowhere/driver"]}, r"sweep: peers: cannot run /nowhere/driver: No such file"),
    ]
    for options, words in cases:
        with pytest.raises(atoll.Error, match=words):
            atoll.sweep("stack:height=2", **{**ONE, **options})
    with pytest.raises(atoll.SceneError, match="stak"):
        atoll.sweep("stak", **ONE)
    with pytest.raises(TypeError):
        atoll.sweep([3], **ONE)  # type: ignore[list-item]
    with pytest.raises(atoll.Error, match='found the column "cpu"; expected one of scene, engine'):
        atoll.sweep("stack:height=2", **ONE)["cpu"]


def test_every_axis_is_an_argument() -> None:
    """Those of the table that are settings, as C++ has them."""
    first, last = FIRST_COLUMNS.index("substeps"), FIRST_COLUMNS.index("options")
    columns = atoll.sweep("stack:height=2", **ONE).columns
    settings = columns[first : columns.index("options")]
    assert settings == FIRST_COLUMNS[first:last]
    assert {*settings, "dt"} <= set(inspect.signature(atoll.sweep).parameters)


def test_other_engines_have_rows_too(tmp_path: Path) -> None:
    driver = tmp_path / "driver.py"
    driver.write_text(
        f"#!{sys.executable}\n"
        "import json, sys\n"
        "if '--describe' in sys.argv:\n"
        "    print(json.dumps({'engine': 'Mock', 'version': '1', 'settings': [{'label': 'default', 'options': ['--fast', '1']}]}))\n"
        "elif '--errors' in sys.argv:\n"
        "    print(json.dumps({'errors': {'penetration_mean': 0.25}}))\n"
        "else:\n"
        "    print(json.dumps({'cpu_s_per_simulated_s': 0.5, 'ms_per_step': {'mean': 2}}))\n"
    )
    driver.chmod(driver.stat().st_mode | stat.S_IXUSR)
    table = atoll.sweep("stack:height=2", peers=[str(driver)], peer_limit=60, **ONE)
    row = table.rows[-1]
    assert row["engine"] == "Mock" and row["options"] == "--fast 1" and row["substeps"] is None
    assert row["penetration_mean"] == 0.25 and row["cpu_s_per_simulated_s"] == 0.5 and row["ms_per_step"] == 2
    assert table["substeps"].dtype == np.float64 and np.isnan(table["substeps"][-1])
    with pytest.raises(atoll.Error, match="sweep: found a Scene beside peers"):
        atoll.sweep(atoll.load_scene("stack:height=2"), peers=[str(driver)], **ONE)
    with pytest.raises(atoll.Error, match='found a second engine named "Mock", expected each once'):
        atoll.sweep("stack:height=2", peers=[str(driver)] * 2, **ONE)


TIMES = {"cpu_s_per_simulated_s", "cpu_min", "cpu_max", "ms_per_step", "ms_min", "ms_max"}
GRID: dict[str, Any] = {"quick": True, "steps": 20, "repeats": 1, "time": 1e-6, "progress": False}


def assert_same_but_times(table: atoll.SweepTable, undivided: atoll.SweepTable) -> None:
    assert table.columns == [*undivided.columns, "worker"]
    for name in undivided.columns:
        if name not in TIMES:
            assert [row[name] for row in table] == [row[name] for row in undivided], name
        else:
            assert [row[name] is None for row in table] == [row[name] is None for row in undivided]


def test_parts_on_workers_make_the_same_table(monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = ["stack:height=3", "pendulum"]
    undivided = atoll.sweep(scenes, **GRID)
    assert len(undivided) > 4 * _sweep_parts.PART_SIZE
    table = atoll.sweep(scenes, engine="local", workers=2, **GRID)
    assert_same_but_times(table, undivided)
    assert len(set(table["worker"])) == 2 and table["worker"].dtype.kind == "U"
    for size in (1, 3, len(undivided)):
        monkeypatch.setattr(_sweep_parts, "PART_SIZE", size)
        assert_same_but_times(atoll.sweep(scenes, engine=InPlace(), **GRID), undivided)


def test_parts_whose_runs_broke_have_no_errors() -> None:
    scene = atoll.load_scene("stack:height=2")
    scene.gravity = [0, 0, -1e8]  # breaks at the scene's own dt, and not at smaller ones
    undivided = atoll.sweep([scene, "pendulum"], **GRID)
    assert undivided.rows[0]["outcome"] == "non_finite" and undivided.rows[0]["penetration_mean"] is None
    assert any(row["outcome"] == "done" for row in undivided if row["scene"] == scene.name)
    assert_same_but_times(atoll.sweep([scene, "pendulum"], engine=InPlace(), **GRID), undivided)


def test_parts_of_what_others_can_not_read(tmp_path: Path) -> None:
    scene = atoll.load_scene("stack:height=2")
    scene.name = "of a script"
    scene.write(str(tmp_path / "scene.json"))
    given: list[str | atoll.Scene] = [scene, str(tmp_path / "scene.json"), "stack:height=2"]
    few: dict[str, Any] = {**ONE, "substeps": 4, "iterations": [1, 2]}
    engine = InPlace()
    assert_same_but_times(atoll.sweep(given, engine=engine, **few), atoll.sweep(given, **few))
    assert [isinstance(call.arguments[0], atoll.Scene) for call in engine.calls[:1] + engine.calls[-1:]] == [True, False]
    assert not any(str(tmp_path) in str(call.arguments) for call in engine.calls)
    with pytest.raises(atoll.Error, match="sweep: found the Scene pendulum.*, whose known motion can't be sent"):
        atoll.sweep(atoll.load_scene("pendulum"), engine=engine, **ONE)


def test_lost_parts_are_run_again() -> None:
    class Killing(LocalEngine):
        lost = 0

        def wait(self, timeout: float) -> list[Answer]:
            if self.lost == 0:
                os.kill(self.process_ids()[0], signal.SIGKILL)
            answers = super().wait(timeout)
            self.lost += sum(bool(answer.lost) for answer in answers)
            return answers

    scenes = ["stack:height=3", "pendulum"]
    engine = Killing(2)
    try:
        table = atoll.sweep(scenes, engine=engine, **GRID)
        assert engine.lost > 0
        assert_same_but_times(table, atoll.sweep(scenes, **GRID))
        assert_same_but_times(atoll.sweep(scenes[0], engine=engine, **ONE), atoll.sweep(scenes[0], **ONE))
    finally:
        engine.close()


class InPlace:
    """An engine that answers here, after some losses."""

    depth = 2

    def __init__(self, losses: int = 0) -> None:
        self.losses = losses
        self.calls: list[Call] = []
        self.waiting: list[Call] = []
        self.stopped = self.closed = False

    def places(self) -> int:
        return 1

    def submit(self, call: Call) -> None:
        self.calls.append(call)
        self.waiting.append(call)

    def wait(self, timeout: float) -> list[Answer]:
        call = self.waiting.pop()
        if self.losses > 0:
            self.losses -= 1
            return [Answer(call.ticket, "here", lost="here was unplugged")]
        try:
            return [Answer(-1, "of another sweep"), Answer(call.ticket, "here", call.function(*call.arguments))]
        except Exception as error:
            return [Answer(call.ticket, "here", error=error)]

    def stop(self) -> list[Answer]:
        self.stopped = True
        self.waiting.clear()
        return []

    def close(self) -> None:
        self.closed = True


def test_a_part_is_given_up_after_ten_retries() -> None:
    engine = InPlace(losses=10)
    assert len(atoll.sweep("stack:height=2", engine=engine, **ONE)) == len(atoll.sweep("stack:height=2", **ONE))
    assert len({call.ticket for call in engine.calls}) == len(engine.calls) and not engine.stopped and not engine.closed
    engine = InPlace(losses=11)
    words = "sweep: stack:height=2, settings .* workers were lost 11 times, at last: here was unplugged"
    with pytest.raises(atoll.Error, match=words):
        atoll.sweep("stack:height=2", engine=engine, **ONE)
    assert engine.stopped and not engine.closed


def test_what_a_sweep_on_workers_does_not_take_is_told() -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"substeps": [0]}, r'sweep: substeps: found "0", expected an integer'),
        ({"steps": 0}, r"sweep: steps is 0"),
        ({"repeats": -1}, r"sweep: repeats is -1"),  # which a worker raises
        ({"peers": ["driver"]}, r"sweep: found peers with an engine of workers; expected them on one machine"),
        ({"engine": None, "workers": 2}, r"sweep: found workers or an address without an engine"),
    ]
    for options, words in cases:
        with pytest.raises(atoll.Error, match=words):
            atoll.sweep("stack:height=2", **{**ONE, "engine": "local", "workers": 1, **options})
    with pytest.raises(atoll.SceneError, match="stak"):
        atoll.sweep("stak", engine="local", workers=1, **ONE)
    with pytest.raises(atoll.EnsembleError, match='found the engine "loacl"; expected one of local, ray'):
        atoll.sweep("stack:height=2", engine="loacl", **ONE)
    with pytest.raises(atoll.EnsembleError, match="workers is 0; expected 1 or more"):
        atoll.sweep("stack:height=2", engine="local", workers=0, **ONE)


def measure_part(part: tuple[int, int, int], scenes: list[str]) -> list[list[str]]:
    options: dict[str, Any] = {"quick": True, "steps": 2, "repeats": 1, "time": 1e-6, "seed": 1}
    lists = {name: ["1"] for name in ("substeps", "iterations")}
    return _core.measure_sweep(scenes, lists, **options, peers=[], peer_limit=None, on_work=print, part=part)[1]


def test_a_part_that_a_scene_has_not_is_told() -> None:
    (size,) = _core.sweep_sizes(["pendulum"], {"substeps": ["1"], "iterations": ["1"]}, quick=True, steps=2, seed=1)
    assert [row[0] for row in measure_part((1, 2, size), ["pendulum"])] == ["0", "1"]
    for begin, end in itertools.permutations((0, 2, -1, size + 1), 2):
        if (begin, end) != (0, 2):
            with pytest.raises(atoll.Error, match=f"found the part {begin} to {end}; expected a range in 0 to {size}"):
                measure_part((begin, end, size), ["pendulum"])
    with pytest.raises(atoll.Error, match=f"found {size} settings to try in pendulum.*, expected {size + 1} as on the machine"):
        measure_part((0, 1, size + 1), ["pendulum"])
    with pytest.raises(atoll.Error, match="found a part of 2 scenes and 0 peers; expected one scene"):
        measure_part((0, 1, size), ["pendulum"] * 2)


def test_columns_of_parts_whose_runs_broke_come_where_others_have_them() -> None:
    known: list[tuple[str, str]] = []
    for names in ("ac", "ac", "abc", "acd", "xacd"):
        _sweep_parts._add_columns(known, [(name, "number") for name in names])
    assert "".join(name for name, _ in known) == "xabcd"


class FakeBar:
    """As much of tqdm's as is asked of it."""

    made: list[FakeBar] = []

    def __init__(self, *, total: int, **options: object) -> None:
        self.total, self.n, self.closed, self.options = total, 0, False, options
        self.made.append(self)

    def update(self, more: int) -> None:
        self.n += more

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def bars(monkeypatch: pytest.MonkeyPatch) -> list[FakeBar]:
    monkeypatch.setattr(FakeBar, "made", [])
    monkeypatch.setitem(sys.modules, "tqdm", types.ModuleType("tqdm"))
    monkeypatch.setitem(sys.modules, "tqdm.auto", types.SimpleNamespace(tqdm=FakeBar))
    return FakeBar.made


def test_a_bar_of_tqdms_shows_how_far_it_is(bars: list[FakeBar]) -> None:
    atoll.sweep("stack:height=2", **{**ONE, "substeps": [1, 4], "progress": True})
    (bar,) = bars
    assert bar.n == bar.total > 0 and bar.closed and bar.options["disable"] is None
    atoll.sweep("stack:height=2", engine=InPlace(), **{**ONE, "substeps": [1, 4], "progress": True})
    assert bars[1].n == bars[1].total > 0 and bars[1].closed


def test_ctrl_c_ends_it(bars: list[FakeBar], monkeypatch: pytest.MonkeyPatch) -> None:
    under_way = threading.Event()

    def update(bar: FakeBar, more: int) -> None:
        bar.n += more
        under_way.set()

    monkeypatch.setattr(FakeBar, "update", update)

    def interrupt() -> None:
        under_way.wait()
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell's background ignores
    # The first scene is done in a second, the other one takes hours.
    scenes = ["stack:height=1", "pile:bodies=500"]
    with pytest.raises(KeyboardInterrupt):
        atoll.sweep(scenes, substeps=[1, 2, 4, 8], iterations=1, steps=100_000)
    signal.signal(signal.SIGINT, before)
    thread.join()
    (bar,) = bars
    assert bar.n < bar.total and bar.closed


def test_tqdm_is_no_requirement(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    assert len(atoll.sweep("stack:height=2", **{**ONE, "progress": True})) > 0


def small_table() -> atoll.SweepTable:
    columns = [("scene", "text"), ("default", "flag"), ("substeps", "integer"), ("error", "number"), ("why", "text")]
    return _sweep.SweepTable(columns, [["a<b", "1", "4", "0.10000000000000001", ""], ["c,d", "0", "", "", ""]])


def test_a_table_as_html_csv_and_words(tmp_path: Path) -> None:
    table = small_table()
    html = table._repr_html_()
    assert "<th>error</th>" in html and "<th>why</th>" not in html  # which is empty
    assert "<td>a&lt;b</td><td>True</td><td>4</td><td>0.1</td>" in html
    table.write_csv(tmp_path / "table.csv")
    assert (tmp_path / "table.csv").read_text() == 'scene,default,substeps,error,why\na<b,True,4,0.1,\n"c,d",False,,,\n'
    assert repr(table) == "<SweepTable of 2 runs, 2 scenes, 5 columns>"


def test_a_table_as_a_data_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    taken: dict[str, Any] = {}
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=lambda columns: taken.update(columns) or "frame"))
    assert small_table().to_pandas() == "frame"
    assert list(taken) == ["scene", "default", "substeps", "error", "why"]
    assert taken["error"][0] == 0.1 and np.isnan(taken["error"][1])
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pandas"):
        small_table().to_pandas()


def test_a_table_as_a_frame_of_the_real_pandas() -> None:
    pandas = pytest.importorskip("pandas")
    frame = atoll.sweep("stack:height=2", **{**ONE, "substeps": [1, 4]}).to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert frame.loc[frame["default"], "substeps"].tolist() == [4]
