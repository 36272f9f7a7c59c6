"""Joints that turn from one frame to the next as no joint does, and angles that only wrap."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.recording import SkeletonMotion

LEAST = np.deg2rad(15.0)  # of a turn between two frames that is worth a word [rad]
TIMES = 4.0  # it is so much larger than the turns a few frames before and after
AROUND = (2, 3, 4)  # frames before and after; a spike takes two turns, there and back


@dataclass(frozen=True)
class Jump:
    """A joint that turns suddenly.

    Attributes:
        joint: Name of the joint in the file.
        time: Time of the first frame after the turn [s].
        angle: How far it turned between two frames [rad].
    """

    joint: str
    time: float
    angle: float

    def __str__(self) -> str:
        """Return it for a message."""
        return f"{self.joint} by {np.rad2deg(self.angle):.0f}° at {self.time:.2f} s"


def jumps(skeleton: SkeletonMotion, joints: list[int]) -> list[Jump]:
    """Return the sudden turns of joints, the largest first.

    What turns is the bone below the joint against the one above, so a joint is not blamed for
    another. A turn by a whole circle is none: the rotation is the same.

    Args:
        skeleton: The motion.
        joints: Which of its joints to look at.
    """
    found = []
    for j in joints:
        turned, above = skeleton.rotations[:, j], skeleton.parents[j]
        if above >= 0:
            turned = np.swapaxes(skeleton.rotations[:, above], 1, 2) @ turned
        angle = _angles(np.swapaxes(turned[:-1], 1, 2) @ turned[1:])
        usual = np.zeros_like(angle)
        for k in AROUND:
            usual[:-k] = np.maximum(usual[:-k], angle[k:])
            usual[k:] = np.maximum(usual[k:], angle[:-k])
        for f in np.flatnonzero((angle > LEAST) & (angle > TIMES * usual)):
            time = float(skeleton.time[f + 1])
            found.append(Jump(skeleton.names[j], time, float(angle[f])))
    return sorted(found, key=lambda jump: -jump.angle)


def unwrapped(angles: Float[Array, "n_frames n"]) -> Float[Array, "n_frames n"]:
    """Return angles [rad] without steps by whole circles, and turned back by those they are off.

    No joint turns by half a circle between two frames, and none is a circle away from its rest.
    """
    steps = np.unwrap(np.nan_to_num(angles), axis=0) - np.nan_to_num(angles)
    smooth = angles + steps
    with np.errstate(invalid="ignore"):
        middle = np.nanmedian(smooth, axis=0) if len(smooth) else np.zeros(smooth.shape[1])
    return smooth - 2 * np.pi * np.round(np.nan_to_num(middle) / (2 * np.pi))


def _angles(rotations: Float[Array, "n 3 3"]) -> Float[Array, " n"]:
    """Return the angles of rotations [rad]."""
    cosine = (np.einsum("nii->n", rotations) - 1) / 2
    return np.arccos(np.clip(cosine, -1, 1))
