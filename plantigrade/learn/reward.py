r"""Rewards for tracking a reference: terms from 0 to 1, and their weighted sum.

[Park2020]_, Eq. 10, prints :math:`r = w_p r_p + w_v r_v + w_c r_c + w_e r_e` and takes the terms
from [DeepMimic]_:

.. math::

    r_p = e^{-2 \sum_j \Delta q_j^2} \quad r_v = e^{-0.1 \sum_j \Delta \dot q_j^2} \quad
    r_e = e^{-40 \sum_e |\Delta p_e|^2} \quad r_c = e^{-10 |\Delta p_c|^2}

over joints :math:`j`, hands and feet :math:`e` relative to the pelvis, and the centre of mass in
the world. In [DeepMimic]_ the sum runs over rotation angles of joints; here it runs over hinges,
which is equivalent for small angles.

None of these terms depends on how a foot lands. Two additional terms do: one penalises ground
forces outside the range of walking, the other errors of pitch and roll of the feet,

.. math::

    r_f = e^{-\max(|F/W - 1| - 0.25, 0)} \qquad r_s = e^{-20 \sum_f |\Delta s_f|^2}

with :math:`F` the mean vertical ground reaction force during a decision, from the change of
momentum, :math:`W` the body weight, and :math:`s_f` the vertical components of the first two axes
of a foot.
"""

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.observation import first_axes
from plantigrade.learn.reference import Reference, ReferenceState
from plantigrade.world.world_model import FOOT_PREFIXES


@dataclass(frozen=True, kw_only=True)
class RewardWeights:
    """Weights of the reward terms; the first four are those of [DeepMimic]_.

    Attributes:
        pose: :math:`w_p`.
        velocity: :math:`w_v`.
        com: :math:`w_c`.
        ends: :math:`w_e`.
        feet: Whether joints within the feet count in pose and velocity. They are two fifths of all
            joints and matter little for a walk.
        force: Weight of :math:`r_f - 1`, a cost of hard landings and flight; not in the paper.
        soles: Weight of :math:`r_s`; not in the paper.
    """

    pose: float = 0.65
    velocity: float = 0.1
    com: float = 0.1
    ends: float = 0.15
    feet: bool = True
    force: float = 0.0
    soles: float = 0.0


FORCE_TOLERANCE = 0.25
"""Deviation of the ground reaction force from body weight in walking, without penalty [body
weights]; a centre of mass that rises by 2.5 cm in each of two steps per second accelerates by 0.2
g."""
ROWS = 101
"""Instants of a stride at which the inclination of the feet is stored."""
LEAN_WEIGHTS = RewardWeights(pose=0.5, velocity=0.1, com=0.25, ends=0.15, feet=False)
"""Weights with which walking was learned in a million steps."""
LANDING_WEIGHTS = replace(LEAN_WEIGHTS, force=2.0, soles=0.3)
"""Weights with which a walking policy learned to land on the heel."""


class Reward:
    """Reward of tracking a reference."""

    def __init__(self, reference: Reference, weights: RewardWeights):
        self._weights, human = weights, reference.human
        names = [human.body_names[b - 1] for b in human.model.jnt_bodyid[1:]]
        inner = [n.startswith(FOOT_PREFIXES) and not n.startswith("foot") for n in names]
        self._counts = np.where(np.array(inner) & (not weights.feet), 0.0, 1.0)
        self._feet = np.array([human.body(f"foot_{side}") for side in SIDES]) - 1
        self._soles = _soles(reference) if weights.soles else None

    def of(
        self,
        view: BatchState,
        reference: ReferenceState,
        phase: Float[Array, " n"],
        force: Float[Array, " n"],
    ) -> tuple[Float[Array, " n"], dict[str, Float[Array, " n"]]]:
        """Return rewards and their terms, one row per world.

        Args:
            view: Updated state of the persons.
            force: Mean vertical ground reaction force since the last decision [body weights].
        """
        pose = (view.angles - reference.qpos[:, 7:]) * self._counts
        rates = (view.rates - reference.qvel[:, 6:]) * self._counts
        com = view.com - reference.com
        ends = (view.ends - view.positions[:, :1]) @ view.headings
        off = ends.reshape(len(com), -1) - reference.ends
        terms = {
            name: np.exp(-factor * np.einsum("ij,ij->i", x, x))
            for name, factor, x in (
                ("pose", 2.0, pose), ("velocity", 0.1, rates), ("com", 10.0, com),
                ("ends", 40.0, off),
            )
        }  # fmt: skip
        if self._weights.force:
            terms["force"] = np.exp(-np.maximum(np.abs(force - 1.0) - FORCE_TOLERANCE, 0.0))
        if self._soles is not None:
            row = np.rint(phase * (len(self._soles) - 1)).astype(int)
            off = foot_inclination(view.orientations[:, self._feet]) - self._soles[row]
            terms["soles"] = np.exp(-20.0 * np.einsum("ijk,ijk->i", off, off))
        whole = np.full(len(com), -self._weights.force)
        for name, term in terms.items():
            whole += getattr(self._weights, name) * term
        return whole, terms


def foot_inclination(quat: Float[Array, "*n 4"]) -> Float[Array, "*n 2"]:
    """Return the sines of pitch and roll of bodies."""
    first, second = first_axes(quat)
    return np.stack([first[..., 2], second[..., 2]], axis=-1)


def _soles(reference: Reference) -> Float[Array, "n_rows 2 2"]:
    """Return the inclination of the feet over the stride, in :data:`ROWS` rows."""
    human = reference.human
    data, feet = mujoco.MjData(human.model), [human.body(f"foot_{side}") for side in SIDES]
    found = np.zeros((ROWS, len(feet), 2))
    for k, qpos in enumerate(reference.at(np.linspace(0.0, reference.period, ROWS)).qpos):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(human.model, data)
        found[k] = foot_inclination(data.xquat[feet])
    return found
