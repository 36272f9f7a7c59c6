"""Getting up from the floor: from hands and knees, from one knee, from sitting, or from lying.

From hands and knees one foot comes forward between the hands, which then leave the floor; the foot
behind pushes off the floor with its toes and is put down beside the other. From sitting both feet
are drawn in (:mod:`~plantigrade.trajopt.tasks.sitting_on_floor`); a person who lies on the back
first sits up (:mod:`~plantigrade.trajopt.tasks.lying_on_back`). Where and when things rest is
given; forces, torques and the motion are computed.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import word
from plantigrade.constants import SIDES
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.limb_sites import BALL, KNEELING_PITCH, TOES_PART, limb_site
from plantigrade.contact.plan import ContactPlan, Footprint, PointSupport, Stance
from plantigrade.contact.site import foot_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.models import Human
from plantigrade.side_names import opposite
from plantigrade.trajopt.guess.foot_motion import with_toes
from plantigrade.trajopt.guess.in_contact import KNEELING, Interpolated, resting
from plantigrade.trajopt.guess.postures import body_at, standing_feet, standing_posture
from plantigrade.trajopt.guess.rising import RisingPostures
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.tasks.lying_on_back import STRAIGHT, LyingOnBack
from plantigrade.trajopt.tasks.mechanics import check_time
from plantigrade.trajopt.tasks.settings import GetUpSettings
from plantigrade.trajopt.tasks.sitting_on_floor import from_sitting
from plantigrade.trajopt.tasks.standing import at_rest, basics
from plantigrade.trajopt.tasks.supported import with_supports
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import Clearance
from plantigrade.trajopt.terms.posture import (
    LumbopelvicRhythm,
    Posture,
    PostureAt,
    Quiet,
    Rest,
    Upright,
)
from plantigrade.trajopt.terms.term import Term

FOREFOOT_OFF = 0.05  # [s] ball off before the toes
TOES_GAP = 0.1  # [s] time in which toes come from their inner edge to lie flat
TOES_BACK = float(np.deg2rad(12.6))  # [rad] slope of a shank on its toes, ankle above the knee
STRIDE = 1.25  # [thigh] front foot ahead of the rear knee with both hands on the floor. Estimate.
HANDS_AHEAD = 0.34  # [stature] palms ahead of the knees on hands and knees. Estimate.
HANDS_ASIDE = 0.145  # [stature] palms from the middle; the foot passes between. Estimate.
KNEELS_UNTIL = 0.73  # [1] of the time on one knee that the guess stays upright. Chosen.
TRUNK_WEIGHT = 5.0  # [1/s] weight of a trunk that does not lean aside. Chosen.
HEAD_WEIGHT = 1.0  # [1/s] weight of a head that does not lean aside, as in lifting. Chosen.
HABITS = {
    **dict.fromkeys(("pelvis_list", "lumbar_bending", "lumbar_rotation"), 2.0),
    **dict.fromkeys(("thorax_bending", "thorax_rotation"), 2.0),
    **dict.fromkeys(("arm_flex", "elbow_flex"), 0.3),
    **dict.fromkeys(("heel_angle", "heel_inversion", "heel_adduction"), 1.5),
}
"""Weights of angles away from zero [1/(s rad²)]: trunk and pelvis do not bend aside. Chosen. They
are angles between bones, and a trunk that leans with its pelvis costs nothing: without the costs of
lean, trunk and head pass the front knee aside, 26 and 57° off the vertical. A heel bone on which a
lying leg rests would wriggle by 6 mm."""

BACK_IN_LYING = dict.fromkeys(
    ("lumbar_extension", "lower_thorax_extension", "thorax_extension"), 0.3
)
"""Weights of the back away from standing for those who lie at first [1/(s rad²)]. Chosen: with the
rhythm of back and hips the lumbar joint flexes by 71° as the hands leave the floor behind them."""


@dataclass(frozen=True)
class _Times:
    """When contacts change [s]."""

    front_off: float  #: Front knee and toes leave; below zero from one knee
    front_down: float  #: The front foot lands
    hands_off: float
    knee_off: float  #: The rear knee leaves
    toes_off: float
    strike: float  #: The rear foot lands beside the other
    duration: float = 1.0

    def lasting(self, duration: float) -> "_Times":
        """Return shares of a duration as times."""
        return _Times(**{f.name: duration * getattr(self, f.name) for f in fields(self)})


DURATIONS = {"half-kneeling": 3.0, "all-fours": 6.0, "sitting": 5.0, "lying": 6.0}
"""Duration from a posture on the floor where none is given [s]. Chosen."""
FROM = {"all-fours": "hands and knees", "sitting": "sitting", "lying": "lying"}
"""Posture from which a person rises on the palms → its name in messages."""
_HALF_KNEELING = _Times(-1.0, -1.0, -1.0, 0.37, 0.63, 0.80)  # [1] of the duration. Estimate.
_ALL_FOURS = _Times(0.10, 0.27, 0.40, 0.54, 0.71, 0.86)  # [1] of the duration. Estimate.


def get_up(human: Human, parameters: GetUpSettings) -> MotionTask:
    """Return the task of getting up from hands and knees, one knee, sitting or lying.

    Toes of a leg that kneels are on the floor.

    Raises:
        ParameterError: If there is too little time, feet have no toes to kneel on, or hands no
            wrists to rest on.
    """
    word("begin", parameters.begin, tuple(DURATIONS))
    _require_wrists(human, parameters.begin)
    duration = parameters.duration or DURATIONS[parameters.begin]
    lies = LyingOnBack() if parameters.begin == "lying" else None
    if lies is not None or parameters.begin == "sitting":
        made = from_sitting(human, parameters.side, duration, lies)
    else:
        made = _from_knees(human, parameters.side, duration, hands=parameters.begin == "all-fours")
    plan, supports, times, postures, rises = made
    standing = postures[-1]
    begun = ContactPlan(duration, plan.stances, supports=supports)
    start = resting(ContactBody.for_plan(human, begun), begun, np.zeros(1), postures[:1])[0]
    check_time(human, duration - rises, float(standing[4] - start[4]), "to get up")
    terms = (
        *(basics(human) if lies is None else _without_rhythm(basics(human))),
        Rest(0.0),
        Quiet(0.0),
        PostureAt(0.0, tuple(map(float, start))),
        *at_rest(human, duration, standing),
        Clearance(),
        Posture(HABITS),
        Upright("trunk", sideways=TRUNK_WEIGHT),
        Upright("head", sideways=HEAD_WEIGHT),
    )
    if lies is not None:
        terms = (*terms, Posture(STRAIGHT, stop=lies.sits * duration))
    guess = Interpolated(times, (start, *postures[1:]))
    return with_supports(MotionTask("get-up", plan, terms, guess), supports)


def _require_wrists(human: Human, begin: str) -> None:
    """Raise for a rise on the palms of hands that do not bend: their fingers would be in the floor.

    Raises:
        ParameterError: If so.
    """
    if begin != "half-kneeling" and "wrist_flex_r" not in human.coordinates:
        raise ParameterError(
            f"a skeleton of {human.model.nv} coordinates has no wrists, and its palms cannot lie "
            f"on the floor, as they do in rising from {FROM[begin]}: take joints='43' or another "
            "with wrists, or begin='half-kneeling'"
        )


def _without_rhythm(terms: tuple[Term, ...]) -> Iterator[Term]:
    """Yield terms in which the back does not follow the hips."""
    for term in terms:
        if isinstance(term, Posture):
            yield replace(term, weights={**term.weights, **BACK_IN_LYING})
        elif not isinstance(term, LumbopelvicRhythm):
            yield term


def _from_knees(
    human: Human, front: str, duration: float, *, hands: bool
) -> tuple[ContactPlan, tuple[PointSupport, ...], tuple[float, ...], Float[Array, "n nv"], float]:
    """Return the plan of the feet, other supports, times, postures and when the rise begins [s].

    Raises:
        ParameterError: If feet have no toes to kneel on.
    """
    if f"mtp_angle_{front}" not in human.coordinates:
        raise ParameterError("toes of rigid feet cannot bend in kneeling: take feet='two-segment'")
    at = (_ALL_FOURS if hands else _HALF_KNEELING).lasting(duration)
    plan, supports = _plan(human, front, at, hands=hands)
    return plan, supports, *_keys(human, front, at), at.knee_off


def _plan(
    human: Human, front: str, at: _Times, *, hands: bool
) -> tuple[ContactPlan, tuple[PointSupport, ...]]:
    """Return the stances of the feet, and what else rests on the floor."""
    rear, feet, end = opposite(front), standing_feet(human), at.duration + 1.0
    x = feet[front].position[0] - (STRIDE if hands else 1.0) * human.dimensions.thigh
    knees = {side: (x, feet[side].position[1], 0.0) for side in SIDES}

    def kneels(side: str, until: float) -> PointSupport:
        site = limb_site(human, f"knee_{side}")
        return PointSupport(site, knees[side], -1.0, until, pitch=KNEELING_PITCH)

    toes = toes_behind(human, rear, knees[rear])
    medial = human.feet == "multi-segment"
    flat = -1.0 if medial or at.front_off < 0.0 else at.hands_off
    stances = [
        Stance(feet[front], at.front_down, at.front_down, end, end, end),
        Stance(feet[rear], at.strike, at.strike, end, end, end),
    ]
    supports = [kneels(rear, at.knee_off)]
    footprint, ball_off = _footprint(human, rear, toes), at.toes_off - FOREFOOT_OFF
    if medial:
        supports += _on_medial_toes(human, footprint, flat, ball_off, at.toes_off)
    else:
        stances.insert(0, Stance(footprint, flat, flat, flat, ball_off, at.toes_off))
    if hands:
        supports.append(kneels(front, at.front_off))
        if not medial:  # first on the inner edge
            edge = limb_site(human, f"toes_{rear}")
            supports.append(PointSupport(edge, toes, -1.0, flat - TOES_GAP))
        for side, left in (("r", -1.0), ("l", 1.0)):
            palm = (x + HANDS_AHEAD * human.height, left * HANDS_ASIDE * human.height, 0.0)
            site = limb_site(human, f"hand_{side}", on_ground=True)
            supports.append(PointSupport(site, palm, -1.0, at.hands_off))
    return ContactPlan(at.duration, tuple(stances)), tuple(supports)


def toes_behind(
    human: Human, side: str, knee: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return where the toes of a leg rest that kneels on them, its knee at a place [m]."""
    q = standing_posture(human)
    q[6 + human.hinge(f"knee_angle_{side}")] = KNEELING_PITCH + TOES_BACK
    foot = {name: KNEELING[name] for name in ("ankle_angle", "mtp_angle")}
    for name, angle in with_toes(human, foot).items():
        q[6 + human.hinge(f"{name}_{side}")] = angle
    parts = tuple(limb_site(human, f"{part}_{side}") for part in ("knee", "toes"))
    places = body_at(human, q).position(SitePoints(human, parts))
    x, y, _ = places[1] - places[0] + knee
    return float(x), float(y), 0.0


