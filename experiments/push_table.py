"""The largest pushes that a standing person withstands, by foot, formulation and direction.

Table 1 of [Park2020]_, with what a pendulum on the same base of support would withstand beside it
(:func:`~plantigrade.world.push_limits.predicted_limit`), and a map of sixteen directions.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.measured import Cases, Measured
from experiments.page import Grid
from experiments.standing import FORMULATIONS, MASS, ORDER, Standing, stands
from experiments.table import Row, at_least
from plantigrade.charts import Series, path_plot
from plantigrade.charts.figure import Figure
from plantigrade.constants import GRAVITY
from plantigrade.pages.section import Section
from plantigrade.world.push_limits import PushTest, directions, on_feet, predicted_limit

DURATION, WATCH, STEP = 0.4, 5.0, 2.5  # of a push [s], of what follows [s], of the forces [N]
SIDES = {"front": np.pi, "side": np.pi / 2, "back": 0.0}
"""Where a push comes from, as the paper calls it → where it goes to [rad]."""
PAPER = {"two-segment": (45.0, 50.0, 40.0), "multi-segment": (65.0, 75.0, 50.0)}
SUM = 205.0  # front + side + back [N]
STANCES = (0.35, 0.45, 0.55, 0.65)
"""Places of the centre of mass over the soles, from the heels."""
N_MAP = 16
FORMULATION = "torque"
"""The formulation that is held against the paper's numbers."""
WAYS = {"in place": FORMULATION, "stepping": "stepping"}
"""What the map compares → formulation."""
TIMES = 3.0
"""How much more is to be withstood with steps than in place, in every direction."""
SIZES = ((1.60, 55.0), (1.90, 95.0))
"""Other bodies [m, kg]; constants are settled on the paper's."""
NOTES = (
    "",
    f"Pushes of {DURATION:g} s at the centre of mass of the trunk of a person of {MASS:g} kg; a "
    f"push is withstood if nothing but the feet has touched the ground {WATCH:g} s after it. "
    "With steps they must also be upright and at rest by then, legs not crossed, and the grid is "
    f"{4 * STEP:g} N. 'front' is a push from the front. Limits by bisection to {STEP:g} N; three "
    "lighter pushes are tried below each, and forces at which the person fell all the same are "
    "named. 'pendulum' is what shifting the pressure to the edge of the base of support can stop; "
    "it is the same for all feet, for their contact points are the same. People: 626 lateral "
    "pushes while walking changed the speed by 0.52 ± 0.10 m/s, 26.7 ± 7 % of body weight for 0.2 "
    "s; who stands and may "
    "not step withstands about 0.48 m/s forward (an estimate).",
)


Case = tuple[Standing, float]


def paper_cases(quick: bool) -> dict[str, Case]:
    """Return every foot and formulation from three sides."""
    feet = ORDER[:2] if quick else ORDER
    ways = (FORMULATION,) if quick else FORMULATIONS
    return {
        f"paper/{way}/{foot}/{side}": (Standing(foot, way), towards)
        for way in ways
        for foot in feet
        for side, towards in SIDES.items()
    }


def stance_cases(quick: bool) -> dict[str, Case]:
    """Return every foot with the centre of mass at other places over the soles."""
    return {
        f"stances/{ahead:g}/{foot}/{side}": (Standing(foot, FORMULATION, ahead=ahead), towards)
        for ahead in (STANCES[:1] if quick else STANCES)
        for foot in ORDER[:2]
        for side, towards in SIDES.items()
    }


def map_cases(quick: bool) -> dict[str, Case]:
    """Return sixteen directions, in degrees to the left of forward, without and with steps."""
    return {
        f"map/{name}/{np.rad2deg(towards):g}": (Standing(formulation=way), towards)
        for name, way in WAYS.items()
        for towards in directions(4 if quick else N_MAP)
    }


def size_cases(quick: bool) -> dict[str, Case]:
    """Return other bodies with the same setting, without and with steps."""
    return {
        f"sizes/{height:g} m {mass:g} kg, {name}/{side}": (
            Standing(formulation=way, height=height, mass=mass),
            towards,
        )
        for height, mass in (SIZES[:1] if quick else SIZES)
        for name, way in WAYS.items()
        for side, towards in SIDES.items()
    }


