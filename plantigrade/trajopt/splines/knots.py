r"""Knot vectors: where the pieces of a spline join, and how smoothly.

A knot vector :math:`t_0 \le t_1 \le \dots` of a spline of degree :math:`\gamma` with :math:`n`
basis functions has :math:`n + \gamma + 1` knots [s]; the spline lives on :math:`[t_\gamma, t_n]`.
At a knot that occurs :math:`\mu` times it has :math:`\gamma - \mu` continuous derivatives: at
degree 3, a contact switch given twice lets the acceleration jump, given three times the velocity.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError

TIME_TOLERANCE = 1e-9  # [1] relative to the span; closer times coincide


def clamped_knots(breaks: Float[Array, " n_breaks"], degree: int = 3) -> Float[Array, " n_knots"]:
    r"""Return knots whose first and last have multiplicity :math:`\gamma + 1`.

    Value and derivatives at both ends then depend on the first and last coefficients alone, which
    suits boundary conditions; it is the knot vector of [Zhakatayev2023]_ (section VI). The number
    of coefficients is ``n_breaks + degree - 1``: one per node and two more at degree 3.

    Args:
        breaks: Breakpoints in order, first and last included [s]; one given twice becomes a knot of
            multiplicity two.
        degree: Degree of the spline, 0 or more.

    Raises:
        ParameterError: If the breakpoints are not finite and in order, or span nothing.

    Example:
        >>> clamped_knots(np.array([0.0, 0.5, 0.8, 2.0]), degree=2)
        array([0. , 0. , 0. , 0.5, 0.8, 2. , 2. , 2. ])
    """
    require_breaks(breaks)
    require_degree(degree)
    start, stop = breaks[0], breaks[-1]
    inner = breaks[(breaks > start) & (breaks < stop)]
    return np.concatenate([np.full(degree + 1, start), inner, np.full(degree + 1, stop)])


def periodic_knots(breaks: Float[Array, " n_breaks"], degree: int = 3) -> Float[Array, " n_knots"]:
    r"""Return the knots of a periodic spline: :math:`t_{i + n} = t_i + T`.

    The number of coefficients is ``n_breaks - 1``, that of the pieces of one period.

    Args:
        breaks: Breakpoints of one period in order [s]; the last is the first, a period :math:`T`
            later.
        degree: Degree of the spline, 0 or more, below the number of pieces.

    Example:
        >>> periodic_knots(np.array([0.0, 0.4, 1.0]), degree=1)
        array([-0.6,  0. ,  0.4,  1. ,  1.4])
    """
    require_breaks(breaks)
    require_degree(degree)
    n, period = len(breaks) - 1, breaks[-1] - breaks[0]
    if n < degree + 1:
        raise ParameterError(
            f"{n} pieces in a period are too few for a spline of degree {degree}: "
            f"give at least {degree + 1}, or a lower degree"
        )
    return np.concatenate(
        [breaks[n - degree : n] - period, breaks, breaks[1 : degree + 1] + period]
    )


def require_degree(degree: int) -> None:
    """Raise :class:`ParameterError` unless ``degree`` is a whole number, zero or more."""
    if not (isinstance(degree, int | np.integer) and degree >= 0):
        raise ParameterError(f"{degree=} of a spline must be a whole number, 0 or more")


def require_breaks(breaks: Float[Array, " n_breaks"]) -> None:
    """Raise :class:`ParameterError` unless breakpoints are finite, in order and span some time."""
    if breaks.ndim != 1 or len(breaks) < 2 or not np.isfinite(breaks).all():
        raise ParameterError("a spline needs two or more times in a row, all of them finite [s]")
    back = np.flatnonzero(np.diff(breaks) < 0)
    if len(back):
        i = int(back[0])
        raise ParameterError(
            f"knots must not go back in time: {breaks[i + 1]:g} s follows {breaks[i]:g} s"
        )
    if not breaks[-1] > breaks[0]:
        raise ParameterError(f"the knots span no time: all lie at {breaks[0]:g} s")


def require_knots(knots: Float[Array, " n_knots"], degree: int, *, periodic: bool) -> None:
    """Raise unless the knots define a spline of this degree in which every coefficient matters.

    Those of a periodic one must repeat, as from :func:`periodic_knots`.
    """
    require_degree(degree)
    require_breaks(knots)
    n = len(knots) - degree - 1
    if n < degree + 1:
        raise ParameterError(
            f"{len(knots)} knots are too few for a spline of degree {degree}, which needs "
            f"{2 * degree + 2} or more: give more knots or a lower degree"
        )
    flat = np.flatnonzero(knots[degree + 1 :] <= knots[:n])
    if len(flat):
        raise ParameterError(
            f"the knot at {knots[flat[0]]:g} s occurs more than {degree + 1} times, the most a "
            f"spline of degree {degree} can have: give it less often or raise the degree"
        )
    if periodic:
        period, inside = knots[n] - knots[degree], n - degree
        ahead = knots[inside:] - knots[: len(knots) - inside]
        if inside < degree + 1 or not np.allclose(
            ahead, period, rtol=0, atol=TIME_TOLERANCE * period
        ):
            raise ParameterError(
                "the knots do not repeat from period to period: make them with periodic_knots"
            )
    elif not (knots[degree] < knots[degree + 1] and knots[n - 1] < knots[n]):
        raise ParameterError(
            "the first or last basis function ends where the spline begins: put a knot at either "
            f"end {degree + 1} times (clamped_knots) or once"
        )
