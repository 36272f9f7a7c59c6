"""How true motions from tasks are: what the checker finds, how near walks are to published norms.

Every motion is made with the same settings, for people of many sizes, on all feet, at all speeds;
what fails is named with the way its solver went. No recording and no norm is in any problem.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.page import Grid, write_page
from experiments.synthesis_planes import growth_row, plane_grids, plane_rows, planes_of
from experiments.synthesis_trial import (
    brief,
    chosen_parts,
    failures,
    judge,
    motion_rows,
    outcome,
    solve,
    task_of,
    tried,
)
from experiments.table import ResultTable, Row, at_least, at_most, between
from plantigrade.analyze import norms
from plantigrade.analyze.curves import gait_curves
from plantigrade.analyze.gait_shape import gait_shape
from plantigrade.analyze.movement import muscle_work
from plantigrade.charts import RIGHT, Figure, Ribbon, Series, line_plot
from plantigrade.charts.labels import title_of
from plantigrade.dynamics.centroid import centroid
from plantigrade.models import Person
from plantigrade.pages.section import Section
from plantigrade.record import Run
from plantigrade.trajopt.tasks.gait_parameters import leg_length

FILE, PAGE = "synthesis-fidelity.json", "synthesis-fidelity.html"
OTHERS = ("sit-to-stand", "stand-to-sit", "squat", "reach", "side-step", "jump")
FREE = 1.3  # the speed that goals are set for [m/s]
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
    """How much is measured: speeds [m/s], statures [m] and masses [kg] of people, other tasks.

    Nodes a second are the tasks' own if absent.
    """

    speeds: tuple[float, ...] = (0.7, 1.0, FREE, 1.6, 1.9)
    statures: tuple[float, ...] = (1.50, 1.60, 1.75, 1.85, 1.95)
    masses: tuple[float, ...] = (45.0, 77.5, 110.0)
    feet: tuple[str, ...] = ("rigid", "two-segment", "multi-segment")
    others: tuple[str, ...] = (
        "sit-to-stand",
        "stand-to-sit",
        "squat",
        "reach",
        "side-step",
        "jump",
    )
    nodes_per_second: float | None = None


QUICK = Extent((FREE,), (1.75,), (77.5,), ("two-segment",), ("squat", "reach", "jump"))
QUICK_PARTS = ("speeds", "tasks")


def run(
    *,
    parts: Sequence[str] = (),
    extent: Extent | None = None,
    quick: bool = False,
    out: Path | None = None,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> ResultTable:
    """Return the table of the parts (names of :data:`PARTS`), and of all that was measured before.

    Raises:
        ParameterError: If there is no such part.
    """
    extent = extent or (QUICK if quick else Extent())
    kept = KeptResults(out / FILE if out else None, say, anew=overwrite)
    for name in chosen_parts(parts, PARTS, QUICK_PARTS if quick else PARTS):
        for key, who, task, told in PARTS[name](extent):
            make = partial(measure, who, task, told, extent.nodes_per_second)
            kept.get(f"{name}/{key}", partial(tried, make), brief)
    found = table(kept)
    if out is not None:
        grids = (check_grid(kept.results), gait_grid(kept.results), *plane_grids(kept.results))
        sections = [*curve_sections(kept.results), *(g.section() for g in grids)]
        write_page(out / PAGE, found, sections, kept)
    return found


def table(kept: KeptResults) -> ResultTable:
    """Return the table of results that are there."""
    results, notes = kept.results, [*NOTES, *kept.notes()]
    planes = (grid.text() for grid in plane_grids(results))
    sheets = [check_grid(results).text(), gait_grid(results).text(), *planes]
    sheets += fault_sheets(results)
    title = "Motions from tasks: physics and likeness"
    return ResultTable(title, list(rows_of(results)), notes, sheets)


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
    some = sorted({min(extent.speeds), FREE, max(extent.speeds)} & set(extent.speeds))
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
        yield f"{kind}, {FREE:g} m/s from standing", who, "walk", {"speed": FREE}


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
    who: Person, task: str, told: dict[str, Any], nodes_per_second: float | None
) -> dict[str, Any]:
    """Return what is kept of one motion."""
    human = who.human()
    made = solve(human, task_of(task, human, told, nodes_per_second))
    run = judge(made, strides=2)
    found = outcome(made, run) | {"person": asdict(who), "task": task, "told": told}
    found["check"] = {k: v for k, v in run.figures.items() if k.startswith("check_")}
    return found | shape_of(run) if told.get("periodic") else found


def shape_of(run: Run) -> dict[str, Any]:
    """Return the figures and curves of a periodic walk."""
    record = run.record
    human, motion = record.human, record.motion
    com = centroid(human, motion.qpos, motion.qvel).com
    curves = gait_curves(record)
    speed = float(np.ptp(motion["pelvis_tx"][[0, -1]]) / motion.duration)
    kind = norms.speed_class(speed, leg_length(human))
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


# Tables -------------------------------------------------------------------------------------------

CHECKED = (
    ("root rms %", "check_root_force_rms_bw_percent", "{:.2f}"),
    ("max %", "check_root_force_max_bw_percent", "{:.2f}"),
    ("slip mm", "check_slip_max_mm", "{:.2f}"),
    ("depth mm", "check_penetration_max_mm", "{:.2f}"),
    ("friction", "check_friction_ratio_max", "{:.2f}"),
    ("CoP mm", "check_pressure_outside_max_mm", "{:.1f}"),
    ("joint deg", "check_joint_limit_excess_max_deg", "{:.1f}"),
    ("speed %", "check_velocity_limit_use_max_percent", "{:.0f}"),
    ("torque %", "check_torque_limit_use_max_percent", "{:.0f}"),
    ("overlap mm", "check_overlap_max_mm", "{:.1f}"),
)


def check_grid(results: Mapping[str, Result]) -> Grid:
    """Return what the checker found of every motion."""
    header = ("", "good", "s", "iterations", "nodes", *(title for title, _, _ in CHECKED))
    lines = []
    for key, r in results.items():
        if "error" in r:
            lines.append([key, "no", *["-"] * (len(header) - 2)])
            continue
        cells = [key, "yes" if r["good"] else "NO", f"{r['cpu']:.1f}", str(r["iterations"])]
        check = r["check"]
        numbers = ["-" if check.get(k) is None else form.format(check[k]) for _, k, form in CHECKED]
        lines.append([*cells, str(r["nodes"]), *numbers])
    return Grid("What the checker finds", header, lines)


def _agreement(name: str, gait: Mapping[str, Any]) -> str:
    return "{rmse:.1f}/{rmse_offset_removed:.1f}/{correlation:.2f}".format(
        **gait["agreement"][name]
    )


GAIT = (
    ("raw", lambda g: f"{g['rmse']:.1f}"),
    ("offset-removed", lambda g: f"{g['rmse_offset_removed']:.1f}"),
    *((n.split("_")[0], partial(_agreement, n)) for n in CURVES),
    ("peaks", lambda g: "{first:.2f} {trough:.2f} {second:.2f}".format(**g["humps"])),
    ("two", lambda g: "yes" if g["humps"]["two"] else "NO"),
    ("knee mid", lambda g: f"{g['knee_mid_stance']:.0f}"),
    ("swing", lambda g: f"{g['knee_swing']:.0f}"),
    ("ankle range", lambda g: f"{g['ankle_range']:.0f}"),
    ("push-off", lambda g: f"{g['ankle_power']:.1f}"),
    ("stance %", lambda g: f"{g['stance']:.0f}"),
    ("width cm", lambda g: f"{100 * g['step_width_m']:.0f}"),
    ("cost", lambda g: f"{g['muscle_cost_of_transport']:.2f}"),
)  # fmt: skip


def gait_grid(results: Mapping[str, Result]) -> Grid:
    """Return how periodic walks look."""
    header = ("", "class", *(title for title, _ in GAIT))
    units = ("", "", "deg", "deg", *["raw/off/r"] * 3, "body weights", "humps", "deg", "deg", "deg")
    units += ("W/kg", "", "", "")
    lines = [list(units)]
    for key, r in results.items():
        if "gait" in r:
            lines.append([key, r["speed_class"], *(cell(r["gait"]) for _, cell in GAIT)])
    return Grid("How walks look beside norms", header, lines)


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
        told = r["told"]
        text = (
            f"Right leg over the gait cycle at {told['speed']:g} m/s. Band: mean and one standard "
            f"deviation of the norms at speeds called “{r['speed_class'].replace('_', ' ')}”; "
            "dashes: toe off. Nothing of the norms is in the problem."
        )
        sections.append(Section(f"Walking at {told['speed']:g} m/s", figures, text=text))
    return sections


def fault_sheets(results: Mapping[str, Result]) -> list[str]:
    """Return what failed and how the solver ended."""
    lines = ["What failed, and why"]
    for key, words in failures(results).items():
        lines.append(f"{key}: {words}")
        for stage in results[key].get("stages", ()):
            if stage["end"]:
                lines.append(f"    {stage['name']}, {stage['nodes']} nodes: {stage['status']}")
                lines += [f"        {words}" for words in stage["end"]]
    return ["\n".join(lines)] if len(lines) > 1 else []


def rows_of(results: Mapping[str, Result]) -> Iterator[Row]:
    """Return what motions are held against."""
    good = sum(bool(r["good"]) for r in results.values())
    yield at_least("all", "made with the same settings", good, len(results))
    for key, r in results.items():
        yield from motion_rows(key, r)
        speed = r.get("told", {}).get("speed")
        if "check" in r and (speed is None or speed <= FREE):
            yield from check_rows(key, r["check"])
        if "planes" in r and speed is not None and key.startswith("speeds/"):
            yield from plane_rows(key, r["planes"], float(speed))
        if key == f"speeds/{FREE:g} m/s periodic" and "gait" in r:
            yield from gait_rows(key, r["gait"])
    yield from growth_row(results)


def check_rows(key: str, check: Mapping[str, Any]) -> Iterator[Row]:
    """Return what physics asks of one motion."""
    for name, quantity, limit, unit in (
        ("check_root_force_rms_bw_percent", "root force, RMS", 0.5, "% of body weight"),
        ("check_root_force_max_bw_percent", "root force, most", 1.0, "% of body weight"),
        ("check_slip_max_mm", "slip", 3.0, "mm"),
        ("check_penetration_max_mm", "penetration", 2.0, "mm"),
        ("check_pressure_outside_max_mm", "centre of pressure outside", 3.0, "mm"),
    ):
        if check.get(name) is not None:
            yield at_most(key, quantity, float(check[name]), limit, unit)


def gait_rows(key: str, gait: Mapping[str, Any]) -> Iterator[Row]:
    """Return what is expected of a walk at free speed."""
    yield at_most(key, "RMSE of hip, knee and ankle, raw", gait["rmse"], 5.1, "deg")
    off = gait["rmse_offset_removed"]
    yield at_most(key, "RMSE of hip, knee and ankle, offset removed", off, 3.2, "deg")
    for name, least in (("hip_flexion", 0.95), ("knee_angle", 0.95), ("ankle_angle", 0.8)):
        yield at_least(key, f"{name} r", gait["agreement"][name]["correlation"], least)
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
