"""Published mean and standard deviation of gait curves for comparison.

There are two populations; pages name the one they show, with number, ages and speed.

- :data:`ADULTS` [Fukuchi2018]_: 42 healthy adults, 24 of 21 to 37 and 18 of 50 to 84 years, over
  ground at their own comfortable speed: joint angles. Their step length and cadence change with
  speed as those of 51 adults of the same laboratory on a treadmill [Fukuchi2018]_.
- :data:`CHILDREN` [Schwartz2008]_ (supplementary tables): 83 typically developing children of 4 to
  17 years, barefoot, at five speeds: joint angles, moments, powers, ground reactions. Children's
  ankle moment and power are smaller than adults'.

A third one may be given by the user (:mod:`plantigrade.analyze.own_norms`).

No table of joint moments, powers or ground reactions of adults with standard deviations may be
redistributed; those of children are shown instead, under their name.

Published angles are those of a pelvis defined by the plane through its iliac spines. In Rajagopal's
pelvis that plane leans forward by :data:`plantigrade.models.anatomy.SPINE_PLANE` at zero tilt,
which is subtracted from pelvis tilt and hip flexion.

``schwartz2008.json`` and ``fukuchi2018.json`` contain these tables at every 2 % of the cycle, with
angles rounded to 0.1 degree and everything else to 0.01, and names and signs converted to those of
OpenSim's Rajagopal model (pelvis tilt positive backward, pelvis list positive to the right side
down, rotation positive to the left, knee flexion positive; internal moments positive in the
direction of their coordinate, so that knee extensors and plantarflexors are negative; foot
progression positive inward). Curves are those of the right leg (of adults the mean of both legs);
for the left leg, pelvis list and rotation change sign.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files

import numpy as np

from plantigrade.analyze.statistics import Agreement, compare_curves
from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.errors import ParameterError
from plantigrade.models.anatomy import SPINE_PLANE
from plantigrade.models.stature import ADULT_AGE

MIRRORED = ("pelvis_list", "pelvis_rotation")
"""Angles that change sign when left and right are exchanged."""
SPEED_CLASSES = ("very_slow", "slow", "free", "fast", "very_fast")
"""Speed classes, slowest first."""
CLASS_BOUNDS = (0.227, 0.363, 0.500, 0.636)  #: Dimensionless speeds between the classes


@dataclass(frozen=True)
class Population:
    """A population with published gait curves."""

    name: str  #: ``"adults"``, ``"children"`` or ``"own norms"``
    people: str  #: Number and ages of the people
    speed: str  #: Walking speed
    citation: str  #: Source
    #: Mean and SD of a user's own curves, at even percentages of the cycle, by our names
    curves: Mapping[str, tuple[Array, Array]] = field(default_factory=dict, compare=False)

    @property
    def own(self) -> bool:
        """Whether the curves are a user's own."""
        return bool(self.curves)


COMFORTABLE = (1.24, 0.16)  #: Comfortable speed of these adults, mean and SD [m/s]

