"""What the learned walks of the package are like: how long, how near the reference, how they land.

Section 6.2 of [Park2020]_, which gives no numbers: with the multi-segment foot the heel lands
first, with a box the whole sole.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.learned import FEET, POINTS, Walk, in_words, last, measure, there
from experiments.measured import Measured
from experiments.page import Grid
from experiments.table import Row, at_least, at_most, between, equal
from plantigrade.learn import Policy
from plantigrade.workflows.policies import shipped

STARTS, ALONE, LONG = 16, 20.0, 600.0  # instants of the stride, [s], [s]
SHOWN = range(0, 36, 3)
"""Of the points of a curve, those of stance."""
REGIONS = ("heel", "midfoot", "ball", "toes")
NOTES = (
    "",
    "The person is the paper's (1.50 m, 48.5 kg, 66 coordinates less those that a foot lacks), "
    "and follows the published mean walk at 1.12 m/s on level ground, at 600 Hz where it was "
    "trained at 150 Hz. 'begin' is how long after the strike a region of the sole first presses, "
    "the median; the peak of the force is that of plates, low-passed at 20 Hz. One policy "
    "for each foot; learned-feet compares trainings. The paper gives no numbers.",
)


def _starts(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    n = 2 if quick else STARTS
    return {
        f"starts/{foot}/{i}": partial(last, Walk(foot=foot, begin=(i + 0.5) / n), ALONE)
        for foot in there()
        for i in range(n)
    }


def _strides(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    duration = 6.0 if quick else 22.0
    return {f"strides/{foot}": partial(measure, Walk(foot=foot), duration) for foot in there()}


def _long(quick: bool) -> dict[str, Callable[[], dict[str, Any]]]:
    duration = 10.0 if quick else LONG
    return {f"long/{foot}": partial(last, Walk(foot=foot), duration) for foot in there()}


def table(kept: KeptResults) -> Iterator[Grid]:
    """Return one line for every foot."""
    header = ("", "body deg", "worst joint", "m/s", "heel first %", *(f"{r} ms" for r in REGIONS),
              "stance ms", "peak BW")  # fmt: skip
    lines = []
    for foot in FEET:
        r = kept.results.get(f"strides/{foot}", {})
        if "body_rms" in r:
            begins = [r["begins"][name] for name in REGIONS]
            lines.append([
                foot, f"{r['body_rms']:.2f}", f"{r['worst_rms']:.1f}", f"{r['speed']:.3f}",
                "-" if r["heel_first"] is None else f"{100 * r['heel_first']:.0f}",
                *("-" if t is None else f"{1e3 * t:.0f}" for t in begins),
                "-" if r["stance"] is None else f"{1e3 * r['stance']:.0f}",
                f"{r['peak_force']:.2f}",
            ])  # fmt: skip
    yield Grid("Learned walks on level ground", header, lines)
    loads = []
    for foot in FEET:
        if cycles := kept.results.get(f"strides/{foot}", {}).get("load"):
            curve = np.mean(cycles, axis=0)
            loads.append([foot, *(f"{curve[k]:.2f}" for k in SHOWN)])
    at = np.linspace(0, 100, POINTS)[SHOWN]
    header = ("", *(f"{x:.0f} %" for x in at))
    yield Grid("Vertical force of a foot over its cycle [body weights]", header, loads)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return what is held against goals."""
    for foot in FEET:
        starts = [r for r in kept.beginning(f"starts/{foot}/").values() if "error" not in r]
        if starts:
            about = Policy.load(shipped(foot)).about
            yield Row(foot, "decisions learned", float(about["decisions"]))
            stood = sum(r["stood"] for r in starts)
            yield equal(foot, f"of {len(starts)} starts walk 20 s", stood, len(starts))
        r = kept.results.get(f"strides/{foot}", {})
        if "body_rms" in r:
            yield at_most(foot, "joints off the reference", r["body_rms"], 4.0, "deg")
            yield between(
                foot, "speed of the reference", r["speed"] / r["speed_wanted"], 0.95, 1.05
            )
            yield between(foot, "mean vertical force", r["weight"], 0.98, 1.02, "BW")
            yield at_most(foot, "peak vertical force", r["peak_force"], 1.5, "BW")
            if r["heel_first"] is not None:
                share = 100.0 * r["heel_first"]
                if foot == "multi-segment":
                    yield at_least(foot, "heel first", share, 95.0, "%")
                else:
                    yield Row(foot, "heel first", share, "%")
        r = kept.results.get(f"long/{foot}", {})
        if "time" in r:
            yield at_least(foot, "walks on", r["time"], 10.0 if r["time"] < 11 else LONG, "s")


def _brief(result: Result) -> str:
    return in_words(result)


EXPERIMENT = Measured(
    name="learned-walk",
    title="Learned walks",
    parts={"starts": _starts, "strides": _strides, "long": _long},
    brief=_brief,
    grids=table,
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
