#!/usr/bin/env python3
"""Writes the tables of perf/*.md from the files in perf/results.

usage: tables.py          writes them
       tables.py --check  exit status 1 if one would be another

A table stands between `<!-- table: NAME -->` and `<!-- end of table -->`. NAME is that of a file of results, or one of
`SUMMARIES` here. Each file has columns `date`, `machine` and `versions`; they make the line below the table. Those of
results.csv, which `atoll sweep` writes itself, are in results_origin.csv.
"""

from __future__ import annotations

import csv
import re
import sys
from collections.abc import Callable
from pathlib import Path

import robot_table

PERF = Path(__file__).resolve().parent
MARKED = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end of table -->)", re.DOTALL)
ORIGIN = ("date", "machine", "versions")
MEASURES = ("analytic_error", "joint_gap_run_mean", "penetration_mean")
NAMES = {"bullet": "Bullet", "ode": "ODE", "mujoco": "MuJoCo"}
Row = dict[str, str]


def load(name: str) -> list[Row]:
    with (PERF / f"results/{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def markdown(heads: list[str], rows: list[list[str]]) -> str:
    lines = [f"| {' | '.join(line)} |" for line in [heads, *rows]]
    return "\n".join([lines[0], "|" + "---|" * len(heads), *lines[1:]]) + "\n"


def origin(rows: list[Row]) -> str:
    dates = sorted({row["date"] for row in rows})
    parts = [dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"]
    parts += [", ".join(dict.fromkeys(row[column] for row in rows)) for column in ORIGIN[1:]]
    return f"\nMeasured {'; '.join(parts)}.\n"


def whole(name: str) -> str:
    rows = load(name)
    heads = [head for head in rows[0] if head not in ORIGIN]
    return markdown(heads, [[row[head] for head in heads] for row in rows]) + origin(rows)


def number(value: float) -> str:
    if value and value < 0.001:
        return f"{value:.1e}"
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def nearest(default: Row, others: list[Row], measure: str) -> str:
    """The fastest run of another engine at no more error, else the one that errs least."""
    able = [row for row in others if row["outcome"] == "done" and row[measure] and row["cpu_s_per_simulated_s"]]
    if not able:
        return "no other engine does it"
    error, time = float(default[measure]), float(default["cpu_s_per_simulated_s"])
    as_good = [row for row in able if float(row[measure]) <= error]
    if as_good:
        best = min(as_good, key=lambda row: float(row["cpu_s_per_simulated_s"]))
        return f"{NAMES[best['engine']]}, {best['label']}: {number(float(best['cpu_s_per_simulated_s']) / time)} x the time"
    best = min(able, key=lambda row: float(row[measure]))
    return f"{NAMES[best['engine']]}, {best['label']}: error {number(float(best[measure]))}"


def sweep() -> str:
    rows = load("results")
    lines = []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        some = [row for row in rows if row["scene"] == scene]
        default = next(row for row in some if row["engine"] == "Atoll" and row["default"] == "1")
        measure = next(name for name in MEASURES if default[name])
        lines.append([f"`{scene.split(':')[0]}`", number(float(default[measure])),
                      number(1000 * float(default["cpu_s_per_simulated_s"])),
                      nearest(default, [row for row in some if row["engine"] != "Atoll"], measure)])
    return markdown(["scene", "error", "ms", "nearest of the others"], lines) + origin(load("results_origin"))


def frontier() -> str:
    """The last rung of each engine with any number of substeps."""
    rows = load("frontier")
    engines = list(dict.fromkeys(row["engine"] for row in rows))
    settings = ("1", "2", "4", "8", "16 substeps")
    lines = []
    for climb in dict.fromkeys(row["the most (rungs)"] for row in rows):
        rungs = re.search(r"\((\S+) \.\.\. (\S+)\)", climb)
        cells = [climb]
        for engine in engines:
            row = next(row for row in rows if (row["the most (rungs)"], row["engine"]) == (climb, engine))
            reached = [row[of].split(":")[0] for of in settings if row[of] != "-"]
            value = {"all": float("inf")} | {rung: fraction(rung) for rung in reached if rung != "all"}
            best = max(reached, key=lambda rung: value[rung], default="none")
            cells.append(rungs[2] if rungs and best == "all" else best)
        lines.append(cells)
    return markdown(["the most (rungs)", *engines], lines) + origin(rows)


def fraction(text: str) -> float:
    over, _, under = text.partition("/")
    return float(over) / float(under or 1)


def physics() -> str:
    """How many laws hold, and which don't."""
    rows = load("physics")
    beyond = [row for row in rows if float(row["error"]) > float(row["limit"])]
    lines = [[row["case"], row["limit"], row["error"], row["dt/4"], row["dt/16"]] for row in beyond]
    held = f"{len(rows) - len(beyond)} of {len(rows)} laws hold to their limits. The others are:\n\n"
    return held + markdown(["case", "limit", "error", "at dt/4", "at dt/16"], lines) + origin(rows)


def robots(free: bool) -> str:
    rows = [row for row in robot_table.load(robot_table.RESULTS) if row["run"].startswith("free") == free]
    order = list(dict.fromkeys(row["robot"] for row in rows))
    rows.sort(key=lambda row: (order.index(row["robot"]), robot_table.RUNS.index(row["run"])))
    lines = robot_table.free_table(rows) if free else robot_table.touching_table(rows)
    versions = [row | {"versions": f"Atoll {row['atoll']}, MuJoCo {row['mujoco']}"} for row in rows]
    return "\n".join(lines) + "\n" + origin(versions)


SUMMARIES: dict[str, Callable[[], str]] = {
    "results": sweep, "frontier": frontier, "physics": physics,
    "robots_free": lambda: robots(free=True), "robots_touching": lambda: robots(free=False),
}


def filled(text: str) -> str:
    return MARKED.sub(lambda mark: mark[1] + SUMMARIES.get(mark[2], lambda: whole(mark[2]))() + mark[3], text)


def main() -> None:
    check = sys.argv[1:] == ["--check"]
    different, count = [], 0
    for page in sorted(PERF.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        count += len(MARKED.findall(text))
        if filled(text) == text:
            continue
        different.append(page.name)
        if not check:
            page.write_text(filled(text), encoding="utf-8")
    if check and (different or count == 0):
        sys.exit(f"perf/tables.py would write other tables: {', '.join(different) or 'no page has any'}")


if __name__ == "__main__":
    main()
