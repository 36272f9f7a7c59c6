"""One frozen setting walks everywhere: long, on slopes, tiles and steps, on all bodies and walks.

What Sec. 5.3 of the pendulum paper shows [Tsai2010]_, with its numbers and those of a feasibility
study beside ours; any controller can be put to it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments import landing_laws, squares
from experiments.gait_walks import PEOPLE
from experiments.kept_results import KeptResults, Result
from experiments.measured import Cases, Measured
from experiments.page import Grid
from experiments.table import Row, at_least, at_most, equal
from experiments.walking import (
    CONTROLLERS,
    brief,
    figures,
    own_walk,
    person,
    recorded,
    runs,
    walking,
)
from plantigrade.contact.ground import Ground, Step
from plantigrade.control.gait.reference import period_of
from plantigrade.errors import ParameterError
from plantigrade.record import Record
from plantigrade.workflows.harness import walk
from plantigrade.workflows.other_bodies import on_body, with_legs
from plantigrade.workflows.walkers import Walker, walks_as
from plantigrade.world import Controller
from plantigrade.world.grounds import ground_named

FLAT, LONG, HILL, UNEVEN, OTHER, LOOPED = 60.0, 600.0, 20.0, 14.0, 12.0, 30.0
"""How long walks last: level, long, on slopes, on tiles and steps, on other bodies, looped [s]."""
SHORT = 6.0
"""And in the short form [s]."""
FAR = 1e4
"""So far on is the point that walks on level ground are led to [m]."""
LEVEL = 4.0
"""So much level ground comes before a slope or a step [m]."""
SLOPES = (-15, -10, -5, 5, 10, 15)
TILES, SEEDS, FEW = (1, 2, 3, 5, 8), 10, 3
STEP = 10
LEGS, SMALL = (0.5, 0.75, 1.0, 1.25, 1.5, 2.0), (1.60, 65.0)
"""Times a leg is as long, and whose it is [m, kg]: with twice its legs it is a person still."""
BODIES = (
    (1.45, 45.0), (1.45, 70.0), (1.60, 55.0), (1.75, 75.0), (1.75, 110.0), (1.95, 75.0),
    (1.95, 110.0),
)  # fmt: skip
MORE = (
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
RECORDINGS = (*(name for names in PEOPLE.values() for name in names), *MORE)
QUICK = ("cmu_asfamc/49_01.amc",)
STANDS = 0.1
"""Who is slower does not walk [m/s]."""
KEEP, SLOWEST, RMS, DRIFT, SHARE = 0.95, 0.6, 4.0, 0.2, 90.0  # goals: speeds, [deg], [m], [%]
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
PAPER = {"slope -15": "walks", "slope +15": "walks", "legs x0.5": "walks", "legs x2": "walks"}
NOTES = (
    "",
    "One setting of each controller for everything. The walk is that of CMU 16_15, brought over to "
    "a person of 1.75 m and 81.4 kg (angles kept, lengths by the leg, times by its root); legs: "
    "thigh and shank of a person of 1.60 m and 65 kg, mass and feet as they are. Slopes and steps "
    "come after 4 m of level ground; speeds on a slope are horizontal, from 2 s after its foot on. "
    "Tiles are 40 cm wide, of random height up to the number given. The study's slopes began at "
    "once, its uphill speeds suffer from that. Recordings: closed strides are repeated for 30 s, "
    "others are walked once. Squares (--part squares): closed strides led round corners of 90° "
    "every 4 m for 25 s, to each side. RMS: all joints, against the gait at the controller's own "
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
        made.follow(FAR * far[None])
    return made


def hill(controller: str, data: Path | None, degrees: float, seconds: float) -> Result:
    """Return a walk onto a slope."""
    one = walking(controller, data)
    found = walk(one, ground=ground_named(f"ramp:{degrees}"), duration=seconds)
    on = np.flatnonzero(found.com[:, 0] > LEVEL)
    since = float(found.time[on[0]]) + 2.0 if len(on) else np.inf
    return {**figures(found, since), "level": one.speed, "reached": bool(len(on))}


def uneven(controller: str, data: Path | None, cm: float, seed: int, seconds: float) -> Result:
    """Return a walk over tiles."""
    ground = ground_named(f"tiles:{cm}", seed=seed)
    return figures(walk(walking(controller, data), ground=ground, duration=seconds), since=2.0)


def kerb(controller: str, data: Path | None, cm: float, seconds: float) -> Result:
    """Return a walk over a step."""
    ground = Ground(steps=(Step(LEVEL, 0.01 * cm),))
    return figures(walk(walking(controller, data), ground=ground, duration=seconds), since=2.0)


def legs(controller: str, data: Path | None, times: float, seconds: float) -> Result:
    """Return a walk on other legs."""
    record = on_body(own_walk(data), with_legs(person(*SMALL), times))
    return figures(walk(walks_as(controller, record), duration=seconds), since=2.0)


def body(controller: str, data: Path | None, height: float, mass: float, seconds: float) -> Result:
    """Return a walk of another body."""
    record = on_body(own_walk(data), person(height, mass))
    return figures(walk(walks_as(controller, record), duration=seconds), since=2.0)


def recording(controller: str, path: Path, seconds: float) -> Result:
    """Return a recorded walk: looped where it is closed, once where it is not.

    Standing trials, and walks that were not recorded on level ground, are said to be so.
    """
    one = walks_as(controller, recorded(path))
    if one.speed < STANDS:
        return {"left_out": "stands, no walk"}
    try:
        one.controller()
    except ParameterError as error:
        if "level ground" not in str(error):
            raise
        return {"left_out": "was recorded on uneven ground"}
    cyclic = period_of(one.record)[0] is not None
    found = walk(one, duration=seconds if cyclic else min(one.period, seconds))
    return {**figures(found, since=1.0), "cyclic": cyclic}


def parts_for(controllers: Sequence[str], data: Path | None) -> dict[str, Callable[[bool], Cases]]:
    """Return the parts of the battery for some controllers."""

    def every(
        make: Callable[[bool], dict[str, tuple[Callable[..., Result], tuple[Any, ...]]]],
    ) -> Callable[[bool], Cases]:
        def cases(quick: bool) -> Cases:
            return {
                f"{controller}/{key}": partial(work, controller, *items)
                for controller in controllers
                for key, (work, items) in make(quick).items()
            }

        return cases

    def seconds(long: float, quick: bool) -> float:
        return SHORT if quick else long

    def spelled(what: str, long: float, quick: bool) -> str:
        return f"{what}/{seconds(long, quick):g} s"

    def slopes(quick: bool) -> dict[str, Any]:
        long = HILL if not quick else 9.0
        return {
            f"slope {d:+d}/{long:g} s": (hill, (data, float(d), long))
            for d in ((-10, 10) if quick else SLOPES)
        }

    def tiles(quick: bool, seeds: int = FEW) -> dict[str, Any]:
        return {
            spelled(f"tiles {cm} cm/{seed}", UNEVEN, quick): (
                uneven,
                (data, float(cm), seed, seconds(UNEVEN, quick)),
            )
            for cm in ((3,) if quick else TILES)
            for seed in range(1, 2 if quick else seeds + 1)
        }

    def recordings(quick: bool) -> dict[str, Any]:
        if data is None:
            return {}
        return {
            spelled(f"recording {name}", LOOPED, quick): (
                recording,
                (data / name, seconds(LOOPED, quick)),
            )
            for name in (QUICK if quick else RECORDINGS)
            if (data / name).exists()
        }

    return {
        "flat": every(
            lambda quick: {spelled("flat", FLAT, quick): (flat, (data, seconds(FLAT, quick)))}
        ),
        "long": every(
            lambda quick: {spelled("long", LONG, quick): (flat, (data, seconds(LONG, quick)))}
        ),
        "slopes": every(slopes),
        "tiles": every(tiles),
        "all tiles": every(partial(tiles, seeds=SEEDS)),
        "steps": every(
            lambda quick: {
                spelled(f"step {cm:+d} cm", UNEVEN, quick): (
                    kerb,
                    (data, float(cm), seconds(UNEVEN, quick)),
                )
                for cm in ((STEP,) if quick else (STEP, -STEP))
            }
        ),
        "legs": every(
            lambda quick: {
                spelled(f"legs x{times:g}", OTHER, quick): (
                    legs,
                    (data, times, seconds(OTHER, quick)),
                )
                for times in ((0.75,) if quick else LEGS)
            }
        ),
        "bodies": every(
            lambda quick: {
                spelled(f"body {h:g} m {m:g} kg", OTHER, quick): (
                    body,
                    (data, h, m, seconds(OTHER, quick)),
                )
                for h, m in (BODIES[:1] if quick else BODIES)
            }
        ),
        "recordings": every(recordings),
        "squares": every(lambda quick: squares.cases(quick, data, RECORDINGS)),
        "laws": lambda quick: landing_laws.cases(quick, data),
    }


def _cells(kept: KeptResults) -> dict[str, dict[str, list[Result]]]:
    """Return results by what was walked and by controller: of seeds there are several.

    Where a walk was done for a short and for a long time, the long one counts.
    """
    long: dict[tuple[str, str], dict[str, Result]] = {}
    for key, result in kept.results.items():
        name, _, rest = key.partition("/")
        what, _, seconds = rest.rpartition("/")
        own = long.setdefault((what, name), {})
        if not own or float(seconds[:-2]) > float(next(iter(own))[:-2]):
            long[what, name] = {seconds: result}
    found: dict[str, dict[str, list[Result]]] = {}
    for (what, name), own in long.items():
        line = what.partition("/")[0] if what.startswith("tiles") else what
        found.setdefault(line, {}).setdefault(name, []).extend(own.values())
    return found


def told(result: Result) -> str:
    """Return one result in a line."""
    return str(result["left_out"]) if "left_out" in result else brief(result)


def _told(results: list[Result]) -> str:
    """Return what became of one line of the table for one controller."""
    good = [r for r in results if "error" not in r]
    if not good:
        return str(results[0]["error"])[:60] if results else ""
    if len(results) > 1:
        return f"{sum(r['survived'] for r in good)} of {len(results)}"
    return told(good[0])


def _walked(cells: dict[str, dict[str, list[Result]]]) -> dict[str, dict[str, list[Result]]]:
    """Return all but what compares landing laws."""
    return {k: row for k, row in cells.items() if not k.startswith(landing_laws.PREFIX)}


def grids(kept: KeptResults) -> tuple[Grid, ...]:
    """Return the tables."""
    laws = landing_laws.grid(_cells(kept))
    return (table(kept),) if laws is None else (table(kept), laws)


def table(kept: KeptResults) -> Grid:
    """Return everything walked, by controller, beside the study and the paper."""
    cells = _walked(_cells(kept))
    names = sorted({name for row in cells.values() for name in row})
    lines = [
        [
            what,
            *(_told(row.get(name, [])) for name in names),
            STUDY.get(what, ""),
            PAPER.get(what, ""),
        ]
        for what, row in cells.items()
    ]
    return Grid("What was walked", ("", *names, "study", "paper"), lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return the figures with their goals."""
    yield from landing_laws.rows(_cells(kept))
    cells = _walked(_cells(kept))
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
                    yield at_least(name, f"{what}, speed by the recorded", share, KEEP)
                    if r["rms_deg"] is not None:
                        yield at_most(name, f"{what}, joints", r["rms_deg"], RMS, "deg")
                    if r["seconds"] >= LOOPED:
                        drift = 60.0 * abs(r["aside"]) / r["seconds"]
                        yield at_most(name, f"{what}, drift aside in a minute", drift, DRIFT, "m")
            elif what.startswith("slope"):
                for r in found:
                    fine = r["survived"] and r["reached"]
                    share = r["speed"] / (level or r["level"]) if fine else 0.0
                    yield at_least(name, f"{what} deg, speed by that on the level", share, SLOWEST)
            elif what.startswith("tiles"):
                share = 100.0 * sum(r["survived"] for r in found) / every
                goal = {"tiles 3 cm": 100.0, "tiles 5 cm": 90.0}.get(what)
                if goal is None:
                    yield Row(name, f"{what} walked", share, "%")
                else:
                    yield at_least(name, f"{what} walked", share, goal, "%")
            elif not what.startswith(("recording", squares.PREFIX)):
                for r in found:
                    yield equal(name, f"{what}, falls", int(not r["survived"]), 0)
        for kind in ("recording", squares.PREFIX):
            ways = [found for what, found in mine.items() if what.startswith(kind)]
            ways = [found for found in ways if not (found and "left_out" in found[0])]
            if ways:
                walked = sum(bool(found and found[0]["survived"]) for found in ways)
                yield at_least(name, f"{kind}s walked", 100.0 * walked / len(ways), SHARE, "%")


def experiment(controllers: Sequence[str], data: Path | None) -> Measured:
    """Return the experiment for some controllers."""
    return Measured(
        name="walk-battery",
        title="Walking everywhere with one setting",
        parts=parts_for(controllers, data),
        usual=("flat", "slopes", "tiles", "steps", "legs", "bodies", "recordings"),
        shortly=("flat", "slopes", "tiles", "steps", "legs", "bodies", "recordings"),
        brief=told,
        grids=grids,
        rows=rows,
        notes=NOTES,
    )


run = runs(experiment)
EXPERIMENT = experiment(CONTROLLERS, None)
