"""A live session: a world and a controller that a user changes while they run.

The thread that owns a session calls :meth:`Session.advance`. Other threads pass actions to
:meth:`Session.submit`, which are done between two control steps. :attr:`Session.frame` has the
state for display and is replaced as a whole.
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
from plantigrade.live.clock import Clock, LoopPace
from plantigrade.live.frame import History, LiveFrame
from plantigrade.live.interactive_force import DragRope, InteractiveForce
from plantigrade.live.slope import Slope
from plantigrade.record import Record
from plantigrade.spatial.conventions import facing
from plantigrade.world import Controller, Disturbance, Load, Target, World
from plantigrade.world.load import pack_of
from plantigrade.world.world_model import GROUND_PREFIXES

SPEEDS = (1.0, 0.5, 0.25, 0.1)  # simulated per real time
RATE = 60.0  # [1/s] of frames
MAX_DURATION = 600.0  # [s] of a session, which is recorded in memory; then it pauses
BODY_FRICTION = 0.3  # of trunk and limbs, at most that of the ground


@dataclass(frozen=True)
class Choice:
    """Controller and body of a session."""

    controller: str  #: Name of a controller
    feet: str  #: Kind of feet
    joints: str  #: Joint set


@dataclass(frozen=True, eq=False, kw_only=True)
class SessionWorld:
    """World of a session and its parts that can be changed."""

    world: World  #: The world with its disturbances
    controller: Callable[[str], Controller]  #: Function that returns a new controller by name
    slope: Slope | None  #: Plate by which the ground tilts; None if the ground is not level
    load: Load = field(default_factory=lambda: Load(0.0))  #: Load on the back


@runtime_checkable
class WorldFactory(Protocol):
    """Function that makes the world of a session."""

    def __call__(
        self, choice: Choice, hand: Disturbance, placement: tuple[float, float, float] | None
    ) -> SessionWorld:
        """Return the world and its parts.

        Args:
            placement: Position [m] and heading [rad] of the person; None at the first start.

        Raises:
            PlantigradeError: If the choice does not exist.
        """
        ...


class Session:
    """A simulation that a user changes while it runs.

    Args:
        director: Function that makes the world.
        choice: Initial controller and body.
        max_force: Maximum interactive force [N].
        until: Time at which the session pauses [s].

    Attributes:
        choice: Present controller and body.
        until: Time at which the session pauses [s].
        speed: Simulated per real time.
        paused: Whether the simulation is paused.
        frame: State for display.
        frame_ready: Event that is set with every new frame; the display clears it.
        message: Message for the user; empty if there is none.
        pending: Actions that are not done yet.

    Raises:
        PlantigradeError: If the choice does not exist.
    """

    def __init__(
        self,
        director: WorldFactory,
        choice: Choice,
        *,
        max_force: float = 100.0,
        until: float | None = None,
    ):
        self._director, self._hand = director, InteractiveForce(max_force)
        self.frame_ready = Event()
        self.pending: deque[Callable[[], None]] = deque()
        self.until = min(until or MAX_DURATION, MAX_DURATION)
        self.speed, self.paused, self.message = 1.0, False, ""
        self._start(choice, director(choice, self._hand, None))

    @property
    def world(self) -> World:
        """The world."""
        return self._session_world.world

    @property
    def controller(self) -> Controller:
        """Present controller."""
        return self._controller

    @property
    def targets(self) -> tuple[Target, ...]:
        """Targets of the controller."""
        return tuple(self._controller.targets)

    @property
    def tilts(self) -> bool:
        """Whether the ground can be tilted."""
        return self._session_world.slope is not None

    @property
    def desired_slope(self) -> Float[Array, " 2"] | None:
        """Desired slope, up in front and up on the left [rad]; None if it cannot be tilted."""
        return None if self._session_world.slope is None else self._session_world.slope.desired

    @property
    def hand(self) -> InteractiveForce:
        """Interactive forces."""
        return self._hand

    def submit(self, action: Callable[[], None]) -> None:
        """Add an action to be done before the next control step; may be called from any thread."""
        self.pending.append(action)

    def advance(self, seconds: float) -> float:
        """Do pending actions, simulate whole control steps, and return their duration [s]."""
        pending = len(self.pending)
        for _ in range(pending):
            try:
                self.pending.popleft()()
            except PlantigradeError as error:
                self.message = str(error)
        period, start = 1.0 / self.world.control_rate, self.world.time
        done = 0.0
        while not self.paused and seconds - done > period - 1e-9:
            self._step()
            done += period
        if self.world.time != start or pending:
            self.frame = self._current_frame()
            self.frame_ready.set()
        return done

    def step(self) -> None:
        """Pause and do one control step."""
        self.paused = True
        self._step()

    def restart(self) -> None:
        """Restart without the recording, with the initial slope and friction."""
        self._start(self.choice, self._session_world)
        self.message = ""

    def choose(self, choice: Choice) -> None:
        """Change the controller or the body.

        A new controller continues from the present state, unless it needs a higher control rate;
        then the session restarts. With other feet or joints, a new person stands at rest at the
        position of the last one; motion, forces, targets, slope and the recording are lost.
        """
        if (choice.feet, choice.joints) == (self.choice.feet, self.choice.joints):
            controller = self._session_world.controller(choice.controller)
            if controller.rates.control > self.world.control_rate + 1e-6:
                self._start(choice, self._director(choice, self._hand, None))
                self.message = (
                    f"{choice.controller} needs another control rate; the session has restarted."
                )
                return
            self._controller = controller
            self.choice, self.message = choice, ""
            return
        self._start(choice, self._director(choice, self._hand, self._placement()))
        self.message = "The body was replaced; the recording so far is lost."

    def push(self, direction: float, duration: float) -> None:
        """Push at the upper trunk in a direction [rad], 0 forward, for a duration [s]."""
        self._hand.push(self.world.time + duration, direction)

    def hold(self, body: int, at: Float[Array, " 3"], end: Float[Array, " 3"]) -> None:
        """Hold a body at a point and pull it to another one, world [m]."""
        if not 0 < body < self.world.model.nbody:
            raise ParameterError(f"there is no body {body} to hold")
        if not np.isfinite([at, end]).all():
            raise ParameterError("positions of a rope must be finite")
        data = self.world.data
        turn = data.xmat[body].reshape(3, 3)
        self._hand.hold(DragRope(body, turn.T @ (at - data.xpos[body]), end))

    def pull(self, end: Float[Array, " 3"]) -> None:
        """Pull the held body to another point, world [m]; do nothing if none is held."""
        if not np.isfinite(end).all():
            raise ParameterError("the position of the hand must be finite")
        if self._hand.rope is not None:
            self._hand.hold(replace(self._hand.rope, end=end))

    def tilt(self, ahead: float, left: float) -> None:
        """Set the desired slope of the ground, up in front and up on the left [rad]."""
        if self._session_world.slope is None:
            raise ParameterError("only level ground can be tilted")
        self._session_world.slope.desired = np.array([ahead, left])

    @property
    def load(self) -> float:
        """Load on the back [kg]."""
        return self._load

    def set_load(self, mass: float) -> None:
        """Set the load on the back [kg]."""
        self._session_world.load.set_mass(self.world, mass)
        self._load = mass

    @property
    def friction(self) -> float:
        """Friction of the ground."""
        return self._friction

    def set_friction(self, friction: float) -> None:
        """Set the friction of the ground."""
        model = self.world.model
        for i in range(model.ngeom):
            name = model.geom(i).name
            if name.startswith((GEOM_PREFIX, *GROUND_PREFIXES)):
                model.geom_friction[i, 0] = friction
            elif name.startswith("core_"):
                model.geom_friction[i, 0] = min(BODY_FRICTION, friction)
        self._friction, self._max_friction = friction, max(self._max_friction, friction)

    def record(self) -> Record:
        """Return the Record since the start.

        The friction of its ground is the maximum of the session.
        """
        record = self.world.record()
        return replace(record, ground=replace(record.ground, friction=self._max_friction))

    def _start(self, choice: Choice, session_world: SessionWorld) -> None:
        """Start a world with a choice."""
        controller = session_world.controller(choice.controller)
        self.choice, self._session_world, self._controller = choice, session_world, controller
        self._history = History(session_world.world)
        self._max_friction = 0.0
        self._state = session_world.world.reset()
        self.set_friction(session_world.world.ground.friction)
        self._load = session_world.load.mass
        self.frame = self._current_frame()

    def _step(self) -> None:
        world = self.world
        if world.diverged is not None or world.time > self.until - 1e-9:
            self.paused = True
            return
        self._hand.signals = {
            "live.friction": self._friction,
            "live.load": self._load,
            **{f"live.{t.name.replace(' ', '_')}": t.value for t in self.targets},
        }
        try:
            self._state = world.step(self._controller(self._state))
        except PlantigradeError as error:  # the command was invalid
            self.paused, self.message = True, str(error)
            return
        self._history.append(world, *self._contact_forces())

    def _contact_forces(self) -> tuple[Array, Array]:
        """Return force and point of application at every contact sphere."""
        contacts = self.world.contacts
        external = contacts.external_forces([contacts.read_step(self.world.data)[0]])
        return external.force[0], external.point[0]

    def _current_frame(self) -> LiveFrame:
        world, data = self.world, self.world.data
        force, point = self._contact_forces()
        rope, line = self._hand.rope, None
        if rope is not None:
            line = np.array([rope.position(data), rope.end])
        return LiveFrame(
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
            pack_pose=self._session_world.load.pose(world),
            drawings=tuple(self._controller.drawings(self._state)),
            history=self._history.recent(),
            end_message=self._end_message(),
        )

    def _end_message(self) -> str:
        world = self.world
        if world.diverged is not None:
            return f"diverged at {world.diverged:.2f} s"
        if world.time > self.until - 1e-9:
            return f"paused at {self.until:g} s, the end of the session"
        return "" if world.fall is None else str(world.fall)

    def _placement(self) -> tuple[float, float, float]:
        """Return position and heading of the person."""
        root = self._state.qpos
        x, y = facing(root[3:7])
        return float(root[0]), float(root[1]), float(np.arctan2(y, x))


def run(session: Session, stop: Event, clock: Clock | None = None) -> None:
    """Run a session in real time until ``stop`` is set."""
    clock = clock or Clock()
    pace = LoopPace(RATE)
    clock.begin()
    while not stop.wait(pace.time_to_wait()):
        clock.mark_simulated(
            session.advance(clock.time_due(0.0 if session.paused else session.speed))
        )
