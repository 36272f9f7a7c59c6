r"""A jump from standing: countermovement, push, flight, landing, and standing again.

The height :math:`h` of a jump is how far the centre of mass rises after take-off. It sets the speed
at take-off and the time of flight, after which the toes land:

.. math:: v = \sqrt{2 g h}, \qquad t = 2 v / g = 2 \sqrt{2 h / g}

The body is required to be stretched at take-off, because a crouched take-off would cost less.
"""

import numpy as np

from plantigrade.bounds import number
from plantigrade.constants import SIDES
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD
from plantigrade.trajopt.guess.postures import KeyPostures, standing_feet, standing_posture
from plantigrade.trajopt.tasks.mechanics import check_crouch, check_push, check_time
from plantigrade.trajopt.tasks.settings import JumpSettings, PushingSettings, TakeOffSettings
from plantigrade.trajopt.tasks.standing import at_rest, basics, crouch
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.limits import Limits, PowerLimit, Within
from plantigrade.trajopt.terms.posture import Pose, Posture, Symmetry
from plantigrade.trajopt.terms.targets import CentreOfMass
from plantigrade.trajopt.terms.term import Term

HEEL_OFF = 0.11  # [s] time of heel off before take-off
FOREFOOT_OFF = 0.035  # [s] time of forefoot off before take-off
HEEL_DOWN = 0.06  # [s] time of heel contact after the toes have landed
# [1] height of the centre of mass at take-off above standing, relative to stature. Chosen below
# that of people, because at 3 % light and strong jumpers move the trunk too fast for the mesh.
TAKE_OFF_RISE = 0.01
FORWARD_RISE_LOSS = 0.1  # [1] decrease of this height per distance of a forward jump
COUNTERMOVEMENT_DEPTH = 0.15  # [1] depth of the countermovement relative to stature, 0.25 to 0.3 m
LOWEST_POINT_TIME = 0.6  # [1] time of the lowest pelvis relative to the push
BACK_WEIGHTS = {"lumbar_extension": 50.0, "thorax_extension": 50.0, "lower_thorax_extension": 50.0}
"""Weights of a straight back [1/(s rad²)]; torque costs alone would flex it instead of the hips."""
ARM_WEIGHTS = {"arm_flex": 1.0, "arm_add": 5.0, "elbow_flex": 1.0}
"""Weights of arms away from hanging [1/(s rad²)]. Chosen: arms swing forward, as those of people;
sideways would cost less torque."""
HANGING_ARM = -0.14  # [rad] adduction of an arm beside the trunk, as in standing
PELVIS_TILT = float(np.deg2rad(-15.0))  # [rad] mean forward lean of the pelvis in push and landing
JOINT_POWER = 10.0  # [W/kg] maximum power of a joint
GUESS_LEG_SHORTENING = 0.06  # [leg lengths] shortening of the legs of the guess; knees of 40°
# [1/s] at 25, the error in flight between nodes is a quarter of body weight
NODES_PER_SECOND = 40.0


def jump(human: Human, parameters: JumpSettings) -> MotionTask:
    """Return the task of a jump.

    Raises:
        ParameterError: If a value is out of range for this person.
    """
    height, distance, push = parameters.jump_height, parameters.distance, parameters.push
    most, what = 0.5 * human.height, f"a jump of a person of {human.height:.2f} m"
    number("distance", distance, -most, most, "m", what)
    depth = _depth(human, parameters)
    check_push(human, height, depth + TAKE_OFF_RISE * human.height)
    speed = float(np.sqrt(2 * human.gravity * height))
    down = push + 2 * speed / human.gravity
    duration = down + parameters.landing
    stances = []
    for side, foot in standing_feet(human).items():
        stances.append(_pushing(foot, push))
        x, y, z = foot.position
        there = Footprint(side, (x + distance, y, z), foot.heading)
        end = duration + 1.0
        stances.append(Stance(there, down, down + HEEL_DOWN, end, end, end, toes_first=True))
    before = standing_posture(human)
    after = _moved(human, before, ahead=distance)
    terms: tuple[Term, ...] = (
        *basics(human),
        *at_rest(human, 0.0, before),
        *at_rest(human, duration, after),
        CentreOfMass(
            push,
            position=(np.nan, np.nan, _stretched(human) - FORWARD_RISE_LOSS * abs(distance)),
            velocity=(np.nan, np.nan, speed),
        ),
        *_countermovement(human, push, depth),
        *_habits(human),
    )
    plan, guess = ContactPlan(duration, tuple(stances)), _jump_guess(human, parameters, depth, down)
    return MotionTask("jump", plan, terms, guess, nodes_per_second=NODES_PER_SECOND)


