"""Conventions for axes, quaternions and velocities, and all conversions between them.

* World and bodies: x forward, y left, z up. OpenSim: x forward, y up, z right.
* Quaternions: MuJoCo ``wxyz``; SciPy ``xyzw``.
* Free joint: MuJoCo's velocity is linear in world axes and angular in body axes.
"""

from collections.abc import Sequence
from functools import lru_cache
from math import atan2, cos, hypot, sin
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError

# Columns are OpenSim's axes in ours: v_ours = OPENSIM_TO_WORLD @ v_opensim.
OPENSIM_TO_WORLD = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])

PELVIS = ("pelvis_tilt", "pelvis_list", "pelvis_rotation", "pelvis_tx", "pelvis_ty", "pelvis_tz")
"""Pelvis coordinates in OpenSim's order: angles, then translations in its axes."""
MIN_LENGTH = 1e-12  # below which a vector has no direction


def wxyz_to_xyzw(quat: Float[Array, "*n 4"]) -> Float[Array, "*n 4"]:
    """Return MuJoCo's quaternion in SciPy's order."""
    return np.roll(quat, -1, axis=-1)


def xyzw_to_wxyz(quat: Float[Array, "*n 4"]) -> Float[Array, "*n 4"]:
    """Return SciPy's quaternion in MuJoCo's order."""
    return np.roll(quat, 1, axis=-1)


def rotation_matrix(quat: Float[Array, "*n 4"]) -> Float[Array, "*n 3 3"]:
    """Return the matrix that maps body axes to world axes for ``wxyz`` quaternions."""
    q = quat / np.linalg.norm(quat, axis=-1, keepdims=True)
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return matrices(rows)


def matrices(rows: Sequence[Sequence[Any]]) -> Float[Array, "*n i j"]:
    """Return matrices from their entries, an array or a number each, row by row."""
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotation_quaternion(rotation: Float[Array, "*n 3 3"]) -> Float[Array, "*n 4"]:
    """Return ``wxyz`` of rotations, the inverse of :func:`rotation_matrix`."""
    from scipy.spatial.transform import Rotation

    return xyzw_to_wxyz(Rotation.from_matrix(rotation).as_quat())


def continuous(quat: Float[Array, "n 4"]) -> Float[Array, "n 4"]:
    """Return quaternions, in either order, that do not change sign from one to the next."""
    flips = np.where((quat[1:] * quat[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    return quat * np.concatenate([[1.0], np.cumprod(flips)])[:, None]


def continuous_poses(qpos: Float[Array, "n nq"]) -> Float[Array, "n nq"]:
    """Return configurations of a body with a free root, its quaternion :func:`continuous`."""
    return np.hstack([qpos[:, :3], continuous(qpos[:, 3:7]), qpos[:, 7:]])


def about_vertical(angle: Float[Array, "*n"] | float) -> Float[Array, "*n 3 3"]:
    """Return rotations about the vertical by angles, to the left [rad].

    Example:
        >>> (about_vertical(np.pi / 2) @ [1.0, 0.0, 0.0]).round(9) + 0.0
        array([0., 1., 0.])
    """
    c, s = np.cos(angle), np.sin(angle)
    out = np.zeros((*np.shape(angle), 3, 3))
    out[..., 0, 0] = out[..., 1, 1] = c
    out[..., 0, 1], out[..., 1, 0], out[..., 2, 2] = -s, s, 1.0
    return out


def axes_along(
    first: Float[Array, "*n 3"], second: Float[Array, "... 3"]
) -> Float[Array, "*n 3 3"]:
    """Return axes as columns: along a vector, along another made square to it, and their product.

    Example:
        >>> axes_along(np.array([2.0, 0.0, 0.0]), np.array([1.0, 0.0, 3.0])) + 0.0
        array([[ 1.,  0.,  0.],
               [ 0.,  0., -1.],
               [ 0.,  1.,  0.]])
    """
    u = first / np.sqrt((first * first).sum(axis=-1, keepdims=True))
    v = second - (u * second).sum(axis=-1, keepdims=True) * u
    v = v / np.sqrt((v * v).sum(axis=-1, keepdims=True))
    return np.stack([u, v, np.cross(u, v)], axis=-1)


def surface_axes(normal: Float[Array, " 3"]) -> Float[Array, "3 3"]:
    """Return axes of a surface as columns, two along it and its normal; the world's if level.

    Args:
        normal: Normal of length one.
    """
    first = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = first - (first @ normal) * normal
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first), normal], axis=1)


