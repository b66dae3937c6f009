"""A worker process of `LocalEngine`: answers calls that come through a socket until that is closed."""

from __future__ import annotations

import ctypes
import multiprocessing.connection
import pickle
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

from . import stopping
from .messages import read_call, write_answer

_PR_SET_PDEATHSIG = 1


def serve(descriptor: int) -> None:
    # Whoever started it may be killed; it would go on with a job that the next one begins again.
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.signal(signal.SIGTERM, lambda *_: stopping.ask())
    connection: multiprocessing.connection.Connection[Any, Any] = multiprocessing.connection.Connection(descriptor)
    while True:
        try:
            call = connection.recv_bytes()
        except EOFError:
            return
        stopping.forget()
        message, seconds = answer(call, pickle.dumps, pickle.loads)
        try:
            connection.send_bytes(b"%f\n" % seconds + message)
        except OSError:
            return


def answer(call: bytes, dumps: Callable[[Any], bytes], loads: Callable[[bytes], Any]) -> tuple[bytes, float]:
    """To a call, a value or what its function raised, and the seconds that it took."""
    value, error, seconds = None, None, 0.0
    try:
        function, arguments = read_call(call, loads)
        begin = time.perf_counter()
        try:
            value = function(*arguments)
        finally:
            seconds = time.perf_counter() - begin
    except Exception as raised:
        error = raised
    try:
        return write_answer(call, value, error, dumps), seconds
    except Exception as raised:  # that can't be pickled
        return write_answer(call, None, RuntimeError(f"{error or value!r}: {raised}"), dumps), seconds


if __name__ == "__main__":
    serve(int(sys.argv[1]))
