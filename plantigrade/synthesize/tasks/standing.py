r"""Tasks on two feet that stay where they are: rising from a chair and sitting down, squat, reach.

Every one begins and ends in quiet standing or sitting: rates and accelerations are zero there, so
that forces balance.
"""

from collections.abc import Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan, Footprint, Support
from plantigrade.contact.site import ContactSite, Point
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    pelvis_angles_to_quaternion,
    rotation_matrix,
)
from plantigrade.synthesize.guess.legs import Leg
from plantigrade.synthesize.guess.postures import (
    KeyPostures,
    posture,
    standing_feet,
    standing_posture,
    standing_stances,
)
from plantigrade.synthesize.tasks.task import MotionTask
from plantigrade.synthesize.terms.more_terms import Above, Quiet, Reach, Rest, Symmetry
from plantigrade.synthesize.terms.terms import (
    Acceleration,
    Contact,
    Dynamics,
    Forces,
    Limits,
    Pose,
    Term,
    Torque,
)

SEAT_OFF = 0.35  # of the movement, about a third [Kralj1990]_ [Schenkman1990]_
KNEE_PART = 0.9  # chair height, of the knee's; about what a chair of 45 cm is to an adult
SHANK_LEAN = float(np.deg2rad(15.0))  # knees ahead of the ankles, seated
SEATED_TILT = float(np.deg2rad(15.0))  # pelvis tilted back, seated upright
H_POINT = 0.055  # hip joint above the seat, of stature: 10 cm (estimate)
ISCHIA = 0.068  # between the ischial points, of stature: 12 cm (estimate)
BUTTOCK = 0.025  # radius of an ischial point, of stature


def basics() -> tuple[Term, ...]:
    """Return the conditions and costs every task on true forces has."""
    return (Dynamics(), Contact(), Limits(), Torque(), Acceleration(1e-3), Forces())


def at_rest(human: Human, time: float, q: Float[Array, " nv"]) -> tuple[Term, ...]:
    """Return the terms of a posture that is held."""
    from plantigrade.models.human import PELVIS

    names = PELVIS + human.coordinates
    return (
        Pose(time, dict(zip(names, map(float, q), strict=True))),
        Quiet(time),
    )


