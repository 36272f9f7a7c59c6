"""Parameters of each task: one dataclass per task, whose fields are command line options.

Nothing here loads NumPy. Angles are in radians; the command line takes degrees. Defaults that
depend on the person, such as the height of a chair, are set where the task is built.
"""

from dataclasses import dataclass, fields
from typing import Annotated, Any, ClassVar, Literal

from plantigrade.bounds import Bounded, number, word
from plantigrade.errors import ParameterError, known_names
from plantigrade.options import (
    Cadence,
    Degrees,
    Flag,
    Metres,
    Seconds,
    optional,
    refuse_unknown,
)

Side = Literal["r", "l"]
Heights = Annotated[tuple[float, ...] | None, optional("METRES [METRES ...]")]
Target = Annotated[tuple[float, float, float] | None, optional("X Y Z")]
Basis = Annotated[
    Literal["trigonometric", "polynomial"] | None, optional("{trigonometric,polynomial}")
]

MIN_WALKING_SPEED = 0.3  #: Minimum walking speed [m/s]
MAX_WALKING_SPEED = 2.2  #: Maximum walking speed [m/s]
MAX_DURATION = 20.0  #: Maximum duration of a movement in place [s]


@dataclass(frozen=True, kw_only=True)
class TaskSettings(Bounded):
    """Parameters of a task; values out of range raise a ParameterError."""

    times: ClassVar[tuple[str, ...]] = ("duration",)
    """Parameters that set times, which may be free."""

    def __post_init__(self):
        """Refuse values of another type, or out of range."""
        super().__post_init__()
        if "side" in (f.name for f in fields(self)):
            word("side", getattr(self, "side"), ("r", "l"))  # noqa: B009

    @property
    def changed(self) -> dict[str, Any]:
        """Parameters that differ from their defaults, by name."""
        given = ((f, getattr(self, f.name)) for f in fields(self))
        return {f.name: value for f, value in given if value != f.default}


@dataclass(frozen=True, kw_only=True)
class Walk(TaskSettings):
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
        """Refuse combinations that make no walk."""
        super().__post_init__()
        for name in ("optimise_timing", "cart_force"):
            if getattr(self, name) and not self.periodic:
                raise ParameterError(f"{name} needs periodic")
        if self.cart_force and (self.slope or self.optimise_timing):
            raise ParameterError("a cart is pushed on level ground, with the usual timing")
        if self.strides != Walk.strides and not self.periodic:
            raise ParameterError("strides needs periodic; without it give steps")
        if self.steps != Walk.steps and self.periodic:
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
class WalkBackward(TaskSettings):
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
class WalkSideways(TaskSettings):
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
class Run(TaskSettings):
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
class Hop(TaskSettings):
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
        """Refuse legs that nobody has."""
        super().__post_init__()
        word("legs", self.legs, ("both", "r", "l"))


@dataclass(frozen=True, kw_only=True)
class SitToStand(TaskSettings):
    """Rise from a chair."""

    activity = "standing up or sitting down"
    times = ("duration", "seat_off")
    ranges = {
        "chair_height": (0.1, 2, "m"),
        "duration": (0.5, MAX_DURATION, "s"),
        "seat_off": (0.1, 0.8, "of the duration"),
    }

    chair_height: Metres = None
    """Seat height [m]; by default 0.9 of knee height."""
    duration: float = 2.0
    """Duration, from rest to rest [s]; 1.5 to 3.5 s in studies."""
    seat_off: float = 0.35
    """Time of seat-off, as a fraction of the duration."""
    armrests: Flag = False
    """Both hands push on armrests, until half the way from seat-off to the end."""


@dataclass(frozen=True, kw_only=True)
class StandToSit(SitToStand):
    """Sit down on a chair."""


@dataclass(frozen=True, kw_only=True)
class GetUp(TaskSettings):
    """Get up from the floor."""

    activity = "getting up from the floor"
    ranges = {"duration": (1.5, MAX_DURATION, "s")}

    begin: Literal["half-kneeling", "all-fours", "sitting"] = "all-fours"
    """Kneeling on one knee, on hands and knees, or sitting with stretched legs."""
    duration: Seconds = None
    """Duration, until standing [s]; by default 3 from one knee, 6 from hands and knees, 5 from
    sitting."""
    side: Side = "r"
    """Side of the foot ahead, the other knee being on the floor; or, from sitting, that is drawn in
    first."""


@dataclass(frozen=True, kw_only=True)
class Squat(TaskSettings):
    """Squat and stand up again."""

    activity = "a squat"
    ranges = {"depth": (0.01, 1, "m"), "duration": (0.6, MAX_DURATION, "s")}

    depth: Metres = None
    """Descent of the pelvis [m]; by default 0.2 of body height."""
    duration: float = 2.5
    """Duration [s]."""