def _jump_guess(human: Human, parameters: JumpSettings, depth: float, down: float) -> KeyPostures:
    """Return postures of a jump that goes down by a depth [m] and lands at a time [s]."""
    height, distance = parameters.jump_height, parameters.distance
    push, landing = parameters.push, parameters.landing
    before, rise = standing_posture(human), 0.04 * human.height
    low, landed = crouch(human, standing_feet(human), depth), down + 0.3 * landing
    flight = 2 * float(np.sqrt(2 * human.gravity * height)) / human.gravity
    return KeyPostures(
        (0.0, LOWEST_POINT_TIME * push, push, push + flight / 2, down, landed, down + landing),
        (
            before,
            _moved(human, low, arms=-40.0),
            _moved(human, before, up=rise, arms=90.0),
            _moved(human, before, ahead=distance / 2, up=rise + height, arms=90.0),
            _moved(human, before, ahead=distance, up=rise, arms=60.0),
            _moved(human, low, ahead=distance, arms=20.0),
            _moved(human, before, ahead=distance),
        ),
        lift=height,
        bent=GUESS_LEG_SHORTENING,
    )


def take_off(human: Human, parameters: TakeOffSettings) -> MotionTask:
    """Return the task of leaving the ground as high as can be; it ends in the air.

    Raises:
        ParameterError: If the depth is out of range for this person, or too much for the strength.
    """
    push, depth, gain = parameters.push, _depth(human, parameters), parameters.gain
    check_crouch(human, depth, parameters.strength)
    duration = push + 0.08
    plan = ContactPlan(duration, tuple(_pushing(f, push) for f in standing_feet(human).values()))
    before = standing_posture(human)
    low = crouch(human, standing_feet(human), depth)
    usual = float(np.sqrt(2 * human.gravity * 0.35))  # height is z + v^2 / 2 g; this is its slope
    terms: tuple[Term, ...] = (
        *(
            Limits(strength=parameters.strength) if isinstance(t, Limits) else t
            for t in basics(human)
        ),
        *at_rest(human, 0.0, before),
        CentreOfMass(
            push,
            position=(np.nan, np.nan, _stretched(human)),
            gain=(gain, gain * usual / human.gravity),
        ),
        PowerLimit(JOINT_POWER),
        *_countermovement(human, push, depth),
        *_habits(human),
    )
    rise = 0.04 * human.height
    guess = KeyPostures(
        (0.0, LOWEST_POINT_TIME * push, push, duration),
        (
            before,
            _moved(human, low, arms=-40.0),
            _moved(human, before, up=rise, arms=90.0),
            _moved(human, before, up=rise + 0.15, arms=90.0),
        ),
        lift=0.0,
        bent=GUESS_LEG_SHORTENING,
    )
    return MotionTask("take-off", plan, terms, guess, nodes_per_second=NODES_PER_SECOND)


def _pushing(foot: Footprint, push: float) -> Stance:
    return Stance(foot, -1.0, -1.0, push - HEEL_OFF, push - FOREFOOT_OFF, push)


def _countermovement(human: Human, push: float, depth: float) -> tuple[Term, ...]:
    """Return how far the pelvis goes down before the push, and no further."""
    height = float(standing_posture(human)[4] - depth)
    return (
        Pose(LOWEST_POINT_TIME * push, {"pelvis_ty": height}, at_rest=False, held=False),
        Within("pelvis_ty", low=height, stop=push),
    )


def _depth(human: Human, parameters: PushingSettings) -> float:
    """Return how far the pelvis goes down [m].

    Raises:
        ParameterError: If that is out of range for this person, or too deep for the time.
    """
    depth = COUNTERMOVEMENT_DEPTH * human.height if parameters.depth is None else parameters.depth
    what = f"a jump of a person of {human.height:.2f} m"
    number("depth", depth, 0.05 * human.height, 0.3 * human.height, "m", what)
    check_time(human, LOWEST_POINT_TIME * parameters.push, depth, "a countermovement")
    return depth


def _habits(human: Human) -> tuple[Term, ...]:
    """Return costs of what people do not do without need: bend the back, use one side more."""
    back = {n: w for n, w in BACK_WEIGHTS.items() if n in human.coordinates}
    weights = {**back, **ARM_WEIGHTS, "pelvis_tilt": 10.0}
    angles = {"pelvis_tilt": PELVIS_TILT, "arm_add": HANGING_ARM}
    return Symmetry(30.0), Posture(weights, angles)


def _stretched(human: Human) -> float:
    """Return the height of the centre of mass at take-off [m]."""
    return float(BodyState(human, human.standing()).com[2]) + TAKE_OFF_RISE * human.height


def _moved(human: Human, q, *, ahead: float = 0.0, up: float = 0.0, arms: float | None = None):
    """Return a posture at another place [m], with both arms raised forward [°]."""
    out = q.copy()
    out[3:6] += np.array([ahead, 0.0, up]) @ OPENSIM_TO_WORLD
    if arms is not None:
        out[[6 + human.hinge(f"arm_flex_{side}") for side in SIDES]] = np.deg2rad(arms)
    return out
