"""Files of meshes that a URDF names, in a form that MuJoCo's compiler reads."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

_READ_BY_MUJOCO = (".stl", ".obj")

Packages = Mapping[str, str | Path] | Sequence[str | Path]


class Unreadable(Exception):
    """Says why a mesh isn't read."""


class MeshFiles:
    """Finds the files that URIs name, and reads each once.

    `package://NAME/rest` is looked for in the packages given, and in the folders above the URDF: one of the name, or one
    that has a folder of the name.
    """

    def __init__(self, folder: Path, packages: Packages) -> None:
        self._folder = folder
        self._named = {k: Path(v) for k, v in packages.items()} if isinstance(packages, Mapping) else {}
        self._roots = [] if isinstance(packages, Mapping) else [Path(p) for p in packages]
        self.assets: dict[str, bytes] = {}  #: contents by the names that read() gives
        self._names: dict[tuple[Path, str], str] = {}

    def read(self, uri: str, scale: str) -> str:
        """The name of the asset that a mesh is, one for each scale of a file. Raises Unreadable."""
        path = self._find(uri)
        name = self._names.get((path, scale))
        if name is None:
            content, suffix = _content(path)
            name = f"{path.stem}_{len(self._names)}{suffix}"
            self.assets[name] = content
            self._names[path, scale] = name
        return name

    def _find(self, uri: str) -> Path:
        if uri.startswith("package://"):
            package, _, rest = uri[len("package://") :].lstrip("/").partition("/")
            candidates = [folder / rest for folder in self._folders(package)]
        else:
            candidates = [self._folder / uri.removeprefix("file://")]
        for candidate in candidates:
            if candidate.is_file():
                return candidate.resolve()
        raise Unreadable(f"there is no file {uri}")

    def _folders(self, package: str) -> list[Path]:
        folders = [self._named[package]] if package in self._named else []
        for root in [*self._roots, self._folder, *self._folder.parents]:
            folders += [root] if root.name == package else []
            folders += [root / package]
        return folders


def _content(path: Path) -> tuple[bytes, str]:
    suffix = path.suffix.lower()
    if suffix == ".dae":
        return _stl(_collada_triangles(path)), ".stl"
    if suffix not in _READ_BY_MUJOCO:
        raise Unreadable(f"{path.name} is not of .stl, .obj or .dae")
    content = path.read_bytes()
    if (
        suffix == ".stl"
        and content[:5] == b"solid"
        and len(content) != 84 + 50 * int.from_bytes(content[80:84], "little")
    ):
        return _stl(_text_triangles(path, content)), suffix  # MuJoCo reads binary files only
    return content, suffix


def _collada_triangles(path: Path) -> np.ndarray:
    """m, shape (triangles, 3, 3), as ROS shows such files: in their unit, with the transforms of their nodes, whatever
    axis is up."""
    try:
        collada = importlib.import_module("collada")
    except ImportError:
        raise Unreadable(f"{path.name} takes the module collada: pip install atoll[robots]") from None
    try:
        document = collada.Collada(str(path), ignore=[collada.DaeError])
        triangles = []
        for geometry in document.scene.objects("geometry") if document.scene is not None else ():
            for primitive in geometry.primitives():
                if hasattr(primitive, "triangleset"):
                    primitive = primitive.triangleset()
                corners = primitive.vertex[primitive.vertex_index]
                if corners.ndim == 3 and corners.shape[1:] == (3, 3):
                    triangles.append(corners)
    except (collada.DaeError, OSError, ValueError) as error:
        raise Unreadable(f"{path.name} is broken: {error}") from None
    if not triangles:
        raise Unreadable(f"{path.name} has no triangles")
    return np.concatenate(triangles).astype(np.float64) * float(document.assetInfo.unitmeter or 1)


def _text_triangles(path: Path, content: bytes) -> np.ndarray:
    words = content.split()
    corners = [words[place + 1 : place + 4] for place, word in enumerate(words) if word == b"vertex"]
    try:
        return np.array(corners, dtype=np.float64).reshape(-1, 3, 3)
    except ValueError:
        raise Unreadable(f"{path.name} is broken") from None


def _stl(triangles: np.ndarray) -> bytes:
    """A binary file of triangles, shape (n, 3, 3)."""
    record = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["corners"] = triangles
    return bytes(80) + len(triangles).to_bytes(4, "little") + record.tobytes()
