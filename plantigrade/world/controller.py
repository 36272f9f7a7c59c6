"""What moves a person: the contract of every controller, and what is made of a plain function.

::

    class Sway(Controller):
        rates = Rates(physics=1000.0, control=100.0)

        def __init__(self):
            self.targets = (Target("lean", -5.0, 5.0, 0.0, "deg"),)

        def __call__(self, state):
            lean = np.deg2rad(self.targets[0].value)
            ...

        def drawings(self, state):
            return (Drawing(name="goal", points=self.goal[None]),)

Everything but ``__call__`` has a default. A function ``controller(state) -> command`` is a
controller, too: :func:`controller_from` wraps it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Any, cast

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.options import shown
from plantigrade.world.command import Commanded
from plantigrade.world.offers import Drawing, Target
from plantigrade.world.state import State


@dataclass(frozen=True)
class Rates:
    """How often the physics steps, the controller is called, and a frame is kept.

    Attributes:
        physics: Steps of the physics per second, a multiple of the others [1/s].
        control: Commands per second [1/s].
        frames: Frames per second that are kept [1/s]; one per command if absent.
    """

    physics: float = 1800.0
    control: float = 100.0
    frames: float | None = None

    def changed(self, physics: float | None = None, control: float | None = None) -> "Rates":
        """Return rates of which a user has set some.

        With another rate of the physics alone, commands come as often as before or a little less
        often: the rate of the physics is a whole multiple. Every command then has its frame.

        Args:
            physics: Steps of the physics per second [1/s].
            control: Commands per second [1/s].
        """
        if physics is None and control is None:
            return self
        if control is None:
            control = physics / ceil(physics / self.control) if physics else self.control
        return Rates(physics or self.physics, float(control))


@dataclass(frozen=True, eq=False)
class InitialState:
    """How a person begins.

    Attributes:
        human: The person.
        ground: What they are on.
        qpos: Their configuration.
        qvel: Their velocity [m/s, rad/s].
    """

    human: Human
    ground: Ground
    qpos: Float[Array, " nq"]
    qvel: Float[Array, " nv"]


@dataclass(frozen=True)
class Summary:
    """What a controller did in the last simulation.

    Attributes:
        sentences: For a reader.
        figures: For ``metrics.json``: name, with its unit as suffix, and value.
    """

    sentences: tuple[str, ...] = ()
    figures: Mapping[str, Any] = field(default_factory=dict)


class Controller(ABC):
    """What moves a person: it is called with a state and returns a command.

    Attributes:
        rates: Rates that it needs.
        passive: Whether joints also resist by themselves, as tissue does.
        exact_limits: Whether limits of torque hold for all of stable PD
            (:class:`~plantigrade.world.World`).
        duration: How long it goes on where nobody says [s]; as long as its motion if absent.
        targets: Numbers that a slider or a script may change while it runs.
        settings: The numbers that were chosen for it, a frozen dataclass; None if it has none.
        shared: Objects that never change, and that copies of the controller have in common.
    """

    rates: Rates = Rates()
    passive: bool = True
    exact_limits: bool = True
    duration: float | None = None
    targets: Sequence[Target] = ()
    settings: Any = None
    shared: Sequence[object] = ()

    @abstractmethod
    def __call__(self, state: State) -> Commanded:
        """Return what the joints do for one control step."""

    @property
    def name(self) -> str:
        """The name under which runs know it."""
        return type(self).__name__

    def start(self, initial: InitialState) -> InitialState:
        """Return how the person begins, given how their motion does."""
        return initial

    def summary(self) -> Summary:
        """Return what it did in the last simulation."""
        return Summary()

    def drawings(self, state: State) -> Sequence[Drawing]:
        """Return points and lines to be drawn with a state."""
        return ()

    def follow(self, points: Float[Array, "n 2"]) -> bool:
        """Walk from point to point and stand at the last, if it can.

        Args:
            points: The points, world, without the start [m].

        Returns:
            Whether it can.
        """
        return False


class FunctionController(Controller):
    """A plain function as a controller.

    Args:
        function: Called with a state; returns a command.
    """

    def __init__(self, function: Callable[[State], Commanded]):
        self.function = function

    @property
    def name(self) -> str:
        """The name of the function."""
        return getattr(self.function, "__name__", type(self.function).__name__)

    def __call__(self, state: State) -> Commanded:
        """Return what the function commands."""
        return self.function(state)


class WrappedController(Controller):
    """A controller that changes what another one sees or commands; all else is the other's.

    Args:
        inner: The other controller.
    """

    def __init__(self, inner: Controller):
        self.inner = inner
        self.rates, self.passive = inner.rates, inner.passive
        self.exact_limits, self.duration = inner.exact_limits, inner.duration
        self.targets, self.settings, self.shared = inner.targets, inner.settings, inner.shared

    @property
    def name(self) -> str:
        """The name of the other controller."""
        return self.inner.name

    def __call__(self, state: State) -> Commanded:
        """Return what the other controller commands."""
        return self.inner(state)

    def start(self, initial: InitialState) -> InitialState:
        """Return how the other controller lets the person begin."""
        return self.inner.start(initial)

    def summary(self) -> Summary:
        """Return what the other controller did."""
        return self.inner.summary()

    def drawings(self, state: State) -> Sequence[Drawing]:
        """Return what the other controller draws."""
        return self.inner.drawings(state)

    def follow(self, points: Float[Array, "n 2"]) -> bool:
        """Let the other controller walk from point to point."""
        return self.inner.follow(points)


AnyController = Controller | Callable[[State], Commanded]
"""A controller, or a function that serves as one."""


def controller_from(given: Any) -> Controller:
    """Return a controller: itself, or a plain function that is wrapped.

    Raises:
        ParameterError: If it cannot be called.

    Example:
        >>> controller_from(lambda state: None).rates.control
        100.0
    """
    if isinstance(given, Controller):
        return given
    if isinstance(given, type) or not callable(given):
        raise ParameterError(
            f"a controller is a Controller or a function of a state, not {shown(given)}"
        )
    return FunctionController(cast("Callable[[State], Commanded]", given))
