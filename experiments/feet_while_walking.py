"""What the kind of foot does for walking: on bumps, pushed, and to the ankle moment.

Secs. 6.2 and 6.3 and Fig. 8 of [Park2020]_, with every foot.
"""

from collections.abc import Iterator, Sequence
from functools import cache, partial
from pathlib import Path

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.measured import Cases, Measured
from experiments.page import Grid
from experiments.table import Row, at_least
from experiments.walking import (
    CONTROLLERS,
    MASS,
    RECORDING,
    SPEED,
    brief,
    figures,
    person,
    recorded,
    runs,
)
from plantigrade.analyze.norms import norm
from plantigrade.arrays import Array, Float
from plantigrade.charts import Ribbon, Series, line_plot
from plantigrade.charts.figure import Figure
from plantigrade.pages.section import Section
from plantigrade.threads import on_one_thread
from plantigrade.workflows.harness import Going, PushedWalk, walk, world_of
from plantigrade.workflows.motions import synthesize
from plantigrade.workflows.other_bodies import on_body
from plantigrade.workflows.simulate_settings import LEARNED
from plantigrade.workflows.walked import Landing
from plantigrade.workflows.walkers import Walker, walker, walks_as
from plantigrade.world.grounds import ground_named

FEET = ("multi-segment", "two-segment", "rigid")
CM, SEEDS, LONG, SHORT = 3, 5, 12.0, 5.0
"""Height of bumps, fields of them, and how long walks last, also in the short form [s]."""
FORCES, ALL = (80, 100), (50, 60, 70, 80, 90, 100)
PUSH, PHASES = 0.4, (0.1, 0.35, 0.6, 0.85)
WITHSTOOD, FELL = 80, 100
"""What the paper's walker withstood and what it did not [N]."""
SETTLED, POINTS = 2.0, 51
"""Cycles count from this time on [s]; points of a curve over the cycle."""
PEAK = (1.45, 0.19)
"""Greatest plantarflexion moment of 138 adults at 1.21 m/s [N m/kg], mean and SD."""
NOTES = (
    "",
    f"CMU 16_15 fitted with every kind of foot, on a person of 1.75 m and {MASS:g} kg. Bumps are "
    f"up to {CM} cm high and low, smoothed over 15 cm; the controller knows the ground. Pushes "
    "come from the right for 0.4 s at the trunk at four phases of the right foot's cycle; the "
    "paper does not say at which. Its walker, a learned policy of 48.5 kg, withstood 80 N and fell "
    "at 100 N: 0.66 and 0.82 m/s; ours are heavier, 100 N are 0.49 m/s. Withstood: on the feet six "
    "seconds later. Ankle moments are held against those of 83 children at a free speed (Schwartz "
    "2008), for no free table of adults has a standard deviation; adults' greatest moment is "
    "1.45 ± 0.19 N m/kg. A landing is heel first where the first force acts behind the ankle.",
)


@cache
def walking_on(controller: str, data: Path | None, feet: str) -> Walker:
    """Return somebody with a kind of feet; of the package's policies that of such feet."""
    if controller == LEARNED:
        return walker(f"{LEARNED}:{feet}")
    who = person(feet=feet)
    if data is None or not (data / RECORDING).exists():
        told = {"speed": SPEED, "periodic": True, "height": who.height, "mass": who.mass}
        return walks_as(controller, synthesize("walk", feet=feet, **told).record)
    return walks_as(controller, on_body(recorded(data / RECORDING, feet), who))


@on_one_thread
def level(controller: str, data: Path | None, feet: str, seconds: float) -> Result:
    """Return a walk on level ground: ankle moments over the cycle, landings on the heel."""
    one = walking_on(controller, data, feet)
    acts = one.controller()
    going = Going(one, acts, world_of(one, acts, recording=True))
    while going.on and going.world.time < seconds - 1e-9:
        going.step()
    found, record = going.walked(), going.world.record()
    curves = []
    for side in ("r", "l"):
        moment = record.torque(f"ankle_angle_{side}") / record.human.mass
        curves += cut(record.motion.time, moment, [x for x in found.landings if x.side == side])
    heels = [x.heel for x in found.landings if x.time > SETTLED]
    curve = np.mean(curves, axis=0) if curves else np.full(POINTS, np.nan)
    return {
        **figures(found),
        "moment": curve,
        "cycles": len(curves),
        "heel": [sum(heels), len(heels)],
    }


