"""Push limits of a walk: every direction at every phase of the gait, by bisection.

Table of pushes of the pendulum paper [Tsai2010]_, which does not say at which phase it pushed. A
push counts as withstood if the person is back to the recorded gait six seconds after it
(:mod:`experiments.walk_trial`), not just on the feet. The same for a standing person who
may step, and pushes that people took.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from experiments.altered_people import torque_limits
from experiments.cached_results import CachedResults, Cases, Result
from experiments.human_pushes import N_PUSHES, people_cases, people_rows, pushed_summary
from experiments.last_pushed import pushed_at
from experiments.push_limits import PushTest, directions, push_limit
from experiments.push_shares import push_summary, share_cases, share_rows, survived_rows
from experiments.push_table import polar
from experiments.specification import Specification, default_summary, gap_remarks
from experiments.standing import Standing, is_standing
from experiments.table import Grid, Row, at_least
from experiments.walk_trial import WATCH_TIME
from experiments.walkers import guest_named
from experiments.walking import CONTROLLERS, HEIGHT, MASS, person, runs, walking
from plantigrade.charts import path_plot
from plantigrade.charts.figure import grid
from plantigrade.constants import GRAVITY
from plantigrade.errors import ParameterError
from plantigrade.pages.section import Section

FORCE_DURATION = 0.4
"""Duration of the pushes of the parts ``force`` and ``stronger`` [s]."""
IMPULSE_DURATION = 0.2
"""Duration of the pushes of the part ``impulse`` [s]."""
N_DIRECTIONS = 8
"""Directions of the usual map."""
N_PHASES = 4
"""Phases of the gait cycle of the usual map."""
N_DIRECTIONS_FULL = 16
"""Directions of the full map."""
N_PHASES_FULL = 10
"""Phases of the gait cycle of the full map."""
FORCE_STEP = 50.0
"""Distance of the tried forces in the usual map [N]."""
FORCE_STEP_FULL = 20.0
"""Distance of the tried forces in the full map [N]."""
MAX_FORCE = 1000.0
"""Greatest push that is tried [N]."""
STRENGTH_FACTOR = 2.0
"""Strength of the joints in the part ``stronger``, relative to people [1]."""
KINDS = {
    "force": (FORCE_DURATION, 1.0),
    "impulse": (IMPULSE_DURATION, 1.0),
    "stronger": (FORCE_DURATION, STRENGTH_FACTOR),
}
"""Part → how long its pushes act, and how strong the joints are."""
MIN_MEDIAN_LIMIT = 400.0
"""Goal of the median push limit [N]."""
MIN_WORST_LIMIT = 250.0
"""Goal of the least push limit [N]."""
MAX_IMPACT = 6.0
"""Goal: greatest vertical force on a foot after a survived push [body weights]. Nobody lands harder
without harm."""
MAX_IMPACT_PUSH = 300.0
"""Pushes up to which that goal counts [N]."""
PAPER_FORCES = (486.02, 478.60, 456.24, 452.43, 457.72, 452.60, 469.68, 467.22)
"""Sizes of the paper's eight pushes [N]: its components, some of whose signs are lost in print."""
NOTES = (
    "",
    f"A person of {HEIGHT:g} m and {MASS:g} kg (the paper's mass) walks CMU 16_15 and is pushed "
    "at the trunk's centre of mass, direction fixed in the world: 0° forward, 90° to the left; "
    "phase 0 is the strike of the right foot. Withstood: on the feet six seconds after the push, "
    "no leg through the other, and the last stride within 20 % of the recorded speed and 5 cm of "
    "the recorded height of the centre of mass. Bodies are solid. 'on feet' asks only for the "
    "first. Shares are of single pushes, at phases between those of the map. "
    "Limits by bisection on a grid, 50 N in the usual map and 20 N in the full one; one "
    "lighter push (half the limit) is tried after it. Survived pushes with a landing beyond "
    f"{MAX_IMPACT:g} body weights, which no person bears, are listed apart. "
    "Paper: 452 to 486 N × 0.4 s, phase unstated; "
    "SIMBICON 340 N sagittal; study: median 400 N, worst 200 N, on the feet only, legs through "
    "each other. People: lateral pushes at the upper arm while walking 0.33 to 1.46 m/s, here at "
    "the trunk; some crouched, ours walk upright. Their start is a percentage of the step from the "
    "strike of the foot that stands; the side is inferred from the program published beside them.",
)


