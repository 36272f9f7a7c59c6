"""The pushes that people took while walking, given to a simulated person.

626 lateral pushes at the upper arm of 29 adults, published with the program DeepPushRecovery
(github snumrl/DeepPushRecovery, Apache-2.0): each is given to a person of that height and mass who
walks at that speed, at that phase, with that force.
"""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

from experiments.cached_results import CachedResults, Result
from experiments.specification import Cases
from experiments.table import Row, at_least
from experiments.walk_outcome import WalkOutcome
from experiments.walk_trial import walk
from experiments.walkers import walker, walks_as
from experiments.walking import recorded
from plantigrade.errors import FileError
from plantigrade.kinematics.transfer import leg_length, transferred
from plantigrade.models import Human
from plantigrade.record import Record
from plantigrade.world import PhasePush

FILE = "pushes/human-data.csv"
N_PUSHES = 26
"""Number of pushes, spread evenly over all."""
N_QUICK_PUSHES = 2
"""Number of pushes in the short form."""
WALKS = (
    "cmu_asfamc/49_01.amc",
    "cmu_asfamc/07_05.amc",
    "cmu_asfamc/16_15.amc",
    "cmu_asfamc/02_01.amc",
    "cmu_asfamc/07_01.amc",
)
"""Walks of 0.85 to 1.4 m/s; the one nearest to a speed is taken."""
MAX_SPEED_FACTOR = 1.25
"""Greatest factor of a walk's speed [1]."""
MIN_SPEED_FACTOR = 0.75
"""Least factor of a walk's speed [1]."""
MIN_SURVIVAL_SHARE = 95.0  # goal: share of pushes survived [%]
COLUMNS = (
    "height", "weight", "sex", "actual_speed", "push_force_not_normalized", "push_duration",
    "push_direction", "push_start", "crouch", "maximal_detour_distance", "detour_first_step",
    "maximal_detour_step",
)  # fmt: skip


@dataclass(frozen=True)
class Pushed:
    """A push that somebody took.

    Attributes:
        number: Of the row.
        height: Of the person [m].
        mass: Of the person [kg].
        sex: Of the person.
        speed: Walking speed [m/s].
        force: Mean force [N]: impulse over duration.
        duration: How long it lasted [s].
        side: The side it came from, that of the foot that stood.
        phase: When it began, of the cycle of that foot.
        crouch: Whether the person was told to crouch.
        detour: Greatest lateral displacement [m].
        first: Lateral displacement at the first step after the push [m].
        step: Number of the step of the greatest displacement.
    """

    number: int
    height: float
    mass: float
    sex: str
    speed: float
    force: float
    duration: float
    side: str
    phase: float
    crouch: bool
    detour: float
    first: float
    step: float


@cache
def pushes(path: Path) -> tuple[Pushed, ...]:
    """Return the pushes of the table.

    The unit of ``push_force_not_normalized``, N s, is inferred: over ``push_duration`` it gives the
    172 N of the publication. Its start is a percentage of the step, half a cycle, from the strike
    of the foot that stands, which is that of the side the push comes from: so the program that is
    published beside the table has it.

    Raises:
        FileError: If the table cannot be read.
    """
    found = []
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            for k, row in enumerate(csv.DictReader(lines)):
                value = {name: float(row[name]) for name in COLUMNS}
                duration = value["push_duration"]
                sex = "male" if value["sex"] == 1 else "female"
                side = "l" if value["push_direction"] == 1 else "r"
                push = value["push_force_not_normalized"] / duration, duration, side
                detour, first = (value[name] / 1000.0 for name in COLUMNS[9:11])
                found.append(
                    Pushed(k, value["height"] / 100.0, value["weight"], sex,
                           value["actual_speed"] / 1000.0, *push,
                           (value["push_start"] / 200.0) % 1.0, value["crouch"] > 0,
                           detour, first, value["maximal_detour_step"])
                )  # fmt: skip
    except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError) as error:
        raise FileError(path, f"holds no table of pushes ({error!r})") from error
    return tuple(found)


def walk_at(data: Path, human: Human, speed: float) -> Record:
    """Return the recorded walk that is nearest to a speed on a body, made as fast as it can be."""

    def of(name: str) -> tuple[float, Record, float]:
        record = recorded(data / name)
        own = walker("pendulum", record).speed
        own *= float(np.sqrt(leg_length(human) / leg_length(record.human)))
        return abs(np.log(own / speed)), record, own

    _, record, own = min((of(name) for name in WALKS), key=lambda each: each[0])
    return transferred(
        record, human, faster=float(np.clip(speed / own, MIN_SPEED_FACTOR, MAX_SPEED_FACTOR))
    )