def measure(standing: Standing, towards: float) -> dict[str, Any]:
    """Return the limit in a direction, and the pendulum's."""
    steps = standing.formulation == "stepping"
    test = PushTest(
        situation=standing,
        duration=DURATION,
        watch_time=WATCH,
        withstood=stands if steps else on_feet,
    )
    expected = predicted_limit(standing()[0], towards, DURATION)
    step = (4 if steps else 1) * STEP
    limit = test.limit(towards, guess=(2 if steps else 1) * expected, step=step)
    return {
        "force": limit.force,
        "sure": min((*limit.gaps, limit.force + step)) - step,
        "gaps": list(limit.gaps),
        "tried": len(limit.tried),
        "pendulum": expected,
    }


def _brief(result: Result) -> str:
    return f"{result['force']:g} N (pendulum {result['pendulum']:.0f})"


def _forces(kept: KeptResults, start: str, name: str = "force") -> list[float | None]:
    return [kept.results.get(f"{start}/{side}", {}).get(name) for side in SIDES]


def _cells(forces: Sequence[float | None]) -> list[str]:
    return ["-" if f is None else f"{f:g}" for f in forces]


def table(kept: KeptResults) -> Grid:
    """Return the paper's table and ours, absolute and relative to the body."""
    header = ("", *SIDES, "sum", "/ pendulum", "", "", "% weight", "", "", "m/s", "", "")
    lines = [[f"paper, {foot}", *_cells(f), f"{sum(f):g}", *[""] * 9] for foot, f in PAPER.items()]
    for way in FORMULATIONS:
        for foot in ORDER:
            forces = _forces(kept, f"paper/{way}/{foot}")
            expected = _forces(kept, f"paper/{way}/{foot}", "pendulum")
            if any(f is None for f in (*forces, *expected)):
                continue
            f, p = np.array(forces, float), np.array(expected, float)
            cells = [f"{way}, {foot}", *_cells(forces), f"{f.sum():g}"]
            cells += [f"{x:.2f}" for x in f / p]
            cells += [f"{x:.1f}" for x in 100 * f / (MASS * GRAVITY)]
            lines.append([*cells, *(f"{x:.2f}" for x in f * DURATION / MASS)])
    return Grid("Largest push [N], by what a pendulum withstands, and by the body", header, lines)


def stances(kept: KeptResults) -> Grid:
    """Return the limits by where the centre of mass is."""
    header = ("centre of mass, of the soles", *SIDES, "sum", "pendulum", "", "")
    lines = []
    for ahead in STANCES:
        for foot in ORDER:
            forces = _forces(kept, f"stances/{ahead:g}/{foot}")
            expected = _forces(kept, f"stances/{ahead:g}/{foot}", "pendulum")
            if not any(f is None for f in (*forces, *expected)):
                total = sum(f or 0.0 for f in forces)
                cells = [f"{ahead:g}, {foot}", *_cells(forces), f"{total:g}"]
                lines.append([*cells, *(f"{p:.0f}" for p in expected if p is not None)])
    return Grid("Largest push [N] by where the centre of mass is", header, lines)


def map_table(kept: KeptResults) -> Grid:
    """Return the limits all around."""
    ways = _ways(kept)
    header = ("towards [deg]", *ways, "pendulum")
    lines = []
    for degrees in sorted({d for found in ways.values() for d in found}):
        found = [ways[way].get(degrees) for way in ways]
        expected = next(r["pendulum"] for r in found if r is not None)
        forces = [None if r is None else r["force"] for r in found]
        lines.append([f"{degrees:g}", *_cells(forces), f"{expected:.0f}"])
    return Grid("Largest push [N] by direction, multi-segment feet", header, lines)


def factors(kept: KeptResults) -> Grid:
    """Return how much more is withstood with steps."""
    ways = _ways(kept)
    header = ("towards [deg]", "times", "% weight", "m/s", "every lighter one tried [N]")
    lines = []
    for degrees, result in sorted(ways.get("stepping", {}).items()):
        if degrees in ways.get("in place", {}):
            force, place = result["force"], ways["in place"][degrees]["force"]
            times = f"{force / place:.2f}" if place else "-"
            weight, speed = 100 * force / (MASS * GRAVITY), force * DURATION / MASS
            sure = f"{result['sure']:g}"
            lines.append([f"{degrees:g}", times, f"{weight:.0f}", f"{speed:.2f}", sure])
    return Grid("With steps: by what is withstood in place, and by the body", header, lines)


