r"""Whether measured forces of a gait are those of its motion: sign, axes, unit, place and clock.

The net ground reaction equals :math:`m (a - g)` of the centre of mass. Over the frames with
measured forces on both feet, the slope of the regression of measured on required force is 1 in
each direction: 0.8 to 1.2 in recordings of walking, 0.5 to 0.7 fore-aft in running, whose
accelerations are filtered. It is negative for a reversed axis, near zero for exchanged axes, and
the square of the ratio of the clocks for a wrong frame rate. In single support the slope shows a
fault of one plate; sideways the force changes too little there. Friction under a foot limits the
free moment.

A constant offset of the centre of pressure appears as one of the centre of mass
(:func:`plantigrade.dynamics.inverse.com_metrics`).
"""

import numpy as np

from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDE_NAMES, SIDES
from plantigrade.dynamics.inverse import com_metrics
from plantigrade.motion.event_timing import is_running
from plantigrade.spatial.conventions import rotation_matrix

MIN_SLOPE, MAX_SLOPE = 0.35, 2.2  # [1] range of the slope of forces that belong to the motion
MIN_VARIATION = {"fore-aft": 0.012, "sideways": 0.025, "vertical": 0.02}
"""Minimum standard deviation of the required force, for a slope [BW]; half the frame rate leaves a
quarter of it, and walkers have 0.06, 0.03 and 0.12."""
MIN_FRAMES = 20  # [1] minimum number of frames for a slope
MIN_TIME = 0.3  # [s] and their minimum duration; less is a part of a stance
MIN_SINGLE_LOAD = 0.3  # [BW] minimum load of the foot that stands alone …
MAX_OTHER_LOAD = 0.02  # [BW] … and maximum load of the other one
MIN_CLOCK_SLOPES = 2  # [1] number of directions that must show the same wrong clock
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
    least = max(MIN_FRAMES, MIN_TIME / float(np.median(np.diff(trial.motion.time))))
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
    wrong = {key: s for key, s in slopes.items() if not MIN_SLOPE <= s <= MAX_SLOPE}
    return _told(slopes, wrong) if wrong else ""


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


def _told(slopes: dict[tuple[str, str], float], wrong: dict[tuple[str, str], float]) -> str:
    """Return the sentence on wrong slopes, with the likely cause."""
    whole = {name: slope for (name, where), slope in slopes.items() if not where}
    for beyond, word in ((lambda s: s > MAX_SLOPE, "low"), (lambda s: 0 < s < MIN_SLOPE, "high")):
        same = [s for s in whole.values() if beyond(s)]
        if len(same) == len(whole) >= MIN_CLOCK_SLOPES:
            ratio = float(np.sqrt(np.median(same)))
            factor = max(ratio, 1 / ratio)
            return (
                "the measured forces change in all directions "
                f"{np.median(same):.2g} times as much as the motion requires: the frame rate of "
                f"the file is probably {factor:.1f} times too {word}, or the unit of forces is "
                "wrong"
            )
    of_feet = [key for key in wrong if key[1]]
    name, where = (
        of_feet[0] if len(of_feet) == 1 else min(wrong, key=lambda k: (bool(k[1]), wrong[k]))
    )
    slope = wrong[name, where]
    cause = "sign or axis" if slope < MIN_SLOPE else "scale or unit"
    how = f"changes {slope:.1f} times as much as the motion requires"
    if slope < 0:
        how = "has the opposite direction of what the motion requires"
    elif slope < MIN_SLOPE:
        how = "does not follow the motion"
    return f"the measured {name} force{where} {how}: {cause} of the force plates is probably wrong"
