r"""The smooth curve through postures that are known at a few instants only, with their rates.

Of all curves that pass the postures at their rates it is the one of least jerk,
:math:`\min \int |\dddot q|^2 dt`: a quintic from each posture to the next, whose accelerations at
the postures are such that the jerk does not jump, and vanishes at either end. A cubic between each
two (least acceleration) would let accelerations jump there, and the joint moments with them.
"""

import mujoco
import numpy as np
from scipy.interpolate import BPoly
from scipy.linalg import solve_banded

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.derivatives import Derivatives, continuous, differentiate
from plantigrade.models import Human

SMALL = 1e-4  # step of a finite difference [s]


def curve_through(
    human: Human,
    time: Float[Array, " n"],
    postures: Float[Array, "n nq"],
    velocities: Float[Array, "n nv"],
    *,
    interval: float,
) -> tuple[Float[Array, " n_samples"], Derivatives]:
    """Return the times of samples [s], and the curve there with its rates.

    Args:
        human: Whose postures.
        time: When each is passed [s], increasing; at least two.
        postures: Configurations; either sign of the quaternion.
        velocities: At which each is passed.
        interval: Time between samples [s].
    """
    postures = continuous(postures)
    rates = np.empty_like(postures)
    for posture, velocity, rate in zip(postures, velocities, rates, strict=True):
        ahead, behind = posture.copy(), posture.copy()
        mujoco.mj_integratePos(human.model, ahead, velocity, SMALL)
        mujoco.mj_integratePos(human.model, behind, velocity, -SMALL)
        rate[:] = (ahead - behind) / (2 * SMALL)
    curve = BPoly.from_derivatives(
        time, np.stack([postures, rates, smoothest(time, postures, rates)], axis=1)
    )
    samples = np.linspace(time[0], time[-1], max(int((time[-1] - time[0]) / interval), 1) + 1)
    return samples, differentiate(human, samples, curve(samples), None)


def smoothest(
    time: Float[Array, " n"], values: Float[Array, "n k"], rates: Float[Array, "n k"]
) -> Float[Array, "n k"]:
    """Return the second derivatives with which the curve of this module passes values at rates."""
    h, rise = np.diff(time)[:, None], np.diff(values, axis=0)
    # jerk of each quintic at its ends, without the shares of the second derivatives there:
    # -9 a0 / h + 3 a1 / h at the left one, -3 a0 / h + 9 a1 / h at the right one
    left = (60 * rise - h * (36 * rates[:-1] + 24 * rates[1:])) / h**3
    right = (60 * rise - h * (24 * rates[:-1] + 36 * rates[1:])) / h**3
    band, wanted = np.zeros((3, len(time))), np.zeros_like(values)
    band[1, :-1] += 9 / h[:, 0]
    band[1, 1:] += 9 / h[:, 0]
    band[0, 1:] = band[2, :-1] = -3 / h[:, 0]
    wanted[:-1] += left
    wanted[1:] -= right
    return solve_banded((1, 1), band, wanted)
