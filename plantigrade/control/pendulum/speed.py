"""The speed of a walk, by the length of its steps."""

from dataclasses import dataclass

from plantigrade.control.gait.loads import LoadSettings
from plantigrade.control.gait.phase import GaitPhaseSettings


@dataclass(frozen=True, kw_only=True)
class SpeedSettings:
    """How the speed of a walk is changed and corrected."""

    max_step_scale: float = 1.3
    """Longest steps, and with it the greatest correction [recorded steps]. Chosen (±20 %:
    deviation 14 %)."""
    acceleration: float = 0.5
    """Change of the desired speed [m/s²]. Chosen (±20 %: deviation 16 %)."""
    stride_time: float = LoadSettings.min_rest_time
    """About the time of a stride: time constant of mean values, least time in which one walk turns
    into another, and half the time after a change of speed from which the mean speed is corrected
    [s]. Chosen (±20 %: below 2 %)."""
    weight_shift_time: float = LoadSettings.min_rest_time
    """Time from the last step to quiet standing, and greatest time in which the weight is shifted
    to the first stance foot [s]: with it a foot is at rest."""
    correction_rate: float = GaitPhaseSettings.return_rate
    """Rate at which an error of the mean speed is corrected [1/s]; as of the path."""
    min_corrected_scale: float = 0.35
    """Shortest steps whose speed is corrected, and longest ones after which a walk may stop
    [recorded steps]. Chosen (±20 %: deviation 17 %)."""
    step_widening: float = 0.6
    """Widening of steps by their shortening: feet are no longer ahead of each other. Chosen (±20 %:
    below 2 %)."""
    lift_reduction: float = 0.5
    """Reduction of the height of swing feet by the shortening of steps. Chosen (±20 %: deviation 3
    %)."""
    turn_overspeed: float = 2.0
    """Speed, by that which the turn to the path allows, above which the walk goes straight on: it
    would turn on a wide bend off the path. Chosen (±20 %: below 2 %)."""

    def transition_time(self, change: float) -> float:
        """Return the time in which a walk turns into one of another mean speed [s].

        Args:
            change: Change of the mean speed [m/s].
        """
        return max(self.stride_time, abs(change) / self.acceleration)


class SpeedControl:
    """Adapts the length of steps to a desired speed.

    Args:
        scale: Length of the first steps [recorded steps].
        speed: Mean speed at the start [m/s].
        position: Along the line of the walk [m].

    Attributes:
        scale: Length of steps by the desired speed, without correction [recorded steps].
        mean: Mean speed, over a stride [m/s].
    """

    def __init__(self, settings: SpeedSettings, scale: float, speed: float, position: float):
        self.settings, self.scale, self.mean = settings, scale, speed
        self._position, self._correction, self._steady = position, 0.0, 0.0

    def update(
        self, desired: float, recorded: float, position: float, step: float, *, displaced: bool
    ) -> float:
        """Advance by a time step; return the length of steps [recorded steps].

        Args:
            desired: Desired speed [m/s].
            recorded: Speed with recorded steps [m/s].
            position: Along the line of the walk [m].
            step: The time step [s].
            displaced: Whether the walk is where a push has left it. Its speed is no error of the
                walk then: corrected, it was 1.3 times as fast for seconds after a push back.
        """
        own = self.settings
        self.mean += step / own.stride_time * ((position - self._position) / step - self.mean)
        self._position = position
        goal = min(desired / recorded, own.max_step_scale)
        change = own.acceleration / recorded * step
        self.scale += min(max(goal - self.scale, -change), change)
        self._steady = self._steady + step if self.scale == goal and not displaced else 0.0
        if self._steady > 2.0 * own.stride_time and goal > own.min_corrected_scale:
            self._correction += step * own.correction_rate * (desired - self.mean) / recorded
            most = own.max_step_scale - 1.0
            self._correction = min(max(self._correction, -most), most)
        correction = self._correction * min(self.scale / own.min_corrected_scale, 1.0)
        return min(self.scale + correction, own.max_step_scale)
