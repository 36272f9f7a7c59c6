"""Estimate of the disturbance of a standing body: what accelerates it besides the ground."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.world import State


@dataclass(frozen=True, kw_only=True)
class DisturbanceSettings:
    """Filter of the estimate."""

    n_samples: int = 3
    """Number of ticks of which the median counts: a touchdown spoils single ones. Chosen."""
    max_force_change: float = 0.15
    """Change of the ground force above which a tick is left out [body weights]. Chosen."""
    deadband: float = 0.7
    """Acceleration up to which there is no disturbance; full from twice that on [m/s²]. Chosen."""
    max_acceleration: float = 5.0
    """Saturation of the estimate [m/s²]. Chosen."""


class DisturbanceEstimator:
    r"""Estimates :math:`\ddot c - \sum F / m` over the ground from one tick to the next.

    Args:
        settings: Its filter.
    """

    def __init__(self, settings: DisturbanceSettings):
        self.settings = settings
        self._samples = np.zeros((settings.n_samples, 2))
        self._before: tuple[float, Array, Array] | None = None

    def update(self, state: State) -> None:
        """Take the sample of a tick."""
        velocity, force = state.body.com_velocity[:2], state.contact_force.sum(axis=0)[:2]
        if self._before is not None:
            time, velocity_before, force_before = self._before
            ground = 0.5 * (force + force_before) / state.body.mass
            sample = (velocity - velocity_before) / max(state.time - time, 1e-6) - ground
            change = float(np.linalg.norm(force - force_before))
            if change < self.settings.max_force_change * state.body.mass * GRAVITY:
                self._samples = np.vstack([self._samples[1:], sample])
        self._before = state.time, velocity, force

    @property
    def acceleration(self) -> Float[Array, " 2"]:
        """Estimated acceleration by forces other than the ground's [m/s²]."""
        s, estimate = self.settings, np.median(self._samples, axis=0)
        size = float(np.linalg.norm(estimate))
        if size <= s.deadband:
            return 0.0 * estimate
        return estimate * min(size / s.deadband - 1.0, 1.0, s.max_acceleration / size)
