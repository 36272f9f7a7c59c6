"""How a body is held while it walks: lowered, with another posture of trunk and arms."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.world import Barrier, World

KNEES = 0.3
"""Part of a stoop that legs take, by bending; the trunk takes the rest, by leaning forward."""
LOOKS = 0.5
"""The neck takes back this part of the lean: who stoops looks ahead."""
DEEPEST = 30.0
"""Deepest stoop [cm]."""


SPARE = 0.06
"""Who passes under a barrier keeps the head so far below it [m]."""


def barriers_of(world: World) -> list[tuple[float, float]]:
    """Return how far ahead barriers of a world are [m], and how deep to stoop under them [cm].

    Raises:
        ParameterError: If one is too low.
    """
    found = []
    for each in world.disturbances:
        if isinstance(each, Barrier):
            deep = 100.0 * (world.human.height + SPARE - each.height)
            if deep > DEEPEST:
                raise ParameterError(
                    f"a barrier at {each.height:.2f} m is too low to walk under: somebody of "
                    f"{world.human.height:.2f} m stoops by {DEEPEST:g} cm at most, which needs "
                    f"{world.human.height + SPARE - 0.01 * DEEPEST:.2f} m"
                )
            found.append((each.ahead, max(deep, 0.0)))
    return found


@dataclass(frozen=True, eq=False)
class Manner:
    """What is otherwise than recorded.

    Attributes:
        lowered: How much lower the centre of mass is [m].
        angles: What is added to the hinges [rad].
    """

    lowered: float
    angles: Float[Array, " n_hinges"]


def stoop(human: Human, depth: float) -> Manner:
    """Return how somebody stoops.

    Args:
        human: The person.
        depth: How much lower the top of the head is [m].
    """
    names, angles = human.coordinates, np.zeros(len(human.coordinates))
    stands = State(human, human.standing())
    low = float(stands.origin(human.trunk)[2])
    above = human.height - low
    lean = float(np.arccos(max(1.0 - (1.0 - KNEES) * depth / above, 0.0)))
    spine = [n for n in ("lumbar_extension", "thorax_extension") if n in names]
    for name in spine:
        angles[names.index(name)] = -lean / len(spine)
    angles[names.index("neck_extension")] = LOOKS * lean
    bowed = np.array(human.standing())
    bowed[7:] += angles
    down = float(stands.com[2] - stands.moved_to(bowed).com[2])
    hip, ankle = (stands.moved_to(human.standing()).origin(b)[2] for b in ("femur_r", "foot_r"))
    bend = float(np.arccos(1.0 - KNEES * depth / (hip - ankle)))  # of hips and ankles
    for side in SIDES:
        for name, much in (("hip_flexion", 1.0), ("knee_angle", 2.0), ("ankle_angle", 1.0)):
            angles[names.index(f"{name}_{side}")] += much * bend
    return Manner(KNEES * depth + max(down, 0.0), angles)
