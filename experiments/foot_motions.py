"""Tiptoe, tilting, circling, standing on one foot and a jump, by people of all sizes.

The motions of section 6.1 of [Park2020]_, from the scripts of
:mod:`plantigrade.control.balance.script`, carried out by balance with one set of weights. The paper
shows pictures of them and no numbers. If there are recordings, a person who balances on one leg
(49_18 of the CMU collection) is tracked by the same controller.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.push_limits import on_feet
from experiments.specification import Specification, runs_on
from experiments.standing import HEIGHT, JOINTS, MASS, PRESSING_FORCE, RATE, SEX
from experiments.table import Row, at_least, equal
from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.balance import MOTIONS, Balance, script_named, scripted
from plantigrade.models import Human
from plantigrade.motion.filters import runs
from plantigrade.threads import on_one_thread
from plantigrade.workflows.simulate import simulate
from plantigrade.world import World, on_ground

CONTROL_RATE = 90.0
"""Rate of commands [1/s]."""
STANDING_TIME = 1.0
"""Time of standing after the script [s]."""
SIZES = ((HEIGHT, MASS), (1.45, 45.0), (1.70, 65.0), (1.95, 110.0), (1.60, 95.0), (1.85, 62.0))
"""Stature and mass; the paper's first [m, kg]."""
MIN_TIPTOE_TIME = 10.0
"""Goal: time on tiptoe [s]."""
MIN_JUMP_RISE = 10.0
"""Goal: rise of the centre of mass in a jump [cm]."""
RECORDED_PART = "recorded"
"""Name of the part with a recording."""
RECORDING_FILE = Path("cmu_asfamc/49_18.amc")
"""File of that part in the folder of recordings."""
RECORDED_PART_FEET = ("multi-segment", "two-segment")
"""Feet of that part."""
MIN_STANCE_FORCE = 20.0
"""Least load of a stance foot [N]."""
LIFT_OFF_LOAD = 0.1
"""Load below which a rising body has left the ground [body weights]."""
PRESSURE_HYSTERESIS = 0.1
"""Distance by which pressure is nearer to another bone before it moves on [bones]."""
MIN_LOAD_SHARE = 0.1
"""Least load share of a bone that the pressure passes [1]."""
NOTES = (
    "",
    "'on toes' is the longest time in which nothing but points of the toes touched the ground, "
    "'rise' the height of the centre of mass above that in standing, 'flight' the part of it after "
    "the ground carried less than a tenth of body weight, 'air' the time without contact. Of the "
    "toe bones of the circling foot 'bones' carried more than 1 N at some time; 'in order' is the "
    "share of the 'sweeps' from one border of the foot to the other in which the pressure passed "
    "all five, one after the other. 'limited' is the greatest number of torques at their limit.",
)


def _cases(name: str, quick: bool) -> Cases:
    """Return a motion by people of all sizes."""
    return {
        f"{name}/{height:g} m, {mass:g} kg": partial(measure, name, height, mass)
        for height, mass in (SIZES[:1] if quick else SIZES)
    }


def _tracked(data: Path, quick: bool) -> Cases:
    """Return a recording of balance on one leg, on different feet."""
    path = data / RECORDING_FILE
    feet = RECORDED_PART_FEET[:1] if quick else RECORDED_PART_FEET
    return {f"{RECORDED_PART}/{path.stem}, {kind}": partial(track, path, kind) for kind in feet}


def track(path: Path, feet: str) -> dict[str, Any]:
    """Return the figures of a recording that is tracked in balance."""
    run = simulate(path, controller="balance", feet=feet)
    record = run.record
    load = np.asarray(record.contact_force)[:, :, 2]
    down = [
        load[:, [s.side == side for s in record.sites]].sum(axis=1) > MIN_STANCE_FORCE
        for side in SIDES
    ]
    return {
        "stood": run.ok,
        "time": record.motion.duration,
        "one_leg": float(np.mean(down[0] != down[1])) * record.motion.duration,
        "torque": float(run.metrics["motor_torque_max_pct"]),
    }


