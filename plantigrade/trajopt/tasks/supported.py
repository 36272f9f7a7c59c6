"""Hands on armrests, walls and rails, hands, knees and seat on the floor, added to a task."""

from collections.abc import Sequence
from dataclasses import replace

from plantigrade.contact.limb_sites import HAND_PART
from plantigrade.contact.plan import PointSupport
from plantigrade.contact.site import CHAIR_PART
from plantigrade.errors import ParameterError
from plantigrade.trajopt.guess.hands import HandsOnSupports
from plantigrade.trajopt.guess.in_contact import InContact
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import InFront
from plantigrade.trajopt.terms.solid import SolidLimbs


def with_supports(task: MotionTask, supports: Sequence[PointSupport]) -> MotionTask:
    """Return a task whose hands, knees or seat also rest on supports, in front of them otherwise.

    Raises:
        ParameterError: If the task is periodic, a support is outside its time, or one part of the
            body has two different supports.
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
        if (first.position, first.normal, first.friction) != (s.position, s.normal, s.friction):
            raise ParameterError(
                f"{s.site.name} has two supports; give both the same place, normal and friction"
            )
    plan = replace(task.plan, supports=(*task.plan.supports, *supports))
    terms, guess = (*task.terms, *map(InFront, surfaces)), HandsOnSupports(task.guess)
    parts = {s.site.part for s in supports}
    if parts != {HAND_PART}:  # near the ground
        guess = InContact(task.guess)
        near = {"opposite_thighs": True, "shanks": True, "shoulders": CHAIR_PART in parts}
        terms = tuple(replace(t, **near) if isinstance(t, SolidLimbs) else t for t in terms)
    return replace(task, plan=plan, terms=terms, guess=guess)
