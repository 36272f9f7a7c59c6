"""From sitting on the floor with stretched legs over a squat to standing.

Hands rest on the floor behind the pelvis. One foot after the other is drawn in and put down flat,
hands and feet lift the pelvis and move it over the feet, and the hands leave the floor. Of many
ways in which young adults rise, to push with both hands and to stand up from a squat is the most
frequent: a quarter of them [VanSant1988]_.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.limb_sites import (
    HEEL_PART,
    HIP_ABOVE_SEAT,
    LYING_PITCHES,
    limb_site,
    seat_sites,
)
from plantigrade.contact.plan import ContactPlan, PointSupport, Stance
from plantigrade.models import Human
from plantigrade.side_names import opposite
from plantigrade.trajopt.guess.postures import posture, standing_on
from plantigrade.trajopt.tasks.chair import resting_place, turned_out
from plantigrade.trajopt.tasks.standing import bent


@dataclass(frozen=True)
class SittingOnFloor:
    """Where a person sits on the floor, and when contacts change.

    All are estimates: with these lengths, limbs reach and clear each other in people of 1.3 to 2 m;
    with these times, each phase is slow enough for the strength of people.
    """

    first_off: float = 0.06  #: The first heel leaves the floor [1, of the duration]
    first_down: float = 0.20  #: Its foot lands flat [1]
    second_off: float = 0.22  #: The other heel leaves the floor [1]
    second_down: float = 0.36  #: Its foot lands flat [1]
    seat_off: float = 0.50  #: The pelvis leaves the floor [1]
    hands_off: float = 0.62  #: The hands leave the floor [1]
    behind: float = 0.21  #: Hips behind the ankles once the feet are drawn in [stature]
    hands_behind: float = 0.14  #: Palms behind the hips [stature]
    hands_aside: float = 0.17  #: Palms from the middle [stature]
    tilt: float = float(np.deg2rad(25.0))  #: Posterior tilt of the pelvis [rad]
    trunk: float = float(np.deg2rad(-23.0))  #: Lumbar extension [rad]
    knee: float = float(np.deg2rad(15.0))  #: Flexion of the knees of stretched legs [rad]


ARMS_BEHIND = {
    "arm_flex": -0.6, "elbow_flex": 0.3, "wrist_flex": -1.0, "arm_add": -0.3,
}  # fmt: skip
"""Arms on the floor behind the pelvis, to start from [rad]. Estimate."""
DRAWN_IN = {"knee_angle": 1.5, "hip_flexion": 1.75, "ankle_angle": 0.0}
"""A leg that is drawn in, its foot in the air, to start from [rad]. Estimate."""


def from_sitting(
    human: Human, first: str, duration: float
) -> tuple[ContactPlan, tuple[PointSupport, ...], tuple[float, ...], Float[Array, "n nv"], float]:
    """Return the plan of the feet, other supports, times, postures and when the rise begins [s].

    Args:
        first: Side of the foot that is drawn in first.
        duration: Until standing [s].
    """
    how, feet, d, size = SittingOnFloor(), turned_out(human), human.dimensions, human.height
    second = opposite(first)
    ankle, floor = feet[first].position[0], HIP_ABOVE_SEAT * size
    down = {first: how.first_down * duration, second: how.second_down * duration}
    up = {first: how.first_off * duration, second: how.second_off * duration}
    end, seat_off, hands_off = duration + 1.0, how.seat_off * duration, how.hands_off * duration
    hip = ankle - how.behind * size
    behind = _with(human, standing_on(human, feet), dict.fromkeys(SIDES, ARMS_BEHIND))
    arms = dict(zip(human.coordinates, map(float, behind[6:]), strict=True))
    tucked = posture(
        human, feet, hip=(hip, floor), tilt=how.tilt, joints={**arms, **bent(human, how.trunk)}
    )
    heels = {side: limb_site(human, f"{HEEL_PART}_{side}") for side in SIDES}
    reach, rise = _stretched(human, heels[first].position, how.knee, floor - heels[first].radius)
    stretched = {
        "knee_angle": how.knee,
        "hip_flexion": float(rise - how.tilt),
        "ankle_angle": 0.0,
        "subtalar_angle": 0.0,
    }
    supports: list[PointSupport] = []
    for site in seat_sites(human):
        x, y, _ = resting_place(human, site, tucked)
        supports.append(PointSupport(site, (x, y, 0.0), -1.0, seat_off))
    for side, left in (("r", -1.0), ("l", 1.0)):
        place = (hip + reach, feet[side].position[1] + left * d.ankle_height, 0.0)
        pitch = LYING_PITCHES[HEEL_PART]
        supports.append(PointSupport(heels[side], place, -1.0, up[side], pitch=pitch))
        palm = (hip - how.hands_behind * size, left * how.hands_aside * size, 0.0)
        site = limb_site(human, f"hand_{side}", on_ground=True)
        supports.append(PointSupport(site, palm, -1.0, hands_off))
    plan = ContactPlan(
        duration, tuple(Stance(feet[s], down[s], down[s], end, end, end) for s in SIDES)
    )
    lifted = posture(
        human, feet, hip=(ankle - 0.11 * size, floor + 0.06 * size), tilt=-0.4,
        joints={**arms, **bent(human, -0.5)},
    )  # fmt: skip
    squat = posture(
        human, feet, hip=(ankle - 0.10 * size, 0.26 * size), tilt=-0.6, joints=bent(human, -0.3)
    )
    long = _with(human, tucked, {first: stretched, second: stretched})
    keys = [
        (0.0, long),
        (up[first], long),
        ((up[first] + down[first]) / 2, _with(human, long, {first: DRAWN_IN})),
        (down[first], _with(human, tucked, {second: stretched})),
        (up[second], _with(human, tucked, {second: stretched})),
        ((up[second] + down[second]) / 2, _with(human, tucked, {second: DRAWN_IN})),
        (down[second], tucked),
        (seat_off, (tucked + lifted) / 2),
        (hands_off, lifted),
        ((hands_off + duration) / 2, squat),
        (duration, standing_on(human, feet)),
    ]
    times, postures = zip(*keys, strict=True)
    return plan, tuple(supports), tuple(map(float, times)), np.array(postures), seat_off


def _stretched(
    human: Human, heel: Sequence[float] | Array, knee: float, above: float
) -> tuple[float, float]:
    """Return how far ahead of the hip a heel is [m], and how far its thigh is off the vertical.

    Args:
        heel: The heel in the frame of the foot, which is at right angles to the shank [m].
        knee: Flexion of the knee [rad].
        above: Height of the hip above the heel [m].
    """
    d = human.dimensions
    below = -float(heel[2]) + d.shank  # along the shank from the knee; across it, forward positive
    ahead = float(heel[0])
    x = ahead * np.cos(knee) - below * np.sin(knee)
    z = -d.thigh - below * np.cos(knee) - ahead * np.sin(knee)
    length = float(np.hypot(x, z))
    turned = np.arccos(above / length) - np.arctan2(x, -z)
    return float(np.sqrt(length**2 - above**2)), float(turned)


def _with(
    human: Human, q: Float[Array, " nv"], limbs: Mapping[str, Mapping[str, float]]
) -> Float[Array, " nv"]:
    """Return a posture with other angles of limbs, by side; those that a person has."""
    out = q.copy()
    for side, angles in limbs.items():
        for name, angle in angles.items():
            if f"{name}_{side}" in human.coordinates:
                out[6 + human.hinge(f"{name}_{side}")] = angle
    return out
