"""Files with the pose parameters of SMPL: their arrays, found by name and checked."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.errors import FileError
from plantigrade.io.length import check_length
from plantigrade.io.npz import Arrays
from plantigrade.io.pickles import read_pickle
from plantigrade.io.smpl_tree import NAMES

RATES = (1.0, 1000.0)  # [Hz] allowed
MAX_ANGLE = 1e3  # [rad] of a rotation vector
MAX_SPEED = 15.0  # [m/s] median of the pelvis; the fastest sprinters reach 12.4 for moments
_JOINTS = len(NAMES)
_MODELS = (22, 24, 52, 55)  # [joints] of a whole pose: SMPL without and with hands, -H, -X
_UNIT = 1e-2  # [1] deviation of a rotation matrix from one
_BYTES = 8 * 9 * 8  # [bytes] per joint and frame: eight arrays of matrices while reading
_RATE_KEYS = ("mocap_framerate", "mocap_frame_rate", "framerate", "frame_rate", "fps")
_REMEDY = "give an AMASS file (poses, trans) or the result of a video tool in world axes"


@dataclass(frozen=True)
class Layout:
    """Names of the arrays of one kind of file."""

    name: str  #: Name in messages
    poses: tuple[str, ...]  #: Arrays of rotations, joined: the root and 21 joints come first
    trans: str  #: Array of translations
    up: str  #: Vertical where the motion does not show it
    at_hips: bool = False  #: Whether the translation is that of the middle of the hips


LAYOUTS = (
    Layout("WHAM", ("pose_world",), "trans_world", "y", at_hips=True),
    Layout("AIST++", ("smpl_poses",), "smpl_trans", "y"),
    Layout("AMASS", ("poses",), "trans", "z"),
    Layout("AMASS", ("root_orient", "pose_body"), "trans", "z"),
    Layout("SMPL", ("poses",), "transl", "z"),
    Layout("SMPL", ("global_orient", "body_pose"), "transl", "y"),
    Layout("SMPL", ("global_orient", "body_pose"), "trans", "y"),
    Layout("SMPL", ("root_orient", "pose_body"), "transl", "y"),
)
"""Kinds of files, by their keys."""
_CAMERA = ("smpl_params_incam", "pred_rotmat", "pred_cam", "camera_bbox", "smpl", "pose")
_OTHERS = ("betas", "gender", "smpl_scaling", *_RATE_KEYS)
_KEYS = {key for each in LAYOUTS for key in (*each.poses, each.trans)} | {*_OTHERS}


def contents_of(path: Path) -> Mapping[Any, Any]:
    """Return the arrays of a file by name."""
    if path.suffix.lower() == ".npz":
        arrays = Arrays(path, _REMEDY, only=_KEYS)
        return {key: arrays.any(key) for key in arrays.keys()}
    contents = read_pickle(path, _REMEDY)
    if not isinstance(contents, dict):
        raise FileError(path, "holds no named arrays", remedy=_REMEDY)
    return contents


def _layout_of(data: Any) -> Layout | None:
    if not isinstance(data, Mapping):
        return None
    return next((each for each in LAYOUTS if {*each.poses, each.trans} <= data.keys()), None)


def chosen(
    path: Path, contents: Mapping[Any, Any], warnings: list[str]
) -> tuple[Mapping[Any, Any], Layout]:
    """Return the arrays and layout of a motion: the world's of GVHMR, one of several people."""
    layout = _layout_of(contents)
    if layout is not None:
        return contents, layout
    inner = contents.get("smpl_params_global")
    found = [(inner, _layout_of(inner))] if inner is not None else [
        (person, _layout_of(person)) for person in contents.values()
    ]  # fmt: skip
    people = [(data, layout) for data, layout in found if layout is not None]
    if people:
        lengths = [np.size(data[layout.trans]) for data, layout in people]
        if len(people) > 1:
            warnings.append(f"the file has {len(people)} people; the one seen longest was read")
        return people[int(np.argmax(lengths))]
    named = {
        *contents,
        *(k for each in contents.values() if isinstance(each, Mapping) for k in each),
    }
    if named & {*_CAMERA}:
        raise FileError(
            path,
            "holds poses relative to a camera only, which has no ground to stand on",
            remedy="export the motion in world axes (GVHMR: smpl_params_global, WHAM: pose_world)",
        )
    keys = sorted(str(key)[:30] for key in contents)[:8]
    raise FileError(
        path, f"holds no SMPL motion, but {', '.join(keys) or 'nothing'}", remedy=_REMEDY
    )


def numbers(path: Path, data: Mapping[Any, Any], key: str) -> Any:
    """Return an array as floats."""
    value = data.get(key)
    if not isinstance(value, np.ndarray | np.generic | float | int):
        problem = "is missing" if value is None else "is not an array"
        raise FileError(path, problem, where=key, remedy=_REMEDY)
    value = np.asarray(value)
    if value.dtype.kind not in "fiub":
        raise FileError(path, f"holds {value.dtype}, not numbers", where=key, remedy=_REMEDY)
    value = value.astype(float)
    if not np.isfinite(value).all():
        raise FileError(path, "holds numbers that are not finite", where=key, remedy=_REMEDY)
    return value


