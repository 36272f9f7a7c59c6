r"""Walking as a task: periodic, or from standing to standing; straight, turning, up and down.

What a walk costs is the same at every speed, for every person and every foot:

- torques of muscles squared (Eq. 15 of [Zhakatayev2023]_), the ankle's at a fifth: what a muscle
  costs goes with the volume of it that is active, and short fibres on a long tendon make the
  ankle's torque cheaper than the knee's or the hip's [Griffin2003]_;
- work of muscles, positive and negative alike;
- jerk, which keeps the spline quiet between nodes;
- rates of contact forces;
- trunk and head away from upright, arms away from hanging: weakly, and the legs not at all.

The relations between these weights were settled while looking at norms of walking at free speed
([Schwartz2008]_); no recording and no norm is in the problem.
"""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array
from plantigrade.contact.plan import ContactPlan
from plantigrade.models import Human
from plantigrade.synthesize.guess.walk import walking_guess
from plantigrade.synthesize.problem.contact_body import ContactBody
from plantigrade.synthesize.tasks.gait_parameters import GaitParameters, gait_parameters
from plantigrade.synthesize.tasks.settings import Walk
from plantigrade.synthesize.tasks.task import MotionTask
from plantigrade.synthesize.tasks.walking_plan import periodic_walk_plan, walk_plan
from plantigrade.synthesize.terms.contact import Clearance, Contact, Dynamics, Forces
from plantigrade.synthesize.terms.effort import Jerk, Torque, Work
from plantigrade.synthesize.terms.limits import Limits
from plantigrade.synthesize.terms.posture import Posture, PostureAt, Quiet, Rest
from plantigrade.synthesize.terms.term import Term

ANKLE = 0.2  # what torque of the ankle costs beside that of other joints
UPRIGHT = {
    "pelvis_tilt": 3.0,
    "pelvis_list": 3.0,
    "pelvis_rotation": 3.0,
    "lumbar_extension": 0.5,
    "lumbar_bending": 1.0,
    "lumbar_rotation": 0.5,
    "thorax_extension": 0.5,
    "thorax_bending": 1.0,
    "thorax_rotation": 0.5,
    "neck_extension": 0.3,
    "neck_bending": 0.3,
    "neck_rotation": 0.3,
    "arm_flex": 0.05,
    "arm_add": 0.5,
    "arm_rot": 0.2,
    "elbow_flex": 0.05,
    "pro_sup": 0.1,
    "wrist_flex": 0.1,
    "wrist_dev": 0.1,
    "fingers_flex": 0.1,
}
"""What it costs to be bent [1/(s rad²)]: trunk and head upright, arms hanging."""

HANGING = {"elbow_flex": 0.35}
"""Postures that are not zero [rad]."""

CLEARANCE = 0.01  # of everything on a foot in the middle of a swing [m]
NODES_PER_SECOND = {True: 60.0, False: 20.0}
"""Nodes a second up to :data:`USUAL` speed, periodic and from standing; in proportion above it."""

USUAL = 1.3
"""Speed [m/s]."""


def walking_terms(slope: float = 0.0) -> tuple[Term, ...]:
    """Return conditions and costs of every walk.

    Args:
        slope: Of the ground [rad]: upright is as far from its normal.
    """
    return (
        Dynamics(),
        Contact(),
        Clearance(CLEARANCE),
        Limits(),
        Torque(1.0, {"ankle_angle": ANKLE}),
        Work(0.4),
        Jerk(3e-9),
        Forces(rate=5e-3),
        Posture(UPRIGHT, {**HANGING, "pelvis_tilt": -slope}),
    )


def walk(human: Human, told: Walk) -> MotionTask:
    """Return the task of walking.

    Raises:
        ParameterError: If a value is out of range for this person.
    """
    p = gait_parameters(human, told.speed, step_length=told.step_length, cadence=told.cadence)
    if told.periodic:
        return periodic_walk(human, p, slope=told.slope)
    heights = told.heights
    if told.step_height:
        heights = tuple(told.step_height * (k >= told.steps // 2) for k in range(told.steps))
    plan = walk_plan(human, p, steps=told.steps, turn=told.turn, heights=heights)
    plan = replace(plan, slope=told.slope)

    def guess_from_standing(body: ContactBody, plan: ContactPlan, times: Array) -> Array:
        return walking_guess(body.human, plan, p, times)

    ends = walking_guess(human, plan, p, np.array([0.0, plan.duration]))
    ends[:, 0] -= told.slope  # pelvis tilt: upright
    terms: list[Term] = [*walking_terms(told.slope)]
    for time, q in zip((0.0, plan.duration), ends, strict=True):
        terms += [Rest(time), Quiet(time, 1e-4), PostureAt(time, tuple(q))]
    faster = max(1.0, told.speed / USUAL)
    return MotionTask(
        "walk",
        plan,
        tuple(terms),
        guess_from_standing,
        nodes_per_second=NODES_PER_SECOND[False] * faster,
    )


def periodic_walk(human: Human, parameters: GaitParameters, *, slope: float = 0.0) -> MotionTask:
    """Return the task of a periodic walk, of which half a stride is solved.

    Args:
        human: The person.
        parameters: Lengths and times of the walk.
        slope: How far the ground rises along the way [rad].
    """
    plan = replace(periodic_walk_plan(human, parameters), slope=slope)

    def guess(body: ContactBody, plan: ContactPlan, times: Array) -> Array:
        return walking_guess(body.human, plan, parameters, times)

    return MotionTask(
        "walk",
        plan,
        walking_terms(slope),
        guess,
        nodes_per_second=NODES_PER_SECOND[True] * max(1.0, parameters.speed / USUAL),
    )
