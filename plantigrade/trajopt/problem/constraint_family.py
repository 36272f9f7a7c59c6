"""Constraints and costs of one kind at all nodes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Bool, Float

if TYPE_CHECKING:
    import casadi


def node_symbols(nv: int, n_unknowns: int = 0, n_parameters: int = 0) -> "tuple[casadi.SX, ...]":
    """Return symbols (q, qd, qdd, u, p) of what a function of a node takes."""
    import casadi as ca

    sizes = {"q": nv, "qd": nv, "qdd": nv, "u": n_unknowns, "p": n_parameters}
    return tuple(ca.SX.sym(name, n) for name, n in sizes.items())


@dataclass(frozen=True, eq=False)
class ConstraintFamily:
    """Constraints and costs of one kind: a function evaluated at every node, with its limits.

    Attributes:
        name: Name of the rows, for progress and diagnosis: ``"contact"``.
        function: CasADi function of columns (q, qd, qdd, u, p) ↦ rows (n_rows,), in units in which
            1 is large (body weights, radians, metres).
        names: A name for every row.
        lower: Lower limits (n_nodes, n_rows); -inf where there is none.
        upper: Upper limits (n_nodes, n_rows); a row whose limits are equal is an equation.
        weight: Weight of the squared distance to ``target`` (n_nodes, n_rows).
        target: Where the squared cost is least (n_nodes, n_rows).
        gain: Linear cost (n_nodes, n_rows).
        parameters: Parameters of the function at each node (n_nodes, n_parameters).
        unit: Unit of a row as shown to people.
        scale: Value of a row of 1 in that unit.
        parts: The families stacked in this one, if they share a function; see :meth:`stacked`.
    """

    name: str
    function: "casadi.Function"
    names: tuple[str, ...]
    lower: Float[Array, "n_nodes n_rows"]
    upper: Float[Array, "n_nodes n_rows"]
    weight: Float[Array, "n_nodes n_rows"]
    target: Float[Array, "n_nodes n_rows"]
    gain: Float[Array, "n_nodes n_rows"]
    parameters: Float[Array, "n_nodes n_parameters"]
    unit: str = ""
    scale: float = 1.0
    parts: tuple["ConstraintFamily", ...] = ()

    @classmethod
    def free(
        cls,
        name: str,
        function: "casadi.Function",
        names: tuple[str, ...],
        n_nodes: int,
        parameters: Float[Array, "n_nodes n_parameters"] | None = None,
        unit: str = "",
        scale: float = 1.0,
    ) -> "ConstraintFamily":
        """Return rows without limits and without cost; fill the arrays to give them some."""
        shape = (n_nodes, len(names))
        low, high = np.full(shape, -np.inf), np.full(shape, np.inf)
        weight, target, gain = (np.zeros(shape) for _ in range(3))
        p = np.zeros((n_nodes, 0)) if parameters is None else parameters
        return cls(name, function, names, low, high, weight, target, gain, p, unit, scale)

    @classmethod
    def stacked(
        cls, name: str, function: "casadi.Function", parts: Sequence["ConstraintFamily"]
    ) -> "ConstraintFamily":
        """Return families as one that is evaluated at once.

        Its ``parts`` are the families on the same memory: what limits or weighs one of them does
        so in the whole. All have the parameters of the first; ``function`` gives the rows of all,
        in their order.
        """
        names, first = sum((p.names for p in parts), ()), parts[0]
        whole = cls.free(name, function, names, len(first.lower), first.parameters)
        views, at = [], 0
        for part in parts:
            columns = slice(at, at + len(part.names))
            arrays = {}
            for what in ("lower", "upper", "weight", "target", "gain"):
                arrays[what] = getattr(whole, what)[:, columns]
                arrays[what][:] = getattr(part, what)
            views.append(replace(part, **arrays))
            at = columns.stop
        return replace(whole, parts=tuple(views))

    @property
    def equations(self) -> Bool[Array, "n_nodes n_rows"]:
        """Which rows are equations."""
        return self.lower == self.upper

    @property
    def inequalities(self) -> Bool[Array, "n_nodes n_rows"]:
        """Which rows have a limit but are no equation."""
        return (np.isfinite(self.lower) | np.isfinite(self.upper)) & ~self.equations

    @property
    def matters(self) -> Bool[Array, "n_nodes n_rows"]:
        """Which rows have a limit or a cost."""
        return self.equations | self.inequalities | (self.weight != 0) | (self.gain != 0)