def limit(
    controller: str,
    data: Path | None,
    duration: float,
    phase: float,
    degrees: float,
    step: float,
    strength: float,
) -> Result:
    """Return the largest push withstood at a phase, in a direction."""
    guest = guest_named(controller)
    if guest is not None and strength != 1.0:
        raise ParameterError(f"{controller}: the part 'stronger' is for persons alone")
    one = guest or walking(controller, data, HEIGHT, MASS, strength)
    pushed = pushed_at(one, phase)
    feet: dict[float, bool] = {}
    impacts: dict[float, float] = {}
    bends: dict[float, float] = {}
    leans: dict[float, float] = {}

    def withstands(force: float) -> bool:
        found = pushed(force, float(np.deg2rad(degrees)), duration, WATCH_TIME)
        feet[force] = found.survived
        if found.survived:
            impacts[force], bends[force], leans[force] = found.peak, found.bend, found.lean
        return found.withstood

    found = push_limit(withstands, guess=MIN_MEDIAN_LIMIT, step=step, most=MAX_FORCE, below=(0.5,))
    return {
        "force": found.force,
        "gaps": list(found.gaps),
        "tried": len(found.tried),
        "on_feet": max((f for f, stood in feet.items() if stood), default=0.0),
        "impacts": impacts,
        "bends": bends,
        "leans": leans,
        "grid": step,
        "open": found.open,
        "mass": pushed.mass,
        "speed": pushed.speed,
    }


def standing(degrees: float, step: float) -> Result:
    """Return the largest push of a standing person who may step."""
    situation = Standing(formulation="stepping", height=HEIGHT, mass=MASS)
    test = PushTest(
        situation=situation, duration=FORCE_DURATION, watch_time=5.0, withstood=is_standing
    )
    found = test.limit(float(np.deg2rad(degrees)), guess=200.0, step=step, below=(0.5,))
    return {"force": found.force, "gaps": list(found.gaps), "grid": step}


def _size(quick: bool, full: bool) -> tuple[tuple[float, ...], tuple[float, ...], float]:
    """Return phases, directions [deg] and the distance of forces [N]."""
    if quick:
        return (0.3,), (0.0, 90.0), 2 * FORCE_STEP
    phases, around = (N_PHASES_FULL, N_DIRECTIONS_FULL) if full else (N_PHASES, N_DIRECTIONS)
    degrees = tuple(round(float(np.rad2deg(d)), 1) for d in directions(around))
    return (
        tuple(k / phases for k in range(phases)),
        degrees,
        FORCE_STEP_FULL if full else FORCE_STEP,
    )


def map_cases(
    controllers: Sequence[str], data: Path | None, kind: str, full: bool, quick: bool
) -> Cases:
    """Return every direction at every phase; one phase after the other."""
    duration, strength = KINDS[kind]
    phases, degrees, step = _size(quick, full)
    return {
        f"{kind}/{controller}/{phase:g}/{d:g}/{step:g}": partial(
            limit, controller, data, duration, phase, d, step, strength
        )
        for controller in controllers
        for phase in phases
        for d in degrees
    }


def standing_cases(quick: bool) -> Cases:
    """Return all directions for a standing person."""
    degrees = (0.0,) if quick else _size(False, True)[1]
    step = 2 * FORCE_STEP if quick else FORCE_STEP_FULL
    return {f"standing/{d:g}/{step:g}": partial(standing, d, step) for d in degrees}


