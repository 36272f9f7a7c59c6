"""Walks with loads on waist, thighs, shanks and feet beside those of people.

Five men walked at 1.25 m/s with these loads [Browning2007]_. Their metabolic rate rose with the
load, and the more the further down it was; their kinematics stayed, and their legs' moments in
swing rose with loads on the feet. Speed and length of steps are the same in all walks. Work of
muscles stands for the metabolic rate: positive work takes 4 times, negative work 0.83 times as much
[Margaria1968]_.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.gait_shape import muscle_work
from experiments.specification import Specification
from experiments.synthesis_trial import check_motion, failure_remarks, solve, summary
from experiments.table import Grid, Row, at_least, at_most
from plantigrade.analyze.curves import gait_curves
from plantigrade.models import Human
from plantigrade.trajopt.tasks.impairments import Impairments
from plantigrade.trajopt.tasks.registry import make_task

SPEED = 1.25  # [m/s]
LOADS = {"waist": (4, 8, 16), "thighs": (8, 16), "shanks": (4, 8), "feet": (4, 8)}
"""Place → loads, of both sides together [kg]."""
QUICK = {"waist": (8,), "feet": (8,)}
PLACES = tuple(LOADS)  # from the top down
ANGLES = ("hip_flexion_r", "knee_angle_r", "ankle_angle_r")
EFFORT = (1 / 0.25, 1 / 1.2)  # [1] energy for positive and for negative work
MAX_CHANGE = 5.0  # [deg] RMS difference of leg angles that counts as the same kinematics


def measure(place: str, mass: float) -> Result:
    """Return the walk with a load; without one for no place."""
    words = Impairments(load=(f"{place}={mass:g}",) if place else ())
    human = words.person(Human.create(1.78, 74.0))
    task = words.task(human, make_task("walk", human, {"speed": SPEED, "periodic": True}))
    timed = solve(human, task)
    run = check_motion(timed)
    curves = gait_curves(run.record)
    motion = run.record.motion
    way = float(np.linalg.norm(motion.qpos[-1, :2] - motion.qpos[0, :2]))
    swing = curves.percent > 65.0
    hip = np.nanmean(curves.moments["hip_flexion_r"], axis=0)[swing]
    return {
        "place": place,
        "mass": mass,
        "good": bool(timed.solution.success and run.ok),
        "verdict": run.status,
        "success": timed.solution.success,
        "stages": [],
        "status": timed.solution.status,
        "worst": "",
        "iterations": timed.solution.iterations,
        "cpu": timed.cpu,
        "wall": timed.wall,
        "effort": float(np.dot(EFFORT, muscle_work(run.record))) / way,
        "swing_moment": float(np.ptp(hip)),
        "angles": {name: np.nanmean(curves.angles[name], axis=0) for name in ANGLES},
    }


def changes(cached: CachedResults) -> dict[tuple[str, float], dict[str, float]]:
    """Return what changes against the walk without load, by place and mass."""
    results = list(cached.select().values())
    found: dict[tuple[str, float], dict[str, float]] = {}
    for bare in [r for r in results if not r["place"]]:
        for r in [r for r in results if r["place"]]:
            apart = [np.subtract(r["angles"][n], bare["angles"][n]) for n in ANGLES]
            found[r["place"], r["mass"]] = {
                "effort": r["effort"] / bare["effort"] - 1.0,
                "swing_moment": r["swing_moment"] / bare["swing_moment"] - 1.0,
                "angles": float(np.sqrt(np.mean(np.square(apart)))),
            }
    return found


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the verdicts and the changes, with the order that people have as goals."""
    for key, r in cached.select().items():
        yield Row(key, "passes the check", float(r["good"]), goal="= 1", met=bool(r["good"]))
    found, before = changes(cached), 0.0
    for place in PLACES:
        per_kilogram = [x["effort"] / mass for (where, mass), x in found.items() if where == place]
        if per_kilogram:
            mean = 100.0 * float(np.mean(per_kilogram))
            yield at_least(place, "effort for each kilogram", mean, before, "%")
            before = mean
    for (place, mass), x in found.items():
        limit = None if place == "feet" else MAX_CHANGE
        yield at_most(f"{place} {mass:g} kg", "RMS of leg angles", x["angles"], limit, "deg")


def grids(cached: CachedResults) -> Iterator[Grid]:
    """Return all changes."""
    lines = [
        [f"{place} {mass:g} kg", *(f"{100 * x[n]:+.0f} %" for n in ("effort", "swing_moment")),
         f"{x['angles']:.1f}°"]
        for (place, mass), x in changes(cached).items()
    ]  # fmt: skip
    header = ("", "effort", "range of the hip moment in swing", "RMS of leg angles")
    yield Grid("Against the walk without load", header, lines)


def cases(quick: bool) -> Cases:
    """Return the walks."""
    chosen = [("", 0.0), *((n, float(m)) for n, masses in (QUICK if quick else LOADS).items()
                           for m in masses)]  # fmt: skip
    return {f"walks/{n or 'none'} {m:g} kg": partial(measure, n, m) for n, m in chosen}


EXPERIMENT = Specification(
    name="loaded-walks",
    title="Walks with loads on waist and legs",
    parts={"walks": cases},
    summary=summary,
    rows=rows,
    grids=grids,
    notes=(
        "",
        "People [Browning2007]: the metabolic rate rises with the load, and the more the further "
        "down it is; kinematics stay, but with heavy feet; moments in swing rise with loads on "
        "the feet. Effort is work of muscles, positive at an efficiency of .25 and negative at "
        "1.2.",
    ),
    remarks=failure_remarks,
)
