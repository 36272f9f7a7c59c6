"""Every stride of the recordings as the start of a walk, which should last half a minute.

A walk repeats one stride of a recording, the most even one. Here each stride between two strikes of
the same foot is repeated in turn, also those of turns and changes of speed, which close worst.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.gait_walks import PEOPLE
from experiments.specification import Specification
from experiments.table import Grid, Row, at_least
from experiments.walk_battery import OTHER_WALKS
from experiments.walk_trial import walk
from experiments.walkers import walks_as
from experiments.walking import (
    CONTROLLERS,
    figures,
    recorded,
    refusal,
    runs,
    summary,
)
from plantigrade.control.gait.reference import period_of
from plantigrade.motion.cycles import cut_cycles
from plantigrade.record import Record
from plantigrade.spatial.conventions import quaternion_to_pelvis_angles

DURATION = 30.0
"""Duration of a walk [s]."""
QUICK_DURATION = 5.0
"""Duration of a walk in the short form [s]."""
MIN_SPEED = 0.3
"""Least speed of a stride: slower ones shift weight or turn on the spot, and lead nowhere [m/s].
Chosen."""
FORWARD = 45.0
"""Greatest angle between the way of a stride and the heading of the pelvis for one that leads
forward [deg]: half way to sideways."""
MIN_LASTING_SHARE = 95.0
"""Goal: share of strides whose walk lasts [%]."""
PARTS = {
    "people": tuple(name for names in PEOPLE.values() for name in names),
    "others": OTHER_WALKS,
}
"""Part → its recordings: walks of the experiments on gait, straight and turning; uneven ground,
starts from standing, turns, and walks in all directions, in other formats."""
QUICK_WALKS = {"people": ("cmu_asfamc/07_01.amc",), "others": ()}
NOTES = (
    "",
    f"Every gait cycle of a recording, of both feet, is closed and repeated for {DURATION:g} s on "
    "level ground, from where one foot passes the other. Lasted: only the feet touched the ground, "
    "and no leg passed through the other. Left out, and counted apart: strides whose ends differ "
    f"too much to be closed, strides slower than {MIN_SPEED:g} m/s, and recordings of uneven "
    f"ground. Forward: without strides that lead more than {FORWARD:g}° away from the pelvis.",
)


def strides(record: Record) -> list[Record]:
    """Return a record for each gait cycle, whose events are those of the cycle alone."""
    motion = record.motion
    return [
        replace(
            record,
            motion=replace(
                motion,
                events=tuple(e for e in motion.events if cycle.start <= e.time <= cycle.stop),
            ),
        )
        for cycle in cut_cycles(motion.events)
    ]


def start(controller: str, data: Path, name: str, number: int, seconds: float) -> Result:
    """Return the walk that repeats a stride.

    Args:
        controller: Word of the controller.
        data: Folder of recordings.
        name: Path of the recording below it.
        number: Number of the stride, from 0.
        seconds: Duration of the walk [s].
    """
    stride = strides(recorded(data / name))[number]
    one = walks_as(controller, stride)
    if period_of(one.record)[0] is None:
        return {"left_out": "the stride does not close"}
    if one.speed < MIN_SPEED:
        return {"left_out": f"slower than {MIN_SPEED:g} m/s"}
    if why := refusal(one):
        return {"left_out": why}
    forward = bool(_way_by_pelvis(one.record) < np.deg2rad(FORWARD))
    return {**figures(walk(one, duration=seconds), since=2.0), "forward": forward}


def _way_by_pelvis(walk: Record) -> float:
    """Return the angle between the way of a closed stride, along x, and the mean heading [rad]."""
    heading = quaternion_to_pelvis_angles(walk.motion.qpos[:, 3:7])[:, 2]
    return float(abs(np.angle(np.exp(1j * heading).mean())))


def _cases(part: str, controllers: Sequence[str], data: Path | None, quick: bool) -> Cases:
    if data is None:
        return {}
    names = [n for n in (QUICK_WALKS if quick else PARTS)[part] if (data / n).exists()]
    numbers = {n: 1 if quick else len(cut_cycles(recorded(data / n).motion.events)) for n in names}
    seconds = QUICK_DURATION if quick else DURATION
    return {
        f"{part}/{controller}/{name}/{k}/{seconds:g} s": partial(
            start, controller, data, name, k, seconds
        )
        for controller in controllers
        for name in names
        for k in range(numbers[name])
    }


def _starts(cached: CachedResults) -> dict[tuple[str, str], dict[str, list[Result]]]:
    """Return the results by part and controller, then by recording."""
    found: dict[tuple[str, str], dict[str, list[Result]]] = {}
    strides = (each for part in PARTS for each in cached.longest(part).items())
    for stride, result in strides:
        part, controller, rest = stride.split("/", 2)
        name = rest.rpartition("/")[0]
        found.setdefault((part, controller), {}).setdefault(name, []).append(result)
    return found


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return how many strides there are, and the share of those whose walk lasts."""
    found: dict[str, list[Result]] = {}
    for (part, controller), recordings in _starts(cached).items():
        every = [r for results in recordings.values() for r in results]
        found.setdefault(f"{controller}, {part}", []).extend(every)
        found.setdefault(f"{controller}, all", []).extend(every)
    for subject, every in found.items():
        walked = [r for r in every if "left_out" not in r]
        yield Row(subject, "strides", float(len(every)))
        yield Row(subject, "left out", float(len(every) - len(walked)))
        if walked:
            yield at_least(subject, "lasted", _lasted(walked), MIN_LASTING_SHARE, "%")
        if forward := [r for r in walked if r["forward"]]:
            yield Row(subject, "lasted, forward", _lasted(forward), "%")


def _lasted(walked: Sequence[Result]) -> float:
    """Return the share of walks that lasted [%]."""
    return 100.0 * sum(bool(r["survived"]) for r in walked) / len(walked)


def grids(cached: CachedResults) -> Iterator[Grid]:
    """Return the strides of every recording: how many lasted, and how the others ended."""
    for (part, controller), recordings in _starts(cached).items():
        lines = []
        for name, results in recordings.items():
            walked = [r for r in results if "left_out" not in r]
            fell = [str(r["end"]) for r in walked if not r["survived"]]
            out = [str(r["left_out"]) for r in results if "left_out" in r]
            apart = [f"{out.count(why)}: {why}" for why in dict.fromkeys(out)]
            lasted = f"{len(walked) - len(fell)} of {len(walked)}"
            lines.append([name, lasted, "; ".join(apart), "; ".join(fell)])
        header = ("", "lasted", "left out", "ends of the others")
        yield Grid(f"Strides as starts: {controller}, {part}", header, lines)


def experiment(controllers: Sequence[str], data: Path | None) -> Specification:
    """Return the experiment for some controllers."""
    return Specification(
        name="walk-starts",
        title="Every recorded stride as a start",
        parts={part: partial(_cases, part, controllers, data) for part in PARTS},
        summary=summary,
        grids=grids,
        rows=rows,
        notes=NOTES,
    )


run = runs(experiment)
EXPERIMENT = experiment(CONTROLLERS, None)
