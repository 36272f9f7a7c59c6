r"""Angles between the segments of the foot from markers, as in the Oxford Foot Model.

Segments, axes and signs are those of [Carson2001]_ and [Stebbins2006]_ as implemented by Vicon
(described by [Dixon2025]_):

* *tibia*: that of Plug-in Gait (:func:`tibia_axes`).
* *hindfoot* (calcaneus): forward parallel to the floor in standing, in the plane of heel, upper
  heel and the middle between sustentaculum and lateral calcaneus.
* *forefoot* (metatarsals): the plane of both outer metatarsal heads and the base of the fifth;
  forward from the middle of the bases to the toe marker in that plane.
* *hallux*: forward from the first metatarsal head to the hallux marker. Two markers do not
  define its axial rotation, so only its dorsiflexion is given.

The first metatarsal head (virtual medial toe line) and the upper heel carry markers in standing
only; their positions relative to the others are taken from the standing trial. Each of four markers
on a segment is moved halfway to its mean position relative to the other three, and replaced by that
position while it is hidden.

Rotations relative to the segment above are intrinsic, about the left axis (dorsiflexion), the
vertical axis (adduction, internal rotation) and the forward axis (supination, inversion), in this
order. All are positive in the named sense on both sides.
"""

from collections.abc import Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.spatial.conventions import axes_along, unit_vectors

Paths = Mapping[str, Float[Array, "n_frames 3"]]
"""Landmark, without side → path of its marker [m]; NaN while hidden."""

# Segment pair → its angles in the order of rotation: about left (backwards), up and forward.
FOOT_ANGLES: dict[str, tuple[str, ...]] = {
    "hindfoot": ("dorsiflexion", "internal_rotation", "inversion"),
    "forefoot": ("dorsiflexion", "adduction", "supination"),
    "forefoot_to_tibia": ("dorsiflexion", "adduction", "supination"),
    "hallux": ("dorsiflexion",),
}
_SEGMENTS = {
    "hindfoot": ("tibia", "hindfoot"),
    "forefoot": ("hindfoot", "forefoot"),
    "forefoot_to_tibia": ("tibia", "forefoot"),
    "hallux": ("forefoot", "hallux"),
}
FOREFOOT = ("metatarsal_1_base", "metatarsal_5_head", "metatarsal_2_head", "metatarsal_5_base")
HINDFOOT = ("heel", "heel_lateral", "sustentaculum", "heel_wand")
NEEDED = (*FOREFOOT, *HINDFOOT[:3])
"""Landmarks with required markers; the wand on the heel is optional."""
WORN_IN_STANDING = ("metatarsal_1_head", "heel_upper")
"""Landmarks with markers in the standing trial only."""
FOOT_MARKER = 0.0095  #: Diameter of the markers on the feet in the model's protocol [m]
# The Oxford Foot Model's right side in our axes; the left is its mirror image.
_SIGNS = {"r": np.array([-1.0, 1.0, 1.0]), "l": np.array([-1.0, -1.0, -1.0])}


def foot_angles(
    seen: Paths, standing: Paths, tibia: Float[Array, "n_frames 3 3"], side: str
) -> dict[str, np.ndarray]:
    """Return the angles between the segments of one foot over time [rad]; NaN while hidden.

    Args:
        seen: Markers in the trial, at least those of :data:`NEEDED`.
        standing: Markers in standing, with :data:`WORN_IN_STANDING`, z upwards.
        tibia: Rotation from the axes of the tibia (forward, left, up) to the world's, in the trial.
        side: ``"r"`` or ``"l"``.

    Returns:
        ``hindfoot_dorsiflexion_r``, ``forefoot_to_tibia_adduction_l``, …: the pairs of
        :data:`FOOT_ANGLES`, their angles, the side.
    """
    axes = segment_axes(seen, standing, tibia, side)
    found = {}
    for pair, kinds in FOOT_ANGLES.items():
        above, below = _SEGMENTS[pair]
        if below in axes:
            angles = joint_angles(axes[above], axes[below], side)
            found |= {f"{pair}_{what}_{side}": angles[:, k] for k, what in enumerate(kinds)}
    return found


