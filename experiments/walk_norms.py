"""Generated walks at five speeds beside people: angles, moments, arms, head, centre of mass.

The norms are in two halves. Constants of the walk may be settled with the first in view; the second
is what is reported:

- **settling**: angles of children at very slow, free and very fast speed [Schwartz2008]_; peak
  moments of every other of 138 adults at their own speed [VanCriekinge2023]_;
- **reporting**: angles of 42 adults at their own comfortable speed [Fukuchi2018]_, at other speeds
  with what changes from slow to fast in children [Schwartz2008]_; peak moments of the other adults.

Published hip rotation is that of marker models whose knee turns about the shank. The knee of this
skeleton is a hinge, so that the hip turns as the pelvis does over a foot that stands: recorded
people, fitted with this skeleton, have the opposite course (r from -0.7 to 0 with the norms). Hip
rotation is therefore compared with them (:data:`HIP_ROTATION`), at all speeds.

Curves are interpolated over the dimensionless speed, moments over the speed of the adults, who
walked at 0.8 to 1.8 m/s.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.plane_figures import load_figures, plane_figures, published
from experiments.specification import Specification
from experiments.synthesis_trial import check_motion, failure_remarks, outcome, solve, summary
from experiments.table import Grid, Row, at_least, at_most, between, text_of
from plantigrade.analyze import norms
from plantigrade.analyze.curves import gait_curves
from plantigrade.analyze.statistics import compare_curves
from plantigrade.arrays import Array, Float
from plantigrade.models import Person
from plantigrade.models.textbook_gait import ADULT_SPEED, CLASS_SPEEDS
from plantigrade.record import Run
from plantigrade.trajopt.tasks.registry import make_task

PERSON = Person(height=1.74, mass=71.0, joints="43")
SPEEDS = (0.7, 1.0, 1.3, 1.6, 1.9)  # [m/s]
QUICK_SPEEDS = (1.3,)  # [m/s]
HALVES = ("settling", "reporting")
SETTLING_CLASSES = ("very_slow", "free", "very_fast")
"""Classes of speed of the children in the settling half."""
REPORTED_CLASSES = ("slow", "fast")
"""Classes of speed of the children in the other half."""
PEAK_MOMENTS = {
    "settling": {"ankle": (0.442, 0.908, 0.156), "knee": (0.598, -0.190, 0.147)},
    "reporting": {"ankle": (0.596, 0.729, 0.180), "knee": (0.856, -0.444, 0.175)},
}
"""Peak moments of plantarflexors and knee extensors of 69 adults each [VanCriekinge2023]_: slope
[N m s/(kg m)] and intercept of the regression on speed, and the SD about it [N m/kg]."""
HIP_ROTATION = {
    "settling": (-3.7, -2.6, -1.5, -1.1, 0.0, 1.8, 3.6, 4.8, 6.0, 6.9, 6.4, 4.3, 2.6, 2.1, 1.3, 0.0,
                 -1.3, -2.3, -3.0, -3.1, -2.6),
    "reporting": (-1.9, -1.6, -0.6, -0.6, -0.4, 0.8, 2.2, 4.1, 5.9, 7.2, 7.7, 7.0, 4.8, 2.6, 1.9,
                  1.8, 1.2, -0.2, -1.7, -2.1, -2.0),
}  # fmt: skip
"""Hip rotation at 0, 5, …, 100 % of the cycle, mean of the right leg of five people each, who walk
at 1.1 to 1.7 and at 0.9 to 1.4 m/s: the halves of :data:`experiments.gait_walks.PEOPLE`, the first
walk of each, fitted on the 42 joints [deg]."""
HIP_ROTATION_SD = 6.0  # [deg] between these people, mean over the cycle
MOMENTS = {"ankle": "ankle_plantarflexor_nm_kg", "knee": "knee_extensor_early_nm_kg"}
LEG = {"hip_flexion": 5.5, "knee_angle": 4.5, "ankle_angle": 4.0}
"""Angle → greatest RMS difference between :data:`GOAL_SPEEDS` [deg]."""
SHAPES = {"pelvis_tilt": 0.8, "pelvis_list": None, "pelvis_rotation": 0.8}
SHAPES |= {"hip_adduction": None, "hip_rotation": 0.8}
"""Angle → least correlation at all speeds; without a goal if None."""
GOAL_SPEEDS = (1.0, 1.6)  # [m/s]
ANKLE_MOMENT = 0.12  # [1] allowed relative difference of the peak
LOADING_FLEXION = (15.0, 20.0)
"""Range of the greatest knee flexion at loading [deg]."""
LOADING_MIN_SPEED = 0.9
"""Speed from which it is judged [m/s]."""
LOADING_END = 30.0  # [% of the cycle] until which the knee yields
NOTES = (
    "",
    "Settling half: children at very slow, free and very fast speed, moments of every other of 138 "
    "adults. Reporting half: 42 adults at their comfortable speed (at other speeds with what "
    "changes from slow to fast in children), moments of the other adults. Constants of the walk "
    "may be settled on the first; only the second has goals. Hip rotation is that of ten recorded "
    "people, five in each half, fitted with the same skeleton: norms are of knees that turn.",
    "In the table a figure stands beside that of people with its SD: of turns of the pelvis and "
    "the knee the SD between people of the curve at that instant; of arms and centre of mass that "
    "of plantigrade's published ranges. Tilt and hip flexion are those of the model's pelvis.",
)


def curve(name: str, half: str, relative: float) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return mean and SD of an angle at 0, 2, …, 100 % of the cycle, of one half of the norms.

    Args:
        name: A coordinate of the pelvis or the right leg.
        half: One of :data:`HALVES`.
        relative: Dimensionless speed.
    """
    if name == "hip_rotation":
        mean = np.interp(np.linspace(0, 100, 51), np.linspace(0, 100, 21), HIP_ROTATION[half])
        return mean, np.full(len(mean), HIP_ROTATION_SD)
    classes = SETTLING_CLASSES if half == "settling" else REPORTED_CLASSES
    bands = [norms.norm(name, c) for c in classes]
    speeds = [CLASS_SPEEDS[c] for c in classes]
    if half == "settling":
        mean, sd = (
            np.array([np.interp(relative, speeds, values) for values in zip(*rows, strict=True)])
            for rows in ([b.mean for b in bands], [b.sd for b in bands])
        )
        return mean, sd
    adults = norms.norm(name, population=norms.ADULTS)
    slope = (bands[1].mean - bands[0].mean) / (speeds[1] - speeds[0])
    return adults.mean + slope * (relative - ADULT_SPEED), adults.sd


