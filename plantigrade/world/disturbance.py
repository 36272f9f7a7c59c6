"""Disturbances of a person in a world: the interface, and forces on a body."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.thing import Thing
from plantigrade.errors import ParameterError
from plantigrade.models import Human

if TYPE_CHECKING:
    import plantigrade.world.world

TRUNK = ("thorax", "torso")
LIFTED, LOADED = 0.01, 0.05
"""A foot is off the ground below the one, and on it above the other [body weights]."""
SWING = 0.1
"""A foot that strikes was off the ground for so long [s]."""
STRONGEST, LATEST, TURNS = 1e5, 3600.0, 100.0
"""Greatest force [N], latest time [s] and greatest angle [rad] of what acts."""


def trunk(human: Human, body: str = "") -> int:
    """Return the index of a body, of the upper trunk if none is named.

    Raises:
        CoordinateNotFound: If there is no such body.
    """
    return human.body(body or next(b for b in TRUNK if b in human.body_names))


def written_numbers(word: str, what: str, form: str, *counts: int) -> list[float]:
    """Return the numbers of a word of the command line, parted by commas.

    Args:
        word: The word.
        what: What it should be.
        form: How that is written, with an example.
        counts: How many numbers it may have.

    Raises:
        ParameterError: If it has another number of them, or one is none.
    """
    try:
        numbers = [float(part) for part in word.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts:
        raise ParameterError(f"{word!r} is no {what}: write {form}")
    return numbers


class Disturbance:
    """A disturbance of a world; a subclass overrides what it needs.

    One disturbance may serve several worlds: what it keeps of one is ``world.memory[self]``.
    """

    interval: ClassVar[float] = np.inf
    """So often it wants to act, beside at every control step and edge [s]."""

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Add bodies or tendons to the model of the world, after the person."""

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Make ready at the start."""

    def edges(self) -> tuple[float, ...]:
        """Return when it begins and ends; no step of the physics reaches over an edge [s]."""
        return ()

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Act until it is asked again, after :attr:`interval`: call :meth:`World.push`."""

    @property
    def thing(self) -> Thing | None:
        """What of it can be seen; None if nothing."""
        return None

    def place(self, world: "plantigrade.world.world.World") -> Float[Array, " 7"]:
        """Return where that is: its middle, world [m], and rotation ``wxyz``; NaN while nowhere."""
        return np.full(7, np.nan)


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
        ParameterError: If a number is out of range.
    """

    force: float
    duration: float
    direction: float = 0.0
    time: float = 0.0
    body: str = ""

    def __post_init__(self):
        """Refuse what is no push."""
        number("force", self.force, -STRONGEST, STRONGEST, "N", "a push")
        number("duration", self.duration, 1e-3, LATEST, "s", "a push")
        number("direction", self.direction, -TURNS, TURNS, "rad", "a push")
        number("time", self.time, 0, LATEST, "s", "a push")

    @staticmethod
    def written(word: str) -> "Push":
        """Return the push of a word: newtons, seconds, direction in degrees, when in seconds.

        Or, for when, a foot and a percentage of its gait cycle: ``"r25"``.

        Raises:
            ParameterError: If it is none.

        Example:
            >>> Push.written("100,0.2,90,1.5").time
            1.5
        """
        *size, when = word.split(",")
        side, percent = (when[:1], when[1:]) if when[:1] in SIDES else ("", when)
        try:
            force, duration, direction, at = (float(part) for part in (*size, percent))
        except ValueError:
            raise ParameterError(
                f"{word!r} is not a push: write NEWTON,SECONDS,DIRECTION_DEG,AT_S such as "
                "100,0.2,90,1.5, to the left after 1.5 s; or r25 for AT_S, at 25 % of a right cycle"
            ) from None
        turned = float(np.deg2rad(direction))
        if not side:
            return Push(force=force, duration=duration, direction=turned, time=at)
        return PhasePush(
            force=force, duration=duration, direction=turned, side=side, phase=0.01 * at
        )

    def on(self, human: Human) -> int:
        """Return the index of the body it acts on.

        Raises:
            CoordinateNotFound: If there is no such body.
        """
        return trunk(human, self.body)

    @property
    def vector(self) -> Float[Array, " 3"]:
        """The force, world [N]."""
        return self.force * np.array([np.cos(self.direction), np.sin(self.direction), 0.0])

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Refuse a body that is not there, before any work."""
        self.on(world.human)

    def edges(self) -> tuple[float, ...]:
        """Return when it begins and ends [s]."""
        return (self.time, self.time + self.duration)

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Push while it lasts."""
        if self.time - 1e-9 <= world.time < self.time + self.duration - 1e-9:
            world.push(self.on(world.human), self.vector)


@dataclass(frozen=True, kw_only=True)
class PhasePush(Push):
    """One push at a phase of the gait, measured from a heel strike.

    How long a cycle lasts is told by the strike before; so the first two strikes are waited for.

    Attributes:
        side: Which foot, ``"r"`` or ``"l"``.
        phase: Part of its cycle that has passed, from 0 to 1.
        time: Strikes before this do not count [s].

    Raises:
        ParameterError: As :class:`Push`, or if there is no such side or phase.
    """

    side: str = "r"
    phase: float = 0.0

    def __post_init__(self):
        """Refuse what is no phase."""
        super().__post_init__()
        if self.side not in SIDES or not 0.0 <= self.phase <= 1.0:
            raise ParameterError(f"{self}: side must be 'r' or 'l', the phase within 0 and 1")

    def missed(self, world: "plantigrade.world.world.World") -> str:
        """Return a sentence where its time has not come yet, else nothing."""
        begin = world.memory[self].begin
        if begin is not None and begin < world.time:
            return ""
        foot = "right" if self.side == "r" else "left"
        return (
            f"A push at {100 * self.phase:g} % of a cycle of the {foot} foot never came: it waits "
            "for two strikes of that foot."
        )

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Wait for a step."""
        super().reset(world)
        world.memory[self] = Steps()

    def edges(self) -> tuple[float, ...]:
        """Return nothing: when it begins is not known yet."""
        return ()

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Push when it is time."""
        steps: Steps = world.memory[self]
        mine = np.array([site.side == self.side for site in world.sites])
        if steps.begin is None:
            force = float(world.contact_force()[mine, 2].sum())
            steps.look(world.time, force / (world.human.mass * GRAVITY), self)
        begin = np.inf if steps.begin is None else steps.begin
        if begin - 1e-9 <= world.time < begin + self.duration - 1e-9:
            world.push(self.on(world.human), self.vector)


@dataclass
class Steps:
    """What a phase push has observed of a foot.

    Attributes:
        begin: When to push [s].
        strike: The last strike [s].
        off: Since when the foot has been off the ground [s].
    """

    begin: float | None = None
    strike: float | None = None
    off: float | None = None

    def look(self, time: float, load: float, push: PhasePush) -> None:
        """See the load of the foot at a time [body weights, s]."""
        if load < LIFTED:
            self.off = time if self.off is None else self.off
        elif load > LOADED:
            swung = self.off is not None and time - self.off >= SWING
            self.off = None
            if swung and time >= push.time:
                if self.strike is not None:
                    self.begin = time + push.phase * (time - self.strike)
                self.strike = time