def cut(
    time: Float[Array, " n"], values: Float[Array, " n"], landings: Sequence[Landing]
) -> list[Float[Array, " 51"]]:
    """Return a curve over every whole cycle of a foot, from :data:`SETTLED` on."""
    strikes = [x.time for x in landings if x.time > SETTLED]
    return [
        np.interp(np.linspace(begin, end, POINTS), time, values)
        for begin, end in zip(strikes[:-1], strikes[1:], strict=True)
    ]


def bumps(controller: str, data: Path | None, feet: str, seed: int, seconds: float) -> Result:
    """Return a walk over bumps."""
    ground = ground_named(f"bumps:{CM}", seed=seed)
    found = walk(walking_on(controller, data, feet), ground=ground, duration=seconds)
    heels = [x.heel for x in found.landings]
    return {**figures(found), "heel": [sum(heels), len(heels)]}


def pushed(controller: str, data: Path | None, feet: str, force: float, phase: float) -> Result:
    """Return what became of a push from the right."""
    found = PushedWalk(walking_on(controller, data, feet), phase)(force, np.pi / 2, PUSH)
    return {**figures(found), "withstood": found.withstood}


def _level(controllers: Sequence[str], data: Path | None, quick: bool) -> Cases:
    long = SHORT if quick else LONG
    return {
        f"level/{controller}/{feet}/{long:g} s": partial(level, controller, data, feet, long)
        for controller in controllers
        for feet in (FEET[1:2] if quick else FEET)
    }


def _bumps(controllers: Sequence[str], data: Path | None, quick: bool) -> Cases:
    long = SHORT if quick else LONG
    return {
        f"bumps/{controller}/{feet}/{seed}, {long:g} s": partial(
            bumps, controller, data, feet, seed, long
        )
        for controller in controllers
        for feet in (FEET[1:2] if quick else FEET)
        for seed in range(1, 2 if quick else SEEDS + 1)
    }


def _pushes(
    controllers: Sequence[str], data: Path | None, forces: Sequence[int], quick: bool
) -> Cases:
    return {
        f"push/{controller}/{feet}/{force} N at {phase:g}": partial(
            pushed, controller, data, feet, float(force), phase
        )
        for controller in controllers
        for feet in (FEET[1:2] if quick else FEET)
        for force in (forces[:1] if quick else forces)
        for phase in (PHASES[:1] if quick else PHASES)
    }


def _found(kept: KeptResults, part: str) -> dict[tuple[str, str], dict[str, Result]]:
    """Return the results of a part by controller and foot."""
    found: dict[tuple[str, str], dict[str, Result]] = {}
    for key, result in kept.beginning(f"{part}/").items():
        if "error" not in result:
            controller, feet, what = key.split("/", 1)[1].rsplit("/", 2)
            found.setdefault((controller, feet), {})[what] = result
    return found


def likeness(curve: Sequence[float | None]) -> tuple[float, float]:
    """Return correlation with the measured ankle moment and error, root mean square [N m/kg]."""
    ours = np.array([np.nan if x is None else x for x in curve], dtype=float)
    measured = norm("ankle_angle_moment", "free").mean
    if not np.isfinite(ours).all():
        return float("nan"), float("nan")
    r = float(np.corrcoef(ours, measured)[0, 1])
    return r, float(np.sqrt(np.mean((ours - measured) ** 2)))


