"""Walking with a lowered head: trunk leant forward, knees bent."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.person import leg_length
from plantigrade.control.gait.swing_foot import SwingSettings
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.world import Barrier, SimulatedWorld


@dataclass(frozen=True, kw_only=True)
class CrouchSettings:
    """How deep a person crouches, with which joints, and where."""

    max_depth_cm: float = 30.0
    """Greatest lowering of the head [cm]. Chosen (±20 %: below 2 %)."""
    leg_share: float = 0.3
    """Part of the depth that bent legs take; the trunk takes the rest by leaning. Chosen (±20 %:
    deviation 2 %)."""
    neck_share: float = 0.5
    """Part of the lean that the neck takes back: the eyes look ahead. Chosen (±20 %: below 2 %)."""
    speed: float = 0.25
    """Speed at which the head is lowered and raised [m/s]. Chosen (±20 %: below 2 %)."""
    barrier_clearance: float = SwingSettings.clearance
    """Height of a barrier above the head that passes under it [leg lengths]; as of feet above the
    ground."""
    barrier_distance: float = 0.6
    """Distance before and behind a barrier over which the head stays low [m]. Chosen (±20 %:
    below 2 %)."""

    def barriers(self, world: SimulatedWorld) -> list[tuple[float, float]]:
        """Return how far ahead barriers of a world are [m], and the depth under them [cm]."""
        found = []
        tall = world.human.height + self.barrier_clearance * leg_length(world.human)
        for each in world.disturbances:
            if isinstance(each, Barrier):
                depth = 100.0 * (tall - each.height)
                if depth > self.max_depth_cm:
                    raise ParameterError(
                        f"a barrier at {each.height:.2f} m is too low to walk under: somebody of "
                        f"{world.human.height:.2f} m stoops by {self.max_depth_cm:g} cm at most, "
                        f"which needs {tall - 0.01 * self.max_depth_cm:.2f} m"
                    )
                found.append((each.ahead, max(depth, 0.0)))
        return found


@dataclass(frozen=True, eq=False)
class Crouch:
    """A crouched posture, relative to the recorded one."""

    lowering: float  #: Lowering of the centre of mass [m]
    angles: Float[Array, " n_hinges"]  #: Added to the hinges [rad]

    def scaled(self, part: float) -> "Crouch":
        """Return a part of it."""
        return Crouch(part * self.lowering, part * self.angles)

    @classmethod
    def of(cls, human: Human, settings: CrouchSettings) -> "Crouch":
        """Return the deepest crouch of a person."""
        depth, share = 0.01 * settings.max_depth_cm, settings.leg_share
        names, angles = human.coordinates, np.zeros(len(human.coordinates))
        upright = BodyState(human, human.standing())
        trunk_height = human.height - float(upright.origin(human.trunk)[2])
        lean = float(np.arccos(max(1.0 - (1.0 - share) * depth / trunk_height, 0.0)))
        spine = [n for n in ("lumbar_extension", "thorax_extension") if n in names]
        for name in spine:
            angles[names.index(name)] = -lean / len(spine)
        angles[names.index("neck_extension")] = settings.neck_share * lean
        leant = np.array(human.standing())
        leant[7:] += angles
        lowering = float(upright.com[2] - upright.moved_to(leant).com[2])
        bend = float(np.arccos(1.0 - share * depth / leg_length(human)))  # of hips and ankles
        for side in SIDES:
            for name, part in (("hip_flexion", 1.0), ("knee_angle", 2.0), ("ankle_angle", 1.0)):
                angles[names.index(f"{name}_{side}")] += part * bend
        return cls(share * depth + max(lowering, 0.0), angles)


class CrouchControl:
    """Crouches to a desired depth, and under barriers.

    Attributes:
        barriers: How far ahead barriers are [m], and the depth under each [cm].
        crouch: The posture now; None where it is as recorded.

    Raises:
        ParameterError: If a barrier is too low.
    """

    def __init__(self, human: Human, world: SimulatedWorld, settings: CrouchSettings):
        self.settings, self.barriers = settings, settings.barriers(world)
        self._deepest, self._depth = Crouch.of(human, settings), 0.0
        self._greatest = 0.01 * max((depth for _, depth in self.barriers), default=0.0)
        self.crouch: Crouch | None = None

    def depth_under_barriers(self, x: float, speed: float) -> float:
        """Return how deep to crouch at a place [cm].

        Args:
            x: How far ahead that is [m].
            speed: Speed of the walk [m/s].
        """
        behind = self.settings.barrier_distance
        before = behind + speed * self._greatest / self.settings.speed
        return max((d for at, d in self.barriers if at - before < x < at + behind), default=0.0)

    def update(self, depth_cm: float, step: float) -> Crouch | None:
        """Advance towards a depth [cm] by a time step [s]; return the posture then."""
        desired = 0.01 * depth_cm
        if desired != self._depth:
            change = self.settings.speed * step
            self._depth += min(max(desired - self._depth, -change), change)
            part = 100.0 * self._depth / self.settings.max_depth_cm
            self.crouch = self._deepest.scaled(part) if self._depth > 0.0 else None
        return self.crouch
