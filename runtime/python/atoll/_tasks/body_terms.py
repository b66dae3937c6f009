"""MuJoCo's quantities of bodies, from where these are: about the robot's centre of mass, in the axes of the world."""

from __future__ import annotations

import numpy as np

from .. import _core
from .._robots.compiled import Compiled
from .._robots.quaternions import Floats, cross, matrices
from .._robots.robot import Robot
from .coordinates import Motion
from .robot_scene import geoms_of


class BodyTerms:
    """Of a model's own bodies, those that are welded to others included, but for the world. All bodies are one robot."""

    def __init__(self, robot: Robot, model: Compiled, batch_bodies: int) -> None:
        m, data = model.arrays, model.data
        bodies = range(1, m.nbody)
        self.roots = [int(m.body_weldid[body]) for body in bodies]
        self.places = [robot.bodies[model.name("BODY", body)] for body in bodies]
        self.masses = np.array(m.body_mass[1:])
        frames = np.array(data.xmat)[self.roots].reshape(-1, 3, 3)
        offsets = np.array(data.xipos)[1:] - np.array(data.xpos)[self.roots]
        self.centres = np.einsum("bji,bj->bi", frames, offsets)  # m, in the body of the scene
        axes = np.einsum("bji,bjk->bik", frames, np.array(data.ximat)[1:].reshape(-1, 3, 3))
        self.inertias = np.einsum("bij,bj,bkj->bik", axes, np.array(m.body_inertia)[1:], axes)
        self.owners = self._owners(model, batch_bodies)

    def _owners(self, model: Compiled, count: int) -> Floats:
        """Columns of the model's bodies by the place of a body in the scene and its child; -1 for what stands still."""
        m = model.arrays
        owners = np.full((count, m.ngeom), -1)
        for root in set(self.roots):
            geoms = geoms_of(model, root)
            owners[self.places[root - 1], : len(geoms)] = m.geom_bodyid[geoms] - 1
        return owners

    def _turned(self, motion: Motion) -> tuple[Floats, Floats]:
        """Centres of mass, m, and how the bodies are turned, as matrices."""
        turns = matrices(motion.orientations[:, self.places])
        return motion.origins[:, self.places] + np.einsum("wbij,bj->wbi", turns, self.centres), turns

    def centre(self, motion: Motion) -> Floats:
        """m, of the robot's mass, shape (worlds, 3)."""
        centres, _ = self._turned(motion)
        return np.asarray(np.einsum("b,wbi->wi", self.masses / self.masses.sum(), centres))

    def inertia(self, motion: Motion) -> Floats:
        """cinert, shape (worlds, bodies, 10): xx, yy, zz, xy, xz, yz (kg m^2), mass times the arm (kg m), mass."""
        centres, turns = self._turned(motion)
        arms = centres - self.centre(motion)[:, None]
        about = np.einsum("wbij,bjk,wblk->wbil", turns, self.inertias, turns)
        squares = np.einsum("wbi,wbi->wb", arms, arms)[..., None, None] * np.eye(3)
        about += self.masses[:, None, None] * (squares - arms[..., :, None] * arms[..., None, :])
        moments = about[..., [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        masses = np.broadcast_to(self.masses[:, None], (*moments.shape[:2], 1))
        return np.concatenate([moments, masses * arms, masses], axis=-1)

    def velocity(self, motion: Motion) -> Floats:
        """cvel, shape (worlds, bodies, 6): rad/s, and m/s of a point of the body that is where the robot's centre is."""
        angular = motion.angular[:, self.places]
        arms = self.centre(motion)[:, None] - motion.origins[:, self.places]
        return np.concatenate([angular, motion.velocities[:, self.places] + cross(angular, arms)], axis=-1)

    def contact(self, batch: _core.Batch, motion: Motion) -> Floats:
        """cfrc_ext, shape (worlds, bodies, 6): N m and N, of contacts at the end of the last step."""
        total = np.zeros((len(batch), len(self.places), 6))
        forces = batch.contact_points()
        worlds = forces["world"]
        if worlds.size == 0:
            return total
        on_b = forces["normal"] * forces["normal_force"][:, None] + forces["friction"]
        arms = forces["position"] - self.centre(motion)[worlds]
        for side, sign in (("a", -1), ("b", 1)):
            owners = self.owners[forces[side]["index"], forces[f"child_{side}"]]
            wrench = sign * np.concatenate([cross(arms, on_b), on_b], axis=-1)
            np.add.at(total, (worlds[owners >= 0], owners[owners >= 0]), wrench[owners >= 0])
        return total
