"""Walks with loads, at other speeds, on slopes and with bent knees: what changes, beside people.

Each is solved twice: with the steps that people take at that speed on level ground, for work,
moments and angles, and with the step length, stance and heel rise that cost least, within 15 %, 3 %
and 6 % of those.

Of people is known:

- Loads: the metabolic rate rises with the load, and the more the further down it is; kinematics
  stay, and moments in swing rise with loads on the feet [Browning2007]_ (five men, 1.25 m/s).
- Speed: hips, knees and ankles do 42, 16 and 42 % of the positive work at every speed of walking
  [Farris2012]_ (ten people, 0.75 to 2 m/s).
- Slopes: strides are 6 % shorter at −9° and as long as on level ground at 9°, and the part of
  stance stays [Franz2012]_; the shares of the joints in the work of stance are those of
  :data:`SLOPE_SHARES` [Montgomery2018]_ (twenty people). Up a ramp of 10° joints do 1.25 times as
  much work as they absorb on the way down [DeVita2007]_ (34 people).
- Bent knees: muscles of the knee bear much more, those of the hip as much as before, and walking
  takes more energy [Foster2013]_; thigh and shank turn in space as in erect walking [Grasso2000]_.

Work of muscles stands for energy: positive work takes 4 times, negative work 0.83 times as much
[Margaria1968]_.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import trapezoid

from experiments.cached_results import CachedResults, Cases, Result
from experiments.gait_shape import muscle_work
from experiments.specification import Specification
from experiments.synthesis_trial import check_motion, failure_remarks, outcome, solve, summary
from experiments.table import Grid, Row, at_least, at_most, within
from plantigrade.analyze.curves import gait_curves
from plantigrade.arrays import Array
from plantigrade.models import Human
from plantigrade.trajopt.free_times import find_times
from plantigrade.trajopt.tasks.gait_parameters import (
    GaitParameters,
    free_walking_times,
    gait_parameters,
    with_walking_times,
)
from plantigrade.trajopt.tasks.impairments import Impairments
from plantigrade.trajopt.tasks.walking import periodic_walk

SPEED = 1.25  # [m/s]
PLAIN = "level 1.25 m/s"  #: Name of the walk that others are compared with
LOADS = {"waist": (4, 8, 16), "thighs": (8, 16), "shanks": (4, 8), "feet": (4, 8)}
"""Place → loads, of both sides together [kg]."""
PLACES = tuple(LOADS)  # from the top down
SPEEDS = (0.75, 1.75)  # [m/s]
SLOPES = (-9, 9)  # [deg]
MIN_KNEE_FLEXIONS = (15, 30)  # [deg] least flexion of the knees
QUICK_CHANGES = ("waist 8 kg", "feet 8 kg", "slope 9°")
JOINTS = ("hip_flexion_r", "knee_angle_r", "ankle_angle_r")
EFFORT = (1 / 0.25, 1 / 1.2)  # [1] energy for positive and for negative work

WORK_SHARES = ("positive work in stride", "positive work in stance", "negative work in stance")

MAX_CHANGE = 5.0  # [deg] RMS difference of leg angles that counts as the same kinematics
SAME_SHAPE = 0.9  # [1] correlation of curves that counts as the same shape
SAME_SHARE = 10.0  # [%] difference of a share that counts as the same
SAME_STANCE = 2.0  # [% of the stride] difference of a stance that counts as the same
SAME_STRIDE = 10.0  # [%] difference of a change of stride length that counts as the same
LEVEL_SHARES = (42.0, 16.0, 42.0)
"""Hip, knee and ankle in the positive work of level walking [%]."""
STRIDES = {"0.75 m/s": -25.0, "1.75 m/s": 24.0, "slope -9°": -6.0, "slope 9°": 1.0}
"""Change of stride length in people, from stride frequencies [Franz2012]_ [%]."""
STANCES = {"0.75 m/s": 1.2, "1.75 m/s": -0.7, "slope -9°": -0.1, "slope 9°": 0.3}
"""Change of the part of stance in people, from the same [% of the stride]."""
SLOPE_SHARES = {
    "slope -9°": ((34.0, 22.0, 42.0), (17.0, 45.0, 38.0)),
    "slope 9°": ((37.0, 22.0, 42.0), (29.0, 44.0, 27.0)),
}
"""Hip, knee and ankle in the positive and in the negative work of stance in people [%]; negative
work of the knee is what is left."""


@dataclass(frozen=True)
class Change:
    """How a walk differs from the plain one."""

    speed: float = SPEED  #: [m/s]
    slope: float = 0.0  #: [deg]
    words: Impairments = Impairments()  #: Loads, and ranges of the knees
    place: str = ""  #: Of a load
    mass: float = 0.0  #: Of a load [kg]


def changes_of(part: str) -> dict[str, Change]:
    """Return the walks of a part by name, the plain one first."""
    found = {PLAIN: Change()}
    if part == "loads":
        for place, masses in LOADS.items():
            for m in masses:
                words = Impairments(load=(f"{place}={m}",))
                found[f"{place} {m} kg"] = Change(words=words, place=place, mass=float(m))
    elif part == "speeds":
        found |= {f"{v} m/s": Change(v) for v in SPEEDS}
    elif part == "slopes":
        found |= {f"slope {a}°": Change(slope=float(a)) for a in SLOPES}
    else:
        for a in MIN_KNEE_FLEXIONS:
            words = Impairments(limit=tuple(f"knee_{side}={a}:120" for side in "rl"))
            found[f"knees bent {a}°"] = Change(words=words)
    return found


def measure(change: Change) -> Result:
    """Return figures of a walk, and the steps that cost least."""
    human = change.words.person(Human.create(1.78, 74.0))
    usual = gait_parameters(human, change.speed)

    def task(p: GaitParameters) -> Any:
        walk = periodic_walk(human, p, slope=float(np.deg2rad(change.slope)))
        return change.words.task(human, walk)

    timed = solve(human, task(usual))
    run = check_motion(timed)
    found = find_times(
        timed.solution.body,
        lambda times: task(with_walking_times(usual, times)),
        free_walking_times(usual),
    )
    best = with_walking_times(usual, found.times)
    curves, motion = gait_curves(run.record), run.record.motion
    way = float(np.linalg.norm(motion.qpos[-1, :3] - motion.qpos[0, :3]))
    swing = curves.percent > 65.0
    moments = {n: np.nanmean(curves.moments[n], axis=0) for n in JOINTS}
    angles = {n: np.nanmean(curves.angles[n], axis=0) for n in (*JOINTS, "pelvis_tilt")}
    stance = curves.percent <= 100.0 * usual.stance_fraction
    powers = [np.nanmean(curves.powers[n], axis=0) for n in JOINTS]
    seconds = curves.percent / 100.0 * usual.stride_time
    return {
        "place": change.place,
        "mass": change.mass,
        **outcome(timed, run),
        "effort": float(np.dot(EFFORT, muscle_work(run.record))) / way,
        "swing_moment": float(np.ptp(moments["hip_flexion_r"][swing])),
        "peaks": {n: float(-m[stance].min()) for n, m in moments.items()},
        **{
            f"{sign} work in {phase}": [
                float(trapezoid(np.maximum(factor * x[span], 0.0), seconds[span])) for x in powers
            ]
            for sign, factor in (("positive", 1.0), ("negative", -1.0))
            for phase, span in (("stance", stance), ("stride", curves.percent >= 0.0))
        },
        "angles": angles,
        "stride": 2.0 * best.step_length,
        "stance": 100.0 * best.stance_fraction,
    }


def segments(angles: dict[str, Array]) -> tuple[Array, Array]:
    """Return how far forward thigh and shank are turned from the vertical [deg]."""
    thigh = np.add(angles["hip_flexion_r"], angles["pelvis_tilt"])
    return thigh, thigh - np.asarray(angles["knee_angle_r"])


def changes(cached: CachedResults) -> dict[str, dict[str, Any]]:
    """Return what changes against the plain walk of the same part, by name."""
    results = cached.select()
    found: dict[str, dict[str, Any]] = {}
    for key, r in results.items():
        part, name = key.split("/", 1)
        plain = results.get(f"{part}/{PLAIN}")
        if plain is None or r is plain:
            continue
        apart = [np.subtract(r["angles"][n], plain["angles"][n]) for n in JOINTS]
        pairs = zip(segments(r["angles"]), segments(plain["angles"]), strict=True)
        found[name] = {
            "part": part,
            **{n: r[n] for n in ("place", "mass", *WORK_SHARES)},
            **{n: 100.0 * (r[n] / plain[n] - 1.0) for n in ("effort", "swing_moment", "stride")},
            "peaks": [100.0 * (r["peaks"][n] / plain["peaks"][n] - 1.0) for n in JOINTS],
            "stance": r["stance"] - plain["stance"],
            "angles": float(np.sqrt(np.mean(np.square(apart)))),
            "shape": min(float(np.corrcoef(a, b)[0, 1]) for a, b in pairs),
        }
    return found


def shares(work: list[float]) -> list[float]:
    """Return the shares of hip, knee and ankle in a work [%]."""
    return [float(100.0 * x / sum(work)) for x in work]


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the verdicts and the changes, with those of people as goals."""
    for key, r in cached.select().items():
        yield Row(key, "passes the check", float(r["good"]), goal="= 1", met=bool(r["good"]))
    found = changes(cached)
    yield from _load_rows(found)
    for name, x in found.items():
        if name in STRIDES:
            off = x["stride"] - STRIDES[name]
            yield within(name, "change of stride length less people's", off, SAME_STRIDE, "%")
            off = x["stance"] - STANCES[name]
            yield within(name, "change of stance less people's", off, SAME_STANCE, "%")
        for work, theirs in _shares_of_people(name, x["part"]).items():
            pairs = zip(JOINTS, shares(x[work]), theirs, strict=True)
            for joint, own, their in pairs:
                quantity = f"{joint.split('_')[0]} in {work}, less people's"
                yield within(name, quantity, own - their, SAME_SHARE, "%")
        if x["part"] == "bent knees":
            hip, knee, _ = x["peaks"]
            yield at_least(name, "effort", x["effort"], 0.0, "%")
            yield at_least(name, "peak moment of the knee", knee, 0.0, "%")
            yield at_most(name, "peak moment of the hip less the knee's", hip - knee, 0, "%")
            yield at_least(name, "r of thigh and shank", x["shape"], SAME_SHAPE)
    if {"slope 9°", "slope -9°"} <= set(found):
        up, down = (found[f"slope {a}°"] for a in (9, -9))
        net = [sum(x[WORK_SHARES[1]]) - sum(x[WORK_SHARES[2]]) for x in (up, down)]
        yield Row("slopes", "net work up over down; people 1.25", net[0] / -net[1])


