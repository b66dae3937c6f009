#!/usr/bin/env python3
"""Looks up every file and folder that a README or a page of the guide names between backticks.

A name counts as a path if it ends as source files and documents do, or in a slash. It may be given from the repository's
root, from the page's folder, or by its last parts alone: `contact_law.h`. Links are followed by tests/unit/docs_test.cpp.
"""

import os
import re
import sys

from blocks import ROOT, readmes, split

ENDINGS = "h|cpp|py|sh|cmake|md|svg|js|ts"
PATH = re.compile(rf"`((?:\.\./)*[\w.*-]+(?:/[\w.*-]+)*(?:\.(?:{ENDINGS})|/))`")
# Files and folders that users' programs, and builds, have or make.
OTHERS = {"main.cpp", "build/", "snapshots/"}


def names_in_repository():
    """Each file and folder, the latter with a slash at its end, from the root."""
    for folder, folders, files in os.walk(ROOT):
        folders[:] = sorted(name for name in folders if name not in (".git", "build", "node_modules"))
        place = os.path.relpath(folder, ROOT)
        for name in [*files, *(f"{name}/" for name in folders)]:
            yield "/" + os.path.join("" if place == "." else place, name)


def main():
    names = list(names_in_repository())
    ends = {name[i:] for name in names for i, letter in enumerate(name[:-1]) if letter == "/"}
    failures, looked_up = [], 0
    for readme in readmes():
        for path in PATH.findall(split(readme)[1]):
            if path in OTHERS or path.startswith("build/"):
                continue
            looked_up += 1
            pattern = re.compile(re.escape("/" + path.lstrip("./")).replace(r"\*", "[^/]*"))
            found = ("/" + path in ends) or (readme.parent / path).exists() or ("*" in path and any(
                pattern.fullmatch(end) for end in ends))
            if not found:
                failures.append(f"{readme.relative_to(ROOT)}: there is no `{path}`")
    print("\n".join(failures))
    print(f"{looked_up} paths were looked up, {len(failures)} are not there")
    sys.exit(bool(failures) or looked_up == 0)


if __name__ == "__main__":
    main()
