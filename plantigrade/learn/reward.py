r"""How well a person follows a reference: four terms from 0 to 1, and their weighted sum.

[Park2020]_, Eq. 10, prints :math:`r = w_p r_p + w_v r_v + w_c r_c + w_e r_e` and takes the terms
from [DeepMimic]_:

.. math::

    r_p = e^{-2 \sum_j \Delta q_j^2} \quad r_v = e^{-0.1 \sum_j \Delta \dot q_j^2} \quad
    r_e = e^{-40 \sum_e |\Delta p_e|^2} \quad r_c = e^{-10 |\Delta p_c|^2}

over joints :math:`j`, hands and feet :math:`e` as seen from the pelvis, and the centre of mass in
the world. Peng's sum runs over the angles between orientations of joints; ours over hinges, which
is the same where the angles are small.
"""

from dataclasses import dataclass
from math import exp

import numpy as np

from plantigrade.learn.reference import Frame, Heading, limb_ends
from plantigrade.world import World
from plantigrade.world.scene import FOOT


@dataclass(frozen=True, kw_only=True)
class Weights:
    """Weights of the four terms; the paper prints none, these are those of [DeepMimic]_.

    Attributes:
        pose: :math:`w_p`.
        velocity: :math:`w_v`.
        com: :math:`w_c`.
        ends: :math:`w_e`.
        feet: Whether joints within the feet count in pose and velocity: there are two thirds as
            many of them as of all others, and they have little to say about a walk.
    """

    pose: float = 0.65
    velocity: float = 0.1
    com: float = 0.1
    ends: float = 0.15
    feet: bool = True


LEAN_WEIGHTS = Weights(pose=0.5, velocity=0.1, com=0.25, ends=0.15, feet=False)
"""With which walking was learned in a million steps."""


class Reward:
    """Rewards a person for following a reference.

    Args:
        world: The person's.
        weights: The weights.
    """

    def __init__(self, world: World, weights: Weights):
        human, data = world.human, world.data
        self._weights = weights
        names = [human.body_names[b - 1] for b in human.model.jnt_bodyid[1:]]
        inner = [n.startswith(FOOT) and not n.startswith("foot") for n in names]
        self._counts = np.where(np.array(inner) & (not weights.feet), 0.0, 1.0)
        n = len(names)
        self._angles, self._rates = data.qpos[7 : 7 + n], data.qvel[6 : 6 + n]
        self._com, self._pelvis, self._bodies = data.subtree_com[1], data.xpos[1], data.xipos
        self._ends = np.array(limb_ends(human))

    def of(self, turn: Heading, reference: Frame) -> tuple[float, dict[str, float]]:
        """Return the reward and its terms; the kinematics of the world must be up to date.

        Args:
            turn: Where the pelvis faces.
            reference: Where the person should be.
        """
        pose = (self._angles - reference.qpos[7:]) * self._counts
        rates = (self._rates - reference.qvel[6:]) * self._counts
        com = self._com - reference.com
        ends = (self._bodies.take(self._ends, 0) - self._pelvis) @ turn.matrix
        off = ends.ravel() - reference.ends
        p, v = exp(-2.0 * (pose @ pose)), exp(-0.1 * (rates @ rates))
        c, e = exp(-10.0 * (com @ com)), exp(-40.0 * (off @ off))
        w = self._weights
        whole = w.pose * p + w.velocity * v + w.com * c + w.ends * e
        return whole, {"pose": p, "velocity": v, "com": c, "ends": e}
