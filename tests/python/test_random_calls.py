"""Whatever is called with whatever arguments: a result or an exception, and never the end of the interpreter."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import LONG_TESTS

CALLS = 200_000 if LONG_TESTS else 5_000


@pytest.mark.parametrize("seed", range(10 if LONG_TESTS else 2))
def test_calls_with_any_arguments_come_back(seed: int, tmp_path: Path) -> None:
    script = Path(__file__).with_name("random_calls.py")
    command = [sys.executable, str(script), str(seed), str(CALLS)]
    ran = subprocess.run(command, cwd=tmp_path, env=dict(os.environ), capture_output=True, check=False)
    output = ran.stderr.decode("utf-8", "replace")[-4000:]
    assert ran.returncode == 0, output
    assert int(ran.stdout.split()[0]) > CALLS / 10, output
