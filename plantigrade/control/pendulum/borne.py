r"""The centre of mass that the feet of a walk can bear.

From a recording the mass is known to a centimetre, its acceleration not: where it would have to be
pushed from beside the feet, nobody can follow it. Between the feet's centre of pressure :math:`p`
and the mass of a linear pendulum is

.. math:: \ddot x = \omega^2 (x - p),

whose periodic solution is the pressure without its high frequencies,
:math:`\hat x_k = \hat p_k \, \omega^2 / (\omega^2 + (2 \pi k / T)^2)`: the dynamics filter of a
walk that repeats itself.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import solve_banded

from plantigrade.control.gait.reference import STEP, Reference


def borne(reference: Reference) -> Reference:
    """Return a walk whose centre of mass moves over the ground as its feet can make it.

    Args:
        reference: The walk; one that does not repeat itself begins and ends where it does.
    """
    if reference.period is None:
        return _once(reference)
    found = replace(reference, table=reference.table.copy())
    rows = found.rows
    com, velocity, acceleration, pressure = (
        rows.com,
        rows.com_velocity,
        rows.com_acceleration,
        rows.cop,
    )
    n = len(com) - 1
    rate = reference.advance[:2] / reference.period
    time = STEP * np.arange(n)[:, None]
    part = np.fft.rfft(pressure[:-1, :2] - rate * time, axis=0)
    turns = 2.0 * np.pi * np.arange(len(part))[:, None] / reference.period
    part *= reference.omega**2 / (reference.omega**2 + turns**2)
    com[:-1, :2] = np.fft.irfft(part, n, axis=0) + rate * time
    velocity[:-1, :2] = np.fft.irfft(1j * turns * part, n, axis=0) + rate
    acceleration[:-1, :2] = reference.omega**2 * (com - pressure)[:-1, :2]
    com[-1, :2] = com[0, :2] + reference.advance[:2]
    velocity[-1, :2], acceleration[-1, :2] = velocity[0, :2], acceleration[0, :2]
    return found


def _once(reference: Reference) -> Reference:
    """Return the same for a walk that is done once: the pendulum between its ends."""
    found = replace(reference, table=reference.table.copy())
    rows = found.rows
    com, velocity, acceleration, pressure = (
        rows.com,
        rows.com_velocity,
        rows.com_acceleration,
        rows.cop,
    )
    n = len(com) - int(reference.ends)  # the row after the end rests
    stiff = (reference.omega * STEP) ** 2
    band = np.ones((3, n - 2))
    band[1] = -2.0 - stiff
    right = -stiff * pressure[1 : n - 1, :2]
    right[0] -= com[0, :2]
    right[-1] -= com[n - 1, :2]
    com[1 : n - 1, :2] = solve_banded((1, 1), band, right)
    velocity[:n, :2] = np.gradient(com[:n, :2], STEP, axis=0)
    acceleration[:n, :2] = reference.omega**2 * (com - pressure)[:n, :2]
    return found
