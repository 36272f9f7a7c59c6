r"""A first guess of how a foot moves from footprint to footprint.

In stance it turns about the back of the heel until it is flat, then about the hinge of the toes (a
rigid foot: about the tips of the toes). Its pitch falls as :math:`(1 - s)^2 (1 + s)` from strike to
flat and rises as :math:`s^2` from heel off to toe off. In swing, ankle and foot follow the mean
curves of :mod:`~plantigrade.models.textbook_gait`, plus a quintic polynomial that matches position
and velocity at both ends, and are raised until the sole clears the ground.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.plan import Stance
from plantigrade.models import Human
from plantigrade.models.feet import point, sphere_radius
from plantigrade.motion.blends import quintic_rise
from plantigrade.spatial.conventions import matrices, within_half_turn

# [rad] minimum and maximum toe-up angle at heel strike
STRIKE_ANGLES = tuple(np.deg2rad([3.0, 30.0]))
# [rad] minimum and maximum heel-up angle at toe-off
TOE_OFF_ANGLES = tuple(np.deg2rad([10.0, 50.0]))
# [rad] maximum heel-up angle of a foot without toes
MAX_RIGID_TOE_OFF_ANGLE = float(np.deg2rad(35.0))
MAX_EVEN_LIFT = 0.25
"""Lift above which the peak of a swing moves from its middle to where the least lift clears the
ground [m]. The leading foot passes a block of 40 cm late in its swing: with the peak in the middle
it was lifted by a metre, and no motion was found. Stairs of 20 cm need less."""
PEAKS = tuple(np.linspace(0.3, 0.7, 9).tolist())
"""Parts of a swing at which that peak may lie."""
CLEARANCE = 0.015  # [m] clearance of the sole in mid-swing; people have 1 to 2 cm at the toes
TOE_RETURN_SHARE = 0.5  # [1] share of the swing until extended toes are straight
EDGE_MARGIN = 0.03  # [m] distance from the edge of a tread within which the sole is above it
TOES_MARGIN = 0.05  # [rad] how far bent toes of a guess stay within their limit
_STEP = 1e-4  # [s] time step of finite differences


@dataclass(frozen=True)
class FootMotion:
    """A foot over time."""

    ankle: Float[Array, "n_times 3"]  #: Ankle joint centre, world [m]
    heading: Float[Array, " n_times"]  #: Where the foot points, from x towards y [rad]
    pitch: Float[Array, " n_times"]  #: Heel up positive, toes up negative [rad]
    toes: Float[Array, " n_times"]  #: Dorsiflexion of the toes [rad]

    def rotations(self) -> Float[Array, "n_times 3 3"]:
        """Return the matrices that turn foot axes to world axes."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        cp, sp = np.cos(self.pitch), np.sin(self.pitch)
        zero = np.zeros_like(c)
        rows = [[c * cp, -s, c * sp], [s * cp, c, s * sp], [-sp, zero, cp]]
        return matrices(rows)


@dataclass(frozen=True)
class FootCurves:
    """How a foot moves in walking, evenly sampled over the swing from toe off to heel strike."""

    strike: float  #: Toe-up angle at heel strike [rad]
    off: float  #: Heel-up angle at toe off [rad]
    pitch: Float[Array, " n_swing"]  #: Heel-up angle in swing [rad]
    forward: Float[Array, " n_swing"]  #: Forward travel of the ankle, 0 to 1
    up: Float[Array, " n_swing"]  #: Height of the ankle above any level [m]


def foot_motion(
    human: Human,
    stances: Sequence[Stance],
    times: Float[Array, " n_times"],
    curves: FootCurves,
    ground: Ground,
) -> FootMotion:
    """Return how a foot moves through all its stances; it rests before and after them.

    In swing the sole is clear of the ``ground`` with all its treads.
    """
    stands = [_Standing(human, s, curves) for s in stances]
    out = np.full((len(times), 6), np.nan)
    for k, stand in enumerate(stands):
        stance = stand.stance
        first, last = k == 0, k == len(stands) - 1
        own = (times >= stance.heel_strike) | first
        own &= (times <= stance.toe_off) | last
        out[own] = stand.at(times[own])
        if not last:
            swing = (times > stance.toe_off) & (times < stands[k + 1].stance.heel_strike)
            if swing.any():
                out[swing] = _swing(human, stand, stands[k + 1], curves, times[swing], ground)
    return FootMotion(out[:, :3], out[:, 3], out[:, 4], out[:, 5])


