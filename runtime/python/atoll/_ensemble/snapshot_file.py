"""A job's snapshot as bytes: what it is of, and a checksum, ahead of what the library writes."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass

from .. import _core

_MAGIC = b"ATOLLJOB"


class BadSnapshot(Exception):
    """A snapshot that can't be gone on from."""


@dataclass(frozen=True)
class SnapshotBytes:
    content: bytes
    origin: str


def pack(key: str, step: int, state_hash: int, snapshot: _core.Snapshot) -> bytes:
    content = snapshot.__getstate__()
    head = {"key": key, "step": step, "hash": state_hash, "sha256": hashlib.sha256(content).hexdigest()}
    return _MAGIC + json.dumps(head).encode() + b"\n" + content


def unpack(stored: SnapshotBytes, key: str) -> tuple[tuple[int, int], _core.Snapshot]:
    """Its step and hash, and the snapshot. Raises BadSnapshot where it is not whole or of another job."""
    head, _, content = stored.content.partition(b"\n")
    try:
        if not head.startswith(_MAGIC):
            raise ValueError
        header = json.loads(head[len(_MAGIC) :])
        point = (int(header["step"]), int(header["hash"]))
        whole = hashlib.sha256(content).hexdigest() == header["sha256"]
        of_job = header["key"] == key
    except (ValueError, KeyError, TypeError):
        raise BadSnapshot(f"{stored.origin} is no snapshot of a job") from None
    if not whole:
        raise BadSnapshot(f"{stored.origin} is corrupt: its checksum is another")
    if not of_job:
        raise BadSnapshot(f"{stored.origin} is of another job")
    snapshot = _core.Snapshot.__new__(_core.Snapshot)
    snapshot.__setstate__(content)
    return point, snapshot
