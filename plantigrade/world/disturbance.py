"""What else acts on a person in a world: the interface, and forces at a body."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.models import Human

if TYPE_CHECKING:
    from plantigrade.world.world import World

TRUNK = ("thorax", "torso")


class Disturbance:
    """Something that acts on a world; a subclass overrides what it needs.

    One disturbance may serve several worlds: what it keeps of one lies in that world's ``data``.
    """

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Add bodies or tendons to the model of the world, after the person."""

    def reset(self, world: "World") -> None:
        """Make ready at the start."""

    def edges(self) -> tuple[float, ...]:
        """Return when it begins and ends; no step of the physics reaches over an edge [s]."""
        return ()

    def act(self, world: "World") -> None:
        """Act from now until the next control step or edge: add to ``data.xfrc_applied``."""


@dataclass(frozen=True, kw_only=True)
class Push(Disturbance):
    """A constant force at the centre of mass of a body.

    Attributes:
        force: Its size [N].
        duration: How long it acts [s].
        direction: Where it pushes to, over the ground: 0 forward, a quarter turn to the left
            [rad].
        time: When it begins [s].
        body: Name of the body; the upper trunk if empty.

    Raises:
        ParameterError: If a number is not finite, or the duration not positive.
    """

    force: float
    duration: float
    direction: float = 0.0
    time: float = 0.0
    body: str = ""

    def __post_init__(self):
        """Refuse what is no push."""
        if not np.isfinite([self.force, self.duration, self.direction, self.time]).all():
            raise ParameterError(f"{self} has a number that is not finite")
        if not self.duration > 0 or self.time < 0:
            raise ParameterError(f"{self} must last longer than 0 s and begin at 0 s or later")

    @classmethod
    def written(cls, word: str) -> "Push":
        """Return the push of a word: newtons, seconds, direction in degrees, when in seconds.

        Raises:
            ParameterError: If it is none.

        Example:
            >>> Push.written("100,0.2,90,1.5").time
            1.5
        """
        try:
            force, duration, direction, time = (float(part) for part in word.split(","))
        except ValueError:
            raise ParameterError(
                f"{word!r} is no push: write NEWTON,SECONDS,DIRECTION_DEG,AT_S such as "
                "100,0.2,90,1.5, to the left after 1.5 s"
            ) from None
        return cls(
            force=force, duration=duration, direction=float(np.deg2rad(direction)), time=time
        )

    def on(self, human: Human) -> int:
        """Return the index of the body it acts on.

        Raises:
            CoordinateNotFound: If there is no such body.
        """
        return human.body(self.body or next(b for b in TRUNK if b in human.body_names))

    @property
    def vector(self) -> Float[Array, " 3"]:
        """The force, world [N]."""
        return self.force * np.array([np.cos(self.direction), np.sin(self.direction), 0.0])

    def reset(self, world: "World") -> None:
        """Refuse a body that is not there, before any work."""
        self.on(world.human)

    def edges(self) -> tuple[float, ...]:
        """Return when it begins and ends [s]."""
        return (self.time, self.time + self.duration)

    def act(self, world: "World") -> None:
        """Push while it lasts."""
        if self.time - 1e-9 <= world.time < self.time + self.duration - 1e-9:
            world.push(self.on(world.human), self.vector)
