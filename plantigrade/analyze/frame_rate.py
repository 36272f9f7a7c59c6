r"""Whether gravity, as a motion shows it, is that of the earth: otherwise the frame rate is wrong.

Recorded :math:`s` times too slow, accelerations are :math:`s^2` times too small.

- In flight the centre of mass falls with :math:`g`. The masses of segments are known to a tenth or
  two, so the more they accelerate against each other, the less the computed centre shows it.
- In single support the body is an inverted pendulum: the acceleration that lets the centre of mass
  fall ahead of the centre of pressure is :math:`g` times their distance. With a centre of pressure
  that moves along the foot with the centre of mass, the slope of one on the other is a usual share
  of :math:`g`.
- Step length over cadence hardly depends on speed (0.006 m min in adults); over
  :math:`h^{3/2}` of the stature :math:`h` it is that of people of any size.

The pendulum and the steps err independently. Flight needs no other evidence.
"""

from itertools import pairwise

import numpy as np

from plantigrade.analyze.gait import GaitMeasures
from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.dynamics.centroid import centroid
from plantigrade.kinematics.contacts import stances
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.state import PointSet
from plantigrade.motion.event_timing import is_running
from plantigrade.motion.filters import runs
from plantigrade.spatial.conventions import unit_vectors

MAX_WALK_RATIO = 0.0105  # [m min] maximum step length over cadence of a walk
MAX_WALKING_CADENCE = 190.0  # [steps/min] maximum cadence without flight; race walkers have 200
USUAL_WALK_RATIO = 0.00259
"""Step length over stature, cadence and root of the stature [min m^-1/2]: mean of 15 walks of 8
people; its natural logarithm has a standard deviation of 0.12."""
USUAL_PENDULUM = 0.576
"""Slope of the acceleration ahead on g times the distance from the foot [1]: mean of the same
walks; half its natural logarithm has a standard deviation of 0.07."""
STEPS_WEIGHT = 0.35  # [1] weight of the steps in the estimate; the pendulum has the rest
MAX_LOG_RATE = 0.13
"""Largest natural logarithm of the ratio of frame rates without a warning [1]. Settled on 15 walks
of 8 people, who have -0.07 to 0.08; 18 walks of 11 others have -0.08 to 0.09. A frame rate 1.2
times too low adds 0.18."""
CERTAIN_LOG_RATE = 0.25  # [1] logarithm above which a run fails: five standard deviations
FALL = (8.2, 11.8)
"""Range of the acceleration in flight [m/s²]. Settled on a drop jump with 9.5; a runner at 2 and
3 m/s has 10.0 and 9.8. A frame rate 1.2 times too low gives 6.8."""
MASS_ERROR = 0.3
"""Error of the acceleration in flight by the mean acceleration of the segments against the centre
of mass [1]. A sprinter at 9.5 m/s falls with 14.0 to 15.4 m/s² while the segments accelerate with
17.5 m/s²; at 3 m/s they do with 2.3."""
FALLING = (4.0, 25.0)  # [m/s²] range of a flight in which only the clock is wrong
FLIGHT_TIME = (0.04, 1.0)  # [s] range of the duration of a flight, without its ends
MIN_FLIGHT_FRAMES = 5  # [1] minimum number of frames of a flight
FLIGHT_MARGIN = 0.01  # [s] left out at both ends of a flight
MIN_CLEARANCE = 0.03  # [m] minimum height of both soles in the flight of a jump
EDGE = 0.06  # [s] left out at both ends of the recording, where accelerations are uncertain
WALKER_HEIGHT = (0.75, 2.2)  # [m] statures of people who walk
ADULT = (1.4, 2.1)  # [m] usual statures of adults
MIN_SINGLE = 20  # [1] minimum number of frames in single support


