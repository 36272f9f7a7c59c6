r"""Running as a task: periodic and straight, with flight between the steps.

Half a stride is solved, from the strike of the right foot to that of the left: one stance, then
flight. Lengths and times follow from the speed :math:`v`, by laws fitted to what is published of
runners on treadmills (*estimates*; 160 to 180 steps/min and contacts of 0.33 to 0.2 s from 2 to
5 m/s [Hamner2013]_); times are in proportion to the square root of the leg length. Under
another gravity the contact lasts as long, and the flight is scaled by the inverse root of gravity:
the vertical take-off speed of runners is proportional to the root of gravity, from the earth's down
to the moon's [Polet2018]_, and at 1.3 g steps are shorter mainly by the flight [Cavagna2005]_.

The cost is that of walking (:mod:`plantigrade.trajopt.tasks.walking`) with other weights: those of
ankle and knee are smaller, because tendons return a part of their work, and jerk is cheaper,
because everything happens in a third of the time. Rates of forces cost more: muscles take 50 to
100 ms to build up and to release force, so that the vertical force of a runner rises and falls as a
bell; without this cost it is flat, and the knee stays bent, as in a Groucho run [McMahon1987]_. The
foot need not be at rest when it touches the ground, and the knee is bent at strike, as that of
runners. The weights were set with one runner at 3 m/s in view [Hamner2013]_; the problem itself
contains no recording.
"""

import numpy as np

from plantigrade.bounds import number
from plantigrade.constants import GRAVITY
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.models import Human
from plantigrade.trajopt.guess.walk import crude_guess
from plantigrade.trajopt.tasks.gait_parameters import TOE_OUT
from plantigrade.trajopt.tasks.gait_settings import RunSettings
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.walking import STANDING_POSTURE, UPRIGHT_WEIGHTS
from plantigrade.trajopt.terms.contact import Clearance, Contact, Dynamics, Forces
from plantigrade.trajopt.terms.effort import Acceleration, Jerk, Torque, Work
from plantigrade.trajopt.terms.limits import Limits, Within
from plantigrade.trajopt.terms.momentum import AngularMomentum
from plantigrade.trajopt.terms.posture import Posture, Upright
from plantigrade.trajopt.terms.solid import SolidLimbs
from plantigrade.trajopt.terms.term import Term

REFERENCE_SPEED = 3.0  # [m/s] to which the following times belong
REFERENCE_LEG = 0.92  # [m] length of the leg to which they belong
CADENCE = 165.0  # [steps/min]
CADENCE_EXPONENT = 0.17  # [1] of the speed
CONTACT_TIME = 0.285  # [s] at the reference speed
CONTACT_SLOPE = -0.04  # [s per m/s] change with speed
MIN_FLIGHT_SHARE = 0.08  # [1] shortest flight relative to a step
STANCE_SHARES = (0.15, 0.5, 0.88)
"""Foot flat, heel off and ball off relative to the contact time [1]; heel strikers, estimates."""
STEP_WIDTH_SHARE = 0.065  # [leg lengths] half as wide as in walking
STRIKE_KNEE_FLEXION = float(np.deg2rad(15.0))  # [rad] least knee flexion at strike
MAX_JOINT_SPEED = 25.0  # [rad/s] joints of runners at 5 m/s turn at up to 20
USED_FRICTION = 0.5  # [1]
CLEARANCE = 0.02  # [m]
LEG_DISTANCE = 0.01  # [m]
TORQUE_WEIGHTS = {"ankle_angle": 0.6, "hip_adduction": 0.55, "knee_angle": 0.4}  # [1]
WORK_WEIGHT = 0.1  # [1]
JERK_WEIGHT = 4.5e-8  # divided by the sixth power of the step time [1/(s rad²)]
PELVIS_ACCELERATION_WEIGHT = 1.4e-4  # [s³/rad²]
FORCE_RATE_WEIGHT = 0.24  # multiplied by the square of the contact time [1/s]
PELVIS_TILT = -0.3  # [rad] of runners; 17° forward
ELBOW_FLEXION = float(np.deg2rad(90.0))  # [rad] of runners
BENDING_WEIGHTS = {"pelvis_list": 2.0, "lumbar_bending": 1.0, "thorax_bending": 1.0}
"""Pelvis list and bending of the trunk [1/(s rad²)]. Chosen: with those of walking, knees bend 73°
in swing at 3 m/s, in place of 88° (one runner: 95° [Hamner2013]_)."""
NODES_PER_SECOND = 120.0


