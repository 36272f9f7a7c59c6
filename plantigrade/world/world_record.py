"""Conversion of recorded frames of a world to a Record."""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.record import Record
from plantigrade.record.moving_ground import MIN_MOVEMENT, MOVED, PLACE
from plantigrade.record.scene_objects import PLACES, object_signals
from plantigrade.world.recorder import Recorder
from plantigrade.world.simulated_world import SimulatedWorld


def record_of(world: SimulatedWorld, recorder: Recorder) -> Record:
    """Return the Record of the frames that a recorder kept.

    Signals: ``world.motor``, torques of the motors alone [N m]; ``world.push``, sum of pushes
    [N]; ``controller.NAME``, signals of the controller; ``things.*``, poses of scene objects.

    Raises:
        ParameterError: If no frame was recorded.
    """
    until = np.inf if world.fall is None else world.fall.time
    external = recorder.external_forces()
    motion = recorder.motion(external, until)
    n, nv = motion.n_frames, world.human.model.nv
    tau = np.zeros((n, nv))
    tau[:, 6:] = recorder.rows["tau"]
    signals: dict[str, Array] = {"world.motor": np.array(recorder.rows["motor"])}
    pushes = np.zeros((n, 3))
    for i, frame in enumerate(recorder.pushes(external)):
        pushes[i] = np.sum([force for _, force, _ in frame], axis=0) if frame else 0.0
    if pushes.any():
        signals["world.push"] = pushes
    signals |= recorder.signal_arrays()
    if PLACES in signals:
        signals |= object_signals(
            [d.scene_object for d in world.disturbances if d.scene_object is not None]
        )
    notes = [] if world.fall is None else [f"The person {world.fall}."]
    if world.diverged is not None:
        notes.append(
            f"The simulation diverged at {world.diverged:.2f} s; the frames before are kept."
        )
    if np.abs(signals.get(PLACE, 0.0)).max() > MIN_MOVEMENT:
        notes.append(MOVED)
    return Record(
        world.human,
        motion,
        qfrc_actuator=tau,
        **recorder.contacts(external),
        ground=world.ground,
        signals=signals,
        notes=tuple(notes),
    )
