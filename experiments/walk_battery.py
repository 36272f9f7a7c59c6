"""Walking with one setting: long, on slopes, tiles and steps, with all bodies and recordings.

What Sec. 5.3 of the pendulum paper shows [Tsai2010]_, with its numbers and those of a feasibility
study beside ours; any controller can be put to it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments import landing_laws, squares, walk_requests
from experiments.altered_people import scaled_legs
from experiments.cached_results import CachedResults, Cases, Result
from experiments.gait_walks import PEOPLE
from experiments.specification import Part, Specification
from experiments.table import Grid, Row, at_least, at_most, equal
from experiments.walk_trial import walk
from experiments.walkers import Walker, walks_as
from experiments.walking import (
    CONTROLLERS,
    figures,
    own_walk,
    person,
    recorded,
    refusal,
    runs,
    summary,
    walking,
)
from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.control.gait.reference import period_of
from plantigrade.kinematics.transfer import transferred
from plantigrade.record import Record
from plantigrade.world import Controller
from plantigrade.world.grounds import ground_named

FLAT_DURATION = 60.0
"""Duration of a walk on level ground [s]."""
LONG_DURATION = 600.0
"""Duration of the long walk [s]."""
SLOPE_DURATION = 20.0
"""Duration of a walk on a slope [s]."""
UNEVEN_DURATION = 14.0
"""Duration of a walk on tiles or over a step [s]."""
BODY_DURATION = 12.0
"""Duration of a walk of another body [s]."""
LOOP_DURATION = 30.0
"""Duration of a repeated recording [s]."""
QUICK_DURATION = 6.0
"""Duration of walks in the short form [s]."""
QUICK_DURATIONS = {"slopes": 9.0, "squares": 8.0}
"""The same of parts that need longer [s]."""
TARGET_DISTANCE = 1e4
"""Distance of the target point of walks on level ground [m]."""
LEVEL_LENGTH = 4.0
"""Length of the level ground before a slope or a step [m]."""
SLOPES = (-15, -10, -5, 5, 10, 15)
TILE_HEIGHTS = (1, 2, 3, 5, 8)  # [cm]
N_SEEDS = 10  # fields of tiles of each height
N_FEW_SEEDS = 3  # in the usual form
STEP_HEIGHT = 10  # [cm] of the single step, up and down
STAIR_HEIGHTS = (5, 10)  # [cm] of each step of a flight of stairs, up and down
STAIRS_DURATION = 8.0  # [s]
LEG_FACTORS = (0.5, 0.75, 1.0, 1.25, 1.5, 2.0)
"""Lengths of the legs, relative to the person's [1]."""
LEG_PERSON = (1.60, 65.0)
"""Stature and mass of that person [m, kg]: with legs twice as long it still is one."""
BODIES = (
    (1.45, 45.0), (1.45, 70.0), (1.60, 55.0), (1.75, 75.0), (1.75, 110.0), (1.95, 75.0),
    (1.95, 110.0),
)  # fmt: skip
OTHER_WALKS = (
    "cmu_asfamc/03_01.amc",
    "cmu_asfamc/131_01.amc",
    "cmu_asfamc/131_12.amc",
    "cmu_bvh/07_01.bvh",
    "cmu_bvh/09_12.bvh",
    "deepmimic/humanoid3d_walk.txt",
    "deepmimic/humanoid3d_stealthy_walk.txt",
    "opensim/gait2392_subject01/normal_gait.mot",
    "opensim/gait2392_subject01/crouch_gait.mot",
)
"""Walks beside those of the experiments on reproduced gait: uneven ground, from standing, turning,
of other formats."""
RECORDINGS = (*(name for names in PEOPLE.values() for name in names), *OTHER_WALKS)
QUICK_WALKS = ("cmu_asfamc/49_01.amc",)
MIN_SPEED = 0.1
"""Lowest speed of a walk; slower recordings stand [m/s]."""
# Goals
MIN_SPEED_SHARE = 0.95  # [1] of the recorded speed
MIN_SLOPE_SPEED_SHARE = 0.6  # [1] of the speed on level ground
MAX_JOINT_RMS = 4.0  # [deg]
MAX_DRIFT = 0.2  # [m] aside in a minute
MIN_WALKED_SHARE = 90.0  # [%]
MIN_TILES_SHARE = {"tiles 3 cm": 100.0, "tiles 5 cm": 90.0}  # [%]
SEVERAL = ("tiles", "stairs", walk_requests.PREFIX)
"""Beginnings of the names of walks of which there are several."""
STUDY = {
    "flat": "60 s, 0.99 m/s of 1.06, RMS 3.5 to 4.1°, 0.25 m aside",
    "slope -15": "1.28 m/s, RMS 8.9°",
    "slope -10": "1.15 m/s, RMS 6.9°",
    "slope -5": "1.09 m/s, RMS 5.0°",
    "slope +5": "0.59 m/s",
    "slope +10": "0.49 m/s",
    "slope +15": "fell at 4 s",
    "tiles 1 cm": "4 of 4",
    "tiles 2 cm": "3 of 4",
    "tiles 3 cm": "4 of 4",
    "tiles 5 cm": "4 of 4",
    "tiles 8 cm": "3 of 4",
    "legs x0.5": "fell",
    "legs x0.75": "0.87 m/s, RMS 5°",
    "legs x1.5": "1.19 m/s, RMS 5°",
    "legs x2": "walks with another setting",
}
PAPER_RESULTS = {
    "slope -15": "walks",
    "slope +15": "walks",
    "legs x0.5": "walks",
    "legs x2": "walks",
}
NOTES = (
    "",
    "One setting of each controller for everything. The walk is that of CMU 16_15, brought over to "
    "a person of 1.75 m and 81.4 kg (angles cached, lengths by the leg, times by its root); legs: "
    "thigh and shank of a person of 1.60 m and 65 kg, mass and feet as they are. Slopes and steps "
    "come after 4 m of level ground; speeds on a slope are horizontal, from 2 s after its foot on. "
    "Tiles are 40 cm wide, of random height up to the number given. The study's slopes began at "
    "once, its uphill speeds suffer from that. Recordings: closed strides are repeated for 30 s, "
    "others are walked once. Stairs (--part stairs): recorded walks on treads of 60 cm, the first "
    "of them 50 cm ahead. Squares (--part squares): closed strides led round corners of 90° "
    "every 4 m for 25 s, to each side. Requests (--part requests): what simulate can be asked for, "
    "drawn at random. RMS: all joints, against the gait at the controller's own "
    "phase.",
)


