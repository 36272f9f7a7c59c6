r"""Hierarchical quadratic programs: levels of equations and inequalities in strict order.

Level :math:`k` requires :math:`l_k \le A_k x \le u_k` (an equation where :math:`l = u`). The answer
violates the first level as little as possible in the least-squares sense, then the second as
little as it can without changing what the first one got, and so on ([Kanoun2009]_,
[Escande2014]_). Whatever freedom is left goes to the preference

.. math:: \min_x\; (x - \hat x)^T H\, (x - \hat x).

With equations alone this is the recursion of null-space projections of [Siciliano1991]_, which for
two levels reads :math:`x = A_1^+ b_1 + P_1 (A_2 P_1)^+ (b_2 - A_2 A_1^+ b_1)` (Eq. 8 of
[Boukheddimi]_).

Two stages. The recursion is run first; directions in which a level is singular, alone or because
higher levels hold them, are left to the levels below: dividing by their small singular values would
give huge answers. Usually one QR decomposition tells that a level has none; only otherwise are its
singular values computed. (Damping them, as is usual for one task, would hold them as well: a foot
that can hardly be moved along the ground by rolling would never begin to roll.) If its answer
satisfies every inequality it is the answer. Otherwise it is moved to the nearest one that does,
within what the levels leave free, by the dual method of [Goldfarb1983]_: where all levels can still
be met, that takes a few small steps. Where a level has to give way, the independent equations that
the recursion found and all inequalities go to DAQP, which solves the whole hierarchy in one call
([Arnstrom2022]_). DAQP scales every row to unit length, which would weigh the violations of a level
against each other; one more unknown, fixed at zero, gives all rows of a level the same length
before.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np
from scipy.linalg import get_lapack_funcs

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError, SolverError
from plantigrade.wbc.level import Level, check_shapes, check_values

geqrf, orgqr, gesdd, posv, trtrs = get_lapack_funcs(
    ("geqrf", "orgqr", "gesdd", "posv", "trtrs"), dtype=np.float64
)

INFINITY = 1e30  # DAQP's infinity
INEQUALITY_TOLERANCE = 1e-9  # [1] relative violation up to which an inequality counts as satisfied
# Of a unit row; DAQP's own 1e-6 lets a lower level push a higher one by as much. Rows that depend
# on one another can be too tight for the first: then it gives up, or stops short of what a level
# could reach. Where two levels are missed, or one and rows depend on others, the next is tried too
# and the better answer taken.
TOLERANCES = (1e-9, 1e-7)
LEVEL_TOLERANCE = 1e-5  # [1] relative difference of violations up to which two answers are equal
MAX_EXCHANGES = 20  # [1] limit of changes of the active set
MIN_INDEPENDENT_SHARE = 1e-6  # [1] of a row's length, outside the span of the others


@dataclass(frozen=True)
class HierarchySolution:
    """The answer of a hierarchical program."""

    x: Float[Array, " n"]  #: The unknowns
    levels: Sequence[Level]  #: The levels, as given
    ranks: tuple[int, ...]  #: Number of directions that each level's equations determined
    exact: bool  #: Whether the recursion alone gave the answer (no inequality was in the way)
    iterations: int  #: Iterations of the active-set methods; 0 where they were not needed

    @property
    def residuals(self) -> tuple[float, ...]:
        """Violation of each level: the norm of its rows' residuals."""
        return tuple(float(np.linalg.norm(level.residual(self.x))) for level in self.levels)


def solve_hierarchy(
    levels: Sequence[Level],
    *,
    lower: Float[Array, " n"],
    upper: Float[Array, " n"],
    preferred: Float[Array, " n"] | None = None,
    metric: Float[Array, "n n"] | None = None,
    singular: float = 1e-8,
) -> HierarchySolution:
    """Solve a hierarchy of equations and inequalities.

    Args:
        levels: From the most to the least important.
        lower: Lower bounds of the unknowns; they stand above all levels.
        upper: Upper bounds.
        preferred: Where the unknowns go as far as the levels leave them free; zero if absent.
        metric: Symmetric positive definite matrix of that preference; the identity if absent.
        singular: Gain, in the units of the rows, below which a direction of a level counts as
            singular and is left to the levels below.

    Raises:
        ParameterError: If shapes do not agree, a value is not finite, or bounds cross.
        SolverError: If no answer was found.
    """
    n = len(lower)
    check_shapes(levels, lower, upper)
    preferred = np.zeros(n) if preferred is None else preferred
    parts = [level.parts() for level in levels]
    try:
        reduced, x, held = _recursion([p[0] for p in parts], n, preferred, metric, singular)
    except np.linalg.LinAlgError:  # of values that are not finite
        check_values(levels, lower, upper)
        raise
    ranks = tuple(len(right) for _, right in reduced)
    inequalities = [p[1] for p in parts]
    bounds = [(None, lower, upper), *(p for p in inequalities if p is not None)]
    if _satisfied(x, bounds):
        return HierarchySolution(x, levels, ranks, True, 0)
    found = _holding(x, held, bounds) if metric is None else None
    if found is None:
        check_values(levels, lower, upper)  # nothing satisfies a bound that is no number
        found = _active_set(reduced, inequalities, lower, upper, preferred, metric)
    return HierarchySolution(found[0], levels, ranks, False, found[1])


