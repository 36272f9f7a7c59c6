"""How much a vault depends on how the gymnast arrives."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plantigrade.errors import ParameterError, SolverError
from plantigrade.record.jobs import run_jobs
from plantigrade.vaulting.approach import NAMES
from plantigrade.vaulting.search import Found, Search
from plantigrade.vaulting.simulation import Vault

SHARE = 0.05
"""Of its value, by which each part of the approach is changed, up and down."""
AGAIN = 1500
"""Vaults tried to find the best activations anew."""


@dataclass(frozen=True)
class Changed:
    """An approach changed in one thing.

    Attributes:
        name: In what.
        share: By how much of its value.
        same: Velocity upward at take-off with the same activations [m/s]; NaN where the hands do
            not leave, or the approach cannot be.
        anew: The same with activations searched anew from there.
    """

    name: str
    share: float
    same: float
    anew: float


@dataclass(frozen=True)
class _Change:
    """The work of one change."""

    vault: Vault
    found: Found
    most: float

    def __call__(self, task: tuple[str, float]) -> Changed:
        name, share = task
        value = getattr(self.vault.approach, name)
        try:
            approach = replace(self.vault.approach, **{name: (1.0 + share) * value})
            vault = self.vault.with_approach(approach)
            same = vault.worth(self.found.nodes)
        except ParameterError:
            return Changed(name, share, np.nan, np.nan)
        search = Search(vault, AGAIN, self.most, first=self.found.nodes)
        anew = search(("simplex", 0)).rise
        kept = (each if np.isfinite(each) else np.nan for each in (same, anew))
        return Changed(name, share, *kept)


def sensitivity(
    vault: Vault,
    found: Found,
    *,
    most: float = 1.0,
    parallel: Mapping[str, Any] | None = None,
) -> tuple[Changed, ...]:
    """Return what changes if each part of the approach is :data:`SHARE` more or less.

    The report varied the initial kinematics and optimised again; here the take-off with unchanged
    activations, which is what a gymnast would have who does not notice, stands beside that.

    Args:
        vault: The gymnast.
        found: The best activations.
        most: Greatest activation.
        parallel: As of :func:`~plantigrade.vaulting.search.searched`.

    Returns:
        Two changes for each of :data:`~plantigrade.vaulting.approach.NAMES`, down and up.

    Raises:
        SolverError: If one could not be done.
    """
    tasks = [(name, sign * SHARE) for name in NAMES for sign in (-1, 1)]
    changes = []
    for done in run_jobs(_Change(vault, found, most), tasks, **(parallel or {})):
        if done.result is None:
            raise SolverError(f"a changed approach could not be searched: {done.problem}")
        changes.append(done.result)
    return tuple(changes)


def ranking(changes: tuple[Changed, ...], rise: float) -> tuple[tuple[str, float], ...]:
    """Return the names by how far searching anew moves the take-off, farthest first [m/s]."""
    far: dict[str, float] = {}
    for each in changes:
        off = abs(each.anew - rise)
        far[each.name] = max(far.get(each.name, 0.0), 0.0 if np.isnan(off) else off)
    return tuple(sorted(far.items(), key=lambda item: -item[1]))
