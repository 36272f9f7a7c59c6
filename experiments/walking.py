"""The walk of the experiments on walking, and their common functions."""

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from experiments.altered_people import scaled_strength
from experiments.cached_results import Result
from experiments.specification import Specification
from experiments.table import ResultTable
from experiments.walk_outcome import WalkOutcome
from experiments.walkers import Walker, guest_named, make_named, walker
from plantigrade.errors import ParameterError
from plantigrade.kinematics.transfer import transferred
from plantigrade.models import Human
from plantigrade.options import is_policy
from plantigrade.record import Record
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.motions import synthesize
from plantigrade.workflows.settings import FitSettings

RECORDING = "cmu_asfamc/16_15.amc"
"""A straight walk of 1.1 m/s without gaps."""
HEIGHT = 1.75
"""Stature of the person [m]; the paper does not state it."""
MASS = 81.4
"""Mass of the person [kg], that of the paper."""
SPEED = 1.1
"""Speed of the walk that is synthesised without recordings [m/s]."""
CONTROLLERS = ("pendulum",)
"""Default controllers."""
REFUSED = {"level ground": "was recorded on uneven ground", "spin": "spins on one foot"}
"""What a controller says of a walk that it refuses → words for it."""


@cache
def recorded(path: Path, feet: str | None = None) -> Record:
    """Return the fit of a recording, with other feet if they are named."""
    return fit_trial(path, FitSettings(feet=feet))[1].record()  # pyright: ignore[reportArgumentType]


@cache
def own_walk(data: Path | None) -> Record:
    """Return the walk of these experiments, of whom it was recorded; synthesised without data."""
    if data is not None and (data / RECORDING).exists():
        return recorded(data / RECORDING)
    return synthesize("walk", speed=SPEED, periodic=True, height=HEIGHT, mass=MASS).record


def person(height: float = HEIGHT, mass: float = MASS, feet: str | None = None) -> Human:
    """Return the person of these experiments."""
    return Human.create(height, mass) if feet is None else Human.create(height, mass, feet=feet)


@cache
def walking(
    controller: str,
    data: Path | None,
    height: float = HEIGHT,
    mass: float = MASS,
    strength: float = 1.0,
) -> Walker:
    """Return the walk of these experiments on a body of a size, moved by a controller."""
    if is_policy(controller.partition(":")[0]):
        return walker(controller)  # as its own person
    record = own_walk(data)
    if (record.human.height, record.human.mass, strength) != (height, mass, 1.0):
        record = transferred(record, scaled_strength(person(height, mass), strength))
    return walker(controller, record)


def figures(found: WalkOutcome, since: float = 0.0) -> Result:
    """Return the figures of a walk; its mean speed is that from a time on [s]."""
    first = found.com[0] if len(found.com) else (0.0, 0.0, 0.0)
    last = found.com[-1] if len(found.com) else first
    return {
        "survived": found.survived,
        "end": found.end,
        "seconds": found.seconds,
        "speed": found.mean_speed(since),
        "asked": found.speed,
        "rms_deg": float(np.rad2deg(found.rms)),
        "far": float(last[0] - first[0]),
        "aside": float(last[1] - first[1]),
        "steps": len(found.landings),
        "back": found.back,
    }


def refusal(one: Walker) -> str:
    """Return why a controller refuses a walk (:data:`REFUSED`); empty where it takes it."""
    try:
        one.controller()
    except ParameterError as error:
        found = [words for said, words in REFUSED.items() if said in str(error)]
        if not found:
            raise
        return found[0]
    return ""


def summary(result: Result) -> str:
    """Return one line about a walk, or why it was left out."""
    if "left_out" in result:
        return str(result["left_out"])
    if not result["survived"]:
        return str(result["end"])
    share = 100.0 * result["speed"] / max(result["asked"], 1e-9)
    error = "" if result["rms_deg"] is None else f", {result['rms_deg']:.1f}° off"
    return f"{result['seconds']:.0f} s, {result['speed']:.2f} m/s ({share:.0f} %){error}"


def runs(
    make: Callable[[Sequence[str], Path | None], Specification], *, guests: bool = False
) -> Callable[..., ResultTable]:
    """Return the function ``run`` of a module whose experiment any controllers can be put to.

    Args:
        make: Returns the experiment for some controllers and a folder of recordings.
        guests: Whether it takes guests with bodies of their own.
    """

    def run(
        data: Path | None = None, *, controllers: Sequence[str] = (), **options: Any
    ) -> ResultTable:
        """Measure.

        Args:
            data: Folder of recordings; walks are synthesised without it.
            controllers: Words of controllers (:func:`~experiments.walkers.make_named`);
                the usual one if empty.
            options: As :meth:`~experiments.specification.Specification.run` takes it.

        Raises:
            ParameterError: If there is no such part or controller.
            FileError: If what is cached cannot be shown, or a policy cannot be read.
        """
        chosen = tuple(controllers) or CONTROLLERS
        for word in chosen:  # before hours are spent
            if not guests or guest_named(word) is None:
                make_named(word)
        return make(chosen, data).run(**options)

    return run
