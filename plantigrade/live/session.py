"""A live session: a world, what moves the person, and what somebody changes of both.

The thread that owns a session calls :meth:`Session.advance`; everybody else asks: what
:meth:`Session.ask` is given is done between two control steps, so a page never meets a world in the
middle of a step. What is to be drawn lies in :attr:`Session.frame`, which is replaced as a whole.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from threading import Event
from typing import Protocol, runtime_checkable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.site import GEOM_PREFIX
from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.live.clock import Clock, Pace
from plantigrade.live.frame import Frame, History
from plantigrade.live.hand import Hand, Rope
from plantigrade.live.slope import Slope
from plantigrade.record import Record
from plantigrade.spatial.conventions import rotation_matrix
from plantigrade.world import Controller, Disturbance, Load, Target, World
from plantigrade.world.load import pack_of
from plantigrade.world.world_model import GROUND_PREFIXES

SPEEDS = (1.0, 0.5, 0.25, 0.1)
"""Simulated per real time."""
RATE = 60.0
"""Frames per second."""
LONGEST = 600.0
"""A session is kept so long; then it pauses [s]."""
CORE = 0.3
"""Friction of trunk and limbs; the ground's where that is less."""


@dataclass(frozen=True)
class Choice:
    """What a person may choose for a session.

    Attributes:
        controller: Name of a controller, or of one's own.
        feet: Kind of foot.
        joints: Joint set.
    """

    controller: str
    feet: str
    joints: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Cast:
    """Who is in a session: a world, and what moves its person.

    Attributes:
        world: The world, with the disturbances that it was asked to have.
        controller: Returns a new controller of a name.
        slope: The plate by which its ground tilts; None where the ground is not level.
        load: What the person has on the back.
    """

    world: World
    controller: Callable[[str], Controller]
    slope: Slope | None
    load: Load = field(default_factory=lambda: Load(0.0))


@runtime_checkable
class Director(Protocol):
    """What makes the world of a session."""

    def __call__(
        self, choice: Choice, hand: Disturbance, place: tuple[float, float, float] | None
    ) -> Cast:
        """Return who is in it.

        Args:
            choice: What is wanted.
            hand: What also acts.
            place: Where the person stands [m], and which way they look [rad]; None at the first
                start.

        Raises:
            PlantigradeError: If there is nothing of the kind.
        """
        ...


