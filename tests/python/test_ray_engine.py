"""Calls on a Ray cluster: answers, what functions raise, processes that die, nodes to avoid, an end."""

from __future__ import annotations

import importlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from conftest import long_test

pytestmark = long_test
ray: Any = pytest.importorskip("ray", reason="Ray is not installed: the engine takes it as an extra")

from atoll._ensemble import stopping  # noqa: E402
from atoll._ensemble.engines import Answer, Call, EngineError  # noqa: E402
from atoll._ensemble.ray_engine import RayEngine, _Process  # noqa: E402
from atoll._ensemble.whole_file import write_whole  # noqa: E402

PLACES = 3
HANGS = 600  #: s, after which what should have come is taken to hang


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """A node a place, all of this machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAY_AUTH_MODE", "disabled")  # else Ray writes a token into the home directory
        patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        patch.delenv("RAY_ADDRESS", raising=False)
        for setting, value in (("initial_delay_ms", 500), ("period_ms", 500), ("failure_threshold", 20)):
            patch.setenv(f"RAY_health_check_{setting}", str(value))
        paths = [str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])]
        patch.setenv("PYTHONPATH", os.pathsep.join(paths))  # of processes that import this module
        node = {"num_cpus": 1, "object_store_memory": 80 << 20}
        made = importlib.import_module("ray.cluster_utils").Cluster(
            initialize_head=True, head_node_args={**node, "include_dashboard": False}
        )
        made.spare = [made.add_node(**node) for _ in range(PLACES - 1)][-1]
        ray.init(address=made.address, log_to_driver=False)
        made.wait_for_nodes()
        yield made
        ray.shutdown()
        made.shutdown()


@pytest.fixture
def engine(cluster: Any) -> Iterator[RayEngine]:
    made = RayEngine(None, None)
    wait_for_workers(made)
    yield made
    made.close()
    assert ray.is_initialized()  # for it was not the engine's


def answers_of(engine: RayEngine, calls: list[Call]) -> dict[int, Answer]:
    for call in calls:
        engine.submit(call)
    return rest_of(engine, len(calls))


def rest_of(engine: RayEngine, count: int) -> dict[int, Answer]:
    found: dict[int, Answer] = {}
    end = time.monotonic() + HANGS
    while len(found) < count and time.monotonic() < end:
        for answer in engine.wait(0.5):
            assert answer.ticket not in found
            found[answer.ticket] = answer
    assert len(found) == count
    return found


def wait_for(path: Path) -> None:
    end = time.monotonic() + HANGS
    while not path.exists():
        assert time.monotonic() < end
        time.sleep(0.02)


def names() -> set[str]:
    return {f"{socket.gethostname()}/{node['NodeID'][:8]}" for node in ray.nodes() if node["Alive"]}


def wait_for_workers(engine: RayEngine) -> None:
    """Until each node has answered."""
    found: set[str] = set()
    end = time.monotonic() + HANGS
    while found != names():
        assert time.monotonic() < end
        found |= {answer.worker for answer in answers_of(engine, [Call(i, time.sleep, (0.1,)) for i in range(9)]).values()}


def square(number: int) -> int:
    return number * number


def many_bytes(count: int) -> bytes:
    return bytes(count)


class PickyError(Exception):
    """That pickle can't make again."""

    def __init__(self, one: str, other: str) -> None:
        super().__init__(one + other)


def fail(kind: str) -> None:
    if kind == "value":
        raise ValueError("no such thing")
    raise PickyError("one", "other")


def answer_function() -> Any:
    return sys._getframe()


def die(answered: Path) -> None:
    wait_for(answered)
    os.kill(os.getpid(), signal.SIGKILL)


def hang(mark: Path) -> None:
    write_whole(mark, str(os.getpid()).encode())
    time.sleep(HANGS)


def work_until_asked(mark: Path) -> str:
    mark.touch()
    end = time.monotonic() + HANGS
    while not stopping.asked() and time.monotonic() < end:
        time.sleep(0.02)
    return "asked" if stopping.asked() else "never asked"


def is_asked() -> bool:
    return stopping.asked()


def test_each_call_has_one_answer(engine: RayEngine) -> None:
    assert engine.places() == PLACES
    begin = time.monotonic()
    answers = answers_of(engine, [Call(i, square, (i,)) for i in range(20)])
    taken = time.monotonic() - begin
    assert {ticket: answer.value for ticket, answer in answers.items()} == {i: i * i for i in range(20)}
    assert {answer.worker for answer in answers.values()} <= names()
    assert all(answer.error is None and not answer.lost and 0 < answer.seconds < taken for answer in answers.values())
    assert engine.wait(0.1) == []


def test_values_of_a_few_megabytes(engine: RayEngine) -> None:
    answers = answers_of(engine, [Call(i, many_bytes, (5 << 20,)) for i in range(4)])
    assert [len(answer.value) for answer in answers.values()] == [5 << 20] * 4


