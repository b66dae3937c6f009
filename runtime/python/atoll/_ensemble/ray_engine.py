"""Calls functions on the nodes of a Ray cluster: by actors, each a process with a CPU of its own.

Ray finds nodes for them, starts them, and finds out when one or its node is gone. It restarts and retries nothing:
whoever uses the engine gets an answer that says that the worker was lost.

Actors, not tasks. Nodes pass tasks that wait for a CPU on to each other: with two running and two waiting on two nodes,
of 0.25 s each, Ray took 0.6 of a core for that, and the calls a quarter more time; with actors it took nothing that could
be measured. Tasks that are at a node that can't be reached may hang for good (ray-project/ray, issue 63405). And of a
task nobody knows where it runs.

Nodes need the same versions of Python, of Ray and of atoll as the driver. A driver whose atoll lies elsewhere than in
site-packages has nodes look for it under the same path. The driver has to run on a node too, which may be one that takes
no calls (`ray start --num-cpus=0`).

To empty a node, drain it (an autoscaler does, or `ray drain-node --node-id ... --deadline-remaining-seconds ...`): it
gets no more calls, those that it has are asked to end, and its actors end then.

A node that hangs or can't be reached is found by the head's health checks. It takes them 65 s; with
RAY_health_check_period_ms=1000, RAY_health_check_timeout_ms=1000 and RAY_health_check_failure_threshold=3 in the
environment of `ray start --head`, 7 s. A node that was given up ends itself when it is reached again, and is to be
started anew. Ray's own keep-alive can't be used for this: with RAY_grpc_client_keepalive_time_ms below its 5 minutes,
nodes break off calls of more than a few such times.

A driver ends with the head, as a process and without an exception, after RAY_gcs_rpc_server_reconnect_timeout_s (60 s).
"""

from __future__ import annotations

import importlib
import logging
import os
import socket
import textwrap
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import stopping
from .engines import STOP_WITHIN, Answer, Call, EngineError, best_for, late
from .messages import read_answer, write_call
from .worker import answer

#: s, for which what is known of nodes is taken to hold.
NODES_HOLD = 2.0

#: s, within which the head has to take a connection.
CONNECT_WITHIN = 5.0

#: Of calls that an actor has: the one that runs, and where they are quick one that follows without a round trip to the
#: driver, which takes 1 to 3 ms. That one waits should the other take long after all.
CALLS_A_WORKER = 2
QUICK = 0.5  # s

#: Of actors in a row that ended before they had begun, until the engine gives up.
MOST_FAILED_STARTS = 20

#: By which a server of gRPC, as the head is, begins: a frame with settings (RFC 9113, 4.1 and 6.5).
HTTP2_FRAME_HEADER = 9  # bytes; the fourth is the frame's type
HTTP2_SETTINGS = 4


