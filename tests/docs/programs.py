#!/usr/bin/env python3
"""Builds and runs the C++ of each page as one program, linked as the pages say, and compares what it prints.

usage: programs.py SCRATCH PREFIX CMAKE [CMAKE OPTION...]

PREFIX is where Atoll is installed. Numbers may be off by 0.001, or a thousandth of them: what they are held to is what
a reader sees, not the bits.
"""

import pathlib
import re
import shutil
import subprocess
import sys

from blocks import folder_name, readmes, split


def program_of(blocks):
    """The parts of a program, as one; or None. Each line says where it comes from."""
    parts = [block for block in blocks if block.language == "cpp"]
    if not parts:
        return None
    sources = [f'#line {part.line + 1} "{part.readme}"\n{part.text}' for part in parts]
    body = sources[0].rstrip()
    if not body.endswith("}"):
        raise SystemExit(f"{parts[0].place()}: does not end with main()")
    return body[:-1] + "\n".join(sources[1:]) + "}\n"


def output_of(blocks):
    return "".join(block.text for before, block in zip(blocks, blocks[1:])
                   if block.language == "text" and before.language == "cpp")


def same(found, expected):
    def agree(a, b):
        try:
            return abs(float(a) - float(b)) <= max(1e-3, 1e-3 * abs(float(b)))
        except ValueError:
            return a == b
    lines = [text.strip().splitlines() for text in (found, expected)]
    words = [[line.split() for line in text] for text in lines]
    return [len(line) for line in words[0]] == [len(line) for line in words[1]] and all(
        agree(a, b) for left, right in zip(*words) for a, b in zip(left, right))


def project_of(programs, block):
    """A CMake project with every program, each linked as the block says."""
    lines = ["cmake_minimum_required(VERSION 3.25)", "project(samples CXX)"]
    for name in programs:
        lines += [f"add_executable({name} {name}.cpp)",
                  f"target_compile_options({name} PRIVATE -Wall -Wextra -Werror)",
                  block.text.replace("my_program", name)]
    return "\n".join(lines)


def main():
    scratch, prefix, cmake, *options = sys.argv[1:]
    shutil.rmtree(scratch, ignore_errors=True)
    pages = {folder_name(readme): (readme, split(readme)[0]) for readme in readmes()}
    programs = {name: source for name, (_, blocks) in pages.items() if (source := program_of(blocks))}
    linking = [block for _, blocks in pages.values() for block in blocks if block.language == "cmake"]
    failures = 0
    for block in linking:
        folder = pathlib.Path(scratch, f"{folder_name(block.readme)}_{block.line}")
        build = folder / "build"
        folder.mkdir(parents=True)
        for name, source in programs.items():
            (folder / f"{name}.cpp").write_text(source, encoding="utf-8")
        (folder / "CMakeLists.txt").write_text(project_of(programs, block), encoding="utf-8")
        subprocess.run([cmake, "-S", folder, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", *options], check=True,
                       stdout=subprocess.DEVNULL)
        for name in programs:
            readme, blocks = pages[name]
            if subprocess.run([cmake, "--build", build, "--target", name]).returncode:
                print(f"{readme}: its samples do not compile")
                failures += 1
                continue
            run = subprocess.run([build / name], cwd=folder, text=True, stdout=subprocess.PIPE, timeout=600)
            if run.returncode or not same(run.stdout, output_of(blocks)):
                print(f"{readme}: status {run.returncode}, printed\n{run.stdout}\ninstead of\n{output_of(blocks)}")
                failures += 1
    print(f"{len(programs)} programs")
    sys.exit(failures > 0 or not programs or not linking)


if __name__ == "__main__":
    main()
