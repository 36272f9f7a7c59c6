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
from plantigrade.dynamics.loading import FASTER
from plantigrade.kinematics.shoulders import arms_of
from plantigrade.models import Human
from plantigrade.motion import Motion

DOUBTFUL_RESIDUAL = 0.2
"""Root residual, root mean square over the frames whose forces are all measured, that is worth a
warning [BW]: fits of walks leave 0.04 to 0.07, squats 0.02."""
MOST_RESIDUAL = 0.35
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
1700, hip 1300 [Nunome2006]_); the other joints are slower than :data:`FAST`."""
FAST = 1500.0
MUCH_FASTER = 2.0
"""A joint that is so many times as fast is a fault of the fit, not of its noise."""
BACKWARD_ERROR = 12.0
"""Mean marker error of somebody who seems to walk backward, above which the recording is taken to
be mirrored [mm]: people who do walk backward are fitted as well as others, to 4 to 7 mm."""
BACKWARD_PITCH = 20.0
"""The same of the pitch of their feet in the middle of stance, where soles are flat [deg]."""
LISTED = 3  # joints that a note names


@dataclass(frozen=True)
class Doubts:
    """What makes a fitted motion doubtful.

    Attributes:
        residual: Force at the root that nothing explains, root mean square over the frames in
            which the forces on both feet are measured [BW]; None where there are none.
        fast: Joints that turn faster than people's → how many times as fast, worst first.
        keen: Cut-off of motion and forces over the usual one: noise grows with it.
        mirrored: Whether left and right seem to be exchanged.
    """

    residual: float | None
    fast: dict[str, float]
    keen: float = 1.0
    mirrored: bool = False

    @classmethod
    def of(cls, trial: Trial) -> "Doubts":
        """Return those of an analysed recording."""
        keen = FASTER if trial.cutoff is None else max(1.0, trial.cutoff / CUTOFF)
        fast = too_fast(trial.fit.human, trial.motion)
        return cls(_residual(trial), fast, keen, seems_mirrored(trial))

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
        if self.residual is not None and self.residual > self.keen * DOUBTFUL_RESIDUAL:
            notes.append(
                "the measured forces and the motion do not belong together: "
                f"{100 * self.residual:.0f} % of body weight are left at the root where both feet "
                "are on plates (usual are 4 to 7 %). Something else may carry the person, plates "
                "or mass may be wrong, or a joint; do not trust the moments."
            )
        if self.fast:
            named = [
                f"{name} at {times * fastest(name):.0f}°/s"
                for name, times in list(self.fast.items())[:LISTED]
            ]
            more = f" and {len(self.fast) - LISTED} more" if len(self.fast) > LISTED else ""
            notes.append(
                f"joints turn faster than people's: {', '.join(named)}{more}. Angles of a shoulder "
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
        most = self.keen * MOST_RESIDUAL
        if self.residual is not None and self.residual > most:
            return (
                f"forces and motion do not belong together: {100 * self.residual:.0f} % of body "
                f"weight are left at the root where both feet are on plates, {100 * most:.0f} % "
                "are allowed"
            )
        if self.fast and (times := max(self.fast.values())) > MUCH_FASTER:
            name = max(self.fast, key=lambda one: self.fast[one])
            return f"{name} turns {times:.1f} times as fast as the fastest people's"
        return ""


def seems_mirrored(trial: Trial) -> bool:
    """Return whether a person fitted to markers walks backward as nobody does who really does."""
    human, motion = trial.fit.human, trial.motion
    if trial.fit.source_kind != "markers" or not progress_in_stance(human, motion) < 0:
        return False
    error = trial.fit.metrics.get("marker_rms_mean_mm", 0.0)
    return error > BACKWARD_ERROR or np.rad2deg(pitch_in_stance(human, motion)) > BACKWARD_PITCH


def too_fast(human: Human, motion: Motion) -> dict[str, float]:
    """Return joints that turn faster than people's → how many times as fast, worst first.

    Of a shoulder it is the arm's own swing and spin, under the names of flexion and rotation: its
    angles may turn as fast as they like where the arm is horizontal.
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
    return next((speed for start, speed in FASTEST.items() if name.startswith(start)), FAST)


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
