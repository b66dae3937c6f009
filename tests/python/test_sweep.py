"""Sweeps: the table has what the settings come to, under the command's names of columns."""

from __future__ import annotations

import inspect
import signal
import stat
import sys
import threading
import time
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atoll
from atoll import _sweep

# As the command's results.csv begins: see tests/cli/sweep_test.cpp.
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


def test_ctrl_c_ends_it() -> None:
    def interrupt() -> None:
        time.sleep(0.4)
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        atoll.sweep("pile:bodies=500", substeps=[1, 2, 4, 8], iterations=1, steps=100_000, progress=False)
    assert time.monotonic() - began < 30
    thread.join()


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


def test_a_bar_of_tqdms_shows_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeBar, "made", [])
    monkeypatch.setitem(sys.modules, "tqdm", types.ModuleType("tqdm"))
    monkeypatch.setitem(sys.modules, "tqdm.auto", types.SimpleNamespace(tqdm=FakeBar))
    atoll.sweep("stack:height=2", **{**ONE, "substeps": [1, 4], "progress": True})
    (bar,) = FakeBar.made
    assert bar.n == bar.total > 0 and bar.closed and bar.options["disable"] is None


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