def flat(controller: str, data: Path | None, seconds: float) -> Result:
    """Return a walk on level ground, led along a line where the controller can be led."""
    one = walking(controller, data)
    return figures(walk(replace(one, make=partial(_led, one)), duration=seconds), since=2.0)


def _led(one: Walker, record: Record) -> Controller:
    """Return a controller that is led along the line of its walk, if it can be."""
    made = one.controller()
    far = one.way / max(float(np.linalg.norm(one.way)), 1e-9)
    if period_of(record)[0] is not None:
        made.follow(TARGET_DISTANCE * far[None])
    return made


def hill(controller: str, data: Path | None, degrees: float, seconds: float) -> Result:
    """Return a walk onto a slope."""
    one = walking(controller, data)
    found = walk(one, ground=ground_named(f"ramp:{degrees}"), duration=seconds)
    on = np.flatnonzero(found.com[:, 0] > LEVEL_LENGTH)
    since = float(found.time[on[0]]) + 2.0 if len(on) else np.inf
    return {**figures(found, since), "level": one.speed, "reached": bool(len(on))}


def uneven(controller: str, data: Path | None, cm: float, seed: int, seconds: float) -> Result:
    """Return a walk over tiles."""
    ground = ground_named(f"tiles:{cm}", seed=seed)
    return figures(walk(walking(controller, data), ground=ground, duration=seconds), since=2.0)


def kerb(controller: str, data: Path | None, cm: float, seconds: float) -> Result:
    """Return a walk over a step."""
    ground = Ground(steps=(GroundStep(LEVEL_LENGTH, 0.01 * cm),))
    return figures(walk(walking(controller, data), ground=ground, duration=seconds), since=2.0)


def stairs(controller: str, data: Path, cm: int, name: str, seconds: float) -> Result:
    """Return a recorded walk on a flight of stairs with treads of 60 cm."""
    one = walks_as(controller, recorded(data / name))
    return figures(walk(one, ground=ground_named(f"steps:{cm}"), duration=seconds), since=2.0)


def legs(controller: str, data: Path | None, times: float, seconds: float) -> Result:
    """Return a walk on other legs."""
    record = transferred(own_walk(data), scaled_legs(person(*LEG_PERSON), times))
    return figures(walk(walks_as(controller, record), duration=seconds), since=2.0)


