"""Getting up from the floor: from kneeling on one knee, without hands, to standing."""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.limb_sites import KNEELING_PITCH, limb_site
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
from plantigrade.trajopt.terms.posture import Posture

KNEE_OFF = 0.37  # [1] when the knee leaves the floor, of the duration. Estimate.
TOE_OFF, STRIKE = 0.63, 0.80  # [1] when the foot behind leaves and lands beside. Estimate.
FOREFOOT_OFF = 0.05  # [s] ball off before the toes
TOES_BACK = float(np.deg2rad(12.6))  # [rad] slope of a shank on its toes, ankle above the knee
HABITS = {
    **dict.fromkeys(("pelvis_list", "lumbar_bending", "lumbar_rotation"), 2.0),
    **dict.fromkeys(("thorax_bending", "thorax_rotation"), 2.0),
    **dict.fromkeys(("arm_flex", "elbow_flex"), 0.3),
}
"""Weights of angles away from zero [1/(s rad²)]: trunk and pelvis do not bend aside. Chosen."""


def get_up(human: Human, parameters: GetUp) -> MotionTask:
    """Return the task of getting up from kneeling on one knee, toes of that leg on the floor.

    Raises:
        ParameterError: If there is too little time, or feet have no toes to kneel on.
    """
    if f"mtp_angle_{parameters.side}" not in human.coordinates:
        raise ParameterError("toes of rigid feet cannot bend in kneeling: take feet='two-segment'")
    duration, front = parameters.duration, parameters.side
    rear = "l" if front == "r" else "r"
    feet, end = standing_feet(human), duration + 1.0
    knee_off, toe_off, strike = (share * duration for share in (KNEE_OFF, TOE_OFF, STRIKE))
    x, _, _ = feet[front].position
    _, aside, _ = feet[rear].position
    knee = (x - human.dimensions.thigh, aside, 0.0)
    behind = toes_behind(human, rear, knee)
    stances = (
        Stance(feet[front], -1.0, -1.0, end, end, end),
        Stance(behind, -1.0, -1.0, -1.0, toe_off - FOREFOOT_OFF, toe_off),
        Stance(feet[rear], strike, strike, end, end, end),
    )
    site = limb_site(human, f"knee_{rear}")
    support = PointSupport(site, knee, -1.0, knee_off, pitch=KNEELING_PITCH)
    plan = ContactPlan(duration, stances)
    standing = standing_posture(human)
    times, postures = _keys(human, front, knee, parameters)
    on_knee = replace(plan, supports=(support,))
    kneeling = resting(ContactBody.for_plan(human, on_knee), on_knee, np.zeros(1), postures[:1])[0]
    rise = float(standing[4] - kneeling[4])
    check_time(human, duration * (1.0 - KNEE_OFF), rise, "to get up")
    terms = (
        *basics(human),
        *at_rest(human, 0.0, kneeling),
        *at_rest(human, duration, standing),
        Clearance(),
        Posture(HABITS),
    )
    guess = Interpolated(times, (kneeling, *postures[1:]))
    return with_supports(MotionTask("get-up", plan, terms, guess), (support,))


def toes_behind(human: Human, side: str, knee: tuple[float, float, float]) -> Footprint:
    """Return the footprint of a foot on whose toes a leg kneels, its knee at a place."""
    q = standing_posture(human)
    q[6 + human.hinge(f"knee_angle_{side}")] = KNEELING_PITCH + TOES_BACK
    for name in ("ankle_angle", "mtp_angle"):
        if f"{name}_{side}" in human.coordinates:
            q[6 + human.hinge(f"{name}_{side}")] = KNEELING[name]
    qpos = human.from_coordinates(PELVIS + human.coordinates, q[None])[0]
    sites = foot_sites(human)
    toe = next(s for s in sites if s.side == side and s.part == "toe")
    places = State(human, qpos).position(SitePoints(human, (limb_site(human, f"knee_{side}"), toe)))
    x, y, _ = places[1] - places[0] + knee - flat_sites(human, sites, side)[toe.name]
    return Footprint(side, (float(x), float(knee[1]), 0.0))


def _keys(
    human: Human, front: str, knee: tuple[float, float, float], parameters: GetUp
) -> tuple[tuple[float, ...], Float[Array, "n nv"]]:
    """Return times and postures that a guess starts from, legs only near to where they rest."""
    rear = "l" if front == "r" else "r"
    standing, duration, d = standing_posture(human), parameters.duration, human.dimensions

    def bent(back: float, down: float, **angles: float) -> Array:
        q = standing.copy()
        q[3:6] += np.array([-back, 0.0, -down]) @ OPENSIM_TO_WORLD
        for name, angle in angles.items():
            leg = {"front": front, "rear": rear}[name.partition("_")[0]]
            full = f"{name.partition('_')[2]}_{leg}"
            if full in human.coordinates:
                q[6 + human.hinge(full)] = angle
        return q

    low = d.ankle_height + d.shank - limb_site(human, f"knee_{rear}").radius
    ahead = -knee[0]
    kneel = bent(
        ahead, low, rear_knee_angle=KNEELING_PITCH + 0.17, rear_ankle_angle=KNEELING["ankle_angle"],
        rear_mtp_angle=KNEELING["mtp_angle"], front_knee_angle=1.65, front_hip_flexion=1.5,
        front_ankle_angle=0.1,
    )  # fmt: skip
    lunge = bent(
        0.4 * ahead, 0.25 * low, rear_knee_angle=1.2, rear_hip_flexion=-0.1, rear_ankle_angle=0.2,
        rear_mtp_angle=0.9, front_knee_angle=1.0, front_hip_flexion=1.0,
    )  # fmt: skip
    push = bent(
        0.0, 0.06 * human.height, rear_knee_angle=1.1, rear_mtp_angle=0.9,
        front_knee_angle=0.6, front_hip_flexion=0.6,
    )  # fmt: skip
    swing = bent(0.0, 0.0, rear_knee_angle=1.0, rear_hip_flexion=0.5)
    land = bent(0.0, 0.02 * human.height, **{
        f"{leg}_{name}": 0.3 if name == "knee_angle" else 0.15
        for leg in ("front", "rear") for name in ("knee_angle", "hip_flexion", "ankle_angle")
    })  # fmt: skip
    shares = (0.0, 0.27, 0.5, TOE_OFF, (TOE_OFF + STRIKE) / 2, STRIKE, 1.0)
    times = tuple(float(share * duration) for share in shares)
    return times, np.array([kneel, kneel, lunge, push, swing, land, standing])