def tilt_to(normal: Array) -> Float[Array, "3 3"]:
    """Return the shortest rotation of the vertical to a normal of the ground."""
    return _tilt(*normal.tolist())


@lru_cache(maxsize=16)
def _tilt(x: float, y: float, z: float) -> Array:
    k = 1.0 / (1.0 + z)
    xx, xy, yy = k * x * x, k * x * y, k * y * y
    return np.array([[1.0 - xx, -xy, x], [-xy, 1.0 - yy, y], [-x, -y, z]])


def less_tilted(rotation: Float[Array, "3 3"], part: float) -> Float[Array, "3 3"]:
    """Return the rotation of a body, such as a foot, without a part of its tilt."""
    x, y, z = rotation[:, 2].tolist()
    far = max(hypot(x, y), 1e-9)
    angle = part * atan2(far, z)
    normal = np.array([-x / far * sin(angle), -y / far * sin(angle), cos(angle)])
    return tilt_to(normal) @ rotation


def facing(quat: Float[Array, "*n 4"]) -> Float[Array, "*n 2"]:
    """Return horizontal directions, of length one, in which bodies (``wxyz``) have their x axis."""
    return unit_vectors(rotation_matrix(quat)[..., :2, 0])


def about_axis(axis: Float[Array, " 3"], angle: Float[Array, " n"]) -> Float[Array, "n 3 3"]:
    """Return the rotations about an axis of length one by angles [rad] (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * K + (1.0 - c) * (K @ K)


def within_half_turn(angle: Float[Array, "*n"] | float) -> Any:
    """Return angles between -180° and 180° [rad]."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def turned(quat: Float[Array, "*n 4"], angle: Float[Array, " n"] | float) -> Float[Array, "*n 4"]:
    """Return orientations (``wxyz``) turned about the vertical by angles, to the left [rad].

    Example:
        >>> turned(np.array([1.0, 0, 0, 0]), np.pi).round(9) + 0.0
        array([0., 0., 0., 1.])
    """
    c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
    w, x, y, z = np.moveaxis(np.asarray(quat), -1, 0)
    return np.stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w], axis=-1)


def pelvis_angles_to_quaternion(angles: Float[Array, "*n 3"]) -> Float[Array, "*n 4"]:
    """Return ``wxyz`` from OpenSim's pelvis tilt, list and rotation [rad].

    OpenSim rotates the pelvis about its z (right), then x (forward), then y (up) axis; in our axes
    these are -y, x and z.
    """
    from scipy.spatial.transform import Rotation

    signed = np.asarray(angles) * np.array([-1.0, 1.0, 1.0])
    return xyzw_to_wxyz(Rotation.from_euler("YXZ", signed).as_quat())


def quaternion_to_pelvis_angles(quat: Float[Array, "n 4"]) -> Float[Array, "n 3"]:
    """Return pelvis tilt, list and rotation [rad] of ``wxyz`` quaternions, unwrapped over time."""
    from scipy.spatial.transform import Rotation

    angles = Rotation.from_quat(wxyz_to_xyzw(quat)).as_euler("YXZ")
    return np.unwrap(angles * np.array([-1.0, 1.0, 1.0]), axis=0)


