"""Calls functions on the nodes of a Ray cluster: a Ray task a call, of one CPU.

Ray finds a node for each task, starts processes there, and finds out when a node is gone. It retries nothing: whoever
uses the engine gets an answer that says that the worker was lost.

What Ray has no word for:

- Where a task has begun. A task notes its node in the cluster's key-value store while it runs.
- How a task is asked to end soon. `ray.cancel` interrupts a task that runs, as a Ctrl-C would; the handler for that is
  replaced by one that asks (`stopping.py`), and the task ends as any other. One that has not begun is cancelled.

Nodes need the same versions of Python, of Ray and of atoll as the driver. A driver whose atoll lies elsewhere than in
site-packages has nodes look for it under the same path. The driver has to run on a node too, which may be one that takes
no calls (`ray start --num-cpus=0`).

To empty a node, drain it (an autoscaler does, or `ray drain-node --node-id ... --deadline-remaining-seconds ...`): it
gets no more calls, ends those that it has, and leaves the cluster. Calls should be short against the time it is given.

A node that hangs or can't be reached is found by the head's health checks. It takes them 65 s; with
RAY_health_check_period_ms=1000, RAY_health_check_timeout_ms=1000 and RAY_health_check_failure_threshold=3 in the
environment of `ray start --head`, 7 s. Until then calls may wait although other nodes are free. A node that was given up
ends itself when it is reached again, and is to be started anew. Ray's own keep-alive can't be used for this: with
RAY_grpc_client_keepalive_time_ms below its 5 minutes, nodes break off calls of more than a few such times.

A driver ends with the head, as a process and without an exception, after RAY_gcs_rpc_server_reconnect_timeout_s (60 s).
"""

from __future__ import annotations

import importlib
import logging
import os
import signal
import socket
import time
import uuid
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from . import stopping
from .engines import STOP_WITHIN, Answer, Call, EngineError

#: s, for which what is known of nodes is taken to hold.
NODES_HOLD = 2.0

#: s, within which the head has to take a connection.
CONNECT_WITHIN = 5.0

#: Of tasks that Ray has for a place: the one that runs, and one that follows without a round trip to the driver.
TASKS_A_PLACE = 2

#: By which a server of gRPC, as the head is, begins: a frame with settings (RFC 9113, 4.1 and 6.5).
HTTP2_FRAME_HEADER = 9  # bytes; the fourth is the frame's type
HTTP2_SETTINGS = 4

#: Of nodes that left the cluster, which no call is sent to although Ray may believe that they have room.
GONE_KEPT = 32

_STORE = "atoll"  #: the namespace in Ray's key-value store