def body(controller: str, data: Path | None, height: float, mass: float, seconds: float) -> Result:
    """Return a walk of another body."""
    record = transferred(own_walk(data), person(height, mass))
    return figures(walk(walks_as(controller, record), duration=seconds), since=2.0)


def recording(controller: str, data: Path, name: str, seconds: float) -> Result:
    """Return a recorded walk: looped where it is closed, once where it is not.

    Standing trials, spins on one foot and walks that were not recorded on level ground are said to
    be so.
    """
    one = walks_as(controller, recorded(data / name))
    if one.speed < MIN_SPEED:
        return {"left_out": "stands, no walk"}
    if why := refusal(one):
        return {"left_out": why}
    cyclic = period_of(one.record)[0] is not None
    found = walk(one, duration=seconds if cyclic else min(one.period, seconds))
    return {**figures(found, since=1.0), "cyclic": cyclic}


Walks = dict[str, tuple[Callable[..., Result], float, dict[str, tuple[Any, ...]]]]
"""Part → its measurement, duration in the long form [s], and label → further arguments."""


def walks(data: Path | None, quick: bool) -> Walks:
    """Return all walks of the battery."""

    def some(every: Sequence[Any], few: int | Sequence[Any] = 1) -> Sequence[Any]:
        return every if not quick else every[:few] if isinstance(few, int) else few

    def tiles(n: int) -> dict[str, tuple[Any, ...]]:
        seeds = range(1, 2 if quick else n + 1)
        return {
            f"tiles {cm} cm/{seed}": (float(cm), seed)
            for cm in some(TILE_HEIGHTS, (3,))
            for seed in seeds
        }

    there = (
        [] if data is None else [n for n in some(RECORDINGS, QUICK_WALKS) if (data / n).exists()]
    )
    led = [] if data is None else [n for n in some(RECORDINGS) if (data / n).exists()]
    return {
        "flat": (flat, FLAT_DURATION, {"flat": ()}),
        "long": (flat, LONG_DURATION, {"long": ()}),
        "slopes": (
            hill,
            SLOPE_DURATION,
            {f"slope {d:+d}": (float(d),) for d in some(SLOPES, (-10, 10))},
        ),
        "tiles": (uneven, UNEVEN_DURATION, tiles(N_FEW_SEEDS)),
        "all tiles": (uneven, UNEVEN_DURATION, tiles(N_SEEDS)),
        "steps": (
            kerb,
            UNEVEN_DURATION,
            {f"step {cm:+d} cm": (float(cm),) for cm in some((STEP_HEIGHT, -STEP_HEIGHT))},
        ),
        "stairs": (
            stairs,
            STAIRS_DURATION,
            {
                f"stairs {cm:+d} cm/{name}": (cm, name)
                for cm in some([sign * cm for cm in STAIR_HEIGHTS for sign in (1, -1)], (-5,))
                for name in there
                if name not in OTHER_WALKS
            },
        ),
        walk_requests.PREFIX: (
            walk_requests.requested,
            walk_requests.DURATION,
            {
                f"{walk_requests.PREFIX}/{seed}": ([n for n in there if n not in OTHER_WALKS], seed)
                for seed in some(range(walk_requests.N_REQUESTS if there else 0))
            },
        ),
        "legs": (legs, BODY_DURATION, {f"legs x{x:g}": (x,) for x in some(LEG_FACTORS, (0.75,))}),
        "bodies": (
            body,
            BODY_DURATION,
            {f"body {h:g} m {m:g} kg": (h, m) for h, m in some(BODIES)},
        ),
        "recordings": (recording, LOOP_DURATION, {f"recording {name}": (name,) for name in there}),
        "squares": (
            squares.square,
            squares.DURATION,
            {
                f"{squares.PREFIX} {side} {name}": (name, side)
                for name in led
                for side in squares.TURN_SIGNS
            },
        ),
    }


def parts_for(controllers: Sequence[str], data: Path | None) -> dict[str, Part]:
    """Return the parts of the battery for some controllers."""

    def cases(part: str, quick: bool) -> Cases:
        work, duration, every = walks(data, quick)[part]
        duration = QUICK_DURATIONS.get(part, QUICK_DURATION) if quick else duration
        return {
            f"{controller}/{label}/{duration:g} s": partial(work, controller, data, *more, duration)
            for controller in controllers
            for label, more in every.items()
        }

    return {part: partial(cases, part) for part in walks(None, True)} | {
        "laws": lambda quick: landing_laws.cases(quick, data)
    }


