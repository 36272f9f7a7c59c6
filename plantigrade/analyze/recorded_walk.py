"""From an analysed recording to a walk that can be reproduced, or the reason why it cannot.

Events that a jerk has blurred are put in order, a single cycle is repeated; recordings in which
there is no walking, or no level ground, are refused.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plantigrade.analyze.feet import FootPath, foot_path
from plantigrade.analyze.gait import gait_measures
from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.errors import ReproduceError
from plantigrade.kinematics.contacts import stances
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.cycles import cut_cycles
from plantigrade.motion.events import detect_gait_events
from plantigrade.motion.recording import even_clock, rate_of
from plantigrade.notes import Info
from plantigrade.ordered_tasks.cycle_repetition import find_loop, repeat_cycle
from plantigrade.ordered_tasks.gait_reference import GaitReference, reference_of
from plantigrade.ordered_tasks.phases import ordered_events, walking_events
from plantigrade.record import Record
from plantigrade.spatial.conventions import continuous_poses

MAX_HEIGHT_DIFFERENCE = 0.06  #: Of feet that stand on level ground [m]
MIN_EVENTS = 3  #: Gait events in sequence that make two phases, the least that can be rebuilt
CUTOFF = 6.0
"""Low-pass of a repeated cycle [Hz]."""


@dataclass(frozen=True)
class RecordedWalk:
    """A recorded walk to be reproduced."""

    name: str  #: Name of the file
    human: Human  #: The person
    motion: Motion  #: The motion, filtered, with its gait events in order
    feet: FootPath  #: Paths of the feet
    figures: dict[str, Any]  #: Figures of fit and gait
    notes: tuple[str, ...]  #: What the user should know
    #: The fitted recording where forces were measured, on the frames of the motion
    measured: Record | None = None

    @classmethod
    def of(cls, trial: Trial) -> "RecordedWalk":
        """Return the walk of an analysed recording, blurred double supports put in order."""
        events, blurred = ordered_events(trial.motion.events)
        notes = trial.record().notes
        if blurred:
            notes += (
                f"in {blurred} of the steps one foot seems to leave before the other lands, as in "
                "running; the other steps are walking, so both events were set midway.",
            )
        return cls(
            trial.fit.recording.source.name,
            trial.fit.human,
            replace(trial.motion, events=events),
            trial.feet,
            trial.figures,
            notes,
            trial.measured,
        )

    @property
    def ground(self) -> Float[Array, "n_frames 3"]:
        """Path of the ground, the belt of a treadmill [m]; at rest overground."""
        return moving_ground(self.motion.time, self.feet.heel, self.feet.toe)

    def over_ground(self) -> Motion:
        """Return the motion over ground that rests."""
        motion = self.motion
        qpos = continuous_poses(motion.qpos)
        qpos[:, :3] -= self.ground
        time = even_clock(motion.time)
        smooth = differentiate(self.human, time, qpos, None)
        return replace(motion, time=time, qpos=qpos, qvel=smooth.qvel, qacc=smooth.qacc)

    def reference(self) -> GaitReference:
        """Return what the tasks see of it: on ground that rests.

        Raises:
            ReproduceError: If it shows no walking.
        """
        motion = self.motion
        return reference_of(self.human, motion.time, motion.qpos, motion.events, ground=self.ground)

    def repeated(self, trial: Trial) -> "RecordedWalk":
        """Return the walk, repeated where it is one cycle that shows no whole stride of a foot.

        The posture is repeated as it was fitted, then filtered.
        """
        if cut_cycles(walking_events(self.motion.events)):
            return self
        human, fitted = self.human, trial.fit
        loop = find_loop(human, fitted.time, fitted.qpos)
        if loop is None:
            return self
        time, qpos = repeat_cycle(human, fitted.time, fitted.qpos, loop)
        rate = rate_of(time)
        smooth = differentiate(human, time, qpos, CUTOFF if CUTOFF < 0.45 * rate else None)
        feet = foot_path(human, qpos)
        events, _ = ordered_events(detect_gait_events(time, feet.heel, feet.toe, feet.pelvis))
        motion = Motion(time, smooth.qpos, smooth.qvel, human.joint_names, smooth.qacc, events)
        what = "half a cycle" if loop.mirrored else "one cycle"
        closes = "its mirror image" if loop.mirrored else "itself"
        note = Info(
            f"the recording is {what} of {loop.period:.2f} s that closes on {closes}; it was "
            "repeated to three cycles, in which gait events were detected."
        )
        figures = {
            **self.figures,
            "frames": motion.n_frames,
            "duration_s": motion.duration,
            **gait_measures(time, feet.heel, feet.toe, events).metrics(),
        }
        return RecordedWalk(self.name, human, motion, feet, figures, (*self.notes, note))

    def refuse_standing(self) -> None:
        """Raise a ReproduceError where there is no walking, with what was seen instead."""
        events = self.motion.events
        if len(walking_events(events)) >= MIN_EVENTS:
            return
        seen = "it shows no walking"
        if len(events) > MIN_EVENTS:
            seen = (
                f"its {len(events)} heel strikes and toe offs are not in the order of walking, "
                "where one heel lands before the other foot leaves (is it running or hopping?)"
            )
        raise ReproduceError(
            f"{self.name}: {seen}; give a recording with at least two steps of walking"
        )

    def refuse_uneven(self) -> None:
        """Raise a ReproduceError where feet stand at different heights: stairs, a slope."""
        motion = self.motion
        soles = sole_paths(self.human, motion.qpos)
        heights = []
        for side in SIDES:
            low = soles.lowest(side)
            for stance in stances(motion.events, side, motion.time[0], motion.time[-1]):
                start, stop = stance.start, stance.stop
                quarter = (stop - start) / 4
                middle = (motion.time > start + quarter) & (motion.time < stop - quarter)
                if stance.whole and middle.any():
                    heights.append(float(np.quantile(low[middle], 0.1)))  # of a hop: where it lands
        if heights and max(heights) - min(heights) > MAX_HEIGHT_DIFFERENCE:
            raise ReproduceError(
                f"{self.name}: the ground is not level, the feet stand "
                f"{100 * (max(heights) - min(heights)):.0f} cm higher at one step than at another "
                "(stairs or uneven ground); the tasks need a level floor"
            )


def walk_to_reproduce(trial: Trial) -> RecordedWalk:
    """Return the walk of an analysed recording, checked, and repeated if it is a single cycle.

    Raises:
        ReproduceError: If it shows no walking, or uneven ground.
    """
    walk = RecordedWalk.of(trial).repeated(trial)
    walk.refuse_standing()
    walk.refuse_uneven()
    return walk
