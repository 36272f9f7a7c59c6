"""Which rows of a problem a motion breaks, in words: what, where, when, by how much, what to relax.

Rows are evaluated anew at the nodes; nothing a solver says of itself is used.
"""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.synthesize.problem.nlp import ConstraintFamily, Problem
from plantigrade.synthesize.solvers.interior_point import Multipliers

TOLERANCE = 1e-4
"""A row is broken where it is further outside of its limits, in its own unit (where 1 is large)."""

_SIDES = {"_r": "right", "_l": "left"}
_DEGREE, _MILLIMETRE = float(np.rad2deg(1.0)), 1000.0
_REFINE = "refine the mesh (--nodes-per-second)"
_STRONGER = (
    "give the motion more time, or take a stronger person (a term Limits with a larger strength)"
)
ADVICE = {
    "root": "nothing but the ground moves the body as a whole: give the motion more time, put the "
    "feet nearer, or allow more force",
    "torque": _STRONGER,
    "whole torque": _STRONGER,
    "work rate": "give the motion more time, or allow more power",
    "contact": "the foot cannot be where the plan has it: take shorter steps, or put the feet "
    f"nearer, or {_REFINE}",
    "contact speed": f"the foot cannot rest as it touches or leaves: {_REFINE}, or give its roll "
    "more time",
    "coordinates": "the joint's range is too small for this: take shorter steps, or a pose that "
    "can be reached",
    "speeds": "give the motion more time, or allow a greater speed (a term Limits with a larger "
    "speed)",
    "friction": "move more slowly, or allow rougher ground (a term Contact with a larger friction)",
    "force": "give the motion more time, or allow more force (a term Contact with a larger force)",
}
"""What to relax, by kind of row."""
FIXED = {
    "coordinates": "the posture asked for at that instant does not go with all the rest: give the "
    "motion more time, or ask for another posture",
    "speeds": "the body cannot be at rest there: give the motion more time, or do not ask for rest",
}
"""What to relax where a row was fixed, not limited."""


@dataclass(frozen=True)
class Broken:
    """The worst row of one kind.

    Attributes:
        family: Rows it belongs to: ``"contact"``.
        name: Its name: ``"z of toe_1_r"``.
        time: When it is broken worst [s].
        amount: By how much, in ``unit``.
        unit: As shown to people.
        relative: The same in the row's own unit, where 1 is large.
        others: How many more rows of the family are broken, all nodes counted.
        advice: What to relax.
    """

    family: str
    name: str
    time: float
    amount: float
    unit: str
    relative: float
    others: int = 0
    advice: str = ""

    @property
    def side(self) -> str:
        """``"right"``, ``"left"`` or empty."""
        return _SIDES.get(self.name[-2:], "")

    @property
    def words(self) -> str:
        """Its name in words, side in front: ``"right toe 1, z"``."""
        axis, of, place = self.name.rpartition(" of ")
        plain = (place if of else self.name).removesuffix("_r").removesuffix("_l")
        plain = f"{self.side} {plain}".strip().replace("_", " ")
        return f"{axis} of {plain}" if of else plain

    def sentence(self) -> str:
        """Return which row is broken, on which side, when, by how much and what to relax."""
        more = f"; {self.others} more {self.family} rows" if self.others else ""
        end = f": {self.advice}" if self.advice else ""
        return (
            f"{self.words} is off by {self.amount:.3g} {self.unit} at {self.time:.2f} s{more}{end}"
        )


def broken_rows(
    problem: Problem,
    c: Float[Array, "n_coefficients n_coordinates"],
    u: Float[Array, "n_nodes n_unknowns"],
    *,
    tolerance: float = TOLERANCE,
) -> tuple[Broken, ...]:
    """Return the worst broken row of every kind, worst first; empty where all are kept.

    Args:
        problem: What was asked.
        c: Coefficients.
        u: Unknowns at nodes.
        tolerance: Rows less far off are kept, in their own unit.
    """
    q, v, a = problem.states(c, problem.nodes)
    u = u[:, : problem.n_unknowns]
    found = []
    for rows in problem.rows:
        r = values(rows, q, v, a, u)
        off = np.maximum(rows.lower - r, r - rows.upper)
        worst = _worst(problem, rows.name, rows.names, off, tolerance, rows.unit, rows.scale)
        found += [_advised(b, rows, problem) for b in worst]
    if problem.n_unknowns:
        off = np.maximum(problem.u_lower - u, u - problem.u_upper)
        found += _worst(
            problem, "force", problem.u_names, off, tolerance, "% of body weight", 100.0
        )
    return tuple(sorted(found, key=lambda b: -b.relative))


