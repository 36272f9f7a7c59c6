"""Effect of the kind of foot on walking: on bumps, pushed, and on the ankle moment.

Secs. 6.2 and 6.3 and Fig. 8 of [Park2020]_, with every foot.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.specification import Specification
from experiments.table import Row, at_least
from experiments.walk_outcome import Landing
from experiments.walk_trial import PushedWalk, WalkTrial, walk, world_of
from experiments.walkers import Walker, walker, walks_as
from experiments.walking import (
    CONTROLLERS,
    MASS,
    RECORDING,
    SPEED,
    figures,
    person,
    recorded,
    runs,
    summary,
)
from plantigrade.analyze.norms import norm
from plantigrade.arrays import Array, Float
from plantigrade.charts import Ribbon, Series, line_plot
from plantigrade.charts.figure import Figure
from plantigrade.kinematics.transfer import transferred
from plantigrade.options import LEARNED
from plantigrade.pages.section import Section
from plantigrade.threads import on_one_thread
from plantigrade.workflows.motions import synthesize
from plantigrade.world.grounds import ground_named

FEET = ("multi-segment", "two-segment", "rigid")
BUMP_HEIGHT_CM = 3
"""Height of the bumps [cm]."""
N_SEEDS = 5
"""Number of fields of bumps."""
DURATION = 12.0
"""Duration of a walk [s]."""
QUICK_DURATION = 5.0
"""Duration of a walk in the short form [s]."""
FORCES = (80, 100)
"""Pushes that are tried by default [N]."""
ALL_FORCES = (50, 60, 70, 80, 90, 100)
"""Pushes that are tried in the full form [N]."""
PUSH_DURATION = 0.4
"""Duration of a push [s]."""
PUSH_PHASES = (0.1, 0.35, 0.6, 0.85)
"""Phases of the gait cycle at which a push begins [1]."""
PAPER_FORCE = 80
"""Push that the paper's walker withstood [N]."""
SETTLING_TIME = 2.0
"""Time from which gait cycles count [s]."""
N_CURVE_POINTS = 51
"""Points of a curve over the gait cycle."""
NOTES = (
    "",
    f"CMU 16_15 fitted with every kind of foot, on a person of 1.75 m and {MASS:g} kg. Bumps are "
    f"up to {BUMP_HEIGHT_CM} cm high and low, smoothed over 15 cm; the controller knows the "
    "ground. Pushes come from the right for 0.4 s at the trunk at four phases of the right "
    "foot's cycle; the paper does not say at which. Its walker, a learned policy of 48.5 kg, "
    "withstood 80 N and fell at 100 N: 0.66 and 0.82 m/s; ours are heavier, 100 N are 0.49 m/s. "
    "Withstood: on the feet six seconds later. Ankle moments are held against those of 83 "
    "children at a free speed (Schwartz 2008), for no free table of adults has a standard "
    "deviation; adults' greatest moment is 1.45 ± 0.19 N m/kg. A landing is heel first where the "
    "first force acts behind the ankle.",
)


@cache
def walking_on(controller: str, data: Path | None, feet: str) -> Walker:
    """Return the walk with a kind of feet; of the package's policies that of such feet."""
    if controller == LEARNED:
        return walker(f"{LEARNED}:{feet}")
    who = person(feet=feet)
    if data is None or not (data / RECORDING).exists():
        options = {"speed": SPEED, "periodic": True, "height": who.height, "mass": who.mass}
        return walks_as(controller, synthesize("walk", feet=feet, **options).record)
    return walks_as(controller, transferred(recorded(data / RECORDING, feet), who))


@on_one_thread
def level(controller: str, data: Path | None, feet: str, seconds: float) -> Result:
    """Return a walk on level ground: ankle moments over the cycle, landings on the heel."""
    one = walking_on(controller, data, feet)
    acts = one.controller()
    going = WalkTrial(one, acts, world_of(one, acts, recording=True))
    while going.on and going.world.time < seconds - 1e-9:
        going.step()
    found, record = going.walked(), going.world.record()
    curves = []
    for side in ("r", "l"):
        moment = record.torque(f"ankle_angle_{side}") / record.human.mass
        curves += cut(record.motion.time, moment, [x for x in found.landings if x.side == side])
    heels = [x.heel for x in found.landings if x.time > SETTLING_TIME]
    curve = np.mean(curves, axis=0) if curves else np.full(N_CURVE_POINTS, np.nan)
    return {
        **figures(found),
        "moment": curve,
        "cycles": len(curves),
        "heel": [sum(heels), len(heels)],
    }


def cut(
    time: Float[Array, " n"], values: Float[Array, " n"], landings: Sequence[Landing]
) -> list[Float[Array, " 51"]]:
    """Return a curve over every whole cycle of a foot, from :data:`SETTLING_TIME` on."""
    strikes = [x.time for x in landings if x.time > SETTLING_TIME]
    return [
        np.interp(np.linspace(begin, end, N_CURVE_POINTS), time, values)
        for begin, end in zip(strikes[:-1], strikes[1:], strict=True)
    ]


def bumps(controller: str, data: Path | None, feet: str, seed: int, seconds: float) -> Result:
    """Return a walk over bumps."""
    ground = ground_named(f"bumps:{BUMP_HEIGHT_CM}", seed=seed)
    found = walk(walking_on(controller, data, feet), ground=ground, duration=seconds)
    heels = [x.heel for x in found.landings]
    return {**figures(found), "heel": [sum(heels), len(heels)]}


