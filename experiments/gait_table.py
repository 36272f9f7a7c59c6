"""Table I of [Boukheddimi]_ over public recordings, its columns beside ours.

Every walk is fitted with its file name alone and rebuilt twice: with the paper's three tasks, and
with the default. The table proper has one walk of each person, the first by name, so that its tests
compare people; a second shows all walks.
"""

import math
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from experiments.gait_walks import (
    QUICK_PEOPLE,
    SETTLING_PEOPLE,
    TURNS,
    Walk,
    Walks,
    reproduce_walks,
)
from experiments.table import ResultTable, Row, at_least, at_most, sheet, sheets_of
from plantigrade.analyze.gait_study import Study, StudyRow
from plantigrade.analyze.reproduction import ROTATIONS
from plantigrade.constants import SIDES

TASKS = ("paper", "default")
TITLES = {"paper": "Tasks of the paper", "default": "Default tasks"}
# Goals.
SAGITTAL = ("hip_flexion", "knee_angle", "ankle_angle")
# Goals of the default tasks; the paper's tasks have its own.
MAX_ROM_ERROR = 6  # [deg] of one rotation, mean over people
MAX_MEAN_ROM_ERROR = 3  # [deg] mean over rotations
MAX_SAGITTAL_RMSE = 4  # [deg]
MAX_ROTATION_ERROR = 8  # [deg] of the worst rotation of one gait
MAX_MEDIAN_ROTATION_ERROR = 5  # [deg] median over gaits of the worst rotation
MIN_SHARE_OF_GAITS = 90  # [%] of gaits whose worst rotation is within MAX_ROTATION_ERROR
CLEARANCE = 8  # [mm]
MAX_COM_ERROR = 5  # [mm]
MAX_CONTACT_DRIFT = 2  # [mm]
MIN_SOLE_HEIGHT = -5  # [mm] of the lowest point of the soles
MAX_CYCLE_TIME = 0.5  # [s] of computing, for a gait cycle
MAX_PROGRAM_TIME = 0.3  # [ms] of the quadratic programs of a tick, median
MAX_TICK_TIME = 0.6  # [ms] of a whole tick, median
HALVES = {True: "settled half", False: "other half"}
# Words in the names of figures that mean something of independent gaits only.
TESTS = ("_p_", "identical", "_error_low_", "_error_high_")

