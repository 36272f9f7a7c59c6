"""The mesh: a node at every change of contact, evenly spaced nodes in between."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.errors import ParameterError

MAX_NODES = 5000
"""Maximum number of nodes [1]; a walk of 43 coordinates takes 1.1 MB of memory per node, 5 GB in
all."""

MIN_INTERVALS = 2
"""Least number of intervals between two changes of contact [1]: with a single one, a force that is
zero at both ends would be zero throughout."""
EQUAL_INTERVAL_RATIO = 0.7
"""Length of an interval relative to its neighbour from which it counts as equal [1]."""

MIN_EXCESS = {8: 8.0, 4: 2.0, 2: 0.0}
"""Number of parts → excess of the error above which an interval is divided into that many [1].
Chosen: with these values one or two rounds of refinement suffice for jumps, runs and hops."""


def nodes_of(plan: ContactPlan, nodes_per_second: float = 20.0) -> Float[Array, " n"]:
    """Return the nodes of a plan: start, end, every change of contact, and evenly between them.

    Args:
        plan: Says when contact changes.
        nodes_per_second: Least number of nodes per second [1/s].
    """
    if not 0 < nodes_per_second < np.inf:
        raise ParameterError(f"{nodes_per_second=} [1/s] must be positive: 20 is usual")
    switches = plan.switches
    counts = np.maximum(MIN_INTERVALS, np.ceil(np.diff(switches) * nodes_per_second - 1e-9))
    if counts.sum() + 1 > MAX_NODES:
        raise ParameterError(
            f"a motion of {plan.duration:.3g} s at {nodes_per_second:g} nodes per second takes "
            f"{counts.sum() + 1:.0f} nodes of about 1 MB; allowed are {MAX_NODES}: "
            "ask for fewer steps, a shorter duration or fewer nodes_per_second"
        )
    pieces = [
        np.linspace(a, b, int(n) + 1)[:-1]
        for a, b, n in zip(switches[:-1], switches[1:], counts, strict=True)
    ]
    return np.concatenate([*pieces, switches[-1:]])


def nodes_like(
    plan: ContactPlan, switches: Float[Array, " n_switches"], nodes: Float[Array, " n"]
) -> Float[Array, " n"] | None:
    """Return as many nodes of a plan as another motion has, change of contact by change.

    None where the plan has another number of changes than the ``switches`` of the other motion [s].
    """
    if len(plan.switches) != len(switches):
        return None
    return np.interp(nodes, switches, plan.switches)


def split(
    nodes: Float[Array, " n"],
    times: Float[Array, " n_times"],
    excess: Float[Array, " n_times"] | float = 1.0,
    *,
    neighbours: bool = False,
    shortest: float = 0.001,
) -> Float[Array, " m"]:
    """Return the mesh with every interval divided in which something is wrong.

    An interval is halved, quartered where the ``excess`` is over two, or cut in eight where it is
    over eight: errors between the nodes of a cubic spline go with the square of their distance, and
    more slowly beside a change of contact. They reach to the next intervals, and go
    there once nodes are nearer here: ``neighbours`` halves these as well, where they are not
    shorter.

    Args:
        nodes: The mesh [s].
        times: When something is wrong [s].
        excess: How much too large an error is there.
        neighbours: Whether neighbours are halved, too.
        shortest: No interval gets shorter [s].
    """
    at = np.clip(np.searchsorted(nodes, times, side="right") - 1, 0, len(nodes) - 2)
    most = np.zeros(len(nodes) - 1)
    np.maximum.at(most, at, np.broadcast_to(excess, at.shape))
    length = np.diff(nodes)
    if neighbours:
        reach = np.pad(np.where(most > 0, length, np.inf), 1, constant_values=np.inf)
        near = length > EQUAL_INTERVAL_RATIO * np.minimum(reach[:-2], reach[2:])
        most[near & (most == 0)] = 1.0
    new = [nodes]
    for k in np.flatnonzero(most > 0):
        allowed = (n for n in MIN_EXCESS if length[k] >= n * shortest)
        parts = next((n for n in allowed if most[k] > MIN_EXCESS[n]), 1)
        new.append(nodes[k] + length[k] * np.arange(1, parts) / parts)
    return np.sort(np.concatenate(new))
