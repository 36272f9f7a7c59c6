"""Whether feet that stand rest in the laboratory: otherwise it moves, or its cameras do.

A rigid motion of all markers leaves no error in a fit. What shows it is the ball of the foot, which
has the velocity of the ground from foot flat until the heel has risen [Perry1992]_, and all the
time in people who stand, squat, or rise from a chair.
"""

from collections.abc import Iterator

import numpy as np

from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.kinematics.contacts import stances
from plantigrade.models.markers import landmarks_of
from plantigrade.motion.filters import runs

BALL = ("metatarsal_1_head", "metatarsal_2_head", "metatarsal_5_head", "toe_medial", "toe_lateral")
PARTS_OF_STANCE = ((0.25, 0.55), (0.3, 0.7))
"""Parts of the stance in which the ball rests [1]; it must move in both, since toddlers raise the
heel early and slow walkers lower the toes late."""
MIN_STANCE = 0.2  # [s] minimum duration of a whole stance
MIN_FRAMES = 6  # [1] minimum number of frames in which the ball rests
MIN_STANCES = 2  # [1] minimum number of stances
MAX_RISE = 0.01  # [m] height above its lowest at which the ball of a person who does not step rests
EDGE = 0.1  # [s] left out at both ends of such a rest
WINDOW_DURATION = 0.3  # [s] of the parts in which a foot is compared, as long as those of a stance
BELT_SPEED = 0.2  # [m/s] speed of the standing feet above which the ground is a belt
MAX_VELOCITY = 0.033
"""Largest root mean square of the horizontal velocity of standing feet [m/s]. Settled on 27
recordings of 9 people with up to 0.023, but for one with a single stance that slides; 30 of 15
others have up to 0.030. A laboratory that sways by 3 cm at 0.3 Hz has 0.036 to 0.06."""
MAX_MEDIAN = 0.025  # [m/s] largest median: one stance that slides moves no laboratory


def standing_velocities(trial: Trial, part: tuple[float, float]) -> Float[Array, "n_stances 2"]:
    """Return horizontal velocities of the balls of standing feet over the ground [m/s].

    Those on a treadmill are relative to its belt.

    Args:
        trial: An analysed recording; files without markers of the ball give none.
        part: Beginning and end of the part of each whole stance, as shares of its duration [1].
    """
    markers, time = trial.fit.markers, trial.motion.time
    velocities: list[Float[Array, " 2"]] = []
    for side in SIDES if markers is not None else ():
        assert markers is not None
        known = landmarks_of(markers.names)
        own = [markers.index(known[f"{m}_{side}"]) for m in BALL if f"{m}_{side}" in known]
        if not own:
            continue
        ball = markers.positions[:, own].mean(axis=1)
        seen = np.isfinite(ball[:, 0])
        for begin, end in _rests(trial, side, ball[:, 2], part):
            rests = (time >= begin) & (time <= end) & seen
            if rests.sum() >= MIN_FRAMES:
                velocities.append(np.polyfit(time[rests], ball[rests, :2], 1)[0])
    if len(velocities) < MIN_STANCES:
        return np.empty((0, 2))
    found = np.array(velocities)
    belt = np.median(found, axis=0)
    return found - belt if np.linalg.norm(belt) > BELT_SPEED else found


def sway_doubt(trial: Trial) -> str:
    """Return a sentence where feet that stand move; empty otherwise."""
    speeds = [np.linalg.norm(standing_velocities(trial, part), axis=1) for part in PARTS_OF_STANCE]
    if not all(map(len, speeds)):
        return ""
    least = min(root_mean_square(speed) for speed in speeds)
    if least <= MAX_VELOCITY or max(map(np.median, speeds)) <= MAX_MEDIAN:
        return ""
    return (
        f"feet that stand move at {1e3 * least:.0f} mm/s (usually below 25 mm/s): the laboratory "
        "or its cameras sway, or the feet slide; speeds, estimated forces and the place of the "
        "feet on the plates are wrong by as much."
    )


def _rests(
    trial: Trial, side: str, height: Float[Array, " n_frames"], part: tuple[float, float]
) -> Iterator[tuple[float, float]]:
    """Return begin and end of times in which the ball of a foot rests [s]."""
    time = trial.motion.time
    first, last = float(time[0]), float(time[-1])
    for stance in stances(trial.motion.events, side, first, last):
        length = stance.stop - stance.start
        if stance.start > first and stance.stop < last and length >= MIN_STANCE:
            yield stance.start + part[0] * length, stance.start + part[1] * length
    if trial.motion.events or not np.isfinite(height).any():
        return
    for run in runs(height < np.nanmin(height) + MAX_RISE):
        begin, end = float(time[run.start]) + EDGE, float(time[run.stop - 1]) - EDGE
        for k in range(int((end - begin) / WINDOW_DURATION)):
            yield begin + k * WINDOW_DURATION, begin + (k + 1) * WINDOW_DURATION