class RayEngine:
    """Actors on the nodes of a Ray cluster, a call at a time each.

    `address`: of the head, as "10.0.0.1:6379", or "auto" for the cluster that this machine is part of. None: as
    ray.init() has it, a cluster of this machine alone, unless the environment variable RAY_ADDRESS says otherwise; its
    ports are those of the loopback interface. If Ray runs in this process already, it is used as it is. `workers`: how many actors; an autoscaler sees those that find no
    place yet. None: as many as there are CPUs, also of nodes that come later.

    A worker is called `host name/first 8 digits of the node's id`, the same for all actors of a node. A node that is
    started anew has a new name. Raises EngineError where there is no cluster, and later where no actor can be started.

    A call may run twice, even at a time: a node that can't be reached goes on for a while with a call that is answered
    as lost, and one whose process dies at once as it begins may be taken for one that had not begun. One answer is given.
    """

    depth = CALLS_A_WORKER

    def __init__(self, address: str | None = None, workers: int | None = None) -> None:
        self._ray = _import_ray()
        self._ours = _connect(self._ray, address)
        self._asked_for = workers
        self._actor = self._ray.remote(num_cpus=1, max_restarts=0, concurrency_groups={_CONTROL: 1})(_Process)
        self._pickle: Callable[[Any], bytes] = importlib.import_module("ray.cloudpickle").dumps
        self._unpickle: Callable[[bytes], Any] = importlib.import_module("ray.cloudpickle").loads
        self._nodes: list[_Node] = []  # that live and can take a call
        self._nodes_read = -NODES_HOLD
        self._workers: list[_Worker] = []
        self._failed_starts = 0
        self._waiting: list[_Task] = []
        self._answers: list[Answer] = []  # to be given

    def places(self) -> int:
        self._read_nodes()
        return self._known_places()

    def _known_places(self) -> int:
        return self._asked_for if self._asked_for is not None else sum(node.cpus for node in self._nodes)

    def submit(self, call: Call) -> None:
        self._waiting.append(_Task(call, write_call(call.function, call.arguments, self._pickle)))
        self._hand_out()

    def wait(self, timeout: float) -> list[Answer]:
        end = time.monotonic() + timeout
        while True:
            self._hand_out()
            left = 0.0 if self._answers else max(0.0, end - time.monotonic())
            self._take_ready(min(left, NODES_HOLD))
            self._end_late()
            if self._answers or left == 0.0:
                self._hand_out()
                answers, self._answers = self._answers, []
                return answers

    def stop(self) -> list[Answer]:
        """Calls that don't look at `stopping.asked()` are waited for, for STOP_WITHIN, then their processes are killed."""
        for worker in self._busy():
            worker.ask()
        end = time.monotonic() + STOP_WITHIN
        while self._busy() and time.monotonic() < end:
            self._take_ready(end - time.monotonic())
        for worker in self._busy():
            self._end(worker)
        self._waiting.clear()
        answers, self._answers = self._answers, []
        return answers

    def close(self) -> None:
        self._waiting.clear()
        if self._ray.is_initialized():
            for worker in list(self._workers):
                self._end(worker)
            if self._ours:
                self._ray.shutdown()

    def _read_nodes(self) -> None:
        if time.monotonic() - self._nodes_read < NODES_HOLD:
            return
        self._nodes_read = time.monotonic()
        living = [node for node in self._ray.nodes() if node["Alive"]]
        draining = _draining_nodes()
        self._nodes = [
            _Node(node["NodeID"], int(node["Resources"]["CPU"]))
            for node in living
            if node["Resources"].get("CPU", 0) >= 1 and node["NodeID"] not in draining
        ]
        # Ray may not say so for as long as a connection to the node is taken for good, 5 minutes or more.
        ids = {node["NodeID"] for node in living}
        for worker in [worker for worker in self._workers if worker.node and worker.node not in ids]:
            self._lose(worker, "its node died, or can't be reached")
        for worker in [worker for worker in self._workers if worker.node in draining]:
            worker.is_leaving = True
            worker.ask()
            if not worker.calls:
                self._end(worker)
        self._fit_workers()

    def _fit_workers(self) -> None:
        # One where there is no node, for an autoscaler to see.
        wanted = max(1, self._known_places())
        self._workers += [_Worker(self._actor.remote()) for _ in range(wanted - len(self._workers))]
        idle = sorted((worker for worker in self._workers if not worker.calls), key=lambda worker: worker.name != "")
        for worker in idle[: max(0, len(self._workers) - wanted)]:
            self._end(worker)

    def _hand_out(self) -> None:
        self._read_nodes()
        for task in [task for task in self._waiting if self._has_no_node(task.call)]:
            self._waiting.remove(task)
            why = f"no node is left but those to avoid: {', '.join(sorted(task.call.avoid))}"
            self._answers.append(Answer(task.call.ticket, "", lost=why, refused=True))
        for had in range(CALLS_A_WORKER):
            for worker in self._workers:
                if not self._waiting:
                    return
                if worker.can_take(had):
                    index = best_for(worker.name, (task.call for task in self._waiting))
                    if index is not None:
                        worker.begin(self._waiting.pop(index))

    def _has_no_node(self, call: Call) -> bool:
        return bool(call.avoid) and all(node.is_one_of(call.avoid) for node in self._nodes)

    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker.calls]

    def _take_ready(self, timeout: float) -> None:
        timeout = max(0.0, timeout)  # of a time that may have gone by
        awaited = {worker.awaited: worker for worker in self._workers if worker.awaited is not None}
        if not awaited:
            time.sleep(timeout)
            return
        if not self._ray.wait(list(awaited), timeout=timeout)[0]:
            return
        for reference in self._ray.wait(list(awaited), num_returns=len(awaited), timeout=0)[0]:
            self._take(awaited[reference], reference)

    def _take(self, worker: _Worker, reference: Any) -> None:
        errors = self._ray.exceptions
        try:
            said = self._ray.get(reference)
        except errors.RayError as raised:
            if not worker.name:
                self._end(worker)
                self._record_failed_start(raised)
            elif isinstance(raised, errors.RayTaskError):
                error = EngineError(f"{worker.name} can't run calls: {raised}")
                self._answers.append(Answer(worker.took().call.ticket, worker.name, error=error))
            else:
                self._lose(worker, _why(raised))
            return
        if not worker.name:
            worker.is_at(*said)
            self._failed_starts = 0
        elif said is None:
            self._waiting.insert(0, worker.took())
        else:
            self._answer(worker, *said)

    def _answer(self, worker: _Worker, message: bytes, seconds: float) -> None:
        value, error = read_answer(worker.calls[0].task.message, message, self._unpickle)
        worker.is_quick = seconds < QUICK
        self._answers.append(Answer(worker.took().call.ticket, worker.name, value, error, seconds=seconds))

    def _end_late(self) -> None:
        for worker in [worker for worker in self._busy() if worker.is_late()]:
            sent, spent = worker.calls.popleft(), time.monotonic() - worker.begun
            why = late(worker.name, sent.task.call)
            self._answers.append(Answer(sent.task.call.ticket, worker.name, lost=why, overran=True, seconds=spent))
            self._waiting[:0] = [other.task for other in worker.calls]
            self._end(worker)

    def _record_failed_start(self, failure: Exception) -> None:
        self._failed_starts += 1
        if getattr(failure, "actor_init_failed", False) or self._failed_starts == MOST_FAILED_STARTS:
            raise EngineError(f"nodes can't run calls: {failure}")

    def _lose(self, worker: _Worker, why: str) -> None:
        """What ran there is lost, and what had not begun goes elsewhere."""
        if worker.calls:
            spent = time.monotonic() - worker.begun
            lost = f"{worker.name} was lost: {why}"
            self._answers.append(Answer(worker.calls[0].task.call.ticket, worker.name, lost=lost, seconds=spent))
            self._waiting[:0] = [sent.task for sent in list(worker.calls)[1:]]
        self._end(worker)

    def _end(self, worker: _Worker) -> None:
        self._workers.remove(worker)
        self._ray.kill(worker.actor)
        self._nodes_read = -NODES_HOLD  # another may be wanted


