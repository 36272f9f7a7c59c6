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

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.learn.reference import Frame
from plantigrade.learn.view import View
from plantigrade.models import Human
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
    """Rewards persons for following a reference.

    Args:
        human: The person.
        weights: The weights.
    """

    def __init__(self, human: Human, weights: Weights):
        self._weights = weights
        names = [human.body_names[b - 1] for b in human.model.jnt_bodyid[1:]]
        inner = [n.startswith(FOOT) and not n.startswith("foot") for n in names]
        self._counts = np.where(np.array(inner) & (not weights.feet), 0.0, 1.0)

    def of(
        self, view: View, reference: Frame
    ) -> tuple[Float[Array, " n"], dict[str, Float[Array, " n"]]]:
        """Return rewards and their terms, of a view that is up to date.

        Args:
            view: The persons.
            reference: Where they should be.
        """
        pose = (view.angles - reference.qpos[:, 7:]) * self._counts
        rates = (view.rates - reference.qvel[:, 6:]) * self._counts
        com = view.com - reference.com
        ends = (view.ends - view.place[:, :1]) @ view.turn
        off = ends.reshape(len(com), -1) - reference.ends
        terms = {
            name: np.exp(-factor * np.einsum("ij,ij->i", x, x))
            for name, factor, x in (
                ("pose", 2.0, pose), ("velocity", 0.1, rates), ("com", 10.0, com),
                ("ends", 40.0, off),
            )
        }  # fmt: skip
        w = self._weights
        whole = w.pose * terms["pose"] + w.velocity * terms["velocity"]
        return whole + w.com * terms["com"] + w.ends * terms["ends"], terms
