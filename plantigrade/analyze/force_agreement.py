r"""Whether measured forces of a gait are those of its motion: sign, axes, unit, place and clock.

The net ground reaction equals :math:`m (a - g)` of the centre of mass. Over the frames with
measured forces on both feet, the slope of the regression of measured on required force is 1 in
each direction: 0.8 to 1.2 in recordings of walking, 0.5 to 0.7 fore-aft in running, whose
accelerations are filtered. It is negative for a reversed axis, near zero for exchanged axes, and
the square of the ratio of the clocks for a wrong frame rate, upward and fore-aft alike. In single
support the slope shows a fault of one plate; sideways the force changes too little there. What a
foot that stands alone carries less than the motion requires, something else carries. Friction under
a foot limits the free moment.

A constant offset of the centre of pressure appears as one of the centre of mass
(:func:`plantigrade.dynamics.inverse.com_metrics`).
"""

import numpy as np

from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDE_NAMES, SIDES
from plantigrade.dynamics.inverse import com_metrics
from plantigrade.dynamics.plate_clock import MAX_CLOCK_RATE, clock_rate
from plantigrade.models.stature import usual_mass
from plantigrade.motion.event_timing import is_running
from plantigrade.spatial.conventions import rotation_matrix

MIN_SLOPE = 0.35  # [1] least slope of forces that belong to the motion
MAX_SLOPE = 2.2  # [1] greatest slope of forces that belong to the motion
MIN_VARIATION = {"fore-aft": 0.012, "sideways": 0.025, "vertical": 0.02}
"""Minimum standard deviation of the required force, for a slope [BW]; half the frame rate leaves a
quarter of it, and walkers have 0.06, 0.03 and 0.12."""
MIN_FRAMES = 20  # [1] minimum number of frames for a slope
MIN_TIME = 0.3  # [s] and their minimum duration; less is a part of a stance
MIN_SINGLE_LOAD = 0.3  # [BW] minimum load of the foot that stands alone …
MAX_OTHER_LOAD = 0.02  # [BW] … and maximum load of the other one
USUAL_SLOPE = 0.95  # [1] geometric mean of the vertical and the fore-aft slope in walking
MEAN_SLOPES = (0.77, 1.17)
"""Range of this mean in walking with a right frame rate [1]. Settled on 10 walks of 8 people, who
have 0.86 to 1.02; 15 walks of 10 others have 0.87 to 1.09. A frame rate 1.2 times too low
multiplies it by 1.44."""
EACH_SLOPE = (0.90, 1.07)  # [1] each of both slopes is beyond this where the clock is wrong
MIN_CLOCK_TIME = 0.5  # [s] minimum duration of such frames; shorter ones have 0.73 to 0.95
MAX_MISSING = 0.075
"""Largest share of the weight that a foot alone carries less than the motion requires, or than the
other does [1]. Settled on 10 walks of 8 people, who have up to 0.053; 15 of 10 others have up to
0.04, but one, whose plates weigh 9 % less than the file states."""
MASS_RATIOS = (0.6, 1.9)
"""Range of the body mass by plates over the usual one at the stature [1]: body mass indices of 13
and 42 kg/m² in adults, below and above which are fewer than one in a thousand. 36 recordings of 21
people have 0.71 to 1.17."""
MAX_FREE_MOMENT = 0.1
"""Largest free moment of a foot over its load, 99 of 100 frames [m]: friction of 1 at the ends of a
sole of 0.2 m; walkers have 0.01."""
MIN_PEAK = 20.0  # [N] peak of a force plate on which a person stood; noise is 1 to 5
MAX_OFFSET = 35.0
"""Largest offset of the centre of mass by the forces [mm]; recordings of gait have up to 20, of
squats 25."""