def give(controller: str, data: Path, pushed: Pushed) -> Result:
    """Return the outcome of a push of a simulated person."""
    human = Human.create(pushed.height, pushed.mass, pushed.sex)  # pyright: ignore[reportArgumentType]
    one = walks_as(controller, walk_at(data, human, pushed.speed))
    towards = -1.0 if pushed.side == "l" else 1.0
    push = PhasePush(
        force=pushed.force,
        duration=pushed.duration,
        direction=towards * np.pi / 2,
        side=pushed.side,
        phase=pushed.phase,
    )
    found = walk(one, (push,))
    detour, first, step = aside(found, towards)
    return {
        "survived": found.survived,
        "withstood": found.withstood,
        "end": found.end,
        "detour": detour,
        "first": first,
        "step": step,
        "people": [pushed.detour, pushed.first, pushed.step],
        "speed": [one.speed, pushed.speed],
        "impulse": pushed.force * pushed.duration,
        "change": pushed.force * pushed.duration / pushed.mass,
        "crouch": pushed.crouch,
    }


def aside(found: WalkOutcome, towards: float) -> tuple[float, float, float]:
    """Return the lateral displacement by a push: the greatest, at the first step, and when.

    It is measured from the mean position in the stride before.

    Returns:
        The greatest distance [m], that at the first landing after the push began [m], and the
        number of the step in which it was greatest; NaN where nobody was pushed.
    """
    if found.pushed is None or not len(found.time):
        return float("nan"), float("nan"), float("nan")
    begin = found.pushed[0]
    before = (found.time > begin - found.period) & (found.time <= begin)
    after = found.time > begin
    if not before.any() or not after.any():
        return float("nan"), float("nan"), float("nan")
    off = towards * (found.com[after, 1] - found.com[before, 1].mean())
    time, k = found.time[after], int(np.argmax(off))
    strikes = [x.time for x in found.landings if x.time > begin]
    first = float(off[np.searchsorted(time, strikes[0])]) if strikes else float("nan")
    return float(off[k]), first, float(1 + sum(t < time[k] for t in strikes))


def people_cases(
    controllers: Sequence[str], data: Path | None, most: int | None, quick: bool
) -> Cases:
    """Return so many pushes, evenly out of all; all where no number is given."""
    if data is None or not (data / FILE).exists():
        return {}
    every = pushes(data / FILE)
    n = N_QUICK_PUSHES if quick else len(every) if most is None else most
    some = [every[round(k * (len(every) - 1) / max(n - 1, 1))] for k in range(n)]
    return {
        f"people/{controller}/{pushed.number}": partial(give, controller, data, pushed)
        for controller in controllers
        for pushed in some
    }


def pushed_summary(result: Result) -> str:
    """Return one line about a pushed person."""
    if not result["survived"]:
        return str(result["end"])
    people = 100 * result["people"][0]
    back = "" if result["withstood"] else ", not back to the gait"
    return f"{100 * result['detour']:.0f} cm aside, the person {people:.0f} cm{back}"


def _found(cached: CachedResults) -> dict[str, list[Result]]:
    found: dict[str, list[Result]] = {}
    for key, result in cached.select("people").items():
        found.setdefault(key.split("/", 1)[1].rsplit("/", 1)[0], []).append(result)
    return found


def _paired(results: Sequence[Result], name: str, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Return ours and the people's, of those who survived."""
    pairs = [(r[name], r["people"][k]) for r in results if r["survived"] and r[name] is not None]
    both = np.array(pairs, dtype=float).reshape(-1, 2)
    return both[:, 0], both[:, 1]


def people_rows(cached: CachedResults) -> Iterator[Row]:
    """Return the share that survived; detours and steps, and those of the people."""
    for controller, results in _found(cached).items():
        subject = f"{controller} pushes of people"
        share = 100.0 * sum(r["survived"] for r in results) / len(results)
        yield at_least(subject, "survived", share, MIN_SURVIVAL_SHARE, "%")
        back = 100.0 * sum(r["withstood"] for r in results) / len(results)
        yield Row(subject, "back to the gait", back, "%")
        for name, k, quantity, unit in (
            ("detour", 0, "detour", "m"),
            ("first", 1, "aside at the first step", "m"),
            ("step", 2, "farthest in step", ""),
        ):
            ours, theirs = _paired(results, name, k)
            if len(ours):
                yield Row(subject, quantity, float(ours.mean()), unit)
                yield Row(subject, f"{quantity}, SD", float(ours.std()), unit)
                yield Row(subject, f"{quantity}, people", float(theirs.mean()), unit)
                yield Row(subject, f"{quantity}, people, SD", float(theirs.std()), unit)
        speed = np.array([r["speed"] for r in results])
        error = 100.0 * float(np.abs(speed[:, 0] / speed[:, 1] - 1).max())
        yield Row(subject, "speed error, most", error, "%")
