r"""Hopping on the spot, on both legs or on one: periodic, one hop after the other.

The rate :math:`f` of the hops and the rise :math:`h` of the centre of mass in flight set the times:

.. math:: t_\text{flight} = 2 \sqrt{2 h / g}, \qquad t_\text{contact} = 1 / f - t_\text{flight}

People who may choose hop 2.2 times a second, and like springs at that rate and above it
[Farley1991]_. The toes land first and the heels follow. The cost is that of running
(:mod:`plantigrade.trajopt.tasks.running`).
"""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.side_names import opposite
from plantigrade.trajopt.guess.postures import reaching, standing_feet, standing_posture
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.tasks.gait_settings import HopSettings
from plantigrade.trajopt.tasks.running import NODES_PER_SECOND, flying_terms
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.walking import PELVIS_LEAN, STANDING_POSTURE, UPRIGHT_WEIGHTS
from plantigrade.trajopt.terms.limits import Within
from plantigrade.trajopt.terms.posture import Posture, Symmetry
from plantigrade.trajopt.terms.term import Term

MIN_CONTACT = 0.15  # [s] shortest contact; people who hop as fast as they can have 0.15 to 0.2 s
STANCE_SHARES = (0.3, 0.6, 0.85)
"""Heel down, heel off and ball off relative to the contact time [1]; estimates."""
MIDLINE_DISTANCE = 0.02  # [m] of the only foot from the midline, under the centre of mass
SYMMETRY_WEIGHT = 30.0  # [1/(s rad²)] of a hop on both legs, as of a jump
FREE_KNEE = (float(np.deg2rad(60.0)), float(np.deg2rad(100.0)))
"""Least and largest flexion of the free knee [rad], which keeps the foot off the ground."""
TOUCHDOWN_KNEE = float(np.deg2rad(25.0))
"""Largest flexion of a knee at touchdown and take-off [rad]. Without it people would hop with bent
knees, because torque of knees is cheap in running; they hop on stretched legs, 20° to 30°."""
TOUCHDOWN_ANKLE = float(np.deg2rad(-10.0))
"""Largest dorsiflexion of an ankle at touchdown [rad]: the toes point down, 10° to 20°."""
GUESS_CROUCH = (0.03, 0.05)  # [m] pelvis below standing at touchdown, and further at mid-contact


def hop(human: Human, parameters: HopSettings) -> MotionTask:
    """Return the task of hopping on the spot.

    Raises:
        ParameterError: If a hop of that height leaves no time for the contact.
    """
    plan = hopping_plan(human, parameters)
    contact = plan.stances[0].toe_off
    terms: list[Term] = [
        *flying_terms(plan.duration, contact),
        Posture(UPRIGHT_WEIGHTS, {**STANDING_POSTURE, "pelvis_tilt": -PELVIS_LEAN}),
    ]
    for stance in plan.stances:
        side = stance.footprint.side
        terms += [
            Within(f"knee_angle_{side}", high=TOUCHDOWN_KNEE, start=t, stop=t)
            for t in (0.0, contact)
        ]
        terms.append(Within(f"ankle_angle_{side}", high=TOUCHDOWN_ANKLE, start=0.0, stop=0.0))
    if parameters.legs == "both":
        terms.append(Symmetry(SYMMETRY_WEIGHT))
    else:
        free = opposite(parameters.legs)
        terms.append(Within(f"knee_angle_{free}", *FREE_KNEE))
    rise = parameters.hop_height

    def guess(body: ContactBody, plan: ContactPlan, times: Array) -> Array:
        return _guess(body.human, plan, times, rise)

    return MotionTask("hop", plan, tuple(terms), guess, NODES_PER_SECOND)


def hopping_plan(human: Human, parameters: HopSettings) -> ContactPlan:
    """Return one contact and the flight after it."""
    period = 60.0 / parameters.hops_per_minute
    contact = period - 2.0 * float(np.sqrt(2.0 * parameters.hop_height / human.gravity))
    if contact < MIN_CONTACT:
        most = human.gravity / 8.0 * max(period - MIN_CONTACT, 0.0) ** 2
        raise ParameterError(
            f"{parameters.hops_per_minute:g} hops/min of {parameters.hop_height:g} m leave "
            f"{max(contact, 0.0):.2f} s for the contact, people need {MIN_CONTACT:g} s: hop "
            f"{most:.2f} m high at most, or more slowly"
        )
    down, up, ball = (share * contact for share in STANCE_SHARES)
    feet = standing_feet(human)
    if parameters.legs != "both":
        side = parameters.legs
        x, y, z = feet[side].position
        feet = {side: Footprint(side, (x, float(np.sign(y)) * MIDLINE_DISTANCE, z))}
    stances = tuple(
        Stance(foot, 0.0, down, up, ball, contact, toes_first=True) for foot in feet.values()
    )
    return ContactPlan(period, stances, periodic=True, mirrored=False)


def _guess(human: Human, plan: ContactPlan, times: Array, rise: float) -> Array:
    """Return a stiff trunk that goes down and up on legs that reach for level feet."""
    q = np.tile(standing_posture(human), (len(times), 1))
    contact, period = plan.stances[0].toe_off, plan.duration
    low, deep = GUESS_CROUCH
    s = np.clip((times - contact) / (period - contact), 0.0, 1.0)
    flight = rise * 4.0 * s * (1.0 - s)
    q[:, 4] += flight - low - deep * np.sin(np.pi * np.clip(times / contact, 0.0, 1.0))
    standing = {stance.footprint.side: stance.footprint for stance in plan.stances}
    for side in set(SIDES) - set(standing):
        q[:, 6 + human.hinge(f"knee_angle_{side}")] = np.mean(FREE_KNEE)
    up = np.array([0.0, 0.0, 1.0]) * (human.dimensions.ankle_height + flight)[:, None]
    feet = {side: (np.array(f.position) + up, f.heading) for side, f in standing.items()}
    return reaching(human, q, feet)