def _recursion(equations, n, preferred, metric, singular):
    """Return independent equations of each level, the answer without inequalities, what is held."""
    held, part = np.zeros((n, 0)), np.zeros(0)  # orthonormal columns; the answer along them
    reduced = list(equations)
    left = [k for k, (_, right) in enumerate(equations) if len(right)]
    while left:
        found = _regular([equations[k] for k in left], held, part, singular)
        if found is None:
            matrix, right = equations[left[0]]
            found, mixed = _singular(matrix, right, held, part, singular)
            reduced[left[0]] = mixed @ matrix, mixed @ right
        done, basis, along = found
        held = np.concatenate([held, basis], axis=1) if len(part) else basis
        part = np.concatenate([part, along]) if len(part) else along
        left = left[done:]
    back = held.T @ preferred - part
    if metric is None or held.shape[1] >= n:
        return reduced, preferred - held @ back, held
    light = _divided(metric, held)
    return reduced, preferred - light @ np.linalg.solve(held.T @ light, back), held


def _divided(metric, columns):
    """Return the inverse of a metric times columns."""
    _, result, failed = posv(metric, columns)
    if failed:
        raise ParameterError("the metric of the preference is not positive definite")
    return result


def _regular(equations, held, part, singular):
    """Return how many of the next levels have no singular direction, and what they determine.

    That is: of what the levels above leave free, orthonormal columns and the answer along them.
    None if the next level has a singular direction. One decomposition of all rows, one level below
    the other, tells it of all levels: in its triangle each has a block of its own.
    """
    rows = np.concatenate([matrix for matrix, _ in equations])
    right = np.concatenate([value for _, value in equations])
    if len(right) > len(held) - held.shape[1]:
        return None
    rows, right = _left(rows, right, held, part)
    qr, tau, *_ = geqrf(rows.T)  # rows = R^T Q^T
    if min(abs(r) for r in qr.diagonal()[: len(equations[0][1])].tolist()) < singular:
        return None  # the least singular value is no larger than any of these
    inverse, failed = trtrs(qr[: len(right)], np.eye(len(right)))
    done = end = 0
    all_regular = singular**2 * np.vdot(inverse.T, inverse.T) < 1.0
    for _, value in equations if not failed else ():
        start, end = end, end + len(value)
        block = inverse[start:end, start:end]
        # None of a block is below 1 / |its inverse|.
        if not (all_regular or singular**2 * np.vdot(block, block) < 1.0):
            end = start
            break
        done += 1
    return (done, orgqr(qr, tau)[0][:, :end], right[:end] @ inverse[:end, :end]) if done else None


def _singular(matrix, right, held, part, singular):
    """Return the same of one level without its singular directions, and U^T of its U s V^T."""
    own, rest = _left(matrix, right, held, part)
    if not isfinite(own.sum() + right.sum()):
        raise np.linalg.LinAlgError
    v, s, ut, failed = gesdd(own.T, full_matrices=0)
    if failed:
        ut, s, v = (part.T for part in np.linalg.svd(own, full_matrices=False))
    rank = int(np.count_nonzero(s > singular))
    ut = ut[:rank]
    return (1, v[:, :rank], (ut @ rest) / s[:rank]), ut


def _left(rows, right, held, part):
    """Return what of rows and right side the levels above have not settled."""
    if not held.shape[1]:
        return rows, right
    across = rows @ held
    return rows - across @ held.T, right - across @ part


def _satisfied(x, bounds) -> bool:
    """Return whether an answer keeps all bounds; one that is not finite keeps none."""
    room = []
    for matrix, low, high in bounds:
        value = x if matrix is None else matrix @ x
        room.append(np.minimum(value - low, high - value).min(initial=np.inf))
    return all(r >= 0.0 for r in room) or all(r >= -_slack(x) for r in room)


def _slack(x) -> float:
    return INEQUALITY_TOLERANCE * max(1.0, float(np.abs(x).max(initial=0.0)))


