"""Commands that a browser may send to a live session; anything else is refused.

A message is JSON: ``{"do": NAME, …}`` with exactly the arguments of the command of that name, each
within its range. Our page sends no other; what is refused is damaged or comes from another program.
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from threading import Event
from typing import Any

import numpy as np

from plantigrade.control import CONTROLLERS
from plantigrade.live.session import SPEEDS, Session
from plantigrade.models.feet import FEET
from plantigrade.models.joint_sets import JOINT_SETS
from plantigrade.options import is_real

FORCE = (0.0, 1000.0)  # [N] of a push and of the rope; 1000 N throws a person over
DIRECTION = (-180.0, 180.0)  # [°] of a push, 0 forward, 90 to the left
DURATION = (0.05, 1.0)  # [s] of a push, from a blow to a shove
SLOPE = (-15.0, 15.0)  # [°] of the ground; steeper than a ramp for wheelchairs (5°)
FRICTION = (0.05, 1.5)  # [1] from wet ice to a rubber sole on a dry floor
MAX_LOAD = 40.0  # [kg] on the back, a heavy trekking pack
FIRST_JOINT = "ankle_angle_r"  # Joint whose curves are shown at first, with that of the other side

Check = Callable[[Any], bool]


@dataclass(frozen=True)
class Command:
    """An action and the checks of its arguments."""

    act: Callable[..., Any]
    arguments: Mapping[str, Check]


def carry_out(text: str, table: Mapping[str, Command]) -> str:
    """Carry out a message of a browser; return the reason if it is refused, or an empty text."""
    try:
        message = dict(json.loads(text))
        name = message.pop("do")
        command = table[name]
    except (ValueError, TypeError, KeyError, RecursionError):
        return "A message was refused: it is no command."
    checks = command.arguments
    if set(message) != set(checks) or not all(checks[k](message[k]) for k in checks):
        return f"A message was refused: its values for {name} are invalid."
    command.act(**message)
    return ""


class Commands:
    """The commands of a session.

    Attributes:
        joint: Joint whose curves are shown.
        save_requested: Event of the save button.
        joined: Event of a browser that has opened the page.
    """

    def __init__(self, session: Session, *, can_save: bool):
        self.session, self.joint = session, FIRST_JOINT
        self.save_requested, self.joined = Event(), Event()
        self._can_save = can_save

    def receive(self, text: str) -> None:
        """Carry out a message of a browser, or refuse it and say so."""
        if complaint := carry_out(text, self._table()):
            self.session.message = complaint

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Return the ranges of the sliders."""
        friction = self.session.world.ground.friction
        return {
            "force": FORCE,
            "direction": DIRECTION,
            "duration": DURATION,
            "slope": SLOPE,
            "cross_slope": SLOPE,
            "friction": (min(FRICTION[0], friction), max(FRICTION[1], friction)),
            "load": (0.0, max(MAX_LOAD, self.session.load)),
        }

    def _table(self) -> dict[str, Command]:
        session, ranges = self.session, self.ranges()
        table = {
            "join": Command(self.joined.set, {}),
            "step": Command(lambda: session.submit(session.step), {}),
            "restart": Command(lambda: session.submit(session.restart), {}),
            "release": Command(lambda: session.submit(lambda: session.hand.hold(None)), {}),
            "push": Command(
                self._push, {k: number(*ranges[k]) for k in ("force", "direction", "duration")}
            ),
            "hold": Command(self._hold, {"body": whole, "at": point, "end": point}),
            "pull": Command(self._pull, {"end": point}),
            "target": Command(self._set_target, {"name": a_name, "value": number()}),
            "pause": Command(self._pause, {"value": flag}),
            "speed": Command(lambda value: setattr(session, "speed", value), one(SPEEDS)),
            "force": Command(self._set_force, {"value": number(*FORCE)}),
            "controller": self._choice("controller", {*CONTROLLERS, session.choice.controller}),
            "feet": self._choice("feet", FEET),
            "joints": self._choice("joints", JOINT_SETS),
            "friction": self._slider(session.set_friction, "friction"),
            "load": self._slider(session.set_load, "load"),
            "joint": Command(self._show_joint, one(session.world.human.coordinates)),
        }
        if session.tilts:
            table["slope"] = Command(lambda value: self._tilt(0, value), in_range(SLOPE))
            table["cross_slope"] = Command(lambda value: self._tilt(1, value), in_range(SLOPE))
        if self._can_save:
            table["save"] = Command(self.save_requested.set, {})
        return table

    def _slider(self, act: Callable[[float], None], name: str) -> Command:
        session = self.session
        return Command(
            lambda value: session.submit(lambda: act(float(value))), in_range(self.ranges()[name])
        )

    def _choice(self, name: str, options: Iterable[str]) -> Command:
        session = self.session

        def act(value: str) -> None:
            session.submit(lambda: session.choose(replace(session.choice, **{name: value})))

        return Command(act, one(options))

    def _push(self, force: float, direction: float, duration: float) -> None:
        self._set_force(force)
        way = float(np.deg2rad(direction))
        self.session.submit(lambda: self.session.push(way, float(duration)))

    def _set_force(self, value: float) -> None:
        self.session.hand.max_force = float(value)

    def _hold(self, body: int, at: list[float], end: list[float]) -> None:
        start, to = np.array(at, dtype=float), np.array(end, dtype=float)
        self.session.submit(lambda: self.session.hold(body, start, to))

    def _pull(self, end: list[float]) -> None:
        to = np.array(end, dtype=float)
        self.session.submit(lambda: self.session.pull(to))

    def _pause(self, value: bool) -> None:
        self.session.submit(lambda: setattr(self.session, "paused", value))

    def _tilt(self, axis: int, degrees: float) -> None:
        def act() -> None:
            if (slope := self.session.desired_slope) is not None:
                slope = slope.copy()
                slope[axis] = np.deg2rad(degrees)
                self.session.tilt(*slope)

        self.session.submit(act)

    def _set_target(self, name: str, value: float) -> None:
        def act() -> None:
            for target in self.session.targets:
                if target.name == name:
                    target.set(float(value))

        self.session.submit(act)

    def _show_joint(self, value: str) -> None:
        self.joint = value


def number(low: float = -math.inf, high: float = math.inf) -> Check:
    """Return a check that a value is a finite number within a range."""

    def check(value: Any) -> bool:
        return is_real(value) and math.isfinite(value) and low <= value <= high

    return check


def in_range(limits: tuple[float, float]) -> dict[str, Check]:
    """Return the check of a command with one number within a range."""
    return {"value": number(*limits)}


def one(options: Iterable[Any]) -> dict[str, Check]:
    """Return the check of a command with one of some values."""
    allowed = set(options)
    return {"value": lambda value: isinstance(value, str | int | float) and value in allowed}


def flag(value: Any) -> bool:
    """Return whether a value is true or false."""
    return isinstance(value, bool)


def whole(value: Any) -> bool:
    """Return whether a value is a whole number."""
    return isinstance(value, int) and not isinstance(value, bool)


def a_name(value: Any) -> bool:
    """Return whether a value is a text."""
    return isinstance(value, str)


def point(value: Any) -> bool:
    """Return whether a value is three finite numbers."""
    return isinstance(value, list) and len(value) == 3 and all(map(number(), value))