Map = dict[tuple[float, float], Result]


def maps(cached: CachedResults) -> dict[tuple[str, str], Map]:
    """Return the limits by part and controller, then by phase and direction.

    Of several grids the finest counts.
    """
    found: dict[tuple[str, str], Map] = {}
    for key, result in cached.select().items():
        kind, _, rest = key.partition("/")
        if kind in KINDS:
            controller, phase, degrees, _ = rest.rsplit("/", 3)
            own = found.setdefault((kind, controller), {})
            others = [r["grid"] for r in own.values()]
            if others and result["grid"] < min(others):
                own.clear()
            elif others and result["grid"] > min(others):
                continue
            own[float(phase), float(degrees)] = result
    return found


def tables(cached: CachedResults) -> Iterator[Grid]:
    """Return the maps: a line a phase, a column a direction."""
    for (kind, controller), found in maps(cached).items():
        phases = sorted({p for p, _ in found})
        degrees = sorted({d for _, d in found})
        lines = []
        for p in phases:
            row = [found.get((p, d)) for d in degrees]
            lines.append(
                [f"{100 * p:g} %", *("-" if r is None else f"{r['force']:g}" for r in row)]
            )
        header = ("phase \\ towards [deg]", *(f"{d:g}" for d in degrees))
        yield Grid(f"{controller}, {kind}: largest push [N]", header, lines)


def _survived(found: Map, what: str) -> list[tuple[float, float, float, float]]:
    """Return phase, direction [deg], force [N] and a figure of survived pushes.

    Args:
        what: ``impacts`` [body weights], ``bends`` or ``leans`` [deg].
    """
    return [
        (p, d, float(force), value)
        for (p, d), r in sorted(found.items())
        for force, value in r.get(what, {}).items()
        if float(force) > 0.0
    ]


def hard_landings(cached: CachedResults) -> Iterator[Grid]:
    """Return the survived pushes after which a foot lands harder than a person bears."""
    for (kind, controller), found in maps(cached).items():
        lines = [
            [f"{100 * p:g} %", f"{d:g}", f"{force:g}", f"{impact:.1f}"]
            for p, d, force, impact in _survived(found, "impacts")
            if impact > MAX_IMPACT
        ]
        title = (
            f"{controller}, {kind}: survived, but landed with more than {MAX_IMPACT:g} body weights"
        )
        yield Grid(title, ("phase", "towards [deg]", "push [N]", "body weights"), lines)


