"""The largest pushes that a standing person withstands, by foot, formulation and direction.

Table 1 of [Park2020]_, with the limit of a pendulum on the same base of support
(:func:`~experiments.push_limits.predicted_limit`), and a map of sixteen directions.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.push_limits import PushTest, directions, on_feet, predicted_limit
from experiments.specification import Specification, gap_remarks
from experiments.standing import FEET, FORMULATIONS, MASS, PUSHES, Standing, is_standing
from experiments.table import Grid, Row, at_least
from plantigrade.charts import Series, path_plot
from plantigrade.charts.figure import Figure
from plantigrade.constants import GRAVITY
from plantigrade.pages.section import Section

DURATION = 0.4
"""Duration of a push [s]."""
WATCH_TIME = 5.0
"""Time on the feet after a push [s]."""
FORCE_STEP = 2.5
"""Distance of the tried forces [N]."""
PAPER_FORCES = {"two-segment": (45.0, 50.0, 40.0), "multi-segment": (65.0, 75.0, 50.0)}
SUM = 205.0
"""Goal of the sum of the three limits [N]."""
STANCES = (0.35, 0.45, 0.55, 0.65)
"""Positions of the centre of mass over the soles, from the heels."""
N_DIRECTIONS = 16
FORMULATION = "torque"
"""The formulation that is compared with the paper."""
STEPPING = {"in place": FORMULATION, "stepping": "stepping"}
"""Strategies of the map → formulation."""
MIN_RATIO = 3.0
"""Goal of the limit with steps, by that in place, in every direction."""
SIZES = ((1.60, 55.0), (1.90, 95.0))
"""Other bodies [m, kg]; constants were chosen on the paper's."""
NOTES = (
    "",
    f"Pushes of {DURATION:g} s at the centre of mass of the trunk of a person of {MASS:g} kg; a "
    f"push is withstood if nothing but the feet has touched the ground {WATCH_TIME:g} s after it. "
    "With steps they must also be upright and at rest by then, legs not crossed, and the grid is "
    f"{4 * FORCE_STEP:g} N. 'front' is a push from the front. Limits by bisection to "
    f"{FORCE_STEP:g} N; three lighter pushes are tried below each, and forces at which the person "
    "fell all the same are named. 'pendulum' is what shifting the pressure to the edge of the "
    "base of support can stop; it is the same for all feet, for their contact points are the "
    "same. People: 626 lateral pushes while walking changed the speed by 0.52 ± 0.10 m/s, 26.7 ± "
    "7 % of body weight for 0.2 s; who stands and may not step withstands about 0.48 m/s forward "
    "(an estimate).",
)

StandingCases = dict[str, Standing]
"""First part of a key → the person; each is pushed from three sides."""


def paper_cases(quick: bool) -> StandingCases:
    """Return every foot and formulation."""
    return {
        f"paper/{formulation}/{foot}": Standing(foot, formulation)
        for formulation in ((FORMULATION,) if quick else FORMULATIONS)
        for foot in (FEET[:2] if quick else FEET)
    }


def stance_cases(quick: bool) -> StandingCases:
    """Return feet with the centre of mass at other positions over the soles."""
    return {
        f"stances/{ahead:g}/{foot}": Standing(foot, FORMULATION, ahead=ahead)
        for ahead in (STANCES[:1] if quick else STANCES)
        for foot in FEET[:2]
    }


def size_cases(quick: bool) -> StandingCases:
    """Return other bodies with the same setting, without and with steps."""
    return {
        f"sizes/{height:g} m {mass:g} kg, {name}": Standing(
            formulation=formulation, height=height, mass=mass
        )
        for height, mass in (SIZES[:1] if quick else SIZES)
        for name, formulation in STEPPING.items()
    }


def _three_sides(make: Callable[[bool], StandingCases], quick: bool) -> Cases:
    return {
        f"{key}/{side}": partial(measure, standing, direction)
        for key, standing in make(quick).items()
        for side, direction in PUSHES.items()
    }


def map_cases(quick: bool) -> Cases:
    """Return sixteen directions, in degrees to the left of forward, without and with steps."""
    return {
        f"map/{name}/{np.rad2deg(direction):g}": partial(
            measure, Standing(formulation=formulation), direction
        )
        for name, formulation in STEPPING.items()
        for direction in directions(4 if quick else N_DIRECTIONS)
    }


def measure(standing: Standing, direction: float) -> Result:
    """Return the limit in a direction, and the pendulum's."""
    steps = standing.formulation == "stepping"
    factor, withstood = (2, is_standing) if steps else (1, on_feet)
    test = PushTest(
        situation=standing, duration=DURATION, watch_time=WATCH_TIME, withstood=withstood
    )
    expected = predicted_limit(standing()[0], direction, DURATION)
    step = factor**2 * FORCE_STEP
    limit = test.limit(direction, guess=factor * expected, step=step)
    return {
        "force": limit.force,
        "sure": min((*limit.gaps, limit.force + step)) - step,
        "gaps": list(limit.gaps),
        "tried": len(limit.tried),
        "pendulum": expected,
    }