def pressing(problem: Problem, multipliers: Multipliers | None, count: int = 3) -> tuple[str, ...]:
    """Return which limits a solver pushed against hardest, in words: what to relax first.

    Args:
        problem: What was asked.
        multipliers: What rows pushed with; None for nobody knows.
        count: How many limits at most, one of each kind.
    """
    if multipliers is None:
        return ()
    found = []
    for rows in problem.rows:
        push = multipliers.rows.get(rows.name)
        if push is None or push.shape[1:] != rows.lower.shape:
            continue
        size = np.where(rows.inequalities, np.abs(push[1:]).max(axis=0), 0.0)
        k, i = np.unravel_index(int(np.argmax(size)), size.shape)
        if size[k, i] > 0:
            at = Broken(rows.name, rows.names[int(i)], float(problem.nodes[k]), 0.0, "", 0.0)
            found.append((float(size[k, i]), f"{at.words} at {at.time:.2f} s"))
    return tuple(words for _, words in sorted(found, reverse=True)[:count])


def _advised(broken: Broken, rows: ConstraintFamily, problem: Problem) -> Broken:
    """Return what is broken with other advice where it was fixed rather than limited."""
    k = int(np.argmin(np.abs(problem.nodes - broken.time)))
    fixed = rows.equations[k, rows.names.index(broken.name)]
    if rows.name in FIXED and fixed:
        return replace(broken, advice=FIXED[rows.name])
    return broken


def values(
    rows: ConstraintFamily,
    q: Float[Array, "n_nodes nv"],
    v: Float[Array, "n_nodes nv"],
    a: Float[Array, "n_nodes nv"],
    u: Float[Array, "n_nodes n_unknowns"],
) -> Float[Array, "n_nodes n_rows"]:
    """Return rows at all nodes."""
    arguments = [np.ascontiguousarray(x.T) for x in (q, v, a, u, rows.parameters)]
    return np.array(rows.function.map(len(q))(*arguments)).T


def _worst(
    problem: Problem,
    family: str,
    names: tuple[str, ...],
    off: Float[Array, "n_nodes n_rows"],
    tolerance: float,
    unit: str,
    scale: float,
) -> list[Broken]:
    """Return the worst broken row of a family; of the dynamics those of root and torques."""
    off = np.nan_to_num(off, nan=np.inf, neginf=-np.inf)
    kinds = {"": range(len(names))}
    if family == "dynamics":
        kinds = {
            kind: [i for i, n in enumerate(names) if n.startswith(kind)]
            for kind in ("root", "torque", "work rate", "whole torque")
        }
    found = []
    for kind, columns in kinds.items():
        columns = list(columns)
        if not columns:
            continue
        part = off[:, columns]
        k, i = np.unravel_index(int(np.argmax(part)), part.shape)
        worst = float(part[k, i])
        if not worst > tolerance:
            continue
        name = names[columns[int(i)]]
        factor, shown = _shown(family, name, unit, scale)
        found.append(
            Broken(
                family,
                name,
                float(problem.nodes[k]),
                worst * factor,
                shown,
                worst,
                int((part > tolerance).sum()) - 1,
                ADVICE.get(kind or family, ""),
            )
        )
    return found


def _shown(family: str, name: str, unit: str, scale: float) -> tuple[float, str]:
    """Return by what a row is multiplied to be shown, and the unit it then has."""
    if family == "dynamics":
        if name.startswith("root force"):
            return 100.0, "% of body weight"
        if name.startswith("root moment"):
            return 100.0, "% of body weight times metre"
        return scale, "W" if name.startswith("work rate") else "N m"
    if family in ("coordinates", "speeds", "accelerations") and not unit:
        rate = {"coordinates": "", "speeds": "/s", "accelerations": "/s²"}[family]
        if name.rpartition(" ")[2] in ("pelvis_tx", "pelvis_ty", "pelvis_tz"):
            return _MILLIMETRE, f"mm{rate}"
        return _DEGREE, f"deg{rate}"
    return scale, unit or "(its own unit)"
