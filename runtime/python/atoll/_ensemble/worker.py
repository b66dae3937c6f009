"""A worker process of `LocalEngine`: answers calls that come through a socket until that is closed."""

from __future__ import annotations

import ctypes
import multiprocessing.connection
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

from . import stopping

_PR_SET_PDEATHSIG = 1


def serve(descriptor: int) -> None:
    # Whoever started it may be killed; it would go on with a job that the next one begins again.
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.signal(signal.SIGTERM, lambda *_: stopping.ask())
    connection: multiprocessing.connection.Connection[Any, Any] = multiprocessing.connection.Connection(descriptor)
    while True:
        try:
            function, arguments = connection.recv()
        except EOFError:
            return
        stopping.forget()
        value, error, seconds = answer(function, arguments)
        try:
            connection.send((value, error, seconds))
        except OSError:
            return
        except Exception as raised:  # that can't be pickled
            connection.send((None, unsendable(value, error, raised), seconds))


def answer(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, Exception | None, float]:
    """A value, or what the function raised, and the seconds that it took."""
    begin = time.perf_counter()
    value, error = None, None
    try:
        value = function(*arguments)
    except Exception as raised:
        error = raised
    return value, error, time.perf_counter() - begin


def unsendable(value: Any, error: Exception | None, why: Exception) -> RuntimeError:
    """What is told instead of an answer that can't be pickled."""
    return RuntimeError(f"{error or value!r}: {why}")


if __name__ == "__main__":
    serve(int(sys.argv[1]))
