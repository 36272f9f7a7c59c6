"""Sensitivity of the take-off velocity to the approach."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plantigrade.errors import ParameterError, SolverError
from plantigrade.record.jobs import run_jobs
from plantigrade.vaulting.approach import APPROACH_FIELDS
from plantigrade.vaulting.hand_contact import Vault
from plantigrade.vaulting.search import Search, SearchResult

RELATIVE_CHANGE = 0.05
"""Relative change of each field of the approach, up and down [1]; as in the report."""
REFINEMENT_EVALUATIONS = 1500
"""Evaluations of one repeated search of the activations; enough to converge from the optimum."""


@dataclass(frozen=True)
class ApproachChange:
    """Effect of a change of one field of the approach."""

    name: str  #: The changed field
    share: float  #: Relative change of its value [1]
    #: Upward velocity at take-off with unchanged activations [m/s]; NaN without take-off or for an
    #: impossible approach
    same: float
    anew: float  #: Upward velocity at take-off with activations optimised again [m/s]


@dataclass(frozen=True)
class _Evaluation:
    """Evaluates one changed approach."""

    vault: Vault
    found: SearchResult
    max_activation: float

    def __call__(self, task: tuple[str, float]) -> ApproachChange:
        name, share = task
        value = getattr(self.vault.approach, name)
        try:
            approach = replace(self.vault.approach, **{name: (1.0 + share) * value})
            vault = self.vault.with_approach(approach)
            same = vault.objective(self.found.nodes)
        except ParameterError:
            return ApproachChange(name, share, np.nan, np.nan)
        search = Search(vault, REFINEMENT_EVALUATIONS, self.max_activation, first=self.found.nodes)
        anew = search(("simplex", 0)).rise
        finite = (each if np.isfinite(each) else np.nan for each in (same, anew))
        return ApproachChange(name, share, *finite)


def sensitivity(
    vault: Vault,
    found: SearchResult,
    *,
    max_activation: float = 1.0,
    parallel: Mapping[str, Any] | None = None,
    reached: Callable[[float], None] = lambda share: None,
) -> tuple[ApproachChange, ...]:
    """Return the effects of changing each field of the approach by ±:data:`RELATIVE_CHANGE`.

    The report varied the initial kinematics and optimised again. This function also returns the
    take-off with unchanged activations, that of a gymnast unaware of the change.

    Args:
        found: The best activations.
        parallel: As in :func:`~plantigrade.vaulting.search.search_activations`.
        reached: Called after each change with the share of them that are done.

    Returns:
        Two changes for each of :data:`~plantigrade.vaulting.approach.APPROACH_FIELDS`, down and up.

    Raises:
        SolverError: If a search fails.
    """
    tasks = [(name, sign * RELATIVE_CHANGE) for name in APPROACH_FIELDS for sign in (-1, 1)]
    changes = []
    for done in run_jobs(_Evaluation(vault, found, max_activation), tasks, **(parallel or {})):
        if done.result is None:
            raise SolverError(f"a changed approach could not be searched: {done.problem}")
        changes.append(done.result)
        reached(len(changes) / len(tasks))
    return tuple(changes)


def ranking(changes: tuple[ApproachChange, ...], rise: float) -> tuple[tuple[str, float], ...]:
    """Return fields and changes of the re-optimised take-off [m/s], largest first."""
    effects: dict[str, float] = {}
    for each in changes:
        effect = abs(each.anew - rise)
        effects[each.name] = max(effects.get(each.name, 0.0), 0.0 if np.isnan(effect) else effect)
    return tuple(sorted(effects.items(), key=lambda item: -item[1]))
