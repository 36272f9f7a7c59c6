"""The learned stiffness of the feet over the gait cycle: Fig. 7 of [Park2020]_."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults
from experiments.learned import FEET, POINTS, Walk, in_words, last, measure, there
from experiments.measured import Measured
from experiments.page import Grid
from experiments.table import Row
from plantigrade.world import Push

PUSH = Push(force=60.0, duration=0.4, direction=np.pi / 2, time=4.0)
GROUNDS = {"level": ("flat", ()), "rough": ("bumps:3", ()), "pushed": ("flat", (PUSH,))}
"""Name → ground and what acts."""
SHOWN = np.linspace(0, POINTS - 1, 11).astype(int)
SEEDS = 5
NOTES = (
    "",
    "Stiffness in N m/rad at every tenth of the cycle, from heel strike to heel strike, means of "
    "both feet over all cycles of 20 s; 'SD' between cycles. Without an action ankles have 400 "
    "and joints of the foot 60. The paper's curves (multi-segment) rise at the ankle and the "
    "third phalanges towards toe-off, are least at the heel as it strikes, and greatest in "
    "mid-stance at the fourth metatarsal and phalanges; it prints axes without units. 'held' is "
    "the same policy with these stiffnesses held at 400 and 60; no policy was trained with fixed "
    "ones for this table.",
)


def _curves(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    duration = 6.0 if quick else 22.0
    return {f"curves/{foot}": partial(measure, Walk(foot=foot), duration) for foot in there()}


def _held(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    cases = {}
    for foot in there():
        for name, (ground, acting) in GROUNDS.items():
            for seed in range(1 if quick else SEEDS):
                for held in (False, True):
                    walk = Walk(foot=foot, ground=ground, seed=seed, begin=seed / SEEDS, held=held)
                    word = "held" if held else "learned"
                    cases[f"held/{foot}/{name}/{word}/{seed}"] = partial(last, walk, 10.0, acting)
    return cases


def table(kept: KeptResults) -> Iterator[Grid]:
    """Return the curves, and what holding them costs."""
    lines = []
    for foot in FEET:
        for joint, cycles in kept.results.get(f"curves/{foot}", {}).get("stiffness", {}).items():
            if cycles:
                mean, sd = np.mean(cycles, axis=0), np.std(cycles, axis=0)
                name = "ankle" if joint == "foot" else joint.replace("_", " ")
                cells = [f"{mean[i]:.0f}" for i in SHOWN]
                lines.append([f"{foot}, {name}", *cells, f"{sd.mean():.0f}"])
    header = ("", *(f"{10 * i} %" for i in range(11)), "SD")
    yield Grid("Stiffness over the cycle [N m/rad]", header, lines)
    lines = []
    for foot in FEET:
        for name in GROUNDS:
            cells = []
            for word in ("learned", "held"):
                found = _of(kept, foot, name, word)
                if found:
                    stood = sum(r["stood"] for r in found)
                    cells.append(f"{stood} of {len(found)}")
            if len(cells) == 2:
                lines.append([f"{foot}, {name}", *cells])
    yield Grid("Walks of ten seconds", ("", "stiffness learned", "held"), lines)


def _of(kept: KeptResults, foot: str, name: str, word: str) -> list[dict[str, Any]]:
    found = kept.beginning(f"held/{foot}/{name}/{word}/")
    return [r for r in found.values() if "error" not in r]


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return by how much stiffness changes over the cycle, and how many walk on."""
    for foot in FEET:
        for joint, cycles in kept.results.get(f"curves/{foot}", {}).get("stiffness", {}).items():
            if cycles:
                mean = np.mean(cycles, axis=0)
                name = "ankle" if joint == "foot" else joint.replace("_", " ")
                yield Row(foot, f"{name} greatest by least", float(mean.max() / mean.min()))
        for name in GROUNDS:
            for word in ("learned", "held"):
                found = _of(kept, foot, name, word)
                if found:
                    share = 100.0 * float(np.mean([r["stood"] for r in found]))
                    yield Row(foot, f"{name} {word} walked", share, "%")


EXPERIMENT = Measured(
    name="gain-curves",
    title="Learned stiffness of the feet",
    parts={"curves": _curves, "held": _held},
    brief=in_words,
    grids=table,
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
