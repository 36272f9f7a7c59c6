"""The Human: anatomy, anthropometry, feet, joint sets, landmarks and marker sets."""

from plantigrade.models.anthropometry import Dimensions
from plantigrade.models.feet import FEET
from plantigrade.models.human import Human
from plantigrade.models.joint_sets import JOINT_SETS
from plantigrade.models.person import Person

__all__ = ["FEET", "JOINT_SETS", "Dimensions", "Human", "Person"]
