r"""A jump from standing: countermovement, push, flight, landing, and standing again.

The height :math:`h` of a jump is how far the centre of mass rises after take-off. It sets the speed
at take-off and the time of flight, after which the toes land:

.. math:: v = \sqrt{2 g h}, \qquad t = 2 v / g = 2 \sqrt{2 h / g}

The body is required to be stretched at take-off, because a crouched take-off would cost less.
"""

import numpy as np

from plantigrade.bounds import number
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD
from plantigrade.trajopt.guess.postures import KeyPostures, standing_feet, standing_posture
from plantigrade.trajopt.tasks.mechanics import check_crouch, check_push, check_time
from plantigrade.trajopt.tasks.settings import Jump, Pushing, TakeOff
from plantigrade.trajopt.tasks.standing import at_rest, basics, crouch
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.limits import Limits, PowerLimit, Within
from plantigrade.trajopt.terms.posture import Pose, Posture, Symmetry
from plantigrade.trajopt.terms.targets import CentreOfMass
from plantigrade.trajopt.terms.term import Term

HEEL_OFF, FOREFOOT_OFF = 0.11, 0.035  # before take-off [s]
HEEL_DOWN = 0.06  # after the toes have landed [s]
# The centre of mass at take-off above that in standing, of stature: no measurement, people stretch
# further. At 3 % light and strong jumpers whip the trunk faster than the mesh can follow.
EXTENDED = 0.01
LEANT = 0.1  # by which that is less, of the distance of a jump forward
DEPTH = 0.15  # of the countermovement, of stature: 0.25 to 0.3 m
LOWEST = 0.6  # of the push, until the pelvis is lowest
BACK = {"lumbar_extension": 50.0, "thorax_extension": 50.0, "lower_thorax_extension": 50.0}
"""Weights of a straight back [1/(s rad²)]; torques alone would bend it rather than the hips."""
LEAN = float(np.deg2rad(-15.0))  # the pelvis leans forward in push and landing, on average
POWER = 10.0  # of a joint [W/kg]
BENT = 0.06  # by which legs of the guess are short of stretched, of their length: knees of 40°
NODES_PER_SECOND = 40.0  # at 25, flight is off by a quarter of body weight between nodes


def jump(human: Human, told: Jump) -> MotionTask:
    """Return the task of a jump.

    Raises:
        ParameterError: If a value is out of range for this person.
    """
    height, distance, push, landing = told.jump_height, told.distance, told.push, told.landing
    most, what = 0.5 * human.height, f"a jump of a person of {human.height:.2f} m"
    number("distance", distance, -most, most, "m", what)
    depth = _depth(human, told)
    check_push(height, depth + EXTENDED * human.height, "a jump")
    speed = float(np.sqrt(2 * GRAVITY * height))
    flight = 2 * speed / GRAVITY
    down = push + flight
    duration = down + landing
    stances = []
    for side, foot in standing_feet(human).items():
        stances.append(_pushing(foot, push))
        x, y, z = foot.position
        there = Footprint(side, (x + distance, y, z), foot.heading)
        end = duration + 1.0
        stances.append(Stance(there, down, down + HEEL_DOWN, end, end, end, toes_first=True))
    plan = ContactPlan(duration, tuple(stances))
    before = standing_posture(human)
    after = _moved(human, before, ahead=distance)
    terms: tuple[Term, ...] = (
        *basics(),
        *at_rest(human, 0.0, before),
        *at_rest(human, duration, after),
        CentreOfMass(
            push,
            position=(np.nan, np.nan, _stretched(human) - LEANT * abs(distance)),
            velocity=(np.nan, np.nan, speed),
        ),
        *_countermovement(human, push, depth),
        *_habits(human),
    )
    rise = 0.04 * human.height
    low = crouch(human, standing_feet(human), depth)
    guess = KeyPostures(
        (0.0, LOWEST * push, push, push + flight / 2, down, down + 0.3 * landing, duration),
        (
            before,
            _moved(human, low, arms=-40.0),
            _moved(human, before, up=rise, arms=90.0),
            _moved(human, before, ahead=distance / 2, up=rise + height, arms=90.0),
            _moved(human, before, ahead=distance, up=rise, arms=60.0),
            _moved(human, low, ahead=distance, arms=20.0),
            after,
        ),
        lift=height,
        bent=BENT,
    )
    return MotionTask("jump", plan, terms, guess, nodes_per_second=NODES_PER_SECOND)


