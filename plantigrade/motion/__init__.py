"""Recordings, motions, filters and gait events."""

from plantigrade.motion.motion import Motion
from plantigrade.motion.recording import (
    ForcePlate,
    GaitEvent,
    Markers,
    Recording,
    SkeletonMotion,
    Subject,
    Table,
)

__all__ = [
    "ForcePlate",
    "GaitEvent",
    "Markers",
    "Motion",
    "Recording",
    "SkeletonMotion",
    "Subject",
    "Table",
]
