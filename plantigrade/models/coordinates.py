"""Coordinates of the joint sets: axis, range and strength.

Axes are those of the right side in our frames (x forward, y left, z up; Rajagopal's are x
forward, y up, z right) and follow [Rajagopal2016]_ where it has the coordinate; ankle and
subtalar axes are the oblique ones of [Inman1976]_ as in that model, and here all of them pass
through the ankle joint centre. The left axis is the mirror image, so a positive value means the
same movement on both sides.

Ranges are the possible range of a joint rather than its usual one, so that skin motion and errors
of joint centres do not drive a fit into a limit. Each row states the range it was widened from.

Strengths refer to a body mass of 73 kg and a stature of 1.74 m and scale with mass times stature,
as [Anderson2007]_ normalises them. They are those of strong people: the mean plus two standard
deviations (SD) where a study gives both. A moment beyond the limit is therefore impossible for a
person of that size. Sources other than [Anderson2007]_ are [Fice2014]_ (neck), [Goldmann2012]_
(toes), and [Jackson2010]_ and [Kentel2011]_ (arms) as tabulated in the muscle addon of RBDL
[Felis2017]_; ranges are from [Rajagopal2016]_ and [AAOS1965]_. An *estimate* rests on the stated
reasoning, without measurement.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.data_files import toml_tree
from plantigrade.errors import CoordinateNotFound, known_names
from plantigrade.side_names import split_side


@dataclass(frozen=True)
class Coordinate:
    """A rotational coordinate of a joint."""

    axis: tuple[float, float, float]  #: Axis of the right side in the zero pose, unit length
    low: float  #: Lower limit [rad]
    high: float  #: Upper limit [rad]
    range_source: str  #: Source of the limits
    weakest: float  #: Largest moment in the negative sense, a negative number [N m]
    strongest: float  #: Largest moment in the positive sense [N m]
    strength_source: str  #: Source of the moments

    def axis_of(self, side: str) -> np.ndarray:
        """Return the unit axis for side ``"r"``, ``"l"`` (mirrored) or ``""``."""
        a = np.array(self.axis)
        a = a / np.linalg.norm(a)
        return a * np.array([-1.0, 1.0, -1.0]) if side == "l" else a


def _coordinates() -> dict[str, Coordinate]:
    found = {}
    tree = toml_tree("plantigrade.models", "coordinates.toml")
    for name, row in tree["coordinates"].items():
        low, high = (float(v) for v in np.deg2rad(row["range"]))
        weakest, strongest = (float(v) for v in row["moments"])
        source, strength = (tree["sources"][key] for key in row["sources"])
        axis = tuple(row["axis"])
        found[name] = Coordinate(axis, low, high, source, weakest, strongest, strength)
    return found


COORDINATES = _coordinates()


def coordinate_of(name: str) -> Coordinate:
    """Return the table row of a coordinate named with its side.

    Raises:
        CoordinateNotFound: If there is none of that name.
    """
    plain, _ = split_side(name)
    if plain not in COORDINATES:
        raise CoordinateNotFound(f"no coordinate {name!r}; {known_names(name, list(COORDINATES))}")
    return COORDINATES[plain]


REFERENCE_MASS = 73.0  # [kg] body mass of the tabulated strengths
REFERENCE_HEIGHT = 1.74  # [m] stature of the tabulated strengths
