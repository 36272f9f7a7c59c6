"""The interface of controllers, and the conversion of functions to controllers.

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

All members except ``__call__`` have defaults. A function ``controller(state) -> command`` may serve
as a controller; :func:`controller_from` wraps it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Any, cast

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.options import shown
from plantigrade.world.command import AnyCommand
from plantigrade.world.state import State


@dataclass(eq=False)
class Target:
    """A number that a slider or a script sets during a simulation.

    Attributes:
        name: Name of the target.
        low: Minimum.
        high: Maximum.
        value: Present value, which the controller reads at every call.
        unit: Unit as displayed, such as ``"deg"`` or ``"m/s"``; empty if dimensionless.
        names: Names of choices, numbered from zero; empty for a continuous target.

    Raises:
        ParameterError: If the value is not between minimum and maximum.
    """

    name: str
    low: float
    high: float
    value: float
    unit: str = ""
    names: tuple[str, ...] = ()

    def __post_init__(self):
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            raise ParameterError(f"{self.name}: {self.low:g} to {self.high:g} is not a range")
        self.set(self.value)

    def set(self, value: float) -> None:
        """Set the value.

        Raises:
            ParameterError: If the value is out of range.
        """
        if not self.low <= value <= self.high:  # also refuses NaN
            raise ParameterError(
                f"{self.name} must be {self.low:g}–{self.high:g} {self.unit}, not {value:g}"
            )
        self.value = float(value)


@dataclass(frozen=True, eq=False, kw_only=True)
class Drawing:
    """Points and lines in world axes.

    Attributes:
        name: Name of the drawing; it replaces an earlier one of the same name.
        points: Points [m].
        lines: Both end points of each line [m].
        colour: Hexadecimal colour, such as ``"#7e57c2"``.
    """

    name: str
    points: Float[Array, "n_points 3"] | None = None
    lines: Float[Array, "n_lines 2 3"] | None = None
    colour: str = "#7e57c2"


@dataclass(frozen=True)
class Rates:
    """Rates of physics, controller and recording.

    Attributes:
        physics: Steps of the physics per second, an integer multiple of the others [1/s].
        control: Commands per second [1/s].
        frames: Recorded frames per second [1/s]; one per command if absent.
    """

    physics: float = 1800.0
    control: float = 100.0
    frames: float | None = None

    def changed(self, physics: float | None = None, control: float | None = None) -> "Rates":
        """Return rates with some of them changed.

        If only the rate of the physics is given, the control rate becomes its largest divisor that
        does not exceed the present one. Every command then has a frame.

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
    """Initial state of a person.

    Attributes:
        human: The person.
        ground: The ground.
        qpos: Initial configuration.
        qvel: Initial velocity [m/s, rad/s].
    """

    human: Human
    ground: Ground
    qpos: Float[Array, " nq"]
    qvel: Float[Array, " nv"]


@dataclass(frozen=True)
class Summary:
    """Summary of the last simulation of a controller.

    Attributes:
        sentences: Sentences for a reader.
        figures: Figures for ``metrics.json``, by name with the unit as suffix.
    """

    sentences: tuple[str, ...] = ()
    figures: Mapping[str, Any] = field(default_factory=dict)


class Controller(ABC):
    """Base class of controllers: called with a state, it returns a command.

    Attributes:
        rates: Rates that the controller needs.
        passive: Whether joints have passive moments of tissue.
        exact_limits: Whether torque limits include the implicit part of stable PD
            (:class:`~plantigrade.world.World`).
        duration: Default duration [s]; that of its motion if absent.
        targets: Numbers that a slider or a script may change during a simulation.
        settings: Settings of the controller, a frozen dataclass; None if it has none.
        shared: Immutable objects that copies of the controller share.
    """

    rates: Rates = Rates()
    passive: bool = True
    exact_limits: bool = True
    duration: float | None = None
    targets: Sequence[Target] = ()
    settings: Any = None
    shared: Sequence[object] = ()

    @abstractmethod
    def __call__(self, state: State) -> AnyCommand:
        """Return the command for one control step."""

    @property
    def name(self) -> str:
        """Name of the controller in runs."""
        return type(self).__name__

    def start(self, initial: InitialState) -> InitialState:
        """Return the initial state, given the one of the scene or motion."""
        return initial

    def summary(self) -> Summary:
        """Return a summary of the last simulation."""
        return Summary()

    def drawings(self, state: State) -> Sequence[Drawing]:
        """Return points and lines to draw with a state."""
        return ()

    def follow(self, points: Float[Array, "n 2"]) -> bool:
        """Walk from point to point and stand at the last one.

        Args:
            points: Points of the path, world, without the start [m].

        Returns:
            Whether the controller can follow a path.
        """
        return False


class FunctionController(Controller):
    """A function as a controller."""

    def __init__(self, function: Callable[[State], AnyCommand]):
        self.function = function

    @property
    def name(self) -> str:
        """The name of the function."""
        return getattr(self.function, "__name__", type(self.function).__name__)

    def __call__(self, state: State) -> AnyCommand:
        """Return the command of the function."""
        return self.function(state)


class WrappedController(Controller):
    """Base class of wrappers, which change the state or the command of another controller.

    Args:
        inner: The wrapped controller.
    """

    def __init__(self, inner: Controller):
        self.inner = inner
        self.rates, self.passive = inner.rates, inner.passive
        self.exact_limits, self.duration = inner.exact_limits, inner.duration
        self.targets, self.settings, self.shared = inner.targets, inner.settings, inner.shared

    @property
    def name(self) -> str:
        """Name of the wrapped controller."""
        return self.inner.name

    def __call__(self, state: State) -> AnyCommand:
        """Return the command of the wrapped controller."""
        return self.inner(state)

    def start(self, initial: InitialState) -> InitialState:
        """Return the initial state of the wrapped controller."""
        return self.inner.start(initial)

    def summary(self) -> Summary:
        """Return the summary of the wrapped controller."""
        return self.inner.summary()

    def drawings(self, state: State) -> Sequence[Drawing]:
        """Return the drawings of the wrapped controller."""
        return self.inner.drawings(state)

    def follow(self, points: Float[Array, "n 2"]) -> bool:
        """Pass the path to the wrapped controller."""
        return self.inner.follow(points)


AnyController = Controller | Callable[[State], AnyCommand]
"""A controller, or a function that serves as one."""


def controller_from(given: Any) -> Controller:
    """Return a controller; a function is wrapped.

    Raises:
        ParameterError: If the argument is not callable.

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
    return FunctionController(cast("Callable[[State], AnyCommand]", given))
