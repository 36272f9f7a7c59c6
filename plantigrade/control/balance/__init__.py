"""Balance: centre of mass, contact forces and torques in one program at every tick."""

from plantigrade.control.balance.controller import Balance
from plantigrade.control.balance.feasible import feasible_motion
from plantigrade.control.balance.hybrid import Hybrid, HybridSettings
from plantigrade.control.balance.recovery import RecoverySettings
from plantigrade.control.balance.reference import (
    MotionReference,
    Reference,
    ReferenceState,
    posture_reference,
)
from plantigrade.control.balance.script import MOTIONS, ScriptSettings, script_named
from plantigrade.control.balance.script_motion import scripted
from plantigrade.control.balance.settings import BalanceSettings

__all__ = [
    "MOTIONS",
    "Balance",
    "BalanceSettings",
    "Hybrid",
    "HybridSettings",
    "MotionReference",
    "RecoverySettings",
    "Reference",
    "ReferenceState",
    "ScriptSettings",
    "feasible_motion",
    "posture_reference",
    "script_named",
    "scripted",
]
