"""What a policy sees of the person, in axes that turn with the pelvis over the ground."""

from math import cos, pi, sin

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.learn.reference import Frame, heading_of
from plantigrade.models import Human
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
        human: The person.
        lean: Which form.
    """

    def __init__(self, human: Human, *, lean: bool):
        self.lean, self.n = lean, len(human.body_names)
        each = 15 if lean else 13
        self.size = each * self.n + (9 if lean else 1)
        self._turned = np.zeros((5 if lean else 3, self.n, 3))

    def __len__(self) -> int:
        """Return the number of numbers."""
        return self.size

    def of(self, world: World, reference: Frame, phase: float) -> Float[np.ndarray, " n"]:
        """Return what is seen of a world whose kinematics are up to date."""
        data, n, turned = world.data, self.n, self._turned
        own = slice(1, n + 1)
        place, velocity = data.xpos[own], data.cvel[own]
        spin = velocity[:, :3]
        c, s = heading_of(data.qpos[3:7])
        turned[0] = place - place[0]
        turned[1] = velocity[:, 3:] + cross(spin, place - data.subtree_com[1])
        turned[2] = spin
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        out = np.empty(self.size, dtype=np.float32)
        if self.lean:
            axes = data.xmat[own].reshape(n, 3, 3)
            turned[3], turned[4] = axes[:, :, 0], axes[:, :, 1]
        seen = turned.reshape(-1, 3) @ turn
        seen[0, 2] = place[0, 2]
        if self.lean:
            out[: 15 * n] = seen.ravel()
            angle = 2.0 * pi * phase
            off = (data.subtree_com[1] - reference.com) @ turn
            more = (cos(angle), sin(angle), cos(2 * angle), sin(2 * angle))
            out[15 * n :] = (*more, *off.tolist(), c, s)
            return out
        out[: 6 * n] = seen[: 2 * n].ravel()
        out[6 * n : 10 * n] = unturned(data.xquat[own], c, s).ravel()
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
