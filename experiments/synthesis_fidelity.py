"""Fidelity of motions from tasks: findings of the checker, agreement of walks with norms.

Every motion is solved with the same settings, for people of many sizes, on all feet, at all speeds.
No recording and no norm is in any problem.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.gait_shape import gait_shape, muscle_work
from experiments.specification import Specification
from experiments.synthesis_planes import growth_row, plane_grids, plane_rows, planes_of
from experiments.synthesis_trial import (
    check_motion,
    failure_remarks,
    motion_rows,
    outcome,
    solve,
    summary,
    task_of,
)
from experiments.table import Row, at_least, at_most, between
from plantigrade.analyze import norms
from plantigrade.analyze.curves import gait_curves
from plantigrade.charts import RIGHT, Figure, Ribbon, Series, line_plot
from plantigrade.charts.labels import title_of
from plantigrade.dynamics.centroid import centroid
from plantigrade.models import Person
from plantigrade.pages.section import Section
from plantigrade.record import Run

FREE_SPEED = 1.3
"""The speed with goals [m/s]."""
CURVES = ("hip_flexion", "knee_angle", "ankle_angle")
FORCES = ("vertical_grf", "anterior_grf")

NOTES = (
    "",
    "How to read it: root force is what acts on the body and no contact explains, in percent of "
    "body weight, on a grid ten times finer than the nodes; slip, depth and centre of pressure "
    "(CoP, distance outside of what stands) in mm; friction is the largest ratio at a place; "
    "limits are the largest use of a joint's speed and torque, in percent. Norms are those of the "
    "speed class (children of 4 to 17 years; see plantigrade.analyze.norms). Work is that of "
    "muscles at the joints, tissue at rest taken off; its cost of transport counts positive work "
    "alone, per newton and metre. Times of stance and step are part of the task (they follow from "
    "speed and leg length), and so is the line each foot steps on; angles and forces are not. The "
    "few weights of a walk's cost, the same for every speed and person, were settled with norms "
    "at free speed in view.",
    "PredSim's three shipped solutions on the same norms: 6.7 to 7.1 deg raw and 4.2 to 5.9 deg "
    "offset-removed (mean of hip, knee and ankle), ankle r 0.22 to 0.77, solved in 94 to 156 min.",
)


ADULT = Person(height=1.75, mass=77.5, joints="43")


@dataclass(frozen=True)
class Extent:
    """Size of the experiment: speeds [m/s], statures [m] and masses [kg] of people, feet, tasks.

    Nodes per second are the tasks' own if absent.
    """

    speeds: tuple[float, ...] = (0.7, 1.0, FREE_SPEED, 1.6, 1.9)
    statures: tuple[float, ...] = (1.50, 1.60, 1.75, 1.85, 1.95)
    masses: tuple[float, ...] = (45.0, 77.5, 110.0)
    feet: tuple[str, ...] = ("rigid", "two-segment", "multi-segment")
    others: tuple[str, ...] = (
        *("sit-to-stand", "stand-to-sit", "squat", "reach", "side-step", "jump"),
    )
    nodes_per_second: float | None = None


QUICK_EXTENT = Extent((FREE_SPEED,), (1.75,), (77.5,), ("two-segment",), ("squat", "reach", "jump"))
QUICK_PARTS = ("speeds", "tasks")

# Parts --------------------------------------------------------------------------------------------

Case = tuple[str, Person, str, dict[str, Any]]


def speeds(extent: Extent) -> Iterator[Case]:
    """Walks of the average person at all speeds, periodic and from standing to standing."""
    for speed in extent.speeds:
        yield f"{speed:g} m/s periodic", ADULT, "walk", {"speed": speed, "periodic": True}
    for speed in extent.speeds:
        yield f"{speed:g} m/s from standing", ADULT, "walk", {"speed": speed}


def people(extent: Extent) -> Iterator[Case]:
    """Periodic walks of all people: every stature, every mass, slow, free and fast."""
    some = sorted({min(extent.speeds), FREE_SPEED, max(extent.speeds)} & set(extent.speeds))
    for height in extent.statures:
        for mass in extent.masses:
            for speed in some:
                who = replace(ADULT, height=height, mass=mass)
                words = f"{height:.2f} m {mass:g} kg, {speed:g} m/s"
                yield words, who, "walk", {"speed": speed, "periodic": True}


def feet(extent: Extent) -> Iterator[Case]:
    """Walks on all feet at all speeds, and from standing at free speed."""
    for kind in extent.feet:
        who = replace(ADULT, feet=kind)
        for speed in extent.speeds:
            yield f"{kind}, {speed:g} m/s", who, "walk", {"speed": speed, "periodic": True}
        yield f"{kind}, {FREE_SPEED:g} m/s from standing", who, "walk", {"speed": FREE_SPEED}


def others(extent: Extent) -> Iterator[Case]:
    """Return the other tasks."""
    for name in extent.others:
        yield name, ADULT, name, {}


PARTS: Mapping[str, Callable[[Extent], Iterator[Case]]] = {
    "speeds": speeds,
    "feet": feet,
    "tasks": others,
    "people": people,
}


def measure(
    person: Person, task: str, options: dict[str, Any], nodes_per_second: float | None
) -> Result:
    """Return the result of one motion."""
    human = person.human()
    timed = solve(human, task_of(task, human, options, nodes_per_second))
    run = check_motion(timed, strides=2)
    found = outcome(timed, run) | {"person": asdict(person), "task": task, "options": options}
    found["check"] = {k: v for k, v in run.figures.items() if k.startswith("check_")}
    return found | shape_of(run) if options.get("periodic") else found


def shape_of(run: Run) -> dict[str, Any]:
    """Return the figures and curves of a periodic walk."""
    record = run.record
    human, motion = record.human, record.motion
    com = centroid(human, motion.qpos, motion.qvel).com
    curves = gait_curves(record)
    speed = float(np.ptp(motion["pelvis_tx"][[0, -1]]) / motion.duration)
    kind = norms.speed_class(speed, human.dimensions.leg_length)
    shape = gait_shape(curves, kind)
    way = float(np.linalg.norm(com[-1, :2] - com[0, :2]))
    gait = asdict(shape) | {"rmse": shape.rmse, "rmse_offset_removed": shape.rmse_offset_removed}
    for name in ("step_width_m", "cost_of_transport", "cadence_steps_min"):
        gait[name] = run.figures.get(name)
    gait["muscle_cost_of_transport"] = muscle_work(record)[0] / (record.weight * way)
    drawn = {n: np.nanmean(curves.angles[f"{n}_r"], axis=0) for n in CURVES}
    for name, ours in zip(FORCES, ("up_r", "forward_r"), strict=True):
        drawn[name] = np.nanmean(curves.forces[ours], axis=0)
    shown = {"percent": curves.percent, "curves": drawn, "planes": planes_of(run, speed, kind)}
    return {"speed_class": kind, "gait": gait, **shown}


# Figures ------------------------------------------------------------------------------------------


def curve_sections(results: Mapping[str, Result]) -> list[Section]:
    """Return angles and ground reactions over norms, a section for every speed."""
    titles = {"vertical_grf": "Vertical ground reaction", "anterior_grf": "Forward ground reaction"}
    sections = []
    for key, r in results.items():
        if not key.startswith("speeds/") or "curves" not in r:
            continue
        percent, figures = np.array(r["percent"]), []
        for name in (*CURVES, *FORCES):
            band = norms.norm(name, r["speed_class"])
            ours = np.array(r["curves"][name], float)
            figures.append(
                Figure(
                    line_plot(
                        [
                            Series(band.percent, band.mean, "norm", "var(--soft, #64707f)", 1.4),
                            Series(percent, ours, "from the task", RIGHT, 2.0),
                        ],
                        title=titles.get(name, title_of(name)),
                        x_label="gait cycle [%]",
                        y_label="[BW]" if name in FORCES else "[°]",
                        bands=[Ribbon(band.percent, band.mean - band.sd, band.mean + band.sd)],
                        marks=[(r["gait"]["stance"], RIGHT)],
                        zero=True,
                    )
                )
            )
        speed = r["options"]["speed"]
        text = (
            f"Right leg over the gait cycle at {speed:g} m/s. Band: mean and one standard "
            f"deviation of the norms at speeds called “{r['speed_class'].replace('_', ' ')}”; "
            "dashes: toe off. Nothing of the norms is in the problem."
        )
        sections.append(Section(f"Walking at {speed:g} m/s", figures, text=text))
    return sections


CHECKS = (
    ("root_force_rms_bw_percent", "root force, RMS", 0.5, "% of body weight"),
    ("root_force_max_bw_percent", "root force, most", 1.0, "% of body weight"),
    ("slip_max_mm", "slip", 3.0, "mm"),
    ("penetration_max_mm", "penetration", 2.0, "mm"),
    ("pressure_outside_max_mm", "centre of pressure outside", 3.0, "mm"),
    ("friction_ratio_max", "friction", None, ""),
    ("joint_limit_excess_max_deg", "joint limits exceeded", None, "deg"),
    ("velocity_limit_use_max_percent", "use of speed limits", None, "%"),
    ("torque_limit_use_max_percent", "use of torque limits", None, "%"),
    ("overlap_max_mm", "overlap", None, "mm"),
)
"""Figure of the checker, its name, its goal up to free speed, and its unit."""


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures of all motions, with their goals."""
    results = cached.results
    good = sum(bool(r.get("good")) for r in results.values())
    yield at_least("all", "made with the same settings", good, len(results))
    for key, r in results.items():
        yield from motion_rows(key, r)
        if "error" in r:
            continue
        speed = r["options"].get("speed")
        for name, quantity, limit, unit in CHECKS:
            if (value := r["check"].get(f"check_{name}")) is not None:
                slow = speed is None or speed <= FREE_SPEED
                yield at_most(key, quantity, float(value), limit if slow else None, unit)
        if "planes" in r and speed is not None and key.startswith("speeds/"):
            yield from plane_rows(key, r["planes"], float(speed))
        if "gait" in r:
            judged = key == f"speeds/{FREE_SPEED:g} m/s periodic"
            for row in gait_rows(key, r["gait"]):
                yield row if judged else replace(row, goal="", met=None)
    yield from growth_row(results)


