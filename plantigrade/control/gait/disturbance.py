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

MEDIAN_NOISE = 0.55  # of the median of five differences of white noise, by the noise: from samples


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
    n_noisy_samples: int = 20
    """Number of ticks whose mean counts where velocities are noisy, and of which their noise is
    estimated. Chosen: 0.1 s, half of the push that people took."""
    noise_margin: float = 4.0
    """Least deadband by the standard deviation that noise gives the estimate. Without it, a walk
    whose joint angles were known to 0.05° felt a push for 98 % of the time, and crouched; with
    0.2°, a walk feels one for 67 % of the time with 3, for 42 % with 4."""


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
        longest = max(settings.n_samples, settings.n_noisy_samples)
        self._samples: deque[Array] = deque([np.zeros(2)] * settings.n_samples, longest)
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
        samples = np.array(self._samples)
        estimate, noise = _median(samples[-s.n_samples :]), _noise(samples)
        deadband = s.noise_margin * MEDIAN_NOISE * noise
        if deadband > s.deadband:  # a mean of more ticks is late, but knows more
            estimate = samples.mean(axis=0)
            deadband = s.noise_margin * np.sqrt(2.0) / len(samples) * noise
        size = float(np.linalg.norm(estimate))
        deadband = max(deadband, s.deadband)
        self.acceleration = estimate * min(max(size / deadband - 1.0, 0.0), 1.0)


def _median(samples: Array) -> Array:
    """Return the median along the first axis; faster than ``np.median``."""
    ordered, n = np.sort(samples, axis=0), len(samples)
    return np.asarray(0.5 * (ordered[(n - 1) // 2] + ordered[n // 2]))


def _noise(samples: Float[Array, "n 2"]) -> float:
    """Return the noise of the velocities over the time of a tick, standard deviation [m/s²].

    White noise is all that changes the acceleration between two ticks, in most of them. The median
    of the size of a normal variable is 0.67 of its standard deviation, and that of a second
    difference is the root of 6 times as large as that of what is differentiated.
    """
    return float(_median(np.abs(np.diff(samples, axis=0)).ravel())) / (0.6745 * np.sqrt(6.0))
