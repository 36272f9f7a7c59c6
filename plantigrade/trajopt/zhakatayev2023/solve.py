"""One motion of the paper, solved, looked at, and as a Record.

The paper knows no contact forces. To be judged its motions get those that come nearest to
explaining them, at the sites its contact matrix has on the ground; what is left is what no contact
can give.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import FRICTION
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.contact.site import foot_sites
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import runs
from plantigrade.record import Limits as RecordLimits
from plantigrade.record import Record
from plantigrade.trajopt.contact_record import contact_record
from plantigrade.trajopt.guess.postures import standing_feet
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.sampling import sample
from plantigrade.trajopt.solution import Stage, solver_signals
from plantigrade.trajopt.solvers.result import Iterate
from plantigrade.trajopt.terms.contact import Contact
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.zhakatayev2023.between_samples import (
    REFINEMENT_FACTOR,
    Between,
    Course,
    between,
    course,
)
from plantigrade.trajopt.zhakatayev2023.body import PaperBody
from plantigrade.trajopt.zhakatayev2023.conditions import MAX_TORQUE
from plantigrade.trajopt.zhakatayev2023.formulation import PaperProblem, formulate
from plantigrade.trajopt.zhakatayev2023.motions import PaperMotion, paper_task
from plantigrade.trajopt.zhakatayev2023.staged import StagedResult, solve_staged


@dataclass(frozen=True, eq=False)
class PaperSolution:
    """A motion of the paper."""

    paper: PaperProblem
    result: StagedResult  # what the stages found

    @property
    def human(self) -> Human:
        """The person."""
        return self.paper.body.human

    @cached_property
    def course(self) -> Course:
        """The motion, ten times as fine as its samples."""
        return course(self.paper, self.result.c)

    @cached_property
    def between(self) -> Between:
        """Its faults between the samples."""
        return between(self.paper, self.result.c)

    def motion(self, rate: float = 100.0) -> Motion:
        """Return it as a motion of frames, ``rate`` a second."""
        n = round(self.paper.motion.duration * rate)
        times = np.linspace(0.0, self.paper.motion.duration, n + 1)
        states = self.paper.problem.states(self.result.c, times)
        qpos, qvel, _ = self.paper.body.symbolic.to_mujoco(*states)
        return Motion(times, qpos, qvel, self.human.joint_names)

    def record(self) -> Record:
        """Return what happened, with the contact forces that come nearest to explaining it."""
        paper, result, human = self.paper, self.result, self.human
        times = paper.problem.nodes
        plan = plan_of(paper.motion, human)
        body = ContactBody(human, foot_sites(human))
        standing = np.stack([plan.standing(s, times) for s in body.sites], axis=1)
        n = REFINEMENT_FACTOR * (len(times) - 1) + 1
        fine = np.linspace(times[0], times[-1], n)
        shares = equal_shares(standing)
        sampled = sample(body, plan, paper.problem, result.c, shares, fine, FRICTION)
        limits, stages = Limits(), []
        for s in result.stages:  # of the last one every iteration, of the others the end
            end = Iterate(s.iterations, s.objective, s.violation, s.worst, seconds=s.seconds)
            history = (*(result.history if s is result.stages[-1] else ()), end)
            stages.append(Stage(s.name, s.solver, len(times), s.status, s.seconds, history))
        return contact_record(
            body,
            sampled,
            plan,
            friction=FRICTION,
            walks=paper.motion.name == "walk",
            limits=RecordLimits(
                velocity=limits.speed,
                torque=limits.torques(human),
                force=Contact().force * body.weight,
            ),
            signals=solver_signals(stages, []),
        )

    def coordinate(self, name: str) -> Float[Array, " n_times"]:
        """Return a coordinate on the grid of :attr:`course` [rad, m]."""
        return self.course.q[:, self.paper.body.index(name)]

    def rate(self, name: str) -> Float[Array, " n_times"]:
        """Return a rate on the grid of :attr:`course` [rad/s, m/s]."""
        return self.course.qd[:, self.paper.body.index(name)]

    @property
    def effort(self) -> float:
        """Eq. 15: squared joint torques over 200 N m, summed over joints and samples."""
        at = np.searchsorted(self.course.times, self.paper.motion.times - 1e-9)
        samples = self.course.torques[at]
        return float(np.sum((samples / MAX_TORQUE) ** 2))


def paper_motion(
    human: Human,
    task: str,
    basis: str = "trigonometric",
    *,
    say: Callable[[str], None] = lambda _: None,
    callback: Callable[[Any], bool | None] | None = None,
    **options: Any,
) -> PaperSolution:
    """Return a motion of the paper for a person.

    Args:
        human: The person; feet of two segments.
        task: ``"walk"``, ``"sit-to-stand"``, ``"side-step"`` or ``"jump"``.
        basis: ``"trigonometric"`` or ``"polynomial"``.
        say: Called with a line after every try of a stage.
        callback: Called after every iteration; True stops.
        options: Further ones of :func:`~plantigrade.trajopt.zhakatayev2023.staged.solve_staged`.

    Raises:
        ParameterError: If the paper has no such motion, or the person other feet.
    """
    body, motion = PaperBody.of(human), paper_task(task)
    paper = formulate(body, motion, basis=basis)
    return PaperSolution(paper, solve_staged(paper, say=say, callback=callback, **options))


def equal_shares(standing: Bool[Array, "n n_sites"]) -> Float[Array, "n n_unknowns"]:
    """Return body weight shared equally by what stands [body weights]; nothing in flight."""
    u = np.zeros((*standing.shape, 3))
    u[..., 2] = standing / np.maximum(standing.sum(axis=1, keepdims=True), 1)
    return u.reshape(len(standing), -1)


def plan_of(motion: PaperMotion, human: Human) -> ContactPlan:
    """Return the paper's contact matrix as stances of flat feet.

    A foot stands from the first to the last of neighbouring samples at which the matrix has it on
    the ground; between them nothing holds it there.
    """
    feet, times = standing_feet(human), motion.times
    stances = []
    for side, down in motion.contact.items():
        for a, b in ((run.start, run.stop - 1) for run in runs(np.asarray(down, dtype=bool))):
            x, y, z = feet[side].position
            ahead, right = motion.places[side][a]
            place = Footprint(side, (x + float(ahead), y - float(right), z), feet[side].heading)
            start = -1.0 if a == 0 else float(times[a])
            end = motion.duration + 1.0 if b == len(times) - 1 else float(times[b])
            if end > start:
                stances.append(Stance(place, start, start, end, end, end))
    return ContactPlan(motion.duration, tuple(sorted(stances, key=lambda s: s.heel_strike)))
