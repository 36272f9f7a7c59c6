r"""Estimate of a disturbance: the acceleration of the body by forces besides the ground's.

Newton's law for the whole body has one unknown force where those of the ground are known,
:math:`f = m (\ddot c - g) - \sum F`, as in the momentum observers of robots [Haddadin2017]_.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.kinematics.state import BodyState


@dataclass(frozen=True, kw_only=True)
class DisturbanceSettings:
    """Filter of the estimate."""

    n_samples: int = 5
    """Number of ticks whose median counts; a touchdown spoils single ones. Chosen (±20 %: deviation
    15 %)."""
    max_force_change: float = 1.0
    """Change of the ground force above which a tick is left out [body weights]. Chosen: of a walk
    it changes at every tick."""
    deadband: float = 0.25
    """Acceleration up to which there is no disturbance; full from twice that on [m/s²]. Chosen (±20
    %: deviation 12 %)."""


class DisturbanceEstimator:
    r"""Estimates :math:`\ddot c - \sum F / m` over the ground from one tick to the next.

    Args:
        held: Whether the ground force holds during a tick, as torques do; with springs and dampers
            it changes from one tick to the next.

    Attributes:
        acceleration: Estimated acceleration by forces other than the ground's [m/s²].
    """

    def __init__(self, settings: DisturbanceSettings, *, held: bool = False):
        self.settings, self._held, self.acceleration = settings, held, np.zeros(2)
        self._samples: deque[Array] = deque([np.zeros(2)] * settings.n_samples, settings.n_samples)
        self._before: tuple[Array, Array] | None = None

    def update(
        self,
        body: BodyState,
        ground: Float[Array, "n 3"],
        step: float,
        rotation: Float[Array, "2 2"] | None = None,
    ) -> None:
        """Take the sample of a tick.

        Args:
            ground: Forces of the ground now [N].
            step: Time since the last sample [s].
            rotation: From the axes of then to those of now, where they turn.
        """
        s, velocity, force = self.settings, body.com_velocity[:2].copy(), ground[:, :2].sum(axis=0)
        if self._before is not None:
            before, force_before = self._before
            if rotation is not None:
                before, force_before = rotation @ before, rotation @ force_before
            if np.linalg.norm(force - force_before) < s.max_force_change * body.mass * GRAVITY:
                mean = force if self._held else 0.5 * (force + force_before)
                self._samples.append((velocity - before) / step - mean / body.mass)
        self._before = velocity, force
        ordered, n = np.sort(self._samples, axis=0), s.n_samples
        median = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])  # faster than np.median
        size = float(np.linalg.norm(median))
        self.acceleration = median * min(max(size / s.deadband - 1.0, 0.0), 1.0)
