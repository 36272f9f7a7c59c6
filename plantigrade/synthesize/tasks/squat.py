"""Squatting on both feet."""

from collections.abc import Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan, Footprint
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.synthesize.guess.postures import (
    KeyPostures,
    posture,
    standing_feet,
    standing_posture,
    standing_stances,
)
from plantigrade.synthesize.tasks.settings import Squat
from plantigrade.synthesize.tasks.standing import at_rest, basics
from plantigrade.synthesize.tasks.task import MotionTask
from plantigrade.synthesize.terms.posture import Pose, Symmetry


def squat(human: Human, told: Squat) -> MotionTask:
    """Return the task of going down on both feet and coming up again.

    Only how deep the pelvis is halfway through is said; how knees, hips and trunk share that, the
    costs decide.

    Raises:
        ParameterError: If the depth is out of range for this person.
    """
    feet, duration = standing_feet(human), told.duration
    depth = 0.2 * human.height if told.depth is None else told.depth
    low, high = 0.02 * human.height, 0.32 * human.height
    if not low <= depth <= high:
        raise ParameterError(
            f"depth must be {low:.2f}–{high:.2f} m for a squat of a person of {human.height:.2f} "
            f"m, not {depth:g}"
        )
    standing = standing_posture(human)
    crouched = crouch(human, feet, depth)
    plan = ContactPlan(duration, standing_stances(feet, duration))
    half = duration / 2
    terms = (
        *basics(),
        *at_rest(human, 0.0, standing),
        *at_rest(human, duration, standing),
        Pose(half, {"pelvis_ty": float(standing[4] - depth)}, at_rest=False, held=False),
        Symmetry(),  # without it legs may turn in opposite ways: another minimum, no better
    )
    keys = KeyPostures((0.0, half, duration), (standing, crouched, standing))
    return MotionTask("squat", plan, terms, keys)


def crouch(human: Human, feet: Mapping[str, Footprint], depth: float) -> Float[Array, " nv"]:
    """Return a balanced crouch: hips lower by ``depth`` [m], trunk forward as hips are back."""
    d = human.dimensions
    standing = d.ankle_height + d.shank + d.thigh
    bend = min(1.0, depth / (0.25 * human.height))
    lean = np.deg2rad(8.0 + 22.0 * bend)
    hip = standing - depth
    rise = np.clip((hip - d.ankle_height - d.shank * np.cos(lean)) / d.thigh, -0.9, 0.995)
    x = feet["r"].position[0] + d.shank * np.sin(lean) - d.thigh * np.sqrt(1 - rise**2)
    joints = {"lumbar_extension": -np.deg2rad(20.0) * bend}
    joints = {n: v for n, v in joints.items() if n in human.coordinates}
    tilt = -np.deg2rad(20.0) * bend
    return posture(human, feet, hip=(float(x), float(hip)), tilt=float(tilt), joints=joints)
