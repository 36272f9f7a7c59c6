r"""How far to go along a Newton step: a backtracking line search with a filter [Waechter2006]_.

A trial point is judged by two numbers, the sum of constraint residuals :math:`\theta` and the
barrier function :math:`\varphi = f - \mu \sum \log(s - l) - \mu \sum \log(h - s)`. The filter holds
pairs that no later point may be worse than in both. No step may make the worst violation
of a row much worse: a foot that steps through the other leg stays on the wrong side of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array
from plantigrade.trajopt.solvers.kkt import KKTSystem, Step
from plantigrade.trajopt.solvers.slacks import Slacks
from plantigrade.trajopt.transcription.evaluation import Evaluation

MAX_TRIALS = 14  #: Maximum number of step lengths, each half the previous one [1]
MAX_RESIDUAL = 0.3
"""Residual of a constraint that every trial point may have, in its own unit (body weights, radians,
0.1 m between limbs). Chosen: with 0.1 to 0.35 a walk of 66 coordinates on multi-segment feet is
solved at the first try, in a third of the iterations."""
MAX_RESIDUAL_GROWTH = 2.0
"""Factor by which a trial point may raise the largest residual beyond that [1]. Chosen: a guess far
off, as of a jump, is solved as soon as without a limit."""
FILTER_MARGIN = 1e-5  #: Relative improvement required by the filter [1]
MAX_CORRECTIONS = 2  #: Maximum number of corrections of a step shortened by limits [1]
SHORT_STEP = 0.5  #: Step fraction below which a step is corrected [1]
CORRECTION_TARGET = 0.3  #: Increase of the step fraction targeted by a correction [1]
MIN_CORRECTION_GAIN = 1.1  #: Minimum ratio of step fractions for an accepted correction [1]


@dataclass(frozen=True)
class Merit:
    r"""Merit of a point: :math:`\theta`, :math:`\varphi` and the largest residual."""

    residual: float
    barrier: float
    largest: float


@dataclass(frozen=True, eq=False)
class TrialPoint:
    """A point with its slacks and rows, and the fraction of the step that led there."""

    x: Array
    s: list[Array]
    r: list[Array]
    alpha: float


class Filter:
    """Pairs of residual and barrier function that no later point may be worse than in both."""

    def __init__(self, floor: float):
        self._floor = floor
        self._pairs: list[Merit] = []

    def clear(self) -> None:
        """Forget all pairs."""
        self._pairs = []

    def accepts(self, trial: Merit, here: Merit, slope: float, alpha: float) -> bool:
        """Return whether a trial point may be taken; remember the present one if it may."""
        theta, phi = here.residual, here.barrier
        if not (np.isfinite(trial.residual) and np.isfinite(trial.barrier)):
            return False
        if trial.largest > max(MAX_RESIDUAL, MAX_RESIDUAL_GROWTH * here.largest):
            return False
        rounding = 1e-10 * max(1.0, abs(phi))
        for pair in self._pairs:
            limit = pair.barrier - FILTER_MARGIN * pair.residual + rounding
            if trial.residual >= (1 - FILTER_MARGIN) * pair.residual and trial.barrier >= limit:
                return False
        if theta <= self._floor and slope < 0 and alpha * (-slope) ** 2.3 > theta**1.1:
            return trial.barrier <= phi + 1e-4 * alpha * slope + rounding
        better = trial.residual <= (1 - FILTER_MARGIN) * theta
        if better or trial.barrier <= phi - FILTER_MARGIN * theta + rounding:
            theta, phi = (1 - FILTER_MARGIN) * theta, phi - FILTER_MARGIN * theta
            self._pairs.append(Merit(theta, phi, here.largest))
            return True
        return False


class LineSearch:
    """The search along a step from a point at which the problem is linearised."""

    def __init__(
        self,
        evaluation: Evaluation,
        slacks: Sequence[Slacks],
        x: Array,
        step: Step,
        mu: float,
        objective: float,
    ):
        self._e, self._slacks, self._x, self._step, self._mu = evaluation, slacks, x, step, mu
        self.tau = boundary(mu)
        self.alpha_max, self.alpha_dual = fractions(slacks, step, self.tau)
        self.gaps = [s.gap(s.block.r, s.s) for s in slacks]
        self.here = self._merit(objective, [s.s for s in slacks], self.gaps)

    def run(self, filter_: Filter, kkt: KKTSystem) -> TrialPoint | None:
        """Return the first point that the filter accepts; None if there is none."""
        slope = self._slope()
        alpha = self.alpha_max
        for number in range(MAX_TRIALS):
            trial = self.trial(alpha)
            merit = self._merit_of(trial)
            if filter_.accepts(merit, self.here, slope, alpha):
                return trial
            if number == 0 and merit.residual >= 0.5 * self.here.residual:
                corrected = self._corrected(trial, kkt)
                if filter_.accepts(self._merit_of(corrected), self.here, slope, alpha):
                    return corrected
            alpha *= 0.5
        return None

    def trial(self, alpha: float) -> TrialPoint:
        """Return the point at a fraction of the step."""
        return self._along(self._step, alpha, alpha)

    def _along(self, step: Step, part: float, alpha: float) -> TrialPoint:
        """Return the point at a part of a step, to be known as that of a fraction alpha."""
        x = self._x + part * step.x
        s = [s.s + part * d for s, d in zip(self._slacks, step.s, strict=True)]
        return TrialPoint(x, s, self._e.values(x), alpha)

    def _corrected(self, trial: TrialPoint, kkt: KKTSystem) -> TrialPoint:
        """Return the second-order correction of a trial point."""
        gaps = [
            trial.alpha * gap + s.gap(r, new)
            for gap, s, r, new in zip(self.gaps, self._slacks, trial.r, trial.s, strict=True)
        ]
        step = kkt.step(self._x, gaps, self._mu)
        return self._along(step, self._largest(step.s), trial.alpha)

    def _largest(self, ds: Sequence[Array]) -> float:
        """Return the largest fraction of a step of all slacks."""
        return min(
            [1.0, *(x.largest_step(d, self.tau) for x, d in zip(self._slacks, ds, strict=True))]
        )

    def _merit_of(self, trial: TrialPoint) -> Merit:
        gaps = [s.gap(r, new) for s, r, new in zip(self._slacks, trial.r, trial.s, strict=True)]
        return self._merit(self._e.objective(trial.x, trial.r), trial.s, gaps)

    def _merit(self, objective: float, slacks: Sequence[Array], gaps: Sequence[Array]) -> Merit:
        logarithms = sum(s.log_barrier(each) for s, each in zip(self._slacks, slacks, strict=True))
        residual = sum(float(np.abs(gap).sum()) for gap in gaps)
        residual = residual if np.isfinite(residual) else np.inf
        largest = max(float(np.abs(gap).max(initial=0.0)) for gap in gaps)
        return Merit(residual, objective - self._mu * logarithms, largest)

    def _slope(self) -> float:
        """Return the derivative of the barrier function along the step."""
        slope = float(self._e.t.smoothness(self._x)[1] @ self._step.x)
        for b, r in zip(self._e.blocks, self._step.r, strict=True):
            slope += float(np.sum(b.cost_gradient(b.r) * r))
        for s, d in zip(self._slacks, self._step.s, strict=True):
            slope += float(np.sum(s.barrier_force(self._mu) * d))
        return slope


def boundary(mu: float) -> float:
    """Return the part of the way to a limit that a step may go [Waechter2006]_."""
    return max(0.99, 1.0 - mu)


def fractions(slacks: Sequence[Slacks], step: Step, tau: float) -> tuple[float, float]:
    """Return the largest fractions of a step that slacks, and multipliers of limits, can take."""
    primal = [s.largest_step(ds, tau) for s, ds in zip(slacks, step.s, strict=True)]
    dual = [s.largest_dual_step(dz, tau) for s, dz in zip(slacks, step.z, strict=True)]
    return min([1.0, *primal]), min([1.0, *dual])


def recentred(kkt: KKTSystem, slacks: Sequence[Slacks], step: Step, mu: float) -> Step:
    """Return a step that limits stop later, where they stop the Newton step early.

    Somewhat further along, products of multipliers and distances that would be far from the barrier
    parameter are brought back [Gondzio1996]_. That takes the factor that is there.
    """
    tau = boundary(mu)
    reach = fractions(slacks, step, tau)
    for _ in range(MAX_CORRECTIONS):
        if reach[0] > SHORT_STEP:
            break
        aim = min(1.0, reach[0] + CORRECTION_TARGET), min(1.0, reach[1] + CORRECTION_TARGET)
        pairs = zip(slacks, step.s, step.z, strict=True)
        other = kkt.recentred(step, [s.off_centre(ds, dz, *aim, mu) for s, ds, dz in pairs])
        longer = fractions(slacks, other, tau)
        if longer[0] < MIN_CORRECTION_GAIN * reach[0]:
            break
        step, reach = other, longer
    return step
