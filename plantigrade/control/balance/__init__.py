"""Balance: momentum, contact forces and torques in one program at every tick."""

from plantigrade.control.balance.carried import Carried, held
from plantigrade.control.balance.controller import Balance
from plantigrade.control.balance.feasible import feasible_motion
from plantigrade.control.balance.hybrid import Hybrid, HybridWeights
from plantigrade.control.balance.reference import Followed, Held, Reference, Wanted
from plantigrade.control.balance.script import MOTIONS, script_named
from plantigrade.control.balance.script_motion import scripted
from plantigrade.control.balance.weights import Weights

__all__ = [
    "MOTIONS",
    "Balance",
    "Carried",
    "Followed",
    "Held",
    "Hybrid",
    "HybridWeights",
    "Reference",
    "Wanted",
    "Weights",
    "feasible_motion",
    "held",
    "script_named",
    "scripted",
]
