r"""Inverse kinematics of a leg, for all instants at once.

A hinge with axis :math:`e` through :math:`o` moves the ankle :math:`x` by :math:`e \times (x - o)`
and turns the foot by :math:`e`. Steps are those of Levenberg and Marquardt,
:math:`(J^\top J + \mu I)\, \Delta q = J^\top r`, with the distance of the ankle and the rotation
vector of the foot from their targets as residual :math:`r`.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.models import Human
from plantigrade.spatial.conventions import about_axis, rotation_matrix

LEG_COORDINATES = ("hip_flexion", "hip_adduction", "hip_rotation", "knee_angle")
FOOT_COORDINATES = ("ankle_angle", "subtalar_angle")
MIN_KNEE_FLEXION = 0.03  # [rad] minimum knee flexion
_DAMPING = 1e-5  # [1] of the least-squares step, where a straight leg is singular
_ROTATION_LENGTH = 0.25  # [m] distance equivalent to a foot rotation of one radian


@dataclass(frozen=True, eq=False)
class _Hinge:
    """A hinge of the chain."""

    index: int  #: Its place among the person's hinges
    axis: Float[Array, " 3"]  #: In the axes of its body
    moved: int  #: Its column in the Jacobian; -1 for a hinge left as it is


class Leg:
    """The chain from the pelvis to one foot.

    Attributes:
        columns: Hinges that move, as indices within :attr:`Human.coordinates`.
        limits: Their limits [rad].
        hip: Hip joint centre in the pelvis' axes [m].
        length: Thigh and shank, stretched [m].
    """

    def __init__(self, human: Human, side: str):
        model = human.model
        names = [f"{n}_{side}" for n in (*LEG_COORDINATES, *FOOT_COORDINATES)]
        self.columns: Int[Array, " 6"] = np.array([human.hinge(n) for n in names])
        self.limits = human.limits[:, self.columns].copy()
        self.limits[0, 3] = max(self.limits[0, 3], MIN_KNEE_FLEXION)
        self._bodies: list[tuple[np.ndarray, np.ndarray | None, list[_Hinge]]] = []
        body = human.body(f"foot_{side}")
        while human.body_names[body - 1] != "pelvis":
            hinges = []
            start = int(model.body_jntadr[body])
            for joint in range(start, start + int(model.body_jntnum[body])):
                index = int(model.jnt_qposadr[joint]) - 7
                place = np.flatnonzero(self.columns == index)
                moved = int(place[0]) if len(place) else -1
                hinges.append(_Hinge(index, model.jnt_axis[joint].copy(), moved))
            turn = rotation_matrix(model.body_quat[body])
            turned = None if np.allclose(turn, np.eye(3)) else turn
            self._bodies.insert(0, (model.body_pos[body].copy(), turned, hinges))
            body = int(model.body_parentid[body])
        offsets = [position for position, _, _ in self._bodies]
        self.hip = offsets[0]
        self.length = float(sum(np.linalg.norm(o) for o in offsets[1:]))

    def forward(
        self,
        pelvis: Float[Array, "n 3"],
        rotation: Float[Array, "n 3 3"],
        hinges: Float[Array, "n n_hinges"],
    ) -> tuple[Float[Array, "n 3"], Float[Array, "n 3 3"], Float[Array, "n 6 6"]]:
        """Return ankle [m], rotation of the foot, and their Jacobian with respect to the leg.

        Args:
            pelvis: Position of the pelvis, world [m].
            rotation: Rotation of the pelvis to world axes.
            hinges: All hinges of the person [rad].
        """
        x, R = pelvis, rotation
        n = len(pelvis)
        axes, origins = np.zeros((n, 6, 3)), np.zeros((n, 6, 3))
        for offset, fixed, joints in self._bodies:
            x = x + R @ offset
            R = R if fixed is None else R @ fixed
            for joint in joints:
                if joint.moved >= 0:
                    axes[:, joint.moved], origins[:, joint.moved] = R @ joint.axis, x
                R = R @ about_axis(joint.axis, hinges[:, joint.index])
        J = np.concatenate([np.cross(axes, x[:, None] - origins), axes], axis=2)
        return x, R, J.swapaxes(1, 2)

    def reach(
        self,
        pelvis: Float[Array, "n 3"],
        rotation: Float[Array, "n 3 3"],
        hinges: Float[Array, "n n_hinges"],
        ankle: Float[Array, "n 3"],
        foot: Float[Array, "n 3 3"],
        *,
        iterations: int = 25,
    ) -> Float[Array, "n n_hinges"]:
        """Return hinges that bring the foot as near to its target as the limits allow.

        Args:
            pelvis: Position of the pelvis, world [m].
            rotation: Rotation of the pelvis to world axes.
            hinges: All hinges [rad], the leg's near the answer.
            ankle: Target of the ankle, world [m].
            foot: Target of the foot's rotation to world axes.
            iterations: Steps at most.
        """
        q = hinges.copy()
        q[:, self.columns] = np.clip(q[:, self.columns], *self.limits)
        weight = np.array([1.0, 1.0, 1.0, _ROTATION_LENGTH, _ROTATION_LENGTH, _ROTATION_LENGTH])
        for _ in range(iterations):
            x, R, J = self.forward(pelvis, rotation, q)
            r = np.concatenate([ankle - x, _rotvec(foot @ R.swapaxes(1, 2))], axis=1) * weight
            if np.abs(r).max() < 1e-7:
                break
            J = J * weight[:, None]
            A = J.swapaxes(1, 2) @ J + _DAMPING * np.eye(6)
            step = np.linalg.solve(A, J.swapaxes(1, 2) @ r[..., None])[..., 0]
            step *= np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
            q[:, self.columns] = np.clip(q[:, self.columns] + step, *self.limits)
        return q


def _rotvec(R: Float[Array, "n 3 3"]) -> Float[Array, "n 3"]:
    """Return rotation vectors of matrices, for turns below 180° [rad]."""
    axial = np.stack(
        [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1
    )
    sine = np.linalg.norm(axial, axis=1) / 2
    angle = np.arctan2(sine, (np.trace(R, axis1=1, axis2=2) - 1) / 2)
    factor = np.where(sine > 1e-9, angle / np.maximum(2 * sine, 1e-12), 0.5)
    return factor[:, None] * axial
