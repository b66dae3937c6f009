#!/usr/bin/env python3
"""Draws error against run time of two scenes, of the runs in results.csv, to diagram.svg beside this file.

usage: diagram.py          writes the drawing
       diagram.py --check  exit status 1 if it would be another

The page of `atoll sweep` draws the same for every scene (runtime/command/sweep/page).
"""

import csv
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
DRAWING = HERE / "diagram.svg"

PANELS = (  # scene, measure, and in words
    ("pushed-box:force=150,angle=0.5235987755982988", "analytic_error",
     "A box is pushed under 25 balls that roll on it", "distance from the closed form, over the path"),
    ("pyramid3d:layers=18", "penetration_mean", "2109 boxes stand as a pyramid", "mean overlap, m"),
)
ENGINES = {"Atoll": "Atoll", "bullet": "Bullet", "ode": "ODE", "mujoco": "MuJoCo"}
NO_ERROR = 1e-16
WIDTH, HEIGHT, MARGIN = 470, 400, {"left": 62, "right": 12, "top": 64, "bottom": 74}

STYLE = """
  text { font: 12px system-ui, "Segoe UI", Helvetica, Arial, sans-serif; fill: #59636e }
  .title { font-size: 15px; font-weight: 600; fill: #1f2328 } .axis { font-size: 13px; fill: #1f2328 }
  .grid { stroke: #e4e8ec; fill: none } .frame { stroke: #d1d9e0; fill: none }
  .front { stroke-width: 2; fill: none; stroke-linejoin: round } .others { stroke: #59636e; stroke-dasharray: 6 4 }
  .label { font-weight: 600; stroke: #ffffff; stroke-width: 3.5; stroke-linejoin: round; paint-order: stroke }
  .mark { stroke: #ffffff; stroke-width: .75 } .ring { fill: none; stroke-width: 1.6 }
  .spread { stroke-width: 1.2; opacity: .55 }
  .page { fill: #ffffff } .c0 { fill: #0b63c5 } .c1 { fill: #bc4c00 } .c2 { fill: #1a7f37 } .c3 { fill: #8250df }
  .s0 { stroke: #0b63c5 } .s1 { stroke: #bc4c00 } .s2 { stroke: #1a7f37 } .s3 { stroke: #8250df }
  @media (prefers-color-scheme: dark) {
    text { fill: #9aa4af } .title, .axis { fill: #e6edf3 } .grid { stroke: #262c34 } .frame { stroke: #30363d }
    .others { stroke: #9aa4af } .label, .mark { stroke: #0d1117 } .page { fill: #0d1117 }
    .c0 { fill: #58a6ff } .c1 { fill: #f0883e } .c2 { fill: #56d364 } .c3 { fill: #bc8cff }
    .s0 { stroke: #58a6ff } .s1 { stroke: #f0883e } .s2 { stroke: #56d364 } .s3 { stroke: #bc8cff }
  }
"""


class Run:
    def __init__(self, row, measure):
        self.engine, self.label, self.default = row["engine"], row["label"], row["default"] == "1"
        self.time, self.lowest, self.highest = (float(row[k]) for k in ("cpu_s_per_simulated_s", "cpu_min", "cpu_max"))
        self.error = max(NO_ERROR, abs(float(row[measure])))
        self.colour = list(ENGINES).index(self.engine)


def runs_of(rows, scene, measure):
    """Those with an error and a time. Threads and instruction sets don't change a bit, so they are no marks."""
    same_bits = lambda row: row["engine"] == "Atoll" and (row["threads"], row["simd"]) != ("1", "auto")
    return [Run(row, measure) for row in rows if row["scene"] == scene and row["outcome"] == "done" and row[measure]
            and row["cpu_s_per_simulated_s"] and not same_bits(row)]


def front(runs):
    """What no other beats in both, from the fastest on."""
    found = []
    for run in sorted(runs, key=lambda r: (r.time, r.error)):
        if not found or run.error < found[-1].error:
            found.append(run)
    return found


