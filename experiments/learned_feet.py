"""Effect of the kind of feet on a learned walk: several trainings of each kind compared.

One training is no evidence about a foot: other trainings of the same foot fall on other ground.
Policies are named as controllers, any number for each kind of feet; the default is those of the
package.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.stats import t as student

from experiments.cached_results import CachedResults, Cases, Result
from experiments.learned import (
    FEET,
    Walk,
    ankle_norm,
    available_feet,
    measure,
    moment_agreement,
    policy_of,
)
from experiments.learned_disturbed import GOAL_HEIGHT, HEIGHTS, SIDES, pushed_walks, rough_walks
from experiments.learned_level import DURATION, QUICK_DURATION
from experiments.specification import Specification
from experiments.table import Grid, ResultTable, Row
from plantigrade.errors import ParameterError
from plantigrade.options import POLICY_SUFFIXES, is_policy

N_SEEDS = 10
"""Number of low fields of bumps for each policy."""
ROUGHER_HEIGHT = max(HEIGHTS)
"""Height of the higher fields of bumps [cm]."""
QUANTILE = 0.975
"""Quantile of Student's distribution: intervals hold 95 %."""
NOTES = (
    "",
    "Mean over trainings and its 95 % interval by Student's distribution; the number of trainings "
    "is behind the kind of feet. Ten fields of bumps of ±3 cm and twenty of ±5 cm, 20 s each, as "
    "in rough-walk; pushes of 0.4 s from both sides at four phases of the stride, as in "
    "pushed-walk; level walking and the ankle as in learned-walk and ankle-torque. "
    "Policies that learned in different ways say nothing about feet: train them alike.",
)
FIGURES = {
    "rough": ("walk 20 s on ±3 cm", "%"),
    "rougher": ("walk 20 s on ±5 cm", "%"),
    "least": ("side push, least", "N"),
    "push": ("side push, mean", "N"),
    "off": ("joints off the reference", "deg"),
    "heel": ("heel first", "%"),
    "peak": ("peak vertical force", "BW"),
    "foot": ("peak vertical force of one foot", "BW"),
    "double": ("double support", "%"),
    "r": ("ankle moment, r with children's", ""),
    "ratio": ("its peak, by the measured", ""),
    "apart": ("its distance from the measured", "N m/kg"),
}
"""Name of a figure → in words, and its unit."""


def level(word: str, duration: float) -> Result:
    """Return the figures of a walk on level ground."""
    found = measure(Walk(foot=word), duration)
    heel = found["heel_first"]
    result = {"off": found["body_rms"], "peak": found["peak_force"], "stood": found["stood"]}
    result["heel"] = None if heel is None else 100.0 * heel
    result |= {"foot": found["foot_peak"], "double": 100.0 * found["double"]}
    if not found["moment"]:
        return result
    mean, _ = ankle_norm(word, found["speed"])
    return result | moment_agreement(np.mean(found["moment"], axis=0), mean)


def _level(word: str, quick: bool) -> Cases:
    return {"": partial(level, word, QUICK_DURATION if quick else DURATION)}


def _rough(word: str, quick: bool) -> Cases:
    return rough_walks(word, GOAL_HEIGHT, quick, N_SEEDS)


def _rougher(word: str, quick: bool) -> Cases:
    return rough_walks(word, ROUGHER_HEIGHT, quick)


def _pushed(word: str, quick: bool) -> Cases:
    return pushed_walks(word, SIDES, quick)


def _cases(part: str, make: Callable[..., Cases], words: Sequence[str], quick: bool) -> Cases:
    """Return the cases of a part for all policies."""
    return {
        f"{part}/{policy_of(word).reference.human.feet}/{word.replace('/', ':')}/{name}": case
        for word in words
        for name, case in make(word, quick).items()
    }


