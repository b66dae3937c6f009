"""What calls functions on workers: here the processes of one machine, in `ray_engine` those of a cluster.

An engine knows nothing of jobs and snapshots. It takes calls, and gives an answer for each: a value, what the function
raised, or that the worker was lost. Whoever calls decides what to do then.
"""

from __future__ import annotations

import math
import multiprocessing.connection
import os
import pickle
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from . import EnsembleError
from .messages import read_answer, write_call

#: s, within which workers that are asked to stop have to.
STOP_WITHIN = 10.0


@dataclass(frozen=True)
class Call:
    """Of a function of a module, with arguments that can be pickled (see `messages`)."""

    ticket: int  #: by which its answer is known
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    avoid: frozenset[str] = frozenset()  #: names of workers that may not answer it
    prefer: str = ""  #: name of the worker that is best to; others may, rather than do nothing
    limit: float = math.inf  #: s, after which its worker is ended


@dataclass(frozen=True)
class Answer:
    """To a call. One of `error` and `lost` is set where there is no value."""

    ticket: int
    worker: str  #: its name, which stays the same for what may compute the same wrong bits: a place on a machine
    value: Any = None
    error: Exception | None = None  #: what the function raised
    lost: str = ""  #: why the worker is gone
    refused: bool = False  #: lost because no worker is left that may answer it
    overran: bool = False  #: lost because it took longer than its limit
    seconds: float = 0.0  #: wall time in the function; of a lost one since it was handed out, or 0 if nobody knows


class Engine(Protocol):
    """How calls get to workers."""

    #: Of calls for a place, that are best submitted at a time.
    depth: int

    def places(self) -> int:
        """How many calls it works on at a time. More may be submitted; they wait."""

    def submit(self, call: Call) -> None: ...

    def wait(self, timeout: float) -> list[Answer]:
        """Answers that have come, in any order; none after `timeout` s without one."""

    def stop(self) -> list[Answer]:
        """Asks what is under way to come to an end, and gives the answers. Calls that had not begun get none."""

    def close(self) -> None:
        """Ends all workers, whatever they do."""


def calls_at_a_time(engine: Engine) -> int:
    """That are best submitted. Some even where there is no place, for a cluster that grows once it is asked."""
    return engine.depth * max(1, engine.places())


def best_for(worker: str, calls: Iterable[Call]) -> int | None:
    """Index of the call that a worker should answer: one that prefers it, else one that prefers none, else any."""
    mine = ((call.prefer != worker, call.prefer != "", i) for i, call in enumerate(calls) if worker not in call.avoid)
    best = min(mine, default=None)
    return None if best is None else best[-1]


def late(worker: str, call: Call) -> str:
    """Why its worker was ended."""
    return f"took longer than its limit, of which {call.limit:.3g} s were left, on {worker}"


class EngineError(EnsembleError):
    """An engine can't be used as it was asked for."""


class LocalEngine:
    """Processes of this machine, a call at a time each."""

    depth = 2  # so that a worker goes on while its answer is looked at

    def __init__(self, workers: int | None = None, label: str = "") -> None:
        count = workers if workers is not None else len(os.sched_getaffinity(0))
        self._waiting: list[Call] = []
        self._workers = [_Worker(f"{socket.gethostname()}/{label}{place}") for place in range(count)]

    def places(self) -> int:
        return len(self._workers)

    def submit(self, call: Call) -> None:
        self._waiting.append(call)
        self._hand_out()

    def wait(self, timeout: float) -> list[Answer]:
        answers = self._refuse()
        self._hand_out()
        answers += [worker.answer() for worker in self._ready(0.0 if answers else timeout)]
        answers += [worker.overrun() for worker in self._busy() if worker.is_late()]
        self._hand_out()
        return answers

    def stop(self) -> list[Answer]:
        self._waiting.clear()
        for worker in self._busy():
            worker.process.send_signal(signal.SIGTERM)
        answers = []
        end = time.monotonic() + STOP_WITHIN
        while self._busy() and time.monotonic() < end:
            answers += [worker.answer() for worker in self._ready(end - time.monotonic())]
        return answers

    def close(self) -> None:
        for worker in self._workers:
            worker.end()

    def process_ids(self) -> list[int]:
        """Of the workers, by place."""
        return [worker.process.pid for worker in self._workers]

    def _refuse(self) -> list[Answer]:
        names = {worker.name for worker in self._workers}
        refused = [call for call in self._waiting if names <= call.avoid]
        self._waiting = [call for call in self._waiting if call not in refused]
        return [Answer(call.ticket, "", lost="no worker is left that may answer it", refused=True) for call in refused]

    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker.call is not None]

    def _ready(self, timeout: float) -> list[_Worker]:
        busy = {worker.connection: worker for worker in self._busy()}
        ready = multiprocessing.connection.wait(list(busy), max(0.0, timeout))
        return [worker for connection, worker in busy.items() if connection in ready]

    def _hand_out(self) -> None:
        for worker in self._workers:
            if worker.call is not None:
                continue
            index = best_for(worker.name, self._waiting)
            if index is not None:
                worker.begin(self._waiting.pop(index))


@dataclass
class _Worker:
    """A process that `worker.py` runs in, and the call that it works on."""

    name: str
    call: Call | None = None
    sent: bytes = b""  #: the call, as the process has it
    begun: float = 0.0  #: s, of the clock
    process: subprocess.Popen[bytes] = field(init=False)
    connection: multiprocessing.connection.Connection[Any, Any] = field(init=False)

    def __post_init__(self) -> None:
        self._start()

    def begin(self, call: Call) -> None:
        self.call, self.begun = call, time.monotonic()
        self.sent = write_call(call.function, call.arguments, pickle.dumps)
        try:
            self.connection.send_bytes(self.sent)
        except OSError:  # it was killed while it had nothing to do
            self._start()
            self.connection.send_bytes(self.sent)

    def answer(self) -> Answer:
        assert self.call is not None
        ticket, self.call = self.call.ticket, None
        try:
            seconds, _, message = self.connection.recv_bytes().partition(b"\n")
            value, error = read_answer(self.sent, message, pickle.loads)
            return Answer(ticket, self.name, value, error, seconds=float(seconds))
        except (EOFError, OSError):
            spent = time.monotonic() - self.begun
            self.process.wait()
            status = self.process.returncode
            self._start()
            why = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
            return Answer(ticket, self.name, lost=f"{self.name} {why}", seconds=spent)

    def is_late(self) -> bool:
        return self.call is not None and time.monotonic() - self.begun > self.call.limit

    def overrun(self) -> Answer:
        assert self.call is not None
        call, self.call = self.call, None
        self.end()
        self._start()
        return Answer(call.ticket, self.name, lost=late(self.name, call), overran=True, seconds=time.monotonic() - self.begun)

    def end(self) -> None:
        self.connection.close()
        self.process.kill()
        self.process.wait()

    def _start(self) -> None:
        ours, its = socket.socketpair()
        package = Path(__file__).parents[2]
        path = os.pathsep.join([str(package), *filter(None, [os.environ.get("PYTHONPATH")])])
        # In a session of its own, so that a Ctrl-C at the terminal comes to whoever started it alone.
        self.process = subprocess.Popen(
            [sys.executable, "-m", "atoll._ensemble.worker", str(its.fileno())],
            pass_fds=[its.fileno()],
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            env={**os.environ, "PYTHONPATH": path},
        )
        its.close()
        self.connection = multiprocessing.connection.Connection(ours.detach())
