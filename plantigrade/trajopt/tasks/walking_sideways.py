"""Walking sideways: one foot steps out, the other closes, and again.

People who are asked to walk sideways choose 0.57 m/s, a third of the speed of walking forward, near
the speed that costs them least, and spend three times the energy per metre [Handford2014]_: body
and legs stop and start in every stride. The way leads along y, faces stay ahead, and half a stride
is no mirror image of the other: a whole one is solved.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.constants import SIDES
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.models import Human
from plantigrade.side_names import opposite
from plantigrade.trajopt.guess.postures import level_foot, reaching, standing_feet, standing_posture
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.tasks.gait_parameters import TOE_OUT
from plantigrade.trajopt.tasks.gait_settings import WalkSidewaysSettings
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.walking import walking_terms
from plantigrade.trajopt.tasks.walking_plan import standing_distance

STRIDE_SHARE = 0.6  # [leg lengths] how far the body moves in a stride. Estimate.
MAX_STRIDE = 0.9  # [leg lengths] legs 50° apart when the leading foot lands
LEADING_SWING = (0.55, 0.95)
"""Swing of the leading foot, as fractions of the stride; the following foot swings from 0.05 to
0.45. Both stand for 60 % of the stride, as in slow walking forward (*estimate*)."""
FOLLOWING_SWING = (0.05, 0.45)
HEEL_OFF = 0.85  # [1] time of heel off relative to stance. Estimate.
GUESS_LOW = 0.03  # [stature] how far the pelvis of the guess is below standing
GUESS_LIFT = 0.05  # [m] how high the feet of the guess are lifted
NODES_PER_SECOND = 40.0


def walk_sideways(human: Human, parameters: WalkSidewaysSettings) -> MotionTask:
    """Return the task of walking sideways periodically, of which a stride is solved.

    Raises:
        ParameterError: If the strides are too long for this person.
    """
    leg = human.dimensions.leg_length
    cadence, speed = parameters.cadence, parameters.speed
    stride = STRIDE_SHARE * leg if cadence is None else speed * 120.0 / cadence
    what = f"strides to the side at this cadence on legs of {leg:.2f} m"
    number("stride", stride, 0.05, MAX_STRIDE * leg, "m", what)
    plan = sideways_plan(human, stride, stride / speed, parameters.side)

    def guess(body: ContactBody, plan: ContactPlan, times: Array) -> Array:
        return _guess(body.human, plan, times)

    terms = walking_terms(plan.duration / 2)
    return MotionTask("walk-sideways", plan, terms, guess, NODES_PER_SECOND)


def sideways_plan(human: Human, stride: float, duration: float, leading: str) -> ContactPlan:
    """Return a stride [m] to the side of the leading foot; from its landing on."""
    way = 1.0 if leading == "l" else -1.0
    feet, closed = standing_feet(human), standing_distance(human)
    following = opposite(leading)
    x = feet[leading].position[0]
    # when the leading foot lands, legs are apart by a stride more than when the other has closed
    swings = {leading: LEADING_SWING, following: FOLLOWING_SWING}
    first = {leading: way * (closed + stride) / 2, following: -way * (closed + stride) / 2}
    stances = []
    for side, (off, strike) in swings.items():
        out = TOE_OUT if side == "l" else -TOE_OUT
        for k in (-1, 0, 1):
            begin, end = (strike - 1 + k) * duration, (off + k) * duration
            heel = begin + HEEL_OFF * (end - begin)
            if begin < duration and end > 0:
                place = Footprint(side, (x, first[side] + way * k * stride, 0.0), out)
                stances.append(Stance(place, begin, begin, heel, end, end))
    stances.sort(key=lambda s: s.heel_strike)
    return ContactPlan(duration, tuple(stances), periodic=True, mirrored=False, aside=way * stride)


def _guess(human: Human, plan: ContactPlan, times: Float[Array, " n"]) -> Float[Array, "n nv"]:
    """Return a stiff trunk between level feet."""
    q = np.tile(standing_posture(human), (len(times), 1))
    stances = plan.unrolled()
    feet = {s: level_foot(human, stances, s, times, GUESS_LIFT) for s in SIDES}
    middle = (feet["r"][0] + feet["l"][0]) / 2
    start = middle[0, 1] - plan.aside * times[0] / plan.duration
    # at the speed of the walk, and half of the feet's sway about it
    y = start + plan.aside * times / plan.duration
    q[:, 5] = -(y + middle[:, 1]) / 2
    q[:, 4] -= GUESS_LOW * human.height
    return reaching(human, q, feet)