class RayEngine:
    """Nodes of a Ray cluster, a call at a time on each of their CPUs.

    `address`: of the head, as "10.0.0.1:6379", or "auto" for the cluster that this machine is part of. None: as
    ray.init() has it, a cluster of this machine alone, unless the environment variable RAY_ADDRESS says otherwise. If Ray
    runs in this process already, it is used as it is. `workers`: how many calls at a time; None: as many as there are
    CPUs, also of nodes that come later.

    A worker is called `host name/first 8 digits of the node's id`, the same for all processes of a node. A node that is
    started anew has a new name. Raises EngineError where there is no cluster.

    A call may run twice, even at a time: a node that can't be reached goes on for a while with a call that is answered
    as lost, and a call that is not known to have begun when a node goes is submitted again. One answer is given.
    """

    depth = TASKS_A_PLACE

    def __init__(self, address: str | None = None, workers: int | None = None) -> None:
        self._ray = _import_ray()
        self._ours = _connect(self._ray, address)
        self._workers = workers
        self._nodes: list[_Node] = []  # that live and can take a call
        self._gone: deque[str] = deque(maxlen=GONE_KEPT)  # ids of nodes
        self._nodes_read = -NODES_HOLD
        self._waiting: deque[_Task] = deque()
        self._under_way: dict[Any, _Task] = {}  # by Ray's reference
        self._refused: list[Answer] = []
        self._remote = self._ray.remote(_answer)
        self._pickle: Callable[[Any], bytes] = importlib.import_module("ray.cloudpickle").dumps
        self._unpickle: Callable[[bytes], Any] = importlib.import_module("ray.cloudpickle").loads

    def places(self) -> int:
        self._read_nodes()
        return self._workers if self._workers is not None else sum(node.cpus for node in self._nodes)

    def submit(self, call: Call) -> None:
        self._waiting.append(_Task(call, self._pickle((call.function, call.arguments)), uuid.uuid4().hex))
        self._hand_out()

    def wait(self, timeout: float) -> list[Answer]:
        end = time.monotonic() + timeout
        while True:
            self._hand_out()
            answers, self._refused = self._refused, []
            left = 0.0 if answers else max(0.0, end - time.monotonic())
            answers += self._ready(min(left, NODES_HOLD))
            if answers or left == 0.0:
                self._hand_out()
                return answers

    def stop(self) -> list[Answer]:
        """Calls that don't look at `stopping.asked()` are waited for, for STOP_WITHIN, then their processes are killed."""
        self._waiting.clear()
        self._refused.clear()
        for reference in self._under_way:
            self._ray.cancel(reference)
        answers = []
        end = time.monotonic() + STOP_WITHIN
        while self._under_way and time.monotonic() < end:
            answers += self._ready(end - time.monotonic(), stopped=True)
        self._kill()
        return answers

    def close(self) -> None:
        self._waiting.clear()
        self._refused.clear()
        if self._ray.is_initialized():
            self._kill()
            if self._ours:
                self._ray.shutdown()

    def _read_nodes(self) -> None:
        if time.monotonic() - self._nodes_read < NODES_HOLD:
            return
        self._nodes_read = time.monotonic()
        before, self._nodes = self._nodes, [
            _Node(node["NodeID"], int(node["Resources"]["CPU"]))
            for node in self._ray.nodes()
            if node["Alive"] and node["Resources"].get("CPU", 0) >= 1
        ]
        gone = {node.id for node in before} - {node.id for node in self._nodes}
        if gone:
            self._gone.extend(sorted(gone))
            self._give_up_on(gone)
            self._refuse_where_no_node_is_left()

    def _give_up_on(self, gone: set[str]) -> None:
        """Calls that are at nodes which left the cluster are lost, and those that have not begun are submitted again.

        Ray may hang on both for as long as a connection to the node is taken for good, 5 minutes or more, although it knows
        that the node is gone: on an answer, and on asking the node for a process that a call can run in.
        """
        for reference, task in list(self._under_way.items()):
            worker = _noted(task.key)
            is_elsewhere = worker and not any(_short(node) == worker.rpartition("/")[2] for node in gone)
            if is_elsewhere or self._has_ended(reference):
                continue
            del self._under_way[reference]
            self._ray.cancel(reference)
            if worker:
                _note(task.key, None)
                self._refused.append(Answer(task.call.ticket, worker, lost=f"{worker} died, or can't be reached"))
            else:
                self._waiting.appendleft(replace(task, key=uuid.uuid4().hex))

    def _limit(self) -> int:
        """On tasks that Ray has. Some even where there is no node, for an autoscaler to see."""
        return self._workers if self._workers is not None else TASKS_A_PLACE * max(1, self.places())

    def _hand_out(self) -> None:
        self._read_nodes()
        while self._waiting and len(self._under_way) < self._limit():
            task = self._waiting.popleft()
            if self._has_no_node(task):
                self._refuse(task)
                continue
            avoided = [*self._gone, *(node.id for node in self._nodes if node.is_one_of(task.call.avoid))]
            # Without blanks, which Ray takes for a part of the id.
            where = {"ray.io/node-id": f"!in({','.join(avoided)})"} if avoided else None
            remote = self._remote.options(num_cpus=1, max_retries=0, label_selector=where)
            self._under_way[remote.remote(task.key, task.pickled)] = task

    def _has_ended(self, reference: Any) -> bool:
        return bool(self._ray.wait([reference], timeout=0)[0])

    def _refuse_where_no_node_is_left(self) -> None:
        for reference, task in list(self._under_way.items()):
            if self._has_no_node(task) and not self._has_ended(reference):
                self._ray.cancel(reference)
                self._refuse(self._under_way.pop(reference))
        for task in [task for task in self._waiting if self._has_no_node(task)]:
            self._waiting.remove(task)
            self._refuse(task)

    def _has_no_node(self, task: _Task) -> bool:
        return bool(task.call.avoid) and all(node.is_one_of(task.call.avoid) for node in self._nodes)

    def _refuse(self, task: _Task) -> None:
        why = f"no node is left but those to avoid: {', '.join(sorted(task.call.avoid))}"
        self._refused.append(Answer(task.call.ticket, "", lost=why))

    def _ready(self, timeout: float, stopped: bool = False) -> list[Answer]:
        if not self._under_way:
            time.sleep(timeout)
            return []
        references = list(self._under_way)
        if not self._ray.wait(references, timeout=timeout)[0]:
            return []
        ready, _ = self._ray.wait(references, num_returns=len(references), timeout=0)
        answers = [self._take(reference, stopped) for reference in ready]
        return [answer for answer in answers if answer is not None]

    def _take(self, reference: Any, stopped: bool) -> Answer | None:
        """The answer of a task that has ended, if it was not cancelled."""
        task = self._under_way.pop(reference)
        errors = self._ray.exceptions
        try:
            worker, pickled, seconds = self._ray.get(reference)
        except errors.RayError as raised:
            worker = _noted(task.key)
            _note(task.key, None)
            if isinstance(raised, errors.TaskCancelledError):
                return None if stopped else Answer(task.call.ticket, worker, lost=_why(raised, worker))
            if isinstance(raised, (errors.RayTaskError, errors.RuntimeEnvSetupError)):  # not by the function
                return Answer(task.call.ticket, worker, error=EngineError(f"a node can't run calls: {raised}"))
            return Answer(task.call.ticket, worker, lost=_why(raised, worker))
        try:
            value, error = self._unpickle(pickled)
        except Exception as raised:
            value, error = None, RuntimeError(f"what {worker} answered can't be read: {raised!r}")
        return Answer(task.call.ticket, worker, value, error, seconds=seconds)

    def _kill(self) -> None:
        for reference, task in self._under_way.items():
            self._ray.cancel(reference, force=True)
            _note(task.key, None)
        self._under_way.clear()


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
    pickled: bytes  #: its function and arguments
    key: str  #: in Ray's key-value store, of the worker on which it has begun


