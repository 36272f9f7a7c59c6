"""Motions of the SMPL family: AMASS, and the results of video tools in the same pose parameters.

A frame is a rotation vector (axis times angle [rad]) for each joint, relative to its parent, and a
translation of the pelvis [m]; all rotations zero are a T-pose that faces z with y up. Layouts that
are recognised by their keys:

======================  ==========================================  =======  ==================
layout                  keys                                        up       source
======================  ==========================================  =======  ==================
AMASS (SMPL, -H, -X)    poses (n, 66, 72, 156 or 165), trans        z        [AMASS]_
parts of SMPL-X         root_orient, pose_body, trans               z        AMASS, 2021 files
SMPL parts              global_orient, body_pose, transl            y        smplx library
GVHMR                   smpl_params_global: the three above         y        its demo
WHAM                    {person: pose_world, trans_world (hips)}    y        its demo
AIST++                  smpl_poses, smpl_trans, smpl_scaling        y        its loader
======================  ==========================================  =======  ==================

The vertical is the axis (of y and z) along which the head is above the feet; where the motion does
not say, that of the table. Frames per second come from ``mocap_framerate``, ``mocap_frame_rate`` or
``fps``; video results have none and are taken as 30 per second.

**Lengths.** The body model turns the shape numbers ``betas`` into lengths, and its licence does not
let us ship it. Without it, lengths are those of a mean adult of the file's ``gender``, with legs
such that the feet stand (:mod:`plantigrade.io.smpl_legs`). A model file that is named as
``skeleton`` gives the lengths for the file's ``betas``.

**Pelvis.** In the T-pose the pelvis is that of a standing person, whose iliac spines lie 10 degrees
forward and down; rotations of the pelvis are turned to our frame, in which zero is 3 degrees.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.npz import Arrays
from plantigrade.io.pickles import read_pickle
from plantigrade.io.skeletons import FORWARD_LEFT_UP_OF_Y_UP, up_axis
from plantigrade.io.smpl_legs import LegFactors, leg_factors
from plantigrade.io.smpl_model import model_offsets
from plantigrade.io.smpl_tree import (
    MEAN_STATURE,
    NAMES,
    PARENTS,
    ROOT,
    forward_kinematics,
    mean_offsets,
    rest_positions,
)
from plantigrade.motion.recording import Recording, SkeletonMotion, Subject

VIDEO_RATE = 30.0  # [Hz] of files without a rate: the usual one of cameras
RATES = (1.0, 2000.0)  # [Hz] allowed
PELVIS_TILT = np.deg2rad(7.0)
"""Forward tilt of our pelvis frame in the T-pose [rad]: the iliac spines of standing people are
tilted by 10 degrees (of one AMASS sample with markers: 9.9), and by 2.9 in our frame at zero."""
MAX_ANGLE = 1e3  # [rad] of a rotation vector
_JOINTS = len(NAMES)
_WIDTHS = (66, 72, 156, 165)  # [columns] of whole poses: SMPL without and with hands, -H, -X
_RATE_KEYS = ("mocap_framerate", "mocap_frame_rate", "framerate", "frame_rate", "fps")
_REMEDY = "give an AMASS file (poses, trans) or the result of a video tool in world axes"


@dataclass(frozen=True)
class _Layout:
    """Names of the arrays of one kind of file.

    Attributes:
        name: Name in messages.
        poses: Arrays of rotations, joined: the root and 21 joints come first.
        trans: Array of translations.
        up: Vertical where the motion does not show it.
        at_hips: Whether the translation is that of the middle of the hips.
    """

    name: str
    poses: tuple[str, ...]
    trans: str
    up: str
    at_hips: bool = False


LAYOUTS = (
    _Layout("WHAM", ("pose_world",), "trans_world", "y", at_hips=True),
    _Layout("AIST++", ("smpl_poses",), "smpl_trans", "y"),
    _Layout("AMASS", ("poses",), "trans", "z"),
    _Layout("AMASS", ("root_orient", "pose_body"), "trans", "z"),
    _Layout("SMPL", ("poses",), "transl", "z"),
    _Layout("SMPL", ("global_orient", "body_pose"), "transl", "y"),
    _Layout("SMPL", ("global_orient", "body_pose"), "trans", "y"),
    _Layout("SMPL", ("root_orient", "pose_body"), "transl", "y"),
)
"""Kinds of files, by their keys."""
_CAMERA = ("smpl_params_incam", "pred_rotmat", "pred_cam", "camera_bbox", "smpl", "pose")
_OTHERS = ("betas", "gender", "smpl_scaling", "surface_model_type", *_RATE_KEYS)
_KEYS = {key for each in LAYOUTS for key in (*each.poses, each.trans)} | {*_OTHERS}


def read_smpl(
    path: str | Path, *, skeleton: str | Path | None = None, rate: float | None = None
) -> Recording:
    """Read a motion in the pose parameters of SMPL, SMPL-H or SMPL-X.

    Args:
        path: The ``.npz``, ``.pkl`` or ``.pt`` file.
        skeleton: Body model (``.npz`` with ``J_regressor``, ``v_template`` and ``shapedirs``) that
            gives the bone lengths for the file's ``betas``.
        rate: Frames per second [Hz]; by default that of the file, or 30.

    Returns:
        A recording with a ``skeleton`` of 22 joints, and the person's sex where it is given.

    Raises:
        FileError: If the file is damaged, holds anything but arrays, or no motion in world axes.
        ParameterError: If ``rate`` is not allowed.
    """
    path = Path(path)
    if rate is not None and not RATES[0] <= rate <= RATES[1]:
        raise ParameterError(f"rate is {rate:g} Hz; allowed is {RATES[0]:g} to {RATES[1]:g} Hz")
    contents = _contents(path)
    warnings: list[str] = []
    data, layout = _chosen(path, contents, warnings)
    local, trans = _motion(path, data, layout)
    hz = rate or _rate(path, data)
    if hz is None:
        hz = VIDEO_RATE
        warnings.append(f"the file has no frame rate: {hz:g} frames per second were assumed")
    sex = _sex(data)
    kind = "smplx" if _is_smplx(data, layout) else "smpl"
    if skeleton is None:
        offsets, pelvis = mean_offsets(MEAN_STATURE[sex], sex), np.array(ROOT[kind])
    else:
        offsets, pelvis = model_offsets(skeleton, _numbers(path, data, "betas"))
    body = FORWARD_LEFT_UP_OF_Y_UP
    world = _world_axes(path, local, trans, offsets, layout, warnings)
    local = body @ local @ body.T
    local[:, 0] = world @ body.T @ local[:, 0]
    hips = 0.5 * (offsets[1] + offsets[2])
    root = trans @ world.T + (world @ body.T @ pelvis)
    if layout.at_hips:
        root = trans @ world.T - local[:, 0] @ hips
    if skeleton is None:
        legs = leg_factors(local, root, offsets, hz)
        offsets = legs.scaled(offsets)
        warnings.append(_note(legs, offsets, data))
    R, p = forward_kinematics(local, root, offsets)
    R[:, 0] = R[:, 0] @ Rotation.from_rotvec([0.0, PELVIS_TILT, 0.0]).as_matrix()
    return Recording(
        source=path,
        skeleton=SkeletonMotion(
            names=NAMES,
            parents=PARENTS,
            time=np.arange(len(p)) / hz,
            positions=p,
            rotations=R,
            rest_positions=rest_positions(offsets),
            ends=np.full(p.shape, np.nan),
        ),
        subject=Subject(sex=sex),
        warnings=tuple(warnings),
        companions=() if skeleton is None else (Path(skeleton),),
    )


def _contents(path: Path) -> Mapping[Any, Any]:
    """Return the arrays of a file by name."""
    if path.suffix.lower() == ".npz":
        arrays = Arrays(path, _REMEDY, only=_KEYS)
        return {key: arrays.any(key) for key in arrays.keys()}
    contents = read_pickle(path, _REMEDY)
    if not isinstance(contents, dict):
        raise FileError(path, "holds no named arrays", remedy=_REMEDY)
    return contents


def _layout_of(data: Any) -> _Layout | None:
    if not isinstance(data, Mapping):
        return None
    return next((each for each in LAYOUTS if {*each.poses, each.trans} <= data.keys()), None)


def _chosen(
    path: Path, contents: Mapping[Any, Any], warnings: list[str]
) -> tuple[Mapping[Any, Any], _Layout]:
    """Return the arrays of a motion and their layout: of GVHMR the world's, of several people one.

    Raises:
        FileError: If there is none.
    """
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


def _numbers(path: Path, data: Mapping[Any, Any], key: str) -> Any:
    """Return an array as floats.

    Raises:
        FileError: If it is missing or not of finite numbers.
    """
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


def _motion(path: Path, data: Mapping[Any, Any], layout: _Layout) -> tuple[np.ndarray, np.ndarray]:
    """Return the rotation matrices of all joints and the translations.

    Raises:
        FileError: If their shapes do not agree, or are those of no model.
    """
    trans = _numbers(path, data, layout.trans)
    n = len(trans) if trans.ndim else 0
    if n == 0 or trans.size != 3 * n:
        problem = f"has shape {trans.shape}, not (frames, 3)"
        raise FileError(path, problem, where=layout.trans, remedy=_REMEDY)
    trans = trans.reshape(n, 3)
    parts = []
    for key in layout.poses:
        values = _numbers(path, data, key)
        if values.ndim < 2 or len(values) != n:
            problem = f"has shape {values.shape}, but {layout.trans} has {n} frames"
            raise FileError(path, problem, where=key, remedy=_REMEDY)
        parts.append(_rotations(path, key, values))
    local = np.concatenate(parts, axis=1)
    widths = [width // 3 for width in _WIDTHS]
    if len(parts) == 1 and local.shape[1] not in widths or local.shape[1] < _JOINTS:
        problem = f"has {local.shape[1]} joints; {', '.join(map(str, widths))} are known"
        raise FileError(path, problem, where=layout.poses[-1], remedy=_REMEDY)
    if "smpl_scaling" in data and layout.name == "AIST++":
        scaling = _numbers(path, data, "smpl_scaling")
        if scaling.size != 1 or not 1e-3 < scaling.item() < 1e3:
            raise FileError(
                path, "is not one positive number", where="smpl_scaling", remedy=_REMEDY
            )
        trans = trans / scaling.item()
    return local[:, :_JOINTS], trans


def _rotations(path: Path, key: str, values: np.ndarray) -> np.ndarray:
    """Return rotation matrices (n, joints, 3, 3) of rotation vectors or matrices."""
    n = len(values)
    if values.ndim >= 3 and values.shape[-2:] == (3, 3) and values.ndim == 4 - (values.ndim == 3):
        matrices = values.reshape(n, -1, 3, 3)
        if np.abs(matrices @ np.swapaxes(matrices, 2, 3) - np.eye(3)).max() < 1e-2:
            return matrices
    if values.size % (3 * n):
        problem = f"has {values.size // n} columns, not three per joint"
        raise FileError(path, problem, where=key, remedy=_REMEDY)
    vectors = values.reshape(-1, 3)
    largest = float(np.abs(vectors).max(initial=0.0))
    if largest > MAX_ANGLE:
        problem = f"reaches {largest:.0e} rad, which is no rotation of a joint"
        raise FileError(path, problem, where=key, remedy=_REMEDY)
    return Rotation.from_rotvec(vectors).as_matrix().reshape(n, -1, 3, 3)


def _rate(path: Path, data: Mapping[Any, Any]) -> float | None:
    """Return the frame rate of a file [Hz], None if it has none."""
    key = next((key for key in _RATE_KEYS if key in data), None)
    if key is None:
        return None
    rate = _numbers(path, data, key)
    if rate.size != 1 or not RATES[0] <= rate.item() <= RATES[1]:
        raise FileError(path, "is no number of frames per second", where=key, remedy=_REMEDY)
    return float(rate.item())


def _sex(data: Mapping[Any, Any]) -> str | None:
    """Return ``"male"`` or ``"female"``; files hold text, bytes, or the text of bytes."""
    word = data.get("gender")
    if isinstance(word, np.ndarray | np.generic):
        word = word.item() if word.size == 1 and word.dtype.kind in "SU" else None
    if isinstance(word, bytes):
        word = word.decode("latin1")
    word = word.strip("b'\" \0").lower() if isinstance(word, str) else ""
    return {"male": "male", "m": "male", "female": "female", "f": "female"}.get(word)


def _is_smplx(data: Mapping[Any, Any], layout: _Layout) -> bool:
    """Return whether the pelvis joint is that of SMPL-X, which lies lower in its model."""
    if layout.name in ("WHAM", "AIST++"):
        return False
    return layout.poses != ("poses",) or np.size(data["poses"]) == 165 * len(data["poses"])


def _world_axes(
    path: Path,
    local: np.ndarray,
    trans: np.ndarray,
    offsets: Float[Array, "22 3"],
    layout: _Layout,
    warnings: list[str],
) -> Float[Array, "3 3"]:
    """Return the rotation from the file's world to ours."""
    body = FORWARD_LEFT_UP_OF_Y_UP
    _, p = forward_kinematics(local, trans, offsets @ body)
    seen = up_axis(NAMES, p)
    axes = {"y": np.array([0.0, 1, 0]), "z": np.array([0.0, 0, 1])}
    up = axes[layout.up]
    for name, axis in axes.items():
        if seen is not None and np.array_equal(seen, axis) and name != layout.up:
            up = axis
            warnings.append(
                f"{name} was taken as up: the head is above the feet along it ({layout.name} files "
                f"usually have {layout.up} up)"
            )
    return body if up[1] else np.eye(3)


def _note(legs: LegFactors, offsets: Float[Array, "22 3"], data: Mapping[Any, Any]) -> str:
    """Return a sentence on where the bone lengths come from."""
    thigh, shank = (np.linalg.norm(offsets[NAMES.index(f"left_{j}")]) for j in ("knee", "ankle"))
    found = "those of a mean adult were taken, for no foot stands long enough to tell them"
    if legs.stances:
        error = 1e3 * max(legs.standard_errors) * thigh
        found = (
            f"{legs.stances} stances of the feet give {thigh:.3f} m for the thigh and "
            f"{shank:.3f} m for the shank (standard error {error:.0f} mm)"
        )
    shape = " (option skeleton: a body model, for its betas)" if "betas" in data else ""
    return f"the file has no bone lengths{shape}: {found}"
