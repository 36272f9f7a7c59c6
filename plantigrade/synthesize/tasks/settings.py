"""What each task may be told: one dataclass per task, its fields the options of the command.

Nothing here loads NumPy. Angles are in radians; the command line takes degrees. What depends on the
person (how high is a chair?) is checked where the task is made.
"""

from dataclasses import dataclass, fields
from typing import Annotated, Any, Literal

from plantigrade.bounds import Bounded, number, word
from plantigrade.errors import ParameterError
from plantigrade.options import (
    Cadence,
    Degrees,
    Flag,
    Metres,
    optional,
    refuse_unknown,
)

Side = Literal["r", "l"]
Heights = Annotated[tuple[float, ...] | None, optional("METRES [METRES ...]")]
Target = Annotated[tuple[float, float, float] | None, optional("X Y Z")]
Basis = Annotated[
    Literal["trigonometric", "polynomial"] | None, optional("{trigonometric,polynomial}")
]

SLOWEST, FASTEST = 0.3, 2.2
"""Walking speeds [m/s]."""
LONGEST = 20.0
"""Of a movement in place [s]."""


@dataclass(frozen=True, kw_only=True)
class TaskSettings(Bounded):
    """What every task may be told; values out of range raise a ParameterError."""

    def __post_init__(self):
        """Refuse values of another type, or out of range."""
        super().__post_init__()
        if "side" in (f.name for f in fields(self)):
            word("side", getattr(self, "side"), ("r", "l"))  # noqa: B009

    @property
    def told(self) -> dict[str, Any]:
        """What differs from the defaults, by name."""
        given = ((f, getattr(self, f.name)) for f in fields(self))
        return {f.name: value for f, value in given if value != f.default}


@dataclass(frozen=True, kw_only=True)
class Walk(TaskSettings):
    """Walk from standing to standing, or periodically; straight, turning, up and down."""

    activity = "walking"
    ranges = {
        "speed": (SLOWEST, FASTEST, "m/s"),
        "step_length": (0.01, 3, "m"),
        "cadence": (10, 400, "steps/min"),
        "steps": (2, 200, ""),
        "turn": (-720, 720, "degrees"),
        "slope": (-20, 20, "degrees"),
        "step_height": (-1, 1, "m"),
        "strides": (1, 100, ""),
    }

    speed: float = 1.3
    """Walking speed [m/s]."""
    periodic: Flag = False
    """Walk periodically instead of from standing to standing."""
    steps: int = 4
    """Steps of a walk from standing to standing."""
    step_length: Metres = None
    """From foot to foot [m]; what people prefer at the speed if absent."""
    cadence: Cadence = None
    """Cadence instead of the step length [steps/min]."""
    turn: Degrees = 0.0
    """How far the path turns to the left [deg]."""
    slope: Degrees = 0.0
    """How far the ground rises along the path, negative downhill [deg]."""
    step_height: float = 0.0
    """Height of a step up in the middle of the path, down if negative [m]."""
    heights: Heights = None
    """Height of the ground under each step instead [m]."""
    optimise_timing: Flag = False
    """Let a periodic walk choose its own step length, stance and heel rise."""
    strides: int = 2
    """Strides of a periodic walk to write."""

    def __post_init__(self):
        """Refuse what nobody walks."""
        super().__post_init__()
        if self.optimise_timing and not self.periodic:
            raise ParameterError("only a periodic walk chooses its own timing: add periodic")
        if self.strides != Walk.strides and not self.periodic:
            raise ParameterError("strides are those of a periodic walk: add periodic or give steps")
        if self.steps != Walk.steps and self.periodic:
            raise ParameterError("a periodic walk has no number of steps: give strides instead")
        uneven = self.step_height or self.heights is not None
        if self.periodic and (self.turn or uneven):
            raise ParameterError(
                "a periodic walk goes straight on even ground: leave out turn and heights, or "
                "leave out periodic"
            )
        if self.slope and self.turn:
            raise ParameterError("a walk turns or goes up a slope, not both: give slope or turn")
        if self.turn and uneven:
            raise ParameterError("a walk turns or climbs, not both: give turn or heights")
        for height in self.heights or ():
            number("a height", height, -20, 20, "m", "walking")
        if self.step_height and self.heights is not None:
            raise ParameterError("give step_height or heights, not both")


@dataclass(frozen=True, kw_only=True)
class SitToStand(TaskSettings):
    """Rise from a chair."""

    activity = "standing up or sitting down"
    ranges = {
        "chair_height": (0.1, 2, "m"),
        "duration": (0.5, LONGEST, "s"),
        "seat_off": (0.1, 0.8, "of the duration"),
    }

    chair_height: Metres = None
    """Height of the seat [m]; nine tenths of the knee's height if absent."""
    duration: float = 2.0
    """From sitting still to standing still [s]; 1.5 to 3.5 s in studies."""
    seat_off: float = 0.35
    """When the seat is left, as a part of the duration."""


