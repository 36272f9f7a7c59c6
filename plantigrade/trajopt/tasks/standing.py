"""On both feet: standing, squatting, and the conditions and costs that tasks on the spot share."""

from collections.abc import Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.plan import ContactPlan, Footprint
from plantigrade.models import Human
from plantigrade.spatial.conventions import PELVIS
from plantigrade.trajopt.guess.postures import (
    KeyPostures,
    posture,
    standing_feet,
    standing_posture,
    standing_stances,
)
from plantigrade.trajopt.tasks.mechanics import check_time
from plantigrade.trajopt.tasks.settings import SquatSettings, StandSettings
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import Contact, Dynamics, Forces
from plantigrade.trajopt.terms.effort import Acceleration, Torque
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.terms.posture import LumbopelvicRhythm, Pose, Posture, Quiet, Symmetry
from plantigrade.trajopt.terms.solid import SolidLimbs
from plantigrade.trajopt.terms.term import Term

RELAXED_WEIGHTS = {
    **dict.fromkeys(("neck_extension", "neck_bending", "neck_rotation"), 0.1),
    **dict.fromkeys(("pro_sup", "wrist_flex", "wrist_dev", "fingers_flex"), 0.3),
    **dict.fromkeys(("arm_add", "arm_rot"), 0.3),
    **dict.fromkeys(("lower_thorax_extension", "thorax_extension"), 3.0),
}
"""Weights of angles of upper back, neck and arms away from standing [1/(s rad²)]. Chosen: in squats
and reaches the neck bends by less than 20°, and forearms turn by less than 15°. With a tenth of it
the upper back extends by 29°, its limit, where the lumbar joint is flexed most."""


def basics(human: Human) -> tuple[Term, ...]:
    """Return the conditions and costs every task on true forces has."""
    return (
        Dynamics(),
        Contact(),
        Limits(),
        SolidLimbs(),
        Torque(by_strength=True),
        Acceleration(1e-3),
        Forces(),
        relaxed(human),
        LumbopelvicRhythm(),
    )


def relaxed(human: Human) -> Posture:
    """Return the cost of upper back, neck and arms away from standing.

    Neck and arms bear little, and torques by strength hardly say where they are: without this cost
    a squatting neck extends by 46° and forearms supinate by 65° in a reach.
    """
    angles = dict(zip(human.coordinates, map(float, standing_posture(human)[6:]), strict=True))
    return Posture(RELAXED_WEIGHTS, angles)


def at_rest(human: Human, time: float, q: Float[Array, " nv"]) -> tuple[Term, ...]:
    """Return the terms of a posture that is held."""
    coordinates = dict(zip(PELVIS + human.coordinates, map(float, q), strict=True))
    return Pose(time, coordinates), Quiet(time)


def stand(human: Human, parameters: StandSettings) -> MotionTask:
    """Return a person who stands on both feet, with the usual conditions and costs."""
    plan = ContactPlan(
        parameters.duration, standing_stances(standing_feet(human), parameters.duration)
    )
    q = standing_posture(human)
    return MotionTask(
        "standing", plan, basics(human), KeyPostures((0.0, parameters.duration), (q, q))
    )


def squat(human: Human, parameters: SquatSettings) -> MotionTask:
    """Return the task of a squat: the depth of the pelvis is given, the costs decide the rest.

    Raises:
        ParameterError: If the depth is out of range for this person, or too much for the time.
    """
    feet, duration = standing_feet(human), parameters.duration
    depth = 0.2 * human.height if parameters.depth is None else parameters.depth
    what = f"a squat of a person of {human.height:.2f} m"
    number("depth", depth, 0.02 * human.height, 0.32 * human.height, "m", what)
    check_time(human, duration / 2, depth, "a squat")
    standing = standing_posture(human)
    crouched = crouch(human, feet, depth)
    plan = ContactPlan(duration, standing_stances(feet, duration))
    half = duration / 2
    terms = (
        *basics(human),
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
    bend = min(1.0, depth / (0.25 * human.height))
    lean = np.deg2rad(8.0 + 22.0 * bend)
    hip = d.ankle_height + d.shank + d.thigh - depth
    rise = np.clip((hip - d.ankle_height - d.shank * np.cos(lean)) / d.thigh, -0.9, 0.995)
    x = feet["r"].position[0] + d.shank * np.sin(lean) - d.thigh * np.sqrt(1 - rise**2)
    tilt = float(-np.deg2rad(20.0) * bend)
    return posture(human, feet, hip=(float(x), float(hip)), tilt=tilt, joints=bent(human, tilt))


def bent(human: Human, angle: float) -> dict[str, float]:
    """Return the trunk bent by an angle at the lumbar joint, where the person has one [rad]."""
    return {"lumbar_extension": angle} if "lumbar_extension" in human.coordinates else {}
