"""What does not take a Recording by itself, put into the shape the table of formats wants."""

from pathlib import Path

from plantigrade.errors import FileError
from plantigrade.io import bvh, npz
from plantigrade.motion.recording import Recording, Table


def write_bvh(recording: Recording, path: str | Path) -> None:
    """Write the skeleton of a recording as BVH.

    Raises:
        FileError: If there is no skeleton, or the file cannot be written.
    """
    if recording.skeleton is None:
        raise FileError(path, "the recording has no skeleton", remedy="write its markers to .trc")
    bvh.write_bvh(recording.skeleton, path)


def read_npz(path: str | Path) -> Recording:
    """Read what a ``motion.npz`` of a run shares with a recording.

    Recorded markers, gait events, and the angles of the joints [rad]; where the pelvis is needs the
    body beside it (:func:`plantigrade.io.run_folder.read_run`).

    Raises:
        FileError: If the file is no such motion.
    """
    record = npz.read_npz(path)
    motion = record.motion
    n_angles = motion.qpos.shape[1] - 7  # the root has a position and a quaternion
    names = motion.joint_names[1:]
    coordinates = None
    if n_angles == len(names) > 0:
        coordinates = Table(tuple(names), motion.time, motion.qpos[:, 7:])
    return Recording(
        source=Path(path),
        markers=record.recorded_markers,
        coordinates=coordinates,
        events=motion.events,
        warnings=(
            *record.warnings,
            "the place of the pelvis is left out; open the run's folder to have it",
        ),
    )
