"""DeepMimic reference motions: JSON with 44 numbers per frame on one fixed humanoid.

Each frame holds its duration [s], the root's position [m] and rotation, then the rotations of the
joints in :data:`JOINTS`' order: unit quaternions ``wxyz`` for ball joints, one angle [rad] about
z for knees and elbows (elbows flex with positive angles, knees with negative ones). File axes are
x forward, y up, z to the right. The humanoid's joint offsets are those of [DeepMimic]_'s
``humanoid3d`` character (1.62 m tall, 45 kg).

[DeepMimic]: Peng, Abbeel, Levine and van de Panne, *DeepMimic: example-guided deep reinforcement
learning of physics-based character skills*, ACM Transactions on Graphics 37(4), 2018.
"""

import json
from functools import partial
from pathlib import Path

import numpy as np

from plantigrade.data_files import number_table
from plantigrade.errors import FileError
from plantigrade.io.skeletons import euler_rotation, rest_pose, tree_kinematics
from plantigrade.io.text import read_text
from plantigrade.motion.recording import Recording, SkeletonMotion
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD, rotation_matrix

JOINTS: tuple[tuple[str, int, tuple[float, float, float], int], ...] = tuple(
    (name, int(parent), (x, y, z), int(width))
    for name, (parent, x, y, z, width) in number_table(
        "plantigrade.io", "deepmimic_joints.csv", 5
    ).items()
)
"""Name, parent, offset from the parent [m] (x forward, y up, z right), numbers per frame."""
NUMBERS = 4 + sum(width for *_, width in JOINTS)

# Ends of bones without a child joint, in the bone's frame [m]: top of the head, tip of the toes at
# the height of the sole (the foot is a box 0.177 m long around a point 0.045 m before the ankle).
ENDS = {
    "neck": (0.0, 0.2775, 0.0),
    "right_ankle": (0.1335, -0.05, 0.0),
    "left_ankle": (0.1335, -0.05, 0.0),
}

MAX_BYTES = 20e6  # of a file [bytes]: about 10 minutes at 30 Hz
_REMEDY = 'a DeepMimic motion is a JSON object with a list "Frames" of rows of 44 numbers'
_UNIT = 0.02  # how far a quaternion's length may be from 1


def read_deepmimic(path: str | Path) -> Recording:
    """Read a DeepMimic motion, a JSON file (usually ``.txt``).

    Returns:
        A recording with a ``skeleton`` of 15 joints. Each frame lasts for its own duration; that of
        the last one is ignored. A cyclic motion (``"Loop": "wrap"``) is returned as one cycle.

    Raises:
        FileError: If the file is not such a motion; the message names frame and field.
    """
    path = Path(path)
    text = read_text(path, MAX_BYTES)
    wrong = partial(FileError, path, remedy=_REMEDY)
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise wrong(f"is not JSON ({error.msg})", where=where) from error
    except (RecursionError, ValueError) as error:
        raise wrong(f"is not JSON ({str(error)[:80]})") from error
    if not isinstance(data, dict) or not isinstance(data.get("Frames"), list):
        raise wrong('has no list "Frames"', where="Frames")
    rows = data["Frames"]
    if len(rows) < 2:
        raise wrong(f"has {len(rows)} frames, two are needed", where="Frames")
    warnings: list[str] = []
    frames = _frames(path, rows)
    duration = frames[:, 0]
    loop = str(data.get("Loop", "none")).lower()
    if loop not in ("wrap", "none"):
        warnings.append(f"Loop is {loop[:20]!r}, which is unknown; none was assumed")
    elif loop == "wrap":
        warnings.append("the motion is one cycle, meant to be repeated")
    time = np.concatenate([[0.0], np.cumsum(duration[:-1])])
    return Recording(source=path, skeleton=_kinematics(frames, time), warnings=tuple(warnings))


def _frames(path: Path, rows: list) -> np.ndarray:
    """Return the frames with unit quaternions."""
    wrong = partial(FileError, path, remedy=_REMEDY)
    for n, row in enumerate(rows):
        count = len(row) if isinstance(row, list) else None
        if count != NUMBERS:
            what = "is not a list" if count is None else f"has {count} numbers"
            raise FileError(
                path,
                f"{what}; {NUMBERS} are needed",
                where=f"Frames[{n}]",
                remedy="other characters than humanoid3d (dog, atlas) are not read",
            )
        for k, x in enumerate(row):
            if type(x) not in (int, float):
                raise wrong(f"{str(x)[:30]!r} is not a number", where=f"Frames[{n}][{k}]")
    try:
        frames = np.array(rows, dtype=float)
    except OverflowError as error:
        raise wrong(f"a number is too large ({error})", where="Frames") from error
    if not np.isfinite(frames).all():
        n, k = np.argwhere(~np.isfinite(frames))[0]
        raise wrong("is not finite", where=f"Frames[{n}][{k}]")
    if (frames[:-1, 0] <= 0).any():
        n = int(np.argmax(frames[:-1, 0] <= 0))
        problem = f"lasts {frames[n, 0]} s; a frame must last longer than 0 s"
        raise wrong(problem, where=f"Frames[{n}][0]")
    column = 4
    for name, _, _, width in JOINTS:
        if width == 4:
            quat = frames[:, column : column + 4]
            length = np.linalg.norm(quat, axis=1)
            if (np.abs(length - 1) > _UNIT).any():
                n = int(np.argmax(np.abs(length - 1)))
                problem = f"the quaternion of {name} has length {length[n]:.3g}; it must be 1"
                raise wrong(problem, where=f"Frames[{n}][{column}:{column + 4}]")
            frames[:, column : column + 4] = quat / length[:, None]
        column += width
    return frames


def _kinematics(frames: np.ndarray, time: np.ndarray) -> SkeletonMotion:
    n, k = len(frames), len(JOINTS)
    names, parents, offsets, widths = zip(*JOINTS, strict=True)
    local, column = np.empty((n, k, 3, 3)), 4
    for i, width in enumerate(widths):
        values = frames[:, column : column + width]
        column += width
        turns = rotation_matrix(values) if width == 4 else euler_rotation("z" * width, values)
        local[:, i] = turns
    offsets = np.array(offsets)
    R, p = tree_kinematics(parents, local, frames[:, 1:4], offsets)
    ends = np.full(p.shape, np.nan)
    for name, tip in ENDS.items():
        i = names.index(name)
        ends[:, i] = p[:, i] + R[:, i] @ np.array(tip)
    T = OPENSIM_TO_WORLD
    return SkeletonMotion(
        names=names,
        parents=parents,
        time=time,
        positions=p @ T.T,
        rotations=T @ R @ T.T,
        rest_positions=rest_pose(parents, offsets) @ T.T,
        ends=ends @ T.T,
    )