def peak_moment(joint: str, half: str, speed: float) -> tuple[float, float]:
    """Return mean and SD of a joint's peak moment at a speed [N m/kg].

    Example:
        >>> "{:.2f} ± {:.2f}".format(*peak_moment("ankle", "reporting", 1.3))
        '1.50 ± 0.18'
    """
    slope, intercept, sd = PEAK_MOMENTS[half][joint]
    return slope * speed + intercept, sd


def measure(speed: float) -> Result:
    """Return the walk at a speed."""
    human = PERSON.human()
    timed = solve(human, make_task("walk", human, {"speed": speed, "periodic": True}))
    run = check_motion(timed, strides=2)
    return {"speed": speed, **outcome(timed, run), **shape_of(run, speed)}


def shape_of(run: Run, speed: float) -> dict[str, Any]:
    """Return figures and curves of a periodic walk."""
    human, curves = run.record.human, gait_curves(run.record)
    angles = {}
    for name in (*LEG, *SHAPES):
        own = curves.angles[name if name.startswith("pelvis") else f"{name}_r"]
        angles[name] = np.interp(np.linspace(0, 100, 51), curves.percent, np.nanmean(own, axis=0))
    return {
        "relative": norms.dimensionless_speed(speed, human.dimensions.leg_length),
        "angles": angles,
        "figures": plane_figures(run.record) | load_figures(curves),
        "usual": {n: list(x) for n, x in published(human, speed).items()},
    }


