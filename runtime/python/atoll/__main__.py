"""`python -m atoll ensemble PLAN.json --out DIR`, and `python -m atoll import ROBOT.xml -o SCENE.json`."""

from __future__ import annotations

import sys

from ._ensemble import command as ensemble
from ._robots import command as robots


def main() -> int:
    if sys.argv[1:2] == ["ensemble"]:
        return ensemble.main(sys.argv[2:])
    if sys.argv[1:2] == ["import"]:
        return robots.main(sys.argv[2:])
    usage = "usage: python -m atoll ensemble PLAN.json --out DIR, or import ROBOT.xml -o SCENE.json; --help tells more"
    print(usage, file=sys.stderr)
    return 0 if sys.argv[1:] in (["-h"], ["--help"]) else 2


if __name__ == "__main__":
    sys.exit(main())
