"""Tiptoe, tilting, circling, standing on one foot and a jump, by people of all sizes.

The motions of section 6.1 of [Park2020]_, from the scripts of
:mod:`plantigrade.control.balance.script`, carried out by balance with one set of weights. The paper
shows pictures of them and no numbers. Beside them, where there are recordings, a person who
balances on one leg (49_18 of the CMU collection), tracked by the same controller.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.kept_results import KeptResults, Result
from experiments.measured import Cases, Measured
from experiments.page import Grid
from experiments.standing import HEIGHT, JOINTS, MASS, PRESSING, RATE, SEX
from experiments.table import ResultTable, Row, at_least, equal
from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.balance import MOTIONS, Balance, script_named, scripted
from plantigrade.models import Human
from plantigrade.motion.filters import runs
from plantigrade.threads import on_one_thread
from plantigrade.workflows.simulate import simulate
from plantigrade.world import World, on_ground
from plantigrade.world.push_limits import on_feet

CONTROL, AFTER = 90.0, 1.0  # commands [1/s]; so long they must stand after the script [s]
SIZES = ((HEIGHT, MASS), (1.45, 45.0), (1.70, 65.0), (1.95, 110.0), (1.60, 95.0), (1.85, 62.0))
"""Stature and mass; the paper's first [m, kg]."""
TIPTOE, JUMP = 10.0, 10.0  # goals: [s], [cm]
RECORDED, RECORDING = "recorded", Path("cmu_asfamc/49_18.amc")
"""Name of the part with a recording, and its file in the folder of recordings."""
FEET, SOLE = ("multi-segment", "two-segment"), 20.0
"""Its feet; one of them stands that carries more than this [N]."""
LEFT = 0.1
"""A body that rises has left the ground when this little presses there [body weights]."""
CHATTER, CARRIES = 0.1, 0.1
"""Pressure is at another bone when nearer to it by so much [bones], and passes one that carries so
much of the load under the toes."""
NOTES = (
    "",
    "'on toes' is how long in a row nothing but points of the toes touched the ground, 'rise' how "
    "far the centre of mass came above where it is in standing, 'flight' how much of that once the "
    "ground carried less than a tenth of body weight, 'air' how long nothing touched. Of the toe "
    "bones of the circling foot 'bones' carried more than 1 N at some time; "
    "'in order' is the share of the 'sweeps' from one border of the foot to the other in which the "
    "pressure passed all five, one after the other. Limits are the strengths of the person.",
)


def _cases(name: str, quick: bool) -> Cases:
    """Return a motion by people of all sizes."""
    return {
        f"{name}/{height:g} m, {mass:g} kg": partial(measure, name, height, mass)
        for height, mass in (SIZES[:1] if quick else SIZES)
    }


def _tracked(data: Path, quick: bool) -> Cases:
    """Return a recording of balance on one leg, on different feet."""
    path = data / RECORDING
    feet = FEET[:1] if quick else FEET
    return {f"{RECORDED}/{path.stem}, {kind}": partial(track, path, kind) for kind in feet}


def track(path: Path, feet: str) -> dict[str, Any]:
    """Return what becomes of a recording that is followed in balance."""
    run = simulate(path, controller="balance", feet=feet)
    record = run.record
    load = np.asarray(record.contact_force)[:, :, 2]
    down = [load[:, [s.side == side for s in record.sites]].sum(axis=1) > SOLE for side in SIDES]
    return {
        "stood": run.ok,
        "time": record.motion.duration,
        "one_leg": float(np.mean(down[0] != down[1])) * record.motion.duration,
        "torque": float(run.metrics["motor_torque_max_pct"]),
    }


