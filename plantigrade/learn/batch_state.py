"""State of parallel worlds, one row per world."""

from collections.abc import Sequence

import mujoco
import numpy as np

from plantigrade.learn.reference import headings, limb_ends
from plantigrade.models import Human


class BatchState:
    """State of one person in parallel worlds.

    Args:
        of: MuJoCo's model and data of each world, in which the person's coordinates come first.

    Attributes:
        angles: Angles of the hinges, (n, hinges) [rad].
        rates: Rates of the hinges, (n, hinges) [rad/s].
        quat: Orientation of the pelvis, (n, 4).
        com: Centre of mass, (n, 3) [m].
        positions: Origins of the bodies, (n, bodies, 3) [m].
        velocities: Angular velocity and velocity of the bodies, at the centre of mass of the
            person, (n, bodies, 6) [rad/s, m/s].
        orientations: Orientation of the bodies, ``wxyz``, (n, bodies, 4).
        headings: Maps of row vectors from world axes to the heading of the pelvis, (n, 3, 3).
    """

    def __init__(self, human: Human, of: Sequence[tuple[mujoco.MjModel, mujoco.MjData]]):
        n = len(of)
        bodies, hinges = len(human.body_names), len(human.coordinates)
        own, limbs = slice(1, bodies + 1), np.array(limb_ends(human))
        self.angles, self.rates = np.zeros((n, hinges)), np.zeros((n, hinges))
        self.quat, self.com = np.zeros((n, 4)), np.zeros((n, 3))
        self.positions, self.velocities = np.zeros((n, bodies, 3)), np.zeros((n, bodies, 6))
        self.orientations, self._mass_centres = np.zeros((n, bodies, 4)), np.zeros((n, bodies, 3))
        self.headings, self._limbs = np.zeros((n, 3, 3)), limbs - 1
        # Views remain valid because MuJoCo does not reallocate; creating them takes longer than
        # reading.
        self._rows = []
        for i, (model, data) in enumerate(of):
            pairs = (
                (self.angles[i], data.qpos[7 : 7 + hinges]),
                (self.rates[i], data.qvel[6 : 6 + hinges]),
                (self.quat[i], data.qpos[3:7]),
                (self.com[i], data.subtree_com[1]),
                (self.positions[i], data.xpos[own]),
                (self.velocities[i], data.cvel[own]),
                (self.orientations[i], data.xquat[own]),
                (self._mass_centres[i], data.xipos[own]),
            )
            self._rows.append((model, data, pairs))

    @property
    def ends(self) -> np.ndarray:
        """Centres of mass of hands and feet, (n, 4, 3) [m]."""
        return self._mass_centres[:, self._limbs]

    def update(self, which: Sequence[int] | None = None) -> None:
        """Update some or all rows; kinematics is recomputed, because a step leaves it outdated."""
        for i in range(len(self._rows)) if which is None else which:
            model, data, pairs = self._rows[i]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            for to, source in pairs:
                to[...] = source
        self.headings = headings(self.quat)
