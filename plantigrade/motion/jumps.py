"""Implausible rotations of joints between frames, and wrapping of angles."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.recording import SkeletonMotion

MIN_TURN = np.deg2rad(15.0)  # minimum rotation between two frames that is reported [rad]
MIN_RATIO = 4.0  # minimum ratio to rotations a few frames before and after
NEIGHBOURS = (2, 3, 4)  # frames before and after; a spike has two rotations


@dataclass(frozen=True)
class AngleJump:
    """A sudden rotation of a joint."""

    joint: str  #: Name of the joint in the file
    time: float  #: Time of the first frame after the rotation [s]
    angle: float  #: Rotation between two frames [rad]

    def __str__(self) -> str:
        return f"{self.joint} by {np.rad2deg(self.angle):.0f}° at {self.time:.2f} s"


def jumps(skeleton: SkeletonMotion, joints: list[int]) -> list[AngleJump]:
    """Return sudden rotations of joints, largest first.

    They are relative rotations of the bones below and above a joint; full turns do not count.
    """
    found = []
    for j in joints:
        turned, above = skeleton.rotations[:, j], skeleton.parents[j]
        if above >= 0:
            turned = np.swapaxes(skeleton.rotations[:, above], 1, 2) @ turned
        angle = _angles(np.swapaxes(turned[:-1], 1, 2) @ turned[1:])
        usual = np.zeros_like(angle)
        for k in NEIGHBOURS:
            usual[:-k] = np.maximum(usual[:-k], angle[k:])
            usual[k:] = np.maximum(usual[k:], angle[:-k])
        for f in np.flatnonzero((angle > MIN_TURN) & (angle > MIN_RATIO * usual)):
            time = float(skeleton.time[f + 1])
            found.append(AngleJump(skeleton.names[j], time, float(angle[f])))
    return sorted(found, key=lambda jump: -jump.angle)


def unwrapped(angles: Float[Array, "n_frames n"]) -> Float[Array, "n_frames n"]:
    """Return angles [rad] without full turns, in steps and in their mean.

    No joint rotates by 180° between two frames, or by 360° from its rest.
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
