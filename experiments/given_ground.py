"""Ground reactions estimated on slopes and steps, against walks whose forces are known exactly.

A walk is generated on the ground, recorded with the markers and the faults of a laboratory, and
fitted with that ground as given. No constant was chosen on these walks.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from plantigrade.analyze.gait_forces import ForceComparison, compare_forces
from plantigrade.analyze.trial import CUTOFF, analyse
from plantigrade.errors import ReproduceError
from plantigrade.kinematics.textbook_recording import recorded
from plantigrade.kinematics.textbook_walk import TextbookWalk
from plantigrade.motion.filters import lowpass
from plantigrade.motion.motion import interpolate
from plantigrade.record import Record
from plantigrade.trajopt.tasks.gait_settings import WalkSettings
from plantigrade.workflows.fit import fit_recording
from plantigrade.workflows.settings import FitSettings
from plantigrade.workflows.synthesize import synthesize_task

RATE = 100.0
"""Frames per second of the recordings [Hz]."""
STAIRS_UP = (0.0, 0.15, 0.30, 0.45, 0.45, 0.45)
"""Height of the ground under each step of a walk up stairs [m]."""
STAIRS_DOWN = (0.0, -0.15, -0.30, -0.45, -0.45, -0.45)
"""The same down stairs [m]."""
_sloped = partial(WalkSettings, periodic=True, speed=1.2, strides=3)
GROUNDS: dict[str, tuple[WalkSettings, str | None]] = {
    "level, generated": (_sloped(), None),
    "slope 8° up": (_sloped(slope=float(np.deg2rad(8))), "slope:8"),
    "slope 8° down": (_sloped(slope=float(np.deg2rad(-8))), "slope:-8"),
    "steps 15 cm up": (WalkSettings(steps=6, heights=STAIRS_UP, speed=0.9), "steps:15"),
    "steps 15 cm down": (WalkSettings(steps=6, heights=STAIRS_DOWN, speed=0.9), "steps:15"),
}
"""The walk to generate, and the ground given to the fit; level ground for comparison."""


def on_ground(walk: WalkSettings, ground: str | None) -> ForceComparison:
    """Return the forces estimated for a generated walk against its own.

    Raises:
        ReproduceError: If they cannot be estimated.
    """
    true = synthesize_task(walk).record
    clock = true.motion.time
    time = np.arange(clock[0], clock[-1], 1 / RATE)
    qpos = interpolate(time, clock, true.motion.qpos)
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    made = TextbookWalk(true.human, time, qpos, (), walk.speed)
    recording = recorded(made, Path("walk.c3d"))
    trial = analyse(fit_recording(recording, FitSettings(ground=ground)))
    if trial.ground is None:
        raise ReproduceError(f"no forces on {ground}: {' '.join(trial.notes[-1:])}")
    return compare_forces(trial.record(), filtered(true))


def filtered(record: Record) -> Record:
    """Return a record with forces and moments low-passed like the measured forces of a walk."""
    time, force, moments = record.motion.time, record.contact_force, record.qfrc_actuator
    assert force is not None and moments is not None
    return replace(
        record,
        contact_force=lowpass(time, force, cutoff=CUTOFF),
        qfrc_actuator=lowpass(time, moments, cutoff=CUTOFF),
    )
