"""Hands on armrests, walls and rails, limbs, seat and back on the floor, and ground that moves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import FRICTION
from plantigrade.contact.limb_sites import BUTTOCK_PART, HAND_PART
from plantigrade.contact.plan import TIME_TOLERANCE, PointSupport
from plantigrade.contact.site import CHAIR_PART
from plantigrade.contact.surface_motion import SurfaceMotion
from plantigrade.errors import ParameterError
from plantigrade.trajopt.guess.hands import HandsOnSupports
from plantigrade.trajopt.guess.in_contact import InContact
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import Contact, InFront
from plantigrade.trajopt.terms.solid import SolidLimbs


@dataclass(frozen=True)
class SurfaceLimits:
    """Limits of surfaces that move, beyond which no person follows. Chosen."""

    support_speed: float = 3.0  #: Speed of a support [m/s]; that of a hand in a fast reach
    #: Speed of the ground [m/s]; a bus on a motorway: only a change of speed is felt
    ground_speed: float = 30.0
    #: Acceleration of a surface [m/s²]; that of a hand in a fast reach, or an emergency brake
    acceleration: float = 15.0
    interval: float = 0.005  #: Interval at which speed and acceleration are compared with them [s]


LIMITS = SurfaceLimits()


def with_supports(task: MotionTask, supports: Sequence[PointSupport]) -> MotionTask:
    """Return a task whose hands, knees or seat also rest on supports, in front of them otherwise.

    Raises:
        ParameterError: If the task is periodic, a support is outside its time or moves as no body
            follows, or one part of the body has two different supports.
    """
    if not supports:
        return task
    if task.plan.periodic:
        raise ParameterError("a periodic task has no fixed supports: take one from rest to rest")
    surfaces: dict[str, PointSupport] = {}
    for s in supports:
        if s.start >= task.plan.duration or s.stop <= 0.0:
            raise ParameterError(
                f"the support of {s.site.name} from {s.start:g} to {s.stop:g} s is outside the "
                f"motion, which lasts {task.plan.duration:g} s"
            )
        first = surfaces.setdefault(s.site.name, s)
        if _surface(first) != _surface(s):
            raise ParameterError(
                f"{s.site.name} has two supports; give both the same place, normal, friction and "
                "motion"
            )
        if s.motion is not None:
            during = max(s.start, 0.0), min(s.stop, task.plan.duration)
            what = f"the support of {s.site.name}"
            _check_motion(what, s.motion, LIMITS.support_speed, during, task.plan.duration)
    plan = replace(task.plan, supports=(*task.plan.supports, *supports))
    terms, guess = (*task.terms, *map(InFront, surfaces)), HandsOnSupports(task.guess)
    parts = {s.site.part for s in supports}
    if parts != {HAND_PART}:  # near the ground
        guess = InContact(task.guess)
        sits = bool(parts & {CHAIR_PART, BUTTOCK_PART})
        near = {"opposite_thighs": True, "shanks": True, "shoulders": sits}
        terms = tuple(replace(t, **near) if isinstance(t, SolidLimbs) else t for t in terms)
    return replace(task, plan=plan, terms=terms, guess=guess)


def on_moving_ground(task: MotionTask, motion: SurfaceMotion, gravity: float) -> MotionTask:
    """Return a task on ground that moves, with the places of its plan and terms.

    Args:
        gravity: Acceleration of gravity [m/s²].

    Raises:
        ParameterError: If the task is periodic, or the ground moves as no standing person follows.
    """
    if task.plan.periodic:
        raise ParameterError("a periodic task has no moving ground: take one from rest to rest")
    if task.objects:
        raise ParameterError(f"{task.name} has objects, which moving ground does not carry along")
    end = task.plan.duration
    times = _check_motion("the ground", motion, LIMITS.ground_speed, (0.0, end), end)
    a = motion.acceleration(times)
    down = gravity + a[:, 2]
    if down.min() <= 0.0:
        raise ParameterError(
            f"the ground falls with {-a[:, 2].min():.3g} m/s², faster than a body: let it "
            f"accelerate downwards by less than {gravity:.3g} m/s²"
        )
    grip = min((t.friction for t in task.terms if isinstance(t, Contact)), default=FRICTION)
    needed = float((np.linalg.norm(a[:, :2], axis=1) / down).max())
    if needed > grip and not task.plan.supports:
        raise ParameterError(
            f"feet slip on ground that accelerates by {needed:.2f} of what presses them on it, as "
            f"the coefficient of friction is {grip:g}: accelerate it less, or give the hands a "
            "support"
        )
    return replace(task, plan=replace(task.plan, motion=motion))


def _surface(support: PointSupport) -> tuple:
    """Return what two supports of one site must have in common."""
    return support.position, support.normal, support.friction, support.motion


def _check_motion(
    what: str, motion: SurfaceMotion, fastest: float, during: tuple[float, float], end: float
) -> Float[Array, " n"]:
    """Return the times at which a motion was examined [s]; refuse one that no person follows."""
    for time, *_ in motion.rows:
        if not -TIME_TOLERANCE <= time <= end + TIME_TOLERANCE:
            raise ParameterError(
                f"{what} is given at {time:g} s, outside the motion, which lasts {end:g} s; it "
                "continues before its first and after its last row"
            )
    steps = 2 + round((during[1] - during[0]) / LIMITS.interval)
    times = np.linspace(*during, steps)
    for values, most, unit in (
        (motion.velocity(times), fastest, "m/s"),
        (motion.acceleration(times), LIMITS.acceleration, "m/s²"),
    ):
        if (found := float(np.linalg.norm(values, axis=1).max())) > most:
            raise ParameterError(
                f"{what} reaches {found:.3g} {unit}, and up to {most:g} {unit} can be followed: "
                "give it more time, or a shorter way"
            )
    return times
