"""Blocks of code in the READMEs and the guide, and what their languages promise.

cpp    part of a program: the first of a page has main(), and each one after it goes on at the end of main().
       A block `text` that follows has what the program prints up to there.
cmake  how a program of ours is linked; `my_program` is the program.
sh     commands, each of which is run, in one folder for a page. An HTML comment ahead of the block leaves some out:
       <!-- not run: REASON --> all of them, <!-- not run `COMMAND`, `COMMAND`: REASON --> those that begin like that.
       Of these it is checked that programs, files and options are there.
json   a scene file.
python a program, which tests/python runs.
text   nothing: output, drawings.
"""

import pathlib
import re
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
LANGUAGES = ("cpp", "cmake", "sh", "json", "python", "text")


class Block(NamedTuple):
    readme: pathlib.Path
    line: int  # of the fence, counted from 1
    language: str
    text: str
    marker: str  # the HTML comment ahead of it, or ""

    def place(self):
        return f"{self.readme.relative_to(ROOT)}:{self.line}"


def readmes():
    return [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")] + sorted(
        path for folder in ("jobs", "collision", "solver", "runtime", "tests", "perf")
        for path in (ROOT / folder).rglob("*.md"))


def folder_name(readme):
    """Of a page's own, for files that its test makes."""
    return "_".join(readme.relative_to(ROOT).with_suffix("").parts)


def split(readme):
    """The blocks of a README, and its lines outside of them."""
    blocks, prose, text = [], [], None
    for number, line in enumerate(readme.read_text(encoding="utf-8").splitlines(), 1):
        if text is not None:
            if line.startswith("```"):
                blocks.append(Block(readme, start, language, "".join(text), marker))
                text = None
            else:
                text.append(line + "\n")
        elif line.startswith("```"):
            start, language, text = number, line[3:].strip(), []
            comment = re.fullmatch(r"<!--\s*(.*?)\s*-->", prose[-1]) if prose else None
            marker = comment[1] if comment else ""
        else:
            prose.append(line)
    if text is not None:
        raise SystemExit(f"{readme}: a block has no end")
    for block in blocks:
        if block.language not in LANGUAGES:
            raise SystemExit(f"{block.place()}: `{block.language}` is none of {', '.join(LANGUAGES)}")
    return blocks, "\n".join(prose)
