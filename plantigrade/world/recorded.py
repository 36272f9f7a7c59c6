"""The Record of a world."""

from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array
from plantigrade.notes import Info
from plantigrade.record import Record
from plantigrade.record.moving_ground import MOVED, PLACE
from plantigrade.record.things import PLACES, described
from plantigrade.world.recorder import Recorder

if TYPE_CHECKING:
    import plantigrade.world.world


def record_of(world: "plantigrade.world.world.World", recorder: Recorder) -> Record:
    """Return what a recorder kept of a world.

    Signals: ``world.motor`` the torques of the motors alone [N m], ``world.push`` the sum of pushes
    [N], what the controller said, as ``controller.NAME``, and where things were, ``things.*``.

    Raises:
        ParameterError: If nothing was kept.
    """
    until = np.inf if world.fall is None else world.fall.time
    touch = recorder.touch()
    motion = recorder.motion(touch, until)
    n, nv = motion.n_frames, world.human.model.nv
    tau = np.zeros((n, nv))
    tau[:, 6:] = recorder.rows["tau"]
    signals: dict[str, Array] = {"world.motor": np.array(recorder.rows["motor"])}
    pushes = np.zeros((n, 3))
    for i, frame in enumerate(recorder.pushes(touch)):
        pushes[i] = np.sum([force for _, force, _ in frame], axis=0) if frame else 0.0
    if pushes.any():
        signals["world.push"] = pushes
    signals |= recorder.kept_signals()
    if PLACES in signals:
        signals |= described([d.thing for d in world.disturbances if d.thing is not None])
    notes = [] if world.fall is None else [f"The person {world.fall}."]
    if world.diverged is not None:
        notes.append(
            f"The simulation diverged at {world.diverged:.2f} s; what came before is kept."
        )
    if np.abs(signals.get(PLACE, 0.0)).max() > MOVED:
        notes.append(
            Info(
                "The ground moved (signal ground.place: shift [m] and tilt [rad]). The viewer and "
                "the checker follow it; the drawings in the report show it at rest."
            )
        )
    return Record(
        world.human,
        motion,
        qfrc_actuator=tau,
        **recorder.contacts(touch),
        ground=world.ground,
        signals=signals,
        notes=tuple(notes),
    )
