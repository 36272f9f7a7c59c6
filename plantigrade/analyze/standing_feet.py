"""Whether feet that stand rest in the laboratory: otherwise it moves, or its cameras do.

A rigid motion of all markers leaves no error in a fit. What shows it is the ball of the foot, which
has the velocity of the ground from foot flat until the heel has risen [Perry2010]_.
"""

import numpy as np

from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.contacts import stances
from plantigrade.models.markers import landmarks_of

BALL = ("metatarsal_1_head", "metatarsal_2_head", "metatarsal_5_head")
PARTS_OF_STANCE = ((0.25, 0.55), (0.3, 0.7))
"""Parts of the stance in which the ball rests [1]; it must move in both, since toddlers raise the
heel early and slow walkers lower the toes late."""
MIN_STANCE = 0.4  # [s] minimum duration of a whole stance; runs have less
MIN_FRAMES = 6  # [1] minimum number of frames in which the ball rests
MIN_STANCES = 2  # [1] minimum number of stances
BELT_SPEED = 0.2  # [m/s] speed of the standing feet above which the ground is a belt
MAX_VELOCITY = 0.033
"""Largest root mean square of the horizontal velocity of standing feet [m/s]. Settled on 17 walks
of 8 people with up to 0.023, but for one with a single stance that slides; 15 walks of 10 others
have up to 0.030. A laboratory that sways by 3 cm at 0.3 Hz has 0.037 to 0.039."""
MAX_MEDIAN = 0.025  # [m/s] largest median: one stance that slides moves no laboratory


def standing_velocities(trial: Trial, part: tuple[float, float]) -> Float[Array, "n_stances 2"]:
    """Return horizontal velocities of the balls of standing feet over the ground [m/s].

    Those on a treadmill are relative to its belt.

    Args:
        trial: A walk; other motions and files without markers of the ball give none.
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
        ball = markers.positions[:, own, :2].mean(axis=1)
        for stance in stances(trial.motion.events, side, float(time[0]), float(time[-1])):
            length = stance.stop - stance.start
            if stance.start <= time[0] or stance.stop >= time[-1] or length < MIN_STANCE:
                continue
            begin, end = (stance.start + share * length for share in part)
            rests = (time >= begin) & (time <= end) & np.isfinite(ball[:, 0])
            if rests.sum() >= MIN_FRAMES:
                velocities.append(np.polyfit(time[rests], ball[rests], 1)[0])
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
    least = min(float(np.sqrt((speed**2).mean())) for speed in speeds)
    if least <= MAX_VELOCITY or max(map(np.median, speeds)) <= MAX_MEDIAN:
        return ""
    return (
        f"feet that stand move at {1e3 * least:.0f} mm/s (usually below 25 mm/s): the laboratory "
        "or its cameras sway, or the feet slide; speeds, estimated forces and the place of the "
        "feet on the plates are wrong by as much."
    )
