r"""A primal-dual interior point method whose every matrix is a band.

The problem of :mod:`~plantigrade.synthesize.problem.nlp` with slacks :math:`s` for rows that
are inequalities is

.. math:: \min f(x) - \mu \sum \log(s - l) - \mu \sum \log(h - s)
    \quad \text{with} \quad c_E(x) = 0, \; c_I(x) - s = 0.

Slacks and equations are eliminated from Newton's equations,

.. math:: K = W + \delta_w I + J_I^\top \Sigma J_I + \tfrac{1}{\delta_c} J_E^\top J_E,

which is as banded as the Hessian :math:`W` of the Lagrangian, because node rows touch few
coefficients. Its Cholesky factorisation succeeds exactly if the step is one of descent: it is the
inertia test of [Waechter2006]_, and :math:`\delta_w` is raised until it does. The error of order
:math:`\delta_c` that eliminating equations makes is taken out by refinement. Steps are judged by a
filter with a second-order correction, as there; where no step is accepted, Gauss-Newton steps
towards feasibility restore progress.
"""

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import cho_solve_banded

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.synthesize.problem.nlp import Problem
from plantigrade.synthesize.solvers.families import Family, inside, most
from plantigrade.synthesize.solvers.linearised import Linearised

WARM = 5e-5
"""First barrier parameter where multipliers are known: that of the last solution, so that a problem
solved before is solved at once, and one step away in three iterations."""

LONG = 25
"""Iterations in which a violation must halve, or the solver gives up."""

PATIENCE = 5
"""Iterations after which a nearly feasible point waits no longer for a smaller barrier."""

Status = Literal["solved", "acceptable", "stopped", "stalled", "too many iterations"]


@dataclass(frozen=True)
class Options:
    r"""What decides how the solver works; the defaults serve every task.

    Attributes:
        tolerance: Largest error of the optimality conditions, scaled.
        feasibility: Largest violation of a row, in its own unit (where 1 is large).
        acceptable: Optimality error with which a feasible point is good enough once it stalls.
        iterations: Most iterations.
        barrier: First barrier parameter.
        equation: :math:`\delta_c`.
        seconds: Most time [s].
    """

    tolerance: float = 1e-3
    feasibility: float = 1e-6
    acceptable: float = 1e-1
    iterations: int = 150
    barrier: float = 1e-3
    equation: float = 1e-8
    seconds: float = np.inf


@dataclass(frozen=True)
class Iterate:
    r"""What one iteration found.

    Attributes:
        number: Counted from 0.
        objective: Cost.
        violation: Largest violation of a row, in its own unit.
        worst: Which row that is, and when.
        optimality: Error of the optimality conditions, scaled.
        barrier: Barrier parameter.
        regularisation: :math:`\delta_w` that was needed.
        step: Part of the step that was taken.
        seconds: Time since the start [s].
    """

    number: int
    objective: float
    violation: float
    worst: str
    optimality: float
    barrier: float
    regularisation: float
    step: float
    seconds: float


@dataclass(frozen=True)
class Multipliers:
    """What rows push with; a start for a problem much like this one.

    Attributes:
        rows: Name of a family → multipliers of its rows, of lower and of upper limits
            (3, n_nodes, n_rows).
    """

    rows: Mapping[str, Float[Array, "3 n_nodes n_rows"]]

    def moved(
        self, before: Float[Array, " n_nodes"], after: Float[Array, " m_nodes"]
    ) -> "Multipliers":
        """Return multipliers on other nodes: per time they stay the same.

        Args:
            before: Nodes these belong to [s].
            after: When in that motion the nodes of the new problem are [s].
        """
        if len(before) == len(after) and np.allclose(before, after, atol=1e-9):
            return self
        density = (
            np.gradient(after)[:, None] / np.interp(after, before, np.gradient(before))[:, None]
        )
        return Multipliers(
            {
                name: np.stack(
                    [
                        np.stack([np.interp(after, before, x) for x in each.T], axis=1) * density
                        for each in values
                    ]
                )
                for name, values in self.rows.items()
            }
        )


@dataclass(frozen=True)
class Result:
    """Where the solver ended.

    Attributes:
        c: Coefficients (n_coefficients, n_coordinates).
        u: Node unknowns (n_nodes, n_unknowns).
        status: How it ended; ``"solved"`` and ``"acceptable"`` keep every row.
        history: Every iteration.
        multipliers: For a warm start.
    """

    c: Float[Array, "n_coefficients n_coordinates"]
    u: Float[Array, "n_nodes n_unknowns"]
    status: Status
    history: tuple[Iterate, ...]
    multipliers: Multipliers

    @property
    def success(self) -> bool:
        """Whether every row is kept."""
        return self.status in ("solved", "acceptable")