def seat_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return the two points a person sits on, below and a little behind the hip joints."""
    hip = Leg(human, "r").hip
    radius = BUTTOCK * human.height
    drop = H_POINT * human.height - radius
    # below the hip joints when the pelvis is tilted back as in sitting
    x = hip[0] - drop * np.sin(SEATED_TILT)
    z = hip[2] - drop * np.cos(SEATED_TILT)
    half = ISCHIA * human.height / 2
    return tuple(
        ContactSite(
            body="pelvis", position=(x, y, z), radius=radius, name=f"seat_{side}", part="chair"
        )
        for side, y in (("r", -half), ("l", half))
    )


def resting_place(
    human: Human, site: ContactSite, q: Float[Array, " nv"]
) -> tuple[float, float, float]:
    """Return where a site of the pelvis rests in a posture, as rows of contact have it [m]."""
    R = rotation_matrix(pelvis_angles_to_quaternion(q[None, :3]))[0]
    centre = OPENSIM_TO_WORLD @ q[3:6] + R @ np.array(site.position)
    rho = site.radius
    x = centre[0] + rho * np.arcsin(R[2, 0])
    y = centre[1] + rho * np.arctan2(R[2, 1], R[2, 2])
    return float(x), float(y), float(centre[2] - rho)


def seated_posture(human: Human, chair_height: float) -> Float[Array, " nv"]:
    """Return the coordinates of sitting upright on a chair, feet where they are in standing.

    Args:
        human: The person.
        chair_height: Of the seat [m].

    Raises:
        ParameterError: If the legs cannot do that.
    """
    d = human.dimensions
    feet = standing_feet(human)
    ankle = feet["r"].position[0]
    hip = chair_height + H_POINT * human.height
    knee = d.ankle_height + d.shank * np.cos(SHANK_LEAN)
    rise = (hip - knee) / d.thigh
    if not -0.5 <= rise <= 0.75:
        low, high = (knee + k * d.thigh - H_POINT * human.height for k in (-0.5, 0.75))
        raise ParameterError(
            f"{chair_height=} [m]: a person of {human.height:.2f} m sits on {low:.2f} to "
            f"{high:.2f} m"
        )
    x = ankle + d.shank * np.sin(SHANK_LEAN) - d.thigh * np.sqrt(1 - rise**2)
    joints = {n: v for n, v in {"lumbar_extension": -SEATED_TILT}.items() if n in human.coordinates}
    return posture(human, feet, hip=(float(x), hip), tilt=SEATED_TILT, joints=joints)


def sit_to_stand(
    human: Human,
    *,
    chair_height: float | None = None,
    duration: float = 2.0,
    seat_off: float = SEAT_OFF,
    reverse: bool = False,
) -> MotionTask:
    """Return the task of rising from a chair, or of sitting down on it.

    The pelvis rests on two points below the hip joints, which roll on the seat without slipping;
    they carry until seat-off.

    Args:
        human: The person.
        chair_height: Of the seat [m]; nine tenths of the knee's height if not given.
        duration: From sitting still to standing still [s]; 1.5 to 3.5 s in studies [Kralj1990]_.
        seat_off: When the seat is left, as a part of the duration.
        reverse: Whether to sit down instead; the seat is then met at ``1 - seat_off``.

    Raises:
        ParameterError: If a value is out of range.
    """
    d = human.dimensions
    if chair_height is None:
        chair_height = KNEE_PART * (d.ankle_height + d.shank)
    if not 0.5 <= duration <= 20.0:
        raise ParameterError(f"{duration=} [s]: standing up takes 0.5 to 20 s")
    if not 0.1 <= seat_off <= 0.8:
        raise ParameterError(f"{seat_off=} is a part of the duration, 0.1 to 0.8")
    feet, sites = standing_feet(human), seat_sites(human)
    seated, standing = seated_posture(human, chair_height), standing_posture(human)
    off = seat_off * duration
    rising = np.array([0.0, off, 1.15 * off + 0.1 * duration, duration])
    lean = _leaning(human, seated)
    middle = (lean + standing) / 2
    keys = [seated, lean, middle, standing]
    span = (-1.0, off)
    if reverse:
        rising, keys = duration - rising[::-1], keys[::-1]
        span = (duration - off, duration + 1.0)
    supports = tuple(Support(s, resting_place(human, s, seated), *span) for s in sites)
    plan = ContactPlan(duration, standing_stances(feet, duration), supports=supports)
    terms = (
        *basics(),
        *at_rest(human, 0.0, keys[0]),
        *at_rest(human, duration, keys[-1]),
        *(Above(s.name, chair_height) for s in sites),
        Symmetry(),
    )
    name = "stand-to-sit" if reverse else "sit-to-stand"
    return MotionTask(name, plan, terms, KeyPostures(tuple(map(float, rising)), tuple(keys)))


def stand_to_sit(
    human: Human,
    *,
    chair_height: float | None = None,
    duration: float = 2.0,
    seat_off: float = SEAT_OFF,
) -> MotionTask:
    """Return the task of sitting down: :func:`sit_to_stand` in reverse, with the same arguments."""
    return sit_to_stand(
        human, chair_height=chair_height, duration=duration, seat_off=seat_off, reverse=True
    )


def _leaning(human: Human, seated: Float[Array, " nv"]) -> Float[Array, " nv"]:
    """Return the posture just before seat-off: pelvis rolled forward, trunk bent."""
    out = seated.copy()
    out[0] -= np.deg2rad(35.0)
    if "lumbar_extension" in human.coordinates:
        out[6 + human.hinge("lumbar_extension")] -= np.deg2rad(10.0)
    return out


def squat(human: Human, *, depth: float | None = None, duration: float = 2.5) -> MotionTask:
    """Return the task of going down on both feet and coming up again.

    Only how deep the pelvis is halfway through is said; how knees, hips and trunk share that, the
    costs decide.

    Args:
        human: The person.
        depth: How far the pelvis goes down [m]; a fifth of stature if not given, which brings the
            thighs three quarters of the way to level.
        duration: From standing to standing [s].

    Raises:
        ParameterError: If a value is out of range.
    """
    feet = standing_feet(human)
    depth = 0.2 * human.height if depth is None else depth
    if not 0.02 * human.height <= depth <= 0.32 * human.height:
        raise ParameterError(
            f"{depth=} [m]: a person of {human.height:.2f} m squats {0.02 * human.height:.2f} to "
            f"{0.32 * human.height:.2f} m deep"
        )
    if not 0.6 <= duration <= 20.0:
        raise ParameterError(f"{duration=} [s]: a squat takes 0.6 to 20 s")
    standing = standing_posture(human)
    low = crouch(human, feet, depth)
    plan = ContactPlan(duration, standing_stances(feet, duration))
    half = duration / 2
    terms = (
        *basics(),
        *at_rest(human, 0.0, standing),
        *at_rest(human, duration, standing),
        Pose(half, {"pelvis_ty": float(standing[4] - depth)}, at_rest=False, held=False),
        Symmetry(),  # without it legs may turn in opposite ways: another minimum, no better
    )
    keys = KeyPostures((0.0, half, duration), (standing, low, standing))
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


def reach(
    human: Human,
    *,
    target: tuple[float, float, float] | None = None,
    side: str = "r",
    duration: float = 1.5,
    back: bool = False,
) -> MotionTask:
    """Return the task of bringing a hand to a place, feet where they are.

    Args:
        human: The person, standing at the origin, x forward.
        target: Where the middle of the hand shall be, world [m]; straight ahead at shoulder height,
            a tenth of stature further than the arm reaches, if not given.
        side: Which hand, ``"r"`` or ``"l"``.
        duration: From standing still to the hand at rest on its target [s].
        back: Whether to stand up again afterwards, in the same time.

    Raises:
        ParameterError: If a value is out of range, or the target too far away.
    """
    if side not in ("r", "l"):
        raise ParameterError(f"{side=} must be 'r' or 'l'")
    if not 0.3 <= duration <= 20.0:
        raise ParameterError(f"{duration=} [s]: reaching takes 0.3 to 20 s")
    d = human.dimensions
    hand = attachments(human)[f"hand_{side}"]
    point = Point(hand.body, tuple(map(float, hand.position)))
    shoulder = human.skeleton.origins[f"humerus_{side}"] + [
        0.0,
        0.0,
        float(human.standing()[2]),
    ]
    arm = d.upper_arm + d.forearm + 0.44 * d.hand
    if target is None:
        ahead = arm + 0.1 * human.height
        target = (float(shoulder[0] + ahead), float(shoulder[1]), float(shoulder[2]))
    place = np.asarray(target, dtype=float)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ParameterError(f"{target=} must be three numbers [m]")
    away = float(np.hypot(*(place - shoulder)[:2]))
    furthest = arm + 0.25 * human.height
    if away > furthest or not 0.0 <= place[2] <= shoulder[2] + arm + 0.05 * human.height:
        raise ParameterError(
            f"{target=} [m] is {away:.2f} m from the shoulder along the ground; this person "
            f"reaches about {furthest:.2f} m, from the ground up to "
            f"{shoulder[2] + arm + 0.05 * human.height:.2f} m"
        )
    feet, standing = standing_feet(human), standing_posture(human)
    low = _reaching(human, side, place - shoulder, arm)
    total = 2 * duration if back else duration
    plan = ContactPlan(total, standing_stances(feet, total))
    terms: tuple[Term, ...] = (
        *basics(),
        *at_rest(human, 0.0, standing),
        Reach(point, (float(place[0]), float(place[1]), float(place[2])), duration),
        Rest(duration),
        Quiet(duration),
    )
    if back:
        terms = (*terms, *at_rest(human, total, standing))
    keys = [standing, low, standing] if back else [standing, low]
    times = (0.0, duration, total) if back else (0.0, duration)
    return MotionTask("reach", plan, terms, KeyPostures(times, tuple(keys)))


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
