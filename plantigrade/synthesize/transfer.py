"""A solved problem as the start of another one: on another mesh, or of a similar task."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.synthesize.problem.nlp import Problem
from plantigrade.synthesize.solvers.result import Multipliers
from plantigrade.synthesize.tasks.task import coefficients, sample_times

Start = tuple[Array, Array, Multipliers | None]


def transferred(
    old: Problem,
    c: Float[Array, "n_coefficients nv"],
    u: Float[Array, "n_nodes n_unknowns"],
    multipliers: Multipliers | None,
    new: Problem,
    switches: tuple[Array, Array] | None = None,
) -> Start:
    """Return coefficients, node unknowns and multipliers of a new problem.

    Args:
        old: The problem that was solved.
        c: Its coefficients.
        u: Its node unknowns.
        multipliers: Its multipliers, where known.
        new: The new problem.
        switches: Changes of contact of the old and of the new one: what lies between two of them
            stays between them. Where their numbers differ, times are scaled with the duration.
    """
    ends = np.array([0.0, new.basis.span]), np.array([0.0, old.basis.span])
    if switches is not None and len(switches[0]) == len(switches[1]):
        ends = switches[1], switches[0]

    def before(times: Array) -> Array:
        return np.interp(times, *ends)

    times = sample_times(new)
    then = np.clip(before(times), 0.0, old.basis.stop)
    q = old.states(c, then)[0] - old.drift(then) + new.drift(times)
    nodes, values = old.nodes, u
    if old.closure is not None:
        nodes = np.append(nodes, old.basis.span)
        values = np.vstack([values, values[:1, old.closure.u_source] * old.closure.u_sign])
    forces = np.zeros((len(new.nodes), new.n_unknowns))
    by_name = dict(zip(old.u_names, values.T, strict=False))  # not every task has a seat
    for i, name in enumerate(new.u_names):
        if name in by_name:
            forces[:, i] = np.interp(before(new.nodes), nodes, by_name[name])
    moved = None
    if multipliers is not None:
        moved = multipliers.moved(old.nodes, before(new.nodes))
    return coefficients(new, times, q), np.clip(forces, new.u_lower, new.u_upper), moved
