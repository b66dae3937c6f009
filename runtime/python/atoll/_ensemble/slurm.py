"""Batch scripts that run an ensemble on a cluster with Slurm: a job array whose tasks compute a part each, and a job
that gathers the table of all parts when they have ended.

What it uses of Slurm, where `man sbatch` tells more:

- A job array. Task I of N runs `atoll ensemble PLAN --out DIR --part I/N` on the processors that it is given, so DIR
  has to be on a file system that all nodes share. A site's `MaxArraySize`, 1001 by default, bounds N.
- `--signal=B:USR1@60`: a minute before its time limit, Slurm sends SIGUSR1 to a task's shell and nothing else. The shell
  stops the command by SIGTERM and, if that had not finished (status 143), asks for the task to be queued again.
- SIGTERM, which Slurm sends to all processes of a task that it ends, shell and command alike. The shell doesn't pass it
  on, as the command would get it twice, and doesn't queue the task again, as `scancel` would not end it then.
- `--requeue`: Slurm itself queues a task again that a job of higher priority preempted or whose node failed.
- `--dependency=afterany`: the job that gathers waits for all tasks to end for good, and tells what they left undone.

A task that is queued again runs the same command, which goes on from what the part's file has. So does the whole when
it is submitted again: by the user after `scancel`, or where a site cancels what it preempts instead of queueing it.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path

from .engines import EngineError
from .whole_file import write_whole

#: s, before a task's time limit, at which it is stopped. Slurm may do so up to a minute earlier.
STOP_BEFORE = 60

# `kill -0` tells whether `wait` came back because of a signal: then the command still runs. SIGTERM comes to the command as
# well, and is ignored by the shell, once that has started it: with a trap bash 5.2 ended with 255 once in 200 times when a
# second one came, on a busy machine.
_TASK = """\
warned=
trap 'warned=yes; kill -TERM "$!"' USR1
{command} --engine local --workers "$SLURM_CPUS_PER_TASK" --part "$SLURM_ARRAY_TASK_ID/{tasks}" &
trap '' TERM
while wait "$!"; kill -0 "$!" 2>/dev/null; do :; done
wait "$!"
status=$?
if [ "$status" -eq 143 ] && [ -n "$warned" ]; then
  # One task has the number of the whole array as its SLURM_JOB_ID, by which all tasks would be queued again.
  scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID"
fi
exit "$status"
"""


def write_script(
    plan: Path, out: Path, *, tasks: int, workers: int, command: Sequence[str], options: Sequence[str] = ()
) -> Path:
    """Writes `out`/ensemble.sbatch, a job array of `tasks` tasks with `workers` processors each, and `out`/gather.sbatch.

    `command` is what nodes run as `python -m atoll`, a word each. `options` are more of sbatch's, for both scripts, such
    as "--time=02:00:00" and "--partition=short"; the number of tasks and of processors is not theirs to set. Returns
    the path of the first. Raises EngineError where an option or a path can't be written into a script.
    """
    if tasks < 1 or workers < 1:
        raise EngineError(f"Slurm: found {tasks} tasks of {workers} workers; expected one or more")
    out = out.absolute()
    logs = out / "logs"
    logs.mkdir(parents=True, exist_ok=True)  # Slurm makes no directory of an output file
    words = shlex.join([*command, "ensemble", str(plan.absolute()), "--out", str(out)])
    script = out / "ensemble.sbatch"
    array = ["--job-name=atoll-ensemble", _output(logs, "part-%a.log"), "--open-mode=append", "--requeue"]
    array += [f"--signal=B:USR1@{STOP_BEFORE}", *_checked(options)]
    array += [f"--array=0-{tasks - 1}", "--nodes=1", "--ntasks=1", f"--cpus-per-task={workers}"]
    _write(script, array, _TASK.format(command=words, tasks=tasks))
    gather = ["--job-name=atoll-gather", _output(logs, "gather.log"), *_checked(options)]
    gather += ["--nodes=1", "--ntasks=1", "--cpus-per-task=1"]
    _write(out / "gather.sbatch", gather, f"exec {words} --gather\n")
    return script


def how_to_submit(script: Path) -> str:
    """Lines for a shell that submit what `write_script()` wrote."""
    gather = script.with_name("gather.sbatch")
    return (
        f"job=$(sbatch --parsable {shlex.quote(str(script))})\n"
        f'sbatch --dependency=afterany:"${{job%%;*}}" {shlex.quote(str(gather))}\n'
    )


def _checked(options: Sequence[str]) -> Sequence[str]:
    for option in options:
        if not option.startswith("-") or "\n" in option:
            raise EngineError(f'Slurm: found the option "{option}"; expected one of sbatch, such as "--time=02:00:00"')
    return options


def _output(logs: Path, name: str) -> str:
    """The option for where output goes. sbatch reads quotes as a shell does, and % as the begin of a pattern."""
    if "\\" in str(logs) or "\n" in str(logs):
        raise EngineError(f"Slurm: found the directory {str(logs)!r}; expected one without backslashes and line breaks")
    return "--output=" + shlex.quote(str(logs).replace("%", "%%") + "/" + name)


def _write(path: Path, options: Iterable[str], body: str) -> None:
    """So that whoever submits it meanwhile reads the old script or the new one."""
    lines = "".join(f"#SBATCH {option}\n" for option in options)
    write_whole(path, f"#!/bin/bash\n{lines}\n{body}".encode())