NOTES = (
    "",
    "How to read it: sim, ref and diff are ROM in degrees, mean over people of each person's mean "
    "over cycles; diff is sim - ref with its sign (the paper prints it without), with its 95 % "
    "interval; |diff| is the mean of the absolute differences, which does not let one person's "
    "excess pay for another's lack. p is Student's paired test, or Wilcoxon's (w) where Shapiro "
    "and Wilk reject normality, both at 5 %; '=' says that no significant difference was found, "
    "which does not prove that there is none: see the interval. RMSE [deg] and r are of the curves "
    "over the cycle. Under 'paper' stands what the paper printed for its nine people: sim, ref, "
    "diff. Its goal is compared in whole degrees, as printed.",
    f"The walks of one person are not independent: the table of all walks ({', '.join(TURNS)} is "
    "a turn) has no tests and no intervals.",
    "Walk by walk: how far the centre of mass and a point of the soles in contact were off at "
    "most, the lowest point of the soles, the share of the planned stance in which the foot does "
    "stand on the ground, toe clearance in mid swing beside the recorded one, the mean absolute "
    "ROM difference of the twelve, and times of this machine.",
    "Single gaits: of each walk, the rotation furthest off. The constants of the tasks were "
    f"settled on the walks of {', '.join(SETTLING_PEOPLE)}; the other half had no say in them.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the walks in a data folder.

    Raises:
        ParameterError: If the folder holds none of the walks.
    """
    rows: list[Row] = []
    sheets, figures = [], {}
    notes = [*NOTES]
    people = QUICK_PEOPLE if quick else None
    for tasks, walks in reproduce_walks(data, TASKS, people=people, say=say).items():
        notes, title = [*NOTES, *walks.left_out], TITLES[tasks]
        rows += [
            Row(name, f"{tasks} tasks", None, note=why, met=False)
            for name, why in walks.failed.items()
        ]
        if walks.any_cycle:
            each, every = walks.study(one_each=True), walks.study(one_each=False)
            rows += study_rows(tasks, each)
            sheets.append(study_sheet(f"{title}, one walk of each of {each.n} people", each))
            sheets.append(study_sheet(f"{title}, all {every.n} walks", every, tests=False))
            figures |= {f"{tasks}_{k}": v for k, v in each.metrics().items()}
            figures |= {
                f"{tasks}_all_walks_{k}": v
                for k, v in every.metrics().items()
                if not any(word in k for word in TESTS)
            }
            halves = [row for settled in HALVES for row in half_rows(tasks, walks, settled)]
            sheets += sheets_of(f"{title}, single gaits", halves)
            rows += halves
        each_walk = [row for walk in walks.done for row in walk_rows(walk)]
        sheets += sheets_of(f"{title}, walk by walk", each_walk)
        rows += each_walk
    return ResultTable("Gaits from three ordered tasks", rows, notes, sheets, figures)


def single_gaits(walks: Walks, settled: bool) -> dict[str, tuple[float, str]]:
    """Return what single gaits of one half of the people are off by, with units; none of nobody."""
    half = [walk.comparison for walk in walks.half(settled=settled)]
    if not half:
        return {}
    off = np.array([[c.rom_error[name] for _, name in ROTATIONS] for c in half])
    worst = np.abs(off).max(axis=1)
    names = [name for _, name in ROTATIONS]
    over = {
        stem: float(off[:, [names.index(f"{stem}_{s}") for s in SIDES]].mean()) for stem in SAGITTAL
    }
    clearance = [1e3 * abs(a - b) for c in half for a, b in c.clearance.values()]
    return {
        "gaits": (len(half), ""),
        f"worst rotation within {MAX_ROTATION_ERROR} deg": (
            100 * float(np.mean(worst <= MAX_ROTATION_ERROR)),
            "%",
        ),
        "worst rotation, median": (float(np.median(worst)), "deg"),
        "worst rotation, largest": (float(worst.max()), "deg"),
        "ROM difference, mean absolute": (float(np.abs(off).mean()), "deg"),
        **{f"{stem} ROM difference, mean": (value, "deg") for stem, value in over.items()},
        "toe clearance off by, largest": (float(np.nanmax(clearance)), "mm"),
        "toe clearance off by, mean": (float(np.nanmean(clearance)), "mm"),
    }


def half_rows(tasks: str, walks: Walks, settled: bool) -> list[Row]:
    """Return what single gaits of one half of the people are held against."""
    subject = f"{tasks} tasks, {HALVES[settled]}"
    goals = {
        f"worst rotation within {MAX_ROTATION_ERROR} deg": (at_least, MIN_SHARE_OF_GAITS),
        "worst rotation, median": (at_most, MAX_MEDIAN_ROTATION_ERROR),
        "toe clearance off by, largest": (at_most, CLEARANCE),
    }
    rows = []
    for name, (value, unit) in single_gaits(walks, settled).items():
        against, goal = goals.get(name, (at_most, None))
        rows.append(against(subject, name, value, goal if tasks == "default" else None, unit))
    return rows


def study_rows(tasks: str, result: Study) -> list[Row]:
    """Return what the ranges of motion of a set of tasks are held against."""
    subject = f"{tasks} tasks"
    rows = [at_least(subject, "people", result.n, 6)]
    for row in result.rows:
        name = f"{row.coordinate} ROM difference"
        if tasks == "paper":
            printed = row.paper.difference
            met = in_whole_degrees(row.difference) <= printed
            goal = f"<= {printed} as printed"
            rows.append(Row(subject, name, row.difference, "deg", goal, met))
            continue
        rows.append(at_most(subject, name, abs(row.difference), MAX_ROM_ERROR, "deg"))
        rows.append(
            at_most(subject, f"{name}, mean absolute", row.difference_abs, MAX_ROM_ERROR, "deg")
        )
        if row.coordinate[:-2] in SAGITTAL:
            rows.append(
                at_most(subject, f"{row.coordinate} RMSE", row.rmse, MAX_SAGITTAL_RMSE, "deg")
            )
    for name, value in mean_differences(result).items():
        rows.append(
            at_most(subject, name, value, None if tasks == "paper" else MAX_MEAN_ROM_ERROR, "deg")
        )
    return rows


def mean_differences(result: Study) -> dict[str, float]:
    """Return the mean over the twelve rotations of both kinds of ROM difference [deg]."""
    return {
        "ROM difference, mean of twelve": float(np.mean([abs(r.difference) for r in result.rows])),
        "ROM difference, mean of twelve, mean absolute": float(
            np.mean([r.difference_abs for r in result.rows])
        ),
    }


def in_whole_degrees(difference: float) -> int:
    """Return a difference as a table without sign and decimals prints it [deg]."""
    return math.floor(abs(difference) + 0.5)


def walk_rows(walk: Walk) -> list[Row]:
    """Return the figures of one reproduced walk, with their goals."""
    c, name, prefix = walk.comparison, walk.name, f"{walk.tasks} tasks"
    rows = [
        at_most(
            name, f"{prefix}, centre of mass off by", 1e3 * c.com_error_max_m, MAX_COM_ERROR, "mm"
        ),
        at_most(name, f"{prefix}, contact drift", 1e3 * c.contact_drift_m, MAX_CONTACT_DRIFT, "mm"),
        at_least(
            name, f"{prefix}, lowest point of the soles", 1e3 * c.lowest_m, MIN_SOLE_HEIGHT, "mm"
        ),
    ]
    if c.cycles:
        rows.append(
            at_most(name, f"{prefix}, time per cycle", walk.seconds_per_cycle, MAX_CYCLE_TIME, "s")
        )
        off = float(np.mean([abs(c.rom_error[n]) for _, n in ROTATIONS]))
        rows.append(Row(name, f"{prefix}, ROM difference, mean absolute", off, "deg"))
    ours, recorded = (_mean(v[k] for v in c.clearance.values()) for k in (0, 1))
    return [
        *rows,
        at_most(name, f"{prefix}, program, median", 1e3 * walk.tick, MAX_PROGRAM_TIME, "ms"),
        at_most(name, f"{prefix}, whole tick, median", 1e3 * walk.whole_tick, MAX_TICK_TIME, "ms"),
        Row(name, f"{prefix}, cycles", len(c.cycles)),
        Row(name, f"{prefix}, stance with contact", 100 * c.contact_share, "%"),
        Row(name, f"{prefix}, toe clearance", 1e3 * ours, "mm"),
        Row(name, f"{prefix}, toe clearance, recorded", 1e3 * recorded, "mm"),
    ]


def study_sheet(title: str, result: Study, *, tests: bool = True) -> str:
    """Return Table I over a study, the paper's columns beside."""
    header = ["", "sim", "ref", "diff", *(["95 % interval", "p", "="] if tests else []), "|diff|"]
    header += ["RMSE", "r", "paper", "", "", "="]

    def line(row: StudyRow) -> list[str]:
        paper = row.paper
        cells = [row.label, *(f"{x:.1f}" for x in (row.simulated, row.reference))]
        cells += [f"{row.difference:+.1f}"]
        if tests:
            p = "-" if row.p is None else f"{row.p:.3f}{'w' if row.test == 'wilcoxon' else ' '}"
            cells += ["{:+.1f} to {:+.1f}".format(*row.interval), p, "=" if row.identical else ""]
        cells += [f"{row.difference_abs:.1f}"]
        cells += [f"{row.rmse:.1f}", f"{row.correlation:.2f}"]
        return cells + _whole(paper.simulated, paper.reference, paper.difference, paper.identical)

    def mean(what: Callable[[StudyRow], float]) -> float:
        return float(np.mean([what(row) for row in result.rows]))

    last = ["mean of the twelve", "", "", f"{mean(lambda r: abs(r.difference)):.1f}"]
    last += [*([""] * 3 if tests else []), f"{mean(lambda r: r.difference_abs):.1f}"]
    last += [f"{mean(lambda r: r.rmse):.1f}", f"{mean(lambda r: r.correlation):.2f}"]
    last += ["", "", f"{mean(lambda r: r.paper.difference):.1f}", ""]
    return sheet(title, header, [*(line(row) for row in result.rows), last])


def _whole(*values) -> list[str]:
    return ["=" if v is True else "" if v is False else str(v) for v in values]


def _mean(values: Iterable[float]) -> float:
    """Return the mean of the finite values; NaN without one."""
    known = [v for v in values if math.isfinite(v)]
    return float(np.mean(known)) if known else math.nan
