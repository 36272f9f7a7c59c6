"""Walking backward: feet, and the first guess, as in walking forward with time reversed.

Angles of the joints of people who walk backward are nearly those of walking forward seen in
reversed time [Winter1989]_, [Lee2013]_: toes touch first, the heel leaves last. The forces are not
reversed, because muscles work where they braked; the optimiser finds them.
"""

from dataclasses import replace

from plantigrade.arrays import Array
from plantigrade.contact.plan import TIME_TOLERANCE, ContactPlan
from plantigrade.models import Human
from plantigrade.trajopt.guess.walk import walking_guess
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.tasks.gait_parameters import ball_off, gait_parameters
from plantigrade.trajopt.tasks.gait_settings import WalkBackwardSettings
from plantigrade.trajopt.tasks.mechanics import check_froude
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.walking import NODES_PER_SECOND, USUAL_SPEED, walking_terms
from plantigrade.trajopt.tasks.walking_plan import periodic_walk_plan

STEP_SHARE = 0.85
"""Step length relative to walking forward at the same speed [1]. Young people who are asked to turn
to walking backward shorten strides and keep their cadence [Laufer2005]_; at three quarters of the
speed that is this share (*estimate*)."""
HEEL_DOWN = 0.3  # [1] time of the heel's touchdown relative to stance, after the toes. Estimate.


def walk_backward(human: Human, parameters: WalkBackwardSettings) -> MotionTask:
    """Return the task of walking backward periodically, of which half a stride is solved.

    Raises:
        ParameterError: If a value is out of range for this person.
    """
    check_froude(human, parameters.speed)
    length, cadence = parameters.step_length, parameters.cadence
    if length is None and cadence is None:
        length = STEP_SHARE * gait_parameters(human, parameters.speed).step_length
    p = gait_parameters(human, parameters.speed, step_length=length, cadence=cadence)
    # seen forward in time, in which the heel leaves late
    heel_off = (1.0 - HEEL_DOWN) * p.stance_fraction
    forefoot_off = max(ball_off(p.stance_fraction, p.foot_flat), heel_off)
    p = replace(p, heel_off=heel_off, forefoot_off=forefoot_off)
    seen = periodic_walk_plan(human, p)
    about = next(s.toe_off for s in seen.stances if s.footprint.side == "r")

    def guess(body: ContactBody, plan: ContactPlan, times: Array) -> Array:
        return walking_guess(body.human, seen, p, about - times)

    rate = NODES_PER_SECOND[True] * max(1.0, parameters.speed / USUAL_SPEED)
    plan, terms = backward(seen, about), walking_terms(p.step_time)
    return MotionTask("walk-backward", plan, terms, guess, rate)


def backward(plan: ContactPlan, about: float) -> ContactPlan:
    """Return a periodic plan seen backward in time, at ``about`` less its times [s]."""
    every = sorted((s.reversed(about) for s in plan.unrolled()), key=lambda s: s.heel_strike)
    touching = tuple(
        s
        for s in every
        if s.heel_strike < plan.duration - TIME_TOLERANCE and s.toe_off > TIME_TOLERANCE
    )
    return replace(plan, stances=touching, advance=-plan.advance)