class InteriorPoint(Linearised):
    """The solver of one problem: derivatives, orders and arrays are made once and used again."""

    def __init__(self, problem: Problem, options: Options | None = None):
        super().__init__(problem)
        self.options = options or Options()

    # Solve ------------------------------------------------------------------------------------

    def solve(
        self,
        c0: Float[Array, "n_coefficients nv"],
        u0: Float[Array, "n_nodes nu"] | None = None,
        multipliers: Multipliers | None = None,
        progress: Callable[[Iterate], bool | None] | None = None,
    ) -> Result:
        """Solve from a guess.

        Args:
            c0: Coefficients to start from.
            u0: Node unknowns to start from; zero if absent.
            multipliers: From a problem much like this one.
            progress: Told every iteration; returning True stops with the best so far.

        Returns:
            Where the solver ended; never raises because it failed.

        Raises:
            ParameterError: If the guess is of another shape than the problem, or not finite.
        """
        o, t = self.options, self.t
        self._check_guess(c0, u0)
        started = clock.perf_counter()
        warm = multipliers is not None
        mu = o.barrier if not warm else min(o.barrier, WARM)
        u0 = np.zeros((t.n_nodes, t.nu)) if u0 is None else u0
        x = t.join(c0, u0)
        self._jacobians(x)
        x = self._on_linear_equations(x)
        self._jacobians(x)
        for f in self.families:
            f.s = inside(f, f.r, 1e-2 if not warm else 1e-4)
            a, b = f.room(f.s)
            given = None if multipliers is None else multipliers.rows.get(f.rows.name)
            if given is not None and given.shape[1:] == f.rows.lower.shape:
                f.y, low, high = (x[f.at] for x in given)
                f.y = np.where(f.bound, f.y, 0.0)
            else:
                f.y, low, high = np.zeros_like(f.r), np.zeros_like(f.r), np.zeros_like(f.r)
            f.zl = np.where(f.has_low, np.maximum(low, np.minimum(mu / a, 1.0)), 0.0)
            f.zu = np.where(f.has_high, np.maximum(high, np.minimum(mu / b, 1.0)), 0.0)
        history: list[Iterate] = []
        filter_: list[tuple[float, float]] = []
        dw_last, alpha, dw = 0.0, 0.0, 0.0
        status: Status = "too many iterations"
        best: tuple[float, Array] = (np.inf, x)
        stalls = 0
        at_mu = 0
        for number in range(o.iterations + 1):
            values = [f.r for f in self.families]
            objective = self._objective(x, values)
            pushes = [np.where(f.bound, f.y, 0.0) + f.push(f.r) for f in self.families]
            gradient = self._down(pushes) + t.smoothness(x)[1]
            violation, worst = self._worst(values)
            gaps = [f.gap(f.r, f.s) for f in self.families]
            dual_scale, slack_error = self._scale(), self._slack_error(mu)
            optimality = max(float(np.abs(gradient).max()) / dual_scale, slack_error / dual_scale)
            gap = max(float(np.abs(g).max()) for g in gaps)
            complement0 = self._complement(0.0) / dual_scale
            history.append(
                Iterate(
                    number,
                    objective,
                    violation,
                    worst,
                    max(optimality, complement0),
                    mu,
                    dw,
                    alpha,
                    clock.perf_counter() - started,
                )
            )
            if violation < best[0] or (violation <= o.feasibility and optimality < 1e9):
                best = (violation, x)
            error0 = max(optimality, complement0)
            if error0 <= o.tolerance and violation <= o.feasibility:
                status = "solved"
                break
            if _hopeless(history):
                status = "stalled"
                break
            try:
                told = progress(history[-1]) if progress is not None else False
            except KeyboardInterrupt:
                told = True
            if told or history[-1].seconds > o.seconds:
                status, x = "stopped", best[1]
                break
            # barrier
            at_mu += 1
            while (
                max(optimality, gap, self._complement(mu) / dual_scale) <= 10 * mu
                or (violation < 1e-2 and at_mu > PATIENCE)
            ) and mu > o.tolerance / 20:
                mu = max(o.tolerance / 20, min(0.2 * mu, mu**1.5))
                at_mu = 0
                filter_ = []
                slack_error = self._slack_error(mu)
            # Newton
            sigma = self._sigma()
            squares = [
                each + f.weight + np.where(f.eq, 1.0 / o.equation, 0.0)
                for each, f in zip(sigma, self.families, strict=True)
            ]
            band = t.assemble(self._hessians(x, squares))
            factor, dw = self._factor(band, dw_last)
            if factor is None:
                status = "stalled"
                break
            dw_last = dw if dw > 0 else dw_last / 3.0
            self._factored = (factor, sigma)
            dx, dy, ds, dzl, dzu = self._step(x, gaps, mu)
            # line search
            tau = max(0.99, 1.0 - mu)
            alpha_max, alpha_z = 1.0, 1.0
            for f, d, dl, dh in zip(self.families, ds, dzl, dzu, strict=True):
                a, b = f.room(f.s)
                alpha_max = min(alpha_max, most(a, d, f.has_low, tau))
                alpha_max = min(alpha_max, most(b, -d, f.has_high, tau))
                alpha_z = min(alpha_z, most(np.where(f.has_low, f.zl, 1.0), dl, f.has_low, tau))
                alpha_z = min(alpha_z, most(np.where(f.has_high, f.zu, 1.0), dh, f.has_high, tau))
            theta = sum(float(np.abs(g).sum()) for g in gaps)
            phi = objective - mu * self._logs([f.s for f in self.families])
            slope = self._slope(x, dx, ds, mu)
            accepted, alpha = False, alpha_max
            floor_theta = 1e-4 * max(1.0, history[0].violation)
            for trial_number in range(14):
                x_new = x + alpha * dx
                s_new = [f.s + alpha * d for f, d in zip(self.families, ds, strict=True)]
                r_new = self._values(x_new)
                ok, theta_new = self._acceptable(
                    x_new, r_new, s_new, mu, theta, phi, slope, alpha, filter_, floor_theta
                )
                if ok:
                    accepted = True
                    break
                if trial_number == 0 and theta_new >= 0.5 * theta:
                    found = self._correct(
                        x,
                        dx,
                        ds,
                        alpha,
                        r_new,
                        s_new,
                        mu,
                        tau,
                        theta,
                        phi,
                        slope,
                        filter_,
                        floor_theta,
                    )
                    if found is not None:
                        x_new, s_new, r_new = found
                        accepted = True
                        break
                alpha *= 0.5
            if not accepted:
                stalls += 1
                if stalls > 12:
                    status = "stalled"
                    break
                filter_ = []
                x_new = x + alpha_max * min(1.0, 0.1 * stalls + 0.1) * dx
                alpha = alpha_max * min(1.0, 0.1 * stalls + 0.1)
                s_new = [f.s + alpha * d for f, d in zip(self.families, ds, strict=True)]
                if theta > 1e-6 and stalls % 2 == 0:
                    restored = self._restore(x)
                    if restored is not None:
                        x_new = restored
                        r_new = self._values(x_new)
                        s_new = [
                            inside(f, r, 1e-4) for f, r in zip(self.families, r_new, strict=True)
                        ]
            for f, s, d, dl, dh in zip(self.families, s_new, dy, dzl, dzu, strict=True):
                f.s = f.clear(s)
                f.y = f.y + alpha * d
                f.zl = f.zl + alpha_z * dl
                f.zu = f.zu + alpha_z * dh
                a, b = f.room(f.s)  # keep multipliers within reach of mu / slack
                f.zl = np.where(f.has_low, np.clip(f.zl, mu / (1e10 * a), 1e10 * mu / a), 0.0)
                f.zu = np.where(f.has_high, np.clip(f.zu, mu / (1e10 * b), 1e10 * mu / b), 0.0)
            x = x_new
            self._jacobians(x)
        if status in ("stalled", "too many iterations") and history[-1].violation > 10 * best[0]:
            x = best[1]
        last = history[-1]
        if status not in ("solved", "stopped") and last.violation <= 10 * o.feasibility:
            if last.optimality <= o.acceptable:
                status = "acceptable"
        c, u = t.split(x)
        return Result(
            c,
            u,
            status,
            tuple(history),
            Multipliers({f.rows.name: self._everywhere(f) for f in self.families}),
        )

    def _check_guess(self, c0: Array, u0: Array | None) -> None:
        """Refuse a guess that is none."""
        t = self.t
        for what, given, wanted in (
            ("coefficients", c0, (self.problem.basis.n_coefficients, t.nv)),
            ("unknowns of nodes", u0, (t.n_nodes, t.nu)),
        ):
            if given is not None and given.shape != wanted:
                raise ParameterError(
                    f"the guess has {what} {given.shape}; this problem has {wanted}"
                )
            if given is not None and not np.isfinite(given).all():
                raise ParameterError(f"the guess has {what} that are not finite")

    def _everywhere(self, f: Family) -> Array:
        """Return multipliers of a family at all nodes, zero where it does not matter."""
        out = np.zeros((3, *f.rows.lower.shape))
        out[0, f.at], out[1, f.at], out[2, f.at] = f.y, f.zl, f.zu
        return out

    def _on_linear_equations(self, x: Array) -> Array:
        """Return the point nearest to one that keeps the equations that are linear."""
        stiff = 1e6
        weights = [np.where(f.eq & f.linear, stiff, 0.0) for f in self.families]
        missing = [w * (f.r - f.aim) for f, w in zip(self.families, weights, strict=True)]
        if not any(np.abs(m).max(initial=0.0) > stiff * self.options.feasibility for m in missing):
            return x
        band = self.t.assemble(self._hessians(x, weights, curved=False), smooth=False)
        factor = self._damped(band, 1.0)
        if factor is None:
            return x
        return x - cho_solve_banded((factor, True), self._down(missing), check_finite=False)

    # Pieces of an iteration -------------------------------------------------------------------

    def _step(self, x: Array, gaps: list[Array], mu: float):
        """Return the Newton step of x, y, s and the multipliers of limits."""
        factor, sigma = self._factored
        dc = self.options.equation
        fam = self.families
        # elimination of slacks: y+ = sigma (J dx + gap) + b,  b = -mu/(s-l) + mu/(h-s)
        b = []
        for f in fam:
            a, h = f.room(f.s)
            b.append(np.where(f.has_low, -mu / a, 0.0) + np.where(f.has_high, mu / h, 0.0))
        pushes = [
            f.push(f.r) + np.where(f.eq, f.y + g / dc, 0.0) + np.where(f.ineq, s * g + bb, 0.0)
            for f, g, s, bb in zip(fam, gaps, sigma, b, strict=True)
        ]
        smooth = self.t.smoothness(x)[1]
        dx = -cho_solve_banded((factor, True), self._down(pushes) + smooth, check_finite=False)
        Jdx = self._up(dx)
        dy_eq = [np.where(f.eq, (g + j) / dc, 0.0) for f, g, j in zip(fam, gaps, Jdx, strict=True)]
        for _ in range(3):  # towards the equations themselves
            missing = [np.where(f.eq, g + j, 0.0) for f, g, j in zip(fam, gaps, Jdx, strict=True)]
            size = max(float(np.abs(m).max()) for m in missing)
            if size < 1e-11:
                break
            ddx = -cho_solve_banded(
                (factor, True), self._down([m / dc for m in missing]), check_finite=False
            )
            dx = dx + ddx
            step = self._up(ddx)
            Jdx = [j + d for j, d in zip(Jdx, step, strict=True)]
            dy_eq = [
                y + np.where(f.eq, (m + d) / dc, 0.0)
                for y, f, m, d in zip(dy_eq, fam, missing, step, strict=True)
            ]
        dy, ds, dzl, dzu = [], [], [], []
        for f, g, j, s, bb, ye in zip(fam, gaps, Jdx, sigma, b, dy_eq, strict=True):
            d = np.where(f.ineq, j + g, 0.0)
            ds.append(d)
            dy.append(np.where(f.eq, ye, np.where(f.ineq, s * d + bb - f.y, 0.0)))
            a, h = f.room(f.s)
            dzl.append(np.where(f.has_low, mu / a - f.zl - f.zl / a * d, 0.0))
            dzu.append(np.where(f.has_high, mu / h - f.zu + f.zu / h * d, 0.0))
        return dx, dy, ds, dzl, dzu

    def _acceptable(
        self, x, r, s, mu, theta, phi, slope, alpha, filter_, floor_theta
    ) -> tuple[bool, float]:
        """Return whether a trial point may be taken, and how much it violates rows."""
        gaps = [f.gap(ri, si) for f, ri, si in zip(self.families, r, s, strict=True)]
        theta_new = sum(float(np.abs(g).sum()) for g in gaps)
        if not np.isfinite(theta_new):
            return False, np.inf
        phi_new = self._objective(x, r) - mu * self._logs(s)
        if not np.isfinite(phi_new):
            return False, theta_new
        slack = 1e-10 * max(1.0, abs(phi))
        for ft, fp in filter_:
            if theta_new >= (1 - 1e-5) * ft and phi_new >= fp - 1e-5 * ft + slack:
                return False, theta_new
        if theta <= floor_theta and slope < 0 and alpha * (-slope) ** 2.3 > theta**1.1:
            return phi_new <= phi + 1e-4 * alpha * slope + slack, theta_new
        if theta_new <= (1 - 1e-5) * theta or phi_new <= phi - 1e-5 * theta + slack:
            filter_.append(((1 - 1e-5) * theta, phi - 1e-5 * theta))
            return True, theta_new
        return False, theta_new

    def _correct(
        self, x, dx, ds, alpha, r_new, s_new, mu, tau, theta, phi, slope, filter_, floor_theta
    ):
        """Return a second-order correction of a step, or None."""
        gaps = [
            alpha * f.gap(f.r, f.s) + f.gap(r, s)
            for f, r, s in zip(self.families, r_new, s_new, strict=True)
        ]
        dx2, _, ds2, _, _ = self._step(x, gaps, mu)
        part = 1.0
        for f, d in zip(self.families, ds2, strict=True):
            a, b = f.room(f.s)
            part = min(part, most(a, d, f.has_low, tau), most(b, -d, f.has_high, tau))
        x2 = x + part * dx2
        s2 = [f.s + part * d for f, d in zip(self.families, ds2, strict=True)]
        r2 = self._values(x2)
        ok, _ = self._acceptable(x2, r2, s2, mu, theta, phi, slope, alpha, filter_, floor_theta)
        return (x2, s2, r2) if ok else None

    def _restore(self, x: Array) -> Array | None:
        """Return a point that violates rows less, by damped Gauss-Newton steps; None if none."""
        damping, here = 1e-2, x
        values = self._values(x)
        first = size = self._violated(values)
        for _ in range(15):
            self._jacobians(here)
            off = [np.sign(f.r - f.lower) * f.violation(f.r) for f in self.families]
            marks = [np.where(d != 0.0, 1.0, 0.0) for d in off]
            band = self.t.assemble(self._hessians(here, marks, curved=False))
            g = self._down(off)
            for _ in range(8):
                factor = self._damped(band, damping)
                if factor is None:
                    return None
                trial = here - cho_solve_banded((factor, True), g, check_finite=False)
                after = self._violated(self._values(trial))
                if after < size:
                    here, size, damping = trial, after, max(damping / 4, 1e-8)
                    break
                damping *= 6
            else:
                break
            if size < 1e-4 * first:
                break
        return here if size < 0.5 * first else None

    def _slope(self, x: Array, dx: Array, ds: list[Array], mu: float) -> float:
        """Return the derivative of the barrier function along a step."""
        gradient = self._down([f.push(f.r) for f in self.families]) + self.t.smoothness(x)[1]
        slope = float(gradient @ dx)
        for f, d in zip(self.families, ds, strict=True):
            a, b = f.room(f.s)
            slope -= mu * float(np.sum(np.where(f.has_low, d / a, 0.0)))
            slope += mu * float(np.sum(np.where(f.has_high, d / b, 0.0)))
        return slope

    def _logs(self, slacks: Sequence[Array]) -> float:
        total = 0.0
        for f, s in zip(self.families, slacks, strict=True):
            a, b = f.room(s)
            if a.min() <= 0 or b.min() <= 0:
                return -np.inf
            total += float(np.sum(np.log(a)) + np.sum(np.log(b)))
        return total

    def _scale(self) -> float:
        """Return by how much large multipliers excuse a large gradient [Waechter2006]_."""
        total, count = 0.0, 1
        for f in self.families:
            total += float(np.abs(f.y).sum() + f.zl.sum() + f.zu.sum())
            count += int(f.eq.sum() + f.ineq.sum() + f.has_low.sum() + f.has_high.sum())
        return max(1.0, total / count / 100.0) if count else 1.0

    def _slack_error(self, mu: float) -> float:
        return max(
            float(np.abs(np.where(f.ineq, -f.y - f.zl + f.zu, 0.0)).max()) for f in self.families
        )

    def _complement(self, mu: float) -> float:
        worst = 0.0
        for f in self.families:
            a, b = f.room(f.s)
            worst = max(
                worst,
                float(np.abs(np.where(f.has_low, f.zl * a - mu, 0.0)).max()),
                float(np.abs(np.where(f.has_high, f.zu * b - mu, 0.0)).max()),
            )
        return worst


def _hopeless(history: Sequence[Iterate]) -> bool:
    """Return whether the violation, still large, has not halved for long."""
    if len(history) <= 2 * LONG:
        return False
    recent = min(it.violation for it in history[-LONG:])
    return recent > 1e-3 and recent > 0.5 * min(it.violation for it in history[:-LONG])