def pushed(controller: str, data: Path | None, feet: str, force: float, phase: float) -> Result:
    """Return the outcome of a push from the right."""
    found = PushedWalk(walking_on(controller, data, feet), phase)(force, np.pi / 2, PUSH_DURATION)
    return {**figures(found), "withstood": found.withstood}


def _each(
    part: str,
    controllers: Sequence[str],
    data: Path | None,
    quick: bool,
    every: Mapping[str, partial],
) -> Cases:
    """Return cases of every controller and foot; ``every`` takes these two and the data."""
    return {
        f"{part}/{controller}/{feet}/{label}": partial(work, controller, data, feet)
        for controller in controllers
        for feet in (FEET[1:2] if quick else FEET)
        for label, work in every.items()
    }


def _level(controllers: Sequence[str], data: Path | None, quick: bool) -> Cases:
    long = QUICK_DURATION if quick else DURATION
    work = {f"{long:g} s": partial(level, seconds=long)}
    return _each("level", controllers, data, quick, work)


def _bumps(controllers: Sequence[str], data: Path | None, quick: bool) -> Cases:
    long = QUICK_DURATION if quick else DURATION
    seeds = range(1, 2 if quick else N_SEEDS + 1)
    work = {f"{seed}, {long:g} s": partial(bumps, seed=seed, seconds=long) for seed in seeds}
    return _each("bumps", controllers, data, quick, work)


def _pushes(
    forces: Sequence[int], controllers: Sequence[str], data: Path | None, quick: bool
) -> Cases:
    work = {
        f"{force} N at {phase:g}": partial(pushed, force=float(force), phase=phase)
        for force in (forces[:1] if quick else forces)
        for phase in (PUSH_PHASES[:1] if quick else PUSH_PHASES)
    }
    return _each("push", controllers, data, quick, work)


def _found(cached: CachedResults, part: str) -> dict[str, dict[str, Result]]:
    """Return the results of a part by controller and foot, then by what was done."""
    found: dict[str, dict[str, Result]] = {}
    for key, result in cached.select(part).items():
        controller, feet, what = key.split("/", 1)[1].rsplit("/", 2)
        found.setdefault(f"{controller} {feet}", {})[what] = result
    return found


def likeness(curve: Sequence[float | None]) -> tuple[float, float]:
    """Return correlation with the measured ankle moment and error, root mean square [N m/kg]."""
    ours = np.array([np.nan if x is None else x for x in curve], dtype=float)
    measured = norm("ankle_angle_moment", "free").mean
    if not np.isfinite(ours).all():
        return float("nan"), float("nan")
    r = float(np.corrcoef(ours, measured)[0, 1])
    return r, float(np.sqrt(np.mean((ours - measured) ** 2)))


def _goal(subject: str) -> float | None:
    return 100.0 if subject.endswith(f" {FEET[0]}") else None


def _share(results: Iterable[Result]) -> float:
    return 100.0 * float(np.mean([r["survived"] for r in results]))


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures; those of the multi-segment foot are compared with the paper."""
    for subject, found in _found(cached, "level").items():
        result = list(found.values())[-1]
        if result["cycles"]:
            r, error = likeness(result["moment"])
            yield Row(subject, "ankle moment, r", r)
            yield Row(subject, "ankle moment, error", error, "N m/kg")
            yield Row(subject, "ankle moment, peak", -min(result["moment"]), "N m/kg")
        if result["heel"][1]:
            share = 100.0 * result["heel"][0] / result["heel"][1]
            yield Row(subject, "landings on the heel", share, "%")
    for subject, found in _found(cached, "bumps").items():
        yield at_least(subject, "walked on bumps", _share(found.values()), _goal(subject), "%")
    for subject, found in _found(cached, "push").items():
        for force in ALL_FORCES:
            own = [r for what, r in found.items() if what.startswith(f"{force} N")]
            if own:
                goal = _goal(subject) if force <= PAPER_FORCE else None
                yield at_least(subject, f"withstood {force} N", _share(own), goal, "%")


def pictures(cached: CachedResults) -> list[Section]:
    """Return the ankle moments over the cycle."""
    band = norm("ankle_angle_moment", "free")
    percent = np.linspace(0.0, 100.0, N_CURVE_POINTS)
    drawn = [Series(percent, band.mean, "measured, children", dash="4 3")]
    dashes: dict[str, str] = dict(zip(FEET, ("", "8 3", "2 3"), strict=True))
    for subject, found in _found(cached, "level").items():
        result = list(found.values())[-1]
        if result["cycles"]:
            curve = np.array(result["moment"], dtype=float)
            dash = dashes.get(subject.rpartition(" ")[2], "")
            drawn.append(Series(percent, curve, subject, dash=dash))
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


def _summary(result: Result) -> str:
    text = summary(result)
    if "heel" in result:
        text += ", {} of {} landings on the heel".format(*result["heel"])
    return text


def experiment(controllers: Sequence[str], data: Path | None) -> Specification:
    """Return the experiment for some controllers."""
    return Specification(
        name="feet-while-walking",
        title="Feet while walking",
        parts={
            "level": partial(_level, controllers, data),
            "bumps": partial(_bumps, controllers, data),
            "pushes": partial(_pushes, FORCES, controllers, data),
            "all pushes": partial(_pushes, ALL_FORCES, controllers, data),
        },
        default_parts=("level", "bumps", "pushes"),
        summary=_summary,
        rows=rows,
        notes=NOTES,
        pictures=pictures,
    )


run = runs(experiment)
EXPERIMENT = experiment(CONTROLLERS, None)