def _on_medial_toes(
    human: Human, footprint: Footprint, start: float, ball_off: float, stop: float
) -> Iterator[PointSupport]:
    """Yield the supports of the medial toes, on which a leg with a multi-segment foot kneels.

    The lateral toes carry nothing: their metatarsals are shorter, and to lie flat beside medial
    toes that bend by 60° they would have to bend by 80°, more than they can.

    Args:
        start: When they begin to rest on the floor [s].
        ball_off: When the ball leaves it [s].
        stop: When the toes leave it [s].
    """
    sites = foot_sites(human)
    segment = next(s.body for s in sites if s.name == f"{BALL}_{footprint.side}")
    targets = flat_sites(human, sites, footprint.side)
    for site in (s for s in sites if s.body == segment):
        place = np.add(footprint.position, targets[site.name])
        free = replace(site, side="", part=TOES_PART, name=f"{TOES_PART}_{site.name}")
        until = ball_off if site.part == "ball" else stop
        yield PointSupport(free, (float(place[0]), float(place[1]), 0.0), start, until)


def _footprint(human: Human, side: str, toes: tuple[float, float, float]) -> Footprint:
    """Return the footprint of a foot whose ball is at a place [m]."""
    ball = flat_sites(human, foot_sites(human), side)[f"{BALL}_{side}"]
    return Footprint(side, (toes[0] - float(ball[0]), toes[1] - float(ball[1]), 0.0))