def strengths() -> Grid:
    """Return the torque limits that hold."""
    lines = [
        [name, f"{low:.0f}", f"{high:.0f}"] for name, (low, high) in torque_limits(person()).items()
    ]
    return Grid("Torque limits: those of people [N m]", ("hinge", "least", "most"), lines)


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return worst, median and best limit, with their goals; pushes that people took."""
    for (kind, controller), found in maps(cached).items():
        force = np.array([r["force"] for r in found.values()])
        feet = np.array([r["on_feet"] for r in found.values()])
        subject, middle = f"{controller} {kind}", float(np.median(force))
        goals = (
            (MIN_MEDIAN_LIMIT, MIN_WORST_LIMIT)
            if kind != "impulse" and len(force) > 2
            else (None, None)
        )
        yield at_least(subject, "median", middle, goals[0], "N")
        yield at_least(subject, "worst", float(force.min()), goals[1], "N")
        yield Row(subject, "best", float(force.max()), "N")
        yield Row(subject, "worst on feet", float(feet.min()), "N")
        yield Row(subject, "median on feet", float(np.median(feet)), "N")
        yield from _by_body(subject, middle, KINDS[kind][0], mass_of(found))
        usual = {
            what: [value for _, _, f, value in _survived(found, what) if f <= MAX_IMPACT_PUSH]
            for what in ("impacts", "bends", "leans")
        }
        yield from survived_rows(subject, MAX_IMPACT_PUSH, MAX_IMPACT, **usual)
        yield Row(subject, "cases", len(force))
    if own := [r["force"] for r in cached.select("standing").values()]:
        middle = float(np.median(own))
        yield Row("standing with steps", "median", middle, "N")
        yield Row("standing with steps", "worst", float(min(own)), "N")
        yield Row("standing with steps", "best", float(max(own)), "N")
        yield from _by_body("standing with steps", middle, FORCE_DURATION, MASS)
    yield from share_rows(cached, MIN_MEDIAN_LIMIT, MAX_IMPACT_PUSH, MAX_IMPACT)
    yield from people_rows(cached)


def mass_of(found: Map) -> float:
    """Return the mass of the body of a map [kg]; results of former versions are of our person."""
    return float(next(iter(found.values())).get("mass", MASS))


def _by_body(subject: str, force: float, duration: float, mass: float) -> Iterator[Row]:
    """Return the median limit as an impulse, relative to body mass and to body weight."""
    yield Row(subject, "median impulse", force * duration, "N s")
    yield Row(subject, "median change of speed", force * duration / mass, "m/s")
    yield Row(subject, "median by weight", 100 * force / (mass * GRAVITY), "%")


def pictures(cached: CachedResults) -> list[Section]:
    """Return the maps as drawings, one for each phase: forward to the right, left up."""
    sections = []
    for (kind, controller), found in maps(cached).items():
        drawn = []
        circle = dict.fromkeys(np.arange(0.0, 360.0, 5.0).tolist(), MIN_MEDIAN_LIMIT)
        most = max(
            MIN_MEDIAN_LIMIT, *(r["on_feet"] for r in found.values())
        )  # one scale for all phases
        frame = replace(polar(dict.fromkeys(circle, most)), opacity=0.0)
        for p in sorted({p for p, _ in found}):
            own = {d: r for (q, d), r in found.items() if q == p}
            if len(own) < 3:
                continue
            lines = [frame, polar(circle, "400 N", "2 4")]
            for name, label, dash in (
                ("force", "back to the gait", ""),
                ("on_feet", "on the feet", "5 3"),
            ):
                lines.append(polar({d: r[name] for d, r in own.items()}, label, dash))
            title = f"{100 * p:g} % of the cycle"
            drawn.append(
                path_plot(
                    lines, title=title, x_label="forward [N]", y_label="to the left [N]",
                    width=400, max_height=390,
                )
            )  # fmt: skip
        if drawn:
            title = f"Map of pushes: {controller}, {kind}"
            sections.append(Section(title, figures=(grid(drawn, columns=2),)))
    return sections


def _summary(result: Result) -> str:
    """Return one line about a limit, a push of one force, or one that people took."""
    if "force" in result:
        return default_summary(result)
    return push_summary(result) if "impact" in result else pushed_summary(result)


def experiment(controllers: Sequence[str], data: Path | None) -> Specification:
    """Return the experiment for some controllers."""

    def of_map(kind: str, full: bool) -> Callable[[bool], Cases]:
        return partial(map_cases, controllers, data, kind, full)

    return Specification(
        name="push-map",
        title="Pushes that a walk withstands",
        parts={
            "force": of_map("force", False),
            "impulse": of_map("impulse", False),
            "full": of_map("force", True),
            "full impulse": of_map("impulse", True),
            "stronger": of_map("stronger", False),
            "shares": partial(share_cases, controllers, data, FORCE_DURATION),
            "standing": standing_cases,
            "people": partial(people_cases, controllers, data, N_PUSHES),
            "all people": partial(people_cases, controllers, data, None),
        },
        default_parts=("force", "people"),
        summary=_summary,
        grids=lambda cached: (*tables(cached), *hard_landings(cached), strengths()),
        rows=rows,
        notes=NOTES,
        remarks=gap_remarks,
        pictures=pictures,
    )


run = runs(experiment, guests=True)
EXPERIMENT = experiment(CONTROLLERS, None)