def flight_acceleration(trial: Trial) -> tuple[float, float] | None:
    """Return the mean acceleration in flight, positive downwards, and its error [m/s²].

    The error is that of the segments' masses. None without a flight.
    """
    human, time, qpos = trial.fit.human, trial.fit.time, trial.fit.qpos
    events, spans = trial.motion.events, []
    if is_running(events):
        for first, last in pairwise(events):
            if (first.kind, last.kind) == ("toe_off", "heel_strike") and first.side != last.side:
                spans.append((first.time, last.time))
    elif not events:
        lowest = sole_paths(human, qpos).position[..., 2].min(axis=1)
        high = lowest > np.quantile(lowest, 0.1) + MIN_CLEARANCE
        inner = [run for run in runs(high) if run.start > 0 and run.stop < len(time)]
        spans = [(time[run.start], time[run.stop - 1]) for run in inner]
    centres = PointSet(human, human.body_names, human.model.body_ipos[1:])
    share = human.model.body_mass[1:] / human.mass
    found, weights = [], []
    for start, stop in spans:
        inside = (time > start + FLIGHT_MARGIN) & (time < stop - FLIGHT_MARGIN)
        seconds = stop - start - 2 * FLIGHT_MARGIN
        if inside.sum() < MIN_FLIGHT_FRAMES or not FLIGHT_TIME[0] <= seconds <= FLIGHT_TIME[1]:
            continue
        x = time[inside] - time[inside].mean()
        falls = -2.0 * np.polyfit(x, centres.path(qpos[inside])[..., 2], 2)[0]
        fall = float(share @ falls)
        found.append([fall, MASS_ERROR * float(share @ np.abs(falls - fall))])
        weights.append(((x**2 - (x**2).mean()) ** 2).sum())  # inverse of the variance
    if not found:
        return None
    fall, error = np.average(found, axis=0, weights=weights).tolist()
    return (fall, error) if FALLING[0] <= fall <= FALLING[1] else None


def walk_rate(trial: Trial) -> float | None:
    """Return the logarithm of how many times too slow a walk is, by pendulum and steps [1].

    None for another motion than a walk with markers, or where plates show it better.
    """
    measures, human = trial.measures, trial.fit.human
    strides = [s.mean for s in measures.stride_length.values() if s.count]
    measured = trial.forces is not None and bool(np.any(trial.forces.valid))
    if trial.fit.source_kind != "markers" or measured or measures.running or not strides:
        return None
    slope = _pendulum(trial)
    if slope is None or slope <= 0 or not measures.cadence.count:
        return None
    cadence, step = measures.cadence.mean, 0.5 * float(np.mean(strides))
    steps = step / (cadence * human.height**1.5) / USUAL_WALK_RATIO
    return float(
        STEPS_WEIGHT * np.log(steps) - (1 - STEPS_WEIGHT) * 0.5 * np.log(slope / USUAL_PENDULUM)
    )


def rate_doubt(trial: Trial) -> tuple[str, bool]:
    """Return why the frame rate seems wrong, and whether it certainly is; empty if it may be right.

    The sentence has no full stop.
    """
    # Joints of a skeleton file are noisier: jumps of people have 8.8 to 11.3 there.
    flight = flight_acceleration(trial) if trial.fit.source_kind == "markers" else None
    fall, error = flight or (GRAVITY, 0.0)
    if not FALL[0] - error <= fall <= FALL[1] + error:
        factor = float(np.sqrt(GRAVITY / fall))
        said = f"in flight the body falls with {fall:.1f} m/s² instead of {GRAVITY:.1f}"
        return f"{said}: {_cause(factor, trial.fit.human.height)}", True
    rate = walk_rate(trial)
    if rate is not None and abs(rate) > MAX_LOG_RATE:
        return (
            "the body falls ahead over the standing foot and steps as if gravity were "
            f"{np.exp(-2 * rate):.2f} times the earth's: "
            f"{_cause(float(np.exp(rate)), trial.fit.human.height)}",
            abs(rate) > CERTAIN_LOG_RATE,
        )
    return _steps_doubt(trial.measures), False


