"""From an analysed recording to a walk that can be rebuilt, or the reason why there is none.

Events that a jerk has blurred are put in order, a single cycle is repeated; recordings in which
nobody walks, or not on level ground, are refused.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.errors import ReproduceError

if TYPE_CHECKING:
    from plantigrade.analyze.trial import Trial
    from plantigrade.reproduce.reference import Reference

UNEVEN = 0.06  # feet that stand at heights further apart are not on level ground [m]
ENOUGH = 3  # gait events that follow one another make two phases, the least that can be rebuilt


def events_in_order(trial: "Trial") -> "Trial":
    """Return the recording with blurred double supports put in order, and say so."""
    from plantigrade.reproduce.phases import in_order

    events, blurred = in_order(trial.record.motion.events)
    if not blurred:
        return trial
    note = (
        f"at {blurred} of the steps a foot seems to leave before the other comes down, as in "
        "running; the others show a walk, so both events were put at their middle."
    )
    record = trial.record
    return replace(
        trial,
        record=replace(
            record,
            motion=replace(record.motion, events=events),
            warnings=(*record.warnings, note),
        ),
    )


def refuse_standing(trial: "Trial") -> None:
    """Raise where nobody walks in a recording.

    Raises:
        ReproduceError: In one sentence that says what was seen instead.
    """
    from plantigrade.reproduce.phases import walking_events

    events = trial.record.motion.events
    if len(walking_events(events)) >= ENOUGH:
        return
    seen = "nobody is seen to walk in it"
    if len(events) > ENOUGH:
        seen = (
            f"its {len(events)} heel strikes and toe offs do not follow one another as in walking, "
            "where one heel comes down before the other foot leaves (it may be running or hopping)"
        )
    raise ReproduceError(
        f"{trial.fit.recording.source.name}: {seen}; give a recording in which somebody walks two "
        "steps or more"
    )


def refuse_uneven(trial: "Trial") -> None:
    """Raise where feet stand at different heights: stairs, a slope, uneven ground.

    Raises:
        ReproduceError: With the difference of the heights.
    """
    from plantigrade.kinematics.contacts import stances
    from plantigrade.kinematics.sole_paths import sole_paths

    motion = trial.record.motion
    soles = sole_paths(trial.fit.human, motion.qpos)
    heights = []
    for side in ("r", "l"):
        low = soles.position[:, soles.of(side), 2].min(axis=1)
        for start, stop, whole in stances(motion.events, side, motion.time[0], motion.time[-1]):
            quarter = (stop - start) / 4
            middle = (motion.time > start + quarter) & (motion.time < stop - quarter)
            if whole and middle.any():
                heights.append(float(np.quantile(low[middle], 0.1)))  # of a hop: where it lands
    if heights and max(heights) - min(heights) > UNEVEN:
        raise ReproduceError(
            f"{trial.fit.recording.source.name}: the ground is not level, the feet stand "
            f"{100 * (max(heights) - min(heights)):.0f} cm higher at one step than at another "
            "(stairs or uneven ground); the tasks know a level floor: give a walk on level ground"
        )


def reference_of_trial(trial: "Trial") -> "Reference":
    """Return what the tasks see of an analysed recording: on ground that rests.

    Raises:
        ReproduceError: If nobody walks in it.
    """
    from plantigrade.kinematics.ground_level import moving_ground
    from plantigrade.reproduce.reference import reference_of

    motion = trial.record.motion
    return reference_of(
        trial.fit.human,
        motion.time,
        motion.qpos,
        motion.events,
        ground=moving_ground(trial.fit.time, trial.feet.heel, trial.feet.toe),
    )


def whole_cycles(trial: "Trial") -> "Trial":
    """Return the recording, repeated where it is one cycle that shows no whole stride of a foot."""
    from plantigrade.analyze.trial import analyse as analyse_trial
    from plantigrade.motion.cycles import cut_cycles
    from plantigrade.reproduce.phases import in_order, walking_events
    from plantigrade.reproduce.unroll import find_loop, unroll

    events, _ = in_order(trial.record.motion.events)
    if cut_cycles(walking_events(events)):
        return trial
    fitted = trial.fit
    loop = find_loop(fitted.human, fitted.time, fitted.qpos)
    if loop is None:
        return trial
    time, qpos = unroll(fitted.human, fitted.time, fitted.qpos, loop)
    repeated = replace(
        fitted,
        time=time,
        qpos=qpos,
        recording=replace(fitted.recording, plates=()),
        markers=None,
        residual=None,
        kept=None,
        warnings=(
            *fitted.warnings,
            f"the recording is {'half a' if loop.mirrored else 'one'} cycle of {loop.period:.2f} s "
            f"that closes on {'its mirror image' if loop.mirrored else 'itself'}; it was repeated "
            "to three cycles, and the gait was found in the repetition.",
        ),
    )
    return analyse_trial(repeated, mass=fitted.human.mass)
