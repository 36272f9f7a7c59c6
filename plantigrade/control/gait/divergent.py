r"""The divergent component of motion: its growth, and how much the offset of each foot moves it.

Every stance :math:`k` of a motion has a horizontal offset :math:`o_k`: where the foot really is,
less where the motion has it. With :math:`\alpha_k` the share of the load that stance carries (sum
1), the motion's centre of pressure moves by :math:`\sum_k \alpha_k o_k`. The divergent component
:math:`\xi = c + \dot c / \omega` [Hof2005]_ obeys
:math:`\dot{\delta\xi} = \omega (\delta\xi - \delta p)`; the one deviation that stays bounded is

.. math:: \delta\xi^* = \sum_k \beta_k o_k, \quad
    \beta_k(t) = \int_t^\infty \omega e^{-\omega (s - t)} \alpha_k(s) \, ds .

It needs no special cases for double support, starting, stopping, side steps, a seat or standing.
"""

import numpy as np

from plantigrade.arrays import Array, Float


def offset_weights(
    alpha: Float[Array, "n_times n_stances"], omega: float, step: float
) -> Float[Array, "n_times n_stances"]:
    r"""Return :math:`\beta`: how much the offset of each stance moves the divergent component.

    After the last time the shares stay what they are there. Where nothing carries (flight) there is
    no pressure either, and the divergent component of what comes next is waited for.

    Args:
        alpha: Share of the load that each stance carries; its rows sum to 1, or to 0 in flight.
        omega: Rate of the pendulum [1/s].
        step: Between two times [s].
    """
    n = len(alpha)
    keep = float(np.exp(-omega * step))
    beta = np.empty_like(alpha)
    now = alpha[-1].copy()
    for i in range(n - 1, -1, -1):
        if alpha[i].any():
            now = now * keep + alpha[i] * (1.0 - keep)
        beta[i] = now
    total = beta.sum(axis=1, keepdims=True)
    return np.divide(beta, total, out=np.zeros_like(beta), where=total > 0)


def effective_pivot(
    xi: Float[Array, " 2"], later: Float[Array, " 2"], growth: float
) -> Float[Array, " 2"]:
    r"""Return the constant pivot about which the divergent component grows to another value.

    .. math:: \xi_T = p + (\xi - p) \, e^{\omega T}

    Args:
        xi: Divergent component now [m].
        later: The same after a time :math:`T` [m].
    """
    return (later - growth * xi) / (1.0 - growth)