def _holding(x, held, bounds):
    r"""Return the answer if all levels can be met, and the number of steps; None if they cannot.

    The dual method of [Goldfarb1983]_, within what the levels leave free: the inequality furthest
    in the way is pushed back along the part of its row that those at their bounds leave free, and
    whose multiplier falls to zero on the way is let go. The result is the answer nearest to
    ``x``: nothing is violated, and every row that is held pushes the way it can.
    """
    rows = np.concatenate([np.eye(len(x)), *(matrix for matrix, _, _ in bounds[1:])])
    low = np.concatenate([least for _, least, _ in bounds])
    high = np.concatenate([most for _, _, most in bounds])
    slack = _slack(x)
    at = np.zeros((0, len(x)))  # free parts of the rows at their bounds, outwards
    push = np.zeros(0)  # their multipliers
    for step in range(MAX_EXCHANGES):
        value = rows @ x
        over, under = value - high, low - value
        beyond = np.maximum(over, under)
        worst = int(beyond.argmax())
        left = beyond[worst]
        if left <= slack:
            return x, step
        outward = rows[worst] if over[worst] > 0.0 else -rows[worst]
        outward = outward - held @ (outward @ held)
        least = (MIN_INDEPENDENT_SHARE * np.linalg.norm(rows[worst])) ** 2
        own = 0.0
        while left > 0.0:
            _, share, failed = posv(at @ at.T, at @ outward) if len(at) else (None, push, 0)
            way = outward - share @ at
            gain = way @ way
            full = left / gain if gain > least else np.inf
            until = np.full(len(at), np.inf)
            np.divide(push, share, out=until, where=share > 0.0)
            size = min(full, until.min(initial=np.inf))
            if failed or size == np.inf:
                return None  # a level has to give way
            x, push, own = x - size * way, push - size * share, own + size
            if size < full:
                gone = until.argmin()
                at, push = np.delete(at, gone, axis=0), np.delete(push, gone)
                left -= size * gain
            else:
                at, push = np.vstack([at, outward]), np.append(push, own)
                left = 0.0
    return None


def _active_set(reduced, inequalities, lower, upper, preferred, metric):
    """Return the answer and the number of iterations, by DAQP."""
    import daqp

    n = len(lower)
    rows, low, high, sizes = [], [lower, [0.0]], [upper, [0.0]], [n + 1]
    for (matrix, value), others in zip(reduced, inequalities, strict=True):
        rest, least, most = others or (matrix[:0], value[:0], value[:0])
        if len(value) + len(least):
            rows += [matrix, rest]
            low += [value, least]
            high += [value, most]
            sizes.append(len(value) + len(least))
    A = np.zeros((sum(sizes[1:]), n + 1))
    if rows:
        np.concatenate(rows, out=A[:, :n])
    raised = A[:, :n] if metric is None else _divided(metric, A[:, :n].T).T
    length = np.einsum("ij,ij->i", A[:, :n], raised)
    start = 0
    for size in sizes[1:]:
        own = slice(start, start + size)
        A[own, n] = np.sqrt((length[own].max() or 1.0) - length[own])
        start += size
    H = np.eye(n + 1)
    if metric is not None:
        H[:n, :n] = metric
    f = np.zeros(n + 1)
    f[:n] = -preferred if metric is None else -metric @ preferred
    bounds = [np.clip(np.concatenate(side), -INFINITY, INFINITY) for side in (high, low)]
    ends = np.cumsum(sizes, dtype=np.int32)
    best, missed, iterations = None, np.zeros(0), 0
    for tolerance in TOLERANCES:
        sense = np.zeros(len(bounds[0]), dtype=np.int32)
        x, _, flag, info = daqp.solve(
            H, f, A, *bounds, sense, break_points=ends, primal_tol=tolerance
        )
        if flag < 1 or not np.isfinite(x).all():
            continue
        iterations += int(info["iterations"])
        found = _missed(A @ x, bounds[1][n + 1 :], bounds[0][n + 1 :], ends)
        if best is None or _before(found, missed):
            best, missed = x[:n], found
        levels_missed = np.flatnonzero(found > LEVEL_TOLERANCE)
        if not len(levels_missed):
            break
        above = ends[levels_missed[0]] - ends[0]  # rows of the levels above the first one missed
        equal = bounds[0][n + 1 :][:above] == bounds[1][n + 1 :][:above]
        if len(levels_missed) == 1 and not _depend(A, A[:above, :n], equal):
            break
    if best is None:
        raise SolverError(
            f"the hierarchical program of {n} unknowns and {len(A)} rows was not solved "
            f"(DAQP says {flag}); widen the bounds or take the last level away"
        )
    return best, iterations


def _depend(rows, above, equal) -> bool:
    """Return whether a row repeats, or an inequality above is one of the equations there."""
    if len({row.tobytes() for row in rows}) < len(rows):
        return True
    held = np.linalg.qr(above[equal].T)[0]
    rest = above[~equal]
    left = np.linalg.norm(rest - (rest @ held) @ held.T, axis=1)
    return bool((left < MIN_INDEPENDENT_SHARE * np.linalg.norm(rest, axis=1)).any())


def _missed(value, low, high, ends) -> Float[Array, " n_levels"]:
    """Return the violation of each level that has rows."""
    over = np.maximum(value - high, 0.0) + np.minimum(value - low, 0.0)
    return np.sqrt(np.add.reduceat(over**2, ends[:-1] - ends[0])) if len(over) else over


def _before(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether the first level in which two answers differ is missed by less in ``one``."""
    apart = np.flatnonzero(np.abs(one - other) > LEVEL_TOLERANCE * np.maximum(1.0, other))
    return bool(len(apart) and one[apart[0]] < other[apart[0]])
