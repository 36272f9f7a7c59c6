"""State read from worlds after a step: one row per world, updated together."""

from collections.abc import Sequence

import mujoco
import numpy as np

from plantigrade.learn.reference import headings, limb_ends
from plantigrade.models import Human


class View:
    """The state of persons in worlds, all the same person.

    Args:
        human: The person.
        of: MuJoCo's model and data of each, whose first coordinates are the person's.

    Attributes:
        angles: Of the hinges, (n, hinges) [rad].
        rates: Likewise [rad/s].
        quat: Orientation of the pelvis, (n, 4).
        com: Centre of mass, (n, 3) [m].
        place: Origins of the bodies, (n, bodies, 3) [m].
        motion: Angular velocity and velocity of the bodies, at the centre of mass of the person,
            (n, bodies, 6) [rad/s, m/s].
        turned: Orientation of the bodies, ``wxyz``, (n, bodies, 4).
        turn: Maps rows of world axes to the heading of the pelvis, (n, 3, 3).
    """

    def __init__(self, human: Human, of: Sequence[tuple[mujoco.MjModel, mujoco.MjData]]):
        n = len(of)
        bodies, hinges = len(human.body_names), len(human.coordinates)
        own, limbs = slice(1, bodies + 1), np.array(limb_ends(human))
        self.angles, self.rates = np.zeros((n, hinges)), np.zeros((n, hinges))
        self.quat, self.com = np.zeros((n, 4)), np.zeros((n, 3))
        self.place, self.motion = np.zeros((n, bodies, 3)), np.zeros((n, bodies, 6))
        self.turned, self._every = np.zeros((n, bodies, 4)), np.zeros((n, bodies, 3))
        mass = human.model.body_mass[own]
        self._share = mass / mass.sum()
        self.turn, self._limbs = np.zeros((n, 3, 3)), limbs - 1
        # MuJoCo's arrays stay where they are; to make views of them takes longer than to read them.
        self._rows = []
        for i, (model, data) in enumerate(of):
            pairs = (
                (self.angles[i], data.qpos[7 : 7 + hinges]),
                (self.rates[i], data.qvel[6 : 6 + hinges]),
                (self.quat[i], data.qpos[3:7]),
                (self.com[i], data.subtree_com[1]),
                (self.place[i], data.xpos[own]),
                (self.motion[i], data.cvel[own]),
                (self.turned[i], data.xquat[own]),
                (self._every[i], data.xipos[own]),
            )
            self._rows.append((model, data, pairs))

    @property
    def ends(self) -> np.ndarray:
        """Centres of mass of hands and feet, (n, 4, 3) [m]."""
        return self._every[:, self._limbs]

    @property
    def rising(self) -> np.ndarray:
        """Vertical velocity of the centre of mass, (n,) [m/s]."""
        arm = self._every - self.com[:, None]
        spin = self.motion[..., :3]
        own = self.motion[..., 5] + spin[..., 0] * arm[..., 1] - spin[..., 1] * arm[..., 0]
        return own @ self._share

    def look(self, which: Sequence[int] | None = None) -> None:
        """Bring some worlds, or all, up to date: a step leaves kinematics one step behind."""
        for i in range(len(self._rows)) if which is None else which:
            model, data, pairs = self._rows[i]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            for to, source in pairs:
                to[...] = source
        self.turn = headings(self.quat)
