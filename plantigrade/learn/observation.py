"""Observations of a policy, in axes that turn with the heading of the pelvis."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.learn.reference import Frame
from plantigrade.learn.view import View
from plantigrade.models import Human


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
        self.lean, self.bodies = lean, len(human.body_names)
        self.size = (15 * self.bodies + 9) if lean else (13 * self.bodies + 1)

    def __len__(self) -> int:
        """Return the number of numbers."""
        return self.size

    def of(
        self, view: View, reference: Frame, phase: Float[Array, " n"]
    ) -> Float[np.ndarray, "n size"]:
        """Return what is seen in every world of a view that is up to date.

        Args:
            view: The persons.
            reference: Where they should be.
            phase: Part of the stride that has passed.
        """
        n, b, turn = len(phase), self.bodies, view.turn
        spin = view.motion[..., :3]
        parts = np.empty((n, 5 if self.lean else 3, b, 3))
        parts[:, 0] = view.place - view.place[:, :1]
        parts[:, 1] = view.motion[..., 3:]
        parts[:, 1] += cross(spin, view.place - view.com[:, None])
        parts[:, 2] = spin
        if self.lean:
            parts[:, 3], parts[:, 4] = first_axes(view.turned)
        seen = parts.reshape(n, -1, 3) @ turn
        seen[:, 0, 2] = view.place[:, 0, 2]
        seen = seen.reshape(n, -1)
        out = np.empty((n, self.size), dtype=np.float32)
        if self.lean:
            out[:, : 15 * b] = seen
            angle = 2.0 * np.pi * phase
            last = out[:, 15 * b :]
            last[:, 0], last[:, 1] = np.cos(angle), np.sin(angle)
            last[:, 2], last[:, 3] = np.cos(2 * angle), np.sin(2 * angle)
            last[:, 4:7] = ((view.com - reference.com)[:, None] @ turn)[:, 0]
            last[:, 7], last[:, 8] = turn[:, 0, 0], turn[:, 1, 0]
            return out
        out[:, : 6 * b] = seen[:, : 6 * b]
        out[:, 6 * b : 10 * b] = unturned(view.turned, turn).reshape(n, -1)
        out[:, 10 * b : 13 * b] = seen[:, 6 * b :]
        out[:, -1] = phase
        return out


def cross(a: Float[Array, "*n 3"], b: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
    """Return cross products, faster than NumPy's for a few rows."""
    return a.take(_AHEAD, -1) * b.take(_BEHIND, -1) - a.take(_BEHIND, -1) * b.take(_AHEAD, -1)


_AHEAD, _BEHIND = np.array([1, 2, 0]), np.array([2, 0, 1])


def first_axes(quat: Float[Array, "*n 4"]) -> tuple[Float[Array, "*n 3"], Float[Array, "*n 3"]]:
    """Return where the first two axes of bodies point, of quaternions ``wxyz``."""
    w, x, y, z = np.moveaxis(quat, -1, 0)
    first, second = np.empty((*w.shape, 3)), np.empty((*w.shape, 3))
    first[..., 0] = 1.0 - 2.0 * (y * y + z * z)
    first[..., 1], first[..., 2] = 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    second[..., 0], second[..., 2] = 2.0 * (x * y - w * z), 2.0 * (y * z + w * x)
    second[..., 1] = 1.0 - 2.0 * (x * x + z * z)
    return first, second


def unturned(quat: Float[Array, "n b 4"], turn: Float[Array, "n 3 3"]) -> Float[Array, "n b 4"]:
    """Return quaternions as seen from headings, scalar part not negative."""
    cosine, sine = turn[:, 0, 0], turn[:, 1, 0]
    w = np.sqrt(np.maximum(0.5 * (1.0 + cosine), 0.0))[:, None]
    z = -np.copysign(np.sqrt(np.maximum(0.5 * (1.0 - cosine), 0.0)), sine)[:, None]
    a, b, c, d = np.moveaxis(quat, -1, 0)
    seen = np.stack([w * a - z * d, w * b - z * c, w * c + z * b, w * d + z * a], axis=-1)
    return seen * np.where(seen[..., :1] < 0, -1.0, 1.0)
