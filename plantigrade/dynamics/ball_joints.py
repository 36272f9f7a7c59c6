r"""Shoulders near the singularity of their angles, treated as rotations.

With the arm abducted to the horizontal, flexion and rotation change by up to 180° within a few
frames although the arm hardly moves, and filtering these angles would distort the motion. The
shoulder is then filtered and differentiated as a quaternion, like the root, and its angles
:math:`q` follow from rotation :math:`R(q)`, angular velocity and acceleration in the frame of the
upper arm,

.. math:: \omega = u_1 \dot q_1 + u_2 \dot q_2 + u_3 \dot q_3, \quad
    \dot\omega = U \ddot q + (\dot q_2\, u_1 \times u_2 + \dot q_3\, u_1 \times u_3) \dot q_1
    + \dot q_3\, u_2 \times u_3\, \dot q_2,

with :math:`u_i` the axes of the three turns in that frame.
"""

import warnings

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.shoulders import ARM, arms_of, equivalent_angles
from plantigrade.models import Human
from plantigrade.models.coordinates import coordinate_of
from plantigrade.spatial.conventions import continuous, wxyz_to_xyzw, xyzw_to_wxyz

MIN_ABDUCTION_SINE = np.sin(np.deg2rad(60.0))
"""Sine of the abduction above which a shoulder is treated as one rotation."""
SINGULAR_COSINE = 1e-6
"""Cosine of the abduction below which a rotation does not determine the angles."""
INVERSE_DAMPING = 0.01
"""Damping of the inverse of the axes [1]; rates stay finite within 0.6° of the singularity."""


class BallJoint:
    """A shoulder whose three hinges are treated as one rotation.

    Args:
        side: ``"r"`` or ``"l"``.
        hinges: Its hinges: flexion, adduction, rotation.
    """

    def __init__(self, side: str, hinges: list[int]):
        self.hinges = hinges
        axes = [coordinate_of(f"{name}_{side}").axis_of(side) for name in ARM]
        self._sign = np.array([axis.sum() for axis in axes])  # along y, x, z, either way

    def quaternions(self, angles: Float[Array, "n 3"]) -> Float[Array, "n 4"]:
        """Return the rotations of the upper arm, ``wxyz``, with continuous sign."""
        from scipy.spatial.transform import Rotation

        return continuous(xyzw_to_wxyz(Rotation.from_euler("YXZ", angles * self._sign).as_quat()))

    def between(self, one: Float[Array, "n 3"], two: Float[Array, "n 3"]) -> Float[Array, "n 3"]:
        """Return the rotation vectors from some angles to others, in the upper arm [rad]."""
        from scipy.spatial.transform import Rotation

        there, here = (
            Rotation.from_quat(wxyz_to_xyzw(self.quaternions(angles))) for angles in (one, two)
        )
        return (there.inv() * here).as_rotvec()

    def angles(self, quat: Float[Array, "n 4"], near: Float[Array, "n 3"]) -> Float[Array, "n 3"]:
        """Return the angles of rotations nearest to given angles [rad]."""
        from scipy.spatial.transform import Rotation

        with warnings.catch_warnings():  # exactly singular frames keep the given angles
            warnings.simplefilter("ignore", UserWarning)
            one = self._sign * Rotation.from_quat(wxyz_to_xyzw(quat)).as_euler("YXZ")
        locked = np.abs(np.cos(one[:, 1])) < SINGULAR_COSINE
        one[locked] = near[locked]
        result = []
        for triple in (one, equivalent_angles(one)):
            result.append(triple - 2 * np.pi * np.round((triple - near) / (2 * np.pi)))
        distance = [np.linalg.norm(triple - near, axis=1) for triple in result]
        return np.where((distance[0] <= distance[1])[:, None], *result)

    def axes(self, angles: Float[Array, "n 3"]) -> Float[Array, "n 3 3"]:
        """Return the axes of the three turns in the frame of the upper arm, as columns."""
        from scipy.spatial.transform import Rotation

        third = Rotation.from_euler("Z", angles[:, 2:] * self._sign[2]).inv()
        second = Rotation.from_euler("X", angles[:, 1:2] * self._sign[1]).inv()
        y, x, z = np.eye(3)[[1, 0, 2]] * self._sign[:, None]
        u1 = third.apply(second.apply(y))
        u2 = third.apply(np.tile(x, (len(angles), 1)))
        u3 = np.tile(z, (len(angles), 1))
        return np.stack([u1, u2, u3], axis=2)

    def rates(
        self,
        angles: Float[Array, "n 3"],
        velocity: Float[Array, "n 3"],
        acceleration: Float[Array, "n 3"],
    ) -> tuple[Float[Array, "n 3"], Float[Array, "n 3"]]:
        """Return velocities and accelerations of the angles [rad/s, rad/s²].

        Args:
            angles: The angles [rad].
            velocity: Angular velocity in the frame of the upper arm [rad/s].
            acceleration: Angular acceleration in it [rad/s²].
        """
        axes = self.axes(angles)
        u1, u2, u3 = np.moveaxis(axes, 2, 0)
        across = np.swapaxes(axes, 1, 2)
        inverse = across @ np.linalg.inv(axes @ across + INVERSE_DAMPING**2 * np.eye(3))
        rate = np.einsum("nij,nj->ni", inverse, velocity)
        a, b, c = rate.T[..., None]
        turned = (b * np.cross(u1, u2) + c * np.cross(u1, u3)) * a + c * np.cross(u2, u3) * b
        return rate, np.einsum("nij,nj->ni", inverse, acceleration - turned)


def ball_joints(human: Human, qpos: Float[Array, "n_frames nq"]) -> list[BallJoint]:
    """Return the shoulders near the singularity of their angles in a motion."""
    return [
        BallJoint(side, hinges)
        for side, hinges in zip(SIDES, arms_of(human), strict=False)
        if np.abs(np.sin(qpos[:, 7 + hinges[1]])).max(initial=0.0) > MIN_ABDUCTION_SINE
    ]