class Session:
    """A world that runs while somebody interferes.

    Args:
        director: Makes the world.
        choice: With what it begins.
        most: Force of the hand [N].
        until: When it pauses by itself [s].

    Attributes:
        choice: What is chosen now.
        until: When it pauses by itself [s].
        speed: Simulated per real time.
        paused: Whether it stands still.
        frame: What is to be drawn.
        news: Set with every new frame; whoever draws clears it.
        message: What the person should know; empty where there is nothing.
        asked: What is still to be done.

    Raises:
        PlantigradeError: If there is nothing of the kind that is chosen.
    """

    def __init__(
        self,
        director: Director,
        choice: Choice,
        *,
        most: float = 100.0,
        until: float | None = None,
    ):
        self._director, self._hand = director, Hand(most)
        self.news = Event()
        self.asked: deque[Callable[[], None]] = deque()
        self.until = min(until or LONGEST, LONGEST)
        self.speed, self.paused, self.message = 1.0, False, ""
        self._take(choice, director(choice, self._hand, None))

    @property
    def world(self) -> World:
        """The world."""
        return self._cast.world

    @property
    def controller(self) -> Controller:
        """What moves the person now."""
        return self._controller

    @property
    def targets(self) -> tuple[Target, ...]:
        """What may be set of the controller."""
        return tuple(self._controller.targets)

    @property
    def tilts(self) -> bool:
        """Whether the ground can be tilted."""
        return self._cast.slope is not None

    @property
    def slope_wanted(self) -> Float[Array, " 2"] | None:
        """Slope up in front, and up on the left; None where it cannot be tilted [rad]."""
        return None if self._cast.slope is None else self._cast.slope.wanted

    @property
    def hand(self) -> Hand:
        """What pulls and pushes."""
        return self._hand

    def ask(self, action: Callable[[], None]) -> None:
        """Let something be done before the next control step; from any thread."""
        self.asked.append(action)

    def advance(self, seconds: float) -> float:
        """Do what was asked, simulate whole control steps, and return how long they were [s]."""
        asked = len(self.asked)
        for _ in range(asked):
            try:
                self.asked.popleft()()
            except PlantigradeError as error:
                self.message = str(error)
        period, start = 1.0 / self.world.control_rate, self.world.time
        done = 0.0
        while not self.paused and seconds - done > period - 1e-9:
            self._step()
            done += period
        if self.world.time != start or asked:
            self.frame = self._look()
            self.news.set()
        return done

    def step(self) -> None:
        """Pause, and do one control step."""
        self.paused = True
        self._step()

    def restart(self) -> None:
        """Start anew; what was recorded is lost, slope and friction are as at first."""
        self._take(self.choice, self._cast)
        self.message = ""

    def choose(self, choice: Choice) -> None:
        """Take another controller, or another body.

        A new controller takes over where the person is; one that wants commands more often than
        this world has them starts anew. With other feet or joints the person is
        another one: it stands, at rest, where the last one was; motion, forces, targets, slope and
        what was recorded so far are lost.
        """
        if (choice.feet, choice.joints) == (self.choice.feet, self.choice.joints):
            controller = self._cast.controller(choice.controller)
            if controller.rates.control > self.world.control_rate + 1e-6:
                self._take(choice, self._director(choice, self._hand, None))
                self.message = f"{choice.controller} wants other rates: it starts anew."
                return
            self._controller = controller
            self.choice, self.message = choice, ""
            return
        self._take(choice, self._director(choice, self._hand, self._place()))
        self.message = "Another body stands there now: what was recorded before is lost."

    def push(self, direction: float, duration: float) -> None:
        """Push at the upper trunk: 0 forward, a quarter turn left [rad]; how long [s]."""
        self._hand.push(self.world.time + duration, direction)

    def hold(self, body: int, at: Float[Array, " 3"], end: Float[Array, " 3"]) -> None:
        """Hold a body at a place, and pull it to another one, world [m]."""
        if not 0 < body < self.world.model.nbody:
            raise ParameterError(f"there is no body {body} to hold")
        if not np.isfinite([at, end]).all():
            raise ParameterError("a body is held and pulled at places with finite coordinates")
        data = self.world.data
        turn = data.xmat[body].reshape(3, 3)
        self._hand.hold(Rope(body, turn.T @ (at - data.xpos[body]), end))

    def pull(self, end: Float[Array, " 3"]) -> None:
        """Pull what is held to another place, world [m]; nothing where nothing is held."""
        if not np.isfinite(end).all():
            raise ParameterError("a body is pulled to places with finite coordinates")
        if self._hand.rope is not None:
            self._hand.hold(replace(self._hand.rope, end=end))

    def tilt(self, ahead: float, left: float) -> None:
        """Tilt the ground: slope up in front, and up on the left [rad]."""
        if self._cast.slope is None:
            raise ParameterError("only level ground can be tilted")
        self._cast.slope.wanted = np.array([ahead, left])

    @property
    def load(self) -> float:
        """What the person has on the back [kg]."""
        return self._load

    def carry(self, mass: float) -> None:
        """Give the person another load [kg]."""
        self._cast.load.carry(self.world, mass)
        self._load = mass

    @property
    def friction(self) -> float:
        """Friction of the ground."""
        return self._friction

    def rub(self, friction: float) -> None:
        """Give the ground another friction."""
        model = self.world.model
        for i in range(model.ngeom):
            name = model.geom(i).name
            if name.startswith((GEOM_PREFIX, *GROUND_PREFIXES)):
                model.geom_friction[i, 0] = friction
            elif name.startswith("core_"):
                model.geom_friction[i, 0] = min(CORE, friction)
        self._friction, self._roughest = friction, max(self._roughest, friction)

    def record(self) -> Record:
        """Return what has happened since the start.

        Its ground has the greatest friction that there was.
        """
        record = self.world.record()
        return replace(record, ground=replace(record.ground, friction=self._roughest))

    def _take(self, choice: Choice, cast: Cast) -> None:
        """Start with a cast."""
        controller = cast.controller(choice.controller)
        self.choice, self._cast, self._controller = choice, cast, controller
        self._history = History(cast.world)
        self._roughest = 0.0
        self._state = cast.world.reset()
        self.rub(cast.world.ground.friction)
        self._load = cast.load.mass
        self.frame = self._look()

    def _step(self) -> None:
        world = self.world
        if world.diverged is not None or world.time > self.until - 1e-9:
            self.paused = True
            return
        self._hand.said = {
            "live.friction": self._friction,
            "live.load": self._load,
            **self._set(),
        }
        try:
            self._state = world.step(self._controller(self._state))
        except PlantigradeError as error:  # of the controller's command
            self.paused, self.message = True, str(error)
            return
        self._history.keep(world, *self._contact_forces())

    def _set(self) -> dict[str, float]:
        """Return what is set of the controller, as signals."""
        return {f"live.{t.name.replace(' ', '_')}": t.value for t in self.targets}

    def _contact_forces(self) -> tuple[Array, Array]:
        """Return force and place of every contact sphere."""
        contacts = self.world.contacts
        external = contacts.external_forces([contacts.read_step(self.world.data)[0]])
        return external.force[0], external.point[0]

    def _look(self) -> Frame:
        world, data = self.world, self.world.data
        force, point = self._contact_forces()
        rope, line = self._hand.rope, None
        if rope is not None:
            line = np.array([rope.place(data), rope.end])
        return Frame(
            world=world,
            time=world.time,
            positions=data.xpos.copy(),
            quats=data.xquat.copy(),
            com=data.subtree_com[1].copy(),
            force=force,
            point=point,
            rope=line,
            pushes=world.pushes,
            pack=pack_of(self._load),
            worn=self._cast.load.pose(world),
            drawings=tuple(self._controller.drawings(self._state)),
            past=self._history.past(),
            ended=self._ended(),
        )

    def _ended(self) -> str:
        world = self.world
        if world.diverged is not None:
            return f"diverged at {world.diverged:.2f} s"
        if world.time > self.until - 1e-9:
            return f"paused at {self.until:g} s, where it ends"
        return "" if world.fall is None else str(world.fall)

    def _place(self) -> tuple[float, float, float]:
        """Return where the person is, and which way they look."""
        root = self._state.qpos
        ahead = rotation_matrix(root[3:7])[:2, 0]
        return float(root[0]), float(root[1]), float(np.arctan2(ahead[1], ahead[0]))


def run(session: Session, stop: Event, clock: Clock | None = None) -> None:
    """Keep a session to real time until ``stop`` is set."""
    clock = clock or Clock()
    pace = Pace(RATE)
    clock.begin()
    while not stop.wait(pace.rest()):
        clock.did(session.advance(clock.owed(0.0 if session.paused else session.speed)))
