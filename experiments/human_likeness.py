"""Likeness of simulated walks to the people who were recorded: forces, moments, posture, steps.

Every recorded walk is simulated for ten seconds by a controller and compared with the recording and
its measured or estimated forces.
"""

from collections.abc import Iterator, Sequence
from functools import cache, partial
from pathlib import Path

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.gait_walks import PEOPLE, TURNS
from experiments.specification import Specification
from experiments.table import Grid, Row, text_of
from experiments.walk_measures import differences, measures, vertical_force
from experiments.walk_trial import world_of
from experiments.walkers import walks_as
from experiments.walking import CONTROLLERS, runs
from plantigrade.analyze.trial import CUTOFF, Trial, analyse
from plantigrade.threads import on_one_thread
from plantigrade.workflows.fit import fit_trial

CALIBRATION_PEOPLE = ("CMU 07", "CMU 16", "HC032A", "HC038A", "walking2")
"""People on whose walks constants of controllers are settled; those of the others are reported."""
HALVES = ("calibration", "validation")
QUICK_WALKS = {"calibration": ("c3d/HC032A03.c3d",), "validation": ("cmu_asfamc/02_01.amc",)}
"""Walks of the short form."""
DURATION = 10.0
"""Duration of a walk [s]."""
SETTLING_TIME = 3.0
"""Time from which its gait cycles count [s]."""
FORCE_CUTOFF = 20.0  # [Hz] keeps the transient of a heel strike
GOALS = {
    "com_height": ("height of the centre of mass", "cm", 0.0, 1.0, 100.0),
    "com_excursion_ratio": ("excursion of the centre of mass", "%", 1.0, 15.0, 100.0),
    "knee_at_strike": ("knee at strike", "deg", 0.0, 6.0, 1.0),
    "least_knee": ("least knee flexion", "deg", 0.0, 6.0, 1.0),
    "first_peak_ratio": ("first force peak", "%", 1.0, 15.0, 100.0),
    "trough_ratio": ("force trough", "%", 1.0, None, 100.0),
    "second_peak_ratio": ("second force peak", "%", 1.0, None, 100.0),
    "ankle_moment_peak_ratio": ("ankle moment peak", "%", 1.0, 15.0, 100.0),
    "knee_moment_peak_ratio": ("knee moment peak", "%", 1.0, None, 100.0),
    "hip_moment_peak_ratio": ("hip moment peak", "%", 1.0, None, 100.0),
    "trunk": ("trunk lean", "deg", 0.0, 3.0, 1.0),
    "head": ("head lean", "deg", 0.0, 3.0, 1.0),
    "trunk_range": ("range of trunk lean in a cycle", "deg", 0.0, 3.0, 1.0),
    "head_range": ("range of head lean in a cycle", "deg", 0.0, 3.0, 1.0),
    "double_support": ("double support", "% of the cycle", 0.0, None, 1.0),
    "step_width": ("step width", "cm", 0.0, None, 100.0),
}
"""Difference → what it is, its unit, its value in the recording, its goal, factor to the unit."""
MAX_RAW_PEAK = 2.5
"""Goal of the greatest unfiltered force on a foot [BW]."""
MIN_ANKLE_R = 0.92
"""Goal of the correlation of ankle moments [1]."""
SD = {
    "first_peak_sd": "first force peak",
    "trough_sd": "force trough",
    "second_peak_sd": "second force peak",
    "knee_at_strike_sd": "knee at strike",
    "ankle_moment_sd": "ankle moment peak",
    "knee_moment_sd": "knee moment peak",
    "hip_moment_sd": "hip moment peak",
    "double_support_sd": "double support",
}
"""Difference in percent of people's SD → what differs."""
NOTES = (
    "",
    f"Walks of {DURATION:g} s on level ground, cycles from {SETTLING_TIME:g} s on. Vertical "
    f"forces of a foot, measured and simulated, after a filter of {FORCE_CUTOFF:g} Hz; where they "
    f"can only be estimated, both after one of {CUTOFF:g} Hz. The raw peak is the largest of all "
    f"frames, at 100 Hz. Moments after a filter of {CUTOFF:g} Hz. Constants of controllers are "
    f"settled on the walks of {', '.join(CALIBRATION_PEOPLE)}; those of the other people are "
    "reported. SD: between adults of the knee angle, between children at a free speed of all "
    "else. Medians are of absolute differences.",
)