def _cells(cached: CachedResults) -> dict[str, dict[str, list[Result]]]:
    """Return results by what was walked and by controller; of some walks there are several."""
    found: dict[str, dict[str, list[Result]]] = {}
    for key, result in cached.longest(failed=True).items():
        name, _, what = key.partition("/")
        line = what.partition("/")[0] if what.startswith(SEVERAL) else what
        found.setdefault(line, {}).setdefault(name, []).append(result)
    return found


def _cell(results: list[Result]) -> str:
    """Return the cell of a walk and a controller."""
    good = [r for r in results if "error" not in r]
    if not good:
        return str(results[0]["error"])[:60] if results else ""
    if len(results) > 1:
        return f"{sum(r['survived'] for r in good)} of {len(results)}"
    return summary(good[0])


def _walked(cells: dict[str, dict[str, list[Result]]]) -> dict[str, dict[str, list[Result]]]:
    """Return all but what compares landing laws."""
    return {k: row for k, row in cells.items() if not k.startswith(landing_laws.PREFIX)}


def grids(cached: CachedResults) -> Iterator[Grid]:
    """Return all walks by controller, with those of the study and the paper; the landing laws."""
    cells = _walked(_cells(cached))
    names = sorted({name for row in cells.values() for name in row})
    lines = [
        [
            k,
            *(_cell(row.get(name, [])) for name in names),
            STUDY.get(k, ""),
            PAPER_RESULTS.get(k, ""),
        ]
        for k, row in cells.items()
    ]
    yield Grid("Walks", ("", *names, "study", "paper"), lines)
    yield landing_laws.grid(_cells(cached))
    yield walk_requests.falls(cached.longest(failed=True))


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures with their goals."""
    yield from landing_laws.rows(_cells(cached))
    cells = _walked(_cells(cached))
    names = sorted({name for row in cells.values() for name in row})
    for name in names:
        mine = {
            what: [r for r in row[name] if "error" not in r]
            for what, row in cells.items()
            if name in row
        }
        level: float | None = None
        for what, found in mine.items():
            every = len(cells[what][name])
            if what in ("flat", "long"):
                for r in found:
                    yield equal(name, f"{what}, falls", int(not r["survived"]), 0)
                    share = r["speed"] / r["asked"]
                    level = r["speed"] if what == "flat" else level
                    yield at_least(name, f"{what}, speed by the recorded", share, MIN_SPEED_SHARE)
                    if r["rms_deg"] is not None:
                        yield at_most(name, f"{what}, joints", r["rms_deg"], MAX_JOINT_RMS, "deg")
                    if r["seconds"] >= LOOP_DURATION:
                        drift = 60.0 * abs(r["aside"]) / r["seconds"]
                        yield at_most(
                            name, f"{what}, drift aside in a minute", drift, MAX_DRIFT, "m"
                        )
            elif what.startswith("slope"):
                for r in found:
                    fine = r["survived"] and r["reached"]
                    share = r["speed"] / (level or r["level"]) if fine else 0.0
                    yield at_least(
                        name,
                        f"{what} deg, speed by that on the level",
                        share,
                        MIN_SLOPE_SPEED_SHARE,
                    )
            elif what.startswith(SEVERAL):
                share = 100.0 * sum(r["survived"] for r in found) / every
                goal = MIN_TILES_SHARE.get(what, None if "tiles" in what else MIN_WALKED_SHARE)
                yield at_least(name, f"{what} walked", share, goal, "%")
            elif not what.startswith(("recording", squares.PREFIX)):
                for r in found:
                    yield equal(name, f"{what}, falls", int(not r["survived"]), 0)
        for kind in ("recording", squares.PREFIX):
            ways = [found for what, found in mine.items() if what.startswith(kind)]
            ways = [found for found in ways if not (found and "left_out" in found[0])]
            if ways:
                walked = sum(bool(found and found[0]["survived"]) for found in ways)
                yield at_least(
                    name, f"{kind}s walked", 100.0 * walked / len(ways), MIN_WALKED_SHARE, "%"
                )


def experiment(controllers: Sequence[str], data: Path | None) -> Specification:
    """Return the experiment for some controllers."""
    return Specification(
        name="walk-battery",
        title="Walking everywhere with one setting",
        parts=parts_for(controllers, data),
        default_parts=("flat", "slopes", "tiles", "steps", "legs", "bodies", "recordings"),
        summary=summary,
        grids=grids,
        rows=rows,
        notes=NOTES,
    )


run = runs(experiment)
EXPERIMENT = experiment(CONTROLLERS, None)
