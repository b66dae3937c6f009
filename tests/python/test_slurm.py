"""Batch scripts of ensembles: what they ask of Slurm, and what their shells do, with stand-ins for all other commands."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from atoll._ensemble.engines import EngineError
from atoll._ensemble.slurm import how_to_submit, write_script

from conftest import long_test

pytestmark = long_test

# Tells its words but the first two, and ends with the status that is the first: at once, or by SIGTERM.
STAND_IN = """\
import signal, sys, time
status, when, *words = sys.argv[1:]
def stop(*_):
    print("stopped", flush=True)
    sys.exit(int(status))
signal.signal(signal.SIGTERM, stop)
print(words, flush=True)
if when == "stopped":
    time.sleep(600)
sys.exit(int(status))
"""


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    """With a name that takes care."""
    made = tmp_path / "it's 100% \"my\" $dir {0}"
    made.mkdir()
    return made


def write(directory: Path, *, status: int = 0, when: str = "at once", options: tuple[str, ...] = ()) -> Path:
    (directory / "stand in.py").write_text(STAND_IN)
    command = [sys.executable, str(directory / "stand in.py"), str(status), when]
    return write_script(directory / "plan.json", directory / "out", tasks=8, workers=3, command=command, options=options)


def start_task(script: Path) -> subprocess.Popen[str]:
    """As Slurm would, task 5 of array 70."""
    commands = script.parent / "commands"
    commands.mkdir(exist_ok=True)
    scontrol = commands / "scontrol"
    scontrol.write_text('#!/bin/sh\necho "scontrol $*"\n')
    scontrol.chmod(0o700)
    slurm = {"SLURM_ARRAY_JOB_ID": "70", "SLURM_JOB_ID": "70", "SLURM_ARRAY_TASK_ID": "5", "SLURM_CPUS_PER_TASK": "3"}
    environment = {**os.environ, **slurm, "PATH": f"{commands}:{os.environ['PATH']}"}
    # In a group of its own, which Slurm signals as a whole.
    return subprocess.Popen(
        ["bash", str(script)], stdout=subprocess.PIPE, text=True, env=environment, start_new_session=True
    )


def first_line(task: subprocess.Popen[str]) -> str:
    assert task.stdout is not None
    return task.stdout.readline()


def words(directory: Path) -> list[str]:
    return ["ensemble", str(directory / "plan.json"), "--out", str(directory / "out")]


def test_scripts_ask_for_an_array_and_a_job_that_gathers(directory: Path) -> None:
    script = write(directory, options=("--time=02:00:00", "--account='my group'"))
    out = directory / "out"
    assert script == out / "ensemble.sbatch"
    assert sorted(path.name for path in out.iterdir()) == ["ensemble.sbatch", "gather.sbatch", "logs"]
    for name in ("ensemble.sbatch", "gather.sbatch"):
        assert subprocess.run(["bash", "-n", str(out / name)]).returncode == 0
    lines = script.read_text().splitlines()
    assert lines[0] == "#!/bin/bash"
    asked = [shlex.split(line)[1] for line in lines if line.startswith("#SBATCH ")]
    assert asked == [
        "--job-name=atoll-ensemble",
        f"--output={out}/logs/part-%a.log".replace("100%", "100%%"),
        "--open-mode=append",
        "--requeue",
        "--signal=B:USR1@60",
        "--time=02:00:00",
        "--account=my group",
        "--array=0-7",
        "--nodes=1",
        "--ntasks=1",
        "--cpus-per-task=3",
    ]
    # sbatch reads no further than the first line that is a command.
    assert lines.index("#SBATCH --cpus-per-task=3") == len(asked)
    gather = (out / "gather.sbatch").read_text()
    assert "--array" not in gather and "--time=02:00:00" in gather and "--cpus-per-task=1\n" in gather
    write(directory)
    assert "--time" not in script.read_text()


@pytest.mark.parametrize("status", [0, 1, 143])
def test_a_task_runs_its_part_and_ends_as_that_does(directory: Path, status: int) -> None:
    task = start_task(write(directory, status=status))
    out, _ = task.communicate(timeout=600)
    assert out == f"{[*words(directory), '--engine', 'local', '--workers', '3', '--part', '5/8']}\n"
    assert task.returncode == status


@pytest.mark.parametrize("status", [143, 0])
def test_near_its_time_limit_a_task_is_stopped_and_queued_again_if_it_has_more_to_do(directory: Path, status: int) -> None:
    task = start_task(write(directory, status=status, when="stopped"))
    first_line(task)
    os.kill(task.pid, signal.SIGUSR1)
    out, _ = task.communicate(timeout=600)
    assert out == "stopped\n" + ("scontrol requeue 70_5\n" if status == 143 else "")
    assert task.returncode == status


def test_a_task_that_slurm_ends_stops_once_and_is_not_queued_again(directory: Path) -> None:
    task = start_task(write(directory, status=143, when="stopped"))
    first_line(task)
    os.kill(task.pid, signal.SIGTERM)  # to the shell, which leaves the command alone
    time.sleep(0.2)
    assert task.poll() is None
    os.killpg(task.pid, signal.SIGTERM)
    out, _ = task.communicate(timeout=600)
    assert out == "stopped\n"
    assert task.returncode == 143


def test_the_job_that_gathers_is_the_same_ensembles(directory: Path) -> None:
    script = write(directory)
    run = subprocess.run(["bash", str(script.with_name("gather.sbatch"))], capture_output=True, text=True)
    assert run.stdout == f"{[*words(directory), '--gather']}\n"
    assert run.returncode == 0


def test_lines_submit_one_after_the_other(directory: Path) -> None:
    script = write(directory)
    sbatch = directory / "sbatch"
    sbatch.write_text('#!/bin/sh\nprintf "<%s>" "$@" >> "$CALLS"\necho "70;cluster"\n')
    sbatch.chmod(0o700)
    calls = directory / "calls"
    environment = {**os.environ, "PATH": f"{directory}:{os.environ['PATH']}", "CALLS": str(calls)}
    run = subprocess.run(["bash", "-c", how_to_submit(script)], env=environment)
    assert run.returncode == 0
    gather = script.with_name("gather.sbatch")
    assert calls.read_text() == f"<--parsable><{script}><--dependency=afterany:70><{gather}>"


def test_refuses_what_no_script_can_say(tmp_path: Path) -> None:
    for option in ("time=1", "", "--time=1\nrm"):
        with pytest.raises(EngineError, match="expected one of sbatch"):
            write(tmp_path, options=(option,))
    with pytest.raises(EngineError, match="expected one or more"):
        write_script(tmp_path / "plan", tmp_path, tasks=0, workers=1, command=["atoll"])
    with pytest.raises(EngineError, match="without backslashes"):
        write_script(tmp_path / "plan", tmp_path / "a\\b", tasks=1, workers=1, command=["atoll"])