def _keys(human: Human, front: str, at: _Times) -> tuple[tuple[float, ...], Float[Array, "n nv"]]:
    """Return times and postures that a guess starts from, legs only near to where they rest."""
    p, hands = RisingPostures(), at.front_off > 0.0
    rising = [
        ((at.knee_off + at.toes_off) / 2, p.pushing),
        (at.toes_off, p.toe_off),
        ((at.toes_off + at.strike) / 2, p.swing),
        (at.strike, p.strike),
    ]
    if hands:
        rising[:2] = [(time, replace(k, back=k.back + STRIDE - 1.0)) for time, k in rising[:2]]
        rising[2] = (rising[2][0], replace(p.swing, back=(STRIDE - 1.0) / 2))
        first = [
            (0.0, p.all_fours),
            (at.front_off, p.all_fours),
            ((at.front_off + at.front_down) / 2, p.foot_through),
            (at.front_down, p.astride),
            (at.hands_off, p.astride),
            ((at.hands_off + at.knee_off) / 2, p.upright),
        ]
    else:
        first = [(0.0, p.half_kneeling), (KNEELS_UNTIL * at.knee_off, p.half_kneeling)]
    times, keys = zip(*first, *rising, strict=True)
    postures = [k.coordinates(human, front) for k in keys] + [standing_posture(human)]
    return (*map(float, times), at.duration), np.array(postures)
