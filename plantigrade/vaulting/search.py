"""Search for the optimal activations with a downhill simplex or differential evolution.

The *downhill simplex* is the report's method, here SciPy's with the coefficients for many unknowns
of [Gao2012]_. Initial guesses are random, and the simplex restarts at each optimum until the gain
is negligible.

*Differential evolution* [Storn1997]_, also SciPy's, was chosen by measurement. With 8 000
evaluations for 30 unknowns, two searches each, it reached 2.571 and 2.573 m/s in 5 s; CMA-ES
(``cma`` 4.5) reached 2.573 and 2.573 m/s in 17 s, dual annealing 2.532 m/s, the simplex 2.470 to
2.562 m/s.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from time import process_time
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import SolverError
from plantigrade.record.jobs import run_jobs
from plantigrade.vaulting.hand_contact import N_NODES, Vault

OPTIMISERS = ("simplex", "evolution")
NO_TAKE_OFF_COST = 10.0  #: Cost of a vault without take-off [m/s]; worse than any vault
SIMPLEX_EDGE = 0.5  #: Edge of the initial simplex, in units of activation [1]. Chosen
MIN_RESTART_GAIN = 1e-3  #: Minimum gain of a restarted simplex for another restart [m/s]. Chosen
MEMBERS_PER_UNKNOWN = 2
"""Population size of differential evolution per unknown [1]; SciPy rounds 48 and 60 up to 64."""


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of one search."""

    optimiser: str  #: One of :data:`OPTIMISERS`
    seed: int  #: Random seed of the initial guess
    nodes: Float[Array, "k j"]  #: Activation at each node, one column per moving joint
    #: Best value of :meth:`~plantigrade.vaulting.hand_contact.Vault.objective` [m/s]; -inf if the
    #: hands never leave the table
    rise: float
    evaluations: int  #: Number of evaluated vaults
    restarts: int  #: Number of restarts of the simplex
    seconds: float  #: Processor time [s]


@dataclass(frozen=True)
class Search:
    """A search of activations, callable with an optimiser and a seed.

    Args:
        vault: The vault to optimise.
        evaluations: Maximum number of evaluations per search; differential evolution may use a
            third more.
        max_activation: Maximum activation [1]; 1 is full strength.
        first: Initial guess of the simplex; random by default.
    """

    vault: Vault
    evaluations: int = 4000
    max_activation: float = 1.0
    first: Float[Array, "k j"] | None = field(default=None, compare=False)

    def __call__(self, task: tuple[str, int]) -> SearchResult:
        """Return the result for a task (optimiser, seed)."""
        optimiser, seed = task
        began = process_time()
        joints = len(self.vault.segments.joints)
        objective = _Objective(self.vault, joints)
        bounds = [(-self.max_activation, self.max_activation)] * (N_NODES * joints)
        if optimiser == "simplex":
            low, high = np.array(bounds).T
            guess = np.random.default_rng(seed).uniform(low, high)
            guess = guess if self.first is None else self.first.ravel()
            restarts = _simplex(objective, guess, bounds, self.evaluations)
        else:
            restarts = _evolution(objective, seed, bounds, self.evaluations)
        nodes = objective.best.reshape(N_NODES, joints)
        took = process_time() - began
        return SearchResult(
            optimiser, seed, nodes, -objective.lowest, objective.count, restarts, took
        )


class _Objective:
    """The negative objective of a vault; stores the best point."""

    def __init__(self, vault: Vault, joints: int):
        self._vault, self._joints = vault, joints
        self.count, self.lowest = 0, np.inf
        self.best: Array = np.zeros(N_NODES * joints)

    def __call__(self, x: Array) -> float:
        rise = self._vault.objective(x.reshape(N_NODES, self._joints))
        self.count += 1
        if -rise < self.lowest:
            self.lowest, self.best = -rise, np.array(x)
        return -rise if np.isfinite(rise) else NO_TAKE_OFF_COST


def _simplex(
    objective: _Objective, x: Array, bounds: Sequence[tuple[float, float]], max_evaluations: int
) -> int:
    """Minimise with restarts and return the number of restarts."""
    from scipy.optimize import minimize

    low, high = np.array(bounds).T
    size, restarts, before = SIMPLEX_EDGE, 0, np.inf
    while objective.count + len(x) < max_evaluations:
        inward = np.where(x > 0.5 * (low + high), -size, size)
        corners = np.clip(np.vstack([x, x + np.diag(inward)]), low, high)
        options = {
            "initial_simplex": corners,
            "maxfev": min(max_evaluations // 2, max_evaluations - objective.count),
            "adaptive": True,
            "xatol": 1e-3,
            "fatol": 1e-5,
        }
        found = minimize(objective, x, method="Nelder-Mead", bounds=bounds, options=options)
        gained, before, x = before - found.fun, found.fun, found.x
        if gained < MIN_RESTART_GAIN:
            break
        restarts += 1
    return max(restarts - 1, 0)


def _evolution(
    objective: _Objective, seed: int, bounds: list[tuple[float, float]], max_evaluations: int
) -> int:
    from scipy.optimize import differential_evolution

    members = MEMBERS_PER_UNKNOWN * len(bounds)
    differential_evolution(
        objective,
        bounds,
        maxiter=max(max_evaluations // members - 1, 1),
        popsize=MEMBERS_PER_UNKNOWN,
        polish=False,
        rng=seed,
        tol=0.0,
        init="sobol",
    )
    return 0


def search_activations(
    search: Search,
    optimisers: Sequence[str] = OPTIMISERS,
    starts: int = 10,
    *,
    seed: int = 0,
    parallel: Mapping[str, Any] | None = None,
    reached: Callable[[float], None] = lambda share: None,
) -> tuple[SearchResult, ...]:
    """Return the results of all searches, best first.

    Args:
        seed: Random seed of the first start; later starts use consecutive seeds.
        parallel: ``jobs``, ``backend`` and ``address`` of
            :func:`~plantigrade.record.jobs.run_jobs`; sequential if absent.
        reached: Called after each search with the share of them that have ended.

    Raises:
        SolverError: If a search fails.
    """
    found: list[SearchResult] = []
    tasks = [(name, seed + k) for k in range(starts) for name in optimisers]
    for done in run_jobs(search, tasks, **(parallel or {})):
        if done.result is None:
            raise SolverError(f"a search failed: {done.problem}")
        found.append(done.result)
        reached(len(found) / len(tasks))
    return tuple(sorted(found, key=lambda each: -each.rise))
