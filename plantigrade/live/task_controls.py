"""Controls of a task: sliders, switches and choices for its parameters and the person's strength.

The ranges of sliders are narrower than what a task accepts: what people do, and what is solved
within seconds. Angles are in degrees.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from math import degrees, isfinite, radians
from typing import Any, get_args, get_type_hints

from plantigrade.data_files import number_table
from plantigrade.trajopt.tasks.gait_settings import (
    WalkBackwardSettings,
    WalkSettings,
    WalkSidewaysSettings,
)
from plantigrade.trajopt.tasks.task_settings import TaskSettings

Value = float | bool | str | tuple[float, ...] | None
"""Value of a control; None is the default of a number or a point that depends on the person."""

SLIDERS = number_table("plantigrade.live", "sliders.csv", 2)
"""Parameter → range of its slider; others have none."""

TARGET = "target"
"""Parameter that is a point in space."""

HIDDEN: Mapping[type[TaskSettings], tuple[str, ...]] = {
    WalkSettings: ("cadence", "optimise_timing"),  # excluded by a step length; and minutes to solve
    WalkBackwardSettings: ("cadence",),  # excluded by a step length
    WalkSidewaysSettings: ("cadence",),
}
"""Parameters of a task that are left to the command line."""

STRENGTH = "strength of "
"""Beginning of the name of a control for the strength of a joint."""
JOINTS = ("hip_r", "knee_r", "ankle_r", "hip_l", "knee_l", "ankle_l", "lumbar")
"""Joints whose strength can be set, as impairments name them."""
FULL_STRENGTH = 100.0  # [%] strength of a joint that nothing impairs
STRENGTHS = (20.0, 150.0)  # [% of the person's own]; weaker legs carry nobody


@dataclass(frozen=True, kw_only=True)
class Control:
    """A parameter that can be changed on a page."""

    name: str  #: Name of the parameter
    label: str  #: What the page calls it
    unit: str = ""  #: Unit of a number
    low: float = 0.0  #: Lowest value
    high: float = 0.0  #: Highest value
    whole: bool = False  #: Whether it is a whole number
    value: Value = None  #: Value at the start
    options: tuple[str, ...] = ()  #: Allowed words; empty for a number, a point or a switch
    is_point: bool = False  #: Whether it is a point in space [m], which is dragged

    @property
    def is_number(self) -> bool:
        """Whether it has a slider."""
        return self.high > self.low

    def allows(self, value: Any) -> bool:
        """Return whether a control of this kind may have a value."""
        if self.options:
            return isinstance(value, str) and value in self.options
        if not self.is_number and not self.is_point:
            return isinstance(value, bool)
        if value is None:
            return self.value is None
        if self.is_point:
            return isinstance(value, tuple) and len(value) == 3 and all(map(_is_number, value))
        if not _is_number(value):
            return False
        return self.low <= value <= self.high and (not self.whole or value == int(value))


def controls_of(
    parameters: TaskSettings, strengths: Mapping[str, float] | None = None
) -> tuple[Control, ...]:
    """Return the controls of a task, then those of the strength of joints.

    Args:
        parameters: The task, at the values of the start.
        strengths: Joint → strength at the start [% of the person's own]; 100 if absent.
    """
    kind = type(parameters)
    ranges = {
        k: v for each in reversed(kind.__mro__) for k, v in vars(each).get("ranges", {}).items()
    }
    periodic = bool(getattr(parameters, "periodic", False))
    found = []
    for field in fields(parameters):
        name, value = field.name, getattr(parameters, field.name)
        if name in HIDDEN.get(kind, ()) or (
            isinstance(parameters, WalkSettings) and _useless(name, periodic)
        ):
            continue
        label = name.replace("_", " ")
        words = get_args(get_type_hints(kind)[name])
        if name in SLIDERS and name in ranges:
            low, high, unit = ranges[name]
            unit = "°" if unit == "degrees" else unit
            low, high = max(low, SLIDERS[name][0]), min(high, SLIDERS[name][1])
            if unit == "°":
                value = degrees(value)
            if value is not None:  # given outside of the usual range
                low, high = min(low, value), max(high, value)
            whole = isinstance(field.default, int) and not isinstance(field.default, bool)
            found.append(
                Control(
                    name=name, label=label, unit=unit, low=low, high=high, whole=whole, value=value
                )
            )
        elif name == TARGET:
            found.append(Control(name=name, label=label, unit="m", value=value, is_point=True))
        elif isinstance(field.default, bool):
            found.append(Control(name=name, label=label, value=bool(value)))
        elif words and all(isinstance(word, str) for word in words):
            found.append(Control(name=name, label=label, value=value, options=words))
    return (*found, *strength_controls(strengths or {}))


def strength_controls(strengths: Mapping[str, float]) -> tuple[Control, ...]:
    """Return the controls of the strength of joints, in percent of the person's own."""
    found = []
    for joint in JOINTS:
        value = strengths.get(joint, FULL_STRENGTH)
        low, high = min(STRENGTHS[0], value), max(STRENGTHS[1], value)
        name, label = f"{STRENGTH}{joint}", joint_in_words(joint)
        found.append(
            Control(name=name, label=label, unit="%", low=low, high=high, whole=True, value=value)
        )
    return tuple(found)


def strengths_in(words: Iterable[str]) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return the strengths that sliders have [%], and the other words of ``joint_strength``.

    Example:
        >>> strengths_in(["knee_r=0.5", "hip=0.8", "ankle_l=0.5:0.7"])
        ({'knee_r': 50.0}, ('hip=0.8', 'ankle_l=0.5:0.7'))
    """
    found: dict[str, float] = {}
    others = []
    for word in words:
        joint, _, part = word.partition("=")
        if joint in JOINTS and ":" not in part:
            found[joint] = float(round(100.0 * float(part)))
        else:
            others.append(word)
    return found, tuple(others)


def joint_in_words(joint: str) -> str:
    """Return the name of a joint in words.

    Example:
        >>> joint_in_words("knee_r"), joint_in_words("lumbar")
        ('right knee', 'lumbar')
    """
    name, _, side = joint.partition("_")
    return " ".join(filter(None, ({"r": "right", "l": "left"}.get(side, ""), name)))


def options_from(controls: Mapping[str, Control], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values of controls as options of ``synthesize``: radians, and strengths in words."""
    options: dict[str, Any] = {}
    strengths = []
    for name, value in values.items():
        if name.startswith(STRENGTH):
            if value != FULL_STRENGTH:
                strengths.append(f"{name.removeprefix(STRENGTH)}={value / 100.0:g}")
            continue
        control = controls.get(name)
        if control is not None and control.is_number and value is not None:
            value = radians(value) if control.unit == "°" else value
            value = int(value) if control.whole else value
        options[name] = value
    if strengths:
        options["joint_strength"] = tuple(strengths)
    return options


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


def _useless(name: str, periodic: bool) -> bool:
    """Return whether a parameter of a walk belongs to the other kind of walk, or decides which."""
    of_periodic = ("strides", "cart_force")
    of_others = ("steps", "turn", "step_height", "obstacle_height")
    return name == "periodic" or name in (of_others if periodic else of_periodic)
