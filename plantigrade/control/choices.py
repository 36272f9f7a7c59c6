"""The controllers that are chosen by name: one table for every command and page.

A controller of another kind is one more line of :data:`CONTROLLERS`.
"""

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.control.balance import (
    Balance,
    BalanceSettings,
    Hybrid,
    HybridSettings,
    MotionReference,
)
from plantigrade.control.gait.loads import LoadSettings
from plantigrade.control.gait.reference import period_of
from plantigrade.control.numbers import changed, numbers_of
from plantigrade.control.pendulum import Pendulum, PendulumSettings, WalkCommand, Walker, walk_of
from plantigrade.control.posture import Posture, PostureSettings, passive
from plantigrade.control.replay import Replay, ReplaySettings
from plantigrade.control.tracking import Tracking, TrackingSettings
from plantigrade.errors import ParameterError, known_names
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import runs
from plantigrade.options import refuse_unknown
from plantigrade.record import Record
from plantigrade.world import Controller


@dataclass(frozen=True, eq=False, kw_only=True)
class Situation:
    """The situation for which a controller is made.

    Attributes:
        human: The person.
        ground: The ground.
        motion: Motion to carry out, from its first frame on; None for standing.
        standing: Configuration of standing; None where there is a motion.
        record: The motion with its forces and its ground; None for standing.
        script: Foot motion to carry out, if any.
        walk: Command of a walk.
        settings: Settings of the controller.
    """

    human: Human
    ground: Ground
    motion: Motion | None = None
    standing: Float[Array, " nq"] | None = None
    record: Record | None = None
    script: MotionReference | None = None
    walk: WalkCommand | None = None
    settings: Any = None

    @property
    def reference(self) -> MotionReference | None:
        """Reference of balance, the script or the motion; None for the posture of the start.

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


@dataclass(frozen=True)
class ControllerKind:
    """A controller that is chosen by name."""

    make: Callable[[Situation], Controller]  #: Makes it for a situation
    settings: type | None = None  #: The class of its settings; None if it has none

    def with_settings(self, values: Mapping[str, Any], name: str) -> Any:
        """Return its settings, some of them changed.

        Args:
            values: Value by dotted name, such as ``{"swing.clearance": 0.05}``.
            name: Name of the controller, for the message.

        Raises:
            ParameterError: If there is no such setting, or it cannot have such a value.
        """
        if self.settings is None:
            refuse_unknown(name, values, ())
            return None
        return changed(self.settings(), values, name)


CONTROLLERS: Mapping[str, ControllerKind] = {
    "passive": ControllerKind(lambda at: passive),
    "posture": ControllerKind(
        lambda at: Posture(at.standing, settings=at.settings), PostureSettings
    ),
    "balance": ControllerKind(
        lambda at: Balance(at.reference, settings=at.settings), BalanceSettings
    ),
    "hybrid": ControllerKind(lambda at: Hybrid(settings=at.settings), HybridSettings),
    "stable-pd": ControllerKind(
        lambda at: Tracking(at.followed("stable-pd"), settings=at.settings), TrackingSettings
    ),
    "replay": ControllerKind(
        lambda at: Replay(at.recorded("replay"), settings=at.settings), ReplaySettings
    ),
    "pendulum": ControllerKind(
        lambda at: Walker(at.recorded("pendulum"), at.walk, settings=at.settings), PendulumSettings
    ),
}
"""Name of a controller → its factory and the class of its settings."""

STANDING, HELD, SCRIPTED = "posture", "stable-pd", "balance"
"""Defaults for standing, for the posture of a single frame, and for a foot motion or a motion on
one foot."""
WALKING, MOVING = "pendulum", "replay"
"""Defaults for a recorded walk, and for any other motion."""
MAX_PIVOT = 0.05  # [m] how far a foot that has not stepped moves: half of its width


def controller_named(
    name: str | None, situation: Situation, values: Mapping[str, Any] | None = None
) -> Controller:
    """Return a controller.

    Args:
        name: One of :data:`CONTROLLERS`; None for the default.
        situation: The situation for which it is made.
        values: Settings that differ from those of its class, by dotted name; those of other
            controllers are skipped.

    Raises:
        ParameterError: If there is no such controller, or it does not fit the situation.
    """
    word = checked(name or usual(situation.motion, situation.record, situation.script))
    settings = settings_among(values or {}, word)
    return CONTROLLERS[word].make(replace(situation, settings=settings))


def settings_among(values: Mapping[str, Any], name: str) -> Any:
    """Return the settings of a controller; values of settings of other controllers are skipped.

    Raises:
        ParameterError: If a setting cannot have such a value.
    """
    own = {each: value for each, value in values.items() if name in having(each)}
    return CONTROLLERS[name].with_settings(own, name)


def having(name: str) -> tuple[str, ...]:
    """Return the controllers that have a setting of this dotted name."""
    return tuple(word for word in CONTROLLERS if name in _names(word))


def typed_setting(word: str, name: str, value: Any) -> Any:
    """Return a value of a setting of a controller; a word becomes what the setting takes.

    Raises:
        ParameterError: If it cannot have such a value.
    """
    settings = CONTROLLERS[word].with_settings({name: value}, word)
    return next(each.value for each in numbers_of(settings) if each.name == name)


def nearest(name: str) -> str:
    """Return a question for the setting whose name is nearest; empty where none is near."""
    every = {each for word in CONTROLLERS for each in _names(word)}
    near = difflib.get_close_matches(name, sorted(every), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""


@cache
def _names(word: str) -> frozenset[str]:
    """Return the dotted names of all settings of a controller."""
    kind = CONTROLLERS[word].settings
    return frozenset(() if kind is None else (each.name for each in numbers_of(kind())))


def usual(
    motion: Motion | None, record: Record | None = None, script: MotionReference | None = None
) -> str:
    """Return the name of the controller that is taken where none is named.

    What was recorded moves no body exactly: feet slide, and forces do not fit the motion. A walk is
    therefore walked as recorded by a pendulum, which repeats a stride of it for as long as asked,
    and a person on one foot balances there; what was planned or simulated is carried out as it is,
    and so is any other motion.
    """
    if script is not None:
        return SCRIPTED
    if motion is None:
        return STANDING
    if record is None or motion.n_frames == 1:
        return HELD
    if record.has_forces and not any(site.measured for site in record.sites):
        return MOVING  # planned or simulated: it has the force of each contact sphere
    if _is_walk(record):
        return WALKING
    return SCRIPTED if _is_on_one_foot(record) else MOVING


def _is_on_one_foot(record: Record) -> bool:
    """Return whether one foot stays where it stands, and for a while bears the body alone."""
    limits = LoadSettings()
    soles = sole_paths(record.human, record.motion.qpos)
    low = soles.position[:, :, 2] - record.ground.height
    up = [low[:, soles.of(side)].min(axis=1) > limits.max_height for side in SIDES]
    for side, stands, other in zip(SIDES, up, reversed(up), strict=True):
        place = soles.position[:, soles.of(side), :2].mean(axis=1)
        stays = np.ptp(place, axis=0).max() < MAX_PIVOT
        alone = max((run.stop - run.start for run in runs(other)), default=0)
        if stays and not stands.any() and alone > limits.min_rest_time * record.motion.rate:
            return True
    return False


def _is_walk(record: Record) -> bool:
    """Return whether a motion is a walk that a pendulum can repeat.

    People who run or jump have both feet off the ground at times: in recordings by 2.5 to 42 cm,
    where the lower foot of walks is up by 5 mm at most.
    """
    try:
        walk = walk_of(record)
        Pendulum(walk)
    except ParameterError:
        return False
    soles = sole_paths(walk.human, walk.motion.qpos).position[:, :, 2] - walk.ground.height
    flies = soles.min(axis=1).max() > LoadSettings.max_height
    return period_of(walk)[0] is not None and not flies


def checked(name: str) -> str:
    """Return the name of a controller."""
    if name not in CONTROLLERS:
        raise ParameterError(f"no controller {name!r}; {known_names(name, list(CONTROLLERS))}")
    return name
