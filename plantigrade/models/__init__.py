"""The Human: anatomy, anthropometry, feet, joint sets, landmarks and marker sets.

Names are loaded on first use, so that settings do not import NumPy.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from plantigrade.models.person import Person

if TYPE_CHECKING:
    from plantigrade.models.anthropometry import Dimensions
    from plantigrade.models.feet import FEET
    from plantigrade.models.human import Human
    from plantigrade.models.joint_sets import JOINT_SETS

__all__ = ["FEET", "JOINT_SETS", "Dimensions", "Human", "Person"]

_HOMES = {
    "FEET": "feet",
    "JOINT_SETS": "joint_sets",
    "Dimensions": "anthropometry",
    "Human": "human",
}


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