class Scale:
    """A logarithmic axis, with some air at its ends."""

    def __init__(self, values, start, end):
        low, high = math.log10(min(values)), math.log10(max(values))
        air = max(0.07 * (high - low), 0.08)
        self.low, self.high, self.start, self.end = low - air, high + air, start, end

    def __call__(self, value):
        return self.start + (math.log10(value) - self.low) / (self.high - self.low) * (self.end - self.start)

    def decades(self):
        return range(math.ceil(self.low), math.floor(self.high) + 1)


def marker(colour, r):
    shapes = (f"M{-r} 0A{r} {r} 0 1 1 {r} 0A{r} {r} 0 1 1 {-r} 0Z",
              *("M" + "L".join(f"{x * r:.2f} {y * r:.2f}" for x, y in points) + "Z" for points in (
                  ((-.9, -.9), (.9, -.9), (.9, .9), (-.9, .9)), ((0, -1.15), (1.1, .85), (-1.1, .85)),
                  ((0, -1.3), (1.1, 0), (0, 1.3), (-1.1, 0)))))
    return f'<path class="mark c{colour}" d="{shapes[colour]}"/>'


def power_of_ten(exponent):
    if -3 <= exponent <= 2:
        return f"{10.0 ** exponent:g}"
    return "10" + ("⁻" if exponent < 0 else "") + "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(d)] for d in str(abs(exponent)))


def duration(exponent):
    return {-3: "1 ms", -2: "10 ms", -1: "100 ms", 0: "1 s", 1: "10 s"}[exponent]


def staircase(points, x, y, top, right):
    d = f"M{x(points[0].time):.1f} {top}V{y(points[0].error):.1f}"
    for point in points[1:]:
        d += f"H{x(point.time):.1f}V{y(point.error):.1f}"
    return d + f"H{right}"


def labels(runs, lines, x, y, bounds):
    """Names of the defaults, each where it covers least."""
    placed, texts = [], []
    overlaps = lambda a, b: a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
    boxes_of = lambda r: (min(x(r.lowest), x(r.time) - 6), y(r.error) - 6, max(x(r.highest), x(r.time) + 6), y(r.error) + 6)
    for run in (r for r in runs if r.default):
        text = ENGINES[run.engine] + " default"
        w, h, px, py = 6.9 * len(text), 14, x(run.time), y(run.error)
        best = None
        for dx, dy in ((15, -7), (-15 - w, -7), (-w / 2, -28), (-w / 2, 14), (10, -26), (10, 12), (-10 - w, -26),
                       (-10 - w, 12), (26, -42), (26, 28), (-26 - w, -42), (-26 - w, 28), (-w / 2, 30), (-w / 2, -44)):
            box = (px + dx, py + dy, px + dx + w, py + dy + h)
            outside = box[0] < bounds[0] or box[1] < bounds[1] or box[2] > bounds[2] or box[3] > bounds[3]
            marks = [r for r in runs if r is not run and overlaps(box, boxes_of(r))]
            cost = (1000 * outside + 100 * sum(overlaps(box, other) for other in placed) +
                    10 * sum(overlaps(box, line) for line in lines) + sum(20 if r.default else 1 for r in marks))
            if best is None or cost < best[0]:
                best = (cost, box)
        placed.append(best[1])
        texts.append(f'<text class="label c{run.colour}" x="{best[1][0]:.1f}" y="{best[1][1] + 11:.1f}">{text}</text>')
    return texts


def pieces(points, x, y, top, right):
    """The upright and level lines of a front, as boxes."""
    found = []
    for i, point in enumerate(points):
        px, py = x(point.time), y(point.error)
        found.append((px - 1, y(points[i - 1].error) if i else top, px + 1, py))
        found.append((px, py - 1, x(points[i + 1].time) if i + 1 < len(points) else right, py + 1))
    return found


