r"""Minimum-jerk curve through postures and velocities given at a few instants.

The curve minimises :math:`\int |\dddot q|^2 dt`: a quintic between consecutive postures, with
accelerations at the postures that make the jerk continuous and zero at either end. Cubics (least
acceleration) would have discontinuous accelerations at the postures, and so would joint moments.
"""

import mujoco
import numpy as np
from scipy.interpolate import BPoly
from scipy.linalg import solve_banded

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.derivatives import Derivatives, continuous, differentiate
from plantigrade.models import Human

DIFFERENCE_STEP = 1e-4  # [s] step of the finite difference of positions


def curve_through(
    human: Human,
    time: Float[Array, " n"],
    postures: Float[Array, "n nq"],
    velocities: Float[Array, "n nv"],
    *,
    interval: float,
) -> tuple[Float[Array, " n_samples"], Derivatives]:
    """Return sample times [s] and the curve with its derivatives at these times.

    Args:
        time: Time of each posture [s], increasing; at least two.
        postures: Configurations; either sign of the quaternion.
        interval: Time between samples [s].
    """
    postures = continuous(postures)
    rates = np.empty_like(postures)
    for posture, velocity, rate in zip(postures, velocities, rates, strict=True):
        ahead, behind = posture.copy(), posture.copy()
        mujoco.mj_integratePos(human.model, ahead, velocity, DIFFERENCE_STEP)
        mujoco.mj_integratePos(human.model, behind, velocity, -DIFFERENCE_STEP)
        rate[:] = (ahead - behind) / (2 * DIFFERENCE_STEP)
    curve = BPoly.from_derivatives(
        time, np.stack([postures, rates, least_jerk_accelerations(time, postures, rates)], axis=1)
    )
    samples = np.linspace(time[0], time[-1], max(int((time[-1] - time[0]) / interval), 1) + 1)
    return samples, differentiate(human, samples, curve(samples), None)


def least_jerk_accelerations(
    time: Float[Array, " n"], values: Float[Array, "n k"], rates: Float[Array, "n k"]
) -> Float[Array, "n k"]:
    """Return the second derivatives of the minimum-jerk curve at its knots."""
    h, rise = np.diff(time)[:, None], np.diff(values, axis=0)
    # jerk of each quintic at its ends, without the contributions of the second derivatives there:
    # -9 a0 / h + 3 a1 / h at the left one, -3 a0 / h + 9 a1 / h at the right one
    left = (60 * rise - h * (36 * rates[:-1] + 24 * rates[1:])) / h**3
    right = (60 * rise - h * (24 * rates[:-1] + 36 * rates[1:])) / h**3
    band, rhs = np.zeros((3, len(time))), np.zeros_like(values)
    band[1, :-1] += 9 / h[:, 0]
    band[1, 1:] += 9 / h[:, 0]
    band[0, 1:] = band[2, :-1] = -3 / h[:, 0]
    rhs[:-1] += left
    rhs[1:] -= right
    return solve_banded((1, 1), band, rhs)
