"""Do motions survive in the physical world? Tasks and recorded walks, carried out by replay.

Every motion that ``synthesize`` offers is carried out by one frozen controller from starts that are
disturbed in every velocity; periodic walks are repeated. Recorded walks, fitted and reproduced, are
carried out from their first frame to their last. Then motions are pushed: the walk at every phase
of a step, those who stand, and every motion in its middle.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.gait_walks import PEOPLE, QUICK
from experiments.kept_results import KeptResults, Result
from experiments.synthesis_trial import chosen_parts
from experiments.table import ResultTable, Row, at_least, at_most
from plantigrade.control.replay import Replay
from plantigrade.record import Record
from plantigrade.workflows.motions import synthesize
from plantigrade.workflows.replays import largest_push, replay_once
from plantigrade.workflows.reproduce import reproduce

FILE = "replay.json"
PARTS = ("motions", "recordings", "pushes", "standing", "on the way")
LONG, SHORT = 20.0, 5.0
"""Length of a repeated walk, and in the short form [s]."""
STARTS, FEW = 10, 2
SURVIVE, RECORDED, BACK = 98.0, 80.0, 0.10  # goals: per cent, per cent, [m]
MEDIAN, WORST, STANDING = 250.0, 100.0, 200.0  # goals of pushes [N]
FORCES = tuple(float(f) for f in range(50, 501, 50))
COARSE = (100.0, 200.0, 300.0)
"""Pushes that are tried, and in the short form [N]."""
PHASES = (0.0, 0.25, 0.5, 0.75)
AROUND, SIDES = tuple(range(0, 360, 45)), (0, 90, 180, 270)
"""Directions: 0 forward, 90 to the left [deg]."""
SETTLED, WATCHED = 1.0, 2.5
"""A walk is pushed in the step after the first of these; so long must one stay on the feet [s]."""
STANDS = {"reach": 0.5, "squat": 0.5}
"""Motions in which a person still stands at that time [s]."""
LATEST = 2.0
"""Who is pushed in the middle of a motion is pushed no later [s]."""

NOTES = (
    "",
    "How to read it: survived counts runs in which nothing but feet and seat touched anything and "
    "the centre of mass did not sink, until the end; the error is that of the joints to the motion "
    "at the phase of the replay, root mean square, the median of the runs; beside its path is the "
    "centre of mass at the end, the largest of the runs that survived. Starts: Gaussian noise of "
    "0.05 m/s and rad/s on every velocity. Physics 1000 Hz, commands 500 Hz. Bodies are solid: "
    "who is pushed so that one leg is more than 30 mm in the other has not survived. Pushes: 0.2 s "
    "at the upper trunk, the largest of 50, 100, … 500 N that is survived for 2.5 s, by bisection, "
    "one start. Standing: pushed at 0.5 s of a reach and of a squat; a recovery step is allowed. "
    "On the way: in the middle of a motion, at 2 s at the latest.",
)


@dataclass(frozen=True)
class Told:
    """A motion to be synthesised.

    Attributes:
        task: Its task.
        options: What it is told.
        repeated: Whether it is a periodic walk.
    """

    task: str
    options: dict[str, Any] = field(default_factory=dict)
    repeated: bool = False


def walk(**options: Any) -> Told:
    """Return a periodic walk."""
    return Told("walk", {"periodic": True, **options}, repeated=True)


MOTIONS = {
    **{f"walk {v:.1f} m/s": walk(speed=v) for v in (0.7, 1.0, 1.3, 1.6)},
    "walk uphill 8°": walk(slope=float(np.deg2rad(8.0))),
    "walk downhill 8°": walk(slope=float(np.deg2rad(-8.0))),
    "walk, 1.55 m 50 kg": walk(height=1.55, mass=50.0),
    "walk, 1.90 m 95 kg": walk(height=1.90, mass=95.0),
    "walk from standing": Told("walk"),
    "walk turning 45°": Told("walk", {"turn": float(np.deg2rad(45.0))}),
    "walk, step of 10 cm": Told("walk", {"step_height": 0.10}),
    "walk, step down of 10 cm": Told("walk", {"step_height": -0.10}),
    "walk 1.3 m/s, 66 coordinates": walk(speed=1.3, joints="66", feet="multi-segment"),
    "sit-to-stand": Told("sit-to-stand"),
    "stand-to-sit": Told("stand-to-sit"),
    "squat": Told("squat"),
    "reach": Told("reach"),
    "side-step": Told("side-step"),
    "jump": Told("jump"),
}
"""What ``synthesize`` offers, by name."""
QUICKLY = ("walk 1.3 m/s", "sit-to-stand", "side-step")


@cache
def synthesised(name: str) -> Record:
    """Return a motion of :data:`MOTIONS`."""
    told = MOTIONS[name]
    return synthesize(told.task, **told.options).record


def motion_outcome(item: tuple[str, int, float]) -> Result:
    """Return what became of a motion from a start, repeated for so long if it is a walk."""
    name, seed, long = item
    record = synthesised(name)
    found = replay_once(record, long if MOTIONS[name].repeated else None, seed=seed)
    return {
        "survived": found.survived,
        "seconds": found.seconds,
        "error_deg": float(np.rad2deg(found.error)),
        "off_path_m": found.off_path,
        **found.figures,
    }


def recorded_outcome(path: Path) -> Result:
    """Return what became of the reproduction of a recorded walk."""
    record = reproduce(path).record
    found = replay_once(record)
    return {
        "survived": found.survived,
        "seconds": found.seconds,
        "duration": record.motion.duration,
        "error_deg": float(np.rad2deg(found.error)),
        "off_path_m": found.off_path,
    }


def push_outcome(item: tuple[str, float, int, Sequence[float]]) -> Result:
    """Return the largest push survived, from a time on, in a direction [deg]."""
    name, time, direction, forces = item
    controller, angle = Replay(synthesised(name)), float(np.deg2rad(direction))
    return {"force": largest_push(controller, time, angle, forces, after=WATCHED)}


def phase_outcome(item: tuple[str, float, int, Sequence[float]]) -> Result:
    """Likewise at a phase of a step."""
    name, phase, direction, forces = item
    reference = Replay(synthesised(name)).reference
    step = reference.duration / reference.schedule.per_period
    return push_outcome((name, SETTLED + phase * step, direction, forces))


def middle_outcome(item: tuple[str, int, Sequence[float]]) -> Result:
    """Likewise in the middle of a motion."""
    name, direction, forces = item
    time = min(0.5 * synthesised(name).motion.duration, LATEST)
    return push_outcome((name, time, direction, forces))


def run(
    data: Path | None = None,
    *,
    out: Path | None = None,
    parts: Sequence[str] = (),
    overwrite: bool = False,
    quick: bool = False,
    jobs: int = 1,
    say: Callable[[str], None] = lambda _: None,
) -> ResultTable:
    """Carry motions out, those that are not in the folder of results yet.

    Args:
        data: Folder of recordings; without it there are none.
        out: Folder to keep results in.
        parts: Of :data:`PARTS`; all if empty.
        overwrite: Do anew what is there.
        quick: A few motions from few starts, two pushes.
        jobs: How many at once; -1 for one per core.
        say: Called with a line for every result.

    Raises:
        ParameterError: If there is no such part.
    """
    chosen = chosen_parts(parts, PARTS, PARTS)
    kept = KeptResults(None if out is None else out / FILE, say, anew=overwrite)
    rows: list[Row] = []
    if "motions" in chosen:
        rows += motions(kept, quick=quick, jobs=jobs)
    if "recordings" in chosen and data is not None:
        rows += recordings(kept, data, quick=quick, jobs=jobs)
    if "pushes" in chosen:
        rows += pushes(kept, quick=quick, jobs=jobs)
    if "standing" in chosen and not (quick and not parts):
        rows += standing(kept, quick=quick, jobs=jobs)
    if "on the way" in chosen and not (quick and not parts):
        rows += on_the_way(kept, quick=quick, jobs=jobs)
    return ResultTable("Motions carried out in the physical world", rows, [*NOTES, *kept.notes()])


def cases(work: Callable[[Any], Result], items: dict[str, Any]) -> dict[str, Callable[[], Result]]:
    """Return what makes the result of every key."""
    return {key: partial(work, item) for key, item in items.items()}


def brief(result: Result) -> str:
    """Return a result in a few words."""
    if "error" in result:
        return str(result["error"])
    if "force" in result:
        return f"{result['force']:.0f} N"
    ended = "survived" if result["survived"] else f"fell after {result['seconds']:.2f} s"
    return f"{ended}, {result['error_deg']:.1f}° off"


def motions(kept: KeptResults, *, quick: bool, jobs: int) -> list[Row]:
    """Return the rows of synthesised motions."""
    names = QUICKLY if quick else tuple(MOTIONS)
    starts, long = (FEW, SHORT) if quick else (STARTS, LONG)
    items = {
        f"{name}, start {seed}, {long:g} s": (name, seed, long)
        for name in names
        for seed in range(1, starts + 1)
    }
    found = kept.get_all(cases(motion_outcome, items), brief, jobs=jobs)
    rows, every = [], []
    for name in names:
        own = [found[key] for key, item in items.items() if item[0] == name]
        every += own
        rows += _rows(name, own)
    share = 100.0 * float(np.mean([bool(r.get("survived")) for r in every]))
    rows.append(at_least("all motions", "survived", share, SURVIVE, "%"))
    return rows


def _rows(name: str, results: list[Result]) -> list[Row]:
    """Return survival, error and distance from the path of one motion."""
    if problem := next((r["error"] for r in results if "error" in r), ""):
        return [Row(name, "survived", None, "%", f">= {SURVIVE:g}", False, str(problem))]
    alive = [r for r in results if r["survived"]]
    share = 100.0 * len(alive) / len(results)
    rows = [at_least(name, "survived", share, SURVIVE, "%")]
    rows.append(
        Row(name, "joint error", float(np.median([r["error_deg"] for r in results])), "deg")
    )
    if alive:
        beside = max(float(r["off_path_m"]) for r in alive)
        rows.append(at_most(name, "beside its path at the end", beside, BACK, "m"))
    return rows


def recordings(kept: KeptResults, data: Path, *, quick: bool, jobs: int) -> list[Row]:
    """Return the rows of recorded walks."""
    people = QUICK[:2] if quick else tuple(PEOPLE)
    paths = [name for person in people for name in sorted(PEOPLE[person])[: 1 if quick else None]]
    items = {name: data / name for name in paths if (data / name).exists()}
    if not items:
        return []
    found = kept.get_all(cases(recorded_outcome, items), brief, jobs=jobs)
    rows = []
    for name, result in found.items():
        if "error" in result:
            rows.append(Row(name, "walked", None, "s", note=str(result["error"])))
            continue
        note = "" if result["survived"] else "fell"
        rows.append(Row(name, "walked", result["seconds"], "s", note=note))
        rows.append(Row(name, "joint error", result["error_deg"], "deg"))
    share = 100.0 * float(np.mean([bool(r.get("survived")) for r in found.values()]))
    rows.append(at_least("recorded walks", "walked to their end", share, RECORDED, "%"))
    return rows


def pushes(kept: KeptResults, *, quick: bool, jobs: int) -> list[Row]:
    """Return the rows of pushes at 1.3 m/s."""
    name = "walk 1.3 m/s"
    phases, angles = ((0.25,), (0, 90)) if quick else (PHASES, AROUND)
    forces = COARSE if quick else FORCES
    items = {
        f"{name}, pushed at {phase:g} of a step to {angle} deg, by {forces[-1]:g} N at most": item
        for phase in phases
        for angle in angles
        for item in [(name, phase, angle, forces)]
    }
    found = kept.get_all(cases(phase_outcome, items), brief, jobs=jobs)
    rows, held = _pushed(found)
    if not quick:
        rows.append(at_least("pushes", "median", float(np.median(held)), MEDIAN, "N"))
        rows.append(at_least("pushes", "worst", min(held), WORST, "N"))
    return rows


def _pushed(found: dict[str, Result]) -> tuple[list[Row], list[float]]:
    """Return a row for every push, and the forces survived: none where it ended in an error."""
    rows = [
        Row(key, "largest survived", r.get("force"), "N", note=str(r.get("error", "")))
        for key, r in found.items()
    ]
    return rows, [float(r.get("force", 0.0)) for r in found.values()]


def standing(kept: KeptResults, *, quick: bool, jobs: int) -> list[Row]:
    """Return the rows of pushes of those who stand."""
    forces = COARSE if quick else FORCES
    items = {
        f"{name}, pushed while standing to {angle} deg, by {forces[-1]:g} N at most": item
        for name, time in STANDS.items()
        for angle in (SIDES if quick else AROUND)
        for item in [(name, time, angle, forces)]
    }
    rows, held = _pushed(kept.get_all(cases(push_outcome, items), brief, jobs=jobs))
    return [*rows, at_least("pushes while standing", "worst", min(held), STANDING, "N")]


def on_the_way(kept: KeptResults, *, quick: bool, jobs: int) -> list[Row]:
    """Return the largest push of every motion, in its weakest direction."""
    names, forces = (QUICKLY, COARSE) if quick else (tuple(MOTIONS), FORCES)
    items = {
        f"{name}, pushed on the way to {angle} deg, by {forces[-1]:g} N at most": item
        for name in names
        for angle in SIDES
        for item in [(name, angle, forces)]
    }
    found = kept.get_all(cases(middle_outcome, items), brief, jobs=jobs)
    rows = []
    for name in names:
        own = {item[1]: found[key] for key, item in items.items() if item[0] == name}
        held = {angle: float(r.get("force", 0.0)) for angle, r in own.items()}
        problem = next((str(r["error"]) for r in own.values() if "error" in r), "")
        note = problem or ", ".join(f"{angle}°: {force:g} N" for angle, force in held.items())
        rows.append(Row(name, "push survived on the way", min(held.values()), "N", note=note))
    return rows
