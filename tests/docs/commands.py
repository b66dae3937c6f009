#!/usr/bin/env python3
"""Runs the command lines of each README and page of the guide, in a folder of its own that looks like the repository.

usage: commands.py SCRATCH BIN PREFIX COMPILER [FLAG...]

BIN is where programs were built, PREFIX where Atoll is installed. `g++` on a page is COMPILER with these flags, and
main.cpp the page's own program, or that of README.md where it has none. What a marker leaves out is not run, nor is what is quoted in the text; of those each
program or file has to be there, and each option has to be known to it.
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from blocks import ROOT, folder_name, readmes, split
from programs import program_of

TIME_LIMIT = 600  # s


def lines_of(block):
    for line in block.text.replace("\\\n", " ").splitlines():
        if shlex.split(line, comments=True):
            yield line


def left_out(line, marker):
    match = re.match(r"not run\b(.*?):", marker)
    if not match:
        return False
    beginnings = re.findall(r"`([^`]+)`", match[1])
    return not beginnings or any(line.startswith(beginning) for beginning in beginnings)


class Check:
    """Whether what a command line names is there, without running it."""

    def __init__(self, bin_folder):
        self.bin = bin_folder
        self.helps = {}
        self.targets = "\n".join(path.read_text() for folder in ("perf", "tests")
                                 for path in ROOT.glob(f"{folder}/**/CMakeLists.txt"))
        self.presets = (ROOT / "CMakePresets.json").read_text()

    def help_of(self, *command):
        if command not in self.helps:
            run = subprocess.run([*command, "--help"], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 timeout=60)
            self.helps[command] = run.stdout
        return self.helps[command]

    def failure(self, line):
        """What is wrong with a command line, or None."""
        try:
            words = shlex.split(line, comments=True)
        except ValueError as error:
            return str(error)
        options = [word.split("=")[0] for word in words[1:] if re.match(r"--?[a-zA-Z]", word)]
        name = pathlib.Path(words[0]).name
        if name == "atoll":
            return self.atoll_failure(words, options)
        if name.startswith("atoll_"):
            return self.program_failure(name, options)
        if name in ("bash", "python3") and len(words) > 1:
            return self.script_failure(words, options)
        if name == "cmake" and "--preset" in words:
            preset = words[words.index("--preset") + 1]
            return None if f'"name": "{preset}"' in self.presets else f"no preset {preset}"
        return None

    def atoll_failure(self, words, options):
        program = str(self.bin / "atoll")
        command = words[1] if len(words) > 1 and not words[1].startswith("-") else None
        if command and not re.search(rf"^  {command}\b", self.help_of(program), re.M):
            return f"atoll has no command {command}"
        return self.unknown(options, self.help_of(program, command) if command else self.help_of(program))

    def program_failure(self, name, options):
        stem = re.sub("^atoll_(peer_)?", "", name)
        if not re.search(rf"\b(atoll_)?{stem}\b", self.targets) and not list(ROOT.glob(f"perf/{stem}.cpp")):
            return f"nothing builds {name}"
        program = self.bin / name
        # Benchmarks are not a part of every build.
        return self.unknown(options, self.help_of(str(program))) if options and program.exists() else None

    def script_failure(self, words, options):
        script = ROOT / words[1]
        if not script.is_file():
            return f"no file {words[1]}"
        # A script says what its options are, and hands others on.
        known = script.read_text() + "".join(self.help_of(str(self.bin / "atoll"), command)
                                             for command in ("run", "sweep"))
        return self.unknown(options, known)

    @staticmethod
    def unknown(options, known):
        for option in options:
            if not re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", known):
                return f"no option {option}"
        return None


def environment(scratch, bin_folder, prefix, compiler, flags):
    tools = scratch / "tools"
    tools.mkdir(parents=True)
    (tools / "g++").write_text(f'#!/bin/sh\nexec {shlex.join([shutil.which(compiler), *flags])} "$@"\n')
    (tools / "g++").chmod(0o755)
    found = os.environ.copy()
    found["PATH"] = f"{tools}:{bin_folder}:{found['PATH']}"
    found["PKG_CONFIG_PATH"] = ":".join(str(path.parent) for path in pathlib.Path(prefix).glob("**/atoll.pc"))
    return found


def folder_for(readme, blocks, scratch, bin_folder):
    folder = scratch / folder_name(readme)
    (folder / "build/release").mkdir(parents=True)
    (folder / "build/release/bin").symlink_to(bin_folder)
    for part in ("runtime", "collision", "solver", "jobs", "tests", "perf"):
        (folder / part).symlink_to(ROOT / part)
    source = program_of(blocks) or program_of(split(ROOT / "README.md")[0])
    (folder / "main.cpp").write_text(source, encoding="utf-8")
    for block in blocks:
        if block.language == "json":
            (folder / f"scene_{block.line}.json").write_text(block.text, encoding="utf-8")
    return folder


def main():
    scratch, bin_folder, prefix, compiler, *flags = sys.argv[1:]
    scratch, bin_folder = pathlib.Path(scratch), pathlib.Path(bin_folder)
    shutil.rmtree(scratch, ignore_errors=True)
    variables = environment(scratch, bin_folder, prefix, compiler, flags)
    check = Check(bin_folder)
    failures, ran, checked = [], 0, 0
    for readme in readmes():
        blocks, prose = split(readme)
        folder = folder_for(readme, blocks, scratch, bin_folder)
        commands = [(block.place(), line, left_out(line, block.marker))
                    for block in blocks if block.language == "sh" for line in lines_of(block)]
        commands += [(f"{block.place()}", f"atoll run scene_{block.line}.json", False)
                     for block in blocks if block.language == "json"]
        quoted = re.findall(r"`((?:atoll|bash|python3|build/release/bin/\w+) [^`]+)`", prose)
        commands += [(str(readme.relative_to(ROOT)), line.replace("\n", " "), True) for line in quoted]
        for place, line, only_checked in commands:
            failure = check.failure(line)
            checked += 1
            if not failure and not only_checked:
                run = subprocess.run(["bash", "-c", line], cwd=folder, env=variables, text=True, stdin=subprocess.DEVNULL,
                                     stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=TIME_LIMIT)
                ran += 1
                if run.returncode:
                    failure = f"exit status {run.returncode}\n{run.stdout[-2000:]}"
            if failure:
                failures.append(f"{place}: {line}\n  {failure}")
    print("\n".join(failures))
    print(f"{ran} commands ran, {checked} were looked at, {len(failures)} failed")
    sys.exit(bool(failures) or ran == 0)


if __name__ == "__main__":
    main()
