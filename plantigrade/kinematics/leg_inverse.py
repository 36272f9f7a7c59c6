r"""Analytic inverse kinematics of the legs: hip, knee and ankle angles in closed form.

From the hip the ankle is at :math:`k + R_a(\theta) t` in the axes of the thigh, with the knee at
:math:`k`, its axis :math:`a` and the shank :math:`t`, so that how far it is from there gives the
knee by the law of cosines,

.. math:: d^2 = k^2 + t^2 + 2 k \cdot R_a(\theta) t
    = k^2 + t^2 + 2 (c_0 + c_1 \cos\theta + s_1 \sin\theta) .

The hip then turns this vector to where the ankle is to be. About that line the leg could swivel:
the axis of the knee is carried there from the recorded posture by the shortest rotation, so that
the recorded position gives the recorded angles. Ankle and subtalar joint take the foot's
vertical to where it is to be (the second of the subproblems of [MurrayLiSastry1994]_); what is
left, its heading, is the rotation of the ankle where the model has one, and missed where not.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.models import Human
from plantigrade.spatial.conventions import (
    about_axis,
    axes_along,
    rotation_matrix,
    within_half_turn,
)

HIP = ("hip_flexion", "hip_adduction", "hip_rotation")
KNEE = ("knee_angle", "knee_adduction", "knee_rotation")
ANKLE = ("ankle_angle", "subtalar_angle", "ankle_rotation")
_UP = np.array([0.0, 0.0, 1.0])


class LegInverse:
    """Analytic inverse kinematics of both legs of a person."""

    def __init__(self, human: Human):
        self.human = human
        self._legs = [_Leg(human, side) for side in SIDES]

    def reach(
        self,
        qpos: Float[Array, "n_frames nq"],
        ankle: Float[Array, "n_frames 2 3"],
        foot: Float[Array, "n_frames 2 3 3"],
    ) -> Float[Array, "n_frames nq"]:
        """Return postures with the same pelvis, trunk and arms whose feet are elsewhere.

        A foot out of reach is put on the line to it, at the end of the straight leg (or of the leg
        bent as far as it goes). Ranges of joints are not considered.

        Args:
            qpos: Postures; those of the legs say how they swivel, and on which side of straight
                the knee is.
            ankle: Where the origin of the foot is to be, right and left, world [m].
            foot: Rotation of the foot, its axes as columns.
        """
        out = np.array(qpos, dtype=float)
        pelvis = rotation_matrix(out[:, 3:7])
        for i, leg in enumerate(self._legs):
            to = np.einsum("nji,nj->ni", pelvis, ankle[:, i] - out[:, :3])
            turn = pelvis.transpose(0, 2, 1) @ foot[:, i]
            out[:, 7 + leg.hinges] = leg.angles(out[:, 7:], to, turn)
        return out


class _Leg:
    """The geometry of one leg, from the model."""

    def __init__(self, human: Human, side: str):
        model, names = human.model, human.coordinates
        self.hip, self.knee, self.ankle = (
            [names.index(f"{n}_{side}") for n in joint if f"{n}_{side}" in names]
            for joint in (HIP, KNEE, ANKLE)
        )
        self.hinges = np.array([*self.hip, self.knee[0], *self.ankle])
        self.axis = np.array(model.jnt_axis[1:])
        self.signs = self.axis[self.hip].sum(axis=1)  # about y, x and z, to one side or the other
        at = [model.body_pos[human.body(f"{b}_{side}")].copy() for b in ("femur", "tibia", "foot")]
        self.hip_place, self.thigh, self.shank = at

    def angles(self, q: Array, ankle: Array, foot: Array) -> Array:
        """Return angles that lead to a foot in the axes of the pelvis."""
        axis, k = self.axis, self.thigh
        to = ankle - self.hip_place
        far = np.sqrt((to * to).sum(axis=1))
        line = to / np.maximum(far, 1e-9)[:, None]
        beyond = np.broadcast_to(np.eye(3), (len(q), 3, 3))  # knees that do more than bend
        for i in self.knee[1:]:
            beyond = beyond @ about_axis(axis[i], q[:, i])
        shank = beyond @ self.shank
        # The knee, by the law of cosines.
        a = axis[self.knee[0]]
        fixed = (k @ a) * (shank @ a)
        along, across = shank @ k - fixed, np.cross(a, shank) @ k
        size, middle = np.hypot(along, across), np.arctan2(across, along)
        half_excess = 0.5 * (far**2 - k @ k - (shank * shank).sum(axis=1))
        cosine = np.clip((half_excess - fixed) / size, -1.0, 1.0)
        recorded = q[:, self.knee[0]]
        side = np.where(recorded < middle, -1.0, 1.0)
        knee = middle + side * np.arccos(cosine)
        leg = k + np.einsum("nij,nj->ni", about_axis(a, knee), shank)
        # The hip: along the line, with the axis of the knee carried there from the recording.
        before = self._hip_turn(q[:, self.hip])
        straight = k + np.einsum("nij,nj->ni", about_axis(a, recorded), shank)
        old = np.einsum("nij,nj->ni", before, straight)
        carried = _shortest(old, line) @ (before @ a)[:, :, None]
        hip = axes_along(line, carried[:, :, 0]) @ axes_along(leg, a).transpose(0, 2, 1)
        # The ankle takes what is left.
        tibia = hip @ about_axis(a, knee) @ beyond
        left = tibia.transpose(0, 2, 1) @ foot
        ankles = self._ankle_angles(left, q[:, self.ankle])
        return np.concatenate([self._hip_angles(hip), knee[:, None], ankles], axis=1)

    def _hip_turn(self, q: Array) -> Array:
        one, two, three = (about_axis(self.axis[i], x) for i, x in zip(self.hip, q.T, strict=True))
        return one @ two @ three

    def _hip_angles(self, R: Array) -> Array:
        """Return the angles of a rotation about y, x and z."""
        y = np.arctan2(R[:, 0, 2], R[:, 2, 2])
        x = np.arctan2(-R[:, 1, 2], np.hypot(R[:, 1, 0], R[:, 1, 1]))
        z = np.arctan2(R[:, 1, 0], R[:, 1, 1])
        return np.stack([y, x, z], axis=1) * self.signs

    def _ankle_angles(self, R: Array, recorded: Array) -> Array:
        """Return the angles of a turn of the foot in the shank [rad]."""
        one, two = self.axis[self.ankle[0]], self.axis[self.ankle[1]]
        up, slant = R @ _UP, float(one @ two)
        normal = np.cross(one, two)
        p, q = float(two @ _UP), up @ one
        a, b = (q - slant * p) / (1 - slant**2), (p - slant * q) / (1 - slant**2)
        rest = 1.0 - a * a - b * b - 2 * a * b * slant
        out = np.sqrt(np.maximum(rest, 0.0) / (normal @ normal))
        flat = a[:, None] * one + b[:, None] * two
        found = []
        for way in (1.0, -1.0):
            between = flat + (way * out)[:, None] * normal
            second = _angle(two, np.broadcast_to(_UP, between.shape), between)
            found.append(np.stack([_angle(one, between, up), second], axis=1))
        off = [np.abs(within_half_turn(each - recorded[:, :2])).sum(axis=1) for each in found]
        angles = np.where((off[0] <= off[1])[:, None], found[0], found[1])
        if len(self.ankle) > 2:
            turn = about_axis(one, angles[:, 0]) @ about_axis(two, angles[:, 1])
            left = turn.transpose(0, 2, 1) @ R
            last = np.arctan2(left[:, 1, 0], left[:, 0, 0]) * self.axis[self.ankle[2]].sum()
            angles = np.concatenate([angles, last[:, None]], axis=1)
        return angles


def _shortest(one: Array, other: Array) -> Float[Array, "n 3 3"]:
    """Return the shortest rotations that take one direction to another."""
    u = one / np.sqrt((one * one).sum(axis=1, keepdims=True))
    v, c = np.cross(u, other), (u * other).sum(axis=1)
    K = np.zeros((len(u), 3, 3))
    K[:, (2, 0, 1), (1, 2, 0)], K[:, (1, 2, 0), (2, 0, 1)] = v, -v
    return np.eye(3) + K + K @ K / np.maximum(1.0 + c, 1e-9)[:, None, None]


def _angle(axis: Array, one: Array, other: Array) -> Float[Array, " n"]:
    """Return the angle about an axis from one vector to another."""
    across = np.cross(one, other) @ axis
    return np.arctan2(across, (one * other).sum(axis=1) - (one @ axis) * (other @ axis))