def force_disagreement(trial: Trial) -> str:
    """Return the reason why measured forces are not those of a gait; empty if they may be."""
    if trial.forces is None or trial.moments is None or not trial.motion.events:
        return ""
    forces, weight = trial.forces, trial.fit.human.mass * GRAVITY
    measured = forces.force.sum(axis=1)
    required = (measured + trial.moments.residual_force) / weight
    load = forces.force[..., 2] / weight
    valid = np.asarray(forces.valid)
    alone = (load > MIN_SINGLE_LOAD) & (load[:, ::-1] < MAX_OTHER_LOAD) & valid[:, None]
    stands = load > MIN_SINGLE_LOAD
    twist = np.abs(forces.torque[..., 2][stands]) / (load[stands] * weight)
    if len(twist) and (most := float(np.percentile(twist, 99))) > MAX_FREE_MOMENT:
        return (
            f"the free moment reaches {1e2 * most:.0f} cm times the load, more than friction under "
            f"a foot can hold ({1e2 * MAX_FREE_MOMENT:.0f} cm): the unit of moments is wrong"
        )
    least = max(MIN_FRAMES, MIN_TIME * trial.motion.rate)
    frames = {"": valid} | {
        f" under the {SIDE_NAMES[side]} foot": alone[:, k] for k, side in enumerate(SIDES)
    }
    frames = {where: part for where, part in frames.items() if part.sum() >= least}
    if "" not in frames:
        return ""
    way = rotation_matrix(trial.motion.qpos[valid, 3:7])[:, :2, 0].mean(axis=0)
    way /= np.linalg.norm(way)
    axes = {"fore-aft": np.array([*way, 0.0]), "vertical": np.array([0.0, 0.0, 1.0])}
    if not is_running(trial.motion.events):
        axes["sideways"] = np.array([-way[1], way[0], 0.0])
    slopes = {
        (name, where): slope
        for where, part in frames.items()
        for name, axis in axes.items()
        if not (name == "sideways" and where)
        and (slope := _slope(required[part] @ axis, measured[part] @ axis / weight, name))
        is not None
    }
    if "sideways" in axes and valid.sum() / trial.motion.rate >= MIN_CLOCK_TIME:
        # A scale of forces multiplies slopes and mean alike, a wrong clock the slopes alone.
        scale = float(measured[valid, 2].sum() / (required[valid, 2].sum() * weight))
        rate = _wrong_rate(
            *(s and s / scale for s in (slopes.get((n, "")) for n in ("vertical", "fore-aft")))
        )
        if rate and not plate_clock_doubt(trial):  # forces that drift away change less, too
            return rate
    wrong = {key: s for key, s in slopes.items() if not MIN_SLOPE <= s <= MAX_SLOPE}
    return _disagreement(wrong) if wrong else ""


def support_note(trial: Trial) -> str:
    """Return a warning where something besides the feet carries a walker; empty otherwise."""
    if trial.forces is None or trial.moments is None or not trial.motion.events:
        return ""
    forces, weight = trial.forces, trial.fit.human.mass * GRAVITY
    missing = trial.moments.residual_force[:, 2]
    load = forces.force[..., 2]
    alone = (load > MIN_SINGLE_LOAD * weight) & (load[:, ::-1] < MAX_OTHER_LOAD * weight)
    alone &= np.asarray(forces.valid)[:, None]
    less = {}
    for k, side in enumerate(SIDES):
        if alone[:, k].sum() / trial.motion.rate >= MIN_TIME:
            needed = (load[:, k] + missing)[alone[:, k]].sum()
            less[SIDE_NAMES[side]] = float(missing[alone[:, k]].sum() / needed)
    if is_running(trial.motion.events) or not less:
        return ""
    foot = max(less, key=lambda side: less[side])
    # Where the plates weighed the person, feet that carry less make the other one carry more.
    share = less[foot] - (min(less.values()) if len(less) > 1 else 0.0)
    if max(share, less[foot]) <= MAX_MISSING:
        return ""
    return (
        f"the {foot} foot, standing alone, carries {100 * max(share, less[foot]):.0f} % of the "
        "weight less than the motion requires: something else carries the person there (a cane, "
        "a rail, a hand), the plate reads too little, or the body mass is another; forces and "
        "moments that are estimated are wrong by as much."
    )


def plate_clock_doubt(trial: Trial) -> str:
    """Return a warning where the clock of the plates runs at another rate; empty otherwise."""
    if trial.forces is None or trial.moments is None or not trial.motion.events:
        return ""
    needed = (trial.forces.force.sum(axis=1) + trial.moments.residual_force)[:, 2]
    carried, plates = np.asarray(trial.forces.valid), trial.fit.recording.plates
    rate = clock_rate(plates, trial.motion.time, needed, carried, trial.cutoff)
    if rate is None or abs(rate) <= MAX_CLOCK_RATE:
        return ""
    return (
        f"the clock of the force plates runs {100 * abs(rate):.1f} % "
        f"{'slower' if rate > 0 else 'faster'} than that of the motion, so that both drift apart: "
        "the rate of the plates in the file is probably wrong; correct it and do not trust the "
        "joint moments."
    )


