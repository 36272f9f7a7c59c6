"""A step to the side: one foot, then the other, both landing flat."""

import numpy as np

from plantigrade.bounds import number
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.models import Human
from plantigrade.side_names import opposite
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD
from plantigrade.trajopt.guess.postures import KeyPostures, standing_feet, standing_posture
from plantigrade.trajopt.tasks.mechanics import check_support
from plantigrade.trajopt.tasks.settings import SideStepSettings
from plantigrade.trajopt.tasks.standing import at_rest, basics
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import Clearance
from plantigrade.trajopt.terms.effort import Work
from plantigrade.trajopt.terms.posture import Posture

PHASE_SHARES = (0.28, 0.17, 0.10, 0.17, 0.28)
"""Shares of the duration [1]: weight shift to the stance foot, first swing, double support, second
swing, and settling. In 2.4 s the swings take 0.4 s each, as in walking."""
_TRUNK = ("pelvis_list", "pelvis_tilt", "lumbar_bending", "thorax_bending", "lower_thorax_bending")
UPRIGHT_WEIGHTS = dict.fromkeys(_TRUNK, 5.0)  # [1/(s rad²)] weights of an upright trunk
# [1/(s rad²)] weight of arms that hang; without it both rise to 43° in front as counterweights
ARM_WEIGHT = 0.1
# [1/(s m²)] weight of the deviation of the pelvis height from standing
PELVIS_HEIGHT_WEIGHT = 300.0
MAX_STEP_LENGTH = 0.55  # [leg lengths] maximum step; about 20° of hip abduction each


def side_step(human: Human, parameters: SideStepSettings) -> MotionTask:
    """Return the task of a step to the side, from standing to standing.

    Raises:
        ParameterError: If the distance is out of range for this person, or there is too little
            time for it.
    """
    distance, side, duration, clearance = (
        parameters.distance,
        parameters.side,
        parameters.duration,
        parameters.clearance,
    )
    d = human.dimensions
    what = f"a side step of a person of {human.height:.2f} m"
    number("distance", distance, 0.02, MAX_STEP_LENGTH * (d.thigh + d.shank), "m", what)
    way = distance if side == "l" else -distance
    t = np.cumsum(PHASE_SHARES) * duration
    leave = {side: (t[0], t[1]), opposite(side): (t[2], t[3])}
    stances = []
    for foot, (off, strike) in leave.items():
        here = standing_feet(human)[foot]
        x, y, z = here.position
        there = Footprint(foot, (x, y + way, z), here.heading)
        end = duration + 1.0
        stances.append(Stance(here, -1.0, -1.0, off, off, off))
        stances.append(Stance(there, strike, strike, end, end, end))
    stances.sort(key=lambda s: s.heel_strike)
    plan = ContactPlan(duration, tuple(stances))
    check_support(human, plan)
    before = standing_posture(human)
    over = np.sign(way) * abs(standing_feet(human)["r"].position[1])

    def moved(left: float, up: float = -0.015 * human.height):
        out = before.copy()
        out[3:6] += np.array([0.0, left, up]) @ OPENSIM_TO_WORLD
        return out

    after = moved(way, 0.0)
    guess = KeyPostures(
        (0.0, float(t[0]), float((t[1] + t[2]) / 2), float(t[3]), duration),
        (before, moved(-0.7 * over), moved(way / 2), moved(way + 0.7 * over), after),
        lift=max(clearance, 0.03),
    )
    terms = (
        *basics(human),
        *at_rest(human, 0.0, before),
        *at_rest(human, duration, after),
        Clearance(clearance),
        Work(0.5),
        Posture(
            {**UPRIGHT_WEIGHTS, "arm_flex": ARM_WEIGHT, "pelvis_ty": PELVIS_HEIGHT_WEIGHT},
            {"pelvis_ty": float(before[4]) - 0.01},
        ),
    )
    return MotionTask("side-step", plan, terms, guess)
