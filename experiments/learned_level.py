"""Learned walks on level ground: errors and landings, stiffness of the feet, ankle moment.

Section 6.2, Fig. 7 and Fig. 8 of [Park2020]_, which print no numbers: with the multi-segment foot
the heel lands first, with a box the whole sole.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from experiments.cached_results import CachedResults, Cases
from experiments.learned import (
    FEET,
    POINTS,
    Walk,
    ankle_norm,
    cases_of,
    endure,
    measure,
    moment_agreement,
    summary,
    training_value,
)
from experiments.specification import Specification
from experiments.table import Grid, Row, at_least, at_most, between, equal, text_of
from plantigrade.world import Push

DURATION = 22.0
"""Duration of the measured walks [s]."""
QUICK_DURATION = 6.0
"""Duration of the measured walks in the short form [s]."""
N_STARTS = 16
"""Number of start phases."""
START_DURATION = 20.0
"""Duration of the walks from these [s]."""
LONG_DURATION = 600.0
"""Duration of the long walk [s]."""
STANCE_POINTS = range(0, 36, 3)
"""Printed points of a load curve: those of stance."""
TENTH_POINTS = np.linspace(0, POINTS - 1, 11).astype(int)
"""Printed points of other curves: every tenth of the cycle."""
PERCENT = ("", *(f"{10 * i} %" for i in range(11)))


def _level(part: str, quick: bool) -> Cases:
    """Return level walks with every foot."""
    duration = QUICK_DURATION if quick else DURATION
    return cases_of(part, lambda foot: {"": partial(measure, Walk(foot=foot), duration)})


# Errors and landings ------------------------------------------------------------------------------


def _starts(quick: bool) -> Cases:
    n = 2 if quick else N_STARTS
    return cases_of(
        "starts",
        lambda foot: {
            str(i): partial(endure, Walk(foot=foot, begin=(i + 0.5) / n), START_DURATION)
            for i in range(n)
        },
    )


def _long(quick: bool) -> Cases:
    duration = 10.0 if quick else LONG_DURATION
    return cases_of("long", lambda foot: {"": partial(endure, Walk(foot=foot), duration)})


def walk_grids(cached: CachedResults) -> Iterator[Grid]:
    """Return the vertical force in stance."""
    curves = {foot: cached.results.get(f"strides/{foot}", {}).get("load") for foot in FEET}
    means = {foot: np.mean(cycles, axis=0) for foot, cycles in curves.items() if cycles}
    lines = [[foot, *(f"{mean[k]:.2f}" for k in STANCE_POINTS)] for foot, mean in means.items()]
    header = ("", *(f"{x:.0f} %" for x in np.linspace(0, 100, POINTS)[STANCE_POINTS]))
    yield Grid("Vertical force of a foot over its cycle [body weights]", header, lines)


def walk_rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures of walks and their goals."""
    for foot in FEET:
        if starts := cached.select("starts", foot).values():
            yield Row(foot, "decisions learned", training_value(foot, "decisions"))
            stood, n = sum(r["stood"] for r in starts), len(starts)
            yield equal(foot, f"of {n} starts walk 20 s", stood, n)
        r = cached.results.get(f"strides/{foot}", {})
        if "body_rms" in r:
            yield at_most(foot, "joints off the reference", r["body_rms"], 4.0, "deg")
            yield Row(foot, "worst joint off the reference", r["worst_rms"], "deg")
            speed = r["speed"] / r["speed_wanted"]
            yield between(foot, "speed of the reference", speed, 0.95, 1.05)
            yield between(foot, "mean vertical force", r["weight"], 0.98, 1.02, "BW")
            yield at_most(foot, "peak vertical force", r["peak_force"], 1.5, "BW")
            yield Row(foot, "peak vertical force of one foot", r["foot_peak"], "BW")
            yield Row(foot, "double support", 100.0 * r["double"], "%")
            if r["heel_first"] is not None:
                goal = 95.0 if foot == FEET[0] else None
                yield at_least(foot, "heel first", 100.0 * r["heel_first"], goal, "%")
            for name, time in {**r["begins"], "stance": r["stance"]}.items():
                what = "stance" if name == "stance" else f"{name} presses after"
                yield Row(foot, what, None if time is None else 1e3 * time, "ms")
        if time := cached.results.get(f"long/{foot}", {}).get("time"):
            yield at_least(foot, "walks on", time, 10.0 if time < 11 else LONG_DURATION, "s")


WALK = Specification(
    name="learned-walk",
    title="Learned walks",
    parts={"starts": _starts, "strides": partial(_level, "strides"), "long": _long},
    summary=summary,
    grids=walk_grids,
    rows=walk_rows,
    notes=(
        "",
        "The person is the paper's (1.50 m, 48.5 kg, 66 coordinates less those that a foot lacks), "
        "and follows the published mean walk at 1.12 m/s on level ground, at 600 Hz where it was "
        "trained at 150 Hz. The ms of a region are the time from touchdown until it first presses, "
        "the median; the peak of the force is that of plates, low-passed at 20 Hz. One policy "
        "for each foot; learned-feet compares trainings. The paper gives no numbers.",
    ),
)

# Stiffness of the feet ----------------------------------------------------------------------------

PUSH = Push(force=60.0, duration=0.4, direction=np.pi / 2, time=4.0)
GROUNDS = {"level": ("flat", ()), "rough": ("bumps:3", ()), "pushed": ("flat", (PUSH,))}
"""Name → ground and disturbances."""
N_SEEDS = 5
STIFFNESSES = {"learned": False, "held": True}
"""Name → whether the stiffness is held."""