@dataclass(frozen=True, kw_only=True)
class Reach(TaskSettings):
    """Reach for a target with one hand, without stepping."""

    activity = "reaching"
    ranges = {"duration": (0.3, MAX_DURATION, "s")}

    target: Target = None
    """Target of the hand, world axes [m]; by default straight ahead at shoulder height, 0.1 of body
    height beyond the arm."""
    side: Side = "r"
    """Hand that reaches."""
    duration: float = 1.5
    """Duration, from standing still to the hand at rest on its target [s]."""
    back: Flag = False
    """Return to standing afterwards, in the same time."""

    def __post_init__(self):
        """Refuse targets out of range."""
        super().__post_init__()
        if self.target is not None:
            for x in self.target:
                number("target", x, -10, 10, "m", "reaching")


@dataclass(frozen=True, kw_only=True)
class Lift(TaskSettings):
    """Lift a box with both hands from the floor onto a table."""

    activity = "lifting a box"
    ranges = {
        "box_mass": (0, 20, "kg"),
        "table_height": (0.3, 1.2, "m"),
        "duration": (2.5, MAX_DURATION, "s"),
    }

    box_mass: float = 10.0
    """Mass of the box [kg]."""
    table_height: float = 0.72
    """Height of the table [m]."""
    duration: float = 4.0
    """Duration, from standing to standing [s]."""


@dataclass(frozen=True, kw_only=True)
class SideStep(TaskSettings):
    """Step sideways with one foot, then the other."""

    activity = "a side step"
    ranges = {
        "distance": (0.02, 1, "m"),
        "duration": (0.8, MAX_DURATION, "s"),
        "clearance": (0, 0.3, "m"),
    }

    distance: float = 0.3
    """Distance [m]."""
    side: Side = "r"
    """Direction; that foot steps first."""
    duration: float = 2.4
    """Duration [s]."""
    clearance: float = 0.02
    """Foot clearance at mid-swing [m]."""


@dataclass(frozen=True, kw_only=True)
class Pushing(TaskSettings):
    """Push-off of a jump."""

    activity = "a jump"
    times = ("push",)
    ranges = {"depth": (0.01, 1, "m"), "push": (0.4, 10, "s")}

    depth: Metres = None
    """Countermovement: descent of the pelvis [m]; by default 0.15 of body height."""
    push: float = 0.9
    """Time from standing still to take-off [s]."""


@dataclass(frozen=True, kw_only=True)
class Jump(Pushing):
    """Jump from standing and land."""

    times = ("push", "landing")
    ranges = {
        **Pushing.ranges,
        "jump_height": (0.02, 1.2, "m"),
        "distance": (-1.2, 1.2, "m"),
        "landing": (0.4, 10, "s"),
    }

    jump_height: float = 0.25
    """Rise of the centre of mass after take-off [m]; 0.3 to 0.4 m is a good jump."""
    distance: float = 0.0
    """Forward distance of the jump [m]."""
    landing: float = 0.9
    """Time from landing to standing still [s]."""


@dataclass(frozen=True, kw_only=True)
class TakeOff(Pushing):
    """Jump as high as possible; ends in flight."""

    ranges = {
        **Pushing.ranges,
        "strength": (0.1, 2, "of a strong person's strength"),
        "gain": (0, 1e6, "1/m"),
    }

    strength: float = 0.62
    """Usable fraction of the joint strengths; 1 is a strong person, 0.62 an average one."""
    gain: float = 150.0
    """Weight of jump height in the cost [1/m]."""


@dataclass(frozen=True, kw_only=True)
class Stand(TaskSettings):
    """Stand on both feet; a base for your own tasks."""

    activity = "standing"
    ranges = {"duration": (0.1, 60, "s")}

    duration: float = 2.0
    """Duration [s]."""


TASKS: dict[str, type[TaskSettings]] = {
    "walk": Walk,
    "walk-backward": WalkBackward,
    "walk-sideways": WalkSideways,
    "run": Run,
    "hop": Hop,
    "sit-to-stand": SitToStand,
    "stand-to-sit": StandToSit,
    "get-up": GetUp,
    "squat": Squat,
    "reach": Reach,
    "lift": Lift,
    "side-step": SideStep,
    "jump": Jump,
    "take-off": TakeOff,
    "standing": Stand,
}
"""Name of a task → its parameters."""


def settings_for(name: str, **parameters: Any) -> TaskSettings:
    """Return the settings of a task by name."""
    if name not in TASKS:
        raise ParameterError(f"no task {name!r}; {known_names(name, list(TASKS))}")
    refuse_unknown(name, parameters, (f.name for f in fields(TASKS[name])))
    return TASKS[name](**parameters)
