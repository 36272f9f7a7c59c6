"""What makes a fitted motion doubtful: forces it does not explain, inhuman speeds, a mirror image.

A body can follow its markers to the millimetre and still be wrong: a shoulder that passes from one
of its two equivalent triples of angles to the other turns by half a circle within a few frames.
Forces and speeds show it. And a person whose left and right are exchanged walks backward, on feet
that are pitched or far from their markers.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.analyze.feet import pitch_in_stance, progress_in_stance
from plantigrade.analyze.trial import CUTOFF, Trial
from plantigrade.charts.labels import without_side
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.dynamics.ball_joints import BallJoint
from plantigrade.dynamics.loading import RUNNING_FREQUENCY_RATIO
from plantigrade.kinematics.shoulders import arms_of
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.printable import listed

WARNING_RESIDUAL = 0.2
"""Root residual, root mean square over the frames whose forces are all measured, that is worth a
warning [BW]: fits of walks leave 0.04 to 0.07, squats 0.02."""
MAX_RESIDUAL = 0.35
"""The same that no fit may leave [BW]. A cut-off above the usual one allows more in proportion, as
it leaves more noise: runs, at 15 Hz, leave 0.16 to 0.24."""

FASTEST = {
    "arm_rot": 9000.0,
    "wrist": 4000.0,
    "elbow": 3000.0,
    "pro_sup": 3000.0,
    "fingers": 4000.0,
    "mtp": 3000.0,
    "knee_angle": 2500.0,
    "arm": 2000.0,
    "ankle_angle": 2000.0,
}
"""Fastest turning of joints, by the beginning of their names [deg/s]: above the peaks of baseball
pitching (internal rotation of the shoulder 7200, elbow 2300 [Fleisig1999]_) and of kicking (knee
1700, hip 1300 [Nunome2006]_); the other joints are slower than :data:`FASTEST_OTHER`."""
FASTEST_OTHER = 1500.0
MAX_SPEED_RATIO = 2.0
"""Speed of a joint over the fastest of people above which the fit is wrong, not merely noisy."""
MAX_BACKWARD_ERROR = 12.0
"""Largest mean marker error of a person who walks backward [mm]; above it the recording is taken to
be mirrored. People who do walk backward are fitted as well as others, to 4 to 7 mm."""
MAX_BACKWARD_PITCH = 20.0
"""Largest pitch of their feet in mid stance, where soles are flat [deg]."""


@dataclass(frozen=True)
class Doubts:
    """What makes a fitted motion doubtful.

    Attributes:
        residual: Force at the root that nothing explains, root mean square over the frames in
            which the forces on both feet are measured [BW]; None where there are none.
        fast: Joints that turn faster than people's → how many times as fast, worst first.
        noise_factor: Cut-off of motion and forces over the usual one; noise is proportional.
        mirrored: Whether left and right seem to be exchanged.
    """

    residual: float | None
    fast: dict[str, float]
    noise_factor: float = 1.0
    mirrored: bool = False

    @classmethod
    def of(cls, trial: Trial) -> "Doubts":
        """Return those of an analysed recording."""
        noise_factor = (
            RUNNING_FREQUENCY_RATIO if trial.cutoff is None else max(1.0, trial.cutoff / CUTOFF)
        )
        fast = too_fast(trial.fit.human, trial.motion)
        return cls(_residual(trial), fast, noise_factor, seems_mirrored(trial))

    @property
    def figures(self) -> dict[str, Any]:
        """``root_residual_rms_bw`` and ``joints_too_fast``."""
        figures: dict[str, Any] = {"joints_too_fast": self.fast}
        return (
            figures if self.residual is None else {"root_residual_rms_bw": self.residual} | figures
        )

    @property
    def notes(self) -> list[str]:
        """The warnings, which stand before all others."""
        notes = []
        if self.residual is not None and self.residual > self.noise_factor * WARNING_RESIDUAL:
            notes.append(
                "the measured forces and the motion do not belong together: "
                f"{100 * self.residual:.0f} % of body weight are left at the root where both feet "
                "are on plates (usual are 4 to 7 %). Something else may carry the person, plates "
                "or mass may be wrong, or a joint; do not trust the moments."
            )
        if self.fast:
            named = [
                f"{name} at {times * fastest(name):.0f}°/s" for name, times in self.fast.items()
            ]
            notes.append(
                f"joints turn faster than people's: {listed(named, 3)}. Angles of a shoulder "
                "do where the arm passes the axis they count from; else labels or samples are "
                "wrong. Moments are doubtful there."
            )
        return notes

    @property
    def refusal(self) -> str:
        """Why a run with these doubts is not ok; empty where it is."""
        if self.mirrored:
            return (
                "the person walks backward on feet that do not fit: left and right are probably "
                "exchanged. --swap-sides exchanges the names of markers, --mirror-axis turns an "
                "axis of the file"
            )
        most = self.noise_factor * MAX_RESIDUAL
        if self.residual is not None and self.residual > most:
            return (
                f"forces and motion do not belong together: {100 * self.residual:.0f} % of body "
                f"weight are left at the root where both feet are on plates, {100 * most:.0f} % "
                "are allowed"
            )
        if self.fast and (times := max(self.fast.values())) > MAX_SPEED_RATIO:
            name = max(self.fast, key=lambda one: self.fast[one])
            return f"{name} turns {times:.1f} times as fast as the fastest people's"
        return ""


def seems_mirrored(trial: Trial) -> bool:
    """Return whether a person fitted to markers walks backward on feet that do not fit."""
    human, motion = trial.fit.human, trial.motion
    if trial.fit.source_kind != "markers" or not progress_in_stance(human, motion) < 0:
        return False
    error = trial.fit.metrics.get("marker_rms_mean_mm", 0.0)
    return (
        error > MAX_BACKWARD_ERROR
        or np.rad2deg(pitch_in_stance(human, motion)) > MAX_BACKWARD_PITCH
    )


def too_fast(human: Human, motion: Motion) -> dict[str, float]:
    """Return joints that turn faster than people's → how many times as fast, worst first.

    For a shoulder, the speeds of the arm's swing and spin stand under the names of flexion and
    rotation, because its angles have no bounded speed where the arm is horizontal.
    """
    speed = np.abs(motion.qvel[:, 6:])
    for side, hinges in zip(SIDES, arms_of(human), strict=False):
        axes = BallJoint(side, hinges).axes(motion.qpos[:, 7:][:, hinges])
        spin = np.einsum("nij,nj->ni", axes, motion.qvel[:, 6:][:, hinges])
        flex, add, turn = hinges
        speed[:, flex], speed[:, turn] = np.linalg.norm(spin[:, :2], axis=1), np.abs(spin[:, 2])
        speed[:, add] = 0.0
    peak = np.rad2deg(speed.max(axis=0, initial=0.0))
    found = {
        name: float(speed / fastest(name))
        for name, speed in zip(human.coordinates, peak, strict=True)
        if speed > fastest(name)
    }
    return dict(sorted(found.items(), key=lambda one: -one[1]))


def fastest(coordinate: str) -> float:
    """Return how fast a joint can turn at most [deg/s].

    Example:
        >>> fastest("arm_rot_l"), fastest("arm_flex_r"), fastest("hip_flexion_r")
        (9000.0, 2000.0, 1500.0)
    """
    name = without_side(coordinate)
    return next(
        (speed for start, speed in FASTEST.items() if name.startswith(start)), FASTEST_OTHER
    )


def _residual(trial: Trial) -> float | None:
    """Return :attr:`Doubts.residual`; what a seat carries explains its part."""
    if trial.forces is None or trial.moments is None or not np.any(trial.forces.valid):
        return None
    left = trial.moments.residual_force
    if trial.ground is not None and trial.ground.supports:
        left = left - trial.ground.support_force.sum(axis=1)
    valid = np.asarray(trial.forces.valid)
    weight = trial.fit.human.mass * GRAVITY
    return float(np.sqrt((left[valid] ** 2).sum(axis=1).mean())) / weight