def test_what_a_function_raises(engine: RayEngine) -> None:
    answers = answers_of(
        engine, [Call(0, fail, ("value",)), Call(1, fail, ("picky",)), Call(2, answer_function), Call(3, square, (3,))]
    )
    assert isinstance(answers[0].error, ValueError) and str(answers[0].error) == "no such thing"
    assert isinstance(answers[1].error, RuntimeError)
    assert isinstance(answers[2].error, RuntimeError) and "pickle" in str(answers[2].error)
    assert answers[3].value == 9 and answers[3].error is None
    with pytest.raises(TypeError, match="pickle"):
        engine.submit(Call(4, square, (sys._getframe(),)))


def test_a_process_that_is_killed_loses_its_call_alone(engine: RayEngine, tmp_path: Path) -> None:
    mark, answered = tmp_path / "mark", tmp_path / "told"
    engine.submit(Call(0, hang, (mark,)))
    for i in range(1, 9):
        engine.submit(Call(i, square, (i,)))
    engine.submit(Call(9, die, (answered,)))
    wait_for(mark)
    os.kill(int(mark.read_text()), signal.SIGKILL)
    answers = rest_of(engine, 9)
    answered.touch()  # all answers before it have been sent
    answers |= rest_of(engine, 1)
    for ticket in (0, 9):
        assert answers[ticket].worker in names()
        assert answers[ticket].lost.startswith(f"{answers[ticket].worker} was lost: The actor is dead because its worker")
        assert not answers[ticket].refused
    assert [answers[i].value for i in range(1, 9)] == [i * i for i in range(1, 9)]


class Broken(_Process):
    def __init__(self) -> None:
        raise ImportError("no such package here")


def test_nodes_that_can_not_run_calls(engine: RayEngine) -> None:
    broken = RayEngine(None, None)
    broken._actor = ray.remote(num_cpus=0)(Broken)
    broken.submit(Call(0, square, (3,)))
    with pytest.raises(EngineError, match=r"nodes can't run calls: (.|\n)*no such package here"):
        rest_of(broken, 1)
    broken.close()


def test_nodes_to_avoid(engine: RayEngine) -> None:
    one, two, three = sorted(names())
    calls = [Call(i, square, (i,), frozenset({one})) for i in range(6)]
    calls += [Call(i, square, (i,), frozenset({one, three})) for i in range(6, 12)]
    calls.append(Call(12, square, (6,), frozenset({one, two, three})))
    calls.append(Call(13, square, (7,), frozenset({"elsewhere/01234567"})))
    answers = answers_of(engine, calls)
    assert {answers[i].worker for i in range(6)} <= {two, three}
    assert {answers[i].worker for i in range(6, 12)} == {two}
    assert answers[12].refused
    assert answers[12].lost == f"no node is left but those to avoid: {one}, {two}, {three}"
    assert answers[13].value == 49


def test_fewer_workers_than_the_cluster_has(cluster: Any) -> None:
    engine = RayEngine(None, 1)
    assert engine.places() == 1
    begin = time.monotonic()
    answers_of(engine, [Call(i, time.sleep, (0.3,)) for i in range(3)])
    assert time.monotonic() - begin > 0.9
    engine.close()


def test_stop_asks_what_is_under_way_and_drops_the_rest(engine: RayEngine, tmp_path: Path) -> None:
    marks = [tmp_path / str(i) for i in range(10)]
    for i, mark in enumerate(marks):
        engine.submit(Call(i, work_until_asked, (mark,)))
    for mark in marks[:PLACES]:
        wait_for(mark)
    answers = engine.stop()
    # Nothing ends by itself before it is taken to hang.
    assert {answer.ticket: answer.value for answer in answers} == {i: "asked" for i in range(PLACES)}
    assert engine.wait(0.2) == []
    assert not any(mark.exists() for mark in marks[PLACES:])
    # The same processes, of another run.
    assert not any(answer.value for answer in answers_of(engine, [Call(i, is_asked) for i in range(4)]).values())


