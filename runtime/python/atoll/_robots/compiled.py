"""A model as MuJoCo compiled it, in the pose that a scene starts in."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from .. import _core
from .quaternions import Floats, inverse, product, turned
from .receipt import Receipt


class Compiled:
    """Arrays of a model, where its bodies are, and the receipt of what is read of it. The arrays are its own: what the
    model's flags switch off is taken out of them."""

    def __init__(self, mujoco: Any, arrays: Any, pose: str | int | None, receipt: Receipt | None = None) -> None:
        self.mujoco, self.arrays = mujoco, arrays
        self._switch_off()
        self.data = mujoco.MjData(arrays)
        self._take_pose(pose)
        mujoco.mj_kinematics(arrays, self.data)
        mujoco.mj_comPos(arrays, self.data)
        self.receipt = receipt or Receipt(arrays.names[: arrays.names.index(b"\0")].decode() or "model")

    def is_off(self, *flags: str) -> bool:
        """Whether the model disables any of these, as "CONTACT"."""
        return any(self.arrays.opt.disableflags & getattr(self.mujoco.mjtDisableBit, f"mjDSBL_{f}") for f in flags)

    def _switch_off(self) -> None:
        m = self.arrays
        if self.is_off("GRAVITY"):
            m.opt.gravity[:] = 0
        if self.is_off("CONTACT", "CONSTRAINT"):
            m.geom_contype[:] = m.geom_conaffinity[:] = 0
        if self.is_off("LIMIT", "CONSTRAINT"):
            m.jnt_limited[:] = m.tendon_limited[:] = 0
        if self.is_off("FRICTIONLOSS", "CONSTRAINT"):
            m.dof_frictionloss[:] = m.tendon_frictionloss[:] = 0
        if self.is_off("EQUALITY", "CONSTRAINT"):
            m.eq_active0[:] = 0
        if self.is_off("SPRING"):
            m.jnt_stiffness[:] = m.tendon_stiffness[:] = 0
        if self.is_off("DAMPER"):
            m.dof_damping[:] = m.tendon_damping[:] = 0

    def _take_pose(self, pose: str | int | None) -> None:
        m = self.arrays
        self.data.qpos[:] = m.qpos0
        if pose is None:
            return
        number = self.mujoco.mj_name2id(m, self.mujoco.mjtObj.mjOBJ_KEY, pose) if isinstance(pose, str) else pose
        if not 0 <= number < m.nkey:
            names = [self.name("KEY", i) for i in range(m.nkey)]
            raise _core.Error(f"load_mjcf: pose is {pose!r}; expected one of the model's keyframes: {', '.join(names)}")
        self.data.qpos[:] = m.key_qpos[number]

    def name(self, kind: str, number: int) -> str:
        return self.mujoco.mj_id2name(self.arrays, getattr(self.mujoco.mjtObj, f"mjOBJ_{kind}"), number) or str(number)

    def in_root(self, body: int) -> tuple[Floats, Floats]:
        """Where a body is in the one that it is welded to, m, and how it is turned there."""
        root = int(self.arrays.body_weldid[body])
        back = inverse(xyzw(self.data.xquat[root]))
        offset = turned(back, np.array(self.data.xpos[body]) - np.array(self.data.xpos[root]))
        return offset, product(back, xyzw(self.data.xquat[body]))


def compiler() -> Any:
    try:
        return importlib.import_module("mujoco")
    except ImportError:
        raise _core.Error(
            "load_mjcf: there is no module mujoco; expected MuJoCo's compiler: pip install atoll[robots]"
        ) from None


def xyzw(wxyz: Any) -> Floats:
    return np.roll(np.asarray(wxyz, dtype=np.float64), -1)
