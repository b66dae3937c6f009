#!/usr/bin/env python3
"""Compiles the atoll command from nothing and prints, as a table in Markdown, the units that took longest.

usage: python3 perf/compile_times.py [--units N] [--touch FILE]

With --touch it then compiles again what depends on FILE, a path below the root. Times are CPU seconds of the compiler,
memory is its peak; the compiler cache is left out. Needs what runtime/run.sh installs, on an otherwise idle machine.
"""

import argparse
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import time

root = pathlib.Path(__file__).resolve().parent.parent
build = root / "build" / "compile-times"
log = build / "compile_times.log"


def compile_one(command: list[str]) -> int:
    """Stands ahead of the compiler: notes what one call of it takes."""
    status = subprocess.run(command, check=False).returncode
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    output = command[command.index("-o") + 1] if "-o" in command else "?"
    with log.open("a") as out:  # one short write, so that two calls' lines don't mix
        out.write(f"{usage.ru_utime + usage.ru_stime:.3f} {usage.ru_maxrss} {output}\n")
    return status


def run_build() -> tuple[float, list[tuple[float, float, str]]]:
    """Wall time in s, and CPU time in s, peak memory in MB and name of each unit, longest first."""
    log.write_text("")
    begin = time.monotonic()
    subprocess.run(["ninja", "-C", build, "-j", str(os.cpu_count()), "atoll_command"], check=True, stdout=sys.stderr)
    wall = time.monotonic() - begin
    units = []
    for line in log.read_text().splitlines():
        seconds, kilobytes, output = line.split(maxsplit=2)
        if output.endswith((".o", ".gch")):
            units.append((float(seconds), float(kilobytes) / 1024, output))
    return wall, sorted(units, reverse=True)


def name_of(output: str) -> str:
    """solver/unity_0 of CMakeFiles/atoll_solver.dir/Unity/unity_0_cxx.cxx.o"""
    target = output.split(".dir/")[0].rsplit("/", 1)[-1].removeprefix("atoll_")
    return target + "/" + pathlib.PurePath(output).name.split(".")[0].removesuffix("_cxx")


def summary(what: str, wall: float, units: list[tuple[float, float, str]]) -> str:
    cpu = sum(seconds for seconds, _, _ in units)
    largest = max((memory for _, memory, _ in units), default=0)
    return f"{what}: {wall:.0f} s on {os.cpu_count()} cores, {len(units)} units, {cpu:.0f} s of CPU, at most {largest:.0f} MB"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--units", type=int, default=10, help="rows of the table")
    parser.add_argument("--touch", help="a file to change after that, such as runtime/include/atoll/world.h")
    arguments = parser.parse_args()

    shutil.rmtree(build, ignore_errors=True)
    launcher = f"{sys.executable};{pathlib.Path(__file__).resolve()};--compile"
    subprocess.run(
        ["cmake", "-S", root, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DATOLL_BUILD_TESTS=OFF",
         "-DATOLL_BUILD_PERF=OFF", f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}"],
        check=True, stdout=sys.stderr)
    wall, units = run_build()
    print("| unit | CPU, s | memory, MB |")
    print("|---|---|---|")
    for seconds, memory, output in units[: arguments.units]:
        print(f"| `{name_of(output)}` | {seconds:.1f} | {memory:.0f} |")
    print()
    print(summary("all", wall, units))
    if arguments.touch:
        (root / arguments.touch).touch()
        print(summary(f"after a change of {arguments.touch}", *run_build()))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--compile"]:
        sys.exit(compile_one(sys.argv[2:]))
    main()