def run(human: Human, parameters: RunSettings) -> MotionTask:
    """Return the task of running.

    Raises:
        ParameterError: If a value is out of range.
    """
    plan = running_plan(human, parameters)
    return MotionTask(
        "run",
        plan,
        running_terms(plan.duration, plan.stances[0].toe_off),
        lambda body, plan, times: crude_guess(body.human, plan, times),
        NODES_PER_SECOND,
    )


def running_plan(human: Human, parameters: RunSettings) -> ContactPlan:
    """Return one stance and the flight after it, mirrored from step to step.

    Raises:
        ParameterError: If the time of contact leaves no flight.
    """
    length, speed = human.dimensions.leg_length, parameters.speed
    slower = float(np.sqrt(length / REFERENCE_LEG))  # [1] times of longer legs are longer
    faster = speed / REFERENCE_SPEED
    cadence = parameters.cadence or CADENCE * faster**CADENCE_EXPONENT / slower
    step = 60.0 / cadence
    contact = (CONTACT_TIME + CONTACT_SLOPE * (speed - REFERENCE_SPEED)) * slower
    most = (1.0 - MIN_FLIGHT_SHARE) * step
    contact = min(contact, most)
    if parameters.cadence is None:
        step = contact + (step - contact) * float(np.sqrt(GRAVITY / human.gravity))
        most = (1.0 - MIN_FLIGHT_SHARE) * step
    if parameters.contact_time is not None:
        contact = parameters.contact_time
        number("contact_time", contact, 0.0, most, "s", f"running at {60.0 / step:.0f} steps/min")
    place = (0.0, -STEP_WIDTH_SHARE * length / 2, 0.0)
    flat, heel, ball = (share * contact for share in STANCE_SHARES)
    stance = Stance(Footprint("r", place, -TOE_OUT), 0.0, flat, heel, ball, contact)
    return ContactPlan(step, (stance,), periodic=True, advance=speed * step)


def running_terms(step_time: float, contact_time: float) -> tuple[Term, ...]:
    """Return conditions and costs of a run, by the times of a step and of its contact [s]."""
    bent = {"pelvis_tilt": PELVIS_TILT, "elbow_flex": ELBOW_FLEXION}
    return (
        *flying_terms(step_time, contact_time),
        Clearance(CLEARANCE),
        *(Within(f"knee_angle_{s}", STRIKE_KNEE_FLEXION, start=0.0, stop=0.0) for s in "rl"),
        Posture({**UPRIGHT_WEIGHTS, **BENDING_WEIGHTS}, {**STANDING_POSTURE, **bent}),
    )


def flying_terms(step_time: float, contact_time: float) -> tuple[Term, ...]:
    """Return what running and hopping share, by the times of a step and of its contact [s]."""
    return (
        Dynamics(),
        Contact(used=USED_FRICTION, soft_landing=False),
        Limits(speed=MAX_JOINT_SPEED),
        SolidLimbs(LEG_DISTANCE, ground=np.inf, loads_beside=True),
        Torque(1.0, TORQUE_WEIGHTS),
        Work(WORK_WEIGHT),
        Jerk(JERK_WEIGHT * step_time**6, by_inertia=True),
        Acceleration(PELVIS_ACCELERATION_WEIGHT, {"pelvis_rotation": 1.0}, others=0.0),
        Forces(rate=FORCE_RATE_WEIGHT * contact_time**2),
        AngularMomentum(forward=0.1, upward=0.5),
        Upright("head", forward=1.0, sideways=3.0, turning=0.05),
        Upright("trunk", sideways=3.0, away=1.2),
        Upright("pelvis", turning=0.01),
    )
