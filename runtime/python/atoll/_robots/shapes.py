"""Shapes of a compiled model."""

from __future__ import annotations

from typing import Union

import numpy as np

from .. import _core
from .compiled import Compiled, xyzw
from .decomposition import hulls_of
from .filters import Filters
from .quaternions import Floats, inverse, product, turned

_Solid = Union[_core.Box, _core.Sphere, _core.Capsule, _core.Cylinder, _core.Ellipsoid, _core.ConvexHull]
_Shape = Union[_Solid, _core.HalfSpace, _core.HeightField]


class Shapes:
    """Shapes of a model by the bodies that carry them."""

    def __init__(self, model: Compiled, filters: Filters, hull_error: float | None) -> None:
        self.model, self.filters, self.hull_error = model, filters, hull_error
        self.geoms: dict[int, list[int]] = {}  # that touch, of bodies that others are welded to
        self._sort_geoms()

    def _sort_geoms(self) -> None:
        m = self.model.arrays
        for geom in range(m.ngeom):
            name = self.model.name("GEOM", geom)
            if not self.filters.touches(geom):
                self.model.receipt.exact("geom that only shows", name)
                continue
            root = int(m.body_weldid[m.geom_bodyid[geom]])
            self.geoms.setdefault(root, []).append(geom)

    def _material(self, geom: int) -> _core.Material:
        slide, twist, roll = (float(x) for x in self.model.arrays.geom_friction[geom])
        condim = int(self.model.arrays.geom_condim[geom])
        return _core.Material(
            friction=slide if condim > 1 else 0,
            torsional_friction=twist if condim > 3 else 0,
            rolling_friction=roll if condim > 4 else 0,
        )

    def _shapes(self, geom: int) -> list[_Shape]:
        """None of a kind that there isn't here, several of a mesh that is taken apart. The receipt has a line."""
        if int(self.model.arrays.geom_type[geom]) == self.model.mujoco.mjtGeom.mjGEOM_MESH:
            return list(self._hulls(geom))
        shape = self._shape(geom)
        return [] if shape is None else [shape]

    def _hulls(self, geom: int) -> list[_core.ConvexHull]:
        m = self.model.arrays
        mesh = int(m.geom_dataid[geom])
        start, count = int(m.mesh_vertadr[mesh]), int(m.mesh_vertnum[mesh])
        first, faces = int(m.mesh_faceadr[mesh]), int(m.mesh_facenum[mesh])
        found = hulls_of(
            np.array(m.mesh_vert[start : start + count], dtype=np.float64),
            np.array(m.mesh_face[first : first + faces], dtype=np.int64),
            self.hull_error,
        )
        self.model.receipt.taken_as("geom", self.model.name("GEOM", geom), found.note)
        return found.hulls

    def _shape(self, geom: int) -> _Shape | None:
        kinds, m = self.model.mujoco.mjtGeom, self.model.arrays
        kind, size, name = int(m.geom_type[geom]), [float(x) for x in m.geom_size[geom]], self.model.name("GEOM", geom)
        shape: _Shape | None = None
        note = ""
        if kind == kinds.mjGEOM_SPHERE:
            shape = _core.Sphere(size[0])
        elif kind == kinds.mjGEOM_CAPSULE:
            shape = _core.Capsule(size[0], size[1])
        elif kind == kinds.mjGEOM_CYLINDER:
            shape = _core.Cylinder(size[0], size[1])
        elif kind == kinds.mjGEOM_BOX:
            shape = _core.Box(size)
        elif kind == kinds.mjGEOM_PLANE:
            shape = _core.HalfSpace([0, 0, 1], 0)
            if size[0] > 0 or size[1] > 0:
                note = "a plane without end, as MuJoCo collides with it"
        elif kind == kinds.mjGEOM_ELLIPSOID:
            shape = _core.Ellipsoid(size)
        elif kind == kinds.mjGEOM_HFIELD:
            field = int(m.geom_dataid[geom])
            rows, columns = int(m.hfield_nrow[field]), int(m.hfield_ncol[field])
            start = int(m.hfield_adr[field])
            heights = np.array(m.hfield_data[start : start + rows * columns], dtype=np.float64).reshape(rows, columns)
            x, y, z, _ = (float(v) for v in m.hfield_size[field])
            shape = _core.HeightField(heights * z, 2 * x / (columns - 1), 2 * y / (rows - 1))
        if shape is None:
            self.model.receipt.left_out("geom", name, "a signed distance field")
        elif note:
            self.model.receipt.taken_as("geom", name, note)
        else:
            self.model.receipt.exact("geom", name)
        return shape

    def _place(self, geom: int) -> tuple[Floats, Floats]:
        """In the world."""
        quaternion = np.zeros(4)
        self.model.mujoco.mju_mat2Quat(quaternion, self.model.data.geom_xmat[geom])
        turn = xyzw(quaternion)
        position = np.array(self.model.data.geom_xpos[geom])
        if int(self.model.arrays.geom_type[geom]) == self.model.mujoco.mjtGeom.mjGEOM_HFIELD:
            x, y = self.model.arrays.hfield_size[int(self.model.arrays.geom_dataid[geom])][:2]
            position = position - turned(turn, [x, y, 0])  # its frame is in the corner here
        return position, turn

    def fixed(self) -> list[_core.SceneBody]:
        """Static bodies, one for each shape that doesn't move."""
        bodies = []
        for geom in self.geoms.get(0, []):
            position, turn = self._place(geom)
            for shape in self._shapes(geom):
                definition = _core.BodyDef(
                    type=_core.BodyType.STATIC,
                    shape=shape,
                    position=position,
                    orientation=turn,
                    material=self._material(geom),
                    filter=self.filters.of(geom),
                )
                bodies.append(_core.SceneBody(definition=definition))
        return bodies

    def children(self, body: int) -> list[_core.CompoundChild]:
        """Of a body that moves, in its frame."""
        origin, frame = np.array(self.model.data.xpos[body]), xyzw(self.model.data.xquat[body])
        children = []
        for geom in self.geoms.get(body, []):
            position, turn = self._place(geom)
            for shape in self._shapes(geom):
                if isinstance(shape, (_core.HalfSpace, _core.HeightField)):
                    self.model.receipt.left_out("geom", self.model.name("GEOM", geom), "a surface on a body that moves")
                    continue
                child = _core.CompoundChild(
                    shape=shape,
                    position=turned(inverse(frame), position - origin),
                    orientation=product(inverse(frame), turn),
                    material=self._material(geom),
                    filter=self.filters.of(geom),
                )
                children.append(child)
        return children
