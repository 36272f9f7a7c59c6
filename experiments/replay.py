"""Replay of synthesised motions and recorded walks in the physical world.

Every motion that ``synthesize`` offers is carried out by one controller with one setting from
starts that are disturbed in every velocity; periodic walks are repeated. Recorded walks, fitted and
reproduced, are carried out from their first frame to their last. Then motions are pushed: the walk
at every phase of a step, people who stand, and every motion in its middle.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.cached_results import CachedResults, Cases, Result
from experiments.gait_walks import PEOPLE, QUICK_PEOPLE
from experiments.specification import Specification, runs_on
from experiments.table import Row, at_least, at_most
from plantigrade.control.replay import Replay
from plantigrade.control.replay.trials import ReplayOutcome, largest_push, replay_once
from plantigrade.record import Record
from plantigrade.workflows.motions import synthesize
from plantigrade.workflows.reproduce import reproduce

DURATION = 20.0
"""Duration of a repeated walk [s]."""
QUICK_DURATION = 5.0
"""Duration of a repeated walk in the short form [s]."""
N_STARTS = 10
"""Number of disturbed starts."""
N_QUICK_STARTS = 2
"""Number of disturbed starts in the short form."""
MIN_SURVIVAL_SHARE = 98.0
"""Goal: share of survived motions [%]."""
MIN_COMPLETED_SHARE = 80.0
"""Goal: share of completed recordings [%]."""
MAX_OFFSET = 0.10
"""Goal: offset from the path [m]."""
MIN_MEDIAN_PUSH = 250.0
"""Goal of the median push limit [N]."""
MIN_WORST_PUSH = 100.0
"""Goal of the least push limit [N]."""
MIN_STANDING_PUSH = 200.0
"""Goal of the least push limit of standing people [N]."""
FORCES = tuple(float(f) for f in range(50, 501, 50))
QUICK_FORCES = (100.0, 200.0, 300.0)
"""Forces that are tried, also in the short form [N]."""
PUSH_PHASES = (0.0, 0.25, 0.5, 0.75)
DIRECTIONS = tuple(range(0, 360, 45))
"""Directions of pushes: 0 forward, 90 to the left [deg]."""
FOUR_DIRECTIONS = (0, 90, 180, 270)
"""Directions of pushes where fewer are enough [deg]."""
SETTLING_TIME = 1.0
"""A walk is pushed in the first step after this time [s]."""
WATCH_TIME = 2.5
"""Time on the feet after a push [s]."""
STANDING_TIMES = {"reach": 0.5, "squat": 0.5}
"""Motions in which a person still stands at that time [s]."""
MAX_PUSH_TIME = 2.0
"""Latest time of a push in the middle of a motion [s]."""
WALK = "walk 1.3 m/s"
"""The walk that is pushed."""

NOTES = (
    "",
    "A run is survived if nothing but feet and seat touches anything and the centre of mass does "
    "not sink, until the end; the error is that of the joints to the motion at the phase of the "
    "replay, root mean square, the median of the runs; the offset from the path is that of the "
    "centre of mass at the end, the largest of the survived runs. Starts: Gaussian noise of "
    "0.05 m/s and rad/s on every velocity. Physics 1000 Hz, commands 500 Hz. Bodies are solid: "
    "who is pushed so that one leg is more than 30 mm in the other has not survived. Pushes: 0.2 s "
    "at the upper trunk, the largest of 50, 100, … 500 N that is survived for 2.5 s, by bisection, "
    "one start. Standing: pushed at 0.5 s of a reach and of a squat; a recovery step is allowed. "
    "On the way: in the middle of a motion, at 2 s at the latest.",
)


@dataclass(frozen=True)
class Task:
    """A motion to synthesise.

    Attributes:
        task: Name of its task.
        options: Options of the task.
        repeated: Whether it is a periodic walk.
    """

    task: str
    options: dict[str, Any] = field(default_factory=dict)
    repeated: bool = False


def walk(**options: Any) -> Task:
    """Return a periodic walk."""
    return Task("walk", {"periodic": True, **options}, repeated=True)


MOTIONS = {
    **{f"walk {v:.1f} m/s": walk(speed=v) for v in (0.7, 1.0, 1.3, 1.6)},
    "walk uphill 8°": walk(slope=float(np.deg2rad(8.0))),
    "walk downhill 8°": walk(slope=float(np.deg2rad(-8.0))),
    "walk, 1.55 m 50 kg": walk(height=1.55, mass=50.0),
    "walk, 1.90 m 95 kg": walk(height=1.90, mass=95.0),
    "walk from standing": Task("walk"),
    "walk turning 45°": Task("walk", {"turn": float(np.deg2rad(45.0))}),
    "walk, step of 10 cm": Task("walk", {"step_height": 0.10}),
    "walk, step down of 10 cm": Task("walk", {"step_height": -0.10}),
    "walk 1.3 m/s, 66 coordinates": walk(speed=1.3, joints="66", feet="multi-segment"),
    "sit-to-stand": Task("sit-to-stand"),
    "stand-to-sit": Task("stand-to-sit"),
    "squat": Task("squat"),
    "reach": Task("reach"),
    "side-step": Task("side-step"),
    "jump": Task("jump"),
}
"""Tasks of ``synthesize``, by name."""
QUICK_MOTIONS = ("walk 1.3 m/s", "sit-to-stand", "side-step")


@cache
def synthesised(name: str) -> Record:
    """Return a motion of :data:`MOTIONS`."""
    motion = MOTIONS[name]
    return synthesize(motion.task, **motion.options).record


def motion_outcome(name: str, seed: int, duration: float) -> Result:
    """Return the outcome of a motion from a disturbed start; a walk is repeated for a duration."""
    found = replay_once(synthesised(name), duration if MOTIONS[name].repeated else None, seed=seed)
    return {**outcome(found), "off_path_m": found.off_path, **found.figures}


def recorded_outcome(path: Path) -> Result:
    """Return the outcome of the reproduction of a recorded walk."""
    record = reproduce(path).record
    found = replay_once(record)
    duration = record.motion.duration
    return {**outcome(found), "duration": duration, "off_path_m": found.off_path}


def outcome(found: ReplayOutcome) -> Result:
    """Return survival, duration and joint error of a replay."""
    error = float(np.rad2deg(found.error))
    return {"survived": found.survived, "seconds": found.seconds, "error_deg": error}


def push_outcome(name: str, time: float, direction: int, forces: Sequence[float]) -> Result:
    """Return the largest push survived, at a time, in a direction [deg]."""
    controller, angle = Replay(synthesised(name)), float(np.deg2rad(direction))
    return {"force": largest_push(controller, time, angle, forces, after=WATCH_TIME)}


def phase_outcome(name: str, phase: float, direction: int, forces: Sequence[float]) -> Result:
    """Return the largest push survived at a phase of a step."""
    reference = Replay(synthesised(name)).reference
    step = reference.duration / reference.schedule.per_period
    return push_outcome(name, SETTLING_TIME + phase * step, direction, forces)


def middle_outcome(name: str, direction: int, forces: Sequence[float]) -> Result:
    """Return the largest push survived in the middle of a motion."""
    time = min(0.5 * synthesised(name).motion.duration, MAX_PUSH_TIME)
    return push_outcome(name, time, direction, forces)


# Cases --------------------------------------------------------------------------------------------


def motions(quick: bool) -> Cases:
    """Return all motions from disturbed starts."""
    starts, duration = (N_QUICK_STARTS, QUICK_DURATION) if quick else (N_STARTS, DURATION)
    return {
        f"motions/{name}/{duration:g} s/{seed}": partial(motion_outcome, name, seed, duration)
        for name in (QUICK_MOTIONS if quick else MOTIONS)
        for seed in range(1, starts + 1)
    }


def recordings(data: Path | None, quick: bool) -> Cases:
    """Return the recorded walks of a folder."""
    people = QUICK_PEOPLE[:2] if quick else tuple(PEOPLE)
    names = [name for person in people for name in sorted(PEOPLE[person])[: 1 if quick else None]]
    paths = {name: data / name for name in names} if data is not None else {}
    return {
        f"recordings/{name}": partial(recorded_outcome, path)
        for name, path in paths.items()
        if path.exists()
    }


def pushes(quick: bool) -> Cases:
    """Return pushes of the walk at phases of a step."""
    forces = QUICK_FORCES if quick else FORCES
    return {
        f"pushes/{WALK}/pushed at {phase:g} of a step to {angle} deg, by {forces[-1]:g} N at most":
            partial(phase_outcome, WALK, phase, angle, forces)
        for phase in ((0.25,) if quick else PUSH_PHASES)
        for angle in ((0, 90) if quick else DIRECTIONS)
    }  # fmt: skip


def standing(quick: bool) -> Cases:
    """Return pushes of people who stand."""
    forces = QUICK_FORCES if quick else FORCES
    return {
        f"standing/{name}/pushed while standing to {angle} deg, by {forces[-1]:g} N at most":
            partial(push_outcome, name, time, angle, forces)
        for name, time in STANDING_TIMES.items()
        for angle in (FOUR_DIRECTIONS if quick else DIRECTIONS)
    }  # fmt: skip


def on_the_way(quick: bool) -> Cases:
    """Return pushes in the middle of every motion."""
    names, forces = (QUICK_MOTIONS, QUICK_FORCES) if quick else (tuple(MOTIONS), FORCES)
    return {
        f"on the way/{name}/{angle}": partial(middle_outcome, name, angle, forces)
        for name in names
        for angle in FOUR_DIRECTIONS
    }


# Figures ------------------------------------------------------------------------------------------


def summary(result: Result) -> str:
    """Return one line about a result."""
    if "force" in result:
        return f"{result['force']:.0f} N"
    ended = "survived" if result["survived"] else f"fell after {result['seconds']:.2f} s"
    return f"{ended}, {result['error_deg']:.1f}° off"


def rows(cached: CachedResults) -> Iterator[Row]:
    """Return the figures of all parts."""
    yield from motion_rows(cached)
    found = cached.select("recordings", failed=True)
    for key, result in found.items():
        name, problem = key.partition("/")[2], str(result.get("error", ""))
        note = problem or ("" if result["survived"] else "fell")
        yield Row(name, "walked", result.get("seconds"), "s", note=note)
        if not problem:
            yield Row(name, "joint error", result["error_deg"], "deg")
    if found:
        share = 100.0 * float(np.mean([bool(r.get("survived")) for r in found.values()]))
        yield at_least("recorded walks", "walked to their end", share, MIN_COMPLETED_SHARE, "%")
    for part, subject, goals in (
        ("pushes", "pushes", (MIN_MEDIAN_PUSH, MIN_WORST_PUSH)),
        ("standing", "pushes while standing", (None, MIN_STANDING_PUSH)),
    ):
        found = cached.select(part, failed=True)
        for key, result in found.items():
            name, problem = ", ".join(key.split("/")[1:]), str(result.get("error", ""))
            yield Row(name, "largest survived", result.get("force"), "N", note=problem)
        held = [float(r.get("force", 0.0)) for r in found.values()]
        if held:
            complete = part == "standing" or len(held) >= len(pushes(False))
            if goals[0] is not None and complete:
                yield at_least(subject, "median", float(np.median(held)), goals[0], "N")
            if complete:
                yield at_least(subject, "worst", min(held), goals[1], "N")
    for name in MOTIONS:
        found = cached.select("on the way", name, failed=True)
        if found:
            held = {key.split("/")[2]: float(r.get("force", 0.0)) for key, r in found.items()}
            problem = next((str(r["error"]) for r in found.values() if "error" in r), "")
            note = problem or ", ".join(f"{angle}°: {force:g} N" for angle, force in held.items())
            yield Row(name, "push survived on the way", min(held.values()), "N", note=note)


def motion_rows(cached: CachedResults) -> Iterator[Row]:
    """Return survival, error and offset from the path of every motion; of long runs if there."""
    every: list[Result] = []
    for name in MOTIONS:
        durations = (f"{DURATION:g} s", f"{QUICK_DURATION:g} s")
        found = (cached.select("motions", name, long, failed=True).values() for long in durations)
        results = next(filter(None, map(list, found)), [])
        every += results
        alive = [r for r in results if r.get("survived")]
        if problem := next((r["error"] for r in results if "error" in r), ""):
            yield Row(
                name, "survived", None, "%", f">= {MIN_SURVIVAL_SHARE:g}", False, str(problem)
            )
        elif results:
            yield at_least(
                name, "survived", 100.0 * len(alive) / len(results), MIN_SURVIVAL_SHARE, "%"
            )
            error = float(np.median([r["error_deg"] for r in results]))
            yield Row(name, "joint error", error, "deg")
            if alive:
                offset = max(float(r["off_path_m"]) for r in alive)
                yield at_most(name, "beside its path at the end", offset, MAX_OFFSET, "m")
    if every:
        share = 100.0 * float(np.mean([bool(r.get("survived")) for r in every]))
        yield at_least("all motions", "survived", share, MIN_SURVIVAL_SHARE, "%")


def experiment(data: Path | None) -> Specification:
    """Return the experiment, with the recordings of a folder."""
    return Specification(
        name="replay",
        title="Motions carried out in the physical world",
        parts={
            "motions": motions,
            "recordings": partial(recordings, data),
            "pushes": pushes,
            "standing": standing,
            "on the way": on_the_way,
        },
        quick_parts=("motions", "recordings", "pushes"),
        summary=summary,
        rows=rows,
        notes=NOTES,
    )


run = runs_on(experiment)
EXPERIMENT = experiment(None)