def beside(result: Result, half: str) -> dict[str, tuple[float, float | None, float | None]]:
    """Return figures of a walk by name: ours, mean and SD of people where they are known."""
    angles = {n: np.array(x, float) for n, x in result["angles"].items()}
    relative, figures, usual = result["relative"], result["figures"], result["usual"]
    found: dict[str, tuple[float, float | None, float | None]] = {}
    for name in LEG:
        held = compare_curves(angles[name], curve(name, half, relative)[0])
        found[f"{name} RMS deg"] = (held.rmse, None, None)
        found[f"{name} RMS, offset removed deg"] = (held.rmse_offset_removed, None, None)
    for name in SHAPES:
        held = compare_curves(angles[name], curve(name, half, relative)[0])
        found[f"{name} r"] = (held.correlation, None, None)
    mean, sd = curve("pelvis_tilt", half, relative)
    found["pelvis tilt deg"] = (float(angles["pelvis_tilt"].mean()), float(mean.mean()), sd.mean())
    mean, sd = curve("pelvis_rotation", half, relative)
    own = float(np.ptp(angles["pelvis_rotation"]) / 2)
    found["pelvis turn ± deg"] = (own, float(np.ptp(mean) / 2), float(sd[np.abs(mean).argmax()]))
    mean, sd = curve("knee_angle", half, relative)
    knee, early = angles["knee_angle"], np.linspace(0, 100, 51) <= LOADING_END
    found["knee at strike deg"] = (knee[0], mean[0], sd[0])
    k = int(mean[early].argmax())
    found["knee at loading deg"] = (float(knee[early].max()), mean[k], sd[k])
    for joint, name in MOMENTS.items():
        found[f"{joint} moment N m/kg"] = (
            figures[name],
            *peak_moment(joint, half, result["speed"]),
        )
    low, high = usual["arm_swing_deg"]
    found["arm swing deg"] = (figures["arm_swing_deg"], (low + high) / 2, (high - low) / 2)
    found["elbow deg"] = (figures["elbow_range_deg"], None, None)
    found["head pitch ± deg"] = (figures["head_forward_deg"], None, None)
    low, high = usual["com_up_down_mm"]
    found["centre of mass up mm"] = (figures["com_up_down_mm"], (low + high) / 2, (high - low) / 2)
    return {n: tuple(None if x is None else float(x) for x in v) for n, v in found.items()}  # type: ignore[misc]


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures of the reporting half, with their goals."""
    for key, r in cached.select().items():
        yield Row(key, "passes the check", float(r["good"]), goal="= 1", met=bool(r["good"]))
        speed, found = r["speed"], beside(r, "reporting")
        judged = GOAL_SPEEDS[0] <= speed <= GOAL_SPEEDS[1]
        for name, most in LEG.items():
            quantity = f"{name} RMS"
            value = found[f"{quantity} deg"][0]
            yield at_most(key, quantity, value, most if judged else None, "deg")
        for name, least in SHAPES.items():
            yield at_least(key, f"{name} r", found[f"{name} r"][0], least)
        ankle, mean, _ = found["ankle moment N m/kg"]
        low, high = ((1.0 + sign * ANKLE_MOMENT) * float(mean or 0.0) for sign in (-1, 1))
        yield between(key, "ankle moment", ankle, low, high, "N m/kg")
        if speed >= LOADING_MIN_SPEED:
            yield between(
                key, "knee at loading", found["knee at loading deg"][0], *LOADING_FLEXION, "deg"
            )
        for name in ("arm swing", "pelvis turn ±"):
            own, mean, sd = (float(x or 0.0) for x in found[f"{name} deg"])
            yield between(key, name, own, mean - sd, mean + sd, "deg")


def grids(cached: CachedResults) -> Iterator[Grid]:
    """Return all figures beside those of both halves of people."""
    results = cached.select()
    for half in reversed(HALVES):
        found = {f"{r['speed']:g} m/s": beside(r, half) for r in results.values()}
        lines = [
            [name, *(_cell(*figures[name]) for figures in found.values())]
            for name in next(iter(found.values()), {})
        ]
        yield Grid(f"Ours (people ± SD), {half} half", ("", *found), lines)
    lines = [
        [name, *(_between_halves(name, r["relative"]) for r in results.values())]
        for name in (*LEG, *SHAPES)
    ]
    header = ("", *(f"{r['speed']:g} m/s" for r in results.values()))
    yield Grid("Halves against each other: RMS deg, offset removed, r", header, lines)


def _between_halves(name: str, relative: float) -> str:
    """Return how far people of one half are from those of the other."""
    held = compare_curves(*(curve(name, half, relative)[0] for half in HALVES))
    return f"{held.rmse:.1f}, {held.rmse_offset_removed:.1f}, {held.correlation:.2f}"


def _cell(own: float, mean: float | None, sd: float | None) -> str:
    digits = 1 if abs(own) >= 3 else 2
    return text_of(own, digits) + (
        "" if mean is None else f" ({text_of(mean, digits)} ± {text_of(sd, digits)})"
    )


def cases(quick: bool) -> Cases:
    """Return the walks."""
    return {f"walks/{v:g} m/s": partial(measure, v) for v in (QUICK_SPEEDS if quick else SPEEDS)}


EXPERIMENT = Specification(
    name="walk-norms",
    title="Generated walks at five speeds beside people",
    parts={"walks": cases},
    summary=summary,
    rows=rows,
    grids=grids,
    notes=NOTES,
    remarks=failure_remarks,
)
