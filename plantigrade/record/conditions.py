"""Conditions of a task as data: stated by the task, stored in the Record, checked later.

Times are those of the Record's motion, so a condition of a periodic task is stated once per lap,
mirrored where the motion is. Angles are in radians.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import ParameterError

Quantity = Literal[
    "coordinate",
    "speed",
    "rest",
    "point",
    "clearance",
    "com",
    "com speed",
    "displacement",
    "power",
    "muscle torque",
]
"""Kind of the bounded quantity.

- ``"coordinate"``: the coordinate ``of``, pelvis or hinge [rad, m];
- ``"speed"``: its rate [rad/s, m/s];
- ``"rest"``: the largest absolute rate of all coordinates [rad/s, m/s];
- ``"point"``: where the lowest point of a sphere of ``radius`` at ``position`` on body ``of`` is
  along ``axis`` [m]; a point of the body where the radius is zero;
- ``"clearance"``: how far that lowest point is above the ground below it [m];
- ``"com"``, ``"com speed"``: centre of mass along ``axis`` [m], and its velocity [m/s];
- ``"displacement"``: how far the coordinate ``of`` goes from the first of ``time`` to the last;
- ``"power"``: joint power at the hinge ``of`` without what passive tissue does [W];
- ``"muscle torque"``: joint torque at the hinge ``of`` without that of passive tissue [N m].
"""

AXES = ("x", "y", "z")
"""Axes of the ground: x uphill, y to the left, z off the ground; world axes where it is level."""


@dataclass(frozen=True)
class Condition:
    """A quantity stays between bounds for a while.

    Raises:
        ParameterError: If bounds and times do not go together.
    """

    name: str  #: What it is called in a report: ``"knee_angle_r"``, ``"clearance of toe_1_r"``
    quantity: Quantity  #: What is bounded, see :data:`Quantity`
    #: When [s]: one instant, or two or more times between which bounds are linear; the last may be
    #: infinite. Frames outside are not judged.
    time: tuple[float, ...]
    lower: tuple[float, ...]  #: Lower bound at each of ``time``; -inf for none
    upper: tuple[float, ...]  #: Upper bound at each of ``time``; inf for none
    of: str = ""  #: Coordinate, hinge or body
    axis: str = ""  #: One of :data:`AXES`, for a place or its velocity
    #: Point, or centre of the sphere, in the frame of the body [m]
    position: Sequence[float] | Float[Array, " 3"] = (0.0, 0.0, 0.0)
    radius: float = 0.0  #: Of the sphere [m]

    def __post_init__(self):
        for key in ("time", "lower", "upper", "position"):
            object.__setattr__(self, key, tuple(float(x) for x in getattr(self, key)))
        if self.quantity not in get_args(Quantity):
            raise ParameterError(f"{self.name}: no quantity {self.quantity!r}")
        if not len(self.time) == len(self.lower) == len(self.upper) >= 1:
            raise ParameterError(f"{self.name}: every time needs a lower and an upper bound")
        if any(b < a for a, b in zip(self.time[:-1], self.time[1:], strict=True)):
            raise ParameterError(f"{self.name}: times must be in order")

    @property
    def unit(self) -> str:
        """SI unit of the bounds."""
        dynamic = {"power": "W", "muscle torque": "N m"}
        if self.quantity in dynamic:
            return dynamic[self.quantity]
        metres = self.quantity in ("point", "clearance", "com", "com speed")
        metres = metres or self.of in ("pelvis_tx", "pelvis_ty", "pelvis_tz")
        rate = "/s" if self.quantity in ("speed", "rest", "com speed") else ""
        return ("m" if metres else "rad") + rate

    def holds_at(self, time: Float[Array, " n"]) -> Bool[Array, " n"]:
        """Return which times are judged; for an instant, judge the motion at that very time."""
        return (time >= self.time[0] - 1e-9) & (time <= self.time[-1] + 1e-9)

    def bounds(self, time: Float[Array, " n"]) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Return lower and upper bounds at times [s]."""
        knots = np.minimum(self.time, 1e9)
        low, high = (np.asarray(x, float) for x in (self.lower, self.upper))
        return _between(time, knots, low), _between(time, knots, high)

    def later(self, seconds: float) -> "Condition":
        """Return the same condition later."""
        return replace(self, time=tuple(t + seconds for t in self.time))

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON can hold it; infinite bounds become None."""
        d = asdict(self)
        for key in ("time", "lower", "upper"):
            d[key] = [x if np.isfinite(x) else None for x in d[key]]
        return d

    @classmethod
    def from_dict(cls, description: Mapping[str, Any]) -> "Condition":
        """Return the condition of a description.

        Raises:
            ParameterError: If something is missing or of another kind.
        """
        none = {"time": np.inf, "lower": -np.inf, "upper": np.inf}
        try:
            d = dict(description)
            for key, missing in none.items():
                d[key] = tuple(missing if x is None else float(x) for x in d[key])
            d["position"] = tuple(float(x) for x in d["position"])
            return cls(**d)
        except (TypeError, ValueError, KeyError, OverflowError) as error:
            if isinstance(error, ParameterError):
                raise
            raise ParameterError(f"this describes no condition: {error}") from error


def _between(time: Array, knots: Array, values: Array) -> Array:
    """Return piecewise linear bounds; infinite ones reach from knot to knot."""
    finite = np.isfinite(values)
    if finite.all() or not finite.any():
        return np.interp(time, knots, values) if finite.all() else np.full(len(time), values[0])
    out = np.interp(time, knots, np.where(finite, values, 0.0))
    open_ = np.interp(time, knots, (~finite).astype(float)) > 0
    out[open_] = values[~finite][0]
    return out
