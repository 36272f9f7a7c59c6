"""Motions of the paper as runs of ``synthesize``: solved as it sets them, judged as ours are.

The paper knows no contact forces. To be judged its motions get those that come nearest to
explaining them, at the places its contact matrix has on the ground; what is left is what no
contact can give.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    from plantigrade.contact.plan import ContactPlan
    from plantigrade.models import Human
    from plantigrade.synthesize.solution import Synthesis
    from plantigrade.synthesize.solvers.interior_point import Iterate
    from plantigrade.synthesize.zhakatayev2023 import PaperSolution
    from plantigrade.synthesize.zhakatayev2023.motions import PaperMotion

FRICTION = 0.8  # of the ground the motions are judged on; the paper has none


def paper_synthesis(
    human: "Human",
    task: str,
    basis: str = "trigonometric",
    progress: "Callable[[str, Iterate], bool | None] | None" = None,
) -> "Synthesis":
    """Return a motion of the paper as one of ours.

    Args:
        human: Who moves; feet of two segments.
        task: ``"walk"``, ``"sit-to-stand"``, ``"side-step"`` or ``"jump"``.
        basis: ``"trigonometric"`` or ``"polynomial"``.
        progress: Told every iteration; returning True stops.

    Raises:
        ParameterError: If the paper has no such motion, or the person other feet.
    """
    from plantigrade.synthesize.solvers.interior_point import Iterate
    from plantigrade.synthesize.zhakatayev2023 import MOTIONS, paper_motion

    if task not in MOTIONS:
        raise ParameterError(f"the paper has no {task!r}; it has {', '.join(MOTIONS)}")

    def told(p: Any) -> bool | None:
        if progress is None:
            return None
        it = Iterate(p.number, p.objective, p.violation, "", np.nan, np.nan, 0.0, 1.0, np.nan)
        return progress("as the paper", it)

    return as_synthesis(paper_motion(human, task, basis, callback=told))


def as_synthesis(solution: "PaperSolution") -> "Synthesis":
    """Return a solution of the paper's problem as a motion with contact forces."""
    from plantigrade.contact.site import foot_sites
    from plantigrade.synthesize.problem.formulation import Body
    from plantigrade.synthesize.solution import Stage, Synthesis
    from plantigrade.synthesize.solvers.interior_point import Iterate
    from plantigrade.synthesize.tasks.task import Task
    from plantigrade.synthesize.terms.contact import Contact
    from plantigrade.synthesize.terms.limits import Limits

    paper, result = solution.paper, solution.result
    body = Body.of(solution.human, foot_sites(solution.human))
    plan = plan_of(paper.motion, solution.human)
    task = Task(
        f"{paper.motion.name} of the paper",
        plan,
        (Contact(friction=FRICTION), Limits()),
        lambda body, plan, times: paper.problem.states(paper.guess, times)[0],
        nodes_per_second=1.0 / paper.motion.step,
        basis=paper.basis,
    )
    last = len(result.stages) - 1
    stages = []
    for k, s in enumerate(result.stages):
        ends = Iterate(
            s.iterations, s.objective, s.violation, s.worst, np.nan, np.nan, 0.0, 1.0, s.seconds
        )
        history = [ends]
        if k == last:
            each = zip(result.history["objective"], result.history["violation"], strict=False)
            history = [
                Iterate(i, float(f), float(v), "", np.nan, np.nan, 0.0, 1.0, np.nan)
                for i, (f, v) in enumerate(each)
            ] + [ends]
        stages.append(
            Stage(s.name, s.solver, len(paper.problem.nodes), s.status, s.seconds, tuple(history))
        )
    standing = np.stack([plan.standing(s, paper.problem.nodes) for s in body.sites], axis=1)
    return Synthesis(
        body, task, paper.problem, result.c, equal_shares(standing), stages[-1].status,
        result.success, tuple(stages),
    )  # fmt: skip


def equal_shares(standing: Bool[Array, "n n_sites"]) -> Float[Array, "n n_unknowns"]:
    """Return body weight shared equally by what stands [body weights]; nothing in flight."""
    u = np.zeros((*standing.shape, 3))
    u[..., 2] = standing / np.maximum(standing.sum(axis=1, keepdims=True), 1)
    return u.reshape(len(standing), -1)


def plan_of(motion: "PaperMotion", human: "Human") -> "ContactPlan":
    """Return the paper's contact matrix as stances of flat feet.

    A foot stands from the first to the last of neighbouring samples at which the matrix has it on
    the ground; between them nothing holds it there.
    """
    from plantigrade.contact.plan import ContactPlan, Footprint, Stance
    from plantigrade.synthesize.guess.postures import standing_feet

    feet, times = standing_feet(human), motion.times
    stances = []
    for side, down in motion.contact.items():
        on = np.flatnonzero(np.diff(np.r_[0, np.asarray(down, int), 0]))
        for a, b in zip(on[::2], on[1::2] - 1, strict=True):
            x, y, z = feet[side].position
            ahead, right = motion.places[side][a]
            place = Footprint(side, (x + float(ahead), y - float(right), z), feet[side].heading)
            start = -1.0 if a == 0 else float(times[a])
            end = motion.duration + 1.0 if b == len(times) - 1 else float(times[b])
            if end > start:
                stances.append(Stance(place, start, start, end, end, end))
    return ContactPlan(motion.duration, tuple(sorted(stances, key=lambda s: s.strike)))
