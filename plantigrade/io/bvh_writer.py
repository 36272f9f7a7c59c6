"""Writer of BVH files."""

import re
from pathlib import Path
from warnings import catch_warnings, simplefilter

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.skeletons import FORWARD_LEFT_UP_OF_Y_UP
from plantigrade.io.writing import write_text
from plantigrade.motion.recording import Recording, SkeletonMotion


def write_recording(recording: Recording, path: str | Path) -> None:
    """Write the skeleton of a recording as BVH."""
    if recording.skeleton is None:
        raise FileError(path, "the recording has no skeleton", remedy="write its markers to .trc")
    write_bvh(recording.skeleton, path)


UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Units of length that can be written [m]."""


def write_bvh(
    skeleton: SkeletonMotion, path: str | Path, *, order: str = "ZXY", unit: str = "cm"
) -> Path:
    """Write a skeleton's motion as BVH, y up, x left, z forward.

    Joints keep their rest offsets; a joint whose distance to its parent changes gets position
    channels of its own. Bones without a child joint get an ``End Site``. Angles are continuous
    beyond 180 degrees.

    Args:
        order: Order of the rotation channels.
        unit: One of :data:`UNITS`; the file does not say which.

    Raises:
        ParameterError: If ``order`` is not a permutation of XYZ, ``unit`` is unknown, or there are
            gaps.
        FileError: If the file cannot be written.
    """
    order = order.upper()
    if sorted(order) != ["X", "Y", "Z"]:
        raise ParameterError(f"{order=} must contain X, Y and Z once each")
    if unit not in UNITS:
        raise ParameterError(f"{unit=} must be one of {', '.join(UNITS)}")
    if not (np.isfinite(skeleton.positions).all() and np.isfinite(skeleton.rotations).all()):
        raise ParameterError("the skeleton's motion has gaps (NaN); fill them before writing BVH")
    if len(skeleton.time) < 1:
        raise ParameterError("the skeleton's motion has no frames")
    n = len(skeleton.time)
    lines, columns = _hierarchy(skeleton, order, UNITS[unit])
    frame_time = float((skeleton.time[-1] - skeleton.time[0]) / (n - 1)) if n > 1 else 0.01
    lines = ["HIERARCHY", *lines, "MOTION", f"Frames: {n}", f"Frame Time: {frame_time:.8g}"]
    table = np.concatenate(columns, axis=1)
    row = " ".join(["%.6f"] * table.shape[1])
    lines += [row % tuple(values) for values in table.tolist()]
    write_text(path, "\n".join(lines) + "\n")
    return Path(path)


def _hierarchy(
    skeleton: SkeletonMotion, order: str, unit: float
) -> tuple[list[str], list[Float[Array, "n 3"]]]:
    """Return the lines of the hierarchy, and the columns of its channels in the same order."""
    T = FORWARD_LEFT_UP_OF_Y_UP.T  # ours to file
    scale = 1.0 / unit
    p, ends = skeleton.positions @ T.T * scale, skeleton.ends @ T.T * scale
    R = T @ skeleton.rotations @ T.T
    rest = skeleton.rest_positions @ T.T * scale
    tolerance = 1e-5 * max(float(np.ptp(rest, axis=0).max()), 1e-9)
    children: dict[int, list[int]] = {}
    for i, parent in enumerate(skeleton.parents):
        children.setdefault(parent, []).append(i)
    lines: list[str] = []
    columns: list[Float[Array, "n 3"]] = []
    stack: list[tuple[int, int, bool]] = [(i, 0, False) for i in reversed(children.get(-1, []))]
    while stack:
        i, depth, closing = stack.pop()
        tab, parent = "  " * depth, skeleton.parents[i]
        if closing:
            lines.append(f"{tab}}}")
            continue
        if parent < 0:
            offset, local_p, local_R, moves = np.zeros(3), p[:, i], R[:, i], True
        else:
            back = np.swapaxes(R[:, parent], 1, 2)
            local_p = np.einsum("nij,nj->ni", back, p[:, i] - p[:, parent])
            local_R = back @ R[:, i]
            offset, moves = _offset(local_p, rest[i] - rest[parent], tolerance)
        name = re.sub(r"[\s{}]+", "_", skeleton.names[i]) or f"joint{i}"
        count = "6 Xposition Yposition Zposition " if moves else "3 "
        lines += [
            f"{tab}{'ROOT' if parent < 0 else 'JOINT'} {name}",
            f"{tab}{{",
            f"{tab}  OFFSET {_numbers(offset)}",
            f"{tab}  CHANNELS {count}" + " ".join(f"{x}rotation" for x in order),
        ]
        columns += [*([local_p] if moves else []), _angles(local_R, order)]
        if not children.get(i):
            tip = np.einsum("nij,ni->nj", R[:, i], ends[:, i] - p[:, i])
            tip = np.median(tip, axis=0) if np.isfinite(tip).all() else np.zeros(3)
            end = ("End Site", "{", f"  OFFSET {_numbers(tip)}", "}")
            lines += [f"{tab}  {line}" for line in end]
        stack.append((i, depth, True))
        stack.extend((child, depth + 1, False) for child in reversed(children.get(i, [])))
    return lines, columns


def _offset(
    path: Float[Array, "n 3"], rest: Float[Array, " 3"], tolerance: float
) -> tuple[Float[Array, " 3"], bool]:
    """Return the offset of a joint from its parent, and whether its distance changes."""
    if np.abs(path - rest).max() <= tolerance:
        return rest, False
    still = bool((np.abs(path - path[0]) <= tolerance).all())
    return (path[0], False) if still else (rest, True)


def _angles(R: Float[Array, "n 3 3"], order: str) -> Float[Array, "n 3"]:
    """Return continuous angles of rotations in the order of the channels [deg]."""
    from scipy.spatial.transform import Rotation

    with catch_warnings():  # at a singularity any of the equal angles will do
        simplefilter("ignore", UserWarning)
        angles = Rotation.from_matrix(R).as_euler(order, degrees=True)
    return np.unwrap(angles, period=360.0, axis=0)


def _numbers(values: Float[Array, " 3"]) -> str:
    return " ".join(f"{x:.7g}" for x in values)
