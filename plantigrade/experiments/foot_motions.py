"""Tiptoe, tilting, circling, standing on one foot and a jump, by people of all sizes.

The motions of section 6.1 of [Park2020]_, from the scripts of
:mod:`plantigrade.control.balance.script`, carried out by balance with one set of weights. The paper
shows pictures of them and no numbers.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from plantigrade.arrays import Array, Bool, Float
from plantigrade.control.balance import MOTIONS, Balance, script_named, scripted
from plantigrade.experiments.kept_results import KeptResults, Result
from plantigrade.experiments.measured import Cases, Measured
from plantigrade.experiments.page import Grid
from plantigrade.experiments.standing import HEIGHT, JOINTS, MASS, PRESSING, RATE, ROOMS, SEX
from plantigrade.experiments.table import Row, at_least, equal
from plantigrade.models import Human
from plantigrade.world import World, on_ground
from plantigrade.world.push_limits import on_feet

CONTROL, AFTER = 90.0, 1.0  # commands [1/s]; so long they must stand after the script [s]
SIZES = ((HEIGHT, MASS), (1.45, 45.0), (1.70, 65.0), (1.95, 110.0), (1.60, 95.0), (1.85, 62.0))
"""Stature and mass; the paper's first [m, kg]."""
TIPTOE, JUMP = 10.0, 10.0  # goals: [s], [cm]
NOTES = (
    "",
    "'on toes' is how long in a row nothing but points of the toes touched the ground, 'jump' how "
    "far the centre of mass rose above where it is in standing, 'air' how long nothing touched. "
    "Of the toe bones of the circling foot 'bones' carried more than 1 N at some time, and 'in "
    "order' is the share of the sweeps from one border of the foot to the other in which they had "
    "their largest share one after the other. Limits are the strengths of the person.",
)


def _cases(name: str, quick: bool) -> Cases:
    """Return a motion by people of all sizes."""
    return {
        f"{name}/{height:g} m, {mass:g} kg": partial(measure, name, height, mass)
        for height, mass in (SIZES[:1] if quick else SIZES)
    }


