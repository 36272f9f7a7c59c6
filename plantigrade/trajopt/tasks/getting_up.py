"""Getting up from the floor: from hands and knees over one knee, or from one knee, to standing.

From hands and knees one foot comes forward between the hands, which then leave the floor; the foot
behind pushes off the floor with its toes and is put down beside the other. Where and when things
rest is given; forces, torques and the motion are computed.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import word
from plantigrade.constants import SIDES
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.limb_sites import BALL, KNEELING_PITCH, limb_site
from plantigrade.contact.plan import ContactPlan, Footprint, PointSupport, Stance
from plantigrade.contact.site import foot_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD, PELVIS
from plantigrade.trajopt.guess.in_contact import KNEELING, Interpolated, resting
from plantigrade.trajopt.guess.postures import standing_feet, standing_posture
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.tasks.mechanics import check_time
from plantigrade.trajopt.tasks.settings import GetUp
from plantigrade.trajopt.tasks.standing import at_rest, basics
from plantigrade.trajopt.tasks.supported import with_supports
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import Clearance
from plantigrade.trajopt.terms.posture import Posture, PostureAt, Quiet, Rest

FOREFOOT_OFF = 0.05  # [s] ball off before the toes
TOES_GAP = 0.1  # [s] time in which toes come from their inner edge to lie flat
TOES_BACK = float(np.deg2rad(12.6))  # [rad] slope of a shank on its toes, ankle above the knee
STRIDE = 1.25  # [thigh] front foot ahead of the rear knee with both hands on the floor. Estimate.
HANDS_AHEAD = 0.34  # [stature] palms ahead of the knees on hands and knees. Estimate.
HANDS_ASIDE = 0.145  # [stature] palms from the middle; the foot passes between. Estimate.
HABITS = {
    **dict.fromkeys(("pelvis_list", "lumbar_bending", "lumbar_rotation"), 2.0),
    **dict.fromkeys(("thorax_bending", "thorax_rotation"), 2.0),
    **dict.fromkeys(("arm_flex", "elbow_flex"), 0.3),
}
"""Weights of angles away from zero [1/(s rad²)]: trunk and pelvis do not bend aside. Chosen."""


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


HALF_KNEELING_DURATION, ALL_FOURS_DURATION = 3.0, 6.0  # [s] where none is given. Chosen.
_HALF_KNEELING = _Times(-1.0, -1.0, -1.0, 0.37, 0.63, 0.80)  # [1] of the duration. Estimate.
_ALL_FOURS = _Times(0.10, 0.27, 0.40, 0.54, 0.71, 0.86)  # [1] of the duration. Estimate.


def get_up(human: Human, parameters: GetUp) -> MotionTask:
    """Return the task of getting up from hands and knees, or from one knee.

    Toes of a leg that kneels are on the floor.

    Raises:
        ParameterError: If there is too little time, or feet have no toes to kneel on.
    """
    word("begin", parameters.begin, ("half-kneeling", "all-fours"))
    front = parameters.side
    if f"mtp_angle_{front}" not in human.coordinates:
        raise ParameterError("toes of rigid feet cannot bend in kneeling: take feet='two-segment'")
    fours = parameters.begin == "all-fours"
    usual = ALL_FOURS_DURATION if fours else HALF_KNEELING_DURATION
    duration = parameters.duration or usual
    at = (_ALL_FOURS if fours else _HALF_KNEELING).lasting(duration)
    plan, supports = _plan(human, front, at, hands=fours)
    standing = standing_posture(human)
    times, postures = _keys(human, front, at)
    begun = ContactPlan(duration, plan.stances, supports=supports)
    start = resting(ContactBody.for_plan(human, begun), begun, np.zeros(1), postures[:1])[0]
    check_time(human, duration - at.knee_off, float(standing[4] - start[4]), "to get up")
    terms = (
        *basics(human),
        Rest(0.0),
        Quiet(0.0),
        PostureAt(0.0, tuple(map(float, start))),
        *at_rest(human, duration, standing),
        Clearance(),
        Posture(HABITS),
    )
    guess = Interpolated(times, (start, *postures[1:]))
    return with_supports(MotionTask("get-up", plan, terms, guess), supports)


def _plan(
    human: Human, front: str, at: _Times, *, hands: bool
) -> tuple[ContactPlan, tuple[PointSupport, ...]]:
    """Return the stances of the feet, and what else rests on the floor."""
    rear, feet, end = _other(front), standing_feet(human), at.duration + 1.0
    x = feet[front].position[0] - (STRIDE if hands else 1.0) * human.dimensions.thigh
    knees = {side: (x, feet[side].position[1], 0.0) for side in SIDES}

    def kneels(side: str, until: float) -> PointSupport:
        site = limb_site(human, f"knee_{side}")
        return PointSupport(site, knees[side], -1.0, until, pitch=KNEELING_PITCH)

    toes = toes_behind(human, rear, knees[rear])
    flat = -1.0 if at.front_off < 0.0 else at.hands_off
    stances = [
        Stance(
            _footprint(human, rear, toes), flat, flat, flat, at.toes_off - FOREFOOT_OFF, at.toes_off
        ),
        Stance(feet[front], at.front_down, at.front_down, end, end, end),
        Stance(feet[rear], at.strike, at.strike, end, end, end),
    ]
    supports = [kneels(rear, at.knee_off)]
    if hands:
        supports.append(kneels(front, at.front_off))
        supports.append(PointSupport(limb_site(human, f"toes_{rear}"), toes, -1.0, flat - TOES_GAP))
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
    for name in ("ankle_angle", "mtp_angle"):
        q[6 + human.hinge(f"{name}_{side}")] = KNEELING[name]
    qpos = human.from_coordinates(PELVIS + human.coordinates, q[None])[0]
    parts = tuple(limb_site(human, f"{part}_{side}") for part in ("knee", "toes"))
    places = State(human, qpos).position(SitePoints(human, parts))
    x, y, _ = places[1] - places[0] + knee
    return float(x), float(y), 0.0


def _footprint(human: Human, side: str, toes: tuple[float, float, float]) -> Footprint:
    """Return the footprint of a foot whose ball is at a place [m]."""
    ball = flat_sites(human, foot_sites(human), side)[f"{BALL}_{side}"]
    return Footprint(side, (toes[0] - float(ball[0]), toes[1] - float(ball[1]), 0.0))


def _keys(human: Human, front: str, at: _Times) -> tuple[tuple[float, ...], Float[Array, "n nv"]]:
    """Return times and postures that a guess starts from, legs only near to where they rest."""
    rear, d = _other(front), human.dimensions
    low = d.ankle_height + d.shank - limb_site(human, f"knee_{rear}").radius
    crawling = {**KNEELING, "hip_flexion": 1.5, "knee_angle": KNEELING["knee_angle"] - 0.1}
    trunk = {
        "pelvis_tilt": -1.45, "neck_extension": 0.5, "arm_flex": 1.75, "wrist_flex": -1.15,
        "pro_sup": 2.8, "elbow_flex": 0.1,
    }  # fmt: skip
    ahead = {"knee_angle": 1.65, "hip_flexion": 1.5, "ankle_angle": 0.1}
    down = {"knee_angle": 0.3, "hip_flexion": 0.15, "ankle_angle": 0.15}

    def bent(
        back: float, by: float, rear_leg: Mapping[str, float], front_leg: Mapping[str, float],
        others: Mapping[str, float] | None = None,
    ) -> Array:  # fmt: skip
        q = standing_posture(human)
        q[3:6] += np.array([-back * d.thigh, 0.0, -by]) @ OPENSIM_TO_WORLD
        named = {f"{n}_{side}": v for n, v in (others or {}).items() for side in SIDES}
        named |= {f"{n}_{rear}": v for n, v in rear_leg.items()}
        named |= {f"{n}_{front}": v for n, v in front_leg.items()} | dict(others or {})
        for i, name in enumerate(PELVIS + human.coordinates):
            q[i] = named.get(name, q[i])
        return q

    keys: list[tuple[float, Array]] = []
    late = STRIDE - 1.0 if at.front_off > 0.0 else 0.0  # the foot behind is farther behind
    if at.front_off > 0.0:
        instep = {**crawling, "ankle_angle": -0.95, "mtp_angle": 0.0, "hip_rotation": 0.15}
        fours = bent(STRIDE, low, crawling, instep, trunk)
        folded = {**trunk, "pelvis_tilt": -1.0, "lumbar_extension": -0.6, "elbow_flex": 0.3}
        tucked = {
            "knee_angle": 2.2, "hip_flexion": 2.0, "ankle_angle": 0.2, "hip_adduction": -0.2,
            "hip_rotation": 0.15,
        }  # fmt: skip
        through = bent(0.95, low, {**crawling, "hip_flexion": 1.0}, tucked, folded)
        lunge = {"knee_angle": 1.9, "hip_flexion": 2.1, "ankle_angle": 0.2}
        astride = bent(0.65, low + 0.04, {**KNEELING, "hip_flexion": 0.3}, lunge, folded)
        upright = {"pelvis_tilt": -0.5, "arm_flex": 0.4}
        keys = [
            (0.0, fours),
            (at.front_off, fours),
            ((at.front_off + at.front_down) / 2, through),
            (at.front_down, astride),
            (at.hands_off, astride),
            ((at.hands_off + at.knee_off) / 2, bent(0.8, low, KNEELING, ahead, upright)),
        ]
    else:
        keys = [
            (time, bent(1.0, low, {**KNEELING, "hip_flexion": 0.0}, ahead))
            for time in (0.0, 0.73 * at.knee_off)
        ]
    keys += [
        (
            (at.knee_off + at.toes_off) / 2,
            bent(
                0.4 + late, 0.25 * low,
                {"knee_angle": 1.2, "hip_flexion": -0.1, "ankle_angle": 0.2, "mtp_angle": 0.9},
                {"knee_angle": 1.0, "hip_flexion": 1.0},
            ),
        ),
        (
            at.toes_off,
            bent(
                late, 0.06 * human.height, {"knee_angle": 1.1, "mtp_angle": 0.9},
                {"knee_angle": 0.6, "hip_flexion": 0.6},
            ),
        ),
        (
            (at.toes_off + at.strike) / 2,
            bent(late / 2, 0.0, {"knee_angle": 1.2, "hip_flexion": 0.3}, {}),
        ),
        (at.strike, bent(0.0, 0.02 * human.height, down, down)),
        (at.duration, standing_posture(human)),
    ]  # fmt: skip
    times, postures = zip(*keys, strict=True)
    return tuple(map(float, times)), np.array(postures)


def _other(side: str) -> str:
    return "l" if side == "r" else "r"
