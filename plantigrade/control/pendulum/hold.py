"""How long a command holds: a tick, or until a sole touches the ground or leaves it.

Torques that bear the body throw a foot that has left the ground meanwhile: a toe, in hundredths of
a second. With soles that are sampled more often, the program need not be solved as often.
"""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.world import StablePD


class CommandHold:
    """The last command, and whether it still holds.

    Args:
        tick: Time for which it holds [s].
        step: Time from one sample of the soles to the next [s].

    Attributes:
        samples: Samples of the soles in a tick.
        qacc: Accelerations by the last command.
    """

    def __init__(self, tick: float, step: float, nv: int):
        self.samples, self.step = max(round(tick / step), 1), step
        self._left, self._contact = 0, (b"", b"")
        self._command: StablePD | None = None
        self.qacc: Float[Array, " nv"] = np.zeros(nv)

    @property
    def half(self) -> float:
        """Half a tick [s]."""
        return 0.5 * self.samples * self.step

    def still_holds(self, touching: Bool[Array, " n_sites"], stance: list[bool]) -> bool:
        """Return whether the last command still holds; to be called at every sample."""
        contact = touching.tobytes(), bytes(stance)
        holds = contact == self._contact and self._left > 0
        self._contact = contact
        self._left = (self._left if holds else self.samples) - 1
        return holds

    def keep(self, command: StablePD, qacc: Float[Array, " nv"]) -> StablePD:
        """Take a new command, and the accelerations by it."""
        self._command, self.qacc = command, qacc
        return command

    def next(self) -> StablePD:
        """Return the last command a sample later: rates go on as they were planned."""
        command = self._command
        assert command is not None and command.velocity is not None
        self._command = replace(command, velocity=command.velocity + self.step * self.qacc[6:])
        return self._command
