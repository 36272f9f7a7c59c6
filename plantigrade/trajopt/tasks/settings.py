"""Parameters of each task: one dataclass per task, whose fields are command line options.

Nothing here loads NumPy. Angles are in radians; the command line takes degrees. Defaults that
depend on the person, such as the height of a chair, are set where the task is built.
"""

from dataclasses import dataclass, fields
from typing import Any, Literal

from plantigrade.bounds import number
from plantigrade.errors import ParameterError, known_names
from plantigrade.options import Flag, Metres, Seconds, refuse_unknown
from plantigrade.trajopt.tasks.gait_settings import (
    HopSettings,
    RunSettings,
    WalkBackwardSettings,
    WalkSettings,
    WalkSidewaysSettings,
)
from plantigrade.trajopt.tasks.task_settings import MAX_DURATION, Side, Target, TaskSettings


@dataclass(frozen=True, kw_only=True)
class SitToStandSettings(TaskSettings):
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
class StandToSitSettings(SitToStandSettings):
    """Sit down on a chair."""


@dataclass(frozen=True, kw_only=True)
class GetUpSettings(TaskSettings):
    """Get up from the floor."""

    activity = "getting up from the floor"
    ranges = {"duration": (1.5, MAX_DURATION, "s")}

    begin: Literal["half-kneeling", "all-fours", "sitting", "lying"] = "all-fours"
    """Kneeling on one knee, on hands and knees, or sitting or lying on the back with stretched
    legs."""
    duration: Seconds = None
    """Duration, until standing [s]; by default 3 from one knee, 6 from hands and knees or lying, 5
    from sitting."""
    side: Side = "r"
    """Side of the foot ahead, the other knee being on the floor; or, from sitting or lying, of the
    foot that is drawn in first."""


@dataclass(frozen=True, kw_only=True)
class SquatSettings(TaskSettings):
    """Squat and stand up again."""

    activity = "a squat"
    ranges = {"depth": (0.01, 1, "m"), "duration": (0.6, MAX_DURATION, "s")}

    depth: Metres = None
    """Descent of the pelvis [m]; by default 0.2 of body height."""
    duration: float = 2.5
    """Duration [s]."""


@dataclass(frozen=True, kw_only=True)
class ReachSettings(TaskSettings):
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
        super().__post_init__()
        if self.target is not None:
            for x in self.target:
                number("target", x, -10, 10, "m", "reaching")


@dataclass(frozen=True, kw_only=True)
class LiftSettings(TaskSettings):
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
class SideStepSettings(TaskSettings):
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
class PushingSettings(TaskSettings):
    """Push-off of a jump."""

    activity = "a jump"
    times = ("push",)
    ranges = {"depth": (0.01, 1, "m"), "push": (0.4, 10, "s")}

    depth: Metres = None
    """Countermovement: descent of the pelvis [m]; by default 0.15 of body height."""
    push: float = 0.9
    """Time from standing still to take-off [s]."""


@dataclass(frozen=True, kw_only=True)
class JumpSettings(PushingSettings):
    """Jump from standing and land."""

    times = ("push", "landing")
    ranges = {
        **PushingSettings.ranges,
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
class TakeOffSettings(PushingSettings):
    """Jump as high as possible; ends in flight."""

    ranges = {
        **PushingSettings.ranges,
        "strength": (0.1, 2, "of a strong person's strength"),
        "gain": (0, 1e6, "1/m"),
    }

    strength: float = 0.62
    """Usable fraction of the joint strengths; 1 is a strong person, 0.62 an average one."""
    gain: float = 150.0
    """Weight of jump height in the cost [1/m]."""


@dataclass(frozen=True, kw_only=True)
class StandSettings(TaskSettings):
    """Stand on both feet; a base for your own tasks."""

    activity = "standing"
    ranges = {"duration": (0.1, 60, "s")}

    duration: float = 2.0
    """Duration [s]."""


TASKS: dict[str, type[TaskSettings]] = {
    "walk": WalkSettings,
    "walk-backward": WalkBackwardSettings,
    "walk-sideways": WalkSidewaysSettings,
    "run": RunSettings,
    "hop": HopSettings,
    "sit-to-stand": SitToStandSettings,
    "stand-to-sit": StandToSitSettings,
    "get-up": GetUpSettings,
    "squat": SquatSettings,
    "reach": ReachSettings,
    "lift": LiftSettings,
    "side-step": SideStepSettings,
    "jump": JumpSettings,
    "take-off": TakeOffSettings,
    "standing": StandSettings,
}
"""Name of a task → its parameters."""


def settings_for(name: str, **parameters: Any) -> TaskSettings:
    """Return the settings of a task by name."""
    if name not in TASKS:
        raise ParameterError(f"no task {name!r}; {known_names(name, list(TASKS))}")
    refuse_unknown(name, parameters, (f.name for f in fields(TASKS[name])))
    return TASKS[name](**parameters)
