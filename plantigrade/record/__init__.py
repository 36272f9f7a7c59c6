"""Record, what happened; Run, the folder that keeps it."""

from plantigrade.record.record import Record

__all__ = ["Record"]