def sizes(kept: KeptResults) -> Grid:
    """Return the limits of other bodies."""
    header = ("body", *SIDES, "m/s", "", "")
    lines = []
    for height, mass in SIZES:
        for name in WAYS:
            body = f"{height:g} m {mass:g} kg, {name}"
            forces = _forces(kept, f"sizes/{body}")
            if any(f is not None for f in forces):
                speeds = [None if f is None else round(f * DURATION / mass, 2) for f in forces]
                lines.append([body, *_cells(forces), *_cells(speeds)])
    return Grid("Largest push [N] of other bodies, same setting", header, lines)


def _ways(kept: KeptResults) -> dict[str, dict[float, Result]]:
    """Return the results of the map: with or without steps → direction → result."""
    ways: dict[str, dict[float, Result]] = {}
    for key, result in kept.beginning("map/").items():
        if "error" not in result:
            _, way, degrees = key.split("/")
            ways.setdefault(way, {})[float(degrees)] = result
    return ways


def pictures(kept: KeptResults) -> list[Section]:
    """Return the map as a drawing: forward is to the right, the person's left is up."""
    series = []
    for way, found in _ways(kept).items():
        turns = np.deg2rad([*sorted(found), min(found)])
        for name, dash in (("force", ""), ("pendulum", "4 3")):
            size = np.array([found[d][name] for d in [*sorted(found), min(found)]])
            label = way if name == "force" else "pendulum"
            series.append(Series(size * np.cos(turns), size * np.sin(turns), label, dash=dash))
    if not series:
        return []
    drawn = path_plot(
        series, title="Map of pushes", x_label="forward [N]", y_label="to the left [N]"
    )
    caption = "Pushes withstood, from the middle to where they push; dashed: the pendulum."
    return [Section("Map", figures=(Figure(drawn, caption),))]


def gaps(kept: KeptResults) -> list[str]:
    """Return where a lighter push is not withstood."""
    said = []
    for key, result in kept.results.items():
        if result.get("gaps"):
            forces = ", ".join(f"{f:g}" for f in result["gaps"])
            said.append(f"Not monotone: {key} holds {result['force']:g} N and falls at {forces} N.")
    return said


def goals(kept: KeptResults) -> list[Row]:
    """Return what is held against the paper, and every other limit."""
    rows: list[Row] = []
    start = f"paper/{FORMULATION}/multi-segment"
    forces = _forces(kept, start)
    for side, force, goal in zip(SIDES, forces, PAPER["multi-segment"], strict=True):
        if force is not None:
            rows.append(at_least(f"{FORMULATION} multi-segment", side, force, goal, "N"))
    if all(f is not None for f in forces):
        total = float(sum(f or 0.0 for f in forces))
        rows.append(at_least(f"{FORMULATION} multi-segment", "sum", total, SUM, "N"))
    ways = _ways(kept)
    for degrees, result in sorted(ways.get("stepping", {}).items()):
        place = ways.get("in place", {}).get(degrees)
        if place is not None and place["force"]:
            times = result["force"] / place["force"]
            rows.append(at_least("steps, towards", f"{degrees:g} deg", times, TIMES, "times"))
    for key, result in kept.results.items():
        if "error" not in result and not key.startswith(start):
            subject, _, side = key.replace("/", " ").rpartition(" ")
            rows.append(Row(subject, side, result["force"], "N"))
    return rows


def _measured(cases: Callable[[bool], dict[str, Case]], quick: bool) -> Cases:
    return {key: partial(measure, *case) for key, case in cases(quick).items()}


EXPERIMENT = Measured(
    name="push-table",
    title="Pushes that standing people withstand",
    parts={
        "paper": partial(_measured, paper_cases),
        "stances": partial(_measured, stance_cases),
        "map": partial(_measured, map_cases),
        "sizes": partial(_measured, size_cases),
    },
    usual=("paper",),
    brief=_brief,
    grids=lambda kept: (table(kept), stances(kept), map_table(kept), factors(kept), sizes(kept)),
    rows=goals,
    notes=NOTES,
    remarks=gaps,
    pictures=pictures,
)
run = EXPERIMENT.run