def measure(name: str, height: float, mass: float) -> dict[str, Any]:
    """Return what becomes of a motion: plain figures."""
    human = Human.create(height, mass, SEX, JOINTS, "multi-segment")
    wanted = scripted(human, script_named(name))
    world = World(human, rate=RATE, control_rate=CONTROL, recording=False)
    qpos = on_ground(human, world.ground, wanted.motion.qpos[0])
    state, controller = world.reset(qpos=qpos), Balance(wanted)
    first, end = float(state.body.com[2]), float(wanted.time[-1]) + AFTER
    toes = np.array(["toe_" in s.name or "metatarsal_" in s.name for s in world.sites])
    toes &= np.array(["phalanges" in s.name for s in world.sites])
    loads, rise, limited = [], 0.0, 0.0
    while world.time < end - 0.5 / world.rate and on_feet(world):
        command = controller(state)
        limited = max(limited, float(command.signals.get("limited", 0.0)))
        state = world.step(command)
        loads.append(world.contact_force()[:, 2])
        rise = max(rise, float(state.body.com[2]) - first)
    load = np.array(loads)
    on = load > PRESSING
    on_toes, on_rest = (np.atleast_1d(on[:, which].any(axis=1)) for which in (toes, ~toes))
    bones, order = circled(load, [s.name for s in world.sites], float(wanted.time[-1]))
    return {
        "stood": on_feet(world),
        "time": world.time,
        "on_toes": longest(on_toes & ~on_rest) / CONTROL,
        "air": longest(~(on_toes | on_rest)) / CONTROL,
        "jump": 100.0 * rise,
        "bones": bones,
        "in_order": order,
        "most_limited": limited,
        "points": float(on[len(on) // 2 :].sum(axis=1).mean()),
    }


def longest(true: Bool[Array, " n"]) -> int:
    """Return the length of the longest row of what is true.

    Example:
        >>> longest(np.array([True, False, True, True]))
        2
    """
    edges = np.flatnonzero(np.diff(np.r_[False, true, False].astype(int)))
    return int((edges[1::2] - edges[::2]).max()) if len(edges) else 0


def circled(
    load: Float[Array, "n n_sites"], names: Sequence[str], end: float
) -> tuple[int, float | None]:
    """Return how many toe bones of the left foot carried load, and in how many sweeps in order.

    Only while nothing else of that foot touches; a sweep is from one side of it to the other.

    Args:
        load: Vertical force of every sphere, at :data:`CONTROL` [N].
        names: Of the spheres.
        end: When the script ends [s].
    """
    of = [
        [i for i, n in enumerate(names) if n.endswith((f"toe_{b}_l", f"metatarsal_{b}_l"))]
        for b in range(1, 6)
    ]
    inside = [i for i, n in enumerate(names) if n.endswith("_l") and i not in sum(of, [])]
    each = np.stack([load[:, own].sum(axis=1) for own in of], axis=1)[: int(end * CONTROL)]
    alone = load[: len(each), inside].max(axis=1) < PRESSING
    each = each[alone & (each.sum(axis=1) > 2 * PRESSING)]
    bones = int((each.max(axis=0) > PRESSING).sum()) if len(each) else 0
    if len(each) < CONTROL:
        return bones, None
    share = uniform_filter1d(each / each.sum(axis=1, keepdims=True), 9, axis=0)
    middle = share @ np.arange(1.0, 6.0)
    ends: list[int] = []  # turns from one side to the other, in the middle by more than a bone
    way = 0
    for k, m in enumerate(middle):
        side = -1 if m < 2.25 else 1 if m > 3.75 else 0
        if not ends or (side and side != way):
            way = side or way
            ends.append(k)
        elif side == way and side * (m - middle[ends[-1]]) > 0:
            ends[-1] = k
    sweeps = [(a, b) for a, b in zip(ends[:-1], ends[1:], strict=True) if b - a > 4]
    if not sweeps:
        return bones, 0.0
    good = 0
    for a, b in sweeps:
        peaks = share[a : b + 1].argmax(axis=0)
        steps = np.diff(peaks if middle[b] > middle[a] else peaks[::-1])
        good += bool((steps >= 0).all())
    return bones, good / len(sweeps)


def _brief(r: Result) -> str:
    return "stood" if r["stood"] else f"fell at {r['time']:.2f} s"


def table(kept: KeptResults) -> Grid:
    """Return one line for every motion and person."""
    header = ("", "stood", "on toes s", "jump cm", "air s", "bones", "in order", "points", "limits")
    lines = []
    for key, r in kept.results.items():
        if "error" in r:
            continue
        name = key.partition("/")[0]
        order = r["in_order"] if name == "circling" else None
        lines.append(
            [
                key.replace("/", ", "),
                "yes" if r["stood"] else f"fell at {r['time']:.1f} s",
                f"{r['on_toes']:.1f}" if name == "tiptoe" else "",
                f"{r['jump']:.1f}" if name == "jump" else "",
                f"{r['air']:.2f}" if name == "jump" else "",
                f"{r['bones']}" if name == "circling" else "",
                "" if order is None else f"{100 * order:.0f} %",
                f"{r['points']:.1f}",
                f"{r['most_limited']:.0f}",
            ]
        )
    return Grid("Motions of the feet, and most torques at a limit at once", header, lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return what is held against goals."""
    for name in MOTIONS:
        found = {k: r for k, r in kept.beginning(f"{name}/").items() if "error" not in r}
        if not found:
            continue
        fell = sum(not r["stood"] for r in found.values())
        yield equal(name, "falls", fell, 0)
        if name == "tiptoe":
            yield at_least(name, "on toes", min(r["on_toes"] for r in found.values()), TIPTOE, "s")
        if name == "jump":
            yield at_least(name, "least rise", min(r["jump"] for r in found.values()), JUMP, "cm")
        if name == "circling":
            yield at_least(name, "least bones", min(r["bones"] for r in found.values()), 5)
            share = float(np.mean([r["in_order"] or 0.0 for r in found.values()]))
            yield Row(name, "sweeps in order", 100 * share, "%")


EXPERIMENT = Measured(
    name="foot-motions",
    title="Motions of the feet",
    rooms=ROOMS,
    parts={name: partial(_cases, name) for name in MOTIONS},
    brief=_brief,
    grids=lambda kept: (table(kept),),
    rows=rows,
    notes=NOTES,
)
run = EXPERIMENT.run
