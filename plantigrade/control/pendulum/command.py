"""The command of a walk: speed, path and crouch over time, other walks and upper bodies."""

from dataclasses import dataclass

from plantigrade.control.pendulum.path import Path, Timed
from plantigrade.control.pendulum.upper_body import FixedPose
from plantigrade.record import Record

RECORDED = "recorded"  # Name of the upper body that is the walk's own


@dataclass(frozen=True, eq=False, kw_only=True)
class Style:
    """Another walk of the same person, or another motion or pose of their upper body."""

    name: str  #: Its name
    record: Record | None = None  #: The walk or motion; None where it is a pose
    pose: FixedPose | None = None  #: The pose
    time: float | None = None  #: When it begins [s]; None if only by hand


@dataclass(frozen=True, kw_only=True)
class WalkCommand:
    """The command of a walk.

    Attributes:
        speed: Desired speed [m/s]; as recorded if absent.
        path: Desired path; straight on if absent.
        stoop: Lowering of the head [cm]; as recorded if absent.
        own: Name of the recorded walk.
        walks: Other walks of the same person, and when they begin.
        uppers: Other motions and poses of spine, neck and arms, and when they begin.
    """

    speed: Timed | None = None
    path: Path | None = None
    stoop: Timed | None = None
    own: str = RECORDED
    walks: tuple[Style, ...] = ()
    uppers: tuple[Style, ...] = ()

    @property
    def leads(self) -> bool:
        """Whether the walk is to differ from the recorded one."""
        timed = any(style.time is not None for style in self.uppers)
        commands = (self.speed, self.path, self.stoop)
        return timed or bool(self.walks) or any(each is not None for each in commands)

    @property
    def changes(self) -> tuple[tuple[str, float], ...]:
        """Changes and their times [s]; of speeds, bearings and stoops the last."""
        kept = {"a speed": self.speed, "a bearing": self.path, "a stoop": self.stoop}
        found = [(name, max(each.times)) for name, each in kept.items() if each is not None]
        styles = (("another walk", self.walks), ("another upper body", self.uppers))
        return (*found, *((name, s.time) for name, own in styles for s in own if s.time))