@on_one_thread
def measure(name: str, height: float, mass: float) -> dict[str, Any]:
    """Return the figures of a motion."""
    human = Human.create(height, mass, SEX, JOINTS, "multi-segment")
    reference = scripted(human, script_named(name))
    world = World(human, rate=RATE, control_rate=CONTROL_RATE, recording=False)
    qpos = on_ground(human, world.ground, reference.motion.qpos[0])
    state, controller = world.reset(qpos=qpos), Balance(reference)
    first, end = float(state.body.com[2]), float(reference.time[-1]) + STANDING_TIME
    toes = np.array(["toe_" in s.name or "metatarsal_" in s.name for s in world.sites])
    toes &= np.array(["phalanges" in s.name for s in world.sites])
    loads, heights, limited = [], [], 0.0
    while world.time < end - 0.5 / world.rate and on_feet(world):
        command = controller(state)
        limited = max(limited, float(command.signals.get("limited", 0.0)))
        state = world.step(command)
        loads.append(world.contact_force()[:, 2])
        heights.append(float(state.body.com[2]))
    load = np.array(loads)
    on = load > PRESSING_FORCE
    on_toes, on_rest = (np.atleast_1d(on[:, which].any(axis=1)) for which in (toes, ~toes))
    bones, sweeps, order = circled(load, [s.name for s in world.sites], float(reference.time[-1]))
    return {
        "stood": on_feet(world),
        "time": world.time,
        "on_toes": longest(on_toes & ~on_rest) / CONTROL_RATE,
        "air": longest(~(on_toes | on_rest)) / CONTROL_RATE,
        "rise": 100.0 * (max(heights) - first),
        "flight": 100.0 * flown(heights, load.sum(axis=1) / (mass * GRAVITY)),
        "bones": bones,
        "sweeps": sweeps,
        "in_order": order,
        "most_limited": limited,
        "points": float(on[len(on) // 2 :].sum(axis=1).mean()),
    }


def longest(true: Bool[Array, " n"]) -> int:
    """Return the length of the longest run of true values.

    Example:
        >>> longest(np.array([True, False, True, True]))
        2
    """
    return max((run.stop - run.start for run in runs(true)), default=0)


def flown(high: Sequence[float], load: Float[Array, " n"]) -> float:
    """Return the rise of a body after lift-off; 0 without one [m].

    Args:
        high: Height of its centre of mass [m].
        load: Load on the ground [body weights].

    Example:
        >>> flown([1.0, 0.8, 1.0, 1.1, 1.15, 1.1, 1.0], np.array([1, 1, 2, 0.05, 0, 0, 1]))
        0.05
    """
    apex = int(np.argmax(high))
    pressed = np.flatnonzero(load[: apex + 1] >= LIFT_OFF_LOAD)
    off = int(pressed[-1]) + 1 if len(pressed) else 0
    return round(high[apex] - high[off], 6) if off <= apex else 0.0


def circled(
    load: Float[Array, "n n_sites"], names: Sequence[str], end: float
) -> tuple[int, int, float]:
    """Return the path of the pressure under the toes of the left foot.

    The number of toe bones that carried load, the number of sweeps of the pressure from one border
    of the foot towards the other, and the share of sweeps that pass every bone in order. Pressure
    is at the bone whose number is nearest to the mean number weighted by load; it moves on once it
    is nearer to another by :data:`PRESSURE_HYSTERESIS`, and passes a bone whose load share reaches
    :data:`MIN_LOAD_SHARE`. (The bone with the greatest load is no measure: of three that are one
    segment it is never the middle one.) Only the longest interval counts in which nothing else of
    that foot touches.

    Args:
        load: Vertical force of every sphere, at :data:`CONTROL_RATE` [N].
        names: Of the spheres.
        end: When the script ends [s].
    """
    of = [
        [i for i, n in enumerate(names) if n.endswith((f"toe_{b}_l", f"metatarsal_{b}_l"))]
        for b in range(1, 6)
    ]
    inside = [i for i, n in enumerate(names) if n.endswith("_l") and i not in sum(of, [])]
    each = np.stack([load[:, own].sum(axis=1) for own in of], axis=1)[: int(end * CONTROL_RATE)]
    alone = load[: len(each), inside].max(axis=1) < PRESSING_FORCE
    while_alone = runs(alone & (each.sum(axis=1) > 2 * PRESSING_FORCE))
    if not while_alone:
        return 0, 0, 0.0
    each = each[max(while_alone, key=lambda run: run.stop - run.start)]
    share = each / each.sum(axis=1, keepdims=True)
    passed: list[tuple[int, float]] = []  # bone, and the most it carried meanwhile
    for mine, middle in zip(share, share @ np.arange(1.0, 6.0), strict=True):
        at = round(middle)
        if not passed or abs(middle - passed[-1][0]) > 0.5 + PRESSURE_HYSTERESIS:
            passed.append((at, 0.0))
        bone, most = passed[-1]
        passed[-1] = bone, max(most, float(mine[bone - 1]))
    bones = np.array([bone for bone, _ in passed])
    borders = np.flatnonzero((bones == 1) | (bones == 5))
    turns = [int(k) for k in borders if k == borders[0] or bones[k] != bones[k - 1]]
    carried = np.array([most >= MIN_LOAD_SHARE for _, most in passed])
    across = [1, 2, 3, 4, 5]
    sweeps = [
        bones[a : b + 1].tolist() in (across, across[::-1]) and bool(carried[a : b + 1].all())
        for a, b in zip(turns[:-1], turns[1:], strict=True)
    ]
    good = float(np.mean(sweeps)) if sweeps else 0.0
    return int((each.max(axis=0) > PRESSING_FORCE).sum()), len(sweeps), good


FIGURES = {
    "tiptoe": {"on_toes": "s"},
    "jump": {"rise": "cm", "flight": "cm", "air": "s"},
    "circling": {"bones": "", "sweeps": "", "in_order": ""},
    RECORDED_PART: {"time": "s", "one_leg": "s", "torque": "%"},
}
"""Motion → its figures and their units."""


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures of all motions, with their goals."""
    for name in (*MOTIONS, RECORDED_PART):
        found = cached.select(name)
        if not found:
            continue
        yield equal(name, "falls", sum(not r["stood"] for r in found.values()), 0)

        def least(key: str, found: dict[str, Result] = found) -> float:
            return min(r[key] for r in found.values())

        if name == "tiptoe":
            yield at_least(name, "on toes", least("on_toes"), MIN_TIPTOE_TIME, "s")
        if name == "jump":
            yield at_least(name, "least rise", least("rise"), MIN_JUMP_RISE, "cm")
            yield Row(name, "least flight", least("flight"), "cm")
        if name == "circling":
            yield at_least(name, "least bones", least("bones"), 5)
            share = float(np.mean([r["in_order"] for r in found.values()]))
            yield equal(name, "sweeps in order", 100 * share, 100, "%")
        every = {} if name == RECORDED_PART else {"points": "", "most_limited": ""}
        for key, r in found.items():
            for figure, unit in (FIGURES.get(name, {}) | every).items():
                yield Row(key.replace("/", ", "), figure.replace("_", " "), r[figure], unit)


def experiment(data: Path | None) -> Specification:
    """Return the experiment, with the recording of a folder if there is one."""
    parts = {name: partial(_cases, name) for name in MOTIONS}
    return Specification(
        name="foot-motions",
        title="Motions of the feet",
        parts=parts if data is None else {**parts, RECORDED_PART: partial(_tracked, data)},
        rows=rows,
        notes=NOTES,
    )


run = runs_on(experiment)


EXPERIMENT = experiment(None)
