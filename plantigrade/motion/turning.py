"""Rotation of a recording about the vertical."""

from dataclasses import replace

import numpy as np

from plantigrade.motion.recording import Recording
from plantigrade.spatial.conventions import about_vertical


def turn(recording: Recording, angle: float) -> Recording:
    """Return the recording rotated about the vertical through the origin.

    Markers, skeleton and plates are rotated; coordinates and model outputs are not.

    Args:
        angle: Counter-clockwise seen from above [rad].
    """
    if angle == 0:
        return recording
    R = about_vertical(angle)
    if abs(angle / (np.pi / 2) - round(angle / (np.pi / 2))) < 1e-12:
        R = R.round()
    markers, skeleton = recording.markers, recording.skeleton
    if markers is not None:
        markers = replace(markers, positions=markers.positions @ R.T)
    if skeleton is not None:
        skeleton = replace(
            skeleton,
            positions=skeleton.positions @ R.T,
            ends=skeleton.ends @ R.T,
            rotations=R @ skeleton.rotations,
        )
    plates = tuple(
        replace(
            p,
            force=p.force @ R.T,
            cop=p.cop @ R.T,
            corners=None if p.corners is None else p.corners @ R.T,
        )
        for p in recording.plates
    )
    return replace(recording, markers=markers, skeleton=skeleton, plates=plates)


def quarter_turn_to_face_x(facing: float) -> float:
    """Return the multiple of a right angle that turns ``facing`` to within 45° of x [rad].

    Laboratories are aligned with their axes: a quarter turn keeps the path aligned and the forces
    comparable with those of the file.
    """
    return float(-np.round(facing / (np.pi / 2)) * np.pi / 2) + 0.0
