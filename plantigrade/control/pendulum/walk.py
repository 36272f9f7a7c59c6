r"""A recorded walk made ready to be walked: a stride closed, the mass moved as feet can bear it.

From a recording the position of the centre of mass is known to a centimetre, its acceleration not:
some of it would need a pressure beside the feet. Between the feet's centre of pressure :math:`p`
and the mass of a linear pendulum is

.. math:: \ddot x = \omega^2 (x - p),

whose periodic solution is the pressure without its high frequencies,
:math:`\hat x_k = \hat p_k \, \omega^2 / (\omega^2 + (2 \pi k / T)^2)`: the dynamics filter of a
walk that repeats itself.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import solve_banded

from plantigrade.control.gait.reference import STEP, Reference, period_of
from plantigrade.kinematics.stride import stride_of
from plantigrade.record import Record


def walk_of(record: Record) -> Record:
    """Return the most even stride of a walk, closed, along x on level ground.

    A walk that repeats itself already (a synthesised one) or was not recorded on level ground is
    returned as it is. So is a motion without a stride that nearly closes, with a note: it ends
    where it ends.

    Args:
        record: The walk: fitted, reproduced or synthesised.

    Raises:
        ParameterError: If the motion has less than four frames, or gaps.
    """
    ground = record.ground
    uneven = ground.slope or ground.steps or ground.seats or ground.uneven
    if uneven or period_of(record)[0] is not None:
        return record
    stride = stride_of(record.human, record.motion)
    if not stride.cyclic:
        note = "No stride of the motion nearly closes; it is walked once, unchanged."
        return replace(record, notes=(*record.notes, note))
    motion, level = stride.motion(record.human), replace(ground, height=0.0)
    return Record(record.human, motion, ground=level, notes=record.notes)


def with_feasible_com(reference: Reference) -> Reference:
    """Return a walk whose centre of mass moves over the ground as its feet can bear it.

    Args:
        reference: The walk; one that does not repeat itself begins and ends where it does.
    """
    found, omega = replace(reference, table=reference.table.copy()), reference.omega
    rows = found.rows
    com, velocity, acceleration, cop = (
        each[:, :2] for each in (rows.com, rows.com_velocity, rows.com_acceleration, rows.cop)
    )
    if reference.period is None:  # the pendulum between its ends
        n = len(com) - int(reference.ends)  # the row after the end rests
        stiff = (omega * STEP) ** 2
        band = np.ones((3, n - 2))
        band[1] = -2.0 - stiff
        right = -stiff * cop[1 : n - 1]
        right[0] -= com[0]
        right[-1] -= com[n - 1]
        com[1 : n - 1] = solve_banded((1, 1), band, right)
        velocity[:n] = np.gradient(com[:n], STEP, axis=0)
        acceleration[:n] = omega**2 * (com - cop)[:n]
        return found
    n = len(com) - 1
    speed = reference.advance[:2] / reference.period
    time = STEP * np.arange(n)[:, None]
    part = np.fft.rfft(cop[:-1] - speed * time, axis=0)
    frequency = 2.0 * np.pi * np.arange(len(part))[:, None] / reference.period
    part *= omega**2 / (omega**2 + frequency**2)
    com[:-1] = np.fft.irfft(part, n, axis=0) + speed * time
    velocity[:-1] = np.fft.irfft(1j * frequency * part, n, axis=0) + speed
    acceleration[:-1] = omega**2 * (com - cop)[:-1]
    com[-1] = com[0] + reference.advance[:2]
    velocity[-1], acceleration[-1] = velocity[0], acceleration[0]
    return found
