"""The shape of a synthesised gait: differences from norms, ground reaction, knee, ankle, work.

All figures but the work are computed from curves over the gait cycle
(:func:`~plantigrade.analyze.curves.gait_curves`).
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from plantigrade.analyze.curves import GaitCurves
from plantigrade.analyze.norms import agreement_with_norm
from plantigrade.analyze.statistics import Agreement
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES
from plantigrade.dynamics.passive import passive_moments, scale
from plantigrade.errors import ParameterError
from plantigrade.record import Record

LEG = ("hip_flexion", "knee_angle", "ankle_angle")
"""Angles whose mean difference from norms is the usual figure of a simulated gait."""

COMPARED_ANGLES = (*LEG, "pelvis_tilt", "pelvis_list", "pelvis_rotation", "hip_adduction")
MIN_HUMP = 0.02  # [body weights] minimum height of the lower hump above the trough


@dataclass(frozen=True)
class Humps:
    """The vertical ground reaction of one foot in stance [body weights]."""

    first: float  #: First hump; without one, the largest value in the first half of stance
    trough: float  #: Smallest value between the humps
    second: float  #: Second hump; without one, the largest value in the second half
    two: bool  #: Whether there are two humps, both higher than the trough by :data:`MIN_HUMP`


@dataclass(frozen=True)
class GaitShape:
    """Shape of the gait of one foot; mean over its cycles."""

    agreement: dict[str, Agreement]  #: Coordinate → agreement with the norm of the speed class
    humps: Humps | None  #: Humps of the vertical ground reaction; None if forces are unknown
    #: Smallest (braking) and largest (pushing) force forward [body weights]
    anterior: tuple[float, float]
    stance: float  #: Heel strike to toe off [% of the cycle]
    knee_loading: float  #: Largest knee flexion before mid-stance [deg]
    knee_mid_stance: float  #: Knee flexion at the middle of stance [deg]
    knee_swing: float  #: Largest knee flexion in swing [deg]
    ankle_range: float  #: Range of the ankle over the cycle [deg]
    ankle_toe_off: float  #: Ankle dorsiflexion at toe off [deg]
    #: Largest power of the ankle in the second half of stance [W/kg]; NaN if torques are unknown
    ankle_power: float

    @property
    def rmse(self) -> float:
        """Mean over hip, knee and ankle [deg]."""
        return float(np.mean([self.agreement[n].rmse for n in LEG]))

    @property
    def rmse_offset_removed(self) -> float:
        """Mean over hip, knee and ankle, each without its mean difference [deg]."""
        return float(np.mean([self.agreement[n].rmse_offset_removed for n in LEG]))


def gait_shape(curves: GaitCurves, speed_class: str = "free", *, side: str = "r") -> GaitShape:
    """Return the shape of a gait.

    Args:
        curves: Curves over its cycles.
        speed_class: Speed class of the norms, see :func:`plantigrade.analyze.norms.speed_class`.
        side: ``"r"`` or ``"l"``.

    Raises:
        ParameterError: If that foot has no complete cycle with a toe-off.
    """
    cycles = [c for c in curves.cycles if c.side == side and c.toe_off is not None]
    if not cycles:
        foot = SIDE_NAMES.get(side, side)
        raise ParameterError(f"no complete gait cycle of the {foot} foot with a toe-off")
    percent = curves.percent
    stance = float(np.mean([c.percent(c.toe_off) for c in cycles if c.toe_off is not None]))

    def mean(table: dict[str, np.ndarray], name: str) -> Float[Array, " n"]:
        rows = table.get(name, np.empty((0, len(percent))))
        return np.nanmean(rows, axis=0) if len(rows) else np.full(len(percent), np.nan)

    agreement = {}
    for name in COMPARED_ANGLES:
        own = mean(curves.angles, name if name.startswith("pelvis") else f"{name}_{side}")
        if np.isfinite(own).any():
            agreement[name] = agreement_with_norm(percent, own, name, speed_class, side=side)
    knee, ankle = (mean(curves.angles, f"{n}_{side}") for n in ("knee_angle", "ankle_angle"))
    up, forward = (mean(curves.forces, f"{n}_{side}") for n in ("up", "forward"))
    power = mean(curves.powers, f"ankle_angle_{side}")
    late = (percent >= stance / 2) & (percent <= stance)
    return GaitShape(
        agreement,
        humps_of(percent, up, stance) if np.isfinite(up).all() else None,
        (float(forward.min()), float(forward.max())),
        stance,
        knee_loading=float(knee[percent <= stance / 2].max()),
        knee_mid_stance=float(np.interp(stance / 2, percent, knee)),
        knee_swing=float(knee[percent >= stance].max()),
        ankle_range=float(np.ptp(ankle)),
        ankle_toe_off=float(np.interp(stance, percent, ankle)),
        ankle_power=float(power[late].max()),
    )


def humps_of(percent: Float[Array, " n"], up: Float[Array, " n"], stance: float = 60.0) -> Humps:
    """Return both humps of a vertical ground reaction and the trough between them.

    A hump is the highest local maximum in one half of stance.

    Args:
        percent: Percent of the gait cycle, from heel strike.
        up: Vertical force of the foot [body weights].
        stance: Toe-off [% of the cycle].
    """
    inside = np.flatnonzero(percent <= stance)
    force = up[inside]
    higher = (force[1:-1] > force[:-2]) & (force[1:-1] >= force[2:])
    peaks = np.flatnonzero(higher) + 1
    halves = percent[inside] < stance / 2

    def top(half: np.ndarray) -> tuple[int, bool]:
        mine = [i for i in peaks if half[i]]
        if mine:
            return int(max(mine, key=lambda i: force[i])), True
        return int(np.argmax(np.where(half, force, -np.inf))), False

    (a, left), (b, right) = top(halves), top(~halves)
    trough = float(force[a : b + 1].min())
    first, second = float(force[a]), float(force[b])
    two = left and right and min(first, second) - trough >= MIN_HUMP
    return Humps(first, trough, second, bool(two))


def muscle_work(record: Record) -> tuple[float, float]:
    r"""Return the positive work and the absorbed work of the muscles at the joints [J].

    It is :math:`\int \max(\tau_m \dot q, 0)\, dt` over all joints, with :math:`\tau_m` the joint
    torque less the passive moment of tissue (:mod:`plantigrade.dynamics.passive`). The work of
    muscle fibres is smaller, because of biarticular muscles and elastic tendons; heat is not
    included.

    Raises:
        ParameterError: If the record has no joint torques.
    """
    if record.qfrc_actuator is None:
        raise ParameterError("this record has no joint torques, so the work of muscles is unknown")
    motion, human = record.motion, record.human
    q, v, tau = motion.qpos[:, 7:], motion.qvel[:, 6:], record.qfrc_actuator[:, 6:]
    factor = scale(human.mass, human.height)
    tissue = passive_moments(human.coordinates, list(q.T), list(v.T), factor)
    power = (tau - np.stack([np.broadcast_to(m, len(q)) for m in tissue], axis=1)) * v
    done, absorbed = (
        float(trapezoid(np.maximum(p, 0.0).sum(axis=1), motion.time)) for p in (power, -power)
    )
    return done, absorbed