def toe_coordinates(human: Human, toes: Float[Array, " n"]) -> dict[str, Float[Array, " n"]]:
    r"""Return the coordinates of one foot, without side, with which bent toes lie flat [rad].

    The fourth metatarsal is shorter than the third: as the foot turns by :math:`\theta` about the
    head of the third, the lateral metatarsals turn by :math:`\theta + \delta` with
    :math:`\sin(\theta + \delta) / \sin\theta` the ratio of the distances of both heads from the
    cuboid, so that both lie on the ground.
    """
    if human.feet == "rigid":
        return {}
    if human.feet == "two-segment":
        return {"mtp_angle": toes}
    lateral = np.arcsin(np.clip(_lateral_ratio(human) * np.sin(toes), -1.0, 1.0))
    return {"mtp_angle": toes, "cuboid_angle": toes - lateral, "mtp4_angle": lateral}


def with_toes(human: Human, leg: Mapping[str, float]) -> dict[str, float]:
    """Return the angles of a leg that stands on bent toes, with all toes flat on the ground.

    Lateral toes bend more than the first (:func:`toe_coordinates`). Where they would reach their
    limit, all toes bend less, and the ankle is dorsiflexed by the difference.

    Args:
        leg: Angles by the name of a coordinate without its side [rad].

    Returns:
        These and the angles of the foot [rad].
    """
    toes = bend = leg.get("mtp_angle", 0.0)
    if human.feet == "multi-segment":
        most = max(human.limits[1, human.hinge("mtp4_angle_r")] - TOES_MARGIN, 0.0)
        bend = min(toes, float(np.arcsin(np.sin(most) / _lateral_ratio(human))))
    foot = {name: float(x[0]) for name, x in toe_coordinates(human, np.array([bend])).items()}
    if bend < toes:
        foot["ankle_angle"] = leg.get("ankle_angle", 0.0) + toes - bend
    return {**leg, **foot}


def _lateral_ratio(human: Human) -> float:
    """Return how far from the cuboid the head of the third metatarsal is, by that of the fourth."""
    third, fourth, base = (
        float(point(n, human.dimensions)[0]) for n in ("metatarsal_3", "metatarsal_4", "base_4")
    )
    return (third - base) / (fourth - base)


class _Standing:
    """A foot that turns on its footprint."""

    def __init__(self, human: Human, stance: Stance, curves: FootCurves):
        d = human.dimensions
        self.stance = stance
        self.ankle_height, self.radius = d.ankle_height, sphere_radius(d)
        self.heel = point("heel_back_medial", d)[[0, 2]]
        front = {"rigid": "toe_1", "two-segment": "metatarsal_1", "multi-segment": "metatarsal_3"}
        self.front = point(front[human.feet], d)[[0, 2]]
        self.bends = human.feet != "rigid"
        self.strike_angle, self.off_angle = curves.strike, curves.off
        if not self.bends:
            self.off_angle = min(self.off_angle, MAX_RIGID_TOE_OFF_ANGLE)

    def at(self, times: Float[Array, " n"]) -> Float[Array, "n 6"]:
        """Return ankle, heading, pitch and toe angle; times outside the stance are cut to it."""
        s = self.stance
        t = np.clip(times, s.heel_strike, s.toe_off)
        landing = np.zeros_like(t)
        if s.foot_flat > s.heel_strike:
            left = np.clip((s.foot_flat - t) / (s.foot_flat - s.heel_strike), 0.0, 1.0)
            landing = left**2 * (2 - left)
        rising = np.zeros_like(t)
        if s.toe_off > s.heel_off:
            rising = np.clip((t - s.heel_off) / (s.toe_off - s.heel_off), 0.0, 1.0) ** 2
        pitch = self.off_angle * rising - self.strike_angle * landing
        pivot = np.where((pitch < 0)[:, None], self.heel, self.front)
        c, sn = np.cos(pitch), np.sin(pitch)
        # The pivot stays, and the ankle is at -pivot from it, turned; a sphere rolls.
        forward = pivot[:, 0] - (c * pivot[:, 0] + sn * pivot[:, 1])
        forward += np.where((pitch < 0) | (not self.bends), self.radius * pitch, 0.0)
        up = self.ankle_height + pivot[:, 1] - (-sn * pivot[:, 0] + c * pivot[:, 1])
        (x, y, z), heading = s.footprint.position, np.full_like(t, s.footprint.heading)
        x, y = x + np.cos(heading) * forward, y + np.sin(heading) * forward
        toes = np.maximum(pitch, 0.0) if self.bends else np.zeros_like(t)
        return np.column_stack([x, y, z + up, heading, pitch, toes])