_CONTROL = "control"  #: methods of an actor that run beside its calls


class _Process:
    """What is in the process of an actor."""

    def __init__(self) -> None:
        self._ended = 0

    def where(self) -> tuple[str, str]:
        """The name of the host, and the node's id."""
        return socket.gethostname(), _import_ray().get_runtime_context().get_node_id()

    def answer(self, number: int, call: bytes) -> tuple[bytes, float] | None:
        """A value and an error, as bytes, and seconds; None if the call was asked to end before it began."""
        stopping.forget()
        if number <= self._ended:
            return None
        cloudpickle = importlib.import_module("ray.cloudpickle")
        return answer(call, cloudpickle.dumps, cloudpickle.loads)

    def end(self, number: int) -> None:
        """Asks calls up to this one to come to an end soon."""
        self._ended = number
        stopping.ask()


@dataclass(frozen=True)
class _Node:
    id: str
    cpus: int

    def is_one_of(self, workers: frozenset[str]) -> bool:
        return any(worker.rpartition("/")[2] == _short(self.id) for worker in workers)


def _short(node_id: str) -> str:
    return node_id[:8]


@dataclass(frozen=True)
class _Task:
    call: Call
    message: bytes  #: its function and arguments


@dataclass(frozen=True)
class _Sent:
    task: _Task
    reference: Any  #: Ray's, of the answer


@dataclass(eq=False)
class _Worker:
    """An actor, and its calls, which it runs in order."""

    actor: Any
    started: Any = field(init=False)  #: Ray's reference of where it is
    name: str = ""  #: none yet while Ray finds it a node
    node: str = ""
    calls: deque[_Sent] = field(default_factory=deque)
    numbers: int = 0  #: of calls that it was ever sent
    begun: float = 0.0  #: s, of the clock: the first of its calls
    is_quick: bool = False  #: its last call was
    is_leaving: bool = False  #: and gets no more

    def __post_init__(self) -> None:
        self.started = self.actor.where.remote()

    @property
    def awaited(self) -> Any:
        """Ray's reference of what it says next."""
        if not self.name:
            return self.started
        return self.calls[0].reference if self.calls else None

    def is_at(self, host: str, node: str) -> None:
        self.name, self.node = f"{host}/{_short(node)}", node

    def can_take(self, had: int) -> bool:
        """One more call than these."""
        return self.name != "" and not self.is_leaving and len(self.calls) == had and (had == 0 or self.is_quick)

    def begin(self, task: _Task) -> None:
        if not self.calls:
            self.begun = time.monotonic()
        self.numbers += 1
        self.calls.append(_Sent(task, self.actor.answer.remote(self.numbers, task.message)))

    def took(self) -> _Task:
        """The answer of its first call."""
        self.begun = time.monotonic()
        return self.calls.popleft().task

    def is_late(self) -> bool:
        return time.monotonic() - self.begun > self.calls[0].task.call.limit

    def ask(self) -> None:
        """Its calls to come to an end."""
        self.actor.end.options(concurrency_group=_CONTROL).remote(self.numbers)


