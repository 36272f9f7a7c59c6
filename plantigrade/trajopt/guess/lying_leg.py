"""A leg that lies on its heel, the foot at right angles to the shank, in the sagittal plane."""

from dataclasses import dataclass

import numpy as np

from plantigrade.contact.limb_sites import HEEL_PART, limb_site
from plantigrade.models import Human

KNEES = np.linspace(0.0, 2.4, 200)  # [rad] flexions of the knee between which one is sought


@dataclass(frozen=True)
class LyingLeg:
    """The leg of a person whose hip is at a height above the floor."""

    human: Human
    hip: float  #: Height of the hip above the floor [m]

    def reach(self, knee: float) -> float:
        """Return how far ahead of the hip the heel is, at a flexion of the knee [m, rad]."""
        return self._line(knee)[0]

    def knee(self, reach: float) -> float:
        """Return the knee flexion that places the heel at a distance ahead of the hip.

        Args:
            reach: Distance [m].

        Returns:
            Flexion [rad], of those between the first and the last of :data:`KNEES`.
        """
        ahead = [self.reach(float(k)) for k in KNEES]
        return float(np.interp(-reach, -np.array(ahead), KNEES))

    def angles(self, knee: float, tilt: float) -> dict[str, float]:
        """Return the angles of the leg by name, without side [rad].

        Args:
            knee: Flexion of the knee [rad].
            tilt: Posterior tilt of the pelvis [rad].
        """
        flexion = self._line(knee)[1] - tilt
        return {
            "knee_angle": knee,
            "hip_flexion": flexion,
            "ankle_angle": 0.0,
            "subtalar_angle": 0.0,
        }

    def _line(self, knee: float) -> tuple[float, float]:
        """Return how far ahead the heel is [m], and how far the thigh is off the vertical [rad]."""
        d, heel = self.human.dimensions, limb_site(self.human, f"{HEEL_PART}_r")
        ahead, _, up = heel.position
        below, above = d.shank - up, self.hip - heel.radius
        # from the hip in axes of the thigh
        x = ahead * np.cos(knee) - below * np.sin(knee)
        z = -d.thigh - below * np.cos(knee) - ahead * np.sin(knee)
        length = float(np.hypot(x, z))
        turned = np.arccos(above / length) - np.arctan2(x, -z)
        return float(np.sqrt(length**2 - above**2)), float(turned)
