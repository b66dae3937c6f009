"""Images of worlds as arrays, without a display or a browser: `pip install atoll[render]`, and EGL, as Mesa has it.

    from atoll.render import Camera, Renderer

    renderer = Renderer(world, width=640, height=480)
    picture = renderer.render(Camera(position=[4, -6, 3], target=[0, 0, 1]))
    picture.colour, picture.depth, picture.body

Pixels depend on the graphics driver, and so may differ between machines; what the world does depends on none of it.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

BACKGROUND = (235, 238, 242)  #: sRGB, of pixels in which nothing is

_VERTEX = """
#version 330
uniform mat4 seen, placed;
in vec3 place;
out vec3 world;
void main() { world = (placed * vec4(place, 1)).xyz; gl_Position = seen * vec4(world, 1); }
"""
# Normals are those of triangles. Light comes from the sky and, more of it, from over the camera's shoulder.
_FRAGMENT = """
#version 330
uniform vec3 colour, light, eye, forward;
uniform int body;
in vec3 world;
layout(location = 0) out vec4 shown;
layout(location = 1) out vec2 found;
void main() {
    vec3 normal = normalize(cross(dFdx(world), dFdy(world)));
    float lit = 0.45 + 0.1 * normal.z + 0.45 * max(dot(normal, light), 0);
    shown = vec4(pow(lit, 0.6) * colour, 1);
    found = vec2(dot(world - eye, forward), float(body));
}
"""


@dataclass
class Camera:
    """The place that a picture is taken from. Lengths in m, angles in rad."""

    position: ArrayLike
    target: ArrayLike  #: what is in the middle of the picture
    up: ArrayLike = (0, 0, 1)  #: not along the line of sight
    field_of_view: float = 0.8  #: of the height, in (0, pi)
    near: float = 0.02  #: > 0: nothing nearer is seen
    far: float = 1000.0

    @classmethod
    def around(cls, world: _core.World) -> Camera:
        """From the south and above, so far away that all dynamic bodies are in the picture."""
        moving = [b for b in world.bodies if world.definition(b).type == _core.BodyType.DYNAMIC and world.is_enabled(b)]
        boxes = np.array([world.bounds(body) for body in moving])
        lower = boxes[:, 0].min(axis=0) if moving else -np.ones(3)
        upper = boxes[:, 1].max(axis=0) if moving else np.ones(3)
        target, radius = (lower + upper) / 2, max(float(np.linalg.norm(upper - lower)) / 2, 0.1)
        away = np.array([0.4, -1.0, 0.5]) / math.sqrt(1.41)
        return cls(target + away * radius / math.sin(0.4), target, far=1000 + 4 * radius)

    def axes(self) -> NDArray[np.float64]:
        """Rows: right, up, forward, world frame. Raises Error where they are not determined."""
        forward = np.asarray(self.target, float) - np.asarray(self.position, float)
        right = np.cross(forward, np.asarray(self.up, float))
        if not (np.isfinite(right).all() and right.any()):
            raise _core.Error("Camera: target is at the position, or up along the line of sight; expected neither")
        if not (0 < self.field_of_view < math.pi and 0 < self.near < self.far):
            raise _core.Error(
                f"Camera: found field_of_view {self.field_of_view}, near {self.near}, far {self.far}; "
                "expected an angle in (0, pi) rad, and 0 < near < far, in m"
            )
        rows: NDArray[np.float64] = np.stack([right, np.cross(right, forward), forward])
        rows /= np.linalg.norm(rows, axis=1)[:, None]
        return rows

    def matrix(self, aspect: float) -> NDArray[np.float64]:
        """From the world to clip space, for a picture `aspect` times as wide as high."""
        axes = self.axes() * np.array([[1], [1], [-1]])
        view = np.eye(4)
        view[:3] = np.column_stack([axes, -axes @ np.asarray(self.position, float)])
        scale, depth = 1 / math.tan(self.field_of_view / 2), self.far - self.near
        project = np.diag([scale / aspect, scale, -(self.far + self.near) / depth, 0.0])
        project[2, 3], project[3, 2] = -2 * self.far * self.near / depth, -1
        return project @ view


class Picture(NamedTuple):
    """Rows from the top of a picture on."""

    colour: NDArray[np.uint8]  #: sRGB, shape (height, width, 3)
    depth: NDArray[np.float32]  #: m, along the line of sight; infinite where nothing is
    body: NDArray[np.int32]  #: index of the body that is seen; -1 where none is


def _key(shape: Any) -> Hashable:
    """Equal for shapes that look the same."""
    if isinstance(shape, _core.Compound):
        return tuple((_key(c.shape), c.position.tobytes(), c.orientation.tobytes()) for c in shape.children)
    is_shared = isinstance(shape, _core.ConvexHull | _core.TriangleMesh | _core.HeightField)
    return shape if is_shared else repr(shape)


class Renderer:
    """Takes pictures of a world as it is, bodies and shapes that come or change later included.

    For one thread at a time. Raises Error where there is no OpenGL 3.3 to draw with.
    """

    def __init__(self, world: _core.World, width: int = 640, height: int = 480) -> None:
        if not (1 <= width <= 8192 and 1 <= height <= 8192):
            raise _core.Error(f"Renderer: found {width} x {height} pixels; expected each in [1, 8192]")
        self.world, self.width, self.height = world, width, height
        try:
            backend: dict[str, Any] = {"backend": "egl"} if sys.platform == "linux" else {}
            self._context = moderngl.create_context(standalone=True, require=330, **backend)
        except Exception as error:
            raise _core.Error(f"Renderer: found no OpenGL 3.3 ({error}); expected EGL, as of Debian's libegl1") from error
        self._program = self._context.program(vertex_shader=_VERTEX, fragment_shader=_FRAGMENT)
        size = (width, height)
        self._colour, self._found = self._context.texture(size, 4), self._context.texture(size, 2, dtype="f4")
        self._frame = self._context.framebuffer(
            [self._colour, self._found], self._context.depth_renderbuffer(size)
        )
        self._drawn: dict[Hashable, moderngl.VertexArray] = {}

    def render(self, camera: Camera | None = None) -> Picture:
        """Shows all bodies that are enabled. Without a camera, as Camera.around() has it."""
        camera = Camera.around(self.world) if camera is None else camera
        right, up, forward = camera.axes()
        light = right - forward + 2 * up
        self._frame.use()
        self._frame.clear()
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._set("seen", camera.matrix(self.width / self.height).T)
        self._set("light", light / np.linalg.norm(light))
        self._set("eye", np.asarray(camera.position, float))
        self._set("forward", forward)
        used: dict[Hashable, moderngl.VertexArray] = {}
        for body in self.world.bodies:
            if self.world.is_enabled(body):
                self._draw(body, used)
        for key in self._drawn.keys() - used.keys():
            self._drawn[key].release()
        self._drawn = used
        shape = (self.height, self.width)
        colour = np.frombuffer(self._colour.read(), np.uint8).reshape(*shape, 4)[::-1, :, :3].copy()
        found = np.frombuffer(self._found.read(), np.float32).reshape(*shape, 2)[::-1]
        nothing = found[:, :, 0] == 0
        colour[nothing] = BACKGROUND
        depth = np.where(nothing, np.float32(np.inf), found[:, :, 0])
        return Picture(colour, depth, np.where(nothing, -1, found[:, :, 1]).astype(np.int32))

    def _set(self, name: str, numbers: NDArray[np.float64]) -> None:
        self._program[name].write(np.ascontiguousarray(numbers, np.float32).tobytes())  # type: ignore[union-attr]

    def _draw(self, body: _core.BodyId, used: dict[Hashable, moderngl.VertexArray]) -> None:
        definition = self.world.definition(body)
        key = _key(definition.shape)
        drawn = used.get(key) or self._drawn.get(key)
        if drawn is None:
            vertices, triangles = _core.triangles_of(definition.shape)
            corners = self._context.buffer(vertices[triangles].astype(np.float32).tobytes())
            drawn = self._context.vertex_array(self._program, [(corners, "3f", "place")])
        used[key] = drawn
        x, y, z, w = definition.orientation
        placed = np.eye(4)
        placed[:3, 3] = definition.position
        placed[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        self._set("placed", placed.T)
        self._set("colour", np.asarray(_core.colour_of(body.index, definition.type != _core.BodyType.STATIC)))
        self._program["body"].value = body.index  # type: ignore[union-attr]
        drawn.render(moderngl.TRIANGLES)
