"""How long a command holds: a tick, or until a sole touches the ground or leaves it.

Torques that bear the body throw a foot that has left the ground meanwhile: a toe, in hundredths of
a second. Whoever looks at the soles more often than they solve the program need not solve it often.
"""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.world import StablePD

LONGEST = 0.1
"""Nobody walks with longer ticks [s]."""


class Hold:
    """The last command.

    Args:
        tick: So long it holds [s].
        step: From one look to the next [s].
        nv: Coordinates of the person.

    Attributes:
        looks: In a tick.
        qacc: Accelerations that the last command gives.
    """

    def __init__(self, tick: float, step: float, nv: int):
        self.looks, self.step = max(round(tick / step), 1), step
        self._left, self._near, self._stands = 0, b"", b""
        self._command: StablePD | None = None
        self.qacc: Float[Array, " nv"] = np.zeros(nv)

    @property
    def half(self) -> float:
        """To the middle of a tick [s]."""
        return 0.5 * self.looks * self.step

    def goes_on(self, near: Bool[Array, " n_sites"], stands: list[bool]) -> bool:
        """Return whether the last command does; to be asked at every look.

        Args:
            near: Which spheres are at the ground.
            stands: Which feet stand.
        """
        now = near.tobytes(), bytes(stands)
        same = now == (self._near, self._stands)
        self._near, self._stands = now
        goes = same and self._left > 0
        self._left = (self._left if goes else self.looks) - 1
        return goes

    def keep(self, command: StablePD, qacc: Float[Array, " nv"]) -> StablePD:
        """Take a new command, and what accelerations it gives."""
        self._command, self.qacc = command, qacc
        return command

    def later(self) -> StablePD:
        """Return the last command a look later: rates go on as they were planned."""
        command = self._command
        assert command is not None and command.velocity is not None
        self._command = replace(command, velocity=command.velocity + self.step * self.qacc[6:])
        return self._command
