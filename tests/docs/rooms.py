#!/usr/bin/env python3
"""Draws the folders of Atoll and what they include, from the #include lines, to runtime/rooms.svg.

usage: rooms.py          writes the drawing
       rooms.py --check  exit status 1 if it would be another, or if an include runs upward

An arrow is left out where others lead to the same room. What a layer includes of those below it is one arrow.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DRAWING = ROOT / "runtime/rooms.svg"
DIRECTORIES = [ROOT / path for path in
               ("jobs/include", "collision/include", "solver/include", "runtime/include", "runtime")]

# Rooms in the order that they may be included in, from the top down: each sees those in rows below its own.
CORE = ("world", "step", "state")  # one library, whose parts see each other
LAYERS = {
    "runtime": [["command", "python"], ["checks", "view", "batch", "mechanism"], ["scene", "audit", "core"], ["include"]],
    "solver": [["select", "sweep"], ["direct"], ["islands"], ["constraints"], ["integrate"], ["tuning"]],
    "collision": [["queries"], ["continuous"], ["contacts"], ["broadphase", "narrowphase"], ["shapes"]],
    "jobs": [["jobs"]],
}
LABELS = {"runtime/checks": "checks: stability, physics, divergence, soak", "runtime/core": ", ".join(CORE), "runtime/include": "include/atoll, the public API",
          "solver/tuning": "settings, tuning.h", "jobs/jobs": "parallel loops"}

ROWS = [(layer, rooms) for layer, rows in LAYERS.items() for rooms in rows]
ROW_OF = {f"{layer}/{room}": row for row, (layer, rooms) in enumerate(ROWS) for room in rooms}


def room_of(path):
    layer, *folders, _ = path.relative_to(ROOT).parts
    if layer == "jobs":
        return "jobs/jobs"
    if layer == "runtime":
        return "runtime/core" if folders[0] in CORE else f"runtime/{folders[0]}"
    inner = [folder for folder in folders if folder not in ("include", "src", layer)]
    if inner:
        return f"{layer}/{inner[0]}"
    return f"{layer}/tuning"  # headers outside folders: settings and tuned numbers, which all rooms read


def includes():
    """(file, include, room of the file, room of what it includes)."""
    for layer in LAYERS:
        for path in sorted((ROOT / layer).rglob("*")):
            if path.suffix not in (".h", ".cpp") or "examples" in path.parts:
                continue
            for quote, name in re.findall(r'^#include ([<"])([^">]+)', path.read_text(encoding="utf-8"), re.M):
                folders = ([path.parent] if quote == '"' else []) + [ROOT / layer / "src"] + DIRECTORIES
                for folder in folders:
                    target = (folder / name).resolve()
                    if target.is_file():
                        yield str(path.relative_to(ROOT)), name, room_of(path), room_of(target)
                        break


def faults_of(found):
    faults = []
    for path, name, room, target in found:
        for place in (room, target):
            if place not in ROW_OF:
                return [f"{path}: {place} is in no row of tests/docs/rooms.py"]
        if room == target or ROW_OF[target] > ROW_OF[room]:
            continue
        faults.append(f"{path} includes {name}: {room} may not see {target}")
    return faults


def arrows_of(found):
    """Pairs of rooms of one layer, without what other arrows lead to."""
    below = {room: set() for room in ROW_OF}
    for _, _, room, target in found:
        if ROW_OF[target] > ROW_OF[room]:
            below[room].add(target)
    for room in sorted(ROW_OF, key=ROW_OF.get, reverse=True):
        below[room] |= {further for target in below[room] for further in below[target]}
    return sorted((room, target) for room in below for target in below[room]
                  if room.split("/")[0] == target.split("/")[0]
                  and not any(target in below[between] for between in below[room]))


WIDTH, BOX, GAP, MARGIN = 480, 34, 26, 14
STYLE = """
  text { font: 15px system-ui, "Segoe UI", Helvetica, Arial, sans-serif; fill: #1f2328; text-anchor: middle }
  .name { font-weight: 600; text-anchor: start }
  .page { fill: #ffffff } .layer { fill: #eef1f5 } .room { fill: #ffffff; stroke: #59636e }
  .arrow { stroke: #59636e; stroke-width: 1.5; fill: none } .head { fill: #59636e }
  @media (prefers-color-scheme: dark) {
    text { fill: #f0f6fc } .page { fill: #0d1117 } .layer { fill: #1c232c } .room { fill: #0d1117; stroke: #9198a1 }
    .arrow { stroke: #9198a1 } .head { fill: #9198a1 }
  }
"""


def width_of(label):
    return 8.6 * len(label) + 22


def drawing_of(arrows):
    boxes, bands, y = {}, [], MARGIN
    for layer, rows in LAYERS.items():
        top = y
        y += MARGIN - 2
        for rooms in rows:
            labels = [LABELS.get(f"{layer}/{room}", room) for room in rooms]
            widths = [width_of(label) for label in labels]
            space = (WIDTH - 2 * MARGIN - sum(widths)) / (len(rooms) + 1)
            x = MARGIN + space
            for room, label, width in zip(rooms, labels, widths):
                boxes[f"{layer}/{room}"] = (x, y, width, label)
                x += width + space
            y += BOX + GAP
        y += MARGIN - 2 - GAP
        bands.append((layer, top, y))
        y += GAP
    height = y - GAP + MARGIN
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
             f'viewBox="0 0 {WIDTH} {height}" role="img">',
             "<title>Folders of Atoll, and what each includes</title>", f"<style>{STYLE}</style>",
             '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" markerHeight="6" orient="auto">'
             '<path class="head" d="M0 0 8 4 0 8z"/></marker></defs>',
             f'<rect class="page" width="{WIDTH}" height="{height}" rx="8"/>']
    for layer, top, bottom in bands:
        lines.append(f'<rect class="layer" x="{MARGIN}" y="{top}" width="{WIDTH - 2 * MARGIN}" height="{bottom - top}"'
                     ' rx="6"/>')
        lines.append(f'<text class="name" x="{MARGIN + 12}" y="{top + 34}">{layer}/</text>')
    for (_, _, bottom), (_, top, _) in zip(bands, bands[1:]):
        x = MARGIN + 44
        lines.append(f'<path class="arrow" d="M{x} {bottom}V{top - 1}" marker-end="url(#head)"/>')
    for room, target in arrows:
        x, y, width, _ = boxes[room]
        to_x, to_y, to_width, _ = boxes[target]
        # Straight down where the boxes are above each other.
        end = min(max(x + width / 2, to_x + 16), to_x + to_width - 16)
        start = min(max(end, x + 16), x + width - 16)
        lines.append(f'<path class="arrow" d="M{start:.0f} {y + BOX}L{end:.0f} {to_y - 1}" marker-end="url(#head)"/>')
    for x, y, width, label in boxes.values():
        lines.append(f'<rect class="room" x="{x:.0f}" y="{y}" width="{width:.0f}" height="{BOX}" rx="5"/>')
        lines.append(f'<text x="{x + width / 2:.0f}" y="{y + BOX / 2 + 5:g}">{label}</text>')
    return "\n".join(lines) + "\n</svg>\n"


def main():
    found = list(includes())
    faults = faults_of(found)
    drawing = drawing_of(arrows_of(found)) if not faults else None
    if sys.argv[1:] == ["--check"]:
        if not faults and (not DRAWING.is_file() or DRAWING.read_text(encoding="utf-8") != drawing):
            faults.append("runtime/rooms.svg is not what python3 tests/docs/rooms.py draws now")
    elif not faults:
        DRAWING.write_text(drawing, encoding="utf-8")
    print("\n".join(faults) or f"{len(found)} includes, none upward")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