def _shares_of_people(name: str, part: str) -> dict[str, tuple[float, float, float]]:
    """Return the shares of hip, knee and ankle in works of people, where they are known [%]."""
    if part == "speeds":
        return {WORK_SHARES[0]: LEVEL_SHARES}
    return dict(zip(WORK_SHARES[1:], SLOPE_SHARES.get(name, ()), strict=False))


def _load_rows(found: dict[str, dict[str, Any]]) -> Iterator[Row]:
    before = 0.0
    for place in PLACES:
        own = [x["effort"] / x["mass"] for x in found.values() if x["place"] == place]
        if own:
            mean = float(np.mean(own))
            yield at_least(place, "effort for each kilogram", mean, before, "%")
            before = mean
    for name, x in found.items():
        if x["place"]:
            limit = None if x["place"] == "feet" else MAX_CHANGE
            yield at_most(name, "RMS of leg angles", x["angles"], limit, "deg")


def grids(cached: CachedResults) -> Iterator[Grid]:
    """Return all changes, people's in brackets."""
    lines = []
    for name, x in changes(cached).items():
        stride = f" ({STRIDES[name]:+.0f})" if name in STRIDES else ""
        stance = f" ({STANCES[name]:+.1f})" if name in STANCES else ""
        works = {work: ", ".join(f"{s:.0f}" for s in shares(x[work])) for work in WORK_SHARES}
        for work, theirs in _shares_of_people(name, x["part"]).items():
            works[work] += f" ({', '.join(f'{s:.0f}' for s in theirs)})"
        lines.append(
            [name, f"{x['stride']:+.0f} %{stride}", f"{x['stance']:+.1f} %{stance}",
             f"{x['effort']:+.0f} %", *works.values(),
             ", ".join(f"{p:+.0f}" for p in x["peaks"]) + " %",
             f"{x['swing_moment']:+.0f} %", f"{x['angles']:.1f}°"]
        )  # fmt: skip
    header = (
        "", "stride", "stance", "effort", *(f"{work} [%]" for work in WORK_SHARES),
        "peak extension", "hip moment in swing", "RMS of leg angles",
    )  # fmt: skip
    yield Grid("Against the plain walk; hip, knee, ankle; people in brackets", header, lines)


def cases(part: str, quick: bool) -> Cases:
    """Return the walks of a part."""
    chosen = changes_of(part)
    if quick:
        chosen = {name: x for name, x in chosen.items() if name in (PLAIN, *QUICK_CHANGES)}
    return {f"{part}/{name}": partial(measure, x) for name, x in chosen.items()}


EXPERIMENT = Specification(
    name="changed-walks",
    title="Walks with loads, at other speeds, on slopes and with bent knees",
    parts={p: partial(cases, p) for p in ("loads", "speeds", "slopes", "bent knees")},
    quick_parts=("loads", "slopes"),
    summary=summary,
    rows=rows,
    grids=grids,
    notes=(
        "",
        "People: loads [Browning2007], speeds [Farris2012], stride and stance [Franz2012], work on "
        "slopes [Montgomery2018] [DeVita2007], bent knees [Foster2013] [Grasso2000]. Effort is "
        "work of muscles, positive at an efficiency of .25 and negative at 1.2. Stride and stance "
        "are those that cost least.",
    ),
    remarks=failure_remarks,
)
