r"""Rewards for tracking a reference: terms from 0 to 1, and their weighted sum.

[Park2020]_, Eq. 10, prints :math:`r = w_p r_p + w_v r_v + w_c r_c + w_e r_e` and takes the terms
from [DeepMimic]_:

.. math::

    r_p = e^{-2 \sum_j \Delta q_j^2} \quad r_v = e^{-0.1 \sum_j \Delta \dot q_j^2} \quad
    r_e = e^{-40 \sum_e |\Delta p_e|^2} \quad r_c = e^{-10 |\Delta p_c|^2}

over joints :math:`j`, hands and feet :math:`e` relative to the pelvis, and the centre of mass in
the world. In [DeepMimic]_ the sum runs over rotation angles of joints; here it runs over hinges,
which is equivalent for small angles.

None of these terms depends on how a foot lands. Four additional terms do. They penalise ground
forces outside the range of walking, feet that meet the ground fast, a distribution of the load on
both feet that differs from the reference, and errors of pitch and roll of the feet,

.. math::

    r_f = e^{-\max(F_{max} - 1.25, 0) - \max(0.75 - F_{min}, 0)} \qquad
    r_t = e^{-\max(v - 0.2, 0) / 0.3} \qquad
    r_l = e^{-4 (s - \hat s)^2} \qquad r_s = e^{-20 \sum_f |\Delta s_f|^2}

with :math:`F_{max}` and :math:`F_{min}` the greatest and least vertical ground reaction force
during a decision, low-passed as in :mod:`plantigrade.learn.landing`, in body weights, :math:`v` the
downward speed of a foot at touchdown [m/s], :math:`s` and :math:`\hat s` the share of the right
foot in the load, measured and of the reference, and :math:`s_f` the vertical components of the
first two axes of a foot. The load of the reference passes evenly from foot to foot while both soles
are down.
"""

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.landing import Landing
from plantigrade.learn.observation import first_axes
from plantigrade.learn.reference import ReferenceInstant, ReferenceMotion
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
        touchdown: Weight of :math:`r_t - 1`, a cost of fast touchdowns; not in the paper.
        load: Weight of :math:`r_l`; not in the paper.
        soles: Weight of :math:`r_s`; not in the paper.
    """

    pose: float = 0.65
    velocity: float = 0.1
    com: float = 0.1
    ends: float = 0.15
    feet: bool = True
    force: float = 0.0
    touchdown: float = 0.0
    load: float = 0.0
    soles: float = 0.0

    @property
    def landing(self) -> bool:
        """Whether a term needs the forces between two decisions."""
        return bool(self.force or self.touchdown or self.load)


TERMS = ("pose", "velocity", "com", "ends", "force", "touchdown", "load", "soles")
"""Terms of the reward; some rules use a part of them."""
FORCE_TOLERANCE = 0.25
"""Deviation of the ground reaction force from body weight in walking, without penalty [body
weights]; a centre of mass that rises by 2.5 cm in each of two steps per second accelerates by 0.2
g."""
TOUCHDOWN_TOLERANCE = 0.2
"""Downward speed of a foot at touchdown without penalty, that of the published mean walk [m/s]."""
TOUCHDOWN_SCALE = 0.3
"""Excess of that speed at which the reward falls to 1/e [m/s]; chosen."""
DOWN_HEIGHT = 0.002
"""A sole of the reference is down if its lowest point is this close to the lowest height that it
reaches in the stride [m]; chosen."""
ROWS = 101
"""Instants of a stride at which inclination and load of the feet are stored."""
LEAN_WEIGHTS = RewardWeights(pose=0.5, velocity=0.1, com=0.25, ends=0.15, feet=False)
"""Weights with which walking was learned in a million steps."""
LANDING_WEIGHTS = replace(LEAN_WEIGHTS, force=4.0, touchdown=1.0, load=1.0, soles=0.3)
"""Weights with which a walking policy learned to land on the heel."""


class Reward:
    """Reward of tracking a reference."""

    def __init__(self, reference: ReferenceMotion, weights: RewardWeights):
        self._weights, human = weights, reference.human
        names = [human.body_names[b - 1] for b in human.model.jnt_bodyid[1:]]
        inner = [n.startswith(FOOT_PREFIXES) and not n.startswith("foot") for n in names]
        self._counts = np.where(np.array(inner) & (not weights.feet), 0.0, 1.0)
        self._feet = np.array(human.both("foot")) - 1
        self._soles = _soles(reference) if weights.soles else None
        self._shares = load_shares(reference) if weights.load else None

    def of(
        self,
        view: BatchState,
        reference: ReferenceInstant,
        phase: Float[Array, " n"],
        landing: Landing | None = None,
    ) -> tuple[Float[Array, " n"], dict[str, Float[Array, " n"]]]:
        """Return rewards and their terms, one row per world.

        Args:
            view: Updated state of the persons.
            landing: Ground reaction since the last decision; needed for its terms.
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
        row = np.rint(phase * (ROWS - 1)).astype(int)
        if landing is not None:
            terms |= self._landing_terms(landing, row)
        if self._soles is not None:
            off = foot_inclination(view.orientations[:, self._feet]) - self._soles[row]
            terms["soles"] = np.exp(-20.0 * np.einsum("ijk,ijk->i", off, off))
        whole = np.zeros(len(com)) - self._weights.force - self._weights.touchdown
        for name, term in terms.items():
            whole += getattr(self._weights, name) * term
        return whole, terms

    def _landing_terms(self, landing: Landing, row: np.ndarray) -> dict[str, Float[Array, " n"]]:
        above, below = landing.peak - 1.0, 1.0 - landing.trough
        excess = sum(np.maximum(x - FORCE_TOLERANCE, 0.0) for x in (above, below))
        fast = np.maximum(landing.speed - TOUCHDOWN_TOLERANCE, 0.0) / TOUCHDOWN_SCALE
        terms = {"force": np.exp(-excess), "touchdown": np.exp(-fast)}
        if self._shares is not None:
            total = np.maximum(landing.loads.sum(axis=1), FORCE_TOLERANCE)
            off = landing.loads[:, 0] / total - self._shares[row]
            terms["load"] = np.exp(-4.0 * off * off)
        return terms


