"""Plausibility of a fit: residual forces, joint speeds, exchanged sides.

A fit can follow its markers to the millimetre and still be wrong. For instance a shoulder that
changes between its two equivalent triples of angles turns by 180° within a few frames. Forces and
joint speeds show this. A person whose left and right are exchanged walks backward, on feet that are
pitched or far from their markers.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.analyze.feet import pitch_in_stance, progress_in_stance
from plantigrade.analyze.force_agreement import (
    force_disagreement,
    mass_doubt,
    offset_note,
    plate_clock_doubt,
    support_note,
    weak_note,
)
from plantigrade.analyze.frame_rate import rate_doubt
from plantigrade.analyze.standing_feet import sway_doubt
from plantigrade.analyze.trial import CUTOFF, Trial
from plantigrade.constants import SIDES
from plantigrade.data_files import named_numbers
from plantigrade.dynamics.ball_joints import BallJoint
from plantigrade.dynamics.loading import RUNNING_FREQUENCY_RATIO
from plantigrade.kinematics.shoulders import arms_of
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.printable import listed
from plantigrade.side_names import without_side

WARNING_RESIDUAL = 0.1
"""RMS root residual over the frames with measured forces on both feet, above which a warning is
given [BW]; fits of walks have 0.04 to 0.07, of squats 0.02. It is scaled as :data:`MAX_RESIDUAL`; a
walk with the sideways forces of a plate reversed has 0.11."""
MAX_RESIDUAL = 0.35
"""RMS root residual above which a fit fails [BW]. It is scaled with the cut-off over the usual one,
because the noise is; runs, at 15 Hz, have 0.16 to 0.24."""

MAX_JOINT_SPEEDS = named_numbers("plantigrade.analyze", "joint_speeds.csv")
"""Maximum joint speeds by prefix of the coordinate [deg/s], above the peaks of baseball pitching
(internal rotation of the shoulder 7200, elbow 2300 [Fleisig1999]_) and of kicking (knee 1700, hip
1300 [Nunome2006]_)."""
MAX_OTHER_SPEED = 1500.0  # [deg/s] of all other joints
MAX_SPEED_RATIO = 2.0
"""Ratio of a joint speed to its maximum above which the fit is wrong, not merely noisy."""
MAX_BACKWARD_ERROR = 12.0
"""Mean marker error above which a person who walks backward is taken for a mirrored recording [mm];
fits of people who do walk backward have 4 to 7 mm, as others."""
MAX_BACKWARD_PITCH = 20.0
"""Pitch of the feet in midstance above which it is taken for mirrored, too [deg]; soles are flat
there."""


@dataclass(frozen=True)
class Plausibility:
    """Plausibility of a fitted motion."""

    #: RMS residual force at the root over the frames with measured forces on both feet [BW]; None
    #: if there are none
    residual: float | None
    fast: dict[str, float]  #: Joints above their maximum speed → ratio to it, largest first
    #: Cut-off of motion and forces over the usual one; the noise is proportional
    noise_factor: float = 1.0
    mirrored: bool = False  #: Whether left and right seem to be exchanged
    disagreement: str = ""  #: Why measured forces are not those of the motion
    doubts: tuple[str, ...] = ()  #: Warnings on the plates and the direction of the walk

    @classmethod
    def of(cls, trial: Trial) -> "Plausibility":
        """Return the plausibility of an analysed recording."""
        noise_factor = (
            RUNNING_FREQUENCY_RATIO if trial.cutoff is None else max(1.0, trial.cutoff / CUTOFF)
        )
        fast = fast_joints(trial.fit.human, trial.motion)
        mirrored = seems_mirrored(trial)
        doubts = [
            offset_note(trial),
            weak_note(trial),
            support_note(trial),
            plate_clock_doubt(trial),
            sway_doubt(trial),
        ]
        doubts += [] if mirrored else [backward_note(trial)]
        disagreement, odd_mass = "" if fast else force_disagreement(trial), mass_doubt(trial)
        rate, certain = rate_doubt(trial)
        if rate and (disagreement or not certain):
            doubts.append(f"{rate}.")
        elif rate:
            disagreement = rate
        if odd_mass and (trial.fit.metrics.get("height_estimated") or disagreement):
            doubts.append(f"{odd_mass}.")  # the stature may be what is wrong
        elif odd_mass:
            disagreement = odd_mass
        return cls(
            _residual(trial),
            fast,
            noise_factor,
            mirrored,
            disagreement,
            tuple(doubt for doubt in doubts if doubt),
        )

    @property
    def figures(self) -> dict[str, Any]:
        """``root_residual_rms_bw`` and ``joints_too_fast``."""
        figures: dict[str, Any] = {"joints_too_fast": self.fast}
        return (
            figures if self.residual is None else {"root_residual_rms_bw": self.residual} | figures
        )

    @property
    def notes(self) -> list[str]:
        """Warnings, to be listed before all others."""
        notes: list[str] = []
        if self.residual is not None and self.residual > self.noise_factor * WARNING_RESIDUAL:
            notes.append(
                "the measured forces do not match the motion: the residual at the root is "
                f"{100 * self.residual:.0f} % of body weight where both feet are on plates "
                "(usually 4 to 7 %). Another support may carry the person, or plates, body mass "
                "or a joint may be wrong; do not trust the moments."
            )
        if self.disagreement:
            notes.append(f"{self.disagreement}; do not trust the moments.")
        notes += self.doubts
        if self.fast:
            named = [
                f"{name} at {times * max_joint_speed(name):.0f}°/s"
                for name, times in self.fast.items()
            ]
            notes.append(
                f"joints move faster than humanly possible: {listed(named, 3)}. At a shoulder the "
                "cause may be a singularity of its angles, else wrong labels or samples. Moments "
                "are doubtful there."
            )
        return notes

    @property
    def failure(self) -> str:
        """Reason why the run is not ok; empty if it is."""
        if self.mirrored:
            return (
                "the person walks backward on feet that do not fit: left and right are probably "
                "exchanged. --swap-sides exchanges the names of markers, --mirror-axis turns an "
                "axis of the file"
            )
        if self.disagreement:
            return self.disagreement
        most = self.noise_factor * MAX_RESIDUAL
        if self.residual is not None and self.residual > most:
            return (
                "forces and motion do not match: the residual at the root is "
                f"{100 * self.residual:.0f} % of body weight where both feet are on plates; at "
                f"most {100 * most:.0f} % are allowed"
            )
        if self.fast and (times := max(self.fast.values())) > MAX_SPEED_RATIO:
            name = max(self.fast, key=lambda one: self.fast[one])
            return f"{name} moves at {times:.1f} times the maximum speed of people"
        return ""


def seems_mirrored(trial: Trial) -> bool:
    """Return whether a person walks backward on feet that do not fit their markers."""
    human, motion = trial.fit.human, trial.motion
    if trial.fit.source_kind != "markers" or not progress_in_stance(human, motion) < 0:
        return False
    error = trial.fit.metrics.get("marker_rms_mean_mm", 0.0)
    return (
        error > MAX_BACKWARD_ERROR
        or np.rad2deg(pitch_in_stance(human, motion)) > MAX_BACKWARD_PITCH
    )


def backward_note(trial: Trial) -> str:
    """Return a warning where a person with markers walks backward; empty otherwise."""
    if (
        trial.fit.source_kind != "markers"
        or not progress_in_stance(trial.fit.human, trial.motion) < 0
    ):
        return ""
    return (
        "the person walks backward; if this is wrong, the frames are in reverse order, or left and "
        "right are exchanged."
    )


def fast_joints(human: Human, motion: Motion) -> dict[str, float]:
    """Return joints above their maximum speed → ratio to it, largest first.

    For a shoulder the speeds of the arm's swing and spin are used instead of those of flexion and
    rotation, which are unbounded at a singularity of its angles.
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
        name: float(speed / max_joint_speed(name))
        for name, speed in zip(human.coordinates, peak, strict=True)
        if speed > max_joint_speed(name)
    }
    return dict(sorted(found.items(), key=lambda one: -one[1]))


def max_joint_speed(coordinate: str) -> float:
    """Return the maximum speed of a joint [deg/s].

    Example:
        >>> max_joint_speed("arm_rot_l"), max_joint_speed("arm_flex_r")
        (9000.0, 2000.0)
    """
    name = without_side(coordinate)
    return next(
        (speed for start, speed in MAX_JOINT_SPEEDS.items() if name.startswith(start)),
        MAX_OTHER_SPEED,
    )


def _residual(trial: Trial) -> float | None:
    """Return :attr:`Plausibility.residual`; what a seat carries explains its part."""
    if trial.forces is None or trial.moments is None or not np.any(trial.forces.valid):
        return None
    left = trial.moments.residual_force
    if trial.ground is not None and trial.ground.supports:
        left = left - trial.ground.support_force.sum(axis=1)
    valid = np.asarray(trial.forces.valid)
    weight = trial.fit.human.mass * trial.fit.human.gravity
    return float(np.sqrt((left[valid] ** 2).sum(axis=1).mean())) / weight