@on_one_thread
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
    loads, highs, limited = [], [], 0.0
    while world.time < end - 0.5 / world.rate and on_feet(world):
        command = controller(state)
        limited = max(limited, float(command.signals.get("limited", 0.0)))
        state = world.step(command)
        loads.append(world.contact_force()[:, 2])
        highs.append(float(state.body.com[2]))
    load = np.array(loads)
    on = load > PRESSING
    on_toes, on_rest = (np.atleast_1d(on[:, which].any(axis=1)) for which in (toes, ~toes))
    bones, sweeps, order = circled(load, [s.name for s in world.sites], float(wanted.time[-1]))
    return {
        "stood": on_feet(world),
        "time": world.time,
        "on_toes": longest(on_toes & ~on_rest) / CONTROL,
        "air": longest(~(on_toes | on_rest)) / CONTROL,
        "rise": 100.0 * (max(highs) - first),
        "flight": 100.0 * flown(highs, load.sum(axis=1) / (mass * GRAVITY)),
        "bones": bones,
        "sweeps": sweeps,
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
    return max((run.stop - run.start for run in runs(true)), default=0)


def flown(high: Sequence[float], load: Float[Array, " n"]) -> float:
    """Return how far a body rose after it left the ground; 0 where it did not [m].

    Args:
        high: Height of its centre of mass [m].
        load: What the ground carries of it [body weights].

    Example:
        >>> flown([1.0, 0.8, 1.0, 1.1, 1.15, 1.1, 1.0], np.array([1, 1, 2, 0.05, 0, 0, 1]))
        0.05
    """
    apex = int(np.argmax(high))
    pressed = np.flatnonzero(load[: apex + 1] >= LEFT)
    off = int(pressed[-1]) + 1 if len(pressed) else 0
    return round(high[apex] - high[off], 6) if off <= apex else 0.0


def circled(
    load: Float[Array, "n n_sites"], names: Sequence[str], end: float
) -> tuple[int, int, float]:
    """Return how pressure goes around under the toes of the left foot.

    That is how many toe bones carried load, how many times pressure went from one border of the
    foot towards the other, and in what share of them it passed every bone, one after the other.
    Pressure is at the bone whose number is nearest to the mean one, each counting by its load; it
    moves on once it is nearer to another by :data:`CHATTER`, and passes a bone that carries at
    least :data:`CARRIES` of the load meanwhile. (Which bone carries most would not tell: of three
    that are one segment the middle one never does.) Only in the longest time in which nothing else
    of that foot touches.

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
    while_alone = runs(alone & (each.sum(axis=1) > 2 * PRESSING))
    if not while_alone:
        return 0, 0, 0.0
    each = each[max(while_alone, key=lambda run: run.stop - run.start)]
    share = each / each.sum(axis=1, keepdims=True)
    passed: list[tuple[int, float]] = []  # bone, and the most it carried meanwhile
    for mine, middle in zip(share, share @ np.arange(1.0, 6.0), strict=True):
        at = round(middle)
        if not passed or abs(middle - passed[-1][0]) > 0.5 + CHATTER:
            passed.append((at, 0.0))
        bone, most = passed[-1]
        passed[-1] = bone, max(most, float(mine[bone - 1]))
    bones = np.array([bone for bone, _ in passed])
    borders = np.flatnonzero((bones == 1) | (bones == 5))
    turns = [int(k) for k in borders if k == borders[0] or bones[k] != bones[k - 1]]
    carried = np.array([most >= CARRIES for _, most in passed])
    across = [1, 2, 3, 4, 5]
    sweeps = [
        bones[a : b + 1].tolist() in (across, across[::-1]) and bool(carried[a : b + 1].all())
        for a, b in zip(turns[:-1], turns[1:], strict=True)
    ]
    good = float(np.mean(sweeps)) if sweeps else 0.0
    return int((each.max(axis=0) > PRESSING).sum()), len(sweeps), good


def _brief(r: Result) -> str:
    return "stood" if r["stood"] else f"fell at {r['time']:.2f} s"


def table(kept: KeptResults) -> Grid:
    """Return one line for every motion and person."""
    header = ("", "stood", "on toes s", "rise cm", "flight cm", "air s", "bones", "sweeps")
    header = (*header, "in order", "points", "limits")
    lines = []
    for key, r in kept.results.items():
        if "error" in r or key.startswith(RECORDED):
            continue
        name = key.partition("/")[0]
        lines.append(
            [
                key.replace("/", ", "),
                "yes" if r["stood"] else f"fell at {r['time']:.1f} s",
                f"{r['on_toes']:.1f}" if name == "tiptoe" else "",
                f"{r['rise']:.1f}" if name == "jump" else "",
                f"{r['flight']:.1f}" if name == "jump" else "",
                f"{r['air']:.2f}" if name == "jump" else "",
                f"{r['bones']}" if name == "circling" else "",
                f"{r['sweeps']}" if name == "circling" else "",
                f"{100 * r['in_order']:.0f} %" if name == "circling" else "",
                f"{r['points']:.1f}",
                f"{r['most_limited']:.0f}",
            ]
        )
    return Grid("Motions of the feet, and most torques at a limit at once", header, lines)


def rows(kept: KeptResults) -> Iterator[Row]:
    """Return what is held against goals."""
    for name in (*MOTIONS, RECORDED):
        found = {k: r for k, r in kept.beginning(f"{name}/").items() if "error" not in r}
        if not found:
            continue
        fell = sum(not r["stood"] for r in found.values())
        yield equal(name, "falls", fell, 0)
        if name == "tiptoe":
            yield at_least(name, "on toes", min(r["on_toes"] for r in found.values()), TIPTOE, "s")
        if name == "jump":
            yield at_least(name, "least rise", min(r["rise"] for r in found.values()), JUMP, "cm")
            yield Row(name, "least flight", min(r["flight"] for r in found.values()), "cm")
        if name == "circling":
            yield at_least(name, "least bones", min(r["bones"] for r in found.values()), 5)
            share = float(np.mean([r["in_order"] for r in found.values()]))
            yield equal(name, "sweeps in order", 100 * share, 100, "%")


def recorded(kept: KeptResults) -> Grid:
    """Return one line for every recording."""
    lines = [
        [
            key.partition("/")[2],
            "yes" if r["stood"] else f"fell at {r['time']:.1f} s",
            f"{r['time']:.1f}",
            f"{r['one_leg']:.1f}",
            f"{r['torque']:.0f}",
        ]
        for key, r in kept.beginning(f"{RECORDED}/").items()
        if "error" not in r
    ]
    return Grid("Recorded balance", ("", "stood", "lasts s", "on one leg s", "torque %"), lines)


EXPERIMENT = Measured(
    name="foot-motions",
    title="Motions of the feet",
    parts={name: partial(_cases, name) for name in MOTIONS},
    brief=_brief,
    grids=lambda kept: (table(kept), recorded(kept)),
    rows=rows,
    notes=NOTES,
)


def run(data: Path | None = None, **options: Any) -> ResultTable:
    """Run :data:`EXPERIMENT`, and its recording where there are some.

    Args:
        data: Folder of recordings.
        options: Those of :meth:`~experiments.measured.Measured.run`.

    Raises:
        ParameterError: If there is no such part.
    """
    if data is None:
        return EXPERIMENT.run(**options)
    parts = {**EXPERIMENT.parts, RECORDED: partial(_tracked, data)}
    return replace(EXPERIMENT, parts=parts).run(**options)