def _swing(
    human: Human,
    behind: _Standing,
    ahead: _Standing,
    curves: FootCurves,
    times: Float[Array, " n"],
    ground: Ground,
) -> Float[Array, "n 6"]:
    """Return ankle, heading, pitch and toe angle between two footprints."""
    off, strike = behind.stance.toe_off, ahead.stance.heel_strike
    span = strike - off
    before, begin = behind.at(np.array([off - _STEP, off]))
    end, after = ahead.at(np.array([strike, strike + _STEP]))
    v0, v1 = (begin - before) / _STEP, (after - end) / _STEP
    end[3] = begin[3] + within_half_turn(end[3] - begin[3])
    # the mean curve, and a polynomial that matches both ends
    bent, begin[5] = begin[5], 0.0
    v0[5] = v1[5] = end[5] = 0.0
    even = np.linspace(0.0, 1.0, len(curves.pitch))
    mean = np.zeros((len(even), 6))
    mean[:, :2] = begin[:2] + curves.forward[:, None] * (end[:2] - begin[:2])
    mean[:, 2], mean[:, 4] = curves.up, curves.pitch
    slope = np.asarray(np.gradient(mean, even, axis=0)) / span
    first, last = begin - mean[0], end - mean[-1]
    v0, v1 = v0 - slope[0], v1 - slope[-1]

    def path(s: np.ndarray) -> np.ndarray:
        out = _quintic(s, span, first, v0, last, v1)
        for i in (0, 1, 2, 4):
            out[:, i] += np.interp(s, even, mean[:, i])
        out[:, 5] = bent * (1 - quintic_rise(s / TOE_RETURN_SHARE))
        return out

    # raised until the sole is clear, on a grid independent of the evaluation times
    grid = np.linspace(0.0, 1.0, 41)
    clear = _clear(human, path(grid), ground)
    inner = (grid >= 0.15) & (grid <= 0.85)

    def lifts(peak: float) -> float:
        bump = _bump(grid[inner], peak)
        return max(0.0, float((CLEARANCE - clear[inner] / bump).max()))

    peak = 0.5
    if lifts(peak) > MAX_EVEN_LIFT:
        peak = min(PEAKS, key=lifts)
    lift, bump = lifts(peak), _bump(grid, peak)
    lacking = -clear - lift * bump  # what may be left of it near the ends
    s = (times - off) / span
    out = path(s)
    out[:, 2] += lift * _bump(s, peak) + np.interp(s, grid, np.maximum(lacking, 0.0))
    return out


def _bump(s: Float[Array, " n"], peak: float) -> Float[Array, " n"]:
    """Return a smooth rise from 0 to 1, reached at ``peak``, and back to 0."""
    a, b = 4.0 * peak, 4.0 * (1.0 - peak)
    return (s / peak) ** a * ((1.0 - s) / (1.0 - peak)) ** b


def _quintic(s, span, x0, v0, x1, v1):
    """Return polynomials from x0 to x1 with end speeds v0 and v1 and no end acceleration."""
    s = s[:, None]
    d, a, b = x1 - x0, v0 * span, v1 * span
    c3 = 10 * d - 6 * a - 4 * b
    c4 = -15 * d + 8 * a + 7 * b
    c5 = 6 * d - 3 * a - 3 * b
    return x0 + s * (a + s * s * (c3 + s * (c4 + s * c5)))


def _clear(human: Human, path: Float[Array, "n 6"], ground: Ground) -> Float[Array, " n"]:
    """Return the height of the lowest point of the sole above the ground near it [m].

    Bent toes belong to the sole.
    """
    d = human.dimensions
    x, ankle, pitch, toes = path[:, 0], path[:, 2], path[:, 4], path[:, 5]
    along, c, s = np.cos(path[:, 3]), np.cos(pitch), np.sin(pitch)
    heel, ball, tip = (point(n, d) for n in ("heel_back_medial", "metatarsal_1", "toe_1"))
    places = [(x + along * (c * p[0] + s * p[2]), ankle - s * p[0] + c * p[2])
              for p in (heel, ball)]  # fmt: skip
    far, (x, z) = tip[0] - ball[0], places[1]
    places.append((x + along * np.cos(pitch - toes) * far, z - np.sin(pitch - toes) * far))
    heights = [z - ground.along(x, EDGE_MARGIN) for x, z in places]
    return np.min(heights, axis=0) - sphere_radius(d)
