#!/usr/bin/env python3
"""Counts functions and data members of every class, and fails where one has more than the bounds.

Usage: class_sizes.py SOURCE_DIRECTORY [--all]

A struct with nothing private is a list of fields, and may have more of them. Constructors, destructors and operators
count as functions; nested types count for themselves.
"""
import pathlib
import re
import sys

MOST_FUNCTIONS = 25
MOST_MEMBERS = 15
# The public API: calls that check their arguments and hand on, over one member.
EXEMPT = {"World"}
FOLDERS = ["jobs", "collision", "solver", "runtime"]

NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|^[ \t]*#[^\n]*|R"\((?:.|\n)*?\)"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S | re.M)
CLASS = re.compile(r"\b(class|struct)\s+(?:alignas\([^)]*\)\s*)?([A-Za-z_][\w:]*)(?:\s+final)?\s*(?::[^;{()]*)?\{")
NOT_A_MEMBER = re.compile(r"^(using|friend|typedef|enum|class|struct|static_assert|static\s+constexpr|template\s*<[^;]*>\s*(class|struct|friend)|public|private|protected)\b")


def body_of(text, opening):
    depth = 0
    for at in range(opening, len(text)):
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        if depth == 0:
            return text[opening + 1 : at]
    return ""


def statements(body):
    """What a class declares, with what is between braces left out."""
    found, now, depth, parentheses = [], "", 0, 0
    for c in body:
        if c == "{":
            depth += 1
            if depth == 1:
                now += "{"
        elif c == "}":
            depth -= 1
            # A function's body ends its declaration; an initialiser is followed by a semicolon or a comma.
            if depth == 0 and parentheses == 0 and is_function(now.rstrip("{")):
                found.append(now)
                now = ""
        elif depth == 0:
            parentheses += {"(": 1, ")": -1}.get(c, 0)
            if c == ";" and parentheses == 0:
                found.append(now)
                now = ""
            else:
                now += c
    return [re.sub(r"\b(public|private|protected)\s*:(?!:)", "", s).strip() for s in found]


def is_function(statement):
    """Whether a parenthesis comes before an initialiser, outside of template arguments."""
    text = re.sub(r"^\s*template\s*<.*?>\s*(?=[\w\[:~])", "", re.sub(r"\b(public|private|protected)\s*:(?!:)", "", statement).strip(), flags=re.S)
    text = re.sub(r"\balignas\([^)]*\)|\bdecltype\([^)]*\)", "", text)
    if re.match(r"^(enum|class|struct|union|using)\b", text):
        return False
    depth = 0
    for at, c in enumerate(text):
        if text.startswith("operator", at):
            return True
        if c == "<":
            depth += 1
        elif c == ">":
            depth -= 1
        elif c == "=" and depth == 0:
            return False
        elif c == "(" and depth == 0:
            return True
    return False


def outer(text, match):
    """The body of a class without what is between braces in it."""
    flat, depth = "", 0
    for c in body_of(text, match.end() - 1):
        depth += {"{": 1, "}": -1}.get(c, 0)
        flat += c if depth == 0 else ""
    return flat


def sizes(text):
    for match in CLASS.finditer(text):
        declared = [s for s in statements(body_of(text, match.end() - 1)) if s]
        functions = [s for s in declared if is_function(s) and not NOT_A_MEMBER.match(s)]
        members = [s for s in declared if not is_function(s) and not NOT_A_MEMBER.match(s)]
        is_fields = match.group(1) == "struct" and not re.search(r"\b(private|protected)\s*:(?!:)", outer(text, match))
        yield match.group(2), len(functions), len(members), is_fields


def main():
    root = pathlib.Path(sys.argv[1])
    show_all = "--all" in sys.argv
    faults = classes = 0
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in {".h", ".cpp"} or "build" in path.relative_to(root).parts:
                continue
            for name, functions, members, is_fields in sizes(NOISE.sub(" ", path.read_text())):
                classes += 1
                too_large = functions > MOST_FUNCTIONS or (not is_fields and members > MOST_MEMBERS)
                fault = name not in EXEMPT and too_large
                if show_all or fault:
                    print(f"{path.relative_to(root)}: {name} has {functions} functions and {members} members")
                faults += fault
    print(f"{classes} classes, {faults} against the bounds of {MOST_FUNCTIONS} functions and {MOST_MEMBERS} members")
    return 1 if faults or classes == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