def take_off(human: Human, told: TakeOff) -> MotionTask:
    """Return the task of leaving the ground as high as can be; it ends in the air.

    Raises:
        ParameterError: If the depth is out of range for this person, or too much for the strength.
    """
    push, depth, gain = told.push, _depth(human, told), told.gain
    check_crouch(human, depth, told.strength)
    duration = push + 0.08
    plan = ContactPlan(duration, tuple(_pushing(f, push) for f in standing_feet(human).values()))
    before = standing_posture(human)
    low = crouch(human, standing_feet(human), depth)
    usual = float(np.sqrt(2 * GRAVITY * 0.35))  # height is z + v^2 / 2 g; this is its slope
    terms: tuple[Term, ...] = (
        *(Limits(strength=told.strength) if isinstance(t, Limits) else t for t in basics()),
        *at_rest(human, 0.0, before),
        CentreOfMass(
            push,
            position=(np.nan, np.nan, _stretched(human)),
            gain=(gain, gain * usual / GRAVITY),
        ),
        PowerLimit(POWER),
        *_countermovement(human, push, depth),
        *_habits(human),
    )
    rise = 0.04 * human.height
    guess = KeyPostures(
        (0.0, LOWEST * push, push, duration),
        (
            before,
            _moved(human, low, arms=-40.0),
            _moved(human, before, up=rise, arms=90.0),
            _moved(human, before, up=rise + 0.15, arms=90.0),
        ),
        lift=0.0,
        bent=BENT,
    )
    return MotionTask("take-off", plan, terms, guess, nodes_per_second=NODES_PER_SECOND)


def _pushing(foot: Footprint, push: float) -> Stance:
    return Stance(foot, -1.0, -1.0, push - HEEL_OFF, push - FOREFOOT_OFF, push)


def _countermovement(human: Human, push: float, depth: float) -> tuple[Term, ...]:
    """Return how far the pelvis goes down before the push, and no further."""
    height = float(standing_posture(human)[4] - depth)
    return (
        Pose(LOWEST * push, {"pelvis_ty": height}, at_rest=False, held=False),
        Within("pelvis_ty", low=height, stop=push),
    )


def _depth(human: Human, told: Pushing) -> float:
    """Return how far the pelvis goes down [m].

    Raises:
        ParameterError: If that is out of range for this person, or too deep for the time.
    """
    depth = DEPTH * human.height if told.depth is None else told.depth
    what = f"a jump of a person of {human.height:.2f} m"
    number("depth", depth, 0.05 * human.height, 0.3 * human.height, "m", what)
    check_time(LOWEST * told.push, depth, "a countermovement")
    return depth


def _habits(human: Human) -> tuple[Term, ...]:
    """Return costs of what people do not do without need: bend the back, use one side more."""
    back = {n: w for n, w in BACK.items() if n in human.coordinates}
    return (
        Symmetry(30.0),
        Posture({**back, "pelvis_tilt": 10.0, "arm_flex": 2.0}, {"pelvis_tilt": LEAN}),
    )


def _stretched(human: Human) -> float:
    """Return the height of the centre of mass at take-off [m]."""
    return float(State(human, human.standing()).com[2]) + EXTENDED * human.height


def _moved(human: Human, q, *, ahead: float = 0.0, up: float = 0.0, arms: float | None = None):
    """Return a posture at another place [m], with both arms raised forward [°]."""
    out = q.copy()
    out[3:6] += np.array([ahead, 0.0, up]) @ OPENSIM_TO_WORLD
    if arms is not None:
        out[[6 + human.hinge(f"arm_flex_{side}") for side in SIDES]] = np.deg2rad(arms)
    return out
