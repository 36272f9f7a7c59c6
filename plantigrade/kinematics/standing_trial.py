r"""Evidence of a standing trial about a trial: exchanged labels, another person.

Distances that a trial keeps are those of a segment, and the standing trial shows them too. Two
labels, of known name or not, or a cluster of the left and that of the right, are exchanged where
that restores the distances. Where it does not, the standing trial is of another person.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import FitError
from plantigrade.kinematics.exchanged_labels import Exchange
from plantigrade.models.markers import other_side
from plantigrade.motion import Markers
from plantigrade.motion.distances import distances

MAX_RIGID_SPREAD = 0.006  # [m] maximum spread of a distance within one segment
MAX_RIGID_DISTANCE = 0.6  # [m] maximum distance within one segment
MIN_EXCHANGED_ERROR = 0.015  # [m] minimum mean error of the distances of an exchanged label
MAX_CORRECT_ERROR = 0.010  # [m] maximum mean error of the distances of a correct label
# median error of distances on one segment, [m] and relative [1], of another person
MIN_PERSON_DIFFERENCE = (0.006, 0.025)
MIN_PERSON_DISTANCES = 4  # [1] minimum number of such distances
MIN_LABEL_DISTANCES = 2  # [1] minimum number of distances that determine the label of a marker
MAX_DISTANCE_ERROR = 0.05  # [m] saturation of the error of a distance


@dataclass(frozen=True)
class SharedDistances:
    """Distances between the markers that two recordings share."""

    names: tuple[str, ...]  #: The markers of both
    here: Float[Array, "n n"]  #: Distances in the trial [m]
    there: Float[Array, "n n"]  #: Distances in the standing trial [m]
    #: Pairs whose distance the trial keeps, and that the standing trial shows
    rigid: Bool[Array, "n n"]

    @classmethod
    def of(cls, trial: Markers, standing: Markers) -> "SharedDistances":
        """Compare a trial with a standing trial."""
        names = tuple(n for n in trial.names if n in standing.names)
        a, b = (distances(m.select(names).positions) for m in (trial, standing))
        with np.errstate(invalid="ignore"):
            rigid = (
                (a.spread < MAX_RIGID_SPREAD)
                & (a.usual < MAX_RIGID_DISTANCE)
                & np.isfinite(b.usual)
            )
        np.fill_diagonal(rigid, False)
        return cls(names, a.usual, b.usual, rigid)

    def wrong(self, order: np.ndarray, rows: Sequence[int]) -> Float[Array, "k n"]:
        """Return by how much distances of some columns are wrong [m]; 0 of those that change."""
        off = np.abs(self.here[rows] - self.there[np.ix_(order[rows], order)])
        off = np.where(np.isfinite(off), np.minimum(off, MAX_DISTANCE_ERROR), MAX_DISTANCE_ERROR)
        return np.where(self.rigid[rows], off, 0.0)


def exchanged_by_standing(trial: Markers, standing: Markers, known: Sequence[str]) -> Exchange:
    """Return the labels of a trial whose exchange makes its distances those of a standing trial.

    Args:
        known: The markers whose place is known; clusters of the others may be exchanged between
            the sides.
    """
    kept = SharedDistances.of(trial, standing)
    names, n = kept.names, len(kept.names)
    order = np.arange(n)  # column → the label it truly is of
    count = kept.rigid.sum(axis=1)
    moves: list[tuple[tuple[int, int], ...]] = [((i, j),) for i in range(n) for j in range(i)]
    moves += _clusters(kept, set(known))
    for _ in range(n):
        now = kept.wrong(order, range(n)).sum(axis=1)
        bad = (count >= MIN_LABEL_DISTANCES) & (now > MIN_EXCHANGED_ERROR * count)
        best, most = None, 0.0
        for move in moves:
            both = [k for pair in move for k in pair]
            if not bad[both].all():
                continue
            other = order.copy()
            for i, j in move:
                other[[i, j]] = other[[j, i]]
            left = kept.wrong(other, both).sum()
            gain = now[both].sum() - left
            if gain > most and left < MAX_CORRECT_ERROR * count[both].sum():
                best, most = other, gain
        if best is None:
            break
        order = best
    return Exchange.of(names, np.argsort(order))


def _clusters(kept: SharedDistances, known: set[str]) -> list[tuple[tuple[int, int], ...]]:
    """Return the pairs of markers of left and right that move together with each marker."""
    at = {name: i for i, name in enumerate(kept.names)}
    found = set()
    for i, name in enumerate(kept.names):
        if name in known:
            continue
        group = [k for k in (i, *np.flatnonzero(kept.rigid[i])) if kept.names[k] not in known]
        twins = [(k, at.get(other_side(kept.names[k], at) or "")) for k in group]
        pairs = {(min(k, t), max(k, t)) for k, t in twins if t is not None}
        if len(pairs) > 1:
            found.add(tuple(sorted(pairs)))
    return sorted(found)


def require_same_person(
    trial: Markers, standing: Markers, segments: Mapping[str, str], source: object
) -> None:
    """Raise where a standing trial is of another person than a trial.

    Compared are distances between markers of one segment, which skin alone changes. Their median
    over the pairs does not feel a few markers that were put elsewhere.
    """
    kept = SharedDistances.of(trial, standing)
    body = np.array([segments.get(name, "") for name in kept.names])
    compared = np.triu(kept.rigid & (body[:, None] == body) & (body != ""))
    if compared.sum() < MIN_PERSON_DISTANCES:
        return
    off = np.abs(kept.here - kept.there)[compared]
    away, share = float(np.median(off)), float(np.median(off / kept.there[compared]))
    if away > MIN_PERSON_DIFFERENCE[0] and share > MIN_PERSON_DIFFERENCE[1]:
        raise FitError(
            f"the standing trial {source} is of another person, or its markers were put on anew: "
            f"distances between markers of one segment differ by {1e3 * away:.0f} mm "
            f"({100 * share:.0f} %) in the median of {compared.sum()}, skin moves them by 1 to 3 "
            "mm; name the standing trial of the same session, or leave --static out"
        )