def test_stop_kills_what_does_not_listen(engine: RayEngine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atoll._ensemble.ray_engine.STOP_WITHIN", 0.5)
    mark = tmp_path / "mark"
    engine.submit(Call(0, hang, (mark,)))
    wait_for(mark)
    begin = time.monotonic()
    assert engine.stop() == []
    assert 0.5 <= time.monotonic() - begin < HANGS
    assert answers_of(engine, [Call(1, square, (2,))])[1].value == 4


def test_an_address_of_another_cluster(cluster: Any) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nobody = f"127.0.0.1:{free.getsockname()[1]}"
    with pytest.raises(EngineError, match=f"{nobody}: this process is part of the Ray cluster"):
        RayEngine(nobody, None)


def test_addresses_that_lead_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ray, "is_initialized", lambda: False)
    monkeypatch.setattr("atoll._ensemble.ray_engine.CONNECT_WITHIN", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(EngineError, match=f"{address}: no Ray cluster can be reached there: timed out"):
            RayEngine(address, None)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nobody = f"127.0.0.1:{free.getsockname()[1]}"
    for address, why in (
        (nobody, f"{nobody}: no Ray cluster can be reached there: .*refused"),
        ("somewhere", 'somewhere: expected host:port of the head, or "auto"'),
        ("ray://127.0.0.1:10001", "ray://127.0.0.1:10001: expected host:port of the head"),
    ):
        with pytest.raises(EngineError, match=why):
            RayEngine(address, None)


def test_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(EngineError, match=r'pip install "atoll\[ray\]"'):
        RayEngine(None, None)


def test_a_node_that_drains_is_emptied(cluster: Any, engine: RayEngine, tmp_path: Path) -> None:
    before = names()
    node = cluster.add_node(num_cpus=1, object_store_memory=80 << 20)
    wait_for_workers(engine)
    assert engine.places() == PLACES + 1
    (new,) = names() - before
    mark = tmp_path / "mark"
    engine.submit(Call(0, work_until_asked, (mark,), frozenset(before)))
    wait_for(mark)
    engine.submit(Call(1, square, (1,), frozenset(before)))
    reason = importlib.import_module("ray.core.generated.autoscaler_pb2").DRAIN_NODE_REASON_PREEMPTION
    head = importlib.import_module("ray._raylet").GcsClient(address=cluster.address)
    accepted, why = head.drain_node(node.node_id, reason, "test", int(1000 * (time.time() + 60)))
    assert accepted, why
    answers = rest_of(engine, 2)
    assert (answers[0].worker, answers[0].value, answers[0].lost) == (new, "asked", "")
    assert answers[1].refused
    assert engine.places() == PLACES
    answers = answers_of(engine, [Call(i, square, (i,)) for i in range(20)])
    assert {answer.worker for answer in answers.values()} <= before
    end = time.monotonic() + HANGS
    while new in names():  # its actor has ended, so it may leave
        assert time.monotonic() < end
        assert engine.wait(0.2) == []


def test_a_node_that_dies_loses_its_call_and_gets_no_more(cluster: Any, engine: RayEngine, tmp_path: Path) -> None:
    """The last one: the cluster has one node less."""
    marks = [tmp_path / str(i) for i in range(PLACES)]
    spare = next(name for name in names() if name.endswith(cluster.spare.node_id[:8]))
    rest = names() - {spare}
    for i, name in enumerate([spare, *rest]):
        engine.submit(Call(i, hang, (marks[i],), frozenset(names() - {name})))
    for mark in marks:
        wait_for(mark)
    for i in range(PLACES, 8):
        engine.submit(Call(i, square, (i,)))
    engine.submit(Call(8, square, (8,), frozenset(rest)))
    cluster.remove_node(cluster.spare, allow_graceful=False)
    answers = rest_of(engine, 2)
    assert answers[0].worker == spare and answers[0].lost.startswith(f"{spare} was lost: ")
    assert answers[8].lost == f"no node is left but those to avoid: {', '.join(sorted(rest))}"
    assert engine.places() == PLACES - 1
    for mark in marks[1:]:
        os.kill(int(mark.read_text()), signal.SIGKILL)
    answers = rest_of(engine, 7)
    assert all(answers[i].lost.startswith(f"{answers[i].worker} was lost: ") for i in range(1, PLACES))
    assert {answers[i].worker for i in range(1, PLACES)} == rest
    assert {answers[i].value for i in range(PLACES, 8)} == {i * i for i in range(PLACES, 8)}
    assert {answers[i].worker for i in range(PLACES, 8)} <= rest


LISTENERS = """
import os, pathlib
from atoll._ensemble.ray_engine import RayEngine
from atoll._ensemble.engines import Call

def sockets_of_ours():
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if b"ATOLL_TEST_PORTS" in (process / "environ").read_bytes():
                yield from map(os.readlink, (process / "fd").iterdir())
        except OSError:  # it ended
            pass

engine = RayEngine(None, 1)
engine.submit(Call(1, max, (1, 2)))
while not engine.wait(1.0):
    pass
ours = set(sockets_of_ours())
for name in ("tcp", "tcp6"):
    for fields in map(str.split, pathlib.Path("/proc/net", name).read_text().splitlines()):
        if fields[3] == "0A" and f"socket:[{fields[9]}]" in ours:  # listens
            host = fields[1].partition(":")[0]
            print("loopback" if host in ("0100007F", "0000000000000000FFFF00000100007F") else fields[1])
engine.close()
"""


def test_a_cluster_of_this_machine_listens_to_it_alone() -> None:
    environment = {**os.environ, "RAY_AUTH_MODE": "disabled", "RAY_USAGE_STATS_ENABLED": "0", "ATOLL_TEST_PORTS": "1"}
    environment.pop("RAY_ADDRESS", None)
    done = subprocess.run([sys.executable, "-c", LISTENERS], env=environment, capture_output=True, text=True, timeout=HANGS)
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split()) == {"loopback"}
