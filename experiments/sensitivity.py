"""Sensitivity of a controller to its settings: each one changed by a fifth, over a short battery.

Walking: on level ground, pushed, along a path, at changing speeds and heights, on bumps, over edges
and steps, shoved hard, standing and pushed there, round sharp corners, with slow ticks, as fast as
can be, and under a barrier. Standing: undisturbed, pushed forward, sideways and off balance, on a
moving floor, leaning with bent knees, and jumping. A setting
matters if a change of it costs or saves time on the feet, or changes the deviation by
:data:`MIN_EFFECT`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.chosen_numbers import chosen_numbers
from experiments.specification import Specification
from experiments.table import Grid, Row
from experiments.walk_trial import WalkTrial, world_of
from experiments.walkers import Walker, walker
from experiments.walking import own_walk, person, runs
from plantigrade.control.balance import script_named, scripted
from plantigrade.control.choices import CONTROLLERS, Situation, controller_named
from plantigrade.control.numbers import numbers_of
from plantigrade.errors import ParameterError
from plantigrade.threads import on_one_thread
from plantigrade.world import (
    Barrier,
    Controller,
    Disturbance,
    FloorShift,
    InitialState,
    PhasePush,
    Push,
    on_ground,
    standing_on,
    world_for,
)
from plantigrade.world.grounds import ground_named

RELATIVE_CHANGE = 0.2
"""Change of a setting, by its value."""
MIN_EFFECT = 0.02
"""Relative change of the mean deviation from which on a setting matters."""
STANDING_CONTROLLERS = ("posture", "balance", "hybrid")
"""Controllers of people who stand."""
NOTES = (
    "",
    "Seconds on the feet and the mean deviation of a short battery, with each setting 20 % smaller "
    "and 20 % larger: of joint angles from the gait for those who walk, of the centre of mass from "
    "its start for those who stand. Whole numbers change by 1 at least; words, switches and zeros "
    "are left out. Single runs at the edge of falling are decided by chance.",
)


@dataclass(frozen=True, kw_only=True)
class WalkCase:
    """A walk of the battery.

    Attributes:
        duration: Duration [s].
        disturbances: The disturbances.
        ground: Name of the ground.
        points: Points of the path [m].
        script: Time [s], target and value of commands.
        tick: Time for which a command holds [s]; that of the settings where None.
    """

    duration: float
    disturbances: tuple[Disturbance, ...] = ()
    ground: str = "flat"
    points: tuple[tuple[float, float], ...] = ()
    script: tuple[tuple[float, str, float], ...] = ()
    tick: float | None = None


WALKS: Mapping[str, WalkCase] = {
    "level": WalkCase(duration=3.0),
    "pushed": WalkCase(
        duration=6.0,
        disturbances=(
            PhasePush(force=200.0, duration=0.3, direction=np.pi / 2, side="r", phase=0.2),
        ),
    ),
    "bumps": WalkCase(duration=4.0, ground="bumps:3"),
    "course": WalkCase(duration=6.0, points=((2.5, 0.0), (2.5, 2.5))),
    "script": WalkCase(
        duration=7.0,
        script=(
            (0.5, "stoop", 15.0),
            (1.5, "speed", 0.6),
            (3.0, "speed", 0.0),
            (5.0, "speed", 1.0),
        ),
    ),
    "edges": WalkCase(duration=5.0, ground="tiles:5"),
    "stairs": WalkCase(duration=5.0, ground="steps:6"),
    "shoved": WalkCase(
        duration=5.0,
        disturbances=(
            PhasePush(force=350.0, duration=0.3, direction=-np.pi / 2, side="r", phase=0.2),
        ),
    ),
    "standing": WalkCase(
        duration=6.0,
        disturbances=(Push(force=120.0, duration=0.2, direction=1.0, time=3.5),),
        script=((0.5, "speed", 0.0), (4.5, "speed", 1.2)),
    ),
    "corner": WalkCase(duration=6.0, points=((1.5, 0.0), (1.5, 1.0), (0.5, 1.0))),
    "slow ticks": WalkCase(duration=4.0, tick=0.02),
    "fast": WalkCase(duration=5.0, script=((0.5, "speed", 9.0),)),
    "barrier": WalkCase(duration=5.0, disturbances=(Barrier(ahead=3.0, height=1.65),)),
}
"""The battery of walking controllers."""


@dataclass(frozen=True, kw_only=True)
class StandCase:
    """A case of the battery of those who stand.

    Attributes:
        duration: Duration [s].
        disturbances: The disturbances.
        stepping: Whether balance may step.
        targets: Targets that are set after half a second, and their values.
        motion: A foot motion, for balance and a person with multi-segment feet; none if empty.
    """

    duration: float = 2.0
    disturbances: tuple[Disturbance, ...] = ()
    stepping: bool = False
    targets: Mapping[str, float] = field(default_factory=dict)
    motion: str = ""


STANDING_CASES: Mapping[str, StandCase] = {
    "quiet": StandCase(),
    "pushed forward": StandCase(
        disturbances=(Push(force=60.0, duration=0.2, direction=0.0, time=0.2),)
    ),
    "pushed aside": StandCase(
        disturbances=(Push(force=60.0, duration=0.2, direction=np.pi / 2, time=0.2),)
    ),
    "shifted": StandCase(
        disturbances=(FloorShift(distance=0.05, duration=0.3, direction=0.0, time=0.2),)
    ),
    "stepping": StandCase(
        disturbances=(Push(force=220.0, duration=0.2, direction=0.5, time=0.2),), stepping=True
    ),
    "bent": StandCase(targets={"weight forward": 4.0, "height": -10.0, "knees flexion": 20.0}),
    "jump": StandCase(duration=4.0, motion="jump"),
}
"""The battery of standing controllers."""


@on_one_thread
def walked(name: str, data: Path | None, values: Mapping[str, Any], cases: Sequence[str]) -> Result:
    """Return time on the feet [s] and deviation [deg] of a battery of walks."""
    record = own_walk(data)

    def make(case: WalkCase, _: Any) -> Controller:
        at = Situation(
            human=record.human, ground=record.ground, motion=record.motion, record=record
        )
        own = {} if case.tick is None else {"tick": case.tick}
        return controller_named(name, at, {**own, **values})

    one = walker(name, record)
    record = one.record
    walks = [WALKS[case] for case in cases]
    return _result([_walk(Walker(record, partial(make, case), name), case) for case in walks])


def _walk(one: Walker, case: WalkCase) -> tuple[float, float]:
    """Return for how long somebody is on the feet [s], and the deviation [deg]."""
    controller = one.controller()
    if case.points:
        controller.follow(np.array(case.points))
    world = world_of(one, controller, ground_named(case.ground, seed=1), case.disturbances)
    going, script = WalkTrial(one, controller, world), list(case.script)
    targets = {target.name: target for target in controller.targets}
    while going.on and world.time < case.duration - 0.5 / world.rate:
        while script and script[0][0] <= world.time:
            _, name, value = script.pop(0)
            if name in targets:
                targets[name].set(min(value, targets[name].high))
        going.step()
    found = going.walked()
    return found.seconds, float(np.rad2deg(np.sqrt(np.nanmean(found.error**2))))


@on_one_thread
def stood(name: str, values: Mapping[str, Any], cases: Sequence[str]) -> Result:
    """Return time on the feet [s] and deviation [mm] of a battery of standing."""
    ground, found = ground_named("flat"), []
    for case in (STANDING_CASES[each] for each in cases):
        if case.motion and name != "balance":
            continue
        human = person(feet="multi-segment" if case.motion else None)
        qpos, script = standing_on(human, ground), None
        if case.motion:
            script = scripted(human, script_named(case.motion))
            qpos = on_ground(human, ground, script.motion.qpos[0])
        stepping = {"stepping": True} if case.stepping and name == "balance" else {}
        at = Situation(human=human, ground=ground, standing=qpos, script=script)
        controller = controller_named(name, at, {**stepping, **values})
        start = InitialState(human, ground, qpos, np.zeros(human.model.nv))
        world = world_for(controller, start, case.disturbances, recording=False)
        state, off = world.reset(), []
        first = state.body.com[:2]
        while world.fall is None and world.diverged is None and world.time < case.duration - 1e-9:
            if world.time >= 0.5:
                for target in controller.targets:
                    target.set(case.targets.get(target.name, target.value))
            state = world.step(controller(state))
            off.append(state.body.com[:2] - first)
        found.append((world.time, 1e3 * float(np.sqrt(np.mean(np.square(off).sum(axis=1))))))
    return _result(found)


def _result(found: Sequence[tuple[float, float]]) -> Result:
    seconds, off = np.array(found).T
    return {"seconds": float(seconds.sum()), "off": float(np.nanmean(off))}


def _tried(measure: Callable[..., Result], *arguments: Any) -> Result:
    """Return a result; a refused setting is one, too."""
    try:
        return measure(*arguments)
    except ParameterError as error:
        return {"refused": str(error)}


def changed_values(value: Any) -> tuple[Any, Any] | None:
    """Return a value made smaller and larger by a fifth; None where it is no number, or zero.

    Example:
        >>> changed_values(2), changed_values((0.5, 1.0)), changed_values(True)
        ((1, 3), ((0.4, 0.8), (0.6, 1.2)), None)
    """
    if isinstance(value, bool | str) or value is None:
        return None
    if isinstance(value, tuple):
        parts = [changed_values(part) for part in value]
        if not parts or any(part is None for part in parts):
            return None
        low, high = zip(*(part for part in parts if part), strict=True)
        return low, high
    if value == 0:
        return None
    if isinstance(value, int):
        far = max(round(RELATIVE_CHANGE * value), 1)
        return value - far, value + far
    return value * (1.0 - RELATIVE_CHANGE), value * (1.0 + RELATIVE_CHANGE)


def cases(controllers: Sequence[str], data: Path | None, quick: bool) -> Cases:
    """Return the battery with the settings as they are, and with each one changed."""
    found: dict[str, Callable[[], Result]] = {}
    for name in controllers:
        kind = CONTROLLERS[name].settings if name in CONTROLLERS else None
        if kind is None:
            raise ParameterError(f"{name} has no settings; name one of {', '.join(_able())}")
        stands = name in STANDING_CONTROLLERS
        battery = tuple(STANDING_CASES if stands else WALKS)
        battery = battery[:1] if quick else battery
        measure: Callable[..., Result] = partial(stood, name)
        if not stands:
            measure = partial(walked, name, data)
        found[f"{name}/as it is"] = partial(_tried, measure, {}, battery)
        changes = {each.name: changed_values(each.value) for each in numbers_of(kind())}
        every = [(each, values) for each, values in changes.items() if values is not None]
        for each, values in every[:1] if quick else every:
            for sign, value in zip("-+", values, strict=True):
                key = f"{name}/{each}/{sign}"
                found[key] = partial(_tried, measure, {each: value}, battery)
    return found


def _able() -> list[str]:
    return [name for name, kind in CONTROLLERS.items() if kind.settings is not None]


@dataclass(frozen=True)
class Effect:
    """Effect of a changed setting.

    Attributes:
        controller: The controller.
        setting: Dotted name.
        seconds: Change of the time on the feet, setting smaller and larger [s].
        off: Relative change of the deviation, likewise.
    """

    controller: str
    setting: str
    seconds: tuple[float, float]
    off: tuple[float, float]

    @property
    def size(self) -> float:
        """The greater change of the deviation; a second on the feet counts as all of it."""
        return float(np.nanmax(np.abs([*self.seconds, *self.off])))

    @property
    def matters(self) -> bool:
        """Whether the setting matters."""
        return self.size >= MIN_EFFECT


def effects(cached: CachedResults) -> list[Effect]:
    """Return the effects of settings, the greatest first."""
    found = []
    for key, first in cached.results.items():
        controller, setting, *sign = key.split("/")
        base = cached.results.get(f"{controller}/as it is", {})
        second = cached.results.get(f"{controller}/{setting}/+", {})
        if sign != ["-"] or not second or "seconds" not in base:
            continue
        pairs = [
            (each["seconds"] - base["seconds"], each["off"] / base["off"] - 1.0)
            if "seconds" in each
            else (np.nan, np.nan)
            for each in (first, second)
        ]
        seconds, off = zip(*pairs, strict=True)
        if np.isfinite([*seconds, *off]).any():
            found.append(Effect(controller, setting, seconds, off))
    return sorted(found, key=lambda each: -each.size)


def tables(cached: CachedResults) -> Iterator[Grid]:
    """Return one table a controller."""
    every = effects(cached)
    header = ("setting", "on the feet, −20 %", "+20 %", "deviation, −20 %", "+20 %")
    for name in dict.fromkeys(each.controller for each in every):
        lines = [
            [
                each.setting,
                *(f"{value:+.2f} s" for value in each.seconds),
                *(f"{100.0 * value:+.1f} %" for value in each.off),
            ]
            for each in every
            if each.controller == name
        ]
        yield Grid(f"settings of {name}, what matters most first", header, lines)


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return how many numbers were chosen, and how many settings matter."""
    for kind, n in chosen_numbers().items():
        yield Row("all controllers", f"chosen numbers: {kind}", n)
    every = effects(cached)
    for name in dict.fromkeys(each.controller for each in every):
        own = [each for each in every if each.controller == name]
        yield Row(name, "settings that were changed", len(own))
        yield Row(name, "settings that matter", sum(each.matters for each in own))
        yield Row(name, "settings without any effect", sum(each.size == 0.0 for each in own))


def _summary(result: Result) -> str:
    return result.get("refused") or f"{result['seconds']:.2f} s, {result['off']:.3f} off"


def experiment(controllers: Sequence[str], data: Path | None) -> Specification:
    """Return the experiment for some controllers."""
    return Specification(
        name="sensitivity",
        title="Settings of controllers, each changed by a fifth",
        parts={"settings": partial(cases, controllers, data)},
        summary=_summary,
        grids=tables,
        rows=rows,
        notes=NOTES,
    )


run = runs(experiment)
EXPERIMENT = experiment(("pendulum",), None)
"""The experiment with the usual controller."""
