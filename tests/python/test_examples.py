"""Every example runs, and the quick start of the README."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, long_test

FOLDER = ROOT / "runtime/python"
# Words that a run of each example must print, on any machine.
WORDS = {
    "back_in_time.py": "the same bits",
    "conveyor.py": "parcel 4 at 1.50 m/s",
    "crank.py": "turns in 2 s",
    "dominoes.py": "40 of 40 fell",
    "error_of_a_scene.py": "8 substeps",
    "learn_to_balance.py": "learned: ",
    "learn_to_hop.py": "it hops",
    "follow_a_path.py": "within a centimetre: True",
    "falling_crate.py": "it rests with 1471 N",
    "lidar.py": "rays met",
    "one_way_platform.py": "it rose to",
    "orbit.py": "64 substeps",
    "pendulum_error.py": " 64 substeps",
    "plan_a_push.py": "the crate is there",
    "rollback.py": "gets within",
}
#: Takes both cores for seconds. In the daily run learn_to_balance.py learns.
LONG = {"learn_to_hop.py"}


def output_of(*arguments: str, folder: Path | None = None) -> str:
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=3600, cwd=folder, env=os.environ)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_all_examples_are_known() -> None:
    assert set(WORDS) == {path.name for path in FOLDER.glob("examples/*.py")}


@pytest.mark.parametrize("name", [pytest.param(name, marks=long_test) if name in LONG else name for name in WORDS])
def test_example_runs(name: str) -> None:
    path = FOLDER / "examples" / name
    assert WORDS[name] in output_of(str(path))
    assert len(path.read_text().splitlines()) <= 45


def test_quick_starts_run(tmp_path: Path) -> None:
    import atoll

    for text in ((ROOT / "README.md").read_text(), (FOLDER / "README.md").read_text(), atoll.__doc__ or ""):
        blocks = re.findall(r"```python\n(.*?)```", text, re.S) or [re.sub(r"(?m)^    ", "", text[text.index("    import atoll") :])]
        assert blocks
        for number, block in enumerate(blocks):
            script = tmp_path / f"block{number}.py"
            script.write_text(block)
            assert output_of(str(script), folder=tmp_path)