ADULTS = Population(
    "adults",
    "42 healthy adults, 21–37 and 50–84 years",
    f"over ground at their own comfortable speed, {COMFORTABLE[0]} ± {COMFORTABLE[1]} m/s",
    "Fukuchi, Fukuchi & Duarte 2018, PeerJ 6:e4640, CC BY 4.0",
)
CHILDREN = Population(
    "children",
    "83 typically developing children, 4–17 years",
    "barefoot at five speeds",
    "Schwartz, Rozumalski & Trost 2008, J Biomech 41:1639–1650",
)
PUBLISHED_NAMES = {
    "ground_force_up": "vertical_grf",
    "ground_force_forward": "anterior_grf",
    "hip_flexion_power": "hip_power",
    "knee_angle_power": "knee_power",
    "ankle_angle_power": "ankle_power",
}
"""Names of our curves → those of the published tables, where they differ."""
MAX_CHILD_HEIGHT = 1.45
"""Body height below which a person of unknown age is compared with children [m]; 1 % of women and
half of the children of eleven years are shorter."""
ADULT_SPEEDS = (0.34, 1.77)
"""Speeds at which step length and cadence of adults were measured [m/s]."""
STEP_LENGTH = ((-0.0371, 0.3803, 0.2071), 0.040)
"""Step length of adults [m]: a polynomial of speed [m/s], and the SD about it."""
CADENCE = ((-22.34, 96.64, 35.48), 8.2)
"""Cadence of adults [steps/min]: a polynomial of speed [m/s], and the SD about it."""
FOOT_OFF: dict[str, tuple[float, float]] = dict(
    zip(SPEED_CLASSES, ((68, 5), (62, 2), (59, 2), (58, 2), (56, 2)), strict=True)
)
"""Foot off of children by speed class: mean and SD [% of cycle]."""
DOUBLE_SUPPORT: dict[str, tuple[float, float]] = dict(
    zip(SPEED_CLASSES, ((36, 10), (24, 4), (19, 2), (16, 3), (14, 3)), strict=True)
)
"""Total double support of children by speed class: mean and SD [% of cycle]."""


@dataclass(frozen=True)
class NormCurve:
    """A published mean curve and its standard deviation over the gait cycle."""

    name: str  #: Name of the curve
    speed_class: str  #: One of :data:`SPEED_CLASSES`; ``"comfortable"`` for adults
    percent: Float[Array, " n"]  #: Percent of the cycle, 0 at heel strike
    mean: Float[Array, " n"]  #: Mean over subjects, in ``unit``
    sd: Float[Array, " n"]  #: Standard deviation between subjects, in ``unit``
    unit: str  #: ``"deg"``, ``"N m/kg"``, ``"W/kg"`` or ``"body weight"``
    population: Population  #: Population


def population(age: float | None = None, height: float | None = None) -> Population:
    """Return the population for comparison: adults, unless age or height indicate a child.

    Args:
        age: Age [years]; None if unknown.
        height: Body height [m]; None if unknown or estimated only.

    Example:
        >>> [population(*known).name for known in ((9, 1.5), (30, 1.4), (None, 1.3), (None, 1.7))]
        ['children', 'adults', 'children', 'adults']
    """
    if age is not None:
        return CHILDREN if age < ADULT_AGE else ADULTS
    return CHILDREN if height is not None and height < MAX_CHILD_HEIGHT else ADULTS


def reason(age: float | None = None, height: float | None = None) -> str:
    """Return the reason for the choice of :func:`population`.

    Example:
        >>> reason(9), reason(None, 1.7)
        ('by an age of 9 years', 'by a body height of 1.70 m, because no age is known')
    """
    if age is not None:
        return f"by an age of {age:.3g} years"
    if height is not None:
        return f"by a body height of {height:.2f} m, because no age is known"
    return "because neither age nor body height is given"


def names(population: Population = CHILDREN) -> tuple[str, ...]:
    """Return the names of the curves of a population."""
    return tuple(population.curves or _tables(population.name))


