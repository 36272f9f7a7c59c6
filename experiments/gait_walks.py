"""The walks that reproduced gaits are measured on, by person, and one run over them."""

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plantigrade.analyze.gait_study import Study, study
from plantigrade.analyze.recorded_walk import walk_to_reproduce
from plantigrade.analyze.reproduction import Comparison, compare
from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.ordered_tasks.gait import gait_tasks
from plantigrade.ordered_tasks.reproduced_gait import rebuild
from plantigrade.record import Record
from plantigrade.workflows.fit import fit_trial

# All people of the collection with more than a fragment of a walk on even ground, by name. The
# people of OpenSim's three files are not named; the plates carry 66, 75 and 85 kg.
PEOPLE = {
    "CMU 02": ("cmu_asfamc/02_01.amc", "cmu_asfamc/02_02.amc"),
    "CMU 07": (
        "cmu_asfamc/07_01.amc",
        "cmu_asfamc/07_05.amc",
        "cmu_asfamc/07_08.amc",
        "cmu_asfamc/07_12.amc",
    ),
    "CMU 16": ("cmu_asfamc/16_15.amc", "cmu_asfamc/16_21.amc"),
    "CMU 49": ("cmu_asfamc/49_01.amc",),
    "HC032A": ("c3d/HC032A03.c3d",),
    "HC038A": ("c3d/HC038A11.c3d", "c3d/HC038A27.c3d"),
    "treadmill": ("c3d/gaitalytics_treadmill_events.c3d",),
    "walking2": ("c3d/opensim_walking2.c3d",),
    "gait2392": ("opensim/gait2392_subject01/subject01_walk1.trc",),
    "Rajagopal": ("opensim/rajagopal_walk/markers_walk.trc",),
}
# People on whom the constants of the tasks were settled; the others had no say in them.
SETTLING_PEOPLE = ("CMU 02", "CMU 16", "HC032A", "walking2", "gait2392")
QUICK_PEOPLE = ("CMU 49", "HC032A", "gait2392")  # people of a short form: one walk of each
TURNS = ("c3d/HC038A27.c3d",)  # the person turns in it


@dataclass(frozen=True)
class Walk:
    """A walk (its path below the data) reproduced with a set of tasks, in so many seconds.

    The times of a tick are medians [s]: of the hierarchical program, and with kinematics,
    Jacobians and rows.
    """

    person: str
    name: str
    tasks: str
    record: Record
    comparison: Comparison
    seconds: float
    tick: float
    whole_tick: float

    @property
    def seconds_per_cycle(self) -> float:
        """Time one gait cycle took to reproduce; NaN where there is no whole one."""
        if not self.comparison.cycles:
            return float("nan")
        stride = np.mean([c.duration for c in self.comparison.cycles])
        return self.seconds * float(stride / self.record.motion.duration)


@dataclass(frozen=True)
class Walks:
    """Walks reproduced with one set of tasks, why others could not be, and which are not there."""

    done: list[Walk]
    failed: dict[str, str]
    absent: tuple[str, ...]

    @property
    def any_cycle(self) -> bool:
        """Whether a walk holds a whole gait cycle."""
        return any(walk.comparison.cycles for walk in self.done)

    def half(self, *, settled: bool) -> list[Walk]:
        """Return the walks of whole cycles of the people the constants were settled on, or not."""
        return [
            w for w in self.done if w.comparison.cycles and (w.person in SETTLING_PEOPLE) == settled
        ]

    @property
    def left_out(self) -> list[str]:
        """A sentence for each walk that is not there."""
        return [f"{name} is not there and was left out." for name in self.absent]

    def study(self, *, one_each: bool) -> Study:
        """Return the statistics; of one walk per person, the first by name, or of all.

        Raises:
            ParameterError: If no walk has a whole cycle.
        """
        chosen = [w for w in self.done if w.comparison.cycles]
        if one_each:
            first = {name for name in first_walks(self.absent).values() if name is not None}
            chosen = [w for w in chosen if w.name in first]
        if not chosen:
            raise ParameterError("none of the walks was reproduced over a complete gait cycle")
        names = [w.person if one_each else w.name for w in chosen]
        return study(names, [w.comparison for w in chosen])


def first_walks(absent: Sequence[str] = ()) -> dict[str, str | None]:
    """Return the walk that stands for each person: the first by name of those that are there."""
    return {
        person: next((name for name in sorted(walks) if name not in absent), None)
        for person, walks in PEOPLE.items()
    }


def reproduce_walks(
    data: Path,
    tasks: Sequence[str],
    *,
    people: Sequence[str] | None = None,
    one_each: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> dict[str, Walks]:
    """Fit the walks of some people in a data folder; return them by name of a set of tasks.

    Raises:
        ParameterError: If none of them is there.
    """
    chosen = PEOPLE if people is None else people
    everybody = [(person, name) for person in chosen for name in sorted(PEOPLE[person])]
    absent = tuple(name for _, name in everybody if not (data / name).exists())
    if len(absent) == len(everybody):
        raise ParameterError(f"{data} holds none of the walks ({', '.join(absent)})")
    first = first_walks(absent)
    made = {name: Walks([], {}, absent) for name in tasks}
    for person, name in everybody:
        if name in absent or (one_each and first[person] != name):
            continue
        try:
            reference = walk_to_reproduce(fit_trial(data / name)[1]).reference()
        except PlantigradeError as error:
            for walks in made.values():
                walks.failed[name] = str(error)
            continue
        for one, walks in made.items():
            try:
                began = clock.perf_counter()
                gait = rebuild(reference, gait_tasks(one))
                record = gait.record()
                seconds = clock.perf_counter() - began
                held = compare(record)
            except PlantigradeError as error:
                walks.failed[name] = str(error)
                continue
            solver, other = gait.motion.solver_time, gait.motion.kinematics_time
            ticks = float(np.median(solver)), float(np.median(solver + other))
            walks.done.append(Walk(person, name, one, record, held, seconds, *ticks))
        say(f"{name} done")
    return made