def gait_rows(key: str, gait: Mapping[str, Any]) -> Iterator[Row]:
    """Return the agreement of a walk with norms, with the goals at free speed."""
    yield at_most(key, "RMSE of hip, knee and ankle, raw", gait["rmse"], 5.1, "deg")
    off = gait["rmse_offset_removed"]
    yield at_most(key, "RMSE of hip, knee and ankle, offset removed", off, 3.2, "deg")
    for name, least in zip(CURVES, (0.95, 0.95, 0.8), strict=True):
        agreement = gait["agreement"][name]
        yield at_least(key, f"{name} r", agreement["correlation"], least)
        yield Row(key, f"{name} RMSE", agreement["rmse"], "deg")
        yield Row(key, f"{name} RMSE, offset removed", agreement["rmse_offset_removed"], "deg")
    humps = gait["humps"]
    for name, words, low, high in (
        ("first", "first hump", 1.0, 1.3),
        ("trough", "trough", 0.6, 0.9),
        ("second", "second hump", 1.0, 1.3),
    ):
        yield between(key, f"vertical force, {words}", humps[name], low, high, "body weights")
    yield at_least(key, "vertical force, two humps", float(humps["two"]), 1)
    yield at_most(key, "knee at mid-stance", gait["knee_mid_stance"], 20.0, "deg")
    yield between(key, "knee in swing, most", gait["knee_swing"], 52.0, 68.0, "deg")
    yield at_least(key, "ankle range", gait["ankle_range"], 25.0, "deg")
    yield between(key, "stance", gait["stance"], 58.0, 64.0, "%")
    yield between(key, "step width", 100 * gait["step_width_m"], 5.0, 15.0, "cm")
    cost = gait["muscle_cost_of_transport"]
    yield Row(key, "cost of transport, positive work of muscles", cost)
    yield Row(key, "push-off", gait["ankle_power"], "W/kg")


def experiment(extent: Extent | None = None) -> Specification:
    """Return the experiment; its size is that of the long or the short form if none is given."""

    def cases(part: str, quick: bool) -> Cases:
        size = extent or (QUICK_EXTENT if quick else Extent())
        return {
            f"{part}/{key}": partial(measure, person, task, options, size.nodes_per_second)
            for key, person, task, options in PARTS[part](size)
        }

    return Specification(
        name="synthesis-fidelity",
        title="Motions from tasks: physics and agreement with norms",
        parts={part: partial(cases, part) for part in PARTS},
        quick_parts=QUICK_PARTS,
        summary=summary,
        rows=rows,
        grids=lambda cached: plane_grids(cached.select()),
        notes=NOTES,
        remarks=failure_remarks,
        pictures=lambda cached: curve_sections(cached.select()),
    )


EXPERIMENT = experiment()
