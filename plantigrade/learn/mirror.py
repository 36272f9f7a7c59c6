"""The mirror in which the second half of a stride is the first one.

A walk that is even to both sides needs to be learned for one of them only: from the middle of the
stride on, a person sees and does everything in a mirror (the phase method of [Abdolhosseini2019]_).
"""

import mujoco
import numpy as np

from plantigrade.arrays import Float
from plantigrade.errors import ParameterError
from plantigrade.learn.action import Action
from plantigrade.learn.reference import Reference
from plantigrade.models import Human
from plantigrade.models.mirror import mirror_sign, mirrored_name

EVEN = np.deg2rad(3.0)
"""Root mean square of the hinges by which an even stride differs from its mirror image [rad]."""


class Mirror:
    """What is seen and done in the mirror, in the form ``lean``.

    Args:
        human: The person.
        action: The numbers of an action.
    """

    def __init__(self, human: Human, action: Action):
        names = list(human.body_names)
        b, swap = len(names), np.array([names.index(mirrored_name(name)) for name in names])
        data = mujoco.MjData(human.model)
        mujoco.mj_kinematics(human.model, data)
        turns = data.xmat[1 : b + 1].reshape(b, 3, 3)
        across = np.diag([1.0, -1.0, 1.0])
        # Of each body: how its own axes are turned round where the body on the other side has them.
        own = np.einsum("bji,jk,bkl->bil", turns[swap], across, turns)
        first, second = own[:, 0, 0], own[:, 1, 1]
        polar, axial = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
        signs = [np.tile(x, (b, 1)) for x in (polar, polar, axial)]
        signs += [first[:, None] * polar, second[:, None] * polar]
        last = [-1.0, -1.0, 1.0, 1.0, *polar, 1.0, -1.0]
        blocks = [3 * (b * block + swap)[:, None] + np.arange(3) for block in range(5)]
        self._seen = np.concatenate([*(x.ravel() for x in blocks), 15 * b + np.arange(9)])
        self._seen_sign = np.concatenate([*(x.ravel() for x in signs), last]).round()
        hinges = [human.coordinates[i] for i in action.displaced]
        done = [hinges.index(mirrored_name(name)) for name in hinges]
        gains = [action.joints.index(mirrored_name(name)) for name in action.joints]
        self._done = np.array([*done, *(len(done) + i for i in gains)])
        sign = [mirror_sign(name) for name in hinges]
        self._done_sign = np.array([*sign, *(1.0 for _ in gains)])

    def seen(self, seen: Float[np.ndarray, "n size"]) -> Float[np.ndarray, "n size"]:
        """Return what is seen, in the mirror and half a stride later."""
        return seen[:, self._seen] * self._seen_sign.astype(seen.dtype)

    def done(self, action: Float[np.ndarray, "n k"]) -> Float[np.ndarray, "n k"]:
        """Return actions in the mirror."""
        return action[:, self._done] * self._done_sign


def unevenness(reference: Reference) -> float:
    """Return by how much a stride differs from its mirror image, half a stride later [rad].

    It is the root mean square of the hinges; infinite for a motion that is no stride.
    """
    if not reference.cyclic:
        return float("inf")
    human = reference.human
    names = list(human.coordinates)
    other = [names.index(mirrored_name(name)) for name in names]
    sign = np.array([mirror_sign(name) for name in names])
    time = np.linspace(0.0, reference.period, 32, endpoint=False)
    now, later = (reference.at(time + lag).qpos[:, 7:] for lag in (0.0, 0.5 * reference.period))
    return float(np.sqrt(np.mean((now[:, other] * sign - later) ** 2)))


def refuse_uneven(reference: Reference) -> None:
    """Refuse a stride whose halves are no mirror images.

    Raises:
        ParameterError: If it is one.
    """
    found = unevenness(reference)
    if found > EVEN:
        raise ParameterError(
            f"mirrored=True needs a symmetric stride; the halves of this differ "
            f"by {np.rad2deg(found):.1f}° (at most {np.rad2deg(EVEN):g}°)"
        )
