"""What a balanced person is to do: a posture held, or a motion, and which points press."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from plantigrade.arrays import Array, Bool, Float


@dataclass(frozen=True, eq=False)
class Wanted:
    """What is wanted at one time.

    Attributes:
        qpos: The configuration.
        qvel: Its rate.
        qacc: The rate of that.
        presses: Which contact spheres of the feet are to be on the ground; all if absent.
    """

    qpos: Float[Array, " nq"]
    qvel: Float[Array, " nv"]
    qacc: Float[Array, " nv"]
    presses: Bool[Array, " n_sites"] | None = None


class Reference(Protocol):
    """What is wanted, as a function of time."""

    def at(self, time: float) -> Wanted:
        """Return what is wanted at a time since the start [s]."""
        ...


class Held:
    """A posture that is held.

    Args:
        qpos: The posture.
        nv: Number of velocities.
    """

    def __init__(self, qpos: Float[Array, " nq"], nv: int):
        self.wanted = Wanted(np.array(qpos), np.zeros(nv), np.zeros(nv))

    def at(self, time: float) -> Wanted:
        """Return the posture."""
        return self.wanted
