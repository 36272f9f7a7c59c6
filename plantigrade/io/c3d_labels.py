"""Which points of a C3D file are skin markers and which were computed.

C3D stores markers, joint centres and segment axes of a model, joint angles and moments in one list
of points. A fit must use the markers only. In this order, a point is

1. *unlabelled*, if it has no name or one that programs give to stray trajectories (``*17``);
2. *typed*, if POINT:TYPE_GROUPS puts it into a group: ANGLES, FORCES, MOMENTS, POWERS, SCALARS,
   MODELED_MARKERS or the manufacturer's own;
3. *typed*, if its name ends like an output of Plug-in Gait and related models (``LKneeAngles``,
   ``RHipMoment``, ``LNormalisedGRF``);
4. *computed*, if it belongs to a complete segment frame: four names with one stem and the endings
   O A L P (Plug-in Gait) or 0 1 2 3 (Oxford Foot Model), whose three arms stay perpendicular to
   each other in every frame, as no four markers do;
5. *computed*, if its name is one that models use for points no one can put a marker on: joint
   centres (``LHJC``, ``RKJC``), centre of mass, projections, arch height, leg length;
6. *computed*, in a file with Oxford Foot Model frames, if it is one of that model's helper points
   (``LHE1``, ``RD1M0``, ``LPROXFF``, ``RTIB1`` …);
7. *computed*, if it carries residual 0 and is seen in every frame it exists in while most points
   of the file carry positive residuals: the format's own mark of a calculated point;
8. a *marker* otherwise.

MODELED_MARKERS count as markers only where nothing else would be left.
"""

import re
from dataclasses import dataclass

import numpy as np

from plantigrade.io.c3d_file import C3dFile
from plantigrade.io.text import unique_labels

_UNLABELLED = re.compile(
    r"(|\*\d*|[uc]_\d+|uname\*?\d*|unlabell?ed.*|unknown.*|unnamed.*|traj\w*\d+)", re.I
)
_TYPED_NAME = re.compile(
    r".*(angles?|forces?|moments?|powers?|grf|torques?|velocity|scalars?)(_?[lr])?(harrington)?",
    re.I,
)
_COMPUTED_NAME = re.compile(
    r"([lr]?_?(h|k|a|s|e|w|mtp)jc\w*|[lr]?(hip|knee|ankle|shoulder|elbow|wrist)_?(joint)?_?"
    r"cent(re|er)\w*|cent(re|er)_?of_?mass\w*|(whole_?body_?)?com(_?floor|_?[xyz])?|cog|proj\w+"
    r"|[lr]?arch_?height\w*|[lr]?\w*leg_?length)",
    re.I,
)
_OXFORD_HELPER = re.compile(
    r"(pel0|[lr](tib[0-3]|ank1|he1|kax|d1m0|d5m0|proxff|distff|hfplantar|[dp][15]mlat|mma[xyz]))",
    re.I,
)
_FRAME_ENDS = (("O", "A", "L", "P"), ("0", "1", "2", "3"))
_MARKER_GROUPS = {"MARKERS", "MARKER", "LABELED_MARKERS"}


@dataclass(frozen=True)
class LabelledPoints:
    """Columns of a file's points by kind."""

    names: tuple[str, ...]  #: Clean, unique name per column
    markers: tuple[int, ...]  #: Columns of markers
    computed: tuple[int, ...]  #: Columns of positions computed by a model
    typed: tuple[int, ...]  #: Columns of angles, forces, moments, powers, scalars (no positions)
    unlabelled: tuple[int, ...]  #: Columns of stray trajectories
    warnings: tuple[str, ...]  #: Warnings for the user


