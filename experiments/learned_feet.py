"""What feet make of a learned walk: several trainings of each kind, held against each other.

One training says nothing of the foot: others of the same foot fall on other ground. Policies are
named as controllers, any number for each kind of feet; those of the package if none is.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.stats import t as student

from experiments.kept_results import KeptResults, Result
from experiments.learned import FEET, Walk, ankle_norm, last, likened, measure, policy_of, there
from experiments.measured import Cases, Measured
from experiments.page import Grid
from experiments.pushed_walk import PHASES, SIDES, limit
from experiments.rough_walk import DURATION, HELD
from experiments.table import ResultTable, Row
from plantigrade.errors import ParameterError
from plantigrade.workflows.policies import is_policy
from plantigrade.workflows.simulate_settings import POLICY

SEEDS, STRIDES = 10, 22.0
"""Fields of bumps for each policy; how long level walking is measured [s]."""
CERTAIN = 0.975
"""Of Student's distribution: intervals hold 95 %."""
NOTES = (
    "",
    "Mean over trainings and its 95 % interval by Student's distribution; the number of trainings "
    "is behind the kind of feet. Ten fields of bumps of ±3 cm, 20 s each, as in rough-walk; pushes "
    "of 0.4 s from both sides at four instants of the stride, as in pushed-walk; level walking "
    "and the ankle as in learned-walk and ankle-torque. Policies that learned in different ways "
    "do not tell feet apart: train them alike.",
)
FIGURES = {
    "rough": ("walk 20 s on ±3 cm", "%"),
    "least": ("side push, least", "N"),
    "push": ("side push, mean", "N"),
    "off": ("joints off the reference", "deg"),
    "heel": ("heel first", "%"),
    "peak": ("peak vertical force", "BW"),
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
    if not found["moment"]:
        return result
    mean, _ = ankle_norm(word, found["speed"])
    return result | likened(np.mean(found["moment"], axis=0), mean)


def _kind(word: str) -> str:
    return policy_of(word).reference.human.feet


def _each(words: Sequence[str], what: str, make: Callable[[str], Cases]) -> Cases:
    return {
        f"{what}/{_kind(word)}/{word.replace('/', ':')}/{name}": case
        for word in words
        for name, case in make(word).items()
    }


def _level(words: Sequence[str], quick: bool) -> Cases:
    duration = 6.0 if quick else STRIDES
    return _each(words, "level", lambda word: {"": partial(level, word, duration)})


def _rough(words: Sequence[str], quick: bool) -> Cases:
    def fields(word: str) -> Cases:
        return {
            str(seed): partial(
                last, Walk(foot=word, ground=f"bumps:{HELD}", seed=seed), 5.0 if quick else DURATION
            )
            for seed in range(2 if quick else SEEDS)
        }

    return _each(words, "rough", fields)


def _pushed(words: Sequence[str], quick: bool) -> Cases:
    def pushes(word: str) -> Cases:
        return {
            f"{name}/{begin}": partial(limit, Walk(foot=word, begin=begin), degrees)
            for name, degrees in SIDES.items()
            for begin in PHASES[: 1 if quick else None]
        }

    return _each(words, "pushed", pushes)


def figures(kept: KeptResults) -> dict[str, dict[str, list[float]]]:
    """Return for each kind of feet every figure, one number for every training."""
    found: dict[str, dict[str, dict[str, list[Result]]]] = {}
    for key, result in kept.results.items():
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
            if rough := [r["stood"] for r in results.get("rough", [])]:
                own["rough"].append(100.0 * float(np.mean(rough)))
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
    return mean, float(student.ppf(CERTAIN, n - 1) * error)


def tables(kept: KeptResults) -> Iterator[Grid]:
    """Return a line for every figure, a column for every kind of feet."""
    found = {kind: own for kind, own in figures(kept).items() if any(own.values())}
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


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return the means, with every training's value beside them."""
    for kind, own in figures(kept).items():
        for name, (words, unit) in FIGURES.items():
            if own[name]:
                every = ", ".join(f"{value:.3g}" for value in own[name])
                yield Row(kind, words, float(np.mean(own[name])), unit, note=f"each: {every}")


def _brief(result: Result) -> str:
    if "force" in result:
        return f"{result['force']:g} N"
    return f"{'walked' if result['stood'] else 'fell'}"


def experiment(words: Sequence[str]) -> Measured:
    """Return the experiment for some policies."""
    return Measured(
        name="learned-feet",
        title="What feet make of a learned walk",
        parts={
            "level": partial(_level, words),
            "rough": partial(_rough, words),
            "pushed": partial(_pushed, words),
        },
        brief=_brief,
        grids=tables,
        rows=rows,
        notes=NOTES,
    )


def run(*, controllers: Sequence[str] = (), **options: Any) -> ResultTable:
    """Measure.

    Args:
        controllers: Files of policies, any number for each kind of feet; those of the package if
            empty.
        options: As :meth:`~experiments.measured.Measured.run` takes it.

    Raises:
        ParameterError: If a controller is not a policy.
        FileError: If a policy cannot be read.
    """
    for word in controllers:  # before hours are spent
        if not is_policy(word):
            raise ParameterError(
                f"controller={word} is not a policy: learned-feet compares files ({POLICY}) that "
                "plantigrade train wrote, and learned"
            )
        policy_of(word)
    return experiment(tuple(controllers) or tuple(there())).run(**options)


EXPERIMENT = experiment(())
