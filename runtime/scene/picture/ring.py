#!/usr/bin/env python3
"""Draws a ring of bricks that a ball breaks through, as `atoll run` simulates it, to ring.svg beside this file.

usage: ring.py [ATOLL] [OUT]   ATOLL is the command, by default build/lib/bin/atoll or build/release/bin/atoll
"""

import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]

# The scene: courses of bricks in a ring, each course turned by half a brick, and a heavy ball thrown at them.
RADIUS, BRICKS, COURSES = 3.4, 30, 9
BRICK = (0.5 * 0.96 * 2 * math.pi * (RADIUS - 0.2) / BRICKS, 0.2, 0.19)  # half extents: along the ring, across, up; m
BALL = 0.7  # radius, m
THROWN_FROM, THROWN_AT = (-10, 4.2, 1.6), (20, -8.4, 2.4)  # m, m/s
STEPS = 51

# The camera, and the drawing in its plane.
EYE, TARGET, FOCAL = (7.5, -13.5, 8.0), (1.15, -0.9, 1.45), 940
WIDTH, HEIGHT = 960, 540
LIGHT = (-0.12, -0.62, 0.78)
SAND = ((252, 218, 172), (240, 198, 148), (255, 230, 192), (232, 188, 136))
CORAL = (226, 88, 70)
STYLE = """
  .ground { stop-color: #dfe6ee } .shadow { fill: #1b2733; opacity: .26 }
  .solid path { stroke: #4a3018; stroke-opacity: .55; stroke-width: .6; stroke-linejoin: round }
  @media (prefers-color-scheme: dark) { .ground { stop-color: #26323f } .shadow { fill: #000; opacity: .5 } }
"""


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def scaled(a, s):
    return tuple(x * s for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return scaled(a, 1 / math.sqrt(dot(a, a)))


def scene():
    bodies = [{"name": "ground", "type": "static", "shape": {"type": "half_space"}}]
    for course in range(COURSES):
        for brick in range(BRICKS):
            angle = 2 * math.pi * (brick + 0.5 * (course % 2)) / BRICKS
            place = [RADIUS * math.cos(angle), RADIUS * math.sin(angle), BRICK[2] * (2 * course + 1)]
            half = angle / 2 + math.pi / 4
            bodies.append({"shape": {"type": "box", "half_extents": BRICK}, "density": 1500, "position": place,
                           "orientation": [0, 0, math.sin(half), math.cos(half)]})
    bodies.append({"shape": {"type": "sphere", "radius": BALL}, "density": 6000, "position": THROWN_FROM,
                   "velocity": THROWN_AT})
    return {"format": "atoll-scene", "version": 1, "name": "ring", "bodies": bodies}


def final_states(atoll):
    """(position, axes) of every body but the ground."""
    with tempfile.TemporaryDirectory() as directory:
        file, states = pathlib.Path(directory, "ring.json"), pathlib.Path(directory, "states.csv")
        file.write_text(json.dumps(scene()), encoding="utf-8")
        subprocess.run([atoll, "run", file, "--steps", str(STEPS), "--final-state", states], check=True,
                       stdout=subprocess.DEVNULL)
        with open(states, encoding="utf-8") as rows:
            bodies = [{key: float(row[key]) for key in row if key != "name"} for row in csv.DictReader(rows)]
    found = []
    for b in bodies[1:]:
        x, y, z, w = b["qx"], b["qy"], b["qz"], b["qw"]
        axes = ((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
                (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
                (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)))
        found.append(((b["px"], b["py"], b["pz"]), axes))
    return found


AHEAD = unit(sub(TARGET, EYE))
RIGHT = unit(cross(AHEAD, (0, 0, 1)))
UP = cross(RIGHT, AHEAD)


def seen(point):
    away = sub(point, EYE)
    depth = dot(away, AHEAD)
    return (WIDTH / 2 + FOCAL * dot(away, RIGHT) / depth, HEIGHT / 2 - FOCAL * dot(away, UP) / depth)


class Brick:
    """A box: its corners, and which it shows of its faces."""

    def __init__(self, position, axes, colour):
        self.position, self.axes, self.colour = position, axes, colour
        self.corners = [add(position, add(add(scaled(axes[0], x * BRICK[0]), scaled(axes[1], y * BRICK[1])),
                                          scaled(axes[2], z * BRICK[2])))
                        for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        self.outline = [seen(corner) for corner in self.corners]

    def span(self, axis):
        reach = sum(half * abs(dot(axis, own)) for half, own in zip(BRICK, self.axes))
        middle = dot(axis, self.position)
        return middle - reach, middle + reach

    def faces(self):
        for i, axis in enumerate(self.axes):
            for side in (-1, 1):
                normal = scaled(axis, side)
                middle = add(self.position, scaled(normal, BRICK[i]))
                if dot(normal, sub(EYE, middle)) <= 0:
                    continue
                u, v = (scaled(self.axes[j % 3], BRICK[j % 3]) for j in (i + 1, i + 2))
                yield normal, [add(middle, add(scaled(u, a), scaled(v, b)))
                               for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]

    def drawing(self):
        for normal, corners in self.faces():
            yield f'<path d="{path([seen(c) for c in corners])}" fill="{shade(self.colour, normal)}"/>'


class Ball:
    def __init__(self, position):
        self.position, self.axes = position, ()
        self.middle, self.radius = seen(position), FOCAL * BALL / dot(sub(position, EYE), AHEAD)
        self.outline = [add(self.middle, (x * self.radius, y * self.radius)) for x in (-1, 1) for y in (-1, 1)]
        # For its shadow.
        self.corners = [add(position, (r * BALL * x, r * BALL * y, z * BALL))
                        for x, y in circle(24) for r, z in ((1, 0), (0.7, 0.7), (0.7, -0.7))]

    def span(self, axis):
        middle = dot(axis, self.position)
        return middle - BALL, middle + BALL

    def drawing(self):
        (x, y), r = self.middle, self.radius
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" fill="url(#ball)"/>'


def shade(colour, normal):
    bright = 0.56 + 0.48 * max(0, dot(normal, unit(LIGHT))) + 0.08 * normal[2]
    return "#" + "".join(f"{min(255, round(c * bright)):02x}" for c in colour)


def circle(count):
    return [(math.cos(2 * math.pi * i / count), math.sin(2 * math.pi * i / count)) for i in range(count)]


def path(points):
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + "Z"


def in_front(a, b):
    """Whether a may hide b: it lies on the eye's side of a plane between the two, of all such the widest gap's."""
    between = unit(sub(b.position, a.position))
    axes = [*a.axes, *b.axes, between]
    for u in a.axes:
        for v in b.axes:
            normal = cross(u, v)
            if dot(normal, normal) > 1e-6:
                axes.append(unit(normal))
    widest, side = -math.inf, False
    for axis in axes:
        (low_a, high_a), (low_b, high_b), eye = a.span(axis), b.span(axis), dot(axis, EYE)
        for gap, plane, above in ((low_a - high_b, (low_a + high_b) / 2, True),
                                  (low_b - high_a, (low_b + high_a) / 2, False)):
            if gap > widest:
                widest, side = gap, (eye > plane) == above
    return side


def back_to_front(solids):
    """An order in which each solid comes after those that it may hide."""
    bounds = [(min(x for x, _ in s.outline), max(x for x, _ in s.outline), min(y for _, y in s.outline),
               max(y for _, y in s.outline)) for s in solids]
    behind = [[] for _ in solids]
    for i, a in enumerate(bounds):
        for j in range(i):
            b = bounds[j]
            if a[0] < b[1] and b[0] < a[1] and a[2] < b[3] and b[2] < a[3]:
                front, back = (i, j) if in_front(solids[i], solids[j]) else (j, i)
                behind[front].append(back)
    order, state = [], [0] * len(solids)

    def visit(i):
        # Solids that hide each other in a ring have no right order: the farthest is drawn first.
        state[i] = 1
        for j in sorted(behind[i], key=distance, reverse=True):
            if state[j] == 0:
                visit(j)
        order.append(i)

    def distance(i):
        away = sub(solids[i].position, EYE)
        return dot(away, away)

    for i in sorted(range(len(solids)), key=distance, reverse=True):
        if state[i] == 0:
            visit(i)
    return [solids[i] for i in order]


def hull(points):
    points = sorted(set(points))
    half = []
    for sequence in (points, points[::-1]):
        chain = []
        for p in sequence:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1]) -
                                      (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])) <= 0:
                chain.pop()
            chain.append(p)
        half += chain[:-1]
    return half