def panel(rows, scene, measure, title, unit, left):
    runs = runs_of(rows, scene, measure)
    l, r, t, b = left + MARGIN["left"], left + WIDTH - MARGIN["right"], MARGIN["top"], HEIGHT - MARGIN["bottom"]
    x = Scale([v for run in runs for v in (run.lowest, run.highest)], l, r)
    y = Scale([run.error for run in runs], b, t)
    lines = [f'<text class="title" x="{left + 6}" y="24">{title}</text>',
             f'<text x="{left + 6}" y="46">error: {unit}</text>']
    for e in x.decades():
        lines.append(f'<path class="grid" d="M{x(10 ** e):.1f} {t}V{b}"/>'
                     f'<text x="{x(10 ** e):.1f}" y="{b + 17}" text-anchor="middle">{duration(e)}</text>')
    for e in y.decades():
        lines.append(f'<path class="grid" d="M{l} {y(10 ** e):.1f}H{r}"/>'
                     f'<text x="{l - 7}" y="{y(10 ** e) + 4:.1f}" text-anchor="end">{power_of_ten(e)}</text>')
    lines.append(f'<rect class="frame" x="{l}" y="{t}" width="{r - l}" height="{b - t}"/>')
    fronts = [front([run for run in runs if (run.engine == "Atoll") == own]) for own in (False, True)]
    for run in runs:
        lines.append(f'<path class="spread s{run.colour}" d="M{x(run.lowest):.1f} {y(run.error):.1f}'
                     f'H{x(run.highest):.1f}"/>')
    for points, kind in zip(fronts, ("others", "s0")):
        lines.append(f'<path class="front {kind}" d="{staircase(points, x, y, t, r)}"/>')
    for run in sorted(runs, key=lambda run: (run.default, -run.colour)):
        ring = f'<circle class="ring s{run.colour}" r="11"/>' if run.default else ""
        lines.append(f'<g transform="translate({x(run.time):.1f} {y(run.error):.1f})">'
                     f'<title>{ENGINES[run.engine]}: {run.label}</title>'
                     f'{marker(run.colour, 6.5 if run.default else 4.2)}{ring}</g>')
    covered = [box for points in fronts for box in pieces(points, x, y, t, r)]
    lines += labels(runs, covered, x, y, (l + 2, t, r - 2, b))
    lines.append(f'<text class="axis" x="{(l + r) / 2}" y="{b + 38}" text-anchor="middle">'
                 'CPU time per simulated second</text>')
    return lines


def legend():
    lines, x, y = [], 20, HEIGHT - 12
    for colour, name in enumerate(ENGINES.values()):
        lines.append(f'<g transform="translate({x} {y - 4})">{marker(colour, 5)}</g>'
                     f'<text x="{x + 11}" y="{y}">{name}</text>')
        x += 34 + 7 * len(name)
    for kind, name in (("s0", "front of Atoll"), ("others", "front of the others")):
        lines.append(f'<path class="front {kind}" d="M{x:.0f} {y - 4}h24"/>'
                     f'<text x="{x + 31:.0f}" y="{y}">{name}</text>')
        x += 52 + 5.6 * len(name)
    lines.append(f'<text x="{x:.0f}" y="{y}">lower is more exact, further left is faster</text>')
    return lines


def drawing():
    with open(HERE / "results.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    width = WIDTH * len(PANELS)
    size = f'width="{width}" height="{HEIGHT}" viewBox="0 0 {width} {HEIGHT}"'
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">',
             "<title>Error against run time of Atoll and other engines</title>", f"<style>{STYLE}</style>",
             f'<rect class="page" width="{width}" height="{HEIGHT}" rx="6"/>']
    for i, (scene, measure, title, unit) in enumerate(PANELS):
        lines += panel(rows, scene, measure, title, unit, i * WIDTH)
    return "\n".join(lines + legend() + ["</svg>", ""])


def main():
    text = drawing()
    if sys.argv[1:] == ["--check"]:
        if not DRAWING.is_file() or DRAWING.read_text(encoding="utf-8") != text:
            sys.exit("perf/results/diagram.svg is not that of results.csv: run perf/results/diagram.py")
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        DRAWING.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
