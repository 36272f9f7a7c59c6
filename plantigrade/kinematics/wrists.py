r"""Markers of the two sides of a wrist that stand under each other's label.

A forearm turns on its length by half a circle, from the palm forward to the palm back next to a
hanging arm. Meanwhile the thumb's side of the wrist goes from the outer side over the front to the
inner side: it is never behind, where the elbow does not bend to. With the flexion axis :math:`f` of
the elbow, the forearm's direction :math:`v` and the vector :math:`m` from the ulna's marker to the
radius',

.. math:: \rho = \frac{m \cdot (f \times v)}{\lVert m \rVert}

is the sine of the angle of pronation; below :data:`MIN_PRONATION_SINE` the labels are exchanged.
Where the elbow has a lateral marker alone, the axis is the one that is perpendicular to upper arm
and forearm through the point inside of it, so that the kink of the markers in a straight arm is no
flexion.
"""

from collections.abc import Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.exchanged_labels import Exchange
from plantigrade.motion import Markers
from plantigrade.spatial.conventions import unit_vectors

MIN_PRONATION_SINE = -0.35  # [1] sine of 20° beyond an end of the range [AAOS1965]_
ELBOW_MARKER_OFFSET = 0.042  # [m] distance of a lateral elbow marker from the joint centre


def exchanged_wrists(markers: Markers, marks: Mapping[str, str | None]) -> Exchange:
    """Return the wrist markers that are exchanged through a whole recording."""
    label = {mark: name for name, mark in marks.items() if mark and name in markers.names}
    found = {}
    for side in SIDES:
        pair = [label.get(f"wrist_{which}_{side}") for which in ("radial", "ulnar")]
        if None not in pair and thumb_side(markers, label, side) < MIN_PRONATION_SINE:
            found |= {str(pair[0]): str(pair[1]), str(pair[1]): str(pair[0])}
    return Exchange(found)


def thumb_side(markers: Markers, label: Mapping[str, str], side: str) -> float:
    """Return the sine of the forearm's pronation as the wrist markers show it, median of frames.

    It is 1 with the thumb in front, and NaN where markers of the arm are missing.

    Args:
        side: ``"r"`` or ``"l"``.
    """

    def at(mark: str) -> Float[Array, "n_frames 3"]:
        name = label.get(f"{mark}_{side}")
        if name is None:
            return np.full((markers.n_frames, 3), np.nan)
        return markers.positions[:, markers.index(name)]

    shoulder, elbow, medial = at("acromion"), at("elbow_lateral"), at("elbow_medial")
    radial, ulnar = at("wrist_radial"), at("wrist_ulnar")
    sign = 1.0 if side == "r" else -1.0
    u, v = elbow - shoulder, (radial + ulnar) / 2 - elbow
    outward = unit_vectors(elbow - medial)
    if np.isnan(outward).all():
        outward = _outward(u, v, sign)
        v = v + ELBOW_MARKER_OFFSET * outward
    else:
        v = v + (elbow - medial) / 2
    front = np.cross(sign * outward, unit_vectors(v))
    sines = (unit_vectors(radial - ulnar) * front).sum(axis=1)
    return float(np.nanmedian(sines)) if np.isfinite(sines).any() else float("nan")


def _outward(
    u: Float[Array, "n_frames 3"], v: Float[Array, "n_frames 3"], sign: float
) -> Float[Array, "n_frames 3"]:
    """Return the direction of the elbow's axis, outwards, from shoulder to elbow to wrist.

    It meets :data:`ELBOW_MARKER_OFFSET` along both, and the elbow bends forward about it.
    """
    uu, vv, uv = (u * u).sum(axis=1), (v * v).sum(axis=1), (u * v).sum(axis=1)
    area = np.maximum(uu * vv - uv**2, 1e-12)
    a, b = ELBOW_MARKER_OFFSET * (vv + uv) / area, -ELBOW_MARKER_OFFSET * (uu + uv) / area
    within = a[:, None] * u + b[:, None] * v
    across = np.sqrt(np.maximum(1 - (within**2).sum(axis=1), 0.0))
    return unit_vectors(within + sign * across[:, None] * unit_vectors(np.cross(u, v)))
