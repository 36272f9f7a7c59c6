"""Observations of a policy, in axes that follow the heading of the pelvis."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.reference import ReferenceInstant
from plantigrade.models import Human
from plantigrade.spatial.conventions import cross


class Observation:
    r"""The state :math:`s = [p, v, q, \omega, \psi]` of [Park2020]_, or a leaner form of it.

    The state has for every body the position of its origin relative to the pelvis (for the pelvis
    its height), velocity of the origin, orientation and angular velocity, and at last the phase.
    The axes are z up and x in the heading of the pelvis. In the form ``paper``, orientations are
    quaternions ``wxyz`` with a nonnegative scalar part, and the phase is one number from 0 to 1.

    The form ``lean`` is easier to learn: it has the first two axes of a body instead of its
    quaternion, and sine and cosine of the phase and of twice the phase. In addition to the paper it
    has the error of the centre of mass and the heading of the pelvis in the world, without which a
    policy cannot correct its path.

    Args:
        lean: Whether the form is ``lean``.
    """

    def __init__(self, human: Human, *, lean: bool):
        self.lean, self.bodies = lean, len(human.body_names)
        self.size = (15 * self.bodies + 9) if lean else (13 * self.bodies + 1)

    def __len__(self) -> int:
        return self.size

    def of(
        self, view: BatchState, reference: ReferenceInstant, phase: Float[Array, " n"]
    ) -> Float[np.ndarray, "n size"]:
        """Return the observations, one row per world."""
        n, b, turn = len(phase), self.bodies, view.headings
        spin = view.velocities[..., :3]
        parts = np.empty((n, 5 if self.lean else 3, b, 3))
        parts[:, 0] = view.positions - view.positions[:, :1]
        parts[:, 1] = view.velocities[..., 3:]
        parts[:, 1] += cross(spin, view.positions - view.com[:, None])
        parts[:, 2] = spin
        if self.lean:
            parts[:, 3], parts[:, 4] = first_axes(view.orientations)
        seen = parts.reshape(n, -1, 3) @ turn
        seen[:, 0, 2] = view.positions[:, 0, 2]
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
        out[:, 6 * b : 10 * b] = in_heading(view.orientations, turn).reshape(n, -1)
        out[:, 10 * b : 13 * b] = seen[:, 6 * b :]
        out[:, -1] = phase
        return out


def first_axes(quat: Float[Array, "*n 4"]) -> tuple[Float[Array, "*n 3"], Float[Array, "*n 3"]]:
    """Return the first two axes of bodies with orientations ``wxyz``."""
    w, x, y, z = np.moveaxis(quat, -1, 0)
    first, second = np.empty((*w.shape, 3)), np.empty((*w.shape, 3))
    first[..., 0] = 1.0 - 2.0 * (y * y + z * z)
    first[..., 1], first[..., 2] = 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
    second[..., 0], second[..., 2] = 2.0 * (x * y - w * z), 2.0 * (y * z + w * x)
    second[..., 1] = 1.0 - 2.0 * (x * x + z * z)
    return first, second


def in_heading(quat: Float[Array, "n b 4"], turn: Float[Array, "n 3 3"]) -> Float[Array, "n b 4"]:
    """Return quaternions relative to headings, with a nonnegative scalar part."""
    cosine, sine = turn[:, 0, 0], turn[:, 1, 0]
    w = np.sqrt(np.maximum(0.5 * (1.0 + cosine), 0.0))[:, None]
    z = -np.copysign(np.sqrt(np.maximum(0.5 * (1.0 - cosine), 0.0)), sine)[:, None]
    a, b, c, d = np.moveaxis(quat, -1, 0)
    seen = np.stack([w * a - z * d, w * b - z * c, w * c + z * b, w * d + z * a], axis=-1)
    return seen * np.where(seen[..., :1] < 0, -1.0, 1.0)
