"""Which constraints a motion violates: what, where, when, by how much, and what to relax.

They are evaluated anew at the nodes, whatever the solver reported.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.side_names import split_side
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.solvers.result import Multipliers
from plantigrade.trajopt.transcription.derivatives import derivatives_of

TOLERANCE = 1e-4  #: Excess of a limit above which a row is violated, in its own unit [1]

_SIDES = {"_r": "right", "_l": "left"}
_DEGREE, _MILLIMETRE = float(np.rad2deg(1.0)), 1000.0
_REFINE = "refine the mesh (--nodes-per-second)"
_STRONGER = (
    "give the motion more time, or take a stronger person (a term Limits with a larger strength)"
)
_UNBALANCED = (
    "nothing but the ground moves the body as a whole: give the motion more time, put the feet "
    "nearer, or allow more force"
)
ADVICE = {
    "root force": _UNBALANCED,
    "root moment": _UNBALANCED,
    "muscle torque": _STRONGER,
    "joint torque": _STRONGER,
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
"""Advice on relaxation, by family."""
FIXED = {
    "coordinates": "the requested posture at that instant contradicts the other conditions: give "
    "the motion more time, or ask for another posture",
    "speeds": "the body cannot be at rest there: give the motion more time, or do not ask for rest",
}
"""Advice on relaxation of fixed rows."""


@dataclass(frozen=True)
class Violation:
    """The worst constraint of one family, such as ``"z of toe_1_r"`` of ``"contact"``."""

    family: str  #: Family it belongs to
    name: str  #: Its name
    time: float  #: When it is violated worst [s]
    amount: float  #: Size, in ``unit``
    unit: str  #: As shown to people
    relative: float  #: The same in the problem's unit, where 1 is large
    others: int = 0  #: How many more rows of the family are violated, all nodes counted
    advice: str = ""  #: Condition to relax

    @property
    def side(self) -> str:
        """``"right"``, ``"left"`` or empty."""
        return _SIDES.get(self.name[-2:], "")

    @property
    def words(self) -> str:
        """Its name in words, side in front: ``"right toe 1, z"``."""
        axis, of, place = self.name.rpartition(" of ")
        plain, _ = split_side(place if of else self.name)
        plain = f"{self.side} {plain}".strip().replace("_", " ")
        return f"{axis} of {plain}" if of else plain

    def sentence(self) -> str:
        """Return which row is violated, on which side, when, by how much and what to relax."""
        more = f"; {self.others} more {self.family} rows" if self.others else ""
        end = f": {self.advice}" if self.advice else ""
        return (
            f"{self.words} is off by {self.amount:.3g} {self.unit} at {self.time:.2f} s{more}{end}"
        )


def violations(
    problem: Problem,
    c: Float[Array, "n_coefficients n_coordinates"],
    u: Float[Array, "n_nodes n_unknowns"],
    *,
    tolerance: float = TOLERANCE,
) -> tuple[Violation, ...]:
    """Return the worst violated row of every family, worst first; empty where all are kept.

    Rows that are off by no more than ``tolerance``, in the problem's unit, count as kept.
    """
    q, v, a = problem.states(c, problem.nodes)
    u = u[:, : problem.n_unknowns]
    found = []
    for whole in problem.rows:
        every = values(whole, q, v, a, u)
        for family, columns in parts_of(whole):
            r = every[:, columns]
            off = np.maximum(family.lower - r, r - family.upper)
            worst = _worst(problem.nodes, family.name, family.names, off, tolerance)
            if worst is not None:
                found.append(_advised(_in_units(worst, family), family, problem))
    if problem.n_unknowns:
        off = np.maximum(problem.u_lower - u, u - problem.u_upper)
        worst = _worst(problem.nodes, "force", problem.u_names, off, tolerance)
        if worst is not None:
            found.append(replace(worst, amount=100.0 * worst.relative, unit="% of body weight"))
    return tuple(sorted(found, key=lambda b: -b.relative))


def pressing(problem: Problem, multipliers: Multipliers | None, count: int = 3) -> tuple[str, ...]:
    """Return the limits with the largest multipliers, at most one per family, in words."""
    if multipliers is None:
        return ()
    found = []
    for whole in problem.rows:
        pushes = multipliers.rows.get(whole.name)
        if pushes is None or pushes.shape[1:] != whole.lower.shape:
            continue
        for family, columns in parts_of(whole):
            push = np.abs(pushes[1:, :, columns]).max(axis=0)
            size = np.where(family.inequalities, push, 0.0)
            if not size.size:
                continue
            k, i = np.unravel_index(int(np.argmax(size)), size.shape)
            if size[k, i] > 0:
                at = Violation(
                    family.name, family.names[int(i)], float(problem.nodes[k]), 0.0, "", 0.0
                )
                found.append((float(size[k, i]), f"{at.words} at {at.time:.2f} s"))
    return tuple(words for _, words in sorted(found, reverse=True)[:count])


def parts_of(family: ConstraintFamily) -> Iterator[tuple[ConstraintFamily, slice]]:
    """Yield the families a family is made of and their columns in it; itself if it has no parts."""
    first = 0
    for part in family.parts or (family,):
        yield part, slice(first, first + len(part.names))
        first += len(part.names)


def _advised(worst: Violation, family: ConstraintFamily, problem: Problem) -> Violation:
    """Return it with its advice, which differs for fixed and limited quantities."""
    k = int(np.argmin(np.abs(problem.nodes - worst.time)))
    fixed = family.equations[k, family.names.index(worst.name)]
    return replace(worst, advice=FIXED[family.name]) if fixed and family.name in FIXED else worst


def values(
    rows: ConstraintFamily,
    q: Float[Array, "n_nodes nv"],
    v: Float[Array, "n_nodes nv"],
    a: Float[Array, "n_nodes nv"],
    u: Float[Array, "n_nodes n_unknowns"],
) -> Float[Array, "n_nodes n_rows"]:
    """Return rows at all nodes."""
    return derivatives_of(rows.function).values(q, v, a, u, rows.parameters)


def _worst(
    nodes: Float[Array, " n_nodes"],
    family: str,
    names: tuple[str, ...],
    off: Float[Array, "n_nodes n_rows"],
    tolerance: float,
) -> Violation | None:
    """Return the worst row of a family, in its own unit; None where all are kept."""
    off = np.nan_to_num(off, nan=np.inf, neginf=-np.inf)
    if not off.size:
        return None
    k, i = np.unravel_index(int(np.argmax(off)), off.shape)
    worst, name, time = float(off[k, i]), names[int(i)], float(nodes[k])
    if not worst > tolerance:
        return None
    others, advice = int((off > tolerance).sum()) - 1, ADVICE.get(family, "")
    return Violation(family, name, time, worst, "", worst, others, advice)


def _in_units(worst: Violation, family: ConstraintFamily) -> Violation:
    """Return it in a unit for people."""
    factor, unit = family.scale, family.unit or "(its own unit)"
    if family.name in ("coordinates", "speeds", "accelerations") and not family.unit:
        rate = {"coordinates": "", "speeds": "/s", "accelerations": "/s²"}[family.name]
        factor, unit = _DEGREE, f"deg{rate}"
        if worst.name.rpartition(" ")[2] in ("pelvis_tx", "pelvis_ty", "pelvis_tz"):
            factor, unit = _MILLIMETRE, f"mm{rate}"
    return replace(worst, amount=worst.relative * factor, unit=unit)
