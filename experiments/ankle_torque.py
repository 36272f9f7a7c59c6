"""The moment of the ankle over the gait cycle beside measured ones: Fig. 8 of [Park2020]_."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults
from experiments.learned import FEET, POINTS, Walk, ankle_norm, in_words, likened, measure, there
from experiments.measured import Measured
from experiments.page import Grid
from experiments.table import Row, at_least, between

SHOWN = np.linspace(0, POINTS - 1, 11).astype(int)
NOTES = (
    "",
    "Moment of the ankle about its flexion axis by body mass, plantarflexors negative, every "
    "tenth of the cycle; means of both legs over all cycles of 20 s. Measured: 83 children of 4 "
    "to 17 years at the same dimensionless speed [Schwartz2008]: no table of adults' moments is "
    "free to be passed on, and the person is 1.50 m tall. The paper shows, without numbers, that "
    "the multi-segment foot is nearer to measured curves than the two-segment foot.",
)


def _cases(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    duration = 6.0 if quick else 22.0
    return {f"ankle/{foot}": partial(measure, Walk(foot=foot), duration) for foot in there()}


def _found(kept: KeptResults) -> Iterator[tuple[str, Any, Any, Any]]:
    """Yield foot, all curves, mean and SD of the measured ones."""
    for foot in FEET:
        r = kept.results.get(f"ankle/{foot}", {})
        if r.get("moment"):
            yield foot, np.array(r["moment"]), *ankle_norm(foot, r["speed"])


def table(kept: KeptResults) -> Iterator[Grid]:
    """Return the curves."""
    lines = []
    for i, (foot, cycles, mean, sd) in enumerate(_found(kept)):
        if not i:
            lines.append(["measured", *(f"{mean[k]:.2f}" for k in SHOWN)])
            lines.append(["measured, SD", *(f"{sd[k]:.2f}" for k in SHOWN)])
        lines.append([foot, *(f"{cycles.mean(axis=0)[k]:.2f}" for k in SHOWN)])
        lines.append([f"{foot}, SD", *(f"{cycles.std(axis=0)[k]:.2f}" for k in SHOWN)])
    header = ("", *(f"{10 * i} %" for i in range(11)))
    yield Grid("Ankle moment over the cycle [N m/kg]", header, lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return likeness, peak and distance from the measured curve."""
    for foot, cycles, mean, sd in _found(kept):
        own = cycles.mean(axis=0)
        likeness, peak, apart = likened(own, mean).values()
        within = 100.0 * float(np.mean(np.abs(own - mean) <= 2.0 * sd))
        if foot == "multi-segment":
            yield at_least(foot, "likeness r", likeness, 0.95)
            yield between(foot, "peak by that measured", peak, 0.85, 1.15)
        else:
            yield Row(foot, "likeness r", likeness)
            yield Row(foot, "peak by that measured", peak)
        yield Row(foot, "apart", apart, "N m/kg")
        yield Row(foot, "within two SD", within, "%")


EXPERIMENT = Measured(
    name="ankle-torque",
    title="Ankle moment of learned walks",
    parts={"ankle": _cases},
    brief=in_words,
    grids=table,
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
