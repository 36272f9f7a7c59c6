"""Balance: momentum, contact forces and torques in one program at every tick."""

from plantigrade.control.balance.controller import Balance
from plantigrade.control.balance.hybrid import Hybrid, HybridWeights
from plantigrade.control.balance.reference import Followed, Held, Reference, Wanted
from plantigrade.control.balance.weights import Weights

__all__ = [
    "Balance",
    "Followed",
    "Held",
    "Hybrid",
    "HybridWeights",
    "Reference",
    "Wanted",
    "Weights",
]