def _cause(factor: float, height: float) -> str:
    """Return the likely cause of a gravity that differs from the earth's.

    Args:
        factor: By how much the frame rate would be too low [1]. Lengths that are too small by its
            square show the same gravity.
        height: Stature of the fitted person [m].
    """
    adult = height * factor**2
    if not WALKER_HEIGHT[0] < height < WALKER_HEIGHT[1] and ADULT[0] < adult < ADULT[1]:
        return (
            f"lengths are probably {max(factor**2, factor**-2):.1f} times too "
            f"{'small' if factor > 1 else 'large'}, which makes a person of {height:.2f} m of one "
            f"of {adult:.2f} m: check the unit of the file; forces are wrong"
        )
    return (
        f"the frame rate of the file is probably about {max(factor, 1 / factor):.1f} times too "
        f"{'low' if factor > 1 else 'high'}; speeds, cadence and estimated forces are wrong"
    )


def _steps_doubt(measures: GaitMeasures) -> str:
    """Return a sentence where steps are too slow or too fast for their length; empty otherwise."""
    strides = [s.mean for s in measures.stride_length.values() if s.count]
    if measures.running or not strides or not measures.cadence.count:
        return ""
    cadence, step = measures.cadence.mean, 0.5 * float(np.mean(strides))
    slow = step / cadence > MAX_WALK_RATIO
    if not slow and cadence <= MAX_WALKING_CADENCE:
        return ""
    return (
        f"steps of {step:.2f} m at {cadence:.0f} steps/min are none of a walk: the frame rate of "
        f"the file is probably too {'low' if slow else 'high'}"
    )


def _pendulum(trial: Trial) -> float | None:
    """Return the slope of the acceleration ahead on g times the distance from the foot [1]."""
    human, motion, feet = trial.fit.human, trial.motion, trial.feet
    if motion.qacc is None:
        return None
    stands = _stance(trial)
    inner = (motion.time > motion.time[0] + EDGE) & (motion.time < motion.time[-1] - EDGE)
    frames = [np.flatnonzero(stands[:, k] & ~stands[:, 1 - k] & inner) for k in (0, 1)]
    if sum(map(len, frames)) < MIN_SINGLE:
        return None
    both, up = 0.0, 0.0
    for k, own in enumerate(frames):
        if len(own) < MIN_SINGLE // 2:
            continue
        body = centroid(human, motion.qpos[own], motion.qvel[own], motion.qacc[own])
        assert body.force is not None and body.moment is not None
        along = unit_vectors((feet.toe - feet.heel)[own, k, :2])
        foot = 0.7 * feet.heel[own, k] + 0.3 * feet.toe[own, k]  # below the ankle
        height = body.com[:, 2] - min(feet.heel[own, k, 2].min(), feet.toe[own, k, 2].min())
        ahead = ((body.com - foot)[:, :2] * along).sum(axis=1)
        acceleration = body.force / human.mass - [0.0, 0.0, GRAVITY]
        turning = body.moment[:, 1] * along[:, 0] - body.moment[:, 0] * along[:, 1]
        falls = height * (acceleration[:, :2] * along).sum(axis=1) + turning / human.mass
        falls -= ahead * acceleration[:, 2]
        lever = GRAVITY * (ahead - ahead.mean())
        both, up = both + float(falls @ lever), up + float(lever @ lever)
    return both / up if up > 0 else None


def _stance(trial: Trial) -> Bool[Array, "n_frames 2"]:
    """Return the frames in which each foot stands, by the gait events."""
    time: Float[Array, " n_frames"] = trial.motion.time
    stands = np.zeros((len(time), len(SIDES)), dtype=bool)
    for k, side in enumerate(SIDES):
        for stance in stances(trial.motion.events, side, float(time[0]), float(time[-1])):
            stands[(time >= stance.start) & (time <= stance.stop), k] = True
    return stands
