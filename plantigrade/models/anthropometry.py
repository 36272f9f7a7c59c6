"""Lengths and masses of body segments from stature, body mass and sex.

Lengths are fractions of stature: legs, length of the foot and heights of joints from Drillis and
Contini as tabulated in [Winter2009]_, the upper arm from [deLeva1996]_, forearm, hand, breadth of
the foot and heights of the shoulder from the US Army's ANSUR II (4082 men, 1986 women)
[Gordon2014]_, the pelvis from Rajagopal's model [Rajagopal2016]_ and the hip joint centre by the
regression of [Harrington2007]_. Masses, centres of mass along a segment and radii of gyration are
those of [deLeva1996]_ by sex, relative to the segment's length; transverse positions of the centres
of mass are those of [Dumas2007]_ and [DumasWojtusch2018]_.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from plantigrade.data_files import toml_tree
from plantigrade.errors import ParameterError

SEXES = ("female", "male")

_TABLES = toml_tree("plantigrade.models", "anthropometry.toml")
_FRACTIONS: dict[str, float | dict[str, float]] = _TABLES["fractions"]
_VERTICAL = ("ankle_height", "shank", "thigh", "pelvis_height", "trunk", "head")
_ABSORBING = ("pelvis_height", "trunk", "head")  # scaled to keep stature exact


@dataclass(frozen=True)
class Dimensions:
    """Lengths of one body; they determine its geometry."""

    ankle_height: float  #: Ankle joint centre above the sole [m]
    shank: float  #: Knee to ankle joint centre [m]
    thigh: float  #: Hip to knee joint centre [m]
    pelvis_height: float  #: Hip joint centres to lumbar joint, vertically [m]
    trunk: float  #: Lumbar joint to the joint under C7, vertically [m]
    head: float  #: Joint under C7 to the vertex, vertically [m]
    pelvis_width: float  #: Between the anterior superior iliac spines [m]
    pelvis_depth: float  #: Anterior to posterior superior iliac spines [m]
    lumbar_depth: float  #: Lumbar joint behind the anterior superior iliac spines [m]
    shoulder_width: float  #: Between the shoulder joint centres [m]
    upper_arm: float  #: Shoulder to elbow joint centre [m]
    forearm: float  #: Elbow to wrist joint centre [m]
    hand: float  #: Wrist joint centre to the tip of the middle finger [m]
    foot_length: float  #: Heel to toe tip [m]
    foot_width: float  #: Across the metatarsal heads [m]

    @property
    def height(self) -> float:
        """Stature: the sum of the vertical lengths [m]."""
        return float(sum(getattr(self, name) for name in _VERTICAL))

    @property
    def leg_length(self) -> float:
        """Hip joint centre above the sole, with a straight leg [m]."""
        return float(self.thigh + self.shank + self.ankle_height)

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of all lengths."""
        return tuple(f.name for f in fields(cls))

    def as_array(self) -> np.ndarray:
        """Return the lengths in the order of :meth:`names` [m]."""
        return np.array([getattr(self, name) for name in self.names()])

    @classmethod
    def from_array(cls, values: np.ndarray) -> "Dimensions":
        """Build from an array in the order of :meth:`names` [m]."""
        return cls(*(float(v) for v in values))


def dimensions(
    height: float, sex: str = "male", lengths: Mapping[str, float] | None = None
) -> Dimensions:
    """Return the lengths of a person of exactly the given stature.

    Args:
        height: Stature [m], 0.5 to 2.5.
        sex: ``"female"`` or ``"male"``.
        lengths: Individual lengths [m] that replace the average ones. Pelvis, trunk and head
            lengths that are not given absorb the difference in stature.
    """
    check_range("height", height, 0.5, 2.5, "m")
    if sex not in SEXES:
        raise ParameterError(f"sex is {sex!r}; allowed are {', '.join(SEXES)}")
    lengths = dict(lengths or {})
    unknown = sorted(set(lengths) - set(Dimensions.names()))
    if unknown:
        raise ParameterError(
            f"unknown segment length {unknown[0]!r}; allowed are {', '.join(Dimensions.names())}"
        )
    for name, value in lengths.items():
        check_range(name, value, 0.01, 1.0, "m")
    average = {
        name: height * (f[sex] if isinstance(f, dict) else f) for name, f in _FRACTIONS.items()
    }
    result = replace(Dimensions(**average), **lengths)
    free = [name for name in _ABSORBING if name not in lengths]
    excess = result.height - height
    if abs(excess) > 1e-12:
        usual = sum(getattr(result, name) for name in free)
        if not free:
            raise ParameterError(
                f"the given segment lengths add up to {result.height:.4f} m but height is "
                f"{height:.4f} m; leave out one of {', '.join(_ABSORBING)} or change the height"
            )
        factor = (usual - excess) / usual
        if not 0.5 < factor < 2:
            raise ParameterError(
                f"the given segment lengths leave {usual - excess:.3f} m for {', '.join(free)}, "
                f"usually {usual:.3f} m at a height of {height:.3f} m; check them and their unit"
            )
        result = replace(result, **{name: factor * getattr(result, name) for name in free})
    return result


def check_range(name: str, value: float, low: float, high: float, unit: str) -> None:
    """Raise a ParameterError unless ``low <= value <= high`` (NaN is refused)."""
    if not (isinstance(value, int | float | np.floating) and low <= value <= high):
        raise ParameterError(f"{name} is {value!r} {unit}; allowed is {low:g} to {high:g} {unit}")


@dataclass(frozen=True)
class SegmentParameters:
    """One row of de Leva's table 4."""

    mass: float  #: Fraction of body mass
    com: float  #: Centre of mass from the first endpoint, fraction of the length between endpoints
    #: Radii of gyration about the sagittal (forward), transverse (sideways) and longitudinal axis,
    #: fractions of that length
    gyration: tuple[float, float, float]


DE_LEVA: dict[str, dict[str, SegmentParameters]] = {
    sex: {
        part: SegmentParameters(mass, com, tuple(gyration))
        for part, (mass, com, *gyration) in rows.items()
    }
    for sex, rows in _TABLES["de_leva"].items()
}
TRUNK_LANDMARKS: dict[str, dict[str, float]] = _TABLES["trunk_landmarks"]

# Anterior offset of the centre of mass from the line between the end joints of a segment, as a
# fraction of the line's length, which de Leva does not give. Head, from the joint under C7 to the
# vertex, and shank: [DumasWojtusch2018]_, tables 1 and 9. Their thigh is not used: its offsets (4 %
# behind the line in men, 8 % in women) follow mostly from hip joint centres 20 to 29 mm in front of
# those of [Harrington2007]_.
COM_FORWARD = {"male": {"head": 0.020, "shank": -0.048}, "female": {"head": 0.008, "shank": -0.049}}
# The centre of mass of the pelvis behind the anterior superior iliac spines along the plane of the
# spines, as a fraction of the distance between the anterior ones [Dumas2007]_.
PELVIS_COM_BEHIND = {"male": 0.336, "female": 0.371}
# The centre of mass of the torso, without arms and pelvis, behind the suprasternale and across the
# torso, as a fraction of the distance from the hips up to the joint under C7: 46 and 41 % of the
# length from there to the joint, in people of 1.77 m and 1.61 m [Dumas2007]_.
TORSO_COM_BEHIND = {"male": 0.1144, "female": 0.1020}
