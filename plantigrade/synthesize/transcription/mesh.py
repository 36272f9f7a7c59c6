"""Nodes of a motion: every change of contact is one, and in between they are as even as can be."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.errors import ParameterError


def nodes_of(
    plan: ContactPlan, nodes_per_second: float = 20.0, *, least: int = 2
) -> Float[Array, " n"]:
    """Return the times of the nodes of a plan, start, end and every change of contact among them.

    Between two changes nodes are evenly spaced.

    Args:
        plan: Says when contact changes.
        nodes_per_second: Nodes a second at least [1/s].
        least: Intervals between two changes at least: with one alone, a force that is zero at both
            its ends would be zero throughout.

    Raises:
        ParameterError: If the nodes_per_second is not positive or ``least`` below 1.
    """
    if not 0 < nodes_per_second < np.inf:
        raise ParameterError(f"{nodes_per_second=} [1/s] must be positive: 20 is usual")
    if not (least == int(least) and least >= 1):
        raise ParameterError(f"{least=} must be a whole number, 1 or more")
    switches = plan.switches
    pieces = [
        np.linspace(a, b, max(int(least), int(np.ceil((b - a) * nodes_per_second - 1e-9))) + 1)[:-1]
        for a, b in zip(switches[:-1], switches[1:], strict=True)
    ]
    return np.concatenate([*pieces, switches[-1:]])


def nodes_like(
    plan: ContactPlan, switches: Float[Array, " n_switches"], nodes: Float[Array, " n"]
) -> Float[Array, " n"] | None:
    """Return the nodes of a plan that go with those of another motion, change by change.

    Args:
        plan: The plan.
        switches: Changes of contact of the other motion [s].
        nodes: Its nodes, start and end among them [s].

    Returns:
        As many nodes, or None where the plan has another number of changes.
    """
    if len(plan.switches) != len(switches):
        return None
    return np.interp(nodes, switches, plan.switches)


def split(
    nodes: Float[Array, " n"], times: Float[Array, " n_times"], *, shortest: float = 0.002
) -> Float[Array, " m"]:
    """Return nodes with more of them wherever one of the times falls in between.

    Args:
        nodes: The nodes, start and end among them [s].
        times: Times that ask for finer nodes [s].
        shortest: Intervals are not made shorter than this [s].
    """
    within = np.unique(np.clip(np.searchsorted(nodes, times, side="right") - 1, 0, len(nodes) - 2))
    within = within[nodes[within + 1] - nodes[within] >= 2 * shortest]
    return np.sort(np.concatenate([nodes, (nodes[within] + nodes[within + 1]) / 2]))