def joint_angles(
    above: Float[Array, "n 3 3"], below: Float[Array, "n 3 3"], side: str
) -> Float[Array, "n 3"]:
    """Return dorsiflexion, adduction and supination relative to the segment above [rad].

    Rotations are from the segments' axes (forward, left, up) to the world's; NaN gives NaN.
    """
    from scipy.spatial.transform import Rotation

    relative = np.swapaxes(above, 1, 2) @ below
    known = np.isfinite(relative).all(axis=(1, 2))
    angles = np.full((len(relative), 3), np.nan)
    if known.any():
        angles[known] = Rotation.from_matrix(relative[known]).as_euler("YZX") * _SIGNS[side]
    return angles


def segment_axes(
    seen: Paths, standing: Paths, tibia: Float[Array, "n_frames 3 3"], side: str
) -> dict[str, Float[Array, "n_frames 3 3"]]:
    """Return segment → rotation from its axes (forward, left, up) to the world's.

    The arguments are those of :func:`foot_angles`. The hallux is missing if it has no marker.
    """
    medial = 1.0 if side == "r" else -1.0  # direction from lateral to medial, along the left axis
    fore, rest = steadied(seen, FOREFOOT), steadied(standing, FOREFOOT)
    head_1 = seen.get("metatarsal_1_head")
    if head_1 is None:
        place = standing["metatarsal_1_head"]
        head_1 = _carried(_forefoot_frame(rest), _forefoot_frame(fore), place)
    left = medial * (head_1 - fore["metatarsal_5_head"])
    sole = (head_1, fore["metatarsal_5_head"], fore["metatarsal_5_base"])
    base_1, base_5 = _onto(fore["metatarsal_1_base"], *sole), fore["metatarsal_5_base"]
    # The lateral marker is offset from its bone laterally, the medial one upwards.
    width = np.linalg.norm(base_5 - base_1, axis=1)[:, None]
    middle = base_1 + (base_5 - base_1) * (0.5 - FOOT_MARKER / (4 * width))
    axes = {
        "tibia": tibia,
        "hindfoot": _hindfoot(seen, standing),
        "forefoot": axes_along(_onto(fore["metatarsal_2_head"], *sole) - middle, left),
    }
    if "hallux" in seen:
        axes["hallux"] = axes_along(seen["hallux"] - head_1, left)
    return axes


def tibia_axes(
    seen: Paths, hip: Float[Array, "n_frames 3"], knee: float, ankle: float, side: str
) -> Float[Array, "n_frames 3 3"] | None:
    """Return the rotation from the axes of Plug-in Gait's tibia (forward, left, up) to the world's.

    Knee and ankle joint centre lie at a given distance from their markers, in the plane of that
    marker, the joint centre above and the marker on the segment between [Davis1991]_; the frontal
    plane of the tibia is that of knee centre, shank marker and lateral malleolus.

    Args:
        seen: Markers; those of thigh, knee, shank and lateral malleolus are used.
        hip: Hip joint centre [m].
        knee: Distance from the knee marker to the joint centre [m].
        ankle: Distance from the malleolus marker to the joint centre [m].
        side: ``"r"`` or ``"l"``.

    Returns:
        One rotation per frame; None if one of the markers is missing.
    """
    if not {"thigh", "knee_lateral", "shank", "ankle_lateral"} <= set(seen):
        return None
    above = _beside(hip, seen["thigh"], seen["knee_lateral"], knee)
    below = _beside(above, seen["shank"], seen["ankle_lateral"], ankle)
    outwards = unit_vectors(seen["ankle_lateral"] - below)
    z = unit_vectors(above - below)
    x = unit_vectors(np.cross(outwards if side == "l" else -outwards, z))
    return np.stack([x, np.cross(z, x), z], axis=-1)


