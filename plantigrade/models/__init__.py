"""The Human: anatomy, anthropometry, feet, joint sets, landmarks and marker sets.

Names are loaded on first use, so that settings do not import NumPy.
"""

from typing import TYPE_CHECKING

from plantigrade.lazy import lazy
from plantigrade.models.person import Person

if TYPE_CHECKING:
    from plantigrade.models.anthropometry import Dimensions
    from plantigrade.models.feet import FEET
    from plantigrade.models.human import Human
    from plantigrade.models.joint_sets import JOINT_SETS

__all__ = ["FEET", "JOINT_SETS", "Dimensions", "Human", "Person"]

__getattr__ = lazy(__name__)
