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

from plantigrade.errors import ParameterError

SEXES = ("female", "male")

# Fractions of stature, standing: foot + shank + thigh + pelvis + trunk + head = 1.
_FRACTIONS = {
    "ankle_height": 0.039,
    "shank": 0.246,
    "thigh": 0.245,
    "pelvis_height": 0.094,
    "trunk": 0.219,
    "head": 0.157,
    "pelvis_width": 0.137,
    "pelvis_depth": 0.096,
    "lumbar_depth": 0.052,
    "shoulder_width": {"male": 0.200, "female": 0.190},
    "upper_arm": {"male": 0.1618, "female": 0.1605},
    "forearm": {"male": 0.1595, "female": 0.1565},
    "hand": {"male": 0.1090, "female": 0.1100},
    "foot_length": 0.152,
    "foot_width": 0.0575,
}
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


# de Leva 1996, table 4. Endpoints: head vertex–C7 (cervicale), upper trunk suprasternale–xiphoid,
# middle trunk xiphoid–omphalion, lower trunk omphalion–mid-hip, upper arm, forearm, thigh and
# shank between joint centres, hand wrist–third metacarpal head, foot heel–toe tip.
DE_LEVA: dict[str, dict[str, SegmentParameters]] = {
    "male": {
        "head": SegmentParameters(0.0694, 0.5002, (0.303, 0.315, 0.261)),
        "upper_trunk": SegmentParameters(0.1596, 0.2999, (0.716, 0.454, 0.659)),
        "middle_trunk": SegmentParameters(0.1633, 0.4502, (0.482, 0.383, 0.468)),
        "lower_trunk": SegmentParameters(0.1117, 0.6115, (0.615, 0.551, 0.587)),
        "upper_arm": SegmentParameters(0.0271, 0.5772, (0.285, 0.269, 0.158)),
        "forearm": SegmentParameters(0.0162, 0.4574, (0.276, 0.265, 0.121)),
        "hand": SegmentParameters(0.0061, 0.7900, (0.628, 0.513, 0.401)),
        "thigh": SegmentParameters(0.1416, 0.4095, (0.329, 0.329, 0.149)),
        "shank": SegmentParameters(0.0433, 0.4395, (0.251, 0.246, 0.102)),
        "foot": SegmentParameters(0.0137, 0.4415, (0.257, 0.245, 0.124)),
    },
    "female": {
        "head": SegmentParameters(0.0668, 0.4841, (0.271, 0.295, 0.261)),
        "upper_trunk": SegmentParameters(0.1545, 0.2077, (0.746, 0.502, 0.718)),
        "middle_trunk": SegmentParameters(0.1465, 0.4512, (0.433, 0.354, 0.415)),
        "lower_trunk": SegmentParameters(0.1247, 0.4920, (0.433, 0.402, 0.444)),
        "upper_arm": SegmentParameters(0.0255, 0.5754, (0.278, 0.260, 0.148)),
        "forearm": SegmentParameters(0.0138, 0.4559, (0.261, 0.257, 0.094)),
        "hand": SegmentParameters(0.0056, 0.7474, (0.531, 0.454, 0.335)),
        "thigh": SegmentParameters(0.1478, 0.3612, (0.369, 0.364, 0.162)),
        "shank": SegmentParameters(0.0481, 0.4352, (0.267, 0.263, 0.092)),
        "foot": SegmentParameters(0.0129, 0.4014, (0.299, 0.279, 0.139)),
    },
}

# Heights of de Leva's trunk landmarks above the hip joint centres, as fractions of the distance
# from there up to the joint under C7, and his length of the lower trunk. The height of the
# suprasternale is that of [Gordon2014]_ (0.819 and 0.816 of stature); xiphoid and omphalion lie
# below it by his mean lengths (table 4, male stature 1.741 m, female 1.735 m). The height of the
# omphalion then agrees with that of men (0.598 of stature against 0.601) and is 0.014 too high for
# women; his length from there to the hips is oblique because the navel lies in front of them.
TRUNK_LANDMARKS = {
    "male": {
        "suprasternale": 0.9236,
        "xiphoid": 0.6104,
        "omphalion": 0.2149,
        "lower_trunk": 0.2674,
    },
    "female": {
        "suprasternale": 0.9150,
        "xiphoid": 0.6525,
        "omphalion": 0.2744,
        "lower_trunk": 0.3342,
    },
}

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