def _beside(
    proximal: np.ndarray, segment: np.ndarray, joint: np.ndarray, distance: float
) -> np.ndarray:
    """Return the joint centre at a right angle between its marker and the centre above."""
    along = proximal - joint
    cosine = distance / np.linalg.norm(along, axis=1)[:, None]
    along = unit_vectors(along)
    out = segment - joint
    out = unit_vectors(out - along * np.sum(out * along, axis=1)[:, None])
    return joint + distance * (cosine * along - np.sqrt(1 - cosine**2) * out)


def steadied(seen: Paths, names: tuple[str, ...]) -> dict[str, Float[Array, "n_frames 3"]]:
    """Return four markers of a segment, each moved halfway to its mean relative position.

    That is the position relative to the other three, averaged over all frames. It replaces a hidden
    marker. Fewer than four markers are returned unchanged.
    """
    here = [n for n in names if n in seen]
    if len(here) < 4:
        return {name: seen[name] for name in here}
    result = {}
    for i, name in enumerate(here):
        second, first, last = (seen[here[(i + k) % 4]] for k in (1, 2, 3))
        frame = (first, axes_along(second - first, first - last))
        given = _carried(frame, frame, seen[name])
        both = np.where(np.isfinite(given), 0.5 * (seen[name] + given), seen[name])
        result[name] = np.where(np.isfinite(seen[name]), both, given)
    return result


def unsteadiness(seen: Paths) -> float:
    """Return the RMS deviation of the markers of a foot from rigid segments [m].

    It is the distance from the mean position relative to the other three markers of a segment.
    """
    apart = [
        2.0 * np.linalg.norm(there - seen[name], axis=1)
        for names in (FOREFOOT, HINDFOOT)
        for name, there in steadied(seen, names).items()
    ]
    return float(np.sqrt(np.nanmean(np.square(apart))))


def _hindfoot(seen: Paths, standing: Paths) -> np.ndarray:
    now, rest = steadied(seen, HINDFOOT), steadied(standing, HINDFOOT)
    heel = rest["heel"]
    middle = 0.5 * (rest["heel_lateral"] + rest["sustentaculum"])
    ahead = _onto(standing["metatarsal_5_base"], heel, standing["heel_upper"], middle)
    ahead = np.column_stack(
        [ahead[:, :2], heel[:, 2]]
    )  # at the height of the heel, because the foot is flat
    frames = _hindfoot_frame(rest), _hindfoot_frame(now)
    x = _carried(*frames, ahead) - now["heel"]
    above = seen.get("heel_upper")
    above = (_carried(*frames, standing["heel_upper"]) if above is None else above) - now["heel"]
    x, y = unit_vectors(x), unit_vectors(np.cross(above, x))
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _forefoot_frame(fore: Paths) -> tuple[np.ndarray, np.ndarray]:
    base_1, head_5, toe, base_5 = (fore[name] for name in FOREFOOT)
    return base_1, axes_along(base_1 - head_5, toe - base_5)


def _hindfoot_frame(hind: Paths) -> tuple[np.ndarray, np.ndarray]:
    heel, lateral, medial = (hind[name] for name in HINDFOOT[:3])
    return heel, axes_along(heel - 0.5 * (lateral + medial), medial - lateral)


def _carried(here, there, point: np.ndarray) -> np.ndarray:
    """Return a point's mean position in frames ``here`` (origin, rotation), moved to ``there``."""
    (origin, rotation), (new_origin, new_rotation) = here, there
    local = np.einsum("fji,fj->fi", rotation, point - origin)
    return new_origin + new_rotation @ np.nanmean(local, axis=0)


def _onto(point: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the foot of the perpendicular from a point to the plane of three others."""
    normal = unit_vectors(np.cross(b - a, c - a))
    return point - normal * np.sum((point - a) * normal, axis=1)[:, None]