def _summary(result: Result) -> str:
    return f"{result['force']:g} N (pendulum {result['pendulum']:.0f})"


def _limits(cached: CachedResults, *names: object) -> tuple[list, list]:
    """Return the limits from three sides and those of the pendulum; empty if one is missing."""
    found = [cached.results.get("/".join(map(str, (*names, side))), {}) for side in PUSHES]
    if not all("force" in r for r in found):
        return [], []
    return [r["force"] for r in found], [r["pendulum"] for r in found]


def _cells(forces: Sequence[float]) -> list[str]:
    return [f"{force:g}" for force in forces]


def grids(cached: CachedResults) -> Iterator[Grid]:
    """Return the paper's table and ours."""
    header = ("", *PUSHES, "sum", "/ pendulum", "", "", "% weight", "", "", "m/s", "", "")
    lines = [
        [f"paper, {foot}", *_cells((*f, sum(f))), *[""] * 9] for foot, f in PAPER_FORCES.items()
    ]
    for formulation in FORMULATIONS:
        for foot in FEET:
            forces, pendulum = map(np.array, _limits(cached, "paper", formulation, foot))
            if len(forces):
                cells = [f"{formulation}, {foot}", *_cells((*forces, forces.sum()))]
                cells += [f"{x:.2f}" for x in forces / pendulum]
                cells += [f"{x:.1f}" for x in 100 * forces / (MASS * GRAVITY)]
                lines.append([*cells, *(f"{x:.2f}" for x in forces * DURATION / MASS)])
    yield Grid("Largest push [N], by what a pendulum withstands, and by the body", header, lines)


def _map(cached: CachedResults) -> dict[str, dict[float, Result]]:
    """Return the results of the map: strategy → direction [deg] → result."""
    found: dict[str, dict[float, Result]] = {}
    for key, result in cached.select("map").items():
        _, name, degrees = key.split("/")
        found.setdefault(name, {})[float(degrees)] = result
    return found


def _ratios(cached: CachedResults) -> Iterator[tuple[float, Result, float]]:
    """Yield direction [deg], the result with steps, and the limit in place [N]."""
    found = _map(cached)
    in_place = found.get("in place", {})
    for degrees, result in sorted(found.get("stepping", {}).items()):
        if degrees in in_place:
            yield degrees, result, in_place[degrees]["force"]


def polar(sizes: Mapping[float, float], label: str = "", dash: str = "") -> Series:
    """Return a closed curve of sizes by direction [deg]: forward to the right, left up."""
    degrees = [*sorted(sizes), min(sizes)]
    angles, size = np.deg2rad(degrees), np.array([sizes[d] for d in degrees])
    return Series(size * np.cos(angles), size * np.sin(angles), label, dash=dash)


def pictures(cached: CachedResults) -> list[Section]:
    """Return the map as a drawing."""
    series = []
    for strategy, found in _map(cached).items():
        series.append(polar({d: r["force"] for d, r in found.items()}, strategy))
        series.append(polar({d: r["pendulum"] for d, r in found.items()}, "pendulum", "4 3"))
    if not series:
        return []
    drawn = path_plot(
        series, title="Map of pushes", x_label="forward [N]", y_label="to the left [N]"
    )
    caption = "Pushes withstood, from the middle to where they push; dashed: the pendulum."
    return [Section("Map", figures=(Figure(drawn, caption),))]


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the limits, with goals of the paper's foot and of steps."""
    subject, main = f"{FORMULATION} multi-segment", ("paper", FORMULATION, "multi-segment")
    for side, goal in zip(PUSHES, PAPER_FORCES["multi-segment"], strict=True):
        for result in cached.select(*main, side).values():
            yield at_least(subject, side, result["force"], goal, "N")
    if forces := _limits(cached, *main)[0]:
        yield at_least(subject, "sum", float(sum(forces)), SUM, "N")
    for degrees, result, place in _ratios(cached):
        if place:
            ratio = result["force"] / place
            yield at_least("steps, towards", f"{degrees:g} deg", ratio, MIN_RATIO, "times")
        yield Row("every lighter push was withstood, steps", f"{degrees:g}", result["sure"], "N")
    for key, result in cached.select().items():
        if not key.startswith("/".join(main)):
            of, _, side = key.replace("/", " ").rpartition(" ")
            yield Row(of, side, result["force"], "N")
            yield Row(f"{of}, pendulum", side, result["pendulum"], "N")


EXPERIMENT = Specification(
    name="push-table",
    title="Pushes that standing people withstand",
    parts={
        "paper": partial(_three_sides, paper_cases),
        "stances": partial(_three_sides, stance_cases),
        "map": map_cases,
        "sizes": partial(_three_sides, size_cases),
    },
    default_parts=("paper",),
    summary=_summary,
    grids=grids,
    rows=rows,
    notes=NOTES,
    remarks=gap_remarks,
    pictures=pictures,
)
