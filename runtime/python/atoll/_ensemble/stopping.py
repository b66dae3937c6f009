"""Whether what this process computes is to come to an end soon: a process has one such wish."""

from __future__ import annotations

_asked = False


def ask() -> None:
    global _asked
    _asked = True


def forget() -> None:
    """As something new begins."""
    global _asked
    _asked = False


def asked() -> bool:
    return _asked
