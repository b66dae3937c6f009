"""Whether what this process computes is to come to an end soon: a process has one such wish."""

from __future__ import annotations

_asked = False


def ask() -> None:
    global _asked
    _asked = True


def asked() -> bool:
    return _asked
