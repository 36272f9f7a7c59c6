"""Landing laws of the pendulum controller on one small battery: a part of ``walk-battery``.

The paper places the foot by the desired remaining energy [Tsai2010]_ (Eqs. 5–7), in the plane of
the walk (``energy``) or in both planes (``energy-both``); ``divergent`` places it by the
extrapolated centre of mass.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from experiments.cached_results import Result
from experiments.specification import Cases
from experiments.table import Grid, Row
from experiments.walk_trial import walk
from experiments.walking import HEIGHT, MASS, figures, walking
from plantigrade.contact.ground import Ground
from plantigrade.control.pendulum.landing_laws import LAWS
from plantigrade.world import PhasePush
from plantigrade.world.grounds import ground_named

PREFIX = "laws "
"""Prefix of the labels of these walks."""
PEOPLE = ((HEIGHT, MASS), (1.60, 55.0))
"""Stature and mass of the people [m, kg]."""
GROUNDS = ("flat", "ramp:-10", "ramp:10", "tiles:3")
DURATION = 9.0
"""Duration of a walk [s]."""
PUSH_FORCE = 100.0
"""Force of a push at the trunk [N]."""
PUSH_DURATION = 0.4
"""Its duration [s]."""
PUSH_PHASE = 0.3
"""Phase of the right foot's cycle at which it begins [1]."""
DIRECTIONS = {"forward": 0.0, "left": 90.0, "backward": 180.0, "right": 270.0}


def on_ground(
    law: str, data: Path | None, height: float, mass: float, ground: str, seconds: float
) -> Result:
    """Return a walk on a ground by one law."""
    under = Ground() if ground == "flat" else ground_named(ground, seed=1)
    found = walk(walking(law, data, height, mass), ground=under, duration=seconds)
    return {**figures(found, since=2.0), "fine": found.survived}


def pushed(law: str, data: Path | None, height: float, mass: float, direction: float) -> Result:
    """Return a pushed walk by one law; it is fine if it returns to the gait."""
    angle = float(np.deg2rad(direction))
    push = PhasePush(
        force=PUSH_FORCE, duration=PUSH_DURATION, direction=angle, side="r", phase=PUSH_PHASE
    )
    found = walk(walking(law, data, height, mass), (push,))
    return {**figures(found), "fine": found.survived and found.back is not None}


def cases(quick: bool, data: Path | None) -> Cases:
    """Return all walks by key."""
    found: Cases = {}
    for height, mass in PEOPLE[:1] if quick else PEOPLE:
        person = f"{height:.2f} m"
        for ground in GROUNDS[:2] if quick else GROUNDS:
            seconds = 4.0 if quick else DURATION
            for law in LAWS:
                name = f"pendulum:{law}"
                key = f"{name}/{PREFIX}{person}, {ground}/{seconds:g} s"
                found[key] = partial(on_ground, name, data, height, mass, ground, seconds)
        for what, direction in list(DIRECTIONS.items())[: 1 if quick else None]:
            for law in LAWS:
                name = f"pendulum:{law}"
                key = f"{name}/{PREFIX}{person}, {PUSH_FORCE:g} N {what}/{DURATION:g} s"
                found[key] = partial(pushed, name, data, height, mass, direction)
    return found


Cells = Mapping[str, Mapping[str, list[Result]]]
"""What was walked → controller → what became of it."""


def _of_laws(cells: Cells) -> dict[str, dict[str, Result]]:
    return {
        what.removeprefix(PREFIX): {
            law: row[f"pendulum:{law}"][0] for law in LAWS if row.get(f"pendulum:{law}")
        }
        for what, row in cells.items()
        if what.startswith(PREFIX)
    }


def grid(cells: Cells) -> Grid:
    """Return the table of the laws."""
    found = _of_laws(cells)
    lines = [[what, *(_cell(row.get(law)) for law in LAWS)] for what, row in found.items()]
    every = [
        [r for row in found.values() if (r := row.get(law)) is not None and "error" not in r]
        for law in LAWS
    ]
    lines += [
        ["all", *(f"{sum(r['fine'] for r in own)} of {len(own)}" if own else "" for own in every)]
    ][: len(found)]
    return Grid("Landing laws", ("", *LAWS), lines)


def _cell(result: Result | None) -> str:
    if result is None:
        return ""
    if "error" in result:
        return str(result["error"])[:60]
    if not result["survived"]:
        return f"{result['end']}"
    share = 100.0 * result["speed"] / max(result["asked"], 1e-9)
    error = "" if result["rms_deg"] is None else f", {result['rms_deg']:.1f}°"
    return f"{share:.0f} %{error}" + ("" if result["fine"] else ", not back to its gait")


def rows(cells: Cells) -> Iterator[Row]:
    """Return how much of it each law walks."""
    found = _of_laws(cells)
    for law in LAWS:
        own = [row[law] for row in found.values() if law in row]
        if own:
            good = sum("error" not in r and bool(r["fine"]) for r in own)
            yield Row(f"pendulum:{law}", "laws walked", 100.0 * good / len(own), "%")