def _draining_nodes() -> set[str]:
    """Their ids."""
    try:
        return set(importlib.import_module("ray._private.state").state.get_draining_nodes())
    except Exception:  # no part of Ray's documented interface, so it may go; calls are lost with the node then
        return set()


def _why(lost: Exception) -> str:
    said = str(lost).strip().splitlines()
    return textwrap.shorten(said[-1] if said else type(lost).__name__, 200)


def _import_ray() -> Any:
    try:
        return importlib.import_module("ray")
    except ImportError as missing:
        raise EngineError(f'{missing}; Ray is installed by: pip install "atoll[ray]"') from missing


def _connect(ray: Any, address: str | None) -> bool:
    """Whether it was this that started Ray in this process."""
    if ray.is_initialized():
        running = ray.get_runtime_context().gcs_address
        if address not in (None, "auto", "local", running):
            raise EngineError(f"{address}: this process is part of the Ray cluster {running} already")
        return False
    address = address or os.environ.get("RAY_ADDRESS")
    if address is not None and "://" in address:
        raise EngineError(f"{address}: expected host:port of the head, from a driver on a node of the cluster")
    if address not in (None, "auto", "local"):
        _check_reached(address)
        _check_is_node(address)
    options: dict[str, Any] = {"address": address, "log_to_driver": False, "logging_level": logging.ERROR}
    if address in (None, "local"):
        options["include_dashboard"] = False
    package = Path(__file__).absolute().parents[2]
    if package.name not in ("site-packages", "dist-packages"):
        path = os.pathsep.join([str(package), *filter(None, [os.environ.get("PYTHONPATH")])])
        options["runtime_env"] = {"env_vars": {"PYTHONPATH": path}}
    try:
        with _on_loopback() if address in (None, "local") else nullcontext():
            ray.init(**options)
    except Exception as raised:
        raise EngineError(f"{address or 'Ray on this machine'}: {raised}") from raised
    _keep_stdout_clean()
    return True


@contextmanager
def _on_loopback() -> Iterator[None]:
    """Whoever reaches Ray's ports can have it run anything, so those of a cluster of one machine are for that machine.

    Ray has no option for it on Linux. It does so where it takes clusters of several machines to be impossible, which a
    variable says to its processes, and a constant to this one.
    """
    constants: Any = importlib.import_module("ray._private.ray_constants")
    variable, constant = "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER", "ENABLE_RAY_CLUSTER"
    before, possible = os.environ.get(variable), getattr(constants, constant, True)
    os.environ[variable] = "0"
    setattr(constants, constant, False)
    try:
        yield
    finally:
        setattr(constants, constant, possible)
        os.environ.pop(variable)
        if before is not None:
            os.environ[variable] = before


def _check_reached(address: str) -> None:
    """Ray itself tries for minutes, or for good."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdigit():
        raise EngineError(f'{address}: expected host:port of the head, or "auto"')
    greeting = b""
    try:
        with socket.create_connection((host.strip("[]"), int(port)), timeout=CONNECT_WITHIN) as connection:
            if os.environ.get("RAY_USE_TLS", "0") == "0":  # where a server waits for its client to begin
                greeting = connection.recv(HTTP2_FRAME_HEADER)
    except OSError as raised:
        raise EngineError(f"{address}: no Ray cluster can be reached there: {raised}") from raised
    if greeting and (len(greeting) < HTTP2_FRAME_HEADER or greeting[3] != HTTP2_SETTINGS):
        raise EngineError(f"{address}: what answers there is no head of a Ray cluster")


def _check_is_node(address: str) -> None:
    """Ray ends the process where there is none."""
    try:
        client: Any = importlib.import_module("ray._raylet").GcsClient(address=address)
        nodes = [node.raylet_socket_name for node in client.get_all_node_info().values() if node.state == 0]
    except Exception:  # no part of Ray's documented interface, so it may go; ray.init says what else is wrong
        return
    if not any(Path(name).exists() for name in nodes):
        raise EngineError(
            f"{address}: this machine is no node of the cluster; to make it one that takes no calls: "
            f"ray start --address={address} --num-cpus=0"
        )


def _keep_stdout_clean() -> None:
    """Ray prints on stdout what raylets say of workers that died, whatever log_to_driver is. It belongs on stderr."""
    worker: Any = importlib.import_module("ray._private.worker")
    prints = getattr(worker, "print_to_stdstream", None)
    if prints is not None and getattr(prints, "__module__", "") != __name__:

        def print_on_stderr(data: dict[str, Any], *arguments: Any, **named: Any) -> None:
            prints({**data, "is_err": True}, *arguments, **named)

        worker.print_to_stdstream = print_on_stderr
