"""A motion of the paper as a trajectory problem, with the guess it starts from."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.splines.basis import Basis
from plantigrade.trajopt.splines.knots import clamped_knots
from plantigrade.trajopt.tasks.task import BASES
from plantigrade.trajopt.zhakatayev2023 import conditions
from plantigrade.trajopt.zhakatayev2023.body import PaperBody, Pose
from plantigrade.trajopt.zhakatayev2023.motions import PaperMotion

DEGREE = 3  # of the splines: accelerations are continuous


@dataclass(frozen=True, eq=False)
class PaperProblem:
    """A motion of the paper, ready to solve."""

    body: PaperBody
    motion: PaperMotion
    problem: Problem  # rows at the sample times
    start: Pose  # first pose [rad, m]
    end: Pose  # last pose; of a jump, all of it that is not free
    # coefficients of the straight way from the first pose to the last
    guess: Float[Array, "n_coefficients nv"]

    @property
    def n_constraints(self) -> int:
        """Constraints as the paper counts them: equations twice, boundary conditions not.

        Limits of coordinates, rates and generalised forces, and heights of contact points, count
        at every sample, also where something else fixes them.
        """
        count = 0
        for rows in self.problem.rows:
            if rows.name in ("coordinates", "rates"):
                count += 2 * rows.lower.size
            elif rows.name == "floor":
                count += rows.lower.size
            elif rows.name != "boundary":
                count += int(np.isfinite(rows.lower).sum() + np.isfinite(rows.upper).sum())
        return count


def spline(motion: PaperMotion, basis: str) -> Basis:
    """Return the spline of a motion: clamped, of degree 3, with the printed coefficients.

    Raises:
        ParameterError: If the basis is unknown.
    """
    if basis not in BASES:
        raise ParameterError(f"{basis=} must be one of {', '.join(BASES)}")
    breaks = np.linspace(0.0, motion.duration, motion.n_coefficients - DEGREE + 1)
    return BASES[basis](DEGREE, clamped_knots(breaks, DEGREE))


def formulate(
    body: PaperBody, motion: PaperMotion, *, basis: str = "trigonometric"
) -> PaperProblem:
    """Return the problem of a motion.

    Args:
        basis: ``"trigonometric"`` or ``"polynomial"``.

    Raises:
        ParameterError: If the basis is unknown.
    """
    start, end = poses(body, motion)
    rows = (
        conditions.boundary(body, motion, start, end),
        conditions.coordinates(body, motion, start, end),
        conditions.rates(body, motion),
        conditions.forces(body, motion),
        conditions.pelvis(body, motion),
        conditions.floor(body, motion),
        conditions.places(body, motion),
        conditions.slip(body, motion),
        conditions.arms(body, motion),
        conditions.knee(body, motion),
        conditions.apex(body, motion),
    )
    used = spline(motion, basis)
    none = np.zeros((motion.n_samples, 0))
    problem = Problem(used, motion.times, body.names, rows, (), none, none, none[1:])
    times = np.linspace(0.0, motion.duration, 10 * motion.n_coefficients)
    way = start + (times / motion.duration)[:, None] * (end - start)
    return PaperProblem(body, motion, problem, start, end, used.fit(times, way))


def poses(body: PaperBody, motion: PaperMotion) -> tuple[Pose, Pose]:
    """Return the first and the last pose of a motion (section VI)."""
    start, end = body.neutral.copy(), body.neutral.copy()
    if motion.start == "seated":
        return body.seated(), end
    if motion.travel is not None:
        end[body.index("pelvis_tx")] += motion.travel[0]
        end[body.index("pelvis_tz")] += motion.travel[1]
    return start, end