def pelvis_rates_to_free_joint(
    angles: Float[Array, "n 3"], rates: Float[Array, "n 3"], accelerations: Float[Array, "n 3"]
) -> tuple[Float[Array, "n 3"], Float[Array, "n 3"]]:
    r"""Return angular velocity and its derivative in the pelvis' axes [rad/s, rad/s²].

    With tilt, list and rotation :math:`\theta` as in :func:`pelvis_angles_to_quaternion`,
    :math:`\omega = E(\theta)\,\dot\theta` and
    :math:`\dot\omega = E\,\ddot\theta + \dot E\,\dot\theta`.

    Args:
        angles: Pelvis tilt, list and rotation [rad].
        rates: Their first derivatives [rad/s].
        accelerations: Their second derivatives [rad/s²].
    """
    E, E_dot = _pelvis_rate_matrix(angles, rates)
    omega = np.einsum("nij,nj->ni", E, rates)
    alpha = np.einsum("nij,nj->ni", E, accelerations) + np.einsum("nij,nj->ni", E_dot, rates)
    return omega, alpha


def free_joint_to_pelvis_rates(
    angles: Float[Array, "n 3"], omega: Float[Array, "n 3"], alpha: Float[Array, "n 3"]
) -> tuple[Float[Array, "n 3"], Float[Array, "n 3"]]:
    """Return first and second derivatives of the pelvis angles [rad/s, rad/s²].

    The inverse of :func:`pelvis_rates_to_free_joint`.

    Args:
        angles: Pelvis tilt, list and rotation [rad].
        omega: Angular velocity in the pelvis' axes [rad/s].
        alpha: Its derivative [rad/s²].
    """
    singular = np.abs(np.cos(angles[:, 1])) < 1e-6
    if singular.any():
        raise ParameterError(
            f"the pelvis lists by 90° in frame {int(np.flatnonzero(singular)[0])}: there the rates "
            "of its tilt and rotation are not unique; use MuJoCo's velocities for such a motion"
        )
    E, _ = _pelvis_rate_matrix(angles, np.zeros_like(angles))
    rates = np.linalg.solve(E, omega[..., None])[..., 0]
    _, E_dot = _pelvis_rate_matrix(angles, rates)
    rest = alpha - np.einsum("nij,nj->ni", E_dot, rates)
    return rates, np.linalg.solve(E, rest[..., None])[..., 0]


def _pelvis_rate_matrix(
    angles: Float[Array, "n 3"], rates: Float[Array, "n 3"]
) -> tuple[Float[Array, "n 3 3"], Float[Array, "n 3 3"]]:
    """Return the axes of tilt, list and rotation as columns in the pelvis frame, and their rate."""
    _, lean, turn = angles.T
    _, lean_rate, turn_rate = rates.T
    c, s, cl, sl = np.cos(turn), np.sin(turn), np.cos(lean), np.sin(lean)
    zero, one = np.zeros_like(c), np.ones_like(c)
    E = [[-s * cl, c, zero], [-c * cl, -s, zero], [sl, zero, one]]
    E_dot = [
        [-c * cl * turn_rate + s * sl * lean_rate, -s * turn_rate, zero],
        [s * cl * turn_rate + c * sl * lean_rate, -c * turn_rate, zero],
        [cl * lean_rate, zero, zero],
    ]
    return matrices(E), matrices(E_dot)


def cross(a: Float[Array, "... 3"], b: Float[Array, "... 3"]) -> Float[Array, "... 3"]:
    """Return cross products, faster than NumPy."""
    return a.take(_AHEAD, -1) * b.take(_BEHIND, -1) - a.take(_BEHIND, -1) * b.take(_AHEAD, -1)


_AHEAD, _BEHIND = np.array([1, 2, 0]), np.array([2, 0, 1])


def unit_vectors(vectors: Float[Array, "*n k"]) -> Float[Array, "*n k"]:
    """Return vectors of length one; zero stays zero."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), MIN_LENGTH)


def nearest_right_angle(
    way: Float[Array, " 2"], direction: Float[Array, " 2"]
) -> Float[Array, " 2"]:
    """Return a direction, turned by the right angles that bring it nearest to another one."""
    left = np.array([-way[1], way[0]])
    x, y = float(way @ direction), float(left @ direction)
    return way * np.copysign(1.0, x) if abs(x) >= abs(y) else left * np.copysign(1.0, y)
