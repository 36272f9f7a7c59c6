"""Solved motions, kept as small run folders: what looks at a motion loads it and does not solve it.

``python -m tests.stored.make`` makes them anew, after the format of a run or a task has changed;
``test_stored.py`` says whether they are still what the solver gives.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import plantigrade as pg
from plantigrade.record import Record, Run

HERE = Path(__file__).parent
KEPT = ("model.xml", "motion.npz", "metrics.json")


def sit_to_stand() -> Run:
    """Feet and a seat carry a person who stands up."""
    return pg.synthesize("sit-to-stand", joints="43", nodes_per_second=10.0)


def side_step() -> Run:
    """Feet that leave the ground and come down."""
    return pg.synthesize("side-step", joints="42", nodes_per_second=10.0)


MOTIONS: dict[str, Callable[[], Run]] = {"sit-to-stand": sit_to_stand, "side-step": side_step}


def stored(name: str) -> Run:
    """Return a stored motion."""
    return pg.load_run(HERE / name)


def small(run: Run) -> Run:
    """Return the run without what only a warm start needs, every second sample of it."""
    record, every = run.record, slice(None, None, 2)
    motion = record.motion
    fewer = {
        name: None if value is None else value[every]
        for name in ("qfrc_actuator", "contact_force", "contact_point", "contact_planned")
        for value in [getattr(record, name)]
    }
    motion = replace(
        motion,
        time=motion.time[every],
        qpos=motion.qpos[every],
        qvel=motion.qvel[every],
        qacc=None if motion.qacc is None else motion.qacc[every],
    )
    kept: Record = replace(record, motion=motion, signals={}, **fewer)
    return replace(run, record=kept)


if __name__ == "__main__":
    for name, make in MOTIONS.items():
        made = small(make())
        assert made.ok, made.status
        folder = made.save(HERE / name, overwrite=True).folder
        for path in folder.iterdir():
            if path.name not in KEPT:
                path.unlink()
