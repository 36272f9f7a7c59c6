r"""Velocities and accelerations of a motion, in MuJoCo's tangent space.

The root's quaternion :math:`q` is smoothed and differentiated component by component (a linear
filter commutes with rotations of the world, so no direction is preferred) and normalised again.
With quintic splines through the samples for :math:`\dot q` and :math:`\ddot q`, the angular
velocity and acceleration in body axes are

.. math:: \omega = 2\,\mathrm{vec}(\bar q\,\dot q), \qquad
    \dot\omega = 2\,\mathrm{vec}(\bar q\,\ddot q),

the second because :math:`\dot{\bar q} \dot q` is a pure scalar. Shoulders near the singularity of
their angles are treated likewise (:mod:`plantigrade.dynamics.ball_joints`).

A filter that reflects the signal at its ends removes its curvature there: accelerations and moments
approach zero in the first and last tenths of a second. A cubic with the signal's curvature at both
ends is therefore subtracted before filtering and added afterwards; the filter passes cubics
unchanged.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.ball_joints import ball_joints
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion.filters import check_time, lowpass
from plantigrade.motion.recording import even_clock
from plantigrade.spatial.conventions import continuous_poses


@dataclass(frozen=True)
class MotionDerivatives:
    """A motion with its derivatives."""

    qpos: Float[Array, "n_frames nq"]  #: Configurations, smoothed where a cut-off was given
    #: Velocities: root linear in world axes [m/s], root angular in body axes [rad/s], hinges
    #: [rad/s]
    qvel: Float[Array, "n_frames nv"]
    qacc: Float[Array, "n_frames nv"]  #: Accelerations, in the axes of ``qvel``


def differentiate(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    cutoff: float | None,
) -> MotionDerivatives:
    """Return a motion's velocities and accelerations.

    Args:
        time: Time of each frame [s], increasing; evenly spaced if ``cutoff`` is given.
        qpos: Configurations; either sign of the quaternion.
        cutoff: Zero-lag fourth-order low-pass of everything before differentiation [Hz]; None
            for no filter. Use the same for the forces.
    """
    if qpos.shape != (len(time), human.model.nq):
        raise ParameterError(
            f"qpos has shape {qpos.shape}; {len(time)} frames of this person need "
            f"({len(time)}, {human.model.nq})"
        )
    if not np.isfinite(qpos).all():
        frame = int(np.flatnonzero(~np.isfinite(qpos).all(axis=1))[0])
        raise ParameterError(f"qpos has missing values (frame {frame}); close the gaps first")
    check_time(time, qpos)
    time = even_clock(time)
    shoulders = ball_joints(human, qpos)
    quaternions = [each.quaternions(qpos[:, 7:][:, each.hinges]) for each in shoulders]
    smooth = np.hstack([continuous_poses(qpos), *quaternions])
    if cutoff is not None:
        smooth = smoothed(time, smooth, cutoff)
    turns = [slice(3, 7), *(slice(k, k + 4) for k in range(human.model.nq, smooth.shape[1], 4))]
    for at in turns:
        smooth[:, at] /= np.linalg.norm(smooth[:, at], axis=1, keepdims=True)
    first, second = slopes(time, smooth)
    velocity, acceleration = (
        np.hstack([s[:, :3], _spin(smooth, s, turns[0]), s[:, 7 : human.model.nq]])
        for s in (first, second)
    )
    for each, at in zip(shoulders, turns[1:], strict=True):
        k = 7 + np.array(each.hinges)
        smooth[:, k] = each.angles(smooth[:, at], qpos[:, k])
        spins = (_spin(smooth, s, at) for s in (first, second))
        velocity[:, k - 1], acceleration[:, k - 1] = each.rates(smooth[:, k], *spins)
    return MotionDerivatives(smooth[:, : human.model.nq], velocity, acceleration)


def smoothed(
    time: Float[Array, " n_frames"], values: Float[Array, "n_frames k"], cutoff: float
) -> Float[Array, "n_frames k"]:
    """Return the low-passed signal with the curvature at its ends kept.

    Args:
        time: Time of each frame [s], evenly spaced.
        cutoff: Zero-lag fourth-order low-pass [Hz].
    """
    near = [np.abs(time - end) <= 1.0 / cutoff for end in (time[0], time[-1])]
    if min(m.sum() for m in near) < 5:
        return lowpass(time, values, cutoff=cutoff)
    span = time[-1] - time[0]
    u = (time - time[0]) / span
    # Second derivative with respect to u, of a parabola over one period of the cut-off.
    start, stop = (2 * np.polyfit(u[m], values[m], 2)[0] for m in near)
    cubic = np.outer(u**2 / 2, start) + np.outer(u**3 / 6, stop - start)
    return cubic + lowpass(time, values - cubic, cutoff=cutoff)


def slopes(
    time: Float[Array, " n_frames"], values: Float[Array, "n_frames k"]
) -> tuple[Float[Array, "n_frames k"], Float[Array, "n_frames k"]]:
    """Return first and second derivative of an interpolating spline, quintic where it can be."""
    from scipy.interpolate import make_interp_spline

    n = len(time)
    if n < 3:
        rise = np.diff(values, axis=0) / np.diff(time)[:, None] if n == 2 else np.zeros((1, 1))
        return np.broadcast_to(rise, values.shape).copy(), np.zeros_like(values)
    degree = 5 if n >= 6 else 3 if n >= 4 else 2
    if degree == 2:  # the parabola through three samples
        coefficients = np.polyfit(time - time[1], values, 2)
        t = (time - time[1])[:, None]
        return 2 * coefficients[0] * t + coefficients[1], np.tile(2 * coefficients[0], (n, 1))
    spline = make_interp_spline(time - time[0], values, k=degree)
    return spline(time - time[0], 1), spline(time - time[0], 2)


def _spin(values: np.ndarray, slopes: np.ndarray, at: slice) -> np.ndarray:
    """Return angular velocity or acceleration in body axes from a slope of a quaternion."""
    return 2 * _vector_of_product(values[:, at], slopes[:, at])


def _vector_of_product(quat: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the vector part of conj(quat) other, ``wxyz``."""
    w, v = quat[:, :1], quat[:, 1:]
    return w * other[:, 1:] - other[:, :1] * v - np.cross(v, other[:, 1:])
