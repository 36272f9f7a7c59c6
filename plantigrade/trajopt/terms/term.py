"""Base class of terms, which add themselves to a problem and state their demands as data."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import Point
from plantigrade.models.mirror import mirror_sign, mirrored_name
from plantigrade.motion.filters import runs
from plantigrade.record.conditions import AXES, Condition
from plantigrade.side_names import split_side
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.transcription.mesh import nodes_of

Spaced = tuple[float, float, float]
"""From when to when nodes are no further apart than so much [s]."""


class Term(ABC):
    """A condition or a cost, independent of the task it is part of.

    Terms are frozen dataclasses; to write a new one, implement :meth:`add_to`.
    """

    @abstractmethod
    def add_to(self, b: ProblemBuilder) -> None:
        """Add limits and weights to a problem."""

    @property
    def instants(self) -> tuple[float, ...]:
        """Times at which there must be a node [s]."""
        return ()

    def spaced(self, plan: ContactPlan) -> tuple[Spaced, ...]:
        """Return when nodes are near each other, and how near."""
        return ()

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return what must hold of the motion over one period, as the checker judges it.

        Unless a term defines its own, these are the limits that it sets to coordinates and speeds.
        """
        return limits_set(self, body, plan)

    def mirrored(self) -> "Term":
        """Return the same term for the other side."""
        changed = {f.name: _mirrored(getattr(self, f.name)) for f in fields(self)}  # type: ignore[arg-type]
        return replace(self, **changed)  # type: ignore[type-var]


def limits_set(term: Term, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
    """Return the limits that a term sets to coordinates and speeds, as conditions.

    The pelvis is left out on slopes: there its coordinates are in the axes of the ground, which the
    recorded motion is not.
    """
    nodes = np.union1d(nodes_of(plan), np.array(term.instants, dtype=float))
    b = ProblemBuilder(body, plan, nodes[:-1] if plan.periodic else nodes)
    term.add_to(b)
    found = []
    for quantity, name in (("coordinate", "coordinates"), ("speed", "speeds")):
        family = b.family(name)
        limited = np.isfinite(family.lower) | np.isfinite(family.upper)
        for i in np.flatnonzero(limited.any(axis=0)):
            coordinate = b.names[i]
            if plan.slope and coordinate.startswith("pelvis"):
                continue
            label = family.names[i]
            low, high = family.lower[:, i], family.upper[:, i]
            if (low == low[0]).all() and (high == high[0]).all():
                found.append((label, quantity, (0.0, np.inf), low[:1], high[:1], coordinate))
                continue
            for run in runs(limited[:, i]):
                found.append((label, quantity, b.nodes[run], low[run], high[run], coordinate))
    return tuple(
        Condition(
            label,
            quantity,  # type: ignore[arg-type]
            tuple(map(float, when)),
            tuple(map(float, np.broadcast_to(low, len(when)))),
            tuple(map(float, np.broadcast_to(high, len(when)))),
            coordinate,
        )
        for label, quantity, when, low, high, coordinate in found
    )


@dataclass(frozen=True)
class AtInstant(Term):
    """A term about one instant."""

    time: float  #: When [s]

    @property
    def instants(self) -> tuple[float, ...]:
        """Its time."""
        return (self.time,)


def point_conditions(
    point: Point, times: Sequence[float], places: ArrayLike
) -> tuple[Condition, ...]:
    """Return where a point is at times [s], axis by axis.

    Args:
        places: (n_times, 3), world [m]; NaN for an axis that is free.
    """
    return tuple(
        Condition(
            f"{axis} of {point.body}", "point", tuple(times), tuple(x), tuple(x), point.body, axis,
            point.position, point.radius,
        )
        for axis, x in zip(AXES, np.transpose(places).tolist(), strict=True)
        if not np.isnan(x[0])
    )  # fmt: skip


def one_sided(terms: tuple[Term, ...]) -> tuple[Term, ...]:
    """Return the terms whose mirror image is not among them."""
    return tuple(t for t in terms if not any(_same(t.mirrored(), other) for other in terms))


def repeated(
    conditions: tuple[Condition, ...], plan: ContactPlan, periods: int
) -> tuple[Condition, ...]:
    """Return conditions of one period for as many as a motion has, mirrored where the motion is."""
    out = []
    for c in conditions:
        if c.time == (0.0, np.inf) and c == mirrored_condition(c):
            out.append(c)
            continue
        for k in range(periods):
            lap = mirrored_condition(c) if plan.mirrored and k % 2 else c
            end = plan.duration if np.isinf(c.time[-1]) and plan.periodic else np.inf
            lap = replace(lap, time=tuple(min(t, end) for t in lap.time))
            if lap.quantity in ("point", "com") and lap.axis in ("x", "y"):
                far = k * {"x": plan.advance, "y": plan.aside}[lap.axis]  # goes with the person
                bounds = (tuple(x + far for x in each) for each in (lap.lower, lap.upper))
                lap = replace(lap, lower=next(bounds), upper=next(bounds))
            out.append(lap.later(k * plan.duration) if k else lap)
    return tuple(dict.fromkeys(out))


def mirrored_condition(c: Condition) -> Condition:
    """Return the same condition for the other side."""
    of, flips = mirrored_name(c.of), c.axis == "y"
    if c.quantity in ("coordinate", "speed", "displacement"):
        flips = mirror_sign(c.of) < 0
    x, y, z = c.position
    lower, upper = c.lower, c.upper
    if flips:
        lower, upper = tuple(-v for v in upper), tuple(-v for v in lower)
    name = c.name.replace(c.of, of) if c.of else c.name
    return replace(c, name=name, of=of, position=(x, -y, z), lower=lower, upper=upper)


def per_coordinate(
    names: tuple[str, ...], given: Mapping[str, float], otherwise: float = 1.0
) -> Float[Array, " n"]:
    """Return a number for every coordinate, by its name or its name without side."""
    return np.array([given.get(n, given.get(split_side(n)[0], otherwise)) for n in names])


def _mirrored(value: Any) -> Any:
    """Return a field's value for the other side: names change side."""
    if isinstance(value, str):
        return mirrored_name(value)
    if isinstance(value, Mapping):
        return {mirrored_name(k): v for k, v in value.items()}
    if isinstance(value, Point):
        x, y, z = value.position
        return replace(value, body=mirrored_name(value.body), position=(x, -y, z))
    return value


def mirrored_values(values: Mapping[str, float]) -> dict[str, float]:
    """Return values of coordinates by name, in the mirror."""
    return {mirrored_name(k): v * mirror_sign(k) for k, v in values.items()}


def _same(a: Term, b: Term) -> bool:
    if type(a) is not type(b):
        return False
    pairs = ((getattr(a, f.name), getattr(b, f.name)) for f in fields(a))  # type: ignore[arg-type]
    return all(x is y or bool(np.all(x == y)) for x, y in pairs)