def _answer(key: str, pickled: bytes) -> tuple[str, bytes, float]:
    """What a task does: the worker's name, a value and an error pickled, and seconds."""
    worker = f"{socket.gethostname()}/{_short(_import_ray().get_runtime_context().get_node_id())}"
    _note(key, worker)
    cloudpickle = importlib.import_module("ray.cloudpickle")
    stopping.forget()
    interrupt = signal.signal(signal.SIGINT, lambda *_: stopping.ask())
    begin = time.perf_counter()
    value, error = None, None
    try:
        function, arguments = cloudpickle.loads(pickled)
        begin = time.perf_counter()
        value = function(*arguments)
    except Exception as raised:
        error = raised
    finally:
        signal.signal(signal.SIGINT, interrupt)
    seconds = time.perf_counter() - begin
    try:
        answer = cloudpickle.dumps((value, error))
    except Exception as raised:
        answer = cloudpickle.dumps((None, RuntimeError(f"{error or value!r}: {raised}")))
    _note(key, None)
    return worker, answer, seconds


def _note(key: str, worker: str | None) -> None:
    """Where a task is; None: nowhere any more."""
    try:
        store = importlib.import_module("ray.experimental.internal_kv")
        if worker is not None:
            store._internal_kv_put(key, worker, namespace=_STORE)
        else:
            store._internal_kv_del(key, namespace=_STORE)
    except Exception:  # it only says more of what is lost
        pass


def _noted(key: str) -> str:
    """Where a task has begun and not come to an end, or nothing."""
    try:
        worker = importlib.import_module("ray.experimental.internal_kv")._internal_kv_get(key, namespace=_STORE)
    except Exception:
        return ""
    return worker.decode() if worker else ""


def _why(lost: Exception, worker: str) -> str:
    name = worker or "a node"
    kind = type(lost).__name__
    what = {
        "WorkerCrashedError": f"a process of {name} died",
        "NodeDiedError": f"{name} died, or can't be reached",
        "OutOfMemoryError": f"{name} had no memory left",
        "LocalRayletDiedError": f"{name}: its Ray ended",
        "OwnerDiedError": f"{name}: the driver was taken for dead",
        "TaskCancelledError": f"{name}: the call was cancelled",
    }
    said = str(lost).strip().split("\n")[0]
    return what.get(kind, f"{name} lost the answer: {kind}: {said}")


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
        ray.init(**options)
    except Exception as raised:
        raise EngineError(f"{address or 'Ray on this machine'}: {raised}") from raised
    _keep_stdout_clean()
    return True


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
