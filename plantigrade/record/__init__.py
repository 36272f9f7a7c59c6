"""Records of motions with their forces, and runs, the folders that store them."""

from plantigrade.record.conditions import Condition
from plantigrade.record.provenance import Provenance
from plantigrade.record.record import FootForce, Limits, Record
from plantigrade.record.run import Run

__all__ = ["Condition", "FootForce", "Limits", "Provenance", "Record", "Run"]
