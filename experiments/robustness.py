"""Robustness of replays to model mismatch: mass, friction, ground, delay, sensor noise."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from experiments.cached_results import CachedResults, Result
from experiments.replay import MOTIONS, outcome, summary, synthesised
from experiments.specification import Cases, Specification
from experiments.table import Row, at_least
from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.control.replay.trials import replay_once
from plantigrade.world.grounds import ground_named
from plantigrade.world.model_mismatch import ModelMismatch

DURATION = 10.0  # [s] of repeated walks
QUICK_DURATION = 3.0  # [s] of repeated walks in the short form
N_STARTS = 5  # starts of each motion
MIN_SURVIVAL_SHARE = 90.0  # goal: share of starts survived [%]
NAMES = ("walk 1.0 m/s", "walk 1.3 m/s", "walk 1.6 m/s", "walk from standing", "sit-to-stand",
         "side-step", "squat", "jump")  # fmt: skip
WALKS = tuple(name for name in NAMES if name.startswith("walk"))
UNPLANNED_START = 0.5
"""Where the unplanned ground begins [m]."""


def _bumps(seed: int) -> ModelMismatch:
    return ModelMismatch(ground=ground_named("bumps:1", seed=seed))


def _ahead(rise: float) -> Callable[[int], ModelMismatch]:
    """Return ground that is higher by ``rise`` from :data:`UNPLANNED_START` on [m]."""
    return lambda seed: ModelMismatch(ground=Ground(steps=(GroundStep(UNPLANNED_START, rise),)))


MISMATCHES_BY_PART: dict[str, dict[str, Callable[[int], ModelMismatch]]] = {
    "planned": {"as planned": lambda seed: ModelMismatch()},
    "mass": {
        "10 % heavier": lambda seed: ModelMismatch(mass=1.1),
        "10 % lighter": lambda seed: ModelMismatch(mass=0.9),
    },
    "friction": {
        "friction 0.5": lambda seed: ModelMismatch(friction=0.5),
        "friction 1.0": lambda seed: ModelMismatch(friction=1.0),
    },
    "ground": {
        "bumps of 1 cm": _bumps,
        "1 cm higher ahead": _ahead(0.01),
        "1 cm lower ahead": _ahead(-0.01),
    },
    "delay": {"delay of 10 ms": lambda seed: ModelMismatch(delay=0.010)},
    "sensors": {"sensor noise": lambda seed: ModelMismatch(sensors=0.002)},
}
"""Part → name → the mismatch, by the number of the start."""
MISMATCHES = {what: how for part in MISMATCHES_BY_PART.values() for what, how in part.items()}

NOTES = (
    "",
    "Runs from starts disturbed as in the experiment replay, with one mismatch at a time, "
    f"unknown to the controller; walks on level ground are repeated for {DURATION:g} s "
    f"({QUICK_DURATION:g} s in the short form). Bumps are another random relief for each start; "
    f"ground that is higher or lower is so from {UNPLANNED_START:g} m ahead on, for walks (a "
    "motion with a seat keeps its own ground). Sensor noise: 0.002 rad on angles, 0.02 rad/s and "
    "m/s on velocities, white, at 500 Hz.",
)


def replayed(name: str, what: str, seed: int, duration: float) -> Result:
    """Return the outcome of a motion under a mismatch."""
    repeated = duration if MOTIONS[name].repeated else None
    return outcome(
        replay_once(synthesised(name), repeated, seed=seed, mismatch=MISMATCHES[what](seed))
    )


def _fits(name: str, what: str) -> bool:
    """Return whether a disturbance means something for a motion."""
    if "ahead" in what:
        return name in WALKS
    return what != "bumps of 1 cm" or not name.startswith("sit")


def _cases(part: str, quick: bool) -> Cases:
    """Return every motion under the disturbances of a part; first starts come first."""
    names, starts, long = (
        (("walk 1.3 m/s",), 1, QUICK_DURATION) if quick else (NAMES, N_STARTS, DURATION)
    )
    return {
        f"{what}/{name}/{seed}/{long:g} s": partial(replayed, name, what, seed, long)
        for seed in range(1, starts + 1)
        for name in names
        for what in MISMATCHES_BY_PART[part]
        if _fits(name, what)
    }


def _survived(cached: CachedResults, what: str, name: str) -> list[bool]:
    """Return the survival of a motion under a mismatch: of the long runs, if there are any."""
    found = cached.select(what, name, failed=True)
    long = [result for key, result in found.items() if key.endswith(f"/{DURATION:g} s")]
    return [bool(result.get("survived")) for result in long or found.values()]


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the share of runs that survived."""
    for what in MISMATCHES:
        for name in NAMES:
            if own := _survived(cached, what, name):
                share = 100.0 * float(np.mean(own))
                yield at_least(name, f"survived, {what}", share, MIN_SURVIVAL_SHARE, "%")


EXPERIMENT = Specification(
    name="robustness",
    title="Motions under what was not planned",
    parts={part: partial(_cases, part) for part in MISMATCHES_BY_PART},
    summary=summary,
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
