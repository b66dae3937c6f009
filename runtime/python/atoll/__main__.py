"""`python -m atoll ensemble PLAN.json --out DIR`."""

from __future__ import annotations

import sys

from ._ensemble import command


def main() -> int:
    if sys.argv[1:2] == ["ensemble"]:
        return command.main(sys.argv[2:])
    print("usage: python -m atoll ensemble PLAN.json --out DIR; --help tells more", file=sys.stderr)
    return 0 if sys.argv[1:] in (["-h"], ["--help"]) else 2


if __name__ == "__main__":
    sys.exit(main())
