"""Search for the best activations: the report's downhill simplex, and a modern method.

The report's *downhill simplex* is SciPy's, with the coefficients for many unknowns of [Gao2012]_.
As there, first guesses vary, and each optimum found is where the next simplex starts, until that
brings nothing more.

*Differential evolution* [Storn1997]_ is SciPy's too. It was chosen by measurement: with 8 000
evaluations for 30 unknowns, two searches each, it ended at 2.571 and 2.573 m/s in 5 s; CMA-ES
(``cma`` 4.5) at 2.573 and 2.573 m/s in 17 s, dual annealing at 2.532 m/s, the simplex at 2.470 to
2.562 m/s. It needs no further library.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import process_time
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import SolverError
from plantigrade.record.jobs import run_jobs
from plantigrade.vaulting.simulation import NODES, Vault

OPTIMISERS = ("simplex", "evolution")
MISSED = 10.0
"""What hands that do not leave the table count [m/s]: worse than any vault."""
REACH = 0.5
"""Edge of a first simplex, in activation."""
GAIN = 1e-3
"""A repeated simplex that gains less than this is the last [m/s]."""
POPULATION = 2
"""Members of a population for every unknown; SciPy makes 64 of 48 and of 60 of them."""


@dataclass(frozen=True, eq=False)
class Found:
    """What one search found.

    Attributes:
        optimiser: One of :data:`OPTIMISERS`.
        seed: Of its first guess.
        nodes: Activation at each node, one column a joint that moves.
        rise: Velocity of the centre of mass upward at take-off, less what :meth:`Vault.worth` takes
            off for joints that run into their ends [m/s]; -inf if the hands never leave.
        evaluations: How many vaults were tried.
        restarts: How often a simplex was started again.
        seconds: Processor time [s].
    """

    optimiser: str
    seed: int
    nodes: Float[Array, "k j"]
    rise: float
    evaluations: int
    restarts: int
    seconds: float


@dataclass(frozen=True)
class Search:
    """How activations are searched.

    Args:
        vault: The gymnast who arrives.
        evaluations: How many vaults one search may try; evolution tries up to a third more.
        most: Greatest activation, 1 is all the strength.
        first: Where a simplex starts, instead of anywhere.
    """

    vault: Vault
    evaluations: int = 4000
    most: float = 1.0
    first: Float[Array, "k j"] | None = field(default=None, compare=False)

    def __call__(self, task: tuple[str, int]) -> Found:
        """Return what a search by that optimiser finds from that seed."""
        optimiser, seed = task
        began = process_time()
        joints = len(self.vault.segments.joints)
        tried = _Tried(self.vault, joints)
        bounds = [(-self.most, self.most)] * (NODES * joints)
        if optimiser == "simplex":
            guess = np.random.default_rng(seed).uniform(-self.most, self.most, len(bounds))
            guess = guess if self.first is None else self.first.ravel()
            restarts = _simplex(tried, guess, bounds, self.evaluations)
        else:
            restarts = _evolution(tried, seed, bounds, self.evaluations)
        nodes = tried.best.reshape(NODES, joints)
        took = process_time() - began
        return Found(optimiser, seed, nodes, -tried.lowest, tried.count, restarts, took)


class _Tried:
    """The objective, which remembers its best."""

    def __init__(self, vault: Vault, joints: int):
        self._vault, self._joints = vault, joints
        self.count, self.lowest = 0, np.inf
        self.best: Array = np.zeros(NODES * joints)

    def __call__(self, x: Array) -> float:
        rise = self._vault.worth(x.reshape(NODES, self._joints))
        self.count += 1
        if -rise < self.lowest:
            self.lowest, self.best = -rise, np.array(x)
        return -rise if np.isfinite(rise) else MISSED


def _simplex(tried: _Tried, x: Array, bounds: Sequence[tuple[float, float]], most: int) -> int:
    """Descend, and again from where that ended; return how often."""
    from scipy.optimize import minimize

    low, high = np.array(bounds).T
    size, restarts, before = REACH, 0, np.inf
    while tried.count + len(x) < most:
        inward = np.where(x > 0.5 * (low + high), -size, size)
        corners = np.clip(np.vstack([x, x + np.diag(inward)]), low, high)
        options = {
            "initial_simplex": corners,
            "maxfev": min(most // 2, most - tried.count),
            "adaptive": True,
            "xatol": 1e-3,
            "fatol": 1e-5,
        }
        found = minimize(tried, x, method="Nelder-Mead", bounds=bounds, options=options)
        gained, before, x = before - found.fun, found.fun, found.x
        if gained < GAIN:
            break
        restarts += 1
    return max(restarts - 1, 0)


def _evolution(tried: _Tried, seed: int, bounds: list[tuple[float, float]], most: int) -> int:
    from scipy.optimize import differential_evolution

    members = POPULATION * len(bounds)
    differential_evolution(
        tried,
        bounds,
        maxiter=max(most // members - 1, 1),
        popsize=POPULATION,
        polish=False,
        rng=seed,
        tol=0.0,
        init="sobol",
    )
    return 0


def searched(
    search: Search,
    optimisers: Sequence[str] = OPTIMISERS,
    starts: int = 10,
    *,
    seed: int = 0,
    parallel: Mapping[str, Any] | None = None,
) -> tuple[Found, ...]:
    """Return what all searches found, the best first.

    Args:
        search: How each is done.
        optimisers: Which are used.
        starts: Searches of each.
        seed: Of the first start; the others count on.
        parallel: How they are done side by side: ``jobs``, ``backend`` and ``address`` of
            :func:`~plantigrade.record.jobs.run_jobs`; one after the other if absent.

    Raises:
        SolverError: If one could not be done.
    """
    found: list[Found] = []
    tasks = [(name, seed + k) for k in range(starts) for name in optimisers]
    for done in run_jobs(search, tasks, **(parallel or {})):
        if done.result is None:
            raise SolverError(f"a search failed: {done.problem}")
        found.append(done.result)
    return tuple(sorted(found, key=lambda each: -each.rise))
