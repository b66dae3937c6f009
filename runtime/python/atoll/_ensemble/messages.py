"""Calls and answers as bytes, between a driver and its workers.

A call of a job without functions of the plan is plain JSON, and so is its answer: neither side can make the other one run
anything else by it. All other calls and answers are pickles, which can run whatever their sender likes.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from .. import _core
from .job import FunctionError, LimitError, Moment, Part, Point, run_part
from .plan import Job, Keep, Source

_PLAIN = b"{"  # of JSON; a pickle is written after another byte
_PICKLE = b"P"
_NO_CALL = "found neither a call's JSON nor a pickle"

#: What a job raises by its inputs, by name.
_ERRORS: dict[str, type[Exception]] = {
    kind.__name__: kind for kind in (_core.Error, _core.SceneError, FunctionError, LimitError)
}


def write_call(function: Callable[..., Any], arguments: tuple[Any, ...], pickle: Callable[[Any], bytes]) -> bytes:
    if function is not run_part or arguments[0].code:
        return _PICKLE + pickle((function, arguments))
    names = ("job", "start", "seconds", "folder", "snapshot", "name", "memory")
    return _write(dict(zip(names, arguments, strict=False)))


def read_call(message: bytes, unpickle: Callable[[bytes], Any]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    if message[:1] == _PICKLE:
        function, arguments = unpickle(message[1:])
        return function, arguments
    if message[:1] != _PLAIN:
        raise ValueError(_NO_CALL)
    fields = json.loads(message)
    job, start = fields.pop("job"), fields.pop("start")
    keep = Keep(**{**job["keep"], "observables": tuple(job["keep"]["observables"])})
    read = Job(**{**job, "source": Source(**job["source"]), "keep": keep})
    if read.setup or read.observe:
        raise ValueError(f"found {read.setup or read.observe} in a call that runs no functions")
    rest = (fields["seconds"], fields["folder"], _bytes(fields["snapshot"]), fields.get("name", ""), fields.get("memory"))
    return run_part, (read, start and Point(**start), *rest)


def is_plain(call: bytes) -> bool:
    return call[:1] == _PLAIN


def write_answer(call: bytes, value: Any, error: Exception | None, pickle: Callable[[Any], bytes]) -> bytes:
    """Of a call as it came."""
    if not is_plain(call):
        return pickle((value, error))
    kind = type(error).__name__
    words = str(error) if kind in _ERRORS else f"{kind}: {error}"
    return _write({"part": value, "error": error and [kind, words]})


def read_answer(call: bytes, message: bytes, unpickle: Callable[[bytes], Any]) -> tuple[Any, Exception | None]:
    """Of a call as it was sent."""
    try:
        return _read_answer(call, message, unpickle)
    except Exception as raised:
        return None, RuntimeError(f"the answer can't be read: {raised!r}")


def _read_answer(call: bytes, message: bytes, unpickle: Callable[[bytes], Any]) -> tuple[Any, Exception | None]:
    if not is_plain(call):
        value, error = unpickle(message)
        return value, error
    fields = json.loads(message)
    if fields["error"]:
        kind, words = map(str, fields["error"])
        return None, _ERRORS.get(kind, RuntimeError)(words)
    part = fields["part"]
    moments = [Moment(int(moment["step"]), dict(moment["observed"])) for moment in part.pop("series")]
    first, last, checks = int(part.pop("first")), Point(**part.pop("last")), [Point(**check) for check in part.pop("checks")]
    return Part(first, last, checks, moments, part.pop("result"), _bytes(part.pop("snapshot")), **part), None


def _write(fields: dict[str, Any]) -> bytes:
    plain = {name: asdict(value) if isinstance(value, (Job, Point, Part)) else value for name, value in fields.items()}
    return json.dumps(plain, default=_text).encode()


def _text(content: object) -> str:
    if not isinstance(content, bytes):
        raise TypeError(f"found {content!r}; expected what JSON has, or bytes")
    return base64.b64encode(content).decode()


def _bytes(text: str | None) -> bytes | None:
    return None if text is None else base64.b64decode(text)
