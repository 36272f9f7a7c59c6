"""Share of pushes of one force that a walk withstands, over directions and phases.

The largest push at one phase in one direction is a matter of chance: a walker who falls at 300 N
may withstand 350 N. How many of the pushes of a force are withstood is known better, to 9 % of 32.
Phases lie between those of the map, and no constant was settled on them.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.last_pushed import pushed_at
from experiments.push_limits import directions
from experiments.table import Row, at_least, at_most
from experiments.walk_trial import WATCH_TIME
from experiments.walkers import guest_named
from experiments.walking import HEIGHT, MASS, walking

PART = "shares"
"""Name of the part of ``push-map``."""
FORCES = (225.0, 275.0, 325.0, 375.0, 425.0, 475.0, 525.0)
"""Sizes of the pushes [N]."""
PHASES = (0.125, 0.375, 0.625, 0.875)
"""Phases of the gait cycle at which they begin."""
N_DIRECTIONS = 8
"""Number of directions."""
MAX_BEND = 35.0
"""Goal: greatest angle of the upper trunk against the pelvis [deg]: people bend thoracic and lumbar
spine by up to 30° backward and 35° sideways [AAOS1965]_."""


SURVIVED = ("impact", "bend", "lean")
"""Figures of a survived push."""


def outcome(
    controller: str, data: Path | None, duration: float, phase: float, degrees: float, force: float
) -> Result:
    """Return whether a push is withstood, and how hard the feet land after it."""
    one = guest_named(controller) or walking(controller, data, HEIGHT, MASS, 1.0)
    pushed = pushed_at(one, phase)
    found = pushed(force, float(np.deg2rad(degrees)), duration, WATCH_TIME)
    return {
        "withstood": bool(found.withstood),
        "survived": bool(found.survived),
        "impact": found.peak,
        "bend": found.bend,
        "lean": found.lean,
    }


def share_cases(
    controllers: Sequence[str], data: Path | None, duration: float, quick: bool
) -> Cases:
    """Return every push; one phase after the other."""
    forces, phases = (FORCES[2:3], PHASES[:1]) if quick else (FORCES, PHASES)
    degrees = [round(float(np.rad2deg(d)), 1) for d in directions(2 if quick else N_DIRECTIONS)]
    return {
        f"{PART}/{controller}/{phase:g}/{d:g}/{force:g}": partial(
            outcome, controller, data, duration, phase, d, force
        )
        for controller in controllers
        for phase in phases
        for d in degrees
        for force in forces
    }


def push_summary(result: Result) -> str:
    """Return one line about a push."""
    if not result["survived"]:
        return "fell"
    landed = f"landed with {result['impact']:.1f} body weights"
    return f"{'back' if result['withstood'] else 'on the feet'}, {landed}"


def share_rows(
    cached: CachedResults, goal: float, impact_force: float, max_impact: float
) -> Iterator[Row]:
    """Return the shares by force, the force at which half are withstood, and landings.

    That force is left out where all shares are on one side of a half.

    Args:
        goal: Goal of that force [N].
        impact_force: Force up to which the goal of landings counts [N].
        max_impact: Goal of the hardest landing [body weights].
    """
    of: dict[str, dict[float, list[Result]]] = {}
    for key, result in cached.select(PART).items():
        controller, _, _, force = key.removeprefix(f"{PART}/").rsplit("/", 3)
        of.setdefault(controller, {}).setdefault(float(force), []).append(result)
    for controller, pushes in of.items():
        subject, forces = f"{controller} {PART}", sorted(pushes)
        share = [float(np.mean([r["withstood"] for r in pushes[f]])) for f in forces]
        for force, part in zip(forces, share, strict=True):
            yield Row(subject, f"withstood, {force:g} N", 100.0 * part, "%")
        if max(share) >= 0.5 >= min(share):  # otherwise that force was not tried
            falling = np.minimum.accumulate(share)[::-1]
            half = float(np.interp(0.5, falling, forces[::-1]))
            yield at_least(subject, "force at which half are withstood", half, goal, "N")
        usual = [r for f in forces if f <= impact_force for r in pushes[f] if r["survived"]]
        impacts, bends, leans = ([r[k] for r in usual if k in r] for k in SURVIVED)
        yield from survived_rows(subject, impact_force, max_impact, impacts, bends, leans)
        if usual:
            hard = 100.0 * float(np.mean(np.array(impacts) > max_impact))
            words = f"landings beyond {max_impact:g} BW, pushes up to {impact_force:g} N"
            yield Row(subject, words, hard, "%")
        yield Row(subject, "cases", sum(map(len, pushes.values())))


def survived_rows(
    subject: str,
    force: float,
    max_impact: float,
    impacts: Sequence[float],
    bends: Sequence[float],
    leans: Sequence[float],
) -> Iterator[Row]:
    """Return the hardest landing, and how far the back is bent and the trunk leans.

    Args:
        subject: Subject of the rows.
        force: Force up to which pushes are given [N].
        max_impact: Goal of the hardest landing [body weights].
        impacts: Greatest force on a foot after each survived push [body weights].
        bends: Greatest bend of the back [deg].
        leans: Greatest lean of the upper trunk [deg].
    """
    if impacts:
        words = f"hardest landing, pushes up to {force:g} N"
        yield at_most(subject, words, max(impacts), max_impact, "BW")
    if known := [value for value in bends if np.isfinite(value)]:
        words = f"back bent at most, pushes up to {force:g} N"
        yield at_most(subject, words, max(known), MAX_BEND, "deg")
        yield Row(
            subject,
            f"back bent, median of pushes up to {force:g} N",
            float(np.median(known)),
            "deg",
        )
    if known := [value for value in leans if np.isfinite(value)]:
        yield Row(subject, f"trunk leans at most, pushes up to {force:g} N", max(known), "deg")