@dataclass(frozen=True, kw_only=True)
class StandToSit(SitToStand):
    """Sit down on a chair: standing up in reverse."""


@dataclass(frozen=True, kw_only=True)
class Squat(TaskSettings):
    """Squat and come up again."""

    activity = "a squat"
    ranges = {"depth": (0.01, 1, "m"), "duration": (0.6, LONGEST, "s")}

    depth: Metres = None
    """How far the pelvis goes down [m]; a fifth of stature if absent."""
    duration: float = 2.5
    """From standing to standing [s]."""


@dataclass(frozen=True, kw_only=True)
class Reach(TaskSettings):
    """Reach for a place with one hand, the feet where they are."""

    activity = "reaching"
    ranges = {"duration": (0.3, LONGEST, "s")}

    target: Target = None
    """Place of the middle of the hand, world [m]; straight ahead at shoulder height, a tenth of
    stature beyond the arm, if absent."""
    side: Side = "r"
    """Which hand."""
    duration: float = 1.5
    """From standing still to the hand at rest on its target [s]."""
    back: Flag = False
    """Stand up again afterwards, in the same time."""

    def __post_init__(self):
        """Refuse what nobody does."""
        super().__post_init__()
        if self.target is not None:
            for x in self.target:
                number("target", x, -10, 10, "m", "reaching")


@dataclass(frozen=True, kw_only=True)
class SideStep(TaskSettings):
    """Step to the side: one foot, then the other beside it."""

    activity = "a side step"
    ranges = {
        "distance": (0.02, 1, "m"),
        "duration": (0.8, LONGEST, "s"),
        "clearance": (0, 0.3, "m"),
    }

    distance: float = 0.3
    """How far [m]."""
    side: Side = "r"
    """To which side; that foot goes first."""
    duration: float = 2.4
    """From standing to standing [s]."""
    clearance: float = 0.02
    """Height of the sole in the middle of a swing [m]."""


@dataclass(frozen=True, kw_only=True)
class Pushing(TaskSettings):
    """How a jump starts."""

    activity = "a jump"
    ranges = {"depth": (0.01, 1, "m"), "push": (0.4, 10, "s")}

    depth: Metres = None
    """How far the pelvis goes down before the push [m]; 0.15 of stature if absent."""
    push: float = 0.9
    """From standing still to take-off [s]."""


@dataclass(frozen=True, kw_only=True)
class Jump(Pushing):
    """Jump from standing and land."""

    ranges = {
        **Pushing.ranges,
        "jump_height": (0.02, 1.2, "m"),
        "distance": (-1.2, 1.2, "m"),
        "landing": (0.4, 10, "s"),
    }

    jump_height: float = 0.25
    """How far the centre of mass rises after take-off [m]; 0.3 to 0.4 m is a good jump."""
    distance: float = 0.0
    """How far ahead the feet land [m]."""
    landing: float = 0.9
    """From landing to standing still [s]."""


@dataclass(frozen=True, kw_only=True)
class TakeOff(Pushing):
    """Leave the ground as high as can be; ends in the air."""

    ranges = {
        **Pushing.ranges,
        "strength": (0.1, 2, "of a strong person's strength"),
        "gain": (0, 1e6, "1/m"),
    }

    strength: float = 0.62
    """Part of the joint strengths that may be used; 1 is a strong person, 0.62 an average one."""
    gain: float = 150.0
    """What a metre of height takes from the cost."""


@dataclass(frozen=True, kw_only=True)
class Stand(TaskSettings):
    """Stand on both feet: nothing else, to build a task of your own on."""

    activity = "standing"
    ranges = {"duration": (0.1, 60, "s")}

    duration: float = 2.0
    """How long [s]."""


TASKS: dict[str, type[TaskSettings]] = {
    "walk": Walk,
    "sit-to-stand": SitToStand,
    "stand-to-sit": StandToSit,
    "squat": Squat,
    "reach": Reach,
    "side-step": SideStep,
    "jump": Jump,
    "take-off": TakeOff,
    "standing": Stand,
}
"""Name of a task → what it may be told."""


def settings_for(name: str, **told: Any) -> TaskSettings:
    """Return the settings of a task by name.

    Raises:
        ParameterError: If there is no such task or parameter, or a value is out of range.
    """
    if name not in TASKS:
        raise ParameterError(f"no task {name!r}; there are {', '.join(TASKS)}")
    refuse_unknown(name, told, (f.name for f in fields(TASKS[name])))
    return TASKS[name](**told)
