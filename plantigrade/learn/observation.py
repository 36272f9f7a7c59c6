"""What a policy sees of the person, in axes that turn with the pelvis over the ground."""

from math import cos, pi, sin

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.learn.reference import Frame, Heading
from plantigrade.world import World


class Observation:
    r"""The state :math:`s = [p, v, q, \omega, \psi]` of [Park2020]_, or the study's form of it.

    Of every body in turn: place of its origin from that of the pelvis (of the pelvis itself: its
    height), velocity of the origin, orientation, angular velocity; last the phase. All are seen in
    axes whose z is up and whose x is where the pelvis faces. As printed, orientations are
    quaternions ``wxyz`` with a scalar part that is not negative, and the phase is one number from
    0 to 1.

    The other form, ``lean``, has what a network learns more easily: the first two axes of a body
    for its quaternion, sine and cosine of the phase and of twice the phase; and, which the paper
    lacks, how far the centre of mass is off that of the reference and where the pelvis faces in the
    world. Without these a policy cannot know that it leaves the line.

    Args:
        world: Whose person is seen.
        lean: Which form.
    """

    def __init__(self, world: World, *, lean: bool):
        data, n = world.data, len(world.human.body_names)
        self.lean, self.n = lean, n
        self.size = (15 * n + 9) if lean else (13 * n + 1)
        # Arrays of MuJoCo stay where they are; making views of them takes longer than reading them.
        own = slice(1, n + 1)
        self._place, self._spin, self._speed = (
            data.xpos[own],
            data.cvel[own, :3],
            data.cvel[own, 3:],
        )
        self._quat, axes = data.xquat[own], data.xmat[own].reshape(n, 3, 3)
        self._axes = axes.transpose(2, 0, 1)[:2]
        self._com = data.subtree_com[1]
        self._seen = np.zeros((5 if lean else 3, n, 3))

    def __len__(self) -> int:
        """Return the number of numbers."""
        return self.size

    def of(self, turn: Heading, reference: Frame, phase: float) -> Float[np.ndarray, " n"]:
        """Return what is seen; the kinematics of the world must be up to date.

        Args:
            turn: Where the pelvis faces.
            reference: Where the person should be.
            phase: Part of the stride that has passed.
        """
        n, all_seen, place, spin = self.n, self._seen, self._place, self._spin
        np.subtract(place, place[0], out=all_seen[0])
        np.add(self._speed, cross(spin, place - self._com), out=all_seen[1])
        all_seen[2] = spin
        if self.lean:
            all_seen[3:] = self._axes
        seen = all_seen.reshape(-1, 3) @ turn.matrix
        seen[0, 2] = place[0, 2]
        out = np.empty(self.size, dtype=np.float32)
        if self.lean:
            out[: 15 * n] = seen.ravel()
            angle = 2.0 * pi * phase
            off = (self._com - reference.com) @ turn.matrix
            more = (cos(angle), sin(angle), cos(2 * angle), sin(2 * angle))
            out[15 * n :] = (*more, *off.tolist(), turn.cosine, turn.sine)
            return out
        out[: 6 * n] = seen[: 2 * n].ravel()
        out[6 * n : 10 * n] = unturned(self._quat, turn.cosine, turn.sine).ravel()
        out[10 * n : 13 * n] = seen[2 * n :].ravel()
        out[-1] = phase
        return out


def cross(a: Float[Array, "n 3"], b: Float[Array, "n 3"]) -> Float[Array, "n 3"]:
    """Return cross products, faster than NumPy's for a few rows."""
    return a.take(_AHEAD, 1) * b.take(_BEHIND, 1) - a.take(_BEHIND, 1) * b.take(_AHEAD, 1)


_AHEAD, _BEHIND = np.array([1, 2, 0]), np.array([2, 0, 1])


def unturned(quat: Float[Array, "n 4"], cosine: float, sine: float) -> Float[Array, "n 4"]:
    """Return quaternions as seen from a heading, scalar part not negative."""
    half_c = max(0.5 * (1.0 + cosine), 0.0) ** 0.5
    half_s = max(0.5 * (1.0 - cosine), 0.0) ** 0.5 * (1.0 if sine >= 0 else -1.0)
    w, z = half_c, -half_s  # of the turn back, from the left
    left = np.array([[w, 0, 0, -z], [0, w, -z, 0], [0, z, w, 0], [z, 0, 0, w]])
    seen = quat @ left.T
    return seen * np.where(seen[:, :1] < 0, -1.0, 1.0)