def figures(cached: CachedResults) -> dict[str, dict[str, list[float]]]:
    """Return for each kind of feet the value of every figure in every training."""
    found: dict[str, dict[str, dict[str, list[Result]]]] = {}
    for key, result in cached.results.items():
        if "error" not in result:
            what, kind, word, _ = key.split("/", 3)
            found.setdefault(kind, {}).setdefault(word, {}).setdefault(what, []).append(result)
    table: dict[str, dict[str, list[float]]] = {}
    for kind in FEET:
        own = table[kind] = {name: [] for name in FIGURES}
        for results in found.get(kind, {}).values():
            for result in results.get("level", []):
                for name in own.keys() & result.keys():
                    if result[name] is not None:
                        own[name].append(float(result[name]))
            for part in ("rough", "rougher"):
                if rough := [r["stood"] for r in results.get(part, [])]:
                    own[part].append(100.0 * float(np.mean(rough)))
            if forces := [r["force"] for r in results.get("pushed", [])]:
                own["least"].append(min(forces))
                own["push"].append(float(np.mean(forces)))
    return table


def interval(values: Sequence[float]) -> tuple[float, float]:
    """Return the mean and half its 95 % interval; NaN where there is only one value.

    Example:
        >>> tuple(round(x, 2) for x in interval([1.0, 2.0, 3.0]))
        (2.0, 2.48)
    """
    n, mean = len(values), float(np.mean(values))
    if n < 2:
        return mean, float("nan")
    error = float(np.std(values, ddof=1)) / np.sqrt(n)
    return mean, float(student.ppf(QUANTILE, n - 1) * error)


def tables(cached: CachedResults) -> Iterator[Grid]:
    """Return a line for every figure, a column for every kind of feet."""
    found = {kind: own for kind, own in figures(cached).items() if any(own.values())}
    lines = []
    for name, (words, unit) in FIGURES.items():
        cells = []
        for own in found.values():
            if not own[name]:
                cells.append("-")
                continue
            mean, half = interval(own[name])
            more = "" if np.isnan(half) else f" ± {half:.2g}"
            cells.append(f"{mean:.3g}{more}")
        lines.append([f"{words} [{unit}]" if unit else words, *cells])
    counts = [max(len(values) for values in own.values()) for own in found.values()]
    header = ("", *(f"{kind}, {n}" for kind, n in zip(found, counts, strict=True)))
    yield Grid("Learned walks by their feet: mean of trainings ± 95 %", header, lines)


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the means, with every training's value beside them."""
    for kind, own in figures(cached).items():
        for name, (words, unit) in FIGURES.items():
            if own[name]:
                every = ", ".join(f"{value:.3g}" for value in own[name])
                yield Row(kind, words, float(np.mean(own[name])), unit, note=f"each: {every}")


def _summary(result: Result) -> str:
    if "force" in result:
        return f"{result['force']:g} N"
    return "walked" if result["stood"] else "fell"


def experiment(words: Sequence[str]) -> Specification:
    """Return the experiment for some policies."""
    parts = {"level": _level, "rough": _rough, "rougher": _rougher, "pushed": _pushed}
    return Specification(
        name="learned-feet",
        title="Effect of the feet on a learned walk",
        parts={name: partial(_cases, name, make, words) for name, make in parts.items()},
        summary=_summary,
        grids=tables,
        rows=rows,
        notes=NOTES,
    )


def run(*, controllers: Sequence[str] = (), **options: Any) -> ResultTable:
    """Run the experiment.

    Args:
        controllers: Files of policies, any number for each kind of feet; those of the package if
            empty.
        options: Options of :meth:`~experiments.specification.Specification.run`.

    Raises:
        ParameterError: If a controller is not a policy.
        FileError: If a policy cannot be read.
    """
    for word in controllers:  # before hours are spent
        if not is_policy(word):
            raise ParameterError(
                f"controller={word} is not a policy: learned-feet compares learned and files "
                f"({' or '.join(POLICY_SUFFIXES)}) that plantigrade train or convert wrote"
            )
        policy_of(word)
    return experiment(tuple(controllers) or available_feet()).run(**options)


EXPERIMENT = experiment(())
