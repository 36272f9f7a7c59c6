"""A rope that pulls at a person."""

from dataclasses import dataclass

import numpy as np

from plantigrade.bounds import number
from plantigrade.world.disturbance import (
    MAX_FORCE,
    MAX_TIME,
    Disturbance,
    body_index,
    parse_numbers,
)
from plantigrade.world.simulated_world import SimulatedWorld

MAX_ANCHOR = 1e3  # [m] from the origin, along any axis


@dataclass(frozen=True, kw_only=True)
class Rope(Disturbance):
    """A rope that pulls a body towards a fixed point with a constant force.

    Attributes:
        force: Tension [N].
        anchor: Fixed end, world [m].
        time: Start time [s].
        duration: Duration [s]; infinite if absent.
        body: Name of the body to whose centre of mass it is tied; the upper trunk if empty.

    Raises:
        ParameterError: If a number is out of range.
    """

    interval = 0.01
    force: float
    anchor: tuple[float, float, float]
    time: float = 0.0
    duration: float = np.inf
    body: str = ""

    def __post_init__(self):
        number("force", self.force, 0, MAX_FORCE, "N", "a rope, which only pulls")
        for place in self.anchor:
            number("anchor", place, -MAX_ANCHOR, MAX_ANCHOR, "m", "a rope")
        number("time", self.time, 0, MAX_TIME, "s", "a rope")
        number("duration", self.duration, 1e-3, np.inf, "s", "a rope")

    @staticmethod
    def parse(word: str) -> "Rope":
        """Return the rope that a text describes: tension [N], anchor [m], time [s], duration [s].

        Raises:
            ParameterError: If the text has another form.

        Example:
            >>> Rope.parse("80,2,0,1,0.5").anchor
            (2.0, 0.0, 1.0)
        """
        form = "NEWTON,X,Y,Z,AT_S[,SECONDS] such as 80,2,0,1,0.5,1: towards 2 m ahead, 1 m high"
        force, x, y, z, at, *lasts = parse_numbers(word, "rope", form, 5, 6)
        return Rope(force=force, anchor=(x, y, z), time=at, duration=lasts[0] if lasts else np.inf)

    def reset(self, world: SimulatedWorld) -> None:
        """Check that the body exists."""
        body_index(world.human, self.body)

    def edges(self) -> tuple[float, ...]:
        """Return when it begins and ends to pull [s]."""
        return tuple(t for t in (self.time, self.time + self.duration) if np.isfinite(t))

    def act(self, world: SimulatedWorld) -> None:
        """Pull from start to end."""
        if self.time - 1e-9 <= world.time < self.time + self.duration - 1e-9:
            body = body_index(world.human, self.body)
            way = np.array(self.anchor) - world.data.xipos[body]
            far = float(np.linalg.norm(way))
            if far > 1e-6:
                world.push(body, self.force / far * way)
