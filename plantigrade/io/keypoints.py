"""Keypoints of a video in three dimensions, as JSON.

There is no standard; three layouts are read. Frames of MMPose (``instance_info``, names in
``meta_info``); a list of frames, each with the points by name; or one object of our own::

    {"fps": 60, "unit": "m", "up": "y",
     "keypoints": {"RHip": [[x, y, z], …], "LHip": [[x, y, z], null, …], …}}

``time`` [s] may replace ``fps``; without either there are 30 frames per second. Unit and vertical
follow from the size of the body and its height where they are absent. ``null`` is a missing point.
Points in the image alone have no depth, and points about the hips no path: both are refused.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError
from plantigrade.io.axes import UP_AXES, to_world, up_axis_of_points
from plantigrade.io.c3d import LENGTH_UNITS, NAMES_OF_UNITS, unit_of_points
from plantigrade.io.text import check_time, read_text, unique_labels
from plantigrade.models.keypoints import KEYPOINTS
from plantigrade.motion.recording import Markers, Recording

MAX_BYTES = 100e6  # [bytes] of a file: a quarter of an hour at 60 Hz
VIDEO_RATE = 30.0  # [Hz] of files without a rate
MAX_NUMBER = 1e12  # [1] maximum size of a coordinate
MIN_HIP_PATH = 0.005  # [m] spread of the middle of the hips; less is a body about its hips
_REMEDY = 'write {"fps": 60, "keypoints": {"RHip": [[x, y, z], …], …}}, or a TRC file'
_IMAGE_WORDS = ('keypoints_2d"', '"category_id"')  # of OpenPose; of COCO and AlphaPose
_FLAT = "triangulate the views of two or more cameras (Pose2Sim, OpenCap), or lift them"


def read_keypoints(path: str | Path, rate: float | None = None) -> Recording:
    """Read 3-D keypoints of one person as markers, which are fitted as joint centres.

    Args:
        rate: Frames per second [Hz]; that of the file if not given.
    """
    path = Path(path)
    try:
        text = read_text(path, MAX_BYTES)
        data = json.loads(text)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise FileError(path, f"is not JSON ({error.msg})", where=where, remedy=_REMEDY) from error
    except (RecursionError, ValueError) as error:
        raise FileError(path, f"is not JSON ({str(error)[:80]})", remedy=_REMEDY) from error
    if any(word in text[:2000] for word in _IMAGE_WORDS):
        raise _flat(path)
    says = data if isinstance(data, dict) else {}
    names, rows = _frames(path, data)
    warnings: list[str] = []
    raw = _points(path, rows, len(names))
    unit = _unit(path, says, raw, warnings)
    up = _vertical(path, says, names, raw, warnings)
    positions = to_world(raw * unit, up)
    _require_path(path, names, positions)
    time = _time(path, says, len(positions), rate, warnings)
    markers = Markers(unique_labels(names, warnings), time, positions)
    return Recording(source=path, markers=markers, warnings=tuple(warnings))


def _flat(path: Path) -> FileError:
    problem = "holds points in the image (2-D), which have no depth: no angle follows from them"
    return FileError(path, problem, remedy=_FLAT)


def _frames(path: Path, data: Any) -> tuple[list[str], list[list[Any]]]:
    """Return the names, and the point of each name in each frame as it is written."""
    if isinstance(data, dict) and isinstance(data.get("instance_info"), list):
        return _of_mmpose(path, data)
    if isinstance(data, dict) and isinstance(data.get("keypoints"), dict):
        columns = data["keypoints"]
        if not all(isinstance(column, list) for column in columns.values()):
            raise FileError(path, "a keypoint is no list", where="keypoints", remedy=_REMEDY)
        counts = {len(column) for column in columns.values()}
        if len(counts) != 1:
            problem = f"the keypoints have {', '.join(map(str, sorted(counts)))} frames"
            raise FileError(path, problem, where="keypoints", remedy="give every frame, or null")
        return list(columns), [list(row) for row in zip(*columns.values(), strict=True)]
    frames = data.get("frames") if isinstance(data, dict) else data
    if not isinstance(frames, list):
        raise FileError(path, "has no keypoints by name", remedy=_REMEDY)
    found = [f.get("keypoints", f) if isinstance(f, dict) else None for f in frames]
    if any(isinstance(f, list) for f in found):
        raise FileError(path, "has keypoints without names", remedy=_REMEDY)
    named = [f if isinstance(f, dict) else {} for f in found]
    names = list(dict.fromkeys(name for frame in named for name in frame if name in KEYPOINTS))
    if not names:
        raise FileError(path, "has no keypoints by name", remedy=_REMEDY)
    return names, [[frame.get(name) for name in names] for frame in named]


def _of_mmpose(path: Path, data: dict[str, Any]) -> tuple[list[str], list[list[Any]]]:
    meta = data.get("meta_info")
    table = meta.get("keypoint_id2name") if isinstance(meta, dict) else None
    if not isinstance(table, dict):
        where, remedy = "meta_info", "write keypoint_id2name"
        raise FileError(path, "does not name its keypoints", where=where, remedy=remedy)
    names = [str(name) for name in table.values()]
    rows: list[list[Any]] = []
    for k, frame in enumerate(data["instance_info"]):
        people = frame.get("instances") if isinstance(frame, dict) else None
        if not isinstance(people, list):
            raise FileError(path, "has no instances", where=f"frame {k}", remedy=_REMEDY)
        if len(people) > 1:
            problem, remedy = f"shows {len(people)} people", "keep one person"
            raise FileError(path, problem, where=f"frame {k}", remedy=remedy)
        points = people[0].get("keypoints") if people and isinstance(people[0], dict) else []
        given = points if isinstance(points, list) else []
        rows.append([*given, *[None] * len(names)][: len(names)])
    return names, rows


def _points(path: Path, rows: Sequence[Sequence[Any]], count: int) -> Float[Array, "n m 3"]:
    """Return the points, NaN where missing."""
    if len(rows) < 2:
        raise FileError(path, f"has {len(rows)} frames, two are needed", remedy=_REMEDY)
    out = np.full((len(rows), count, 3), np.nan)
    for f, row in enumerate(rows):
        for k, point in enumerate(row):
            if point is None:
                continue
            values: Any = [point.get(a) for a in "xyz"] if isinstance(point, dict) else point
            if isinstance(values, list) and len(values) == 2:
                raise _flat(path)
            if not isinstance(values, list) or len(values) not in (3, 4):
                problem = f"{str(point)[:30]!r} is not a point [x, y, z]"
                raise FileError(path, problem, where=f"frame {f}", remedy=_REMEDY)
            for axis, value in enumerate(values[:3]):
                if type(value) in (int, float) and -MAX_NUMBER < value < MAX_NUMBER:
                    out[f, k, axis] = value
                elif value is not None and value == value:
                    problem = f"{str(value)[:30]!r} is not a number"
                    raise FileError(path, problem, where=f"frame {f}", remedy=_REMEDY)
    missing = ~np.isfinite(out).all(axis=2) | (out == 0).all(axis=2)
    out[missing] = np.nan
    if missing.all():
        raise FileError(path, "has no point of any keypoint in any frame", remedy=_REMEDY)
    if not np.nanmax(np.abs(np.diff(out[..., 2], axis=1)), initial=0.0):
        raise _flat(path)
    return out


def _unit(path: Path, says: dict[str, Any], raw: np.ndarray, warnings: list[str]) -> float:
    word = says.get("unit", says.get("units"))
    if word is None:
        unit = unit_of_points(raw)
        warnings.append(f"the file states no unit; from the body's size: {NAMES_OF_UNITS[unit]}")
        return unit
    if str(word).lower() not in LENGTH_UNITS:
        allowed = f"use one of {', '.join(LENGTH_UNITS)}"
        raise FileError(path, f"unit {str(word)[:20]!r} is not known", remedy=allowed)
    return LENGTH_UNITS[str(word).lower()]


def _vertical(
    path: Path, says: dict[str, Any], names: Sequence[str], raw: np.ndarray, warnings: list[str]
) -> str:
    word = says.get("up")
    if word is None:
        up = _upward(names, raw)
        warnings.append(f"the file states no vertical; the body is upright along {up}")
        return up
    up = str(word).lower()
    up = up if up[:1] in "+-" else f"+{up}"
    if up not in UP_AXES:
        raise FileError(path, f"up is {str(word)[:20]!r}", remedy=f"one of {', '.join(UP_AXES)}")
    return up


def _upward(names: Sequence[str], raw: np.ndarray) -> str:
    """Return the axis along which the hips are above the ankles; cameras have it downward."""
    columns = {
        joint: [k for k, name in enumerate(names) if str(KEYPOINTS.get(name)).startswith(joint)]
        for joint in ("hip_joint", "ankle_joint")
    }
    if not all(columns.values()):
        return up_axis_of_points(raw)[0]
    hips, ankles = (np.nanmedian(raw[:, k], axis=(0, 1)) for k in columns.values())
    leg = np.nan_to_num(hips - ankles)
    axis = int(np.abs(leg).argmax())
    return f"{'+' if leg[axis] >= 0 else '-'}{'xyz'[axis]}"


def _time(
    path: Path, says: dict[str, Any], count: int, rate: float | None, warnings: list[str]
) -> Float[Array, " n_frames"]:
    given = says.get("time")
    if isinstance(given, list) and rate is None:
        if len(given) != count or not all(type(t) in (int, float) for t in given):
            remedy = "give one time per frame"
            raise FileError(path, f"has {count} frames", where="time", remedy=remedy)
        time = np.array(given, dtype=float)
        check_time(time, [str(t) for t in given], path, first_line=1)
        return time
    said = rate or says.get("fps", says.get("rate"))
    if said is None:
        warnings.append(f"the file states no rate; {VIDEO_RATE:g} frames per second were assumed")
        said = VIDEO_RATE
    if type(said) not in (int, float) or not 1.0 <= said <= 1e4:
        raise FileError(path, f"fps is {str(said)[:20]!r}", where="fps", remedy="correct it")
    return np.arange(count) / float(said)


def _require_path(path: Path, names: Sequence[str], positions: Float[Array, "n m 3"]) -> None:
    """Raise where the points are about the hips, as lifted from one image without a world."""
    hips = [k for k, name in enumerate(names) if str(KEYPOINTS.get(name)).startswith("hip_joint")]
    if len(hips) < 2:
        return
    middle = positions[:, hips].mean(axis=1)
    middle = middle[np.isfinite(middle).all(axis=1)]
    if len(middle) and float(np.ptp(middle, axis=0).max()) < MIN_HIP_PATH:
        raise FileError(
            path,
            "holds points about the middle of the hips, which never moves: feet cannot stand, and "
            "no force follows",
            remedy="write the points in world coordinates",
        )