def _held(quick: bool) -> Cases:
    """Return walks with the learned stiffness and with a constant one."""

    def make(foot: str) -> dict[str, Any]:
        return {
            f"{name}/{stiffness}/{seed}": partial(
                endure,
                Walk(foot=foot, ground=ground, seed=seed, begin=seed / N_SEEDS, held=held),
                10.0,
                disturbances,
            )
            for name, (ground, disturbances) in GROUNDS.items()
            for seed in range(1 if quick else N_SEEDS)
            for stiffness, held in STIFFNESSES.items()
        }

    return cases_of("held", make)


def _stiffness(cached: CachedResults) -> Iterator[tuple[str, str, Any]]:
    """Yield foot, joint and the stiffness over its cycles."""
    for foot in FEET:
        for joint, cycles in cached.results.get(f"curves/{foot}", {}).get("stiffness", {}).items():
            if cycles:
                name = "ankle" if joint == "foot" else joint.replace("_", " ")
                yield foot, name, np.array(cycles)


def gain_grids(cached: CachedResults) -> Iterator[Grid]:
    """Return the stiffness over the cycle."""
    lines = []
    for foot, joint, cycles in _stiffness(cached):
        cells = (
            f"{x:.0f}" for x in (*cycles.mean(axis=0)[TENTH_POINTS], cycles.std(axis=0).mean())
        )
        lines.append([f"{foot}, {joint}", *cells])
    yield Grid("Stiffness over the cycle [N m/rad]", (*PERCENT, "SD"), lines)


def gain_rows(cached: CachedResults) -> Iterator[Row]:
    """Return the ratio of greatest and least stiffness, and the shares of completed walks."""
    for foot in FEET:
        for own, joint, cycles in _stiffness(cached):
            if own == foot:
                mean = cycles.mean(axis=0)
                yield Row(foot, f"{joint} greatest by least", float(mean.max() / mean.min()))
        for name in GROUNDS:
            for stiffness in STIFFNESSES:
                if found := cached.select("held", foot, name, stiffness).values():
                    share = 100.0 * float(np.mean([r["stood"] for r in found]))
                    yield Row(foot, f"{name} {stiffness} walked", share, "%")


GAINS = Specification(
    name="gain-curves",
    title="Learned stiffness of the feet",
    parts={"curves": partial(_level, "curves"), "held": _held},
    summary=summary,
    grids=gain_grids,
    rows=gain_rows,
    notes=(
        "",
        "Stiffness in N m/rad at every tenth of the cycle, from heel strike to heel strike, means "
        "of both feet over all cycles of 20 s; 'SD' between cycles. Without an action ankles have "
        "400 and joints of the foot 60. The paper's curves (multi-segment) rise at the ankle and "
        "the third phalanges towards toe-off, are least at the heel as it strikes, and greatest in "
        "mid-stance at the fourth metatarsal and phalanges; it prints axes without units. 'held' "
        "is the same policy with these stiffnesses held at 400 and 60; no policy was trained with "
        "fixed ones for this table.",
    ),
)

# Ankle moment -------------------------------------------------------------------------------------


def _moments(cached: CachedResults) -> Iterator[tuple[str, Any, Any, Any]]:
    """Yield foot, all curves, mean and SD of the measured ones."""
    for foot in FEET:
        r = cached.results.get(f"ankle/{foot}", {})
        if r.get("moment"):
            yield foot, np.array(r["moment"]), *ankle_norm(foot, r["speed"])


def ankle_grids(cached: CachedResults) -> Iterator[Grid]:
    """Return the ankle moment over the cycle."""
    curves: dict[str, Any] = {}
    for foot, cycles, mean, sd in _moments(cached):
        curves = {"measured": mean, "measured, SD": sd} | curves
        curves |= {foot: cycles.mean(axis=0), f"{foot}, SD": cycles.std(axis=0)}
    lines = [[name, *(text_of(y[k], 2) for k in TENTH_POINTS)] for name, y in curves.items()]
    yield Grid("Ankle moment over the cycle [N m/kg]", PERCENT, lines)


def ankle_rows(cached: CachedResults) -> Iterator[Row]:
    """Return the agreement with the measured ankle moment."""
    for foot, cycles, mean, sd in _moments(cached):
        own = cycles.mean(axis=0)
        r, peak, difference = moment_agreement(own, mean).values()
        main = foot == FEET[0]
        yield at_least(foot, "likeness r", r, 0.95 if main else None)
        words = "peak by that measured"
        yield between(foot, words, peak, 0.85, 1.15) if main else Row(foot, words, peak)
        yield Row(foot, "apart", difference, "N m/kg")
        inside = 100.0 * float(np.mean(np.abs(own - mean) <= 2.0 * sd))
        yield Row(foot, "within two SD", inside, "%")


ANKLE = Specification(
    name="ankle-torque",
    title="Ankle moment of learned walks",
    parts={"ankle": partial(_level, "ankle")},
    summary=summary,
    grids=ankle_grids,
    rows=ankle_rows,
    notes=(
        "",
        "Moment of the ankle about its flexion axis by body mass, plantarflexors negative, every "
        "tenth of the cycle; means of both legs over all cycles of 20 s. Measured: 83 children of "
        "4 to 17 years at the same dimensionless speed [Schwartz2008]: no table of adults' moments "
        "is free to be passed on, and the person is 1.50 m tall. The paper shows, without numbers, "
        "that the multi-segment foot is nearer to measured curves than the two-segment foot.",
    ),
)
