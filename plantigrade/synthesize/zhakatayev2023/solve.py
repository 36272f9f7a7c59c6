"""One motion of the paper, solved and looked at."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.synthesize.zhakatayev2023.between import Between, Course, between, course
from plantigrade.synthesize.zhakatayev2023.body import PaperBody
from plantigrade.synthesize.zhakatayev2023.conditions import POSTURE, TORQUE
from plantigrade.synthesize.zhakatayev2023.formulation import PaperProblem, formulate
from plantigrade.synthesize.zhakatayev2023.motions import paper_task
from plantigrade.synthesize.zhakatayev2023.record import record_of
from plantigrade.synthesize.zhakatayev2023.staged import StagedResult, solve_staged


@dataclass(frozen=True, eq=False)
class PaperSolution:
    """A motion of the paper.

    Attributes:
        paper: The problem.
        result: What the stages found.
    """

    paper: PaperProblem
    result: StagedResult

    @property
    def human(self) -> Human:
        """Who moves."""
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
        return record_of(self.paper, self.result)

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
        return float(np.sum((samples / TORQUE) ** 2))


def paper_motion(
    human: Human,
    task: str,
    basis: str = "trigonometric",
    *,
    polygon: str = "quadrilateral",
    posture: float = POSTURE,
    say: Callable[[str], None] = lambda _: None,
    callback: Callable[[Any], bool | None] | None = None,
    **options: Any,
) -> PaperSolution:
    """Return a motion of the paper for a person.

    Args:
        human: Who moves; feet of two segments.
        task: ``"walk"``, ``"sit-to-stand"``, ``"side-step"`` or ``"jump"``.
        basis: ``"trigonometric"`` or ``"polynomial"``.
        polygon: ``"quadrilateral"``, as in the paper, or ``"hull"``.
        posture: Cost of angles away from the neutral pose [1/rad²]; zero for Eq. 15 alone.
        say: Called with a line after every try of a stage.
        callback: Called after every iteration; True stops.
        options: Further ones of :func:`~plantigrade.synthesize.zhakatayev2023.staged.solve_staged`.

    Raises:
        ParameterError: If the paper has no such motion, or the person other feet.
    """
    body, motion = PaperBody.of(human), paper_task(task)
    paper = formulate(body, motion, basis=basis, polygon=polygon, posture=posture)
    return PaperSolution(paper, solve_staged(paper, say=say, callback=callback, **options))
