"""A person as a linear pendulum: capture point, and how a disturbance moves it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.control.gait.support import inside
from plantigrade.kinematics.state import BodyState

MIN_PENDULUM_HEIGHT = 0.3  # [m] keeps the rate finite for bodies that have fallen


@dataclass(frozen=True, eq=False)
class PendulumState:
    """The state a plan starts from; positions over the ground."""

    com: Float[Array, " 2"]  #: Centre of mass [m]
    velocity: Float[Array, " 2"]  #: Its velocity [m/s]
    height: float  #: Height of the centre of mass above the ground [m]
    feet: Float[Array, "2 2"]  #: Middle of the sole of each foot, right first [m]
    pressure: Float[Array, "2 2"]  #: Best centre of pressure in each foot [m]
    heading: Float[Array, " 2"]  #: Direction in which the person faces
    #: Acceleration by forces other than the ground's [m/s²]
    disturbance: Float[Array, " 2"] = field(default_factory=lambda: np.zeros(2))

    @classmethod
    def of(
        cls,
        body: BodyState,
        ground: float,
        soles: Sequence[Float[Array, "_ 3"]],
        feet: Float[Array, "2 2"],
        heading: Float[Array, " 2"],
        margin: float,
        disturbance: Float[Array, " 2"] | None = None,
    ) -> "PendulumState":
        """Return a person as a pendulum.

        Args:
            ground: Height of the ground [m].
            soles: Points of each sole [m].
            feet: Middle of each sole, over the ground [m].
            heading: Direction in which the person faces.
            margin: Distance of pressure from the edge of a sole [m].
            disturbance: Acceleration by forces other than the ground's [m/s²].
        """
        com, velocity = body.com[:2], body.com_velocity[:2]
        height = max(float(body.com[2]) - ground, MIN_PENDULUM_HEIGHT)
        capture = com + velocity / np.sqrt(GRAVITY / height)
        pressure = [inside(own[:, :2], capture, margin) for own in soles]
        disturbance = np.zeros(2) if disturbance is None else disturbance
        return cls(com, velocity, height, feet, np.array(pressure), heading, disturbance)

    @property
    def omega(self) -> float:
        """Rate at which it diverges [1/s]."""
        return float(np.sqrt(GRAVITY / self.height))

    @property
    def capture_point(self) -> Float[Array, " 2"]:
        """Point over which it would come to rest without a disturbance [m]."""
        return self.com + self.velocity / self.omega

    @property
    def disturbance_shift(self) -> Float[Array, " 2"]:
        """Distance of pressure beyond the capture point that balances the disturbance [m]."""
        return self.disturbance / self.omega**2

    @property
    def left(self) -> Float[Array, " 2"]:
        """Direction to the left of the heading."""
        return np.array([-self.heading[1], self.heading[0]])

    def moved(
        self, pivot: Array, capture: Array, com: Array, time: float, disturbed: float
    ) -> tuple[Array, Array]:
        """Return capture point and centre of mass a time from now, about a centre of pressure.

        Args:
            pivot: The centre of pressure [m].
            capture: Capture point now [m].
            com: Centre of mass now [m].
            time: How far ahead [s].
            disturbed: Time for which the disturbance lasts [s].
        """
        during = min(max(disturbed, 0.0), time)
        for duration, shift in ((during, self.disturbance_shift), (time - during, np.zeros(2))):
            growth, centre = np.exp(self.omega * duration), pivot - shift
            # c' = omega (xi - c): the offset of c decays, and xi draws it along.
            com = centre + (com - centre) / growth
            com = com + 0.5 * (growth - 1 / growth) * (capture - centre)
            capture = centre + (capture - centre) * growth
        return capture, com

    def remaining_shift(self, disturbed: float) -> Float[Array, " 2"]:
        """Return the distance of a foot beyond the capture point for the rest of a disturbance."""
        return self.disturbance_shift * (1.0 - np.exp(-self.omega * max(disturbed, 0.0)))
