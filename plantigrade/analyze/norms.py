"""Published mean and standard deviation of gait curves, to draw behind one's own.

All numbers are those of [Schwartz2008]_ (supplementary tables): 83 typically developing CHILDREN of
4 to 17 years walking barefoot at five speeds. Adults differ little in joint angles; their ankle
moment and power tend to be greater. Angles are Plug-in Gait's, so that a constant offset against
another body model is a matter of convention, most of all in pelvis tilt and hip flexion: there
the forward lean of Plug-in Gait's pelvic plane in upright standing
(:data:`plantigrade.models.textbook_gait.PELVIC_PLANE`), where Rajagopal's pelvis has no tilt, is
taken out.

``schwartz2008.json`` was made from those tables: every 2 % of the cycle, angles rounded to 0.1
degree and everything else to 0.01; names and signs turned to those of OpenSim's Rajagopal model
(pelvis tilt positive backward, pelvis list positive to the right side down, rotation positive to
the left, knee flexion positive; internal moments positive in the direction of their coordinate, so
that knee extensors and plantarflexors are negative). Curves are those of the right leg; for the
left leg, pelvis list and rotation change sign.

References:
    [Schwartz2008]_.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.errors import ParameterError
from plantigrade.models.textbook_gait import PELVIC_PLANE

SPEED_CLASSES = ("very_slow", "slow", "free", "fast", "very_fast")
"""Speed classes, slowest first."""

CLASS_BOUNDS = (0.227, 0.363, 0.500, 0.636)
"""Dimensionless speeds between the classes."""

CITATION = (
    "Schwartz, Rozumalski & Trost 2008, J Biomech 41:1639-1650 (typically developing children)"
)

FOOT_OFF: dict[str, tuple[float, float]] = dict(
    zip(SPEED_CLASSES, ((68, 5), (62, 2), (59, 2), (58, 2), (56, 2)), strict=True)
)
"""Foot off by speed class: mean and SD [% of cycle]."""

DOUBLE_SUPPORT: dict[str, tuple[float, float]] = dict(
    zip(SPEED_CLASSES, ((36, 10), (24, 4), (19, 2), (16, 3), (14, 3)), strict=True)
)
"""Double support, both parts together, by speed class: mean and SD [% of cycle]."""


@dataclass(frozen=True)
class NormCurve:
    """A published mean curve and its standard deviation over the gait cycle."""

    name: str  #: Name of the curve
    speed_class: str  #: One of :data:`SPEED_CLASSES`
    percent: Float[Array, " n"]  #: Percent of the cycle, 0 at heel strike
    mean: Float[Array, " n"]  #: Mean over subjects, in ``unit``
    sd: Float[Array, " n"]  #: Standard deviation between subjects, in ``unit``
    unit: str  #: ``"deg"``, ``"N m/kg"``, ``"W/kg"`` or ``"body weight"``
    citation: str = CITATION  #: Where the numbers were published


def names() -> tuple[str, ...]:
    """Return the names of the curves there are."""
    return tuple(_tables())


def norm(name: str, speed_class: str = "free", *, side: str = "r") -> NormCurve:
    """Return the published band of a curve.

    Args:
        name: A coordinate (``"knee_angle"``, or with its side, ``"knee_angle_l"``), its moment
            (``"knee_angle_moment"``), ``"hip_power"``, ``"knee_power"``, ``"ankle_power"``,
            ``"vertical_grf"`` or ``"anterior_grf"``.
        speed_class: One of :data:`SPEED_CLASSES`; see :func:`speed_class`.
        side: Foot whose heel strikes bound the cycle; for ``"l"`` pelvis list and rotation change
            sign.

    Raises:
        ParameterError: If there is no such curve or class.
    """
    stem = name
    for suffix in ("_r", "_l"):
        if name not in _tables() and name.endswith(suffix):
            stem = name.removesuffix(suffix)
        else:
            stem = stem.replace(f"{suffix}_moment", "_moment").replace(f"{suffix}_power", "_power")
    if stem not in _tables():
        raise ParameterError(f"no norm {name!r}; there are {', '.join(names())}")
    if speed_class not in SPEED_CLASSES:
        raise ParameterError(f"{speed_class=}: allowed are {', '.join(SPEED_CLASSES)}")
    if side not in SIDES:
        raise ParameterError(f"{side=}: allowed are 'r' and 'l'")
    table = _tables()[stem][speed_class]
    mirrored = side == "l" and stem in ("pelvis_list", "pelvis_rotation")
    mean = np.array(table["mean"], dtype=float) * (-1 if mirrored else 1)
    # Tilt is positive backward, flexion forward: the plane's lean leaves both.
    mean = mean + {"pelvis_tilt": PELVIC_PLANE, "hip_flexion": -PELVIC_PLANE}.get(stem, 0.0)
    unit = "deg"
    for ending, other in (("_moment", "N m/kg"), ("_power", "W/kg"), ("_grf", "body weight")):
        if stem.endswith(ending):
            unit = other
    percent = np.linspace(0.0, 100.0, len(mean))
    return NormCurve(stem, speed_class, percent, mean, np.array(table["sd"], dtype=float), unit)


def dimensionless_speed(speed: float, leg_length: float) -> float:
    r"""Return :math:`v / \sqrt{g l}`.

    Args:
        speed: Walking speed [m/s].
        leg_length: Leg length [m].
    """
    if not leg_length > 0 or not speed >= 0:
        raise ParameterError(
            f"{speed=} [m/s] must not be negative and {leg_length=} [m] must be positive"
        )
    return speed / float(np.sqrt(GRAVITY * leg_length))


def speed_class(speed: float, leg_length: float) -> str:
    """Return the speed class of [Schwartz2008]_ that a walking speed falls into.

    Example:
        >>> speed_class(1.25, 0.9)
        'free'
    """
    value = dimensionless_speed(speed, leg_length)
    return SPEED_CLASSES[int(np.searchsorted(CLASS_BOUNDS, value, side="right"))]


@cache
def _tables() -> dict[str, dict[str, dict[str, list[float]]]]:
    text = files("plantigrade.analyze").joinpath("schwartz2008.json").read_text(encoding="utf-8")
    return json.loads(text)