def table(kept: KeptResults) -> Grid:
    """Return a line for every controller and foot."""
    lines = []
    parts = {part: _found(kept, part) for part in ("level", "bumps", "push")}
    for at in sorted({key for found in parts.values() for key in found}):
        cells = [", ".join(at)]
        flat = list(parts["level"].get(at, {}).values())[-1:]
        if flat and flat[0]["cycles"]:
            r, error = likeness(flat[0]["moment"])
            cells += [f"{r:.2f}", f"{error:.2f}", f"{-min(flat[0]['moment']):.2f}"]
        else:
            cells += ["-"] * 3
        cells.append(f"{flat[0]['heel'][0]} of {flat[0]['heel'][1]}" if flat else "-")
        rough = list(parts["bumps"].get(at, {}).values())
        cells.append(f"{sum(r['survived'] for r in rough)} of {len(rough)}" if rough else "-")
        for force in ALL:
            own = [
                r for what, r in parts["push"].get(at, {}).items() if what.startswith(f"{force} N")
            ]
            cells.append(f"{sum(r['survived'] for r in own)} of {len(own)}" if own else "-")
        lines.append(cells)
    header = (
        "", "ankle r", "error N m/kg", "peak N m/kg", "heel first", f"bumps ±{CM} cm",
        *(f"{force} N" for force in ALL),
    )  # fmt: skip
    return Grid("Feet while walking", header, lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return the figures; those of the multi-segment foot are held against the paper."""
    for (controller, feet), found in _found(kept, "level").items():
        result = list(found.values())[-1]
        subject = f"{controller} {feet}"
        if result["cycles"]:
            r, error = likeness(result["moment"])
            yield Row(subject, "ankle moment, r", r)
            yield Row(subject, "ankle moment, error", error, "N m/kg")
            yield Row(subject, "ankle moment, peak", -min(result["moment"]), "N m/kg")
        if result["heel"][1]:
            share = 100.0 * result["heel"][0] / result["heel"][1]
            yield Row(subject, "landings on the heel", share, "%")
    for (controller, feet), found in _found(kept, "bumps").items():
        share = 100.0 * float(np.mean([r["survived"] for r in found.values()]))
        subject = f"{controller} {feet}"
        if feet == FEET[0]:
            yield at_least(subject, "walked on bumps", share, 100.0, "%")
        else:
            yield Row(subject, "walked on bumps", share, "%")
    for (controller, feet), found in _found(kept, "push").items():
        for force in ALL:
            own = [r for what, r in found.items() if what.startswith(f"{force} N")]
            if not own:
                continue
            share = 100.0 * float(np.mean([r["survived"] for r in own]))
            subject, what = f"{controller} {feet}", f"withstood {force} N"
            if feet == FEET[0] and force <= WITHSTOOD:
                yield at_least(subject, what, share, 100.0, "%")
            else:
                yield Row(subject, what, share, "%")


def pictures(kept: KeptResults) -> list[Section]:
    """Return the ankle moments over the cycle."""
    band = norm("ankle_angle_moment", "free")
    percent = np.linspace(0.0, 100.0, POINTS)
    drawn = [Series(percent, band.mean, "measured, children", dash="4 3")]
    dashes: dict[str, str] = dict(zip(FEET, ("", "8 3", "2 3"), strict=True))
    for (controller, feet), found in _found(kept, "level").items():
        result = list(found.values())[-1]
        if result["cycles"]:
            curve = np.array(result["moment"], dtype=float)
            drawn.append(Series(percent, curve, f"{controller}, {feet}", dash=dashes.get(feet, "")))
    if len(drawn) == 1:
        return []
    svg = line_plot(
        drawn,
        title="Ankle moment",
        x_label="gait cycle [%]",
        y_label="[N m/kg]",
        bands=[Ribbon(percent, band.mean - band.sd, band.mean + band.sd)],
        width=700,
        height=320,
    )
    return [Section("Ankle moment", figures=(Figure(svg, "Plantarflexors are negative."),))]


def _brief(result: Result) -> str:
    told = brief(result)
    if "heel" in result:
        told += ", {} of {} landings on the heel".format(*result["heel"])
    return told


def experiment(controllers: Sequence[str], data: Path | None) -> Measured:
    """Return the experiment for some controllers."""
    return Measured(
        name="feet-while-walking",
        title="Feet while walking",
        parts={
            "level": partial(_level, controllers, data),
            "bumps": partial(_bumps, controllers, data),
            "pushes": partial(_pushes, controllers, data, FORCES),
            "all pushes": partial(_pushes, controllers, data, ALL),
        },
        usual=("level", "bumps", "pushes"),
        shortly=("level", "bumps", "pushes"),
        brief=_brief,
        grids=lambda kept: (table(kept),),
        rows=rows,
        notes=NOTES,
        pictures=pictures,
    )


run = runs(experiment)
EXPERIMENT = experiment(CONTROLLERS, None)