def foot_inclination(quat: Float[Array, "*n 4"]) -> Float[Array, "*n 2"]:
    """Return the sines of pitch and roll of bodies."""
    first, second = first_axes(quat)
    return np.stack([first[..., 2], second[..., 2]], axis=-1)


def _soles(reference: ReferenceMotion) -> Float[Array, "n_rows 2 2"]:
    """Return the inclination of the feet over the stride, in :data:`ROWS` rows."""
    human = reference.human
    data, feet = mujoco.MjData(human.model), human.both("foot")
    found = np.zeros((ROWS, len(feet), 2))
    for k, qpos in enumerate(reference.at(np.linspace(0.0, reference.period, ROWS)).qpos):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(human.model, data)
        found[k] = foot_inclination(data.xquat[feet])
    return found


def load_shares(reference: ReferenceMotion) -> Float[Array, " n_rows"]:
    """Return the share of the right foot in the load over the stride, in :data:`ROWS` rows.

    It changes evenly while both soles, or none, are down.
    """
    at = np.linspace(0.0, 1.0, ROWS)
    soles = sole_paths(reference.human, reference.at(at * reference.period).qpos)
    heights = np.stack([soles.lowest(s) for s in SIDES], axis=1)
    right, left = (heights - heights.min(axis=0) < DOWN_HEIGHT).T
    alone = right != left
    if not alone.any():
        return np.full(ROWS, 0.5)
    period = 1.0 if reference.cyclic else None
    return np.interp(at, at[alone], right[alone].astype(float), period=period)