def motion(path: Path, data: Mapping[Any, Any], layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the rotation matrices of all joints and the translations.

    Raises:
        FileError: If their shapes do not agree, or are those of no model.
    """
    trans = numbers(path, data, layout.trans)
    n = len(trans) if trans.ndim else 0
    if n == 0 or trans.size != 3 * n:
        problem = f"has shape {trans.shape}, not (frames, 3)"
        raise FileError(path, problem, where=layout.trans, remedy=_REMEDY)
    check_length(path, n, n * _JOINTS * _BYTES)
    parts = []
    for key in layout.poses:
        values = numbers(path, data, key)
        if values.ndim < 2 or len(values) != n:
            problem = f"has shape {values.shape}, but {layout.trans} has {n} frames"
            raise FileError(path, problem, where=key, remedy=_REMEDY)
        parts.append(_rotations(path, key, values, whole=len(layout.poses) == 1))
    local = np.concatenate(parts, axis=1)
    if local.shape[1] < _JOINTS:
        problem = f"has {local.shape[1]} joints with the root; {_JOINTS} are needed"
        raise FileError(path, problem, where=layout.poses[-1], remedy=_REMEDY)
    return local[:, :_JOINTS], trans.reshape(n, 3) / _scaling(path, data, layout)


def _scaling(path: Path, data: Mapping[Any, Any], layout: Layout) -> float:
    """Return file units per metre of the translation; AIST++ states them."""
    if layout.name != "AIST++" or "smpl_scaling" not in data:
        return 1.0
    scaling = numbers(path, data, "smpl_scaling")
    if scaling.size != 1 or not 1e-3 < scaling.item() < 1e3:
        problem = "is not one positive number"
        raise FileError(path, problem, where="smpl_scaling", remedy=_REMEDY)
    return float(scaling.item())


def _rotations(path: Path, key: str, values: np.ndarray, *, whole: bool) -> np.ndarray:
    """Return rotation matrices (n, joints, 3, 3) of rotation vectors or matrices."""
    n, each = len(values), values[0].size
    as_matrices = values.ndim in (3, 4) and values.shape[-2:] == (3, 3)
    joints = each // (9 if as_matrices else 3)
    if each % 3 or not joints:
        problem = f"has {each} columns, not three per joint"
        raise FileError(path, problem, where=key, remedy=_REMEDY)
    if whole and joints not in _MODELS:
        known = ", ".join(map(str, _MODELS))
        problem = f"has {joints} joints; {known} are known"
        raise FileError(path, problem, where=key, remedy=_REMEDY)
    rows = values.reshape(n, joints, -1)[:, :_JOINTS]
    if as_matrices:
        matrices = rows.reshape(n, -1, 3, 3)
        square = matrices @ np.swapaxes(matrices, 2, 3)
        if np.abs(square - np.eye(3)).max() > _UNIT or (np.linalg.det(matrices) < 0).any():
            problem = "holds matrices that are no rotations"
            raise FileError(path, problem, where=key, remedy=_REMEDY)
        return matrices
    largest = float(np.abs(rows).max(initial=0.0))
    if largest > MAX_ANGLE:
        problem = f"reaches {largest:.0e} rad, which is no rotation of a joint"
        raise FileError(path, problem, where=key, remedy=_REMEDY)
    return Rotation.from_rotvec(rows.reshape(-1, 3)).as_matrix().reshape(n, -1, 3, 3)


def check_speed(path: Path, layout: Layout, trans: np.ndarray, rate: float) -> None:
    """Refuse a pelvis that moves as no person does, as in a file in centimetres.

    Args:
        trans: Translations (n, 3) [m].
        rate: Frames per second [Hz].
    """
    moved = np.linalg.norm(np.diff(trans, axis=0), axis=1)
    speed = rate * float(np.median(moved)) if len(moved) else 0.0
    if speed > MAX_SPEED:
        raise FileError(
            path,
            f"moves the pelvis at {speed:.0f} m/s; at most {MAX_SPEED:g} m/s are allowed",
            where=layout.trans,
            remedy="give translations in metres and the frame rate of the motion",
        )


def rate_of_file(path: Path, data: Mapping[Any, Any]) -> float | None:
    """Return the frame rate of a file [Hz], None if it has none."""
    key = next((key for key in _RATE_KEYS if key in data), None)
    if key is None:
        return None
    rate = numbers(path, data, key)
    if rate.size != 1 or not RATES[0] <= rate.item() <= RATES[1]:
        raise FileError(path, "is no number of frames per second", where=key, remedy=_REMEDY)
    return float(rate.item())


def sex_of(data: Mapping[Any, Any]) -> str | None:
    """Return ``"male"`` or ``"female"``; files hold text, bytes, or the text of bytes."""
    word = data.get("gender")
    if isinstance(word, np.ndarray | np.generic):
        word = word.item() if word.size == 1 and word.dtype.kind in "SU" else None
    if isinstance(word, bytes):
        word = word.decode("latin1")
    word = word.strip("b'\" \0").lower() if isinstance(word, str) else ""
    return {"male": "male", "m": "male", "female": "female", "f": "female"}.get(word)


def is_smplx(data: Mapping[Any, Any], layout: Layout) -> bool:
    """Return whether the pelvis joint is that of SMPL-X, which lies lower in its model."""
    if layout.name in ("WHAM", "AIST++"):
        return False
    return layout.poses != ("poses",) or np.size(data["poses"]) == 165 * len(data["poses"])
