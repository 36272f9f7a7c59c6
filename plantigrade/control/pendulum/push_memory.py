"""What a walk knows of the last push, and how it returns to its path."""

from dataclasses import dataclass
from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float


@dataclass(frozen=True, kw_only=True)
class PushSettings:
    """How a walk recognises a push and returns from it; values were chosen."""

    min_speed: float = 0.08
    """Least change of speed by which a disturbance is a push [m/s]; a fifth of that by which people
    were pushed. Landings of a walk with legs half as long are felt, too, and change it by up to
    0.07; taken for pushes, they let that walk fall."""
    memory: float = 0.3
    """Time constant with which a felt change of speed is forgotten [s]; about that of the
    pendulum."""
    recovery_time: float = 1.0
    """Time after the last felt push in which recovery steps lower the body, land no farther than
    the swing foot comes in time, and soon unload the rear foot [s]. On tiles, recovery steps
    correct errors of some centimetres; with either of the first two, a walk over tiles fell."""
    max_path_error: float = 0.4
    """Greatest offset from the reference that is countered [leg lengths]: along the path, what is
    lost beyond it stays lost."""
    max_lasting_offset: float = 0.1
    """Offset from the reference up to which its integral is countered after a push [leg lengths].
    The integral of more led the walk past its path by half a metre, and ahead at 1.3 times its
    speed for seconds."""
    max_return_time: float = 6.0
    """Time from the beginning of the last push after which the integral of a larger offset is
    countered again, across the path [s]: within it, all who stayed on their feet in ``experiment
    push-map`` were back. Without it, steady side wind of 50 N blew a walk 3.4 m off its path in 15
    s, now 2.6 m. Along the path, where place and speed are corrected, it let a tour with punches
    end in a fall."""


class PushMemory:
    """What a walk knows of the last push.

    Args:
        leg: Length of the leg [m].
        step: Time from one tick to the next [s].
        return_rate: Rate at which a lasting offset is countered [1/s].
        stride_time: Time constant with which the line of a walk that turns goes along [s].

    Attributes:
        line: Offset of the line of the walk, ahead and to the left, that it keeps, world [m].
    """

    def __init__(
        self,
        leg: float,
        step: float,
        return_rate: float,
        stride_time: float,
        settings: PushSettings,
    ):
        self.settings, self.line = settings, np.zeros(2)
        self._leg, self._step, self._rate = leg, step, return_rate
        self._stride_time = stride_time
        self._change = 0.0  # [m/s] of speed, by what was felt lately
        self._since = np.inf  # [s] time since a push was last felt
        self._displaced = np.zeros(2, dtype=bool)  # by a push, along the path and across it
        self._aside_time = 0.0  # [s] across it, since the beginning of the last push
        self._correction = np.zeros(2)  # [m] by the integral of the offset

    @property
    def felt(self) -> bool:
        """Whether a push was felt not long ago."""
        return self._since < self.settings.recovery_time

    @property
    def displaced(self) -> bool:
        """Whether the walk is where a push has left it, off its path or behind or ahead on it."""
        return bool(self._returning.any())

    @property
    def recovering(self) -> bool:
        """Whether a push was felt not long ago, or the walk is still where it has left it."""
        return self.felt or self.displaced

    @property
    def _returning(self) -> Array:
        """Along the path and across it, whether the walk comes back from a push by itself."""
        return self._displaced & [True, self._aside_time < self.settings.max_return_time]

    def feel(self, disturbance: Float[Array, " 2"]) -> None:
        """Take the acceleration by a disturbance during a tick [m/s²]."""
        own, size = self.settings, hypot(*disturbance)
        self._change += self._step * (size - self._change / own.memory)
        felt = size > 0.0 and (self.felt or self._change > own.min_speed)
        if felt and not self.felt:
            self._aside_time = 0.0
        self._since = 0.0 if felt else self._since + self._step

    def path_offset(self, offset: Float[Array, " 2"], turns: bool) -> Float[Array, " 2"]:
        """Return the offset from the reference that feet return to [m].

        A recording is no walk of this body, which would stay off its path: a lasting offset is
        countered by its integral. That of an offset which a push left would lead the walk past its
        path by as much on the other side. Sideways in a turn, and along the path beyond a limit,
        the walk does not return.

        Args:
            offset: Load-weighted offset of the stance feet from the reference [m].
            turns: Whether the walk turns.
        """
        own = self.settings
        away, far = offset - self.line, own.max_path_error * self._leg
        small = np.abs(away) < own.max_lasting_offset * self._leg
        self._displaced = (self._displaced | self.felt) & ~small
        self._aside_time = self._aside_time + self._step if self._displaced[1] else 0.0
        near = np.minimum(np.maximum(away, -far), far)
        self.line[0] += away[0] - near[0]
        if turns:
            self.line[1] += self._step / self._stride_time * away[1]
        lasting = np.where(self._returning, 0.0, near)
        self._correction -= self._step * self._rate * lasting
        self._correction = np.minimum(np.maximum(self._correction, -far), far)
        return offset - near + self._correction
