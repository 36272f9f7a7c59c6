"""Disturbances of a person: their interface, and pushes."""

from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.constants import SIDES
from plantigrade.contact.scene import SceneObject
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world.simulated_world import SimulatedWorld

TRUNK_BODIES = ("thorax", "torso")
LIFTED_LOAD = 0.01  # [body weights] below which a foot is off the ground
LANDED_LOAD = 0.05  # [body weights] above which a foot is on the ground
MIN_SWING_TIME = 0.1  # [s] off the ground before a touchdown counts as a step
MAX_FORCE = 1e5  # [N]
MAX_TIME = 3600.0  # [s], the longest simulation
MAX_ANGLE = 100.0  # [rad]


def body_index(human: Human, body: str = "") -> int:
    """Return the index of a body, by default of the upper trunk.

    Raises:
        CoordinateNotFound: If there is no such body.
    """
    return human.body(body or next(b for b in TRUNK_BODIES if b in human.body_names))


def parse_numbers(word: str, what: str, form: str, *counts: int) -> list[float]:
    """Return the comma-separated numbers of a text from the command line."""
    try:
        numbers = [float(part) for part in word.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts:
        raise ParameterError(f"{word!r} is not a {what}: write {form}")
    return numbers


class Disturbance:
    """Base class of disturbances; a subclass overrides the methods it needs.

    One disturbance may act in several worlds: its state in each is ``world.memory[self]``.
    """

    interval: ClassVar[float] = np.inf
    """Interval of additional calls between control steps and edges [s]."""

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Add bodies or tendons to the model of the world, after the person."""

    def reset(self, world: SimulatedWorld) -> None:
        """Prepare the disturbance at the start of a simulation."""

    def edges(self) -> tuple[float, ...]:
        """Return start and end times [s]; physics steps end there."""
        return ()

    def act(self, world: SimulatedWorld) -> None:
        """Act until the next call, after :attr:`interval`: call :meth:`World.push`."""

    @property
    def scene_object(self) -> SceneObject | None:
        """Visible object of the disturbance; None if there is none."""
        return None

    def pose(self, world: SimulatedWorld) -> Float[Array, " 7"]:
        """Return centre, world [m], and rotation ``wxyz`` of that object; NaN if absent."""
        return np.full(7, np.nan)


@dataclass(frozen=True, kw_only=True)
class Push(Disturbance):
    """A constant force at the centre of mass of a body.

    Attributes:
        force: Force [N].
        duration: Duration [s].
        direction: Horizontal direction, 0 forward, a quarter turn to the left [rad].
        time: Start time [s].
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
        number("force", self.force, -MAX_FORCE, MAX_FORCE, "N", "a push")
        number("duration", self.duration, 1e-3, MAX_TIME, "s", "a push")
        number("direction", self.direction, -MAX_ANGLE, MAX_ANGLE, "rad", "a push")
        number("time", self.time, 0, MAX_TIME, "s", "a push")

    @staticmethod
    def parse(word: str) -> "Push":
        """Return the push that a text describes: force [N], duration [s], direction [°], time [s].

        The time may be a foot and a percentage of its gait cycle instead: ``"r25"``.

        Raises:
            ParameterError: If the text has another form.

        Example:
            >>> Push.parse("100,0.2,90,1.5").time
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
        return body_index(human, self.body)

    @property
    def vector(self) -> Float[Array, " 3"]:
        """The force, world [N]."""
        return self.force * np.array([np.cos(self.direction), np.sin(self.direction), 0.0])

    def reset(self, world: SimulatedWorld) -> None:
        """Check that the body exists."""
        self.on(world.human)

    def edges(self) -> tuple[float, ...]:
        """Return the start and end time [s]."""
        return (self.time, self.time + self.duration)

    def act(self, world: SimulatedWorld) -> None:
        """Push from start to end."""
        if self.time - 1e-9 <= world.time < self.time + self.duration - 1e-9:
            world.push(self.on(world.human), self.vector)


@dataclass(frozen=True, kw_only=True)
class PhasePush(Push):
    """One push at a phase of the gait cycle.

    The duration of the cycle follows from two heel strikes of the foot, so the push comes after the
    second one at the earliest.

    Attributes:
        side: Foot whose cycle counts, ``"r"`` or ``"l"``.
        phase: Phase of the cycle, from 0 to 1.
        time: Time before which heel strikes are ignored [s].

    Raises:
        ParameterError: As :class:`Push`, or if there is no such side or phase.
    """

    side: str = "r"
    phase: float = 0.0

    def __post_init__(self):
        super().__post_init__()
        if self.side not in SIDES or not 0.0 <= self.phase <= 1.0:
            raise ParameterError(f"{self}: side must be 'r' or 'l', and phase from 0 to 1")

    def missed(self, world: SimulatedWorld) -> str:
        """Return a message if the push has not come, else an empty string."""
        begin = world.memory[self].push_time
        if begin is not None and begin < world.time:
            return ""
        foot = "right" if self.side == "r" else "left"
        return (
            f"The push at {100 * self.phase:g} % of the gait cycle of the {foot} foot never came: "
            "it needs two heel strikes of that foot."
        )

    def reset(self, world: SimulatedWorld) -> None:
        """Prepare the detection of heel strikes."""
        super().reset(world)
        world.memory[self] = StrikeTimer()

    def edges(self) -> tuple[float, ...]:
        """Return no edges, because the start time is not known in advance."""
        return ()

    def act(self, world: SimulatedWorld) -> None:
        """Update the detection, and push from start to end."""
        timer: StrikeTimer = world.memory[self]
        mine = np.array([site.side == self.side for site in world.sites])
        if timer.push_time is None:
            force = float(world.contact_force()[mine, 2].sum())
            timer.update(world.time, force / (world.human.mass * world.human.gravity), self)
        begin = np.inf if timer.push_time is None else timer.push_time
        if begin - 1e-9 <= world.time < begin + self.duration - 1e-9:
            world.push(self.on(world.human), self.vector)


@dataclass
class StrikeTimer:
    """Detects heel strikes of a foot and times a push."""

    push_time: float | None = None  #: Start time of the push [s]
    last_strike: float | None = None  #: Time of the last heel strike [s]
    liftoff: float | None = None  #: Time since which the foot has been off the ground [s]

    def update(self, time: float, load: float, push: PhasePush) -> None:
        """Update with the load of the foot [body weights] at a time [s]."""
        if load < LIFTED_LOAD:
            self.liftoff = time if self.liftoff is None else self.liftoff
        elif load > LANDED_LOAD:
            swung = self.liftoff is not None and time - self.liftoff >= MIN_SWING_TIME
            self.liftoff = None
            if swung and time >= push.time:
                if self.last_strike is not None:
                    self.push_time = time + push.phase * (time - self.last_strike)
                self.last_strike = time
