"""Record, what happened; Run, the folder that keeps it."""

from plantigrade.record.conditions import Condition
from plantigrade.record.provenance import Provenance
from plantigrade.record.record import FootForce, Limits, Record
from plantigrade.record.run import Run

__all__ = ["Condition", "FootForce", "Limits", "Provenance", "Record", "Run"]