def mass_doubt(trial: Trial) -> str:
    """Return why the body mass by the plates is hardly that of a person; empty if it may be."""
    if trial.weighed is None or trial.fit.human.mass != trial.weighed.mass:
        return ""
    human, age = trial.fit.human, trial.fit.recording.subject.age
    usual = usual_mass(human.height, age)[0]
    ratio = trial.weighed.mass / usual
    if MASS_RATIOS[0] <= ratio <= MASS_RATIOS[1]:
        return ""
    return (
        f"the force plates weigh the person {trial.weighed.mass:.1f} kg, {ratio:.2f} times the "
        f"{usual:.0f} kg usual at a stature of {human.height:.2f} m: the scale of the forces is "
        "probably wrong, such as halved or doubled; if the mass is right, set it with --mass"
    )


def offset_note(trial: Trial) -> str:
    """Return a warning where the plates seem to lie elsewhere; empty otherwise."""
    if trial.forces is None or trial.moments is None or not trial.motion.events:
        return ""
    for name, off in com_metrics(trial.moments, trial.forces, trial.motion.qpos).items():
        if abs(off) > MAX_OFFSET:
            behind, ahead = {"com_ahead_mm": ("behind", "ahead of")}.get(
                name, ("to the right of", "to the left of")
            )
            return (
                f"the measured forces act {abs(off):.0f} mm {behind if off > 0 else ahead} where "
                "the motion needs them: the position of the plates, the centre of pressure or the "
                "vertical moments may be wrong; do not trust the joint moments."
            )
    return ""


def weak_note(trial: Trial) -> str:
    """Return a warning where plates were hit, but by no person; empty otherwise."""
    peaks = [float(np.nanmax(np.abs(p.force), initial=0.0)) for p in trial.fit.recording.plates]
    if trial.withheld is not None or not 0 < max(peaks, default=0.0) < MIN_PEAK:
        return ""
    return (
        f"the force plates measured {max(peaks):.2g} N at most, which no step makes; the unit of "
        "forces is probably another, and nothing of them was used."
    )


def _slope(required: Float[Array, " n"], measured: Float[Array, " n"], name: str) -> float | None:
    """Return the slope of the regression of measured on required force; None if unknown."""
    if required.std() < MIN_VARIATION[name]:
        return None
    return float(np.cov(required, measured)[0, 1] / required.var(ddof=1))


def _wrong_rate(vertical: float | None, forward: float | None) -> str:
    """Return the sentence on a wrong frame rate, by slopes upward and fore-aft over the scale."""
    if vertical is None or forward is None or min(vertical, forward) <= 0:
        return ""
    both = float(np.sqrt(vertical * forward))
    slow = both > MEAN_SLOPES[1] and min(vertical, forward) > EACH_SLOPE[1]
    fast = both < MEAN_SLOPES[0] and max(vertical, forward) < EACH_SLOPE[0]
    if not slow and not fast:
        return ""
    ratio = float(np.sqrt(both / USUAL_SLOPE))
    return (
        f"the measured forces change {both / USUAL_SLOPE:.2g} times as much as the motion "
        f"requires, upward and fore-aft alike: the frame rate of the file is probably "
        f"{max(ratio, 1 / ratio):.1f} times too {'low' if slow else 'high'}; speeds, powers and "
        "estimated forces are wrong by as much or its square"
    )


def _disagreement(wrong: dict[tuple[str, str], float]) -> str:
    """Return the sentence on wrong slopes, with the likely cause."""
    of_feet = [key for key in wrong if key[1]]
    name, where = (
        of_feet[0] if len(of_feet) == 1 else min(wrong, key=lambda k: (bool(k[1]), wrong[k]))
    )
    slope = wrong[name, where]
    cause = "sign or axis" if slope < MIN_SLOPE else "scale or unit"
    how = f"changes {slope:.1f} times as much as the motion requires"
    if name == "vertical" and slope < MIN_SLOPE:  # it carries the person: its sign is right
        return (
            f"the measured vertical force{where} does not follow the motion: one of them, or the "
            "clock of the force plates, is probably wrong"
        )
    if slope < 0:
        how = "has the opposite direction of what the motion requires"
    elif slope < MIN_SLOPE:
        how = "does not follow the motion"
    return f"the measured {name} force{where} {how}: {cause} of the force plates is probably wrong"
