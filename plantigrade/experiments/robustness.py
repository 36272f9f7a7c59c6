"""What replays survive that was not planned: other mass, friction, ground, delay, sensor noise."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from plantigrade.experiments.kept_results import KeptResults, Result
from plantigrade.experiments.replay import MOTIONS, ROOMS, brief, cases, synthesised
from plantigrade.experiments.table import ResultTable, Row, at_least
from plantigrade.workflows.replays import Otherwise, replay_once
from plantigrade.world.grounds import ground_named

FILE = "robustness.json"
LONG, SHORT, STARTS = 10.0, 3.0, 5
SURVIVE = 90.0
NAMES = ("walk 1.0 m/s", "walk 1.3 m/s", "walk 1.6 m/s", "walk from standing", "sit-to-stand",
         "side-step", "squat", "jump")  # fmt: skip
DISTURBED = {
    "as planned": lambda seed: Otherwise(),
    "10 % heavier": lambda seed: Otherwise(mass=1.1),
    "10 % lighter": lambda seed: Otherwise(mass=0.9),
    "friction 0.5": lambda seed: Otherwise(friction=0.5),
    "friction 1.0": lambda seed: Otherwise(friction=1.0),
    "bumps of 1 cm": lambda seed: Otherwise(ground=ground_named("bumps:1", seed=seed)),
    "delay of 10 ms": lambda seed: Otherwise(delay=0.010),
    "sensor noise": lambda seed: Otherwise(sensor_angle=0.002, sensor_rate=0.02),
}
"""Name → what is otherwise, by the number of the start."""

NOTES = (
    "",
    "How to read it: runs from starts disturbed as in the experiment replay, one disturbance at a "
    "time, of which the controller knows nothing; walks on level ground are repeated for 10 s. "
    "Bumps are another random relief for each start (left out where a motion needs its own "
    "ground). Sensor noise: 0.002 rad on angles, 0.02 rad/s and m/s on velocities, white, at "
    "500 Hz.",
)


def outcome(item: tuple[str, str, int, float]) -> Result:
    """Return what became of a motion where something is otherwise."""
    name, what, seed, long = item
    how = DISTURBED[what](seed)
    duration = long if MOTIONS[name].repeated else None
    found = replay_once(synthesised(name), duration, seed=seed, otherwise=how)
    return {
        "survived": found.survived,
        "seconds": found.seconds,
        "error_deg": float(np.rad2deg(found.error)),
    }


def run(
    *,
    out: Path | None = None,
    overwrite: bool = False,
    quick: bool = False,
    jobs: int = 1,
    say: Callable[[str], None] = lambda _: None,
) -> ResultTable:
    """Carry motions out under what was not planned.

    Args:
        out: Folder to keep results in.
        overwrite: Do anew what is there.
        quick: One walk, one start of each disturbance.
        jobs: How many at once; -1 for one per core.
        say: Called with a line for every result.
    """
    kept = KeptResults(None if out is None else out / FILE, say, anew=overwrite, rooms=ROOMS)
    names, starts, long = (("walk 1.3 m/s",), 1, SHORT) if quick else (NAMES, STARTS, LONG)
    items = {
        f"{name}, {what}, start {seed}, {long:g} s": (name, what, seed, long)
        for name in names
        for what in DISTURBED
        for seed in range(1, starts + 1)
        if what != "bumps of 1 cm" or not name.startswith("sit")
    }
    found = kept.get_all(cases(outcome, items), brief, jobs=jobs)
    rows = []
    for what in DISTURBED:
        for name in names:
            own = [found[k] for k, item in items.items() if item[:2] == (name, what)]
            if not own:
                continue
            share = 100.0 * float(np.mean([bool(r.get("survived")) for r in own]))
            problem = next((str(r["error"]) for r in own if "error" in r), "")
            row = at_least(name, f"survived, {what}", share, SURVIVE, "%")
            rows.append(row if not problem else Row(name, row.quantity, share, "%", note=problem))
    return ResultTable("Motions under what was not planned", rows, [*NOTES, *kept.notes()])
