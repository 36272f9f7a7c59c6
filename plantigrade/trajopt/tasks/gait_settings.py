"""Parameters of gaits: walking in every direction, running, hopping."""

from dataclasses import dataclass
from typing import Literal

from plantigrade.bounds import number, word
from plantigrade.errors import ParameterError
from plantigrade.options import Cadence, Degrees, Flag, Metres, Seconds
from plantigrade.trajopt.tasks.task_settings import (
    MAX_WALKING_SPEED,
    MIN_WALKING_SPEED,
    Heights,
    Side,
    TaskSettings,
)


@dataclass(frozen=True, kw_only=True)
class WalkSettings(TaskSettings):
    """Walk, from standing to standing or periodically; straight, turning, uphill or on steps."""

    activity = "walking"
    times = ("step_length", "cadence")
    ranges = {
        "speed": (MIN_WALKING_SPEED, MAX_WALKING_SPEED, "m/s"),
        "step_length": (0.01, 3, "m"),
        "cadence": (10, 400, "steps/min"),
        "steps": (2, 200, ""),
        "turn": (-720, 720, "degrees"),
        "slope": (-20, 20, "degrees"),
        "step_height": (-1, 1, "m"),
        "obstacle_height": (0, 0.5, "m"),
        "cart_force": (0, 400, "N"),
        "strides": (1, 100, ""),
    }

    speed: float = 1.3
    """Walking speed [m/s]."""
    periodic: Flag = False
    """Periodic gait instead of a walk from standing to standing."""
    steps: int = 4
    """Number of steps of a walk from standing to standing."""
    step_length: Metres = None
    """Step length [m]; by default what people prefer at this speed."""
    cadence: Cadence = None
    """Cadence [steps/min], instead of a step length."""
    turn: Degrees = 0.0
    """Total turn of the path, positive to the left [deg]."""
    slope: Degrees = 0.0
    """Slope of the ground along the path, negative downhill [deg]."""
    step_height: float = 0.0
    """Height of a single step in the middle of the path, negative down [m]."""
    heights: Heights = None
    """Height of the ground under each step [m], instead of a single step."""
    obstacle_height: float = 0.0
    """Height of a block in the middle of the path, to step over [m]."""
    cart_force: float = 0.0
    """Force on the handle of a cart that both hands push, in a periodic walk [N]."""
    optimise_timing: Flag = False
    """Optimise step length, stance duration and heel rise of a periodic walk."""
    strides: int = 2
    """Number of strides of a periodic walk to write."""

    def __post_init__(self):
        super().__post_init__()
        for name in ("optimise_timing", "cart_force"):
            if getattr(self, name) and not self.periodic:
                raise ParameterError(f"{name} needs periodic")
        if self.cart_force and (self.slope or self.optimise_timing):
            raise ParameterError("a cart is pushed on level ground, with the usual timing")
        if self.strides != WalkSettings.strides and not self.periodic:
            raise ParameterError("strides needs periodic; without it give steps")
        if self.steps != WalkSettings.steps and self.periodic:
            raise ParameterError("a periodic walk has no number of steps; give strides instead")
        uneven = self.step_height or self.heights is not None or self.obstacle_height
        if self.periodic and (self.turn or uneven):
            raise ParameterError(
                "a periodic walk is straight and on even ground: leave out turn and heights, or "
                "periodic"
            )
        if self.slope and self.turn:
            raise ParameterError("turn and slope cannot be combined; give one")
        if self.turn and uneven:
            raise ParameterError("turn and heights cannot be combined; give one")
        for height in self.heights or ():
            number("a height", height, -20, 20, "m", "walking")
        if self.step_height and self.heights is not None:
            raise ParameterError("step_height and heights cannot be combined; give one")


@dataclass(frozen=True, kw_only=True)
class WalkBackwardSettings(TaskSettings):
    """Walk backward, periodically and straight."""

    activity = "walking backward"
    times = ("step_length", "cadence")
    ranges = {
        "speed": (MIN_WALKING_SPEED, 1.6, "m/s"),
        "step_length": (0.01, 3, "m"),
        "cadence": (10, 400, "steps/min"),
        "strides": (1, 100, ""),
    }

    speed: float = 0.95
    """Walking speed [m/s]."""
    step_length: Metres = None
    """Step length [m]; by default 0.85 of that of walking forward at this speed."""
    cadence: Cadence = None
    """Cadence [steps/min], instead of a step length."""
    strides: int = 2
    """Number of strides to write."""


@dataclass(frozen=True, kw_only=True)
class WalkSidewaysSettings(TaskSettings):
    """Walk sideways, periodically: one foot steps out, the other closes."""

    activity = "walking sideways"
    times = ("cadence",)
    ranges = {
        "speed": (0.1, 1.0, "m/s"),
        "cadence": (30, 200, "steps/min"),
        "strides": (1, 100, ""),
    }

    speed: float = 0.57
    """Walking speed [m/s]; people choose 0.57."""
    side: Side = "r"
    """Direction; that foot leads."""
    cadence: Cadence = None
    """Cadence [steps/min], two steps a stride; by default so that strides are 0.6 of the leg."""
    strides: int = 3
    """Number of strides to write."""


@dataclass(frozen=True, kw_only=True)
class RunSettings(TaskSettings):
    """Run, periodically and straight, with flight between the steps."""

    activity = "running"
    times = ("cadence", "contact_time")
    ranges = {"speed": (2.0, 5.0, "m/s"), "cadence": (120, 240, "steps/min"),
              "contact_time": (0.1, 0.5, "s"), "strides": (1, 100, "")}  # fmt: skip

    speed: float = 3.0
    """Running speed [m/s]."""
    cadence: Cadence = None
    """Cadence [steps/min]; by default what runners prefer at this speed."""
    contact_time: Seconds = None
    """Time of a foot on the ground [s]; by default what runners have at this speed."""
    strides: int = 2
    """Number of strides to write."""


@dataclass(frozen=True, kw_only=True)
class HopSettings(TaskSettings):
    """Hop on the spot, on both legs or on one."""

    activity = "hopping"
    times = ("hops_per_minute",)
    ranges = {"hop_height": (0.01, 0.3, "m"), "hops_per_minute": (60, 240, ""),
              "strides": (1, 100, "")}  # fmt: skip

    legs: Literal["both", "r", "l"] = "both"
    """Legs to hop on."""
    hop_height: float = 0.05
    """Rise of the centre of mass in flight [m]."""
    hops_per_minute: float = 132.0
    """Hops per minute; people choose about 132."""
    strides: int = 4
    """Number of hops to write."""

    def __post_init__(self):
        super().__post_init__()
        word("legs", self.legs, ("both", "r", "l"))
