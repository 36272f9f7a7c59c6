"""Marker sets: the landmark of each marker name.

Five sets are built in; other names are compared with common spellings of the landmarks
(``R.ASIS``, ``RASI``, ``R_ASIS``, ``asis_r``, ``RIAS`` are one point; see
:mod:`plantigrade.models.spellings`). A user's own set is a small TOML file::

    name = "my lab"
    [markers]
    RKN1 = "knee_lateral_r"                                  # on a landmark
    RTH7 = { body = "femur_r", position = [0.05, -0.09, -0.2] } # or on a body, in its frame [m]
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from plantigrade.bounds import shown
from plantigrade.errors import FileError, ParameterError
from plantigrade.models.human import Human
from plantigrade.models.keypoints import KEYPOINTS
from plantigrade.models.landmarks import BONE_SPREAD, LOOSE_SPREAD, Attachment, attachments
from plantigrade.models.mirror import mirrored_name
from plantigrade.models.spellings import landmark_of
from plantigrade.options import is_real
from plantigrade.toml import parse_toml, read_toml


@dataclass(frozen=True)
class MarkerSet:
    """Marker names and their landmarks."""

    name: str  #: Name of the set
    landmarks: dict[str, str]  #: Marker name → landmark name (with side)
    #: Marker name → (body name, position in its frame [m]) for markers placed by hand
    fixed: dict[str, tuple[str, tuple[float, float, float]]]


def other_side(name: str, names: Iterable[str]) -> str | None:
    """Return the name among these with the same spelling for the other side, or None.

    Example:
        >>> other_side("r_thigh1", ["L_thigh1", "L_thigh2"]), other_side("Ann:LKNE", ["Ann:RKNE"])
        ('L_thigh1', 'Ann:RKNE')
    """
    spelled = {n.lower(): n for n in names}
    return next((spelled[n] for n in _toggled(name) if n in spelled), None)


def side_of(name: str, names: Iterable[str]) -> str | None:
    """Return ``"r"`` or ``"l"`` for a name with a twin among these, otherwise None.

    Example:
        >>> side_of("RTH1", ["LTH1", "LTH2"]), side_of("Rod", ["LTH1"])
        ('r', None)
    """
    twin = other_side(name, names)
    if twin is None:
        return None
    changed = zip(_bare(name).lower(), _bare(twin).lower(), strict=False)
    return next(a for a, b in changed if a != b)


def names_of_other_sides(
    names: Sequence[str], marker_set: MarkerSet | None = None
) -> tuple[str, ...]:
    """Return the names with left and right exchanged; names without side are unchanged.

    The new name is its twin among these or else the spelling of the other side's landmark.
    """
    chosen = marker_set or best_set(names)
    marks = {n: chosen.landmarks.get(n) or landmark_of(_bare(n)) or "" for n in names}
    at = {mark: n for n, mark in marks.items() if list(marks.values()).count(mark) == 1}
    new = []
    for name in names:
        mirrored = mirrored_name(marks[name])
        twin = at.get(mirrored) if mirrored != marks[name] else None
        twin = twin or other_side(name, names)
        if twin is None and mirrored != marks[name]:
            spelled = (n.upper() for n in _toggled(name) if landmark_of(_bare(n)) == mirrored)
            twin = next(spelled, None)
        new.append(twin or name)
    return tuple(new) if len(set(new)) == len(new) else tuple(names)


def _toggled(name: str) -> list[str]:
    """Return possible spellings of the name for the other side, in lower case."""
    owner, colon, bare = name.lower().rpartition(":")
    found = []
    for a, b in (("right", "left"), ("left", "right"), ("r", "l"), ("l", "r")):
        found += [b + bare.removeprefix(a)] if bare.startswith(a) else []
        found += [bare.removesuffix(a) + b] if bare.endswith(a) else []
    return [owner + colon + word for word in found]


def _landmarks(
    sided: str, midline: str = "", own: dict[str, str] | None = None, dot: str = ""
) -> dict[str, str]:
    """Return the landmark of each marker of a set.

    Args:
        sided: Names that are prefixed with R and L.
        midline: Complete names of the others.
        own: Landmarks of names whose common spelling means something else.
        dot: Separator between side and name.
    """
    own = own or {}
    found = {name: own.get(name) or landmark_of(name) for name in midline.split()}
    for name in sided.split():
        for side in "RL":
            mark = f"{own[name]}_{side.lower()}" if name in own else landmark_of(side + name)
            found[f"{side}{dot}{name}"] = mark
    return {name: mark for name, mark in found.items() if mark}


_TRUNK = "C7 T2 T6 T10 T12 CLAV STRN RBAK SACR"
_PLUG_IN_GAIT = "FHD BHD SHO UPA ELB FRM WRA WRB FIN ASI PSI THI KNE KNM TIB ANK MED HEE TOE"
_OXFORD_FOOT = "HFB TUB SHN MMA CPG PCA LCA STL NAV P1M D1M P5M D5M HLX"
_GAIT2392 = (
    "ASIS Thigh.Upper Thigh.Front Thigh.Rear Knee.Lat Knee.Med Shank.Upper Shank.Front Shank.Rear "
    "Ankle.Lat Ankle.Med Heel Midfoot.Sup Midfoot.Lat Toe.Tip Toe.Lat Toe.Med Acromium Bicep Elbow "
    "Wrist.Med Wrist.Lat Temple"
)
_GAIT2392_OWN = {
    "Thigh.Upper": "thigh_upper",
    "Thigh.Rear": "thigh_rear",
    "Shank.Upper": "shank_upper",
    "Shank.Rear": "shank_rear",
    "Midfoot.Sup": "midfoot",
    "Midfoot.Lat": "midfoot_lateral",
    "Toe.Lat": "toe_lateral",
    "Toe.Med": "toe_medial",
    # in anatomical hanging with the thumbs forward the lateral side of the wrist is ulnar
    "Wrist.Lat": "wrist_ulnar",
    "Wrist.Med": "wrist_radial",
}
_RAJAGOPAL = (
    "ASIS PSIS Knee MKnee Ankle MAnkle Heel MT5 Toe Shoulder Clavicle Biceps Elbow MElbow Forearm "
    "Wrist"
)
_MED = {"MED": "ankle_medial"}

MARKER_SETS: dict[str, MarkerSet] = {
    name: MarkerSet(name, landmarks, {})
    for name, landmarks in {
        "plug-in-gait": _landmarks(_PLUG_IN_GAIT, _TRUNK, _MED),
        "oxford-foot-model": _landmarks(f"{_PLUG_IN_GAIT} {_OXFORD_FOOT}", _TRUNK, _MED),
        "gait2392": _landmarks(_GAIT2392, "V.Sacral Sternum Top.Head", _GAIT2392_OWN, "."),
        "keypoints": KEYPOINTS,
        "rajagopal": _landmarks(_RAJAGOPAL, "S2", {"Toe": "hallux"}, "."),
    }.items()
}


def _bare(name: str) -> str:
    """Return a marker name without the subject prefix: ``Ann:LKNE`` is ``LKNE``."""
    return name.rpartition(":")[2]


def best_set(names: Iterable[str]) -> MarkerSet:
    """Return the built-in set that contains most of the names, the first in a tie."""
    names = {_bare(name) for name in names}
    return max(MARKER_SETS.values(), key=lambda s: len(names & set(s.landmarks)))


def landmark_names(
    names: Iterable[str], marker_set: MarkerSet | None = None
) -> dict[str, str | None]:
    """Return the landmark of each marker by its name; None if its name is unknown.

    Args:
        names: Marker names as in the recording.
        marker_set: The set to use first; by default the best built-in one.
    """
    names = list(names)
    known = (marker_set or best_set(names)).landmarks
    return {n: known.get(n) or known.get(_bare(n)) or landmark_of(_bare(n)) for n in names}


def place_markers(
    names: Iterable[str], human: Human, marker_set: MarkerSet | None = None
) -> dict[str, Attachment | None]:
    """Return the attachment of each marker on the person; None if its name is unknown.

    Args:
        names: Marker names as in the recording.
        marker_set: The set to use first; by default the best built-in one.
    """
    names = list(names)
    chosen = marker_set or best_set(names)
    places = attachments(human)
    result: dict[str, Attachment | None] = {}
    for name, mark in landmark_names(names, chosen).items():
        if name in chosen.fixed:
            body, position = chosen.fixed[name]
            human.body(body)
            result[name] = Attachment(body, np.array(position), LOOSE_SPREAD / 3)
            continue
        if mark is not None and mark not in places:
            raise ParameterError(
                f"marker set {chosen.name!r} puts {name} on {mark!r}; there is no such landmark; "
                f"there are {', '.join(sorted(places))}"
            )
        place = places[mark] if mark else None
        if place is not None and place.spread < BONE_SPREAD and _bare(name) in KEYPOINTS:
            place = replace(
                place, spread=BONE_SPREAD
            )  # detected in images, not computed from markers
        result[name] = place
    return result


def places_of(marker_set: MarkerSet, human: Human) -> dict[str, Attachment]:
    """Return the place on the person of every marker of a set, by name.

    Raises:
        ParameterError: If the set names a landmark or body that does not exist.
    """
    placed = place_markers([*marker_set.landmarks, *marker_set.fixed], human, marker_set)
    return {name: place for name, place in placed.items() if place is not None}


def landmarks_of(names: Iterable[str], marker_set: MarkerSet | None = None) -> dict[str, str]:
    """Return landmark → marker for markers with a known landmark, the first of each.

    Args:
        names: Marker names as in the recording.
        marker_set: The set to use first; by default the best built-in one.
    """
    names = list(names)
    chosen = marker_set or best_set(names)
    found: dict[str, str] = {}
    for name, mark in landmark_names(names, chosen).items():
        if mark is not None and name not in chosen.fixed:
            found.setdefault(mark, name)
    return found


def marker_set_of(name: str) -> MarkerSet:
    """Return a built-in marker set by its name, or a user's by the path of its TOML file.

    Raises:
        ParameterError: If it is neither.
        FileError: If the file cannot be read.
    """
    if name in MARKER_SETS:
        return MARKER_SETS[name]
    if name.lower().endswith(".toml"):
        return read_marker_set(name)
    raise ParameterError(
        f"marker set {name!r} is not known; allowed are {', '.join(MARKER_SETS)} "
        "or the path of a .toml file"
    )


def read_marker_set(path: str | Path) -> MarkerSet:
    """Read a user's marker set; the module describes the format."""
    path = Path(path)
    content = parse_toml(read_toml(path), path, _EXAMPLE)
    markers = content.get("markers")
    if not isinstance(markers, dict) or not markers:
        raise FileError(path, "has no [markers] table", remedy=_EXAMPLE)
    named: dict[str, str] = {}
    fixed: dict[str, tuple[str, tuple[float, float, float]]] = {}
    for name, value in markers.items():
        match value:
            case str():
                named[name] = value
            case {"body": str(body), "position": [x, y, z]} if all(
                is_real(v) and abs(v) <= MAX_MARKER_OFFSET for v in (x, y, z)
            ):
                fixed[name] = (body, (float(x), float(y), float(z)))
            case _:
                problem = f"{shown(value)} is not an attachment"
                raise FileError(path, problem, where=f"marker {name}", remedy=_EXAMPLE)
    return MarkerSet(str(content.get("name", path.stem)), named, fixed)


MAX_MARKER_OFFSET = 1.0  # [m] maximum coordinate of a marker in the frame of its body

_EXAMPLE = (
    'write lines like RKNE = "knee_lateral_r" or '
    'RTH7 = { body = "femur_r", position = [0.05, -0.09, -0.2] } under [markers]'
)
