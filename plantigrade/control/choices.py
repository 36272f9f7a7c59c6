"""The controllers that are chosen by name: one table for every command and page.

A controller of another kind is one more line of :data:`CONTROLLERS`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.control.balance import Balance, BalanceSettings, Hybrid, MotionReference
from plantigrade.control.pendulum import WalkCommand, Walker
from plantigrade.control.posture import Posture, PostureSettings, passive
from plantigrade.control.replay import Replay
from plantigrade.control.tracking import Tracking, TrackingSettings
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.world import Controller


@dataclass(frozen=True, eq=False, kw_only=True)
class Situation:
    """What a controller is made for.

    Attributes:
        human: The person.
        ground: What they are on.
        motion: What they are to do, its first frame being the start; None where they just stand.
        standing: The configuration in which they stand; None where there is a motion.
        stiffness: Of springs, by what is usual.
        record: The motion with its forces and its ground; None where they just stand.
        script: The foot motion they are to do; None where it is none.
        stepping: Whether they may step where standing in place can no longer succeed.
        walk: What a walk is commanded.
    """

    human: Human
    ground: Ground
    motion: Motion | None = None
    standing: Float[Array, " nq"] | None = None
    stiffness: float = 1.0
    record: Record | None = None
    script: MotionReference | None = None
    stepping: bool = False
    walk: WalkCommand | None = None

    @property
    def reference(self) -> MotionReference | None:
        """What is balanced on: the script or the motion; None for the posture of the start.

        A motion of one frame is a posture, too.
        """
        if self.script is not None or self.motion is None or self.motion.n_frames == 1:
            return self.script
        return MotionReference(self.human, self.motion, ground=self.ground)

    def recorded(self, name: str) -> Record:
        """Return the motion with its forces.

        Raises:
            ParameterError: If there is none; ``name`` is the controller that carries it out.
        """
        if self.record is None:
            raise ParameterError(
                f"{name} needs a motion: give a run or a recording, or use controller=posture to "
                "stand"
            )
        return self.record

    def followed(self, name: str) -> Motion:
        """Return the motion.

        Raises:
            ParameterError: If there is none; ``name`` is the controller that follows one.
        """
        if self.motion is None:
            raise ParameterError(
                f"{name} needs a motion: give a recording or a run, or use controller=posture to "
                "stand"
            )
        return self.motion


CONTROLLERS: Mapping[str, Callable[[Situation], Controller]] = {
    "passive": lambda at: passive,
    "posture": lambda at: Posture(at.standing, settings=PostureSettings(stiffness=at.stiffness)),
    "balance": lambda at: Balance(at.reference, settings=BalanceSettings(stepping=at.stepping)),
    "hybrid": lambda at: Hybrid(),
    "stable-pd": lambda at: Tracking(
        at.followed("stable-pd"), settings=TrackingSettings(stiffness=at.stiffness)
    ),
    "replay": lambda at: Replay(at.recorded("replay")),
    "pendulum": lambda at: Walker(at.recorded("pendulum"), at.walk),
}
"""Name of a controller → how it is made."""

STANDING, MOVING, FORCED, SCRIPTED = "posture", "stable-pd", "replay", "balance"
"""What is taken where none is named: for who stands, for a motion, and for one with its forces."""


def controller_named(name: str | None, situation: Situation) -> Controller:
    """Return a controller.

    Args:
        name: One of :data:`CONTROLLERS`; None for what is usual.
        situation: What it is made for.

    Raises:
        ParameterError: If there is no such controller, or it does not fit the situation.
    """
    return CONTROLLERS[
        checked(name or usual(situation.motion, situation.record, situation.script))
    ](situation)


def usual(
    motion: Motion | None, record: Record | None = None, script: MotionReference | None = None
) -> str:
    """Return the name of the controller that is taken where none is named."""
    if script is not None:
        return SCRIPTED
    if motion is None:
        return STANDING
    return FORCED if record is not None and record.has_forces else MOVING


def checked(name: str) -> str:
    """Return the name of a controller.

    Raises:
        ParameterError: If there is none of that name.
    """
    if name not in CONTROLLERS:
        raise ParameterError(f"no controller {name!r}; there are {', '.join(CONTROLLERS)}")
    return name