def walks_of_half(half: str, *, quick: bool) -> Sequence[str]:
    """Return the paths of the walks of a half below the data, or those of the short form."""
    if quick:
        return QUICK_WALKS[half]
    people = [p for p in PEOPLE if (p in CALIBRATION_PEOPLE) == (half == HALVES[0])]
    return [name for p in people for name in PEOPLE[p] if name not in TURNS]


@cache
def _trial(path: Path) -> Trial:
    return fit_trial(path)[1]


@cache
def _recorded(path: Path) -> Result:
    """Return the measures of a recording, its forces by plates where there are some."""
    trial = _trial(path)
    found: Result = {**measures(trial.record()), "force_cutoff": CUTOFF}
    measured = analyse(trial.fit, cutoff=FORCE_CUTOFF).measured if trial.measured else None
    peaks = {} if measured is None else vertical_force(measured)
    if peaks and np.isfinite(list(peaks.values())).all():
        found |= {**peaks, "force_cutoff": FORCE_CUTOFF}
    return found


@on_one_thread
def likeness(controller: str, data: Path, name: str) -> Result:
    """Return the measures of a walk, those of its recording, and their differences.

    Args:
        controller: Word of the controller.
        data: Folder of recordings.
        name: Path of the recording below it.
    """
    walker = walks_as(controller, _trial(data / name).record())
    moved_by = walker.controller()
    world = world_of(walker, moved_by, recording=True)
    record = world.simulate(moved_by, DURATION, after_fall=0.0)
    if world.fall is not None or world.diverged is not None:
        return {"survived": False, "end": str(world.fall or "diverged")}
    recorded = _recorded(data / name)
    own: Result = measures(record, since=SETTLING_TIME, force_cutoff=recorded["force_cutoff"])
    own["peak_20_hz"] = max(vertical_force(record, FORCE_CUTOFF).values())
    found = differences(own, recorded)
    return {"survived": True, "own": own, "recorded": recorded, "differences": found}


def _cases(half: str, controllers: Sequence[str], data: Path | None, quick: bool) -> Cases:
    if data is None:
        return {}
    there = [n for n in walks_of_half(half, quick=quick) if (data / n).exists()]
    return {
        f"{half}/{controller}/{name}": partial(likeness, controller, data, name)
        for controller in controllers
        for name in there
    }


def _groups(cached: CachedResults) -> Iterator[tuple[str, list[Result]]]:
    """Return the results of each controller and half, with the name of the walk."""
    found: dict[str, list[Result]] = {}
    for half in HALVES:
        for key, result in cached.select(half).items():
            _, controller, name = key.split("/", 2)
            found.setdefault(f"{controller}, {half}", []).append({**result, "name": name})
    yield from found.items()


