r"""The disturbance of a person besides the ground, estimated from how the centre of mass speeds up.

Newton's law for the whole body has one unknown force, if those of the ground are known:
:math:`f = m (\ddot c - g) - \sum F`. Robots notice so that they are touched: the observer of
momentum of [Haddadin2017]_.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import State


@dataclass(frozen=True, kw_only=True)
class DisturbanceSettings:
    """How samples of the disturbance are filtered."""

    median_samples: int = 5
    """Samples whose median is taken: a touchdown makes single ones wrong. Chosen."""
    deadband: float = 0.25
    """Acceleration below which there is no disturbance [m/s²]. Chosen."""


class DisturbanceEstimator:
    """Estimates the horizontal acceleration of a person by what pushes them.

    Attributes:
        acceleration: That acceleration now, world [m/s²].
    """

    def __init__(self, settings: DisturbanceSettings | None = None):
        self.settings = settings or DisturbanceSettings()
        self.acceleration = np.zeros(2)
        self._velocity: Array | None = None
        self._samples: deque[Array] = deque(maxlen=self.settings.median_samples)

    def update(
        self, body: State, ground: Float[Array, "n 3"], step: float, rotation: Float[Array, "2 2"]
    ) -> None:
        """Take another sample.

        Args:
            body: The person now.
            ground: Forces of the ground since the last sample [N].
            step: Time since then [s].
            rotation: From the axes of then to those of now.
        """
        velocity = body.com_velocity[:2].copy()
        if self._velocity is not None:
            gained = (velocity - rotation @ self._velocity) / step
            self._samples.append(gained - ground[:, :2].sum(axis=0) / body.mass)
            ordered, n = np.sort(self._samples, axis=0), len(self._samples)
            median = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])  # np.median takes its time
            size = max(float(np.linalg.norm(median)), 1e-9)
            self.acceleration = median * max(1.0 - self.settings.deadband / size, 0.0)
        self._velocity = velocity
