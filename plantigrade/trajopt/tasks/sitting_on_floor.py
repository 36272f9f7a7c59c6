"""From sitting or lying on the floor with stretched legs over a squat to standing.

Hands rest on the floor behind the pelvis. One foot after the other is drawn in and put down flat,
hands and feet lift the pelvis and move it over the feet, and the hands leave the floor. Of many
ways in which young adults rise, to push with both hands and to stand up from a squat is the most
frequent: a quarter of them [VanSant1988]_.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.limb_sites import (
    BUTTOCK_PART,
    HEEL_PART,
    HIP_ABOVE_SEAT,
    LYING_PITCHES,
    limb_site,
    seat_sites,
)
from plantigrade.contact.plan import ContactPlan, PointSupport, Stance
from plantigrade.models import Human
from plantigrade.side_names import opposite
from plantigrade.trajopt.guess.lying_leg import LyingLeg
from plantigrade.trajopt.guess.postures import posture, standing_on, with_limbs
from plantigrade.trajopt.tasks.chair import resting_place, turned_out
from plantigrade.trajopt.tasks.lying_on_back import LyingOnBack, sitting_up
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


@dataclass(frozen=True)
class _Times:
    """When contacts change [s]."""

    off: Mapping[str, float]  #: The heel of a side leaves the floor
    down: Mapping[str, float]  #: The foot of a side lands flat
    seat_off: float
    hands_off: float
    end: float

    @classmethod
    def of(cls, how: SittingOnFloor, first: str, begun: float, duration: float) -> "_Times":
        """Return the times of a person who sits from ``begun`` on [s]."""
        second, left = opposite(first), duration - begun
        return cls(
            {first: begun + how.first_off * left, second: begun + how.second_off * left},
            {first: begun + how.first_down * left, second: begun + how.second_down * left},
            begun + how.seat_off * left,
            begun + how.hands_off * left,
            duration,
        )


def from_sitting(
    human: Human, first: str, duration: float, lies: LyingOnBack | None = None
) -> tuple[ContactPlan, tuple[PointSupport, ...], tuple[float, ...], Float[Array, "n nv"], float]:
    """Return the plan of the feet, other supports, times, postures and when the rise begins [s].

    Args:
        first: Side of the foot that is drawn in first.
        duration: Until standing [s].
        lies: How the person lies before sitting up, if so.
    """
    how, feet = SittingOnFloor(), turned_out(human)
    begun = 0.0 if lies is None else lies.sits * duration
    at, second = _Times.of(how, first, begun, duration), opposite(first)
    floor, end = HIP_ABOVE_SEAT * human.height, duration + 1.0
    ankle = feet[first].position[0]
    hip = ankle - how.behind * human.height
    behind = with_limbs(human, standing_on(human, feet), dict.fromkeys(SIDES, ARMS_BEHIND))
    arms = dict(zip(human.coordinates, map(float, behind[6:]), strict=True))
    tucked = posture(
        human, feet, hip=(hip, floor), tilt=how.tilt, joints={**arms, **bent(human, how.trunk)}
    )
    leg = LyingLeg(human, floor)
    up = None if lies is None else sitting_up(human, hip, how.tilt, duration, lies)
    reach = leg.reach(how.knee) if up is None else up.reach
    stretched = leg.angles(leg.knee(reach), how.tilt)
    supports = [
        *(() if up is None else up.supports),
        *_seats(human, tucked, at.seat_off, lain=up is not None),
        *_heels_and_hands(human, hip, hip + reach, lies or how, at),
    ]
    stances = tuple(Stance(feet[s], at.down[s], at.down[s], end, end, end) for s in SIDES)
    lifted = posture(
        human, feet, hip=(ankle - 0.11 * human.height, floor + 0.06 * human.height), tilt=-0.4,
        joints={**arms, **bent(human, -0.5)},
    )  # fmt: skip
    squat = posture(
        human, feet, hip=(ankle - 0.10 * human.height, 0.26 * human.height), tilt=-0.6,
        joints=bent(human, -0.3),
    )  # fmt: skip
    long = with_limbs(human, tucked, {first: stretched, second: stretched})
    one_in = with_limbs(human, tucked, {second: stretched})
    keys = [
        *(() if up is None else up.keys),
        (begun, long),
        (at.off[first], long),
        ((at.off[first] + at.down[first]) / 2, with_limbs(human, long, {first: DRAWN_IN})),
        (at.down[first], one_in),
        (at.off[second], one_in),
        ((at.off[second] + at.down[second]) / 2, with_limbs(human, tucked, {second: DRAWN_IN})),
        (at.down[second], tucked),
        (at.seat_off, (tucked + lifted) / 2),
        (at.hands_off, lifted),
        ((at.hands_off + duration) / 2, squat),
        (duration, standing_on(human, feet)),
    ]
    times, postures = zip(*keys, strict=True)
    plan = ContactPlan(duration, stances)
    return plan, tuple(supports), tuple(map(float, times)), np.array(postures), at.seat_off


def _seats(
    human: Human, q: Float[Array, " nv"], stop: float, *, lain: bool
) -> Iterator[PointSupport]:
    """Yield the supports of the pelvis in sitting, to which it has rolled if the person lay."""
    sites = [limb_site(human, f"{BUTTOCK_PART}_{s}") for s in SIDES] if lain else seat_sites(human)
    for site in sites:
        pitch = LYING_PITCHES.get(site.part, 0.0)
        x, y, _ = resting_place(human, site, q, pitch)
        yield PointSupport(site, (x, y, 0.0), -1.0, stop, pitch=pitch)


def _heels_and_hands(
    human: Human, hip: float, heels: float, how: SittingOnFloor | LyingOnBack, at: _Times
) -> Iterator[PointSupport]:
    """Yield the supports of heels and hands.

    Args:
        hip: Hips along x [m].
        heels: Heels along x [m].
    """
    feet = turned_out(human)
    for side, left in (("r", -1.0), ("l", 1.0)):
        place = (heels, feet[side].position[1] + left * human.dimensions.ankle_height, 0.0)
        site, pitch = limb_site(human, f"{HEEL_PART}_{side}"), LYING_PITCHES[HEEL_PART]
        yield PointSupport(site, place, -1.0, at.off[side], pitch=pitch)
        palm = (
            hip - how.hands_behind * human.height, left * how.hands_aside * human.height, 0.0
        )  # fmt: skip
        yield PointSupport(
            limb_site(human, f"hand_{side}", on_ground=True), palm, -1.0, at.hands_off
        )
