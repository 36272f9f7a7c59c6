r"""How well a person follows a reference: four terms from 0 to 1, and their weighted sum.

[Park2020]_, Eq. 10, prints :math:`r = w_p r_p + w_v r_v + w_c r_c + w_e r_e` and takes the terms
from [Peng2018]_:

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

from plantigrade.arrays import Array, Float
from plantigrade.learn.reference import Frame, heading_of, limb_ends
from plantigrade.models import Human
from plantigrade.world import World
from plantigrade.world.scene import FOOT


@dataclass(frozen=True, kw_only=True)
class Weights:
    """Weights of the four terms; the paper prints none, these are those of [Peng2018]_.

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
        human: The person.
        weights: The weights.
    """

    def __init__(self, human: Human, weights: Weights):
        self._weights = weights
        names = [human.body_names[b - 1] for b in human.model.jnt_bodyid[1:]]
        inner = [n.startswith(FOOT) and not n.startswith("foot") for n in names]
        self._counts = np.where(np.array(inner) & (not weights.feet), 0.0, 1.0)
        self._ends = np.array(limb_ends(human))

    def of(self, world: World, reference: Frame) -> tuple[float, dict[str, float]]:
        """Return the reward and its terms, of a world whose kinematics are up to date."""
        data, counts = world.data, self._counts
        n = len(counts)
        pose = (data.qpos[7 : 7 + n] - reference.qpos[7:]) * counts
        rates = (data.qvel[6 : 6 + n] - reference.qvel[6:]) * counts
        com = data.subtree_com[1] - reference.com
        c, s = heading_of(data.qpos[3:7])
        ends = (data.xipos.take(self._ends, 0) - data.xpos[1]) @ _turn(c, s)
        off = ends.ravel() - reference.ends
        terms = {
            "pose": exp(-2.0 * (pose @ pose)),
            "velocity": exp(-0.1 * (rates @ rates)),
            "com": exp(-10.0 * (com @ com)),
            "ends": exp(-40.0 * (off @ off)),
        }
        w = self._weights
        whole = w.pose * terms["pose"] + w.velocity * terms["velocity"]
        return whole + w.com * terms["com"] + w.ends * terms["ends"], terms


def _turn(cosine: float, sine: float) -> Float[Array, "3 3"]:
    """Return the matrix that maps rows of world axes to those of a heading."""
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