def shadow(solids):
    """What the light doesn't reach of the ground: one area, as all outlines run the same way."""
    d = ""
    for s in solids:
        ground = [sub(c, scaled(LIGHT, c[2] / LIGHT[2])) for c in s.corners]
        d += path(hull([seen((x, y, 0)) for x, y, _ in ground]))
    return f'<path class="shadow" d="{d}"/>'


def ground():
    """A round floor with a fading edge."""
    edge = path([seen((0.9 + 7.2 * x, -0.9 + 7.2 * y, 0)) for x, y in circle(72)])
    return f'<path fill="url(#ground)" d="{edge}"/>'


def picture(states):
    solids = [Brick(*state, SAND[(7 * i + i // BRICKS) % len(SAND)]) for i, state in enumerate(states[:-1])]
    solids.append(Ball(states[-1][0]))
    dark, plain, bright = (tuple(round(c * f) for c in CORAL) for f in (0.45, 0.95, 1.25))
    colour = lambda c: "#" + "".join(f"{min(255, x):02x}" for x in c)
    size = f'width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}"'
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">',
             "<title>A ring of bricks that a ball breaks through</title>",
             f"<style>{STYLE}</style>",
             '<defs><radialGradient id="ground" r=".5"><stop class="ground" offset=".7"/>',
             '<stop class="ground" offset="1" stop-opacity="0"/></radialGradient>',
             f'<radialGradient id="ball" cx=".58" cy=".28" r=".8"><stop offset="0" stop-color="{colour(bright)}"/>',
             f'<stop offset=".45" stop-color="{colour(plain)}"/><stop offset="1" stop-color="{colour(dark)}"/>',
             '</radialGradient></defs>', ground(), shadow(solids), '<g class="solid">']
    for solid in back_to_front(solids):
        lines += solid.drawing()
    return "\n".join(lines + ["</g>", "</svg>", ""])


def main():
    built = [ROOT / f"build/{preset}/bin/atoll" for preset in ("lib", "release")]
    atoll = sys.argv[1] if len(sys.argv) > 1 else next((path for path in built if path.is_file()), built[0])
    out = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else HERE / "ring.svg"
    out.write_text(picture(final_states(atoll)), encoding="utf-8")


if __name__ == "__main__":
    main()
