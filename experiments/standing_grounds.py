"""Standing on uneven ground and on a swaying plate, with every kind of foot.

Uneven ground: Fig. 9 of [Park2020]_ (spheres, domes under the arch), and fields of random bumps.
Everybody starts with the soles laid on the ground as closely as the feet can be
(:func:`plantigrade.world.standing_on`). Swaying plate: Fig. 11, which says without numbers that the
two-segment foot wobbles more in one direction and fails in the other.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.push_limits import PushTest
from experiments.specification import Specification
from experiments.standing import FEET, FORMULATIONS, PUSHES, Standing, stand, summary
from experiments.table import Row, at_least, equal
from plantigrade.world import Tilting
from plantigrade.world.standing import COM_ALONG_SOLE

STANDING_PARTS = ("torque", "hybrid", "posture")
"""Formulations that are compared, each a part."""
SHIPPED_FEET_PART = "shipped"
"""Part with the feet of the command line: fewer contacts under those of one or two segments."""


def _has_goal(formulation: str, foot: str) -> bool:
    return foot == FEET[0] and formulation != "posture"


# Uneven ground ------------------------------------------------------------------------------------

DURATION = 10.0
"""Duration of standing [s]."""
N_SEEDS = 20
"""Number of fields of bumps."""
SHAPES = {"sphere:1": "sphere of 1 m", "sphere:0.5": "sphere of 0.5 m", "dome:2": "domes of 2 cm"}
BUMPS = "bumps:3"
MIN_SHARE = 90.0
"""Goal of the share of fields of bumps [%]."""
FORCE_STEP = 2.5
"""Distance of the tried forces [N]."""
WATCH_TIME = 3.0
"""Time on the feet after a push [s]."""


def _uneven(part: str, quick: bool) -> Cases:
    """Return every foot on every ground."""
    duration = 3.0 if quick else DURATION
    grounds = {ground: (ground, 0) for ground in SHAPES}
    grounds |= {f"{BUMPS}/{k}": (BUMPS, k) for k in range(2 if quick else N_SEEDS)}
    full_sole = part != SHIPPED_FEET_PART
    standing = partial(Standing, formulation=part if full_sole else "torque", full_sole=full_sole)
    return {
        f"{part}/{foot}/{name}": partial(
            stand, standing(foot, ground=ground, seed=seed), (), duration
        )
        for foot in (FEET if full_sole else FEET[1:])  # the first has sixteen contacts anyway
        for name, (ground, seed) in grounds.items()
    }


def _pushes(quick: bool) -> Cases:
    """Return push limits on these grounds."""
    return {
        f"pushes/{foot}/{ground}/{side}": partial(_limit, foot, ground, direction)
        for foot in FEET
        for ground in list(SHAPES)[: 1 if quick else None]
        for side, direction in PUSHES.items()
    }


def _limit(foot: str, ground: str, direction: float) -> Result:
    test = PushTest(situation=Standing(foot, "torque", ground), watch_time=WATCH_TIME)
    limit = test.limit(direction, step=FORCE_STEP)
    return {"force": limit.force, "gaps": list(limit.gaps)}


def _by_ground(cached: CachedResults) -> Iterator[tuple[str, str, str, list[Result]]]:
    """Yield formulation or part, foot, kind of ground and its results."""
    for formulation in (*FORMULATIONS, SHIPPED_FEET_PART):
        for foot in FEET:
            for ground, words in (*SHAPES.items(), (BUMPS, "bumps of 3 cm")):
                if found := list(cached.select(formulation, foot, ground).values()):
                    yield formulation, foot, words, found


def uneven_rows(cached: CachedResults) -> Iterator[Row]:
    """Return the share that stood, with a goal for the multi-segment foot; contact points."""
    for formulation, foot, words, found in _by_ground(cached):
        share = 100.0 * float(np.mean([r["stood"] for r in found]))
        goal = MIN_SHARE if "bumps" in words else 100.0
        subject = f"{formulation} {foot}"
        goal = goal if _has_goal(formulation, foot) else None
        yield at_least(subject, f"{words} stood", share, goal, "%")
        stood = [r for r in found if r["stood"]]
        if stood:
            slip, points, lean = (
                np.array([r[name] for r in stood]) for name in ("slip", "points", "wobble")
            )
            yield Row(subject, f"{words} points", float(points.mean()))
            yield Row(subject, f"{words} slip, median", float(np.median(slip)), "mm")
            yield Row(subject, f"{words} slip, most", float(slip.max()), "mm")
            yield Row(subject, f"{words} trunk, median", float(np.median(lean)), "deg")
        if fell := [r["time"] for r in found if not r["stood"]]:
            yield Row(subject, f"{words} first fall", min(fell), "s")
    for key, result in cached.select("pushes").items():
        _, foot, ground, side = key.split("/")
        yield Row(f"push {foot}", f"{SHAPES[ground]} {side}", result["force"], "N")


UNEVEN = Specification(
    name="uneven-ground",
    title="Standing on uneven ground",
    parts={name: partial(_uneven, name) for name in (*STANDING_PARTS, SHIPPED_FEET_PART)}
    | {"pushes": _pushes},
    default_parts=("torque", SHIPPED_FEET_PART),
    summary=summary,
    rows=uneven_rows,
    notes=(
        "",
        "People of 1.50 m and 48.5 kg stand for ten seconds; all feet have the same sixteen "
        "contact points, outline and mass, except in the part 'shipped': feet of two segments and "
        "rigid ones as the command line has them, with seven of these points. 'points' is the "
        "number of points that press with more than 1 N, 'slip' the longest path of one of them "
        "since the first second. Bumps are up to "
        "3 cm high and low, smoothed over 15 cm, another field for every seed. The paper shows its "
        "two-segment foot slip from a sphere, without numbers.",
    ),
)

# Swaying plate ------------------------------------------------------------------------------------

PLATE_DURATION = 20.0
"""Time on the plate [s]."""
PLATE_PERIOD = 4.0
"""Period of its motion [s]."""
AXES = {"fore-aft": 0.0, "lateral": np.pi / 2}
DEGREES = (10, 15)
MOVING_FIGURES = {"trunk": "deg", "sway": "mm", "slip": "mm", "points": ""}
"""Figure → unit."""


def _moving(formulation: str, quick: bool) -> Cases:
    """Return every foot on every plate."""

    def case(foot: str, degrees: int, direction: float) -> partial:
        amplitude = float(np.deg2rad(degrees))
        plate = Tilting(amplitude=amplitude, period=PLATE_PERIOD, direction=direction)
        standing = Standing(foot, formulation, ahead=COM_ALONG_SOLE)
        return partial(stand, standing, (plate,), 5.0 if quick else PLATE_DURATION)

    return {
        f"{formulation}/{foot}/{name}/{degrees}": case(foot, degrees, direction)
        for foot in FEET
        for degrees in (DEGREES[:1] if quick else DEGREES)
        for name, direction in AXES.items()
    }


def moving_rows(cached: CachedResults) -> Iterator[Row]:
    """Return falls, with a goal for the multi-segment foot, and the sway of the trunk."""
    for formulation in FORMULATIONS:
        for foot in FEET:
            found, subject = cached.select(formulation, foot), f"{formulation} {foot}"
            if not found:
                continue
            fell = sum(not r["stood"] for r in found.values())
            yield equal(subject, "falls", fell, 0 if _has_goal(formulation, foot) else None)
            for key, r in found.items():
                _, _, name, degrees = key.split("/")
                if not r["stood"]:
                    yield Row(subject, f"{degrees} deg {name} fell at", r["time"], "s")
                    continue
                for what, unit in MOVING_FIGURES.items():
                    value = r["wobble" if what == "trunk" else what]
                    yield Row(subject, f"{degrees} deg {name} {what}", value, unit)


MOVING = Specification(
    name="moving-slope",
    title="Standing on a plate that sways",
    parts={name: partial(_moving, name) for name in STANDING_PARTS},
    default_parts=("torque", "hybrid"),
    quick_parts=("torque",),
    summary=summary,
    rows=moving_rows,
    notes=(
        "",
        "The plate is a body on joints, driven along a sine of 4 s whose amplitude grows in the "
        "first period. 'trunk' is the change of the trunk's lean, a root mean square over time; "
        "'sway' is that of the centre of mass over the ground.",
    ),
)
