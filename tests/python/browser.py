"""A browser, to look at pages with: a matter of ATOLL_LONG_TESTS=1."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from conftest import LONG_TESTS

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
PROGRAM = next((name for name in NAMES if LONG_TESTS and shutil.which(name)), None)


def load(page: Path, profile: Path) -> tuple[str, str]:
    """The document once 30 s have gone by in it, and what it wrote to the console."""
    assert PROGRAM is not None
    options = (
        "--headless --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --ignore-gpu-blocklist --disable-quic "
        "--no-first-run --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage "
        "--enable-logging=stderr --window-size=1100,900 --virtual-time-budget=30000 --dump-dom"
    )
    words = [PROGRAM, *options.split(), f"--user-data-dir={profile}", page.as_uri()]
    done = subprocess.run(words, capture_output=True, text=True, timeout=3600)
    return done.stdout, "\n".join(line for line in done.stderr.splitlines() if ":CONSOLE" in line)
