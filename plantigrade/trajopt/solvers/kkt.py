r"""Newton's equations of the barrier problem, as one banded matrix.

Slacks and equations are eliminated,

.. math:: K = W + \delta_w I + J_I^\top \Sigma J_I + \tfrac{1}{\delta_c} J_E^\top J_E,

which is as banded as the Hessian :math:`W` of the Lagrangian, because the rows of a node touch few
coefficients. The error of order :math:`\delta_c` made by eliminating equations is removed by
iterative refinement.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

from plantigrade.arrays import Array
from plantigrade.trajopt.solvers.slacks import Slacks
from plantigrade.trajopt.transcription.evaluation import Evaluation

MAX_REFINEMENTS = 3  #: Maximum number of iterative refinement steps [1]
EQUATION_TOLERANCE = 1e-6
"""Relative residual of the equations after refinement [1]; their curvature leaves more."""
RESIDUAL_TOLERANCE = 1e-11  #: Residual below which refinement stops [1]
SHIFT_GROWTH = 8.0  #: Growth factor of an insufficient shift [1]
SMALL_SHIFT = 0.5  #: Previous shift below which zero is tried first [1]


FIRST_ORDER_SHIFT = 1e-3
"""Shift of a matrix without second derivatives, which would otherwise be singular [1]."""


@dataclass(frozen=True, eq=False)
class Step:
    """A Newton step of variables, and by block of rows, multipliers and slacks."""

    x: Array
    r: list[Array]  # to first order
    y: list[Array]
    s: list[Array]
    z: list[Array]


class KKTSystem:
    r"""The matrix at one point after the other.

    Attributes:
        shift: :math:`\delta_w` of the last factorisation.
    """

    def __init__(self, evaluation: Evaluation, slacks: Sequence[Slacks], regularisation: float):
        self._evaluation, self._slacks, self._delta = evaluation, slacks, regularisation
        self.forget()

    def forget(self) -> None:
        """Forget the shifts of earlier factorisations."""
        self.shift = self._before = 0.0

    def factorise(self, x: Array, *, curved: bool = True) -> bool:
        """Factorise the matrix at the point that was linearised last; False if that failed.

        The Cholesky factorisation succeeds exactly if the step is one of descent: it is the inertia
        test of [Waechter2006]_. Without the second derivatives of rows (``curved``) the matrix is
        that of Gauss and Newton, which needs no other test.
        """
        e = self._evaluation
        self._sigma = [s.stiffness() for s in self._slacks]
        squares = [
            sigma + b.weight + np.where(b.equations, 1.0 / self._delta, 0.0)
            for sigma, b in zip(self._sigma, e.blocks, strict=True)
        ]
        multipliers = lagrangian(self._slacks) if curved else None
        band = e.t.assemble(e.hessians(x, squares, multipliers))
        if not curved:
            self._factor, self.shift = factorised_with_least_shift(
                band, FIRST_ORDER_SHIFT, FIRST_ORDER_SHIFT
            )
            return self._factor is not None
        self._factor, self.shift = factorised_with_least_shift(band, self._before)
        self._before = self.shift if self.shift > 0 else self._before / 3.0
        return self._factor is not None

    def step(self, x: Array, gaps: Sequence[Array], mu: float) -> Step:
        """Return the Newton step for residuals of the constraints."""
        e, delta, slacks = self._evaluation, self._delta, self._slacks
        assert self._factor is not None
        forces = [s.barrier_force(mu) for s in slacks]
        # elimination of slacks: y + dy = sigma (J dx + gap) + force
        pushes = [
            b.cost_gradient(b.r)
            + np.where(b.equations, s.y + gap / delta, 0.0)
            + np.where(b.inequalities, sigma * gap + force, 0.0)
            for b, s, gap, sigma, force in zip(
                e.blocks, slacks, gaps, self._sigma, forces, strict=True
            )
        ]
        dx = -solved(self._factor, e.pull_back(pushes) + e.t.smoothness(x)[1])
        Jdx = e.push_forward(dx, equations=True)
        equations = [b.equations for b in e.blocks]

        def residuals() -> list[Array]:
            every = zip(equations, gaps, Jdx, strict=True)
            return [np.where(eq, gap + j, 0.0) for eq, gap, j in every]

        dy_eq = [m / delta for m in residuals()]
        far = [np.where(eq, gap, 0.0) for eq, gap in zip(equations, gaps, strict=True)]
        enough = max(
            EQUATION_TOLERANCE * max(float(np.abs(m).max()) for m in far), RESIDUAL_TOLERANCE
        )
        for _ in range(MAX_REFINEMENTS):
            missing = residuals()
            if max(float(np.abs(m).max()) for m in missing) < enough:
                break
            pushes = [m / delta for m in missing]
            ddx = -solved(self._factor, e.pull_back(pushes, equations=True))
            dx = dx + ddx
            change = e.push_forward(ddx, equations=True)
            Jdx = [j + d for j, d in zip(Jdx, change, strict=True)]
            dy_eq = [
                y + np.where(eq, (m + d) / delta, 0.0)
                for y, eq, m, d in zip(dy_eq, equations, missing, change, strict=True)
            ]
        Jdx = e.push_forward(dx)
        step = Step(dx, Jdx, [], [], [])
        for s, gap, j, sigma, force, y in zip(
            slacks, gaps, Jdx, self._sigma, forces, dy_eq, strict=True
        ):
            b = s.block
            ds = np.where(b.inequalities, j + gap, 0.0)
            dy = np.where(b.inequalities, sigma * ds + force - s.y, 0.0)
            step.s.append(ds)
            step.y.append(np.where(b.equations, y, dy))
            step.z.append(s.multiplier_steps(ds, mu))
        return step

    def recentred(self, step: Step, changes: Sequence[Array]) -> Step:
        """Return a step that changes products of limits' multipliers and distances as well.

        Args:
            changes: Desired change of each product (2, n_nodes, n_rows).
        """
        e, slacks = self._evaluation, self._slacks
        assert self._factor is not None
        forces = [s.barrier_force(each) for s, each in zip(slacks, changes, strict=True)]
        dx = -solved(self._factor, e.pull_back(forces))
        Jdx = e.push_forward(dx)
        new = Step(step.x + dx, [r + j for r, j in zip(step.r, Jdx, strict=True)], [], [], [])
        every = zip(slacks, Jdx, self._sigma, forces, changes, strict=True)
        for i, (s, j, sigma, force, change) in enumerate(every):
            b = s.block
            dy = np.where(b.inequalities, sigma * j + force, 0.0)
            new.y.append(step.y[i] + np.where(b.equations, j / self._delta, dy))
            new.s.append(step.s[i] + np.where(b.inequalities, j, 0.0))
            new.z.append(step.z[i] + s.changed_steps(j, change))
        return new


def lagrangian(slacks: Sequence[Slacks]) -> list[Array]:
    """Return the derivative of the Lagrangian by the rows of every block."""
    return [np.where(s.block.bound, s.y, 0.0) + s.block.cost_gradient(s.block.r) for s in slacks]


def factorised(band: Array, shift: float) -> Array | None:
    """Return the Cholesky factor of a matrix plus a multiple of the identity; None if indefinite.

    The matrix is in lower form: entry (i, j) at ``[i - j, j]``.
    """
    trial = band.copy(order="F")
    trial[0] += shift
    try:
        return cholesky_banded(trial, overwrite_ab=True, lower=True, check_finite=False)
    except LinAlgError:
        return None


def factorised_with_least_shift(
    band: Array, before: float, least: float = 0.0
) -> tuple[Array | None, float]:
    """Return the factor and the shift it took, near that of ``before``; None if none was enough."""
    shift = least if before < SMALL_SHIFT else before / 4.0
    for _ in range(40):
        factor = factorised(band, shift + 1e-12)
        if factor is not None:
            return factor, shift
        shift = shift * SHIFT_GROWTH if shift else max(before / 3.0, 1e-3)
    return None, shift


def solved(factor: Array, right: Array) -> Array:
    """Return the solution of the equations with a factor and a right side."""
    return np.asarray(cho_solve_banded((factor, True), right, check_finite=False))
