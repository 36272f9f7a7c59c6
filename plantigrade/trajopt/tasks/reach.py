"""Reaching for a place with one hand."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import Point
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.trajopt.guess.postures import (
    KeyPostures,
    standing_feet,
    standing_posture,
    standing_stances,
)
from plantigrade.trajopt.tasks import settings
from plantigrade.trajopt.tasks.standing import at_rest, basics
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.posture import Quiet, Rest
from plantigrade.trajopt.terms.targets import Reach
from plantigrade.trajopt.terms.term import Term


def reach(human: Human, parameters: settings.ReachSettings) -> MotionTask:
    """Return the task of bringing a hand to a place, feet where they are."""
    side, target, duration = parameters.side, parameters.target, parameters.duration
    d = human.dimensions
    hand = attachments(human)[f"hand_{side}"]
    point = Point(hand.body, tuple(map(float, hand.position)))
    shoulder = human.skeleton.origins[f"humerus_{side}"] + [0.0, 0.0, float(human.standing()[2])]
    arm = d.upper_arm + d.forearm + 0.44 * d.hand
    if target is None:
        ahead = arm + 0.1 * human.height
        target = (float(shoulder[0] + ahead), float(shoulder[1]), float(shoulder[2]))
    place = np.asarray(target, dtype=float)
    away = float(np.hypot(*(place - shoulder)[:2]))
    furthest, highest = arm + 0.25 * human.height, shoulder[2] + arm + 0.05 * human.height
    if away > furthest or not 0.0 <= place[2] <= highest:
        raise ParameterError(
            f"the target {target} m is {away:.2f} m from the shoulder along the ground; this "
            f"person reaches about {furthest:.2f} m, from the ground up to {highest:.2f} m"
        )
    feet, standing = standing_feet(human), standing_posture(human)
    low = _reaching(human, side, place - shoulder, arm)
    total = 2 * duration if parameters.back else duration
    plan = ContactPlan(total, standing_stances(feet, total))
    terms: tuple[Term, ...] = (
        *basics(human),
        *at_rest(human, 0.0, standing),
        Reach(duration, point, target),
        Rest(duration),
        Quiet(duration),
    )
    if parameters.back:
        terms = (*terms, *at_rest(human, total, standing))
    n = 3 if parameters.back else 2
    guess = KeyPostures((0.0, duration, total)[:n], (standing, low, standing)[:n])
    return MotionTask("reach", plan, terms, guess)


def _reaching(human: Human, side: str, away: Float[Array, " 3"], arm: float) -> Float[Array, " nv"]:
    """Return a posture whose arm points at a place that is ``away`` from the shoulder [m]."""
    out = standing_posture(human)
    names = human.coordinates
    flex = float(np.arctan2(away[0], -away[2]))
    out[6 + names.index(f"arm_flex_{side}")] = np.clip(flex, -0.9, 2.6)
    far = float(np.linalg.norm(away)) / arm
    elbow = 2 * np.arccos(np.clip(far, 0.05, 1.0))
    out[6 + names.index(f"elbow_flex_{side}")] = np.clip(elbow, 0.05, 2.3)
    if "lumbar_extension" in names and far > 1:
        out[6 + names.index("lumbar_extension")] -= min(far - 1, 0.5)
    return out
