#!/usr/bin/env python3
"""The results of robot_rates.py as Markdown: `python perf/robot_table.py` prints it."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parent / "results/robots.csv"
RUNS = ["free, held", "free, driven", "touching, held", "touching, driven"]
OWN, DEFAULT = "its own", "4 substeps"
KEY = ("robot", "run", "engine", "setting", "worlds", "threads")
Row = dict[str, Any]


def processor() -> str:
    info = Path("/proc/cpuinfo")
    names = [line.split(":")[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
    return names[0] if names else "?"


def load(path: Path) -> list[Row]:
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def add(path: Path, rows: list[Row]) -> None:
    """To the file, in which rows of the same robot, run, engine, setting, worlds and threads give way."""
    all_rows = {tuple(str(row[of]) for of in KEY): row for row in load(path) + rows}
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(all_rows.values())


def rounded(value: float) -> str:
    return f"{value:,.0f}" if value >= 10 else f"{value:.1f}"


def row_of(rows: Iterable[Row], engine: str, setting: str) -> Row:
    return next(row for row in rows if (row["engine"], row["setting"]) == (engine, setting))


def fastest(rows: Iterable[Row], engine: str, error: float) -> Row | None:
    """At no more error."""
    able = [row for row in rows if row["engine"] == engine and float(row["error"]) <= error]
    return max(able, key=lambda row: float(row["rate"]), default=None)


def as_good(row: Row | None, beside: Row) -> str:
    """A setting, and its rate as a multiple of another's."""
    return "none" if row is None else f"{row['setting']}: {float(row['rate']) / float(beside['rate']):.2g} x"


def free_table(rows: list[Row]) -> list[str]:
    heads = ["robot", "controls", "Atoll: error", "rate", "MuJoCo: error", "rate"]
    heads += ["MuJoCo's fastest that is as good as Atoll", "Atoll's fastest that is as good as MuJoCo"]
    lines = [f"| {' | '.join(heads)} |", "|---|---|--:|--:|--:|--:|---|---|"]
    for robot, run in dict.fromkeys((row["robot"], row["run"]) for row in rows):
        some = [row for row in rows if (row["robot"], row["run"]) == (robot, run)]
        ours, theirs = row_of(some, "Atoll", DEFAULT), row_of(some, "MuJoCo", OWN)
        cells = [robot, run.split(", ")[1]]
        for row in (ours, theirs):
            cells += [f"{float(row['error']):.1e}", rounded(float(row["rate"]))]
        cells.append(as_good(fastest(some, "MuJoCo", float(ours["error"])), ours))
        cells.append(as_good(fastest(some, "Atoll", float(theirs["error"])), theirs))
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def touching_table(rows: list[Row]) -> list[str]:
    """Atoll's rate / MuJoCo's, on one thread, and of the most worlds on the most threads."""
    places = sorted({(int(row["threads"]), int(row["worlds"])) for row in rows})
    places = [place for place in places if place[0] == 1] + places[-1:]
    heads = [f"{worlds:,}" + (f", {threads} threads" if threads > 1 else "") for threads, worlds in places]
    lines = [f"| robot | controls | {' | '.join(heads)} |", "|---|---|" + "--:|" * len(places)]
    for robot, run in dict.fromkeys((row["robot"], row["run"]) for row in rows):
        cells = [robot, run.split(", ")[1]]
        for place in places:
            there = [row for row in rows if (int(row["threads"]), int(row["worlds"])) == place]
            some = [row for row in there if (row["robot"], row["run"]) == (robot, run)]
            pair = (("Atoll", DEFAULT), ("MuJoCo", OWN))
            cells.append(" / ".join(rounded(float(row_of(some, *of)["rate"])) for of in pair) if some else "-")
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def text(path: Path = RESULTS) -> str:
    rows = load(path)
    free = [row for row in rows if row["run"].startswith("free")]
    touching = [row for row in rows if not row["run"].startswith("free")]
    order = list(dict.fromkeys(row["robot"] for row in rows))
    for some in (free, touching):
        some.sort(key=lambda row: (order.index(row["robot"]), RUNS.index(row["run"])))
    lost = sum(int(row["lost"]) for row in rows)
    return "\n".join([*free_table(free), "", *touching_table(touching), "", f"Bodies lost, and warnings: {lost}."])


if __name__ == "__main__":
    print(text())