def sort_points(file: C3dFile) -> LabelledPoints:
    """Return the file's points by kind."""
    n = file.points.shape[1]
    raw = file.strings("POINT", "LABELS")[:n]
    warnings = []
    if len(raw) < n:
        warnings.append(f"{n - len(raw)} of {n} points have no label")
        raw += [""] * (n - len(raw))
    plain = _without_prefix(raw)
    groups = _groups(file)
    kinds = []
    stems = _frame_members(plain, file.points)
    oxford = any(re.fullmatch(r"[LR](HDF|FOF)[0-3]", plain[i], re.I) for i in stems)
    by_residual = _computed_by_residual(file)
    for i, name in enumerate(plain):
        group = groups.get(raw[i]) or groups.get(name)
        if _UNLABELLED.fullmatch(name):
            kinds.append("unlabelled")
        elif group == "MODELED_MARKERS":
            kinds.append("modeled")
        elif group or (_TYPED_NAME.fullmatch(name) and i not in stems):
            kinds.append("typed")
        elif (
            i in stems
            or _COMPUTED_NAME.fullmatch(name)
            or (oxford and _OXFORD_HELPER.fullmatch(name))
            or by_residual[i]
        ):
            kinds.append("computed")
        else:
            kinds.append("marker")
    if "marker" not in kinds:  # a file of a model's points only is still worth fitting
        kinds = ["marker" if kind == "modeled" else kind for kind in kinds]
    kinds = ["computed" if kind == "modeled" else kind for kind in kinds]

    def columns(kind: str) -> tuple[int, ...]:
        return tuple(i for i, found in enumerate(kinds) if found == kind)

    names = unique_labels([name or f"*{i + 1}" for i, name in enumerate(plain)], warnings)
    return LabelledPoints(
        names,
        columns("marker"),
        columns("computed"),
        columns("typed"),
        columns("unlabelled"),
        tuple(warnings),
    )


def _without_prefix(labels: list[str]) -> list[str]:
    """Remove the prefix ``Name:`` if all labelled points share it."""
    prefixes = {label.split(":", 1)[0] if ":" in label else None for label in labels if label}
    prefixes = {p for p in prefixes if p is not None} | (
        {None}
        if any(label and ":" not in label and not _UNLABELLED.fullmatch(label) for label in labels)
        else set()
    )
    named = {p for p in prefixes if p is not None}
    if len(named) != 1:  # none, or two people in one file: then the prefix tells them apart
        return labels
    prefix = named.pop() + ":"
    stripped = [label.removeprefix(prefix) for label in labels]
    bare = {label for label in labels if ":" not in label}
    return [
        new if new not in bare or new == old else old
        for new, old in zip(stripped, labels, strict=True)
    ]


def _groups(file: C3dFile) -> dict[str, str]:
    """Return the type group of each label from POINT:TYPE_GROUPS and related parameters."""
    names = {"ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "MODELED_MARKERS"}
    names.update(name for name in file.strings("POINT", "TYPE_GROUPS")[::2] if name)
    found = {}
    for name in sorted(names - _MARKER_GROUPS):
        for label in file.strings("POINT", name.upper()):
            found[label] = name.upper()
    return found


def _frame_members(names: list[str], points: np.ndarray) -> set[int]:
    where = {name: i for i, name in enumerate(names)}
    members: set[int] = set()
    for ends in _FRAME_ENDS:
        for name in names:
            if name.endswith(ends[0]) and len(name) > 1:
                four = [where[name[:-1] + end] for end in ends if name[:-1] + end in where]
                if len(four) == 4 and _is_frame(points[:, four]):
                    members.update(four)
    return members


def _is_frame(points: np.ndarray) -> bool:
    """Return whether three arms from the first point stay perpendicular to each other."""
    points = points[np.isfinite(points).all(axis=(1, 2))]
    if len(points) == 0:
        return True  # nothing to be mistaken for a marker
    points = points[:: max(1, len(points) // 50)]
    arms = points[:, 1:] - points[:, :1]
    length = np.linalg.norm(arms, axis=2, keepdims=True)
    if not (length > 0).all():
        return False
    arms = arms / length
    cosines = np.abs(np.einsum("fia,fja->fij", arms, arms) - np.eye(3))
    return bool(cosines.max() < 0.01)


def _computed_by_residual(file: C3dFile) -> np.ndarray:
    seen = file.residuals >= 0
    measured = np.any(file.residuals > 0, axis=0)
    if file.points.shape[1] < 4 or measured.mean() < 0.5:
        return np.zeros(file.points.shape[1], dtype=bool)
    return ~measured & np.any(seen, axis=0)