def _median(walked: Sequence[Result], name: str, expected: float = 0.0) -> float | None:
    """Return the median of the absolute differences from what is expected."""
    found = [r["differences"][name] for r in walked]
    found = [abs(x - expected) for x in found if x is not None]
    return float(np.median(found)) if found else None


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the medians over walks with their goals, which count on the validation half."""
    for subject, results in _groups(cached):
        walked, judged = [r for r in results if r["survived"]], subject.endswith(HALVES[1])
        yield Row(subject, "walks that fell", float(len(results) - len(walked)))
        if not walked:
            continue
        for name, (words, unit, expected, goal, factor) in GOALS.items():
            value = _median(walked, name, expected)
            value = None if value is None else factor * value
            met = None if goal is None or value is None or not judged else value <= goal
            yield Row(subject, words, value, unit, f"<= {goal:g}" if goal and judged else "", met)
        for name in ("ankle", "knee", "hip"):
            value = _median(walked, f"{name}_moment_r")
            goal = MIN_ANKLE_R if name == "ankle" and judged else None
            met = None if goal is None or value is None else value >= goal
            yield Row(subject, f"{name} moment, r", value, "", f">= {goal}" if goal else "", met)
        value = _median(walked, "raw_peak")
        met = value is not None and value <= MAX_RAW_PEAK if judged else None
        goal = f"<= {MAX_RAW_PEAK}" if judged else ""
        yield Row(subject, "raw force peak", value, "BW", goal, met)
        for name, words in SD.items():
            yield Row(subject, f"{words} by SD", _median(walked, name), "%")


COLUMNS = (
    ("peak BW", "peak_20_hz", 2, 1.0),
    ("first peak", "first_peak", 2, 1.0),
    ("trough", "trough", 2, 1.0),
    ("second", "second_peak", 2, 1.0),
    ("raw", "raw_peak", 1, 1.0),
    ("knee at strike deg", "knee_at_strike", 0, 1.0),
    ("least knee", "least_knee", 0, 1.0),
    ("CoM cm", "com_height", 1, 100.0),
    ("excursion", "com_excursion", 1, 100.0),
    ("trunk deg", "trunk", 1, 1.0),
    ("head", "head", 1, 1.0),
    ("trunk range", "trunk_range", 0, 1.0),
    ("head range", "head_range", 0, 1.0),
    ("double support %", "double_support", 0, 1.0),
    ("step width cm", "step_width", 1, 100.0),
)
"""Header → measure that is shown beside the recorded one, digits, factor."""
RATIOS = ("ankle", "knee", "hip")


def grids(cached: CachedResults) -> Iterator[Grid]:
    """Return every walk beside its recording."""
    for subject, results in _groups(cached):
        header = ("", *(c[0] for c in COLUMNS), *(f"{j} r, peak" for j in RATIOS))
        lines = []
        for r in results:
            if not r["survived"]:
                lines.append([r["name"], str(r["end"]), *[""] * (len(header) - 2)])
                continue
            cells = [
                "/".join(
                    text_of(None if v is None else factor * v, digits)
                    for v in (r["own"][name], r["recorded"].get(name))
                )
                for _, name, digits, factor in COLUMNS
            ]
            found = r["differences"]
            for joint in RATIOS:
                ratio = text_of(found[f"{joint}_moment_peak_ratio"], 2)
                cells.append(f"{text_of(found[f'{joint}_moment_r'], 2)} ×{ratio}")
            lines.append([r["name"].rpartition("/")[2], *cells])
        yield Grid(f"Simulated/recorded: {subject}", header, lines)


def summary(result: Result) -> str:
    """Return one line about a walk."""
    if not result["survived"]:
        return str(result["end"])
    found, own = result["differences"], result["own"]
    return (
        f"first peak {text_of(own['first_peak'], 2)} BW, raw {text_of(own['raw_peak'], 1)} BW, "
        f"knee at strike {text_of(found['knee_at_strike'])}° more, "
        f"height {text_of(100.0 * found['com_height'])} cm more, "
        f"ankle r {text_of(found['ankle_moment_r'], 2)}"
    )


def experiment(controllers: Sequence[str], data: Path | None) -> Specification:
    """Return the experiment for some controllers."""
    return Specification(
        name="human-likeness",
        title="Walks beside the people who were recorded",
        parts={half: partial(_cases, half, controllers, data) for half in HALVES},
        summary=summary,
        grids=grids,
        rows=rows,
        notes=NOTES,
    )


run = runs(experiment)
EXPERIMENT = experiment(CONTROLLERS, None)
