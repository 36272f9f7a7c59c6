"""Recordings, motions, records, filters and gait events."""

from plantigrade.motion.motion import Motion
from plantigrade.motion.record import Record
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
    "Record",
    "Recording",
    "SkeletonMotion",
    "Subject",
    "Table",
]
