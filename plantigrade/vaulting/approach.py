"""The approach of a gymnast: velocity, rotation and posture at hand contact."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from plantigrade.bounds import Bounded
from plantigrade.options import Degrees

if TYPE_CHECKING:
    from plantigrade.arrays import Array, Float

APPROACH_FIELDS = (
    "speed",
    "rise",
    "somersault",
    "trunk",
    "shoulder",
    "elbow",
    "hip",
    "knee",
    "ankle",
)
"""Fields of an approach."""


@dataclass(frozen=True, kw_only=True)
class Approach(Bounded):
    """State of the body at touchdown, with joints at rest.

    The defaults are round numbers typical of handspring vaults of elite men ([Takei1988]_,
    [Irwin2009]_); the elbow angle is the report's.

    Raises:
        ParameterError: If a value is out of range.
    """

    activity = "an approach"
    ranges = {
        "speed": (0.5, 9.0, "m/s"),
        "rise": (-3.0, 5.0, "m/s"),
        "somersault": (0.0, 1200.0, "degrees"),
        "trunk": (-30.0, 100.0, "degrees"),
        "shoulder": (60.0, 185.0, "degrees"),
        "elbow": (60.0, 180.0, "degrees"),
        "hip": (60.0, 210.0, "degrees"),
        "knee": (60.0, 180.0, "degrees"),
        "ankle": (80.0, 145.0, "degrees"),
    }

    speed: float = 5.0
    """Forward velocity of the centre of mass at hand contact [m/s]."""
    rise: float = 2.4
    """Upward velocity of the centre of mass at hand contact [m/s]."""
    somersault: Degrees = math.radians(400.0)
    """Forward angular velocity of the whole body [deg/s]."""
    trunk: Degrees = math.radians(22.0)
    """Angle of the trunk above the horizontal [deg]; 90 is a handstand."""
    shoulder: Degrees = math.radians(155.0)
    """Shoulder angle [deg]; 180 is overhead."""
    elbow: Degrees = 2.98
    """Elbow angle [deg]; 180 is straight, 171 in the report."""
    hip: Degrees = math.radians(190.0)
    """Hip angle [deg]; above 180 is arched."""
    knee: Degrees = math.radians(171.0)
    """Knee angle [deg]; 180 is straight."""
    ankle: Degrees = math.radians(135.0)
    """Ankle angle between shank and sole [deg]; 90 in standing."""

    @property
    def posture(self) -> "Float[Array, ' 6']":
        """Tilt of the pelvis and the five joints, in the Human's coordinates [rad]."""
        import numpy as np

        pi = np.pi
        return np.array(
            [
                -(self.trunk + pi / 2),
                self.shoulder,
                pi - self.elbow,
                pi - self.hip,
                pi - self.knee,
                pi / 2 - self.ankle,
            ]
        )
