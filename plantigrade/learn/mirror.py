"""Mirroring of the second half of a stride, so that a policy learns one half only.

In the second half of a symmetric walk, observations and actions are mirrored (the phase method of
[Abdolhosseini2019]_).
"""

import mujoco
import numpy as np

from plantigrade.arrays import Float, root_mean_square
from plantigrade.errors import ParameterError
from plantigrade.learn.action import Action
from plantigrade.learn.reference import ReferenceMotion
from plantigrade.models import Human
from plantigrade.models.mirror import mirror_sign, mirrored_name

MAX_ASYMMETRY = np.deg2rad(3.0)
"""Maximum RMS difference of joint angles between a symmetric stride and its mirror image [rad]."""


class Mirror:
    """Mirrors observations and actions of the form ``lean``."""

    def __init__(self, human: Human, action: Action):
        names = list(human.body_names)
        b, swap = len(names), np.array([names.index(mirrored_name(name)) for name in names])
        data = mujoco.MjData(human.model)
        mujoco.mj_kinematics(human.model, data)
        turns = data.xmat[1 : b + 1].reshape(b, 3, 3)
        across = np.diag([1.0, -1.0, 1.0])
        # For each body, the signs that relate its axes to those of the body on the other side.
        own = np.einsum("bji,jk,bkl->bil", turns[swap], across, turns)
        first, second = own[:, 0, 0], own[:, 1, 1]
        polar, axial = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
        signs = [np.tile(x, (b, 1)) for x in (polar, polar, axial)]
        signs += [first[:, None] * polar, second[:, None] * polar]
        last = [-1.0, -1.0, 1.0, 1.0, *polar, 1.0, -1.0]
        blocks = [3 * (b * block + swap)[:, None] + np.arange(3) for block in range(5)]
        self._observation_index = np.concatenate(
            [*(x.ravel() for x in blocks), 15 * b + np.arange(9)]
        )
        self._observation_sign = np.concatenate([*(x.ravel() for x in signs), last]).round()
        hinges = [human.coordinates[i] for i in action.displaced]
        done = [hinges.index(mirrored_name(name)) for name in hinges]
        gains = [action.joints.index(mirrored_name(name)) for name in action.joints]
        self._action_index = np.array([*done, *(len(done) + i for i in gains)])
        sign = [mirror_sign(name) for name in hinges]
        self._action_sign = np.array([*sign, *(1.0 for _ in gains)])

    def mirror_observation(self, seen: Float[np.ndarray, "n size"]) -> Float[np.ndarray, "n size"]:
        """Return mirrored observations."""
        return seen[:, self._observation_index] * self._observation_sign.astype(seen.dtype)

    def mirror_action(self, action: Float[np.ndarray, "n k"]) -> Float[np.ndarray, "n k"]:
        """Return mirrored actions."""
        return action[:, self._action_index] * self._action_sign


def asymmetry(reference: ReferenceMotion) -> float:
    """Return the RMS difference of joint angles between a stride and its mirror image [rad].

    The mirror image is half a stride later; the result is infinite for a motion without a stride.
    """
    if not reference.cyclic:
        return float("inf")
    human = reference.human
    names = list(human.coordinates)
    other = [names.index(mirrored_name(name)) for name in names]
    sign = np.array([mirror_sign(name) for name in names])
    time = np.linspace(0.0, reference.period, 32, endpoint=False)
    now, later = (reference.at(time + lag).qpos[:, 7:] for lag in (0.0, 0.5 * reference.period))
    return root_mean_square(now[:, other] * sign - later)


def check_symmetry(reference: ReferenceMotion) -> None:
    """Check that the halves of a stride are mirror images."""
    found = asymmetry(reference)
    if found > MAX_ASYMMETRY:
        raise ParameterError(
            f"mirrored=True needs a symmetric stride; the halves of this one differ "
            f"by {np.rad2deg(found):.1f}° (at most {np.rad2deg(MAX_ASYMMETRY):g}°)"
        )