def norm(
    name: str, speed_class: str = "free", *, side: str = "r", population: Population = CHILDREN
) -> NormCurve:
    """Return the published band of a curve, or a user's own.

    Args:
        name: A coordinate (``"knee_angle"``, or with its side, ``"knee_angle_l"``), its moment
            (``"knee_angle_moment"``) or power (``"knee_angle_power"``), ``"ground_force_up"`` or
            ``"ground_force_forward"``; names of the published tables (``"hip_power"``,
            ``"vertical_grf"``) are accepted, too.
        speed_class: One of :data:`SPEED_CLASSES`; see :func:`speed_class`. Adults walked at their
            comfortable speed only.
        side: Foot whose heel strikes bound the cycle; for ``"l"`` pelvis list and rotation change
            sign.

    Raises:
        ParameterError: If there is no such curve or class.
    """
    there = names(population)
    stem = name
    if not population.own:
        stem = PUBLISHED_NAMES.get(name, name)
    for suffix in ("_r", "_l"):
        if stem not in there:
            stem = stem.removesuffix(suffix)
            stem = stem.replace(f"{suffix}_moment", "_moment").replace(f"{suffix}_power", "_power")
    if stem not in there:
        raise ParameterError(f"no norm {name!r} of {population.name}; there are {', '.join(there)}")
    if speed_class not in SPEED_CLASSES:
        raise ParameterError(f"{speed_class=}: allowed are {', '.join(SPEED_CLASSES)}")
    if side not in SIDES:
        raise ParameterError(f"{side=}: allowed are 'r' and 'l'")
    if population.own:
        mean, sd = (np.array(values, dtype=float) for values in population.curves[stem])
        speed_class = "as given"
    else:
        table = _tables(population.name)[stem]
        speed_class = next(iter(table)) if population is ADULTS else speed_class
        mean, sd = (np.array(table[speed_class][key], dtype=float) for key in ("mean", "sd"))
        # Tilt is positive backward, flexion forward; the lean of the plane affects both.
        mean = mean + {"pelvis_tilt": SPINE_PLANE, "hip_flexion": -SPINE_PLANE}.get(stem, 0.0)
    if side == "l" and stem in MIRRORED:
        mean = -mean
    percent = np.linspace(0.0, 100.0, len(mean))
    return NormCurve(stem, speed_class, percent, mean, sd, unit_of(stem), population)


def agreement_with_norm(
    percent: Float[Array, " n"],
    values: Float[Array, " n"],
    name: str,
    speed_class: str = "free",
    *,
    side: str = "r",
    population: Population = CHILDREN,
) -> Agreement:
    """Return the agreement of a curve with a mean of :func:`norm`."""
    band = norm(name, speed_class, side=side, population=population)
    theirs = np.interp(percent, band.percent, band.mean)
    return compare_curves(values, theirs)


def unit_of(name: str) -> str:
    """Return the unit of a curve by its name.

    Example:
        >>> unit_of("knee_angle"), unit_of("hip_power"), unit_of("ground_force_up")
        ('deg', 'W/kg', 'body weight')
    """
    for part, unit in (("_moment", "N m/kg"), ("_power", "W/kg"), ("_grf", "body weight")):
        if name.endswith(part):
            return unit
    return "body weight" if name.startswith("ground_force") else "deg"


def comfortable(speed: float) -> bool:
    """Return whether a speed [m/s] is within two SD of the adults' comfortable speed.

    Example:
        >>> comfortable(1.3), comfortable(0.7)
        (True, False)
    """
    mean, sd = COMFORTABLE
    return abs(speed - mean) <= 2 * sd


def adult_steps(speed: float) -> dict[str, tuple[float, float]]:
    """Return mean and SD of step length [m] and cadence [1/min] of adults at a speed [m/s].

    The result is empty outside the measured speeds.

    Example:
        >>> {name: f"{mean:.2f} ± {sd:.2f}" for name, (mean, sd) in adult_steps(1.2).items()}
        {'step_length': '0.61 ± 0.04', 'cadence': '119.28 ± 8.20'}
    """
    if not ADULT_SPEEDS[0] <= speed <= ADULT_SPEEDS[1]:
        return {}
    tables = {"step_length": STEP_LENGTH, "cadence": CADENCE}
    return {name: (float(np.polyval(fit, speed)), sd) for name, (fit, sd) in tables.items()}


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
    """Return the speed class of a walking speed [Schwartz2008]_.

    Example:
        >>> speed_class(1.25, 0.9)
        'free'
    """
    value = dimensionless_speed(speed, leg_length)
    return SPEED_CLASSES[int(np.searchsorted(CLASS_BOUNDS, value, side="right"))]


@cache
def _tables(population: str) -> dict[str, dict[str, dict[str, list[float]]]]:
    name = {"adults": "fukuchi2018.json", "children": "schwartz2008.json"}[population]
    return json.loads(files("plantigrade.analyze").joinpath(name).read_text(encoding="utf-8"))
