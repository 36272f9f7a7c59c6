"""BVH motions: a hierarchy of offsets with channels per joint, then one row of numbers per frame.

A joint's rotation is the product of its rotation channels in the order they are listed, :math:`R
= R_{parent} R_{c_1} R_{c_2} R_{c_3}`, angles in degrees; its position is that of its parent plus
:math:`R_{parent}` times its offset. Position channels replace the offset or add to it: writers
differ. On a joint below the root they replace it where their median lies nearer to the offset
than to zero; on the root, where an offset is given, the reading is taken that brings the lowest
point of the body nearer to the height 0.

**Unit.** BVH states none. The person's height is summed along the bones from ankle to head; of
metre, centimetre, millimetre, inch and CMU's unit (0.0254 / 0.45 m), in this order, the first is
taken that makes the height lie between 1.0 and 2.2 m. The option ``unit`` overrides it. Where
none fits, the height becomes 1.60 m, with a warning.

**Axes.** Up is the file axis along which the head is above the feet through the motion (y where
the names do not tell); the person's left and forward are found from the twins
``left…``/``right…`` in the rest pose (x and z where they do not tell). They are turned to x
forward, y left, z up; the direction of walking is left as it is.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from warnings import catch_warnings, simplefilter

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.skeletons import (
    FORWARD_LEFT_UP_OF_Y_UP,
    bone_height,
    euler_rotation,
    left_axis,
    turn_to_ours,
    up_axis,
)
from plantigrade.io.text import read_text, write_text
from plantigrade.motion.recording import Recording, SkeletonMotion

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "cmu": 0.0254 / 0.45}  # [m]
PLAUSIBLE_HEIGHT = (1.0, 2.2)  # [m], along the bones from ankle to head
ASSUMED_HEIGHT = 1.60  # [m], ankle to head, where no unit fits
MAX_JOINTS = 2000
MAX_BYTES = 50e6  # of a file [bytes]: about 6 minutes of 43 joints at 120 Hz

_CHANNEL = re.compile(r"([XYZ])(position|rotation)", re.IGNORECASE)
_AT_REST = 2.0  # [deg]
_JUMP = 2.0  # times the usual change between frames


@dataclass
class _Joint:
    name: str
    parent: int
    offset: np.ndarray
    channels: tuple[tuple[str, str], ...] = ()  # (kind, axis): ("rotation", "z")
    first_channel: int = 0
    end: np.ndarray | None = None


def read_bvh(path: str | Path, *, unit: str | None = None) -> Recording:
    """Read a BVH motion.

    Args:
        path: The ``.bvh`` file.
        unit: ``m``, ``cm``, ``mm``, ``in`` or ``cmu``; found from the person's height if absent.

    Returns:
        A recording with a ``skeleton``. A rest pose in the first frame, and frames that only lead
        out of it, are left out with a warning (time starts at 0 in the frame after the rest pose).

    Raises:
        FileError: If the file cannot be read; the line is named.
        ParameterError: If ``unit`` is unknown.
    """
    path = Path(path)
    if unit is not None and unit not in UNITS:
        raise ParameterError(f"{unit=} is not one of {', '.join(UNITS)}")
    text = read_text(path, MAX_BYTES)
    warnings: list[str] = []
    found = re.search(r"^[ \t]*MOTION[ \t]*\r?$", text, re.MULTILINE | re.IGNORECASE)
    if found is None:
        raise FileError(
            path,
            "there is no MOTION section",
            where=f"line {text.count(chr(10)) + 1}",
            remedy="check that this is a BVH file and whole",
        )
    joints, n_channels = _Hierarchy(path, text[: found.start()], warnings).parse()
    values, frame_time = _motion_block(path, text, found.end(), n_channels, warnings)
    n_skipped, values = _without_rest_pose(joints, values, warnings)
    time = (np.arange(len(values)) + max(n_skipped - 1, 0)) * frame_time
    return Recording(
        source=path,
        skeleton=_kinematics(joints, values, time, unit, warnings),
        warnings=tuple(warnings),
    )


class _Hierarchy:
    """Reads the HIERARCHY section; every error names the line."""

    def __init__(self, path: Path, text: str, warnings: list[str]):
        self.path, self.warnings = path, warnings
        self.lines = text.replace("{", "\n{\n").replace("}", "\n}\n") if _crowded(text) else text
        self.crowded = self.lines is not text
        self.n = 0

    def error(self, problem: str) -> FileError:
        where = "HIERARCHY" if self.crowded else f"line {self.n}"
        return FileError(self.path, problem, where=where, remedy="check the BVH file's hierarchy")

    def parse(self) -> tuple[list[_Joint], int]:
        """Return the joints of the first root, parents first, and the number of channels."""
        joints: list[_Joint] = []
        stack: list[int | None] = []  # open blocks: a joint, or None for an End Site
        pending: int | None = None  # the block that the next brace opens
        expect_brace = False
        n_channels, n_roots = 0, 0
        for n, line in enumerate(self.lines.splitlines(), start=1):
            self.n = n
            words = line.split()
            if not words:
                continue
            key = words[0].upper()
            if key == "HIERARCHY":
                continue
            if key == "{":
                if not expect_brace:
                    raise self.error("'{' stands where no joint begins")
                stack.append(pending)
                expect_brace = False
            elif expect_brace:
                raise self.error(f"'{{' is missing before {words[0]!r}")
            elif key == "}":
                if not stack:
                    raise self.error("'}' closes nothing")
                stack.pop()
            elif key in ("ROOT", "JOINT"):
                if key == "JOINT" and (not stack or stack[-1] is None):
                    raise self.error("JOINT stands outside a ROOT")
                if key == "ROOT" and stack:
                    raise self.error("ROOT stands inside another joint")
                n_roots += key == "ROOT"
                if len(joints) >= MAX_JOINTS:
                    raise self.error(f"there are more than {MAX_JOINTS} joints: no human skeleton")
                name = " ".join(words[1:]) or f"joint{len(joints)}"
                parent = stack[-1] if stack else -1
                joints.append(_Joint(name, -1 if parent is None else parent, np.zeros(3)))
                pending, expect_brace = len(joints) - 1, True
            elif key == "END":
                if not stack or stack[-1] is None:
                    raise self.error("End Site stands outside a joint")
                pending, expect_brace = None, True
                ended = stack[-1]
            elif key == "OFFSET":
                offset = self.numbers(words[1:], 3)
                if not stack:
                    raise self.error("OFFSET stands outside a joint")
                if stack[-1] is None:
                    joints[ended].end = offset
                else:
                    joints[stack[-1]].offset = offset
            elif key == "CHANNELS":
                if not stack or stack[-1] is None:
                    raise self.error("CHANNELS stands outside a joint")
                joint = joints[stack[-1]]
                if joint.channels:
                    raise self.error(f"joint {joint.name!r} has CHANNELS twice")
                joint.channels = self.channels(words[1:])
                joint.first_channel = n_channels
                n_channels += len(joint.channels)
            else:
                raise self.error(f"{words[0]!r} is not known in a hierarchy")
        if not joints:
            raise self.error("there is no ROOT")
        if stack or expect_brace:
            raise self.error("a '}' is missing: the hierarchy is cut off")
        if not n_channels:
            raise self.error("no joint has CHANNELS")
        if n_roots > 1:
            second = next(i for i, j in enumerate(joints) if i and j.parent == -1)
            self.warnings.append(
                f"the file holds {n_roots} skeletons; only the first, {joints[0].name!r}, is read"
            )
            joints = joints[:second]
        self.unique_names(joints)
        return joints, n_channels

    def numbers(self, words: list[str], count: int) -> np.ndarray:
        try:
            numbers = np.array([float(word) for word in words])
        except ValueError:
            numbers = np.empty(0)
        if len(numbers) != count or not np.isfinite(numbers).all():
            raise self.error(f"OFFSET needs {count} numbers, here stands {' '.join(words)[:60]!r}")
        return numbers

    def channels(self, words: list[str]) -> tuple[tuple[str, str], ...]:
        if not words or not (words[0].isdigit() and words[0].isascii()):
            raise self.error("CHANNELS needs a count")
        if int(words[0]) != len(words) - 1:
            raise self.error(f"CHANNELS says {words[0][:9]} and lists {len(words) - 1}")
        channels = []
        for word in words[1:]:
            known = _CHANNEL.fullmatch(word)
            if known is None:
                raise self.error(
                    f"channel {word!r} is not Xposition … Zposition, Xrotation … Zrotation"
                )
            channels.append((known[2].lower(), known[1].lower()))
        if sum(kind == "position" for kind, _ in channels) not in (0, 1, 2, 3) or len(
            {c for c in channels if c[0] == "position"}
        ) != sum(kind == "position" for kind, _ in channels):
            raise self.error("a position channel is listed twice")
        return tuple(channels)

    def unique_names(self, joints: list[_Joint]) -> None:
        seen: dict[str, int] = {}
        for joint in joints:
            seen[joint.name] = seen.get(joint.name, 0) + 1
            if seen[joint.name] > 1:
                self.warnings.append(
                    f"there are several joints named {joint.name!r}; numbered from the second on"
                )
                joint.name = f"{joint.name}#{seen[joint.name]}"


def _crowded(text: str) -> bool:
    """Return whether braces share a line with other words."""
    return re.search(r"[{}][ \t]*[^\s{}]|[^\s][ \t]*[{}]", text) is not None


def _motion_block(
    path: Path, text: str, start: int, n_channels: int, warnings: list[str]
) -> tuple[Float[Array, "n k"], float]:
    """Return the numbers of the MOTION section and the time of a frame [s]."""
    head = re.compile(
        r"\s*Frames[ \t]*:[ \t]*(\S*)[ \t]*\r?\n\s*Frame[ \t]+Time[ \t]*:[ \t]*(\S*)", re.IGNORECASE
    ).match(text, start)
    line = text.count("\n", 0, start) + 1
    remedy = "check that the BVH file is whole"
    if head is None:
        raise FileError(
            path,
            "MOTION is not followed by 'Frames:' and 'Frame Time:'",
            where=f"line {line + 1}",
            remedy=remedy,
        )
    try:
        n_frames, frame_time = int(head[1]), float(head[2])
    except ValueError:
        raise FileError(
            path,
            f"Frames is {head[1][:20]!r}, Frame Time is {head[2][:20]!r}: not numbers",
            where=f"line {line + 1}",
            remedy=remedy,
        ) from None
    if not (np.isfinite(frame_time) and frame_time > 0):
        raise FileError(
            path,
            f"Frame Time is {head[2]} s; it must be positive",
            where=f"line {line + 2}",
            remedy="write the time between frames in seconds, as 0.00833333 for 120 Hz",
        )
    first_row = text.count("\n", 0, head.end()) + 2
    block = text[head.end() :]
    values = _numbers(block)
    if values is None:
        block = _whole_rows(path, block, first_row - 1, n_channels)
        values = _numbers(block)
    if values is None:
        raise FileError(path, "holds words that are no numbers", where="MOTION", remedy=remedy)
    rows, rest = divmod(len(values), n_channels)
    if rest or rows != n_frames:
        rows = _count_rows(path, block, first_row - 1, n_channels)
        warnings.append(f"the file says {n_frames} frames and holds {rows} whole ones")
    if rows < 1:
        raise FileError(
            path, "there is no whole frame in MOTION", where=f"line {first_row}", remedy=remedy
        )
    values = values[: rows * n_channels].reshape(rows, n_channels)
    if not np.isfinite(values).all():
        values = _filled(path, values, warnings)
    return values, frame_time


def _numbers(block: str) -> np.ndarray | None:
    """Return all numbers of ``block``, None if anything else stands in it."""
    if not block.strip():
        return np.empty(0)
    with catch_warnings():
        simplefilter("error")
        try:
            return np.fromstring(block, sep=" ")
        except (DeprecationWarning, ValueError, UnicodeError):
            return None


def _whole_rows(path: Path, block: str, line: int, n_channels: int) -> str:
    """Return the rows before a last one that is cut off within a number.

    Raises:
        FileError: If a word that is no number stands anywhere else.
    """
    rows = block.rstrip().split("\n")
    for n, row in enumerate(rows):
        if _numbers(row) is not None:
            continue
        if n == len(rows) - 1 and n > 0 and len(row.split()) <= n_channels:
            return "\n".join(rows[:-1])
        words = row.split()
        bad = next((k for k, word in enumerate(words) if _numbers(word) is None), 0)
        raise FileError(
            path,
            f"{words[bad][:30]!r} is not a number",
            where=f"line {line + n}, channel {bad + 1}",
            remedy="mend or delete this frame",
        )
    return block


def _count_rows(path: Path, block: str, line: int, n_channels: int) -> int:
    """Return the number of whole rows; only the last may be cut off."""
    rows = 0
    short: tuple[int, int] | None = None
    for n, row in enumerate(block.splitlines(), start=line):
        count = len(row.split())
        if not count:
            continue
        if short is not None or count > n_channels:
            n, count = short or (n, count)
            raise FileError(
                path,
                f"this frame has {count} numbers, the hierarchy has {n_channels} channels",
                where=f"line {n}",
                remedy="mend or delete this frame, or check the hierarchy",
            )
        if count < n_channels:
            short = (n, count)
        else:
            rows += 1
    return rows


def _filled(path: Path, values: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Return ``values`` with rows that are not finite bridged by their neighbours."""
    bad = np.asarray(~np.isfinite(values).all(axis=1))
    if bad.mean() > 0.5:
        raise FileError(
            path,
            f"{bad.sum()} of {len(bad)} frames hold values that are not finite",
            where=f"frame {np.flatnonzero(bad)[0] + 1}",
            remedy="export the motion again",
        )
    warnings.append(
        f"{bad.sum()} frames held values that are not finite; the frame before stands in for them"
    )
    last = np.maximum.accumulate(np.where(bad, -1, np.arange(len(bad))))
    last[last < 0] = np.flatnonzero(~bad)[0]
    return values[last]


def _without_rest_pose(
    joints: list[_Joint], values: np.ndarray, warnings: list[str]
) -> tuple[int, np.ndarray]:
    """Return how many first frames are a rest pose or lead out of it, and the others.

    The first frame is a rest pose where nine in ten of the rotations that change later are below
    2 degrees (conversions keep thumbs and feet bent). It is left out where the motion does not
    start from it: where the mean change of the rotations to the second frame exceeds twice the
    largest one in the frames 8 to 40 after it. Conversions smooth over such a jump; the frames
    that follow with changes as large, at most 8, are left out too.
    """
    columns = [
        joint.first_channel + k
        for joint in joints
        for k, (kind, _) in enumerate(joint.channels)
        if kind == "rotation"
    ]
    if len(values) < 4 or not columns:
        return 0, values
    rotations = values[:, columns]
    moving = np.ptp(rotations[1:], axis=0) > 0.5
    if not moving.any() or np.quantile(np.abs(rotations[0, moving]), 0.9) > _AT_REST:
        return 0, values
    change = np.diff(rotations[:, moving], axis=0)
    change = np.abs((change + 180) % 360 - 180).mean(axis=1)
    first = 8 if len(change) > 16 else 1
    jump = _JUMP * max(float(change[first : first + 32].max()), 0.05)
    if change[0] <= jump:
        warnings.append("the first frame is the rest pose; the motion starts from it, it is kept")
        return 0, values
    skip = int(np.argmax(change[:8] <= jump)) or 1
    more = f", and the {skip - 1} after it that lead out of it" if skip > 1 else ""
    warnings.append(f"the first frame is a rest pose, no motion: left out{more}")
    return skip, values[skip:]


def _kinematics(
    joints: list[_Joint],
    values: np.ndarray,
    time: np.ndarray,
    unit: str | None,
    warnings: list[str],
) -> SkeletonMotion:
    """Run the forward kinematics, all frames of a joint at once, and turn it to our axes."""
    n, k = len(values), len(joints)
    R, p, ends = np.empty((n, k, 3, 3)), np.empty((n, k, 3)), np.full((n, k, 3), np.nan)
    rest = np.zeros((k, 3))
    for i, joint in enumerate(joints):
        channels = values[:, joint.first_channel : joint.first_channel + len(joint.channels)]
        rotation = [c for c, (kind, _) in enumerate(joint.channels) if kind == "rotation"]
        axes = "".join(joint.channels[c][1] for c in rotation)
        local = euler_rotation(axes, np.deg2rad(channels[:, rotation]))
        offset = np.broadcast_to(joint.offset, (n, 3)).copy()
        position = [c for c, (kind, _) in enumerate(joint.channels) if kind == "position"]
        for c in position:
            x = "xyz".index(joint.channels[c][1])
            shift, own = channels[:, c], joint.offset[x]
            adds = joint.parent >= 0 and abs(np.median(shift)) < abs(np.median(shift) - own)
            offset[:, x] = shift + (own if adds else 0.0)
        if joint.parent < 0:
            R[:, i], p[:, i] = local, offset
        else:
            R[:, i] = R[:, joint.parent] @ local
            p[:, i] = p[:, joint.parent] + np.einsum("nij,nj->ni", R[:, joint.parent], offset)
            own = joint.offset if np.any(joint.offset) else np.median(offset, axis=0)
            rest[i] = rest[joint.parent] + own
        if joint.end is not None:
            ends[:, i] = p[:, i] + R[:, i] @ joint.end
    names, parents = tuple(j.name for j in joints), tuple(j.parent for j in joints)
    up = up_axis(names, p)
    up_rest = up_axis(names, rest[None])
    left = left_axis(names, rest, up_rest if up_rest is not None else up)
    if up is None:
        warnings.append("the joint names do not tell head from feet: y is taken as up")
        up = np.array([0.0, 1, 0])
    body = turn_to_ours(up_rest if up_rest is not None else up, left)
    world = body if np.array_equal(body[2], up) else turn_to_ours(up, None)
    if joints[0].offset.any() and any(kind == "position" for kind, _ in joints[0].channels):
        low = np.percentile(np.nanmin(p @ up, axis=1), 2)
        if abs(low + joints[0].offset @ up) < abs(low):
            p += joints[0].offset
            ends += joints[0].offset
    scale = _scale(bone_height(names, parents, rest), unit, warnings)
    for i in range(k):  # joint by joint: the arrays may be large
        R[:, i] = world @ R[:, i] @ body.T
        p[:, i] = p[:, i] @ world.T * scale
        ends[:, i] = ends[:, i] @ world.T * scale
    return SkeletonMotion(
        names=names,
        parents=parents,
        time=time,
        positions=p,
        rotations=R,
        rest_positions=rest @ body.T * scale,
        ends=ends,
    )


def _scale(height: float, unit: str | None, warnings: list[str]) -> float:
    """Return metres per file unit, from the person's height in file units."""
    if unit is not None:
        return UNITS[unit]
    if not (np.isfinite(height) and height > 0):
        warnings.append(
            "the joint names do not tell the person's height: lengths taken as cm (option unit)"
        )
        return UNITS["cm"]
    for name, metres in UNITS.items():
        if PLAUSIBLE_HEIGHT[0] <= height * metres <= PLAUSIBLE_HEIGHT[1]:
            if name != "m":
                warnings.append(
                    f"lengths taken as {name}, which makes the skeleton {height * metres:.2f} m "
                    "from ankle to head (option unit)"
                )
            return metres
    warnings.append(
        f"no unit makes the skeleton human-sized ({height:g} from ankle to head in file units): "
        f"scaled to {ASSUMED_HEIGHT:.2f} m (option unit)"
    )
    return ASSUMED_HEIGHT / height


def write_recording(recording: Recording, path: str | Path) -> None:
    """Write the skeleton of a recording as BVH.

    Raises:
        FileError: If there is no skeleton, or the file cannot be written.
    """
    if recording.skeleton is None:
        raise FileError(path, "the recording has no skeleton", remedy="write its markers to .trc")
    write_bvh(recording.skeleton, path)


def write_bvh(skeleton: SkeletonMotion, path: str | Path, *, order: str = "ZXY") -> Path:
    """Write a skeleton's motion as BVH, in centimetres, y up, x left, z forward.

    Joints keep their rest offsets; a joint whose distance to its parent changes gets position
    channels of its own. Bones that end at no joint get an ``End Site``.

    Args:
        skeleton: What to write; evenly sampled.
        path: The file.
        order: Order of the rotation channels.

    Raises:
        ParameterError: If ``order`` is not a permutation of XYZ, or there are gaps.
        FileError: If the file cannot be written.
    """
    from scipy.spatial.transform import Rotation

    order = order.upper()
    if sorted(order) != ["X", "Y", "Z"]:
        raise ParameterError(f"{order=} must hold X, Y and Z once each")
    if not (np.isfinite(skeleton.positions).all() and np.isfinite(skeleton.rotations).all()):
        raise ParameterError("the skeleton's motion has gaps (NaN); fill them before writing BVH")
    if len(skeleton.time) < 1:
        raise ParameterError("the skeleton's motion has no frames")
    T = FORWARD_LEFT_UP_OF_Y_UP.T  # ours to file
    p, ends = skeleton.positions @ T.T * 100, skeleton.ends @ T.T * 100
    R = T @ skeleton.rotations @ T.T
    rest = skeleton.rest_positions @ T.T * 100
    n, k = p.shape[:2]
    frame_time = float((skeleton.time[-1] - skeleton.time[0]) / (n - 1)) if n > 1 else 0.01
    tolerance = 1e-5 * max(float(np.ptp(rest, axis=0).max()), 1e-9)
    children: dict[int, list[int]] = {}
    for i, parent in enumerate(skeleton.parents):
        children.setdefault(parent, []).append(i)
    lines, columns = ["HIERARCHY"], []
    rotation_channels = " ".join(f"{x}rotation" for x in order)
    stack: list[tuple[int, int, bool]] = [(i, 0, False) for i in reversed(children.get(-1, []))]
    while stack:
        i, depth, closing = stack.pop()
        tab = "  " * depth
        if closing:
            lines.append(f"{tab}}}")
            continue
        parent = skeleton.parents[i]
        if parent < 0:
            offset, local_p, local_R = np.zeros(3), p[:, i], R[:, i]
            moves = True
        else:
            offset = rest[i] - rest[parent]
            back = np.swapaxes(R[:, parent], 1, 2)
            local_p = np.einsum("nij,nj->ni", back, p[:, i] - p[:, parent])
            local_R = back @ R[:, i]
            moves = bool(np.abs(local_p - offset).max() > tolerance)
            if moves and (np.abs(local_p - local_p[0]) <= tolerance).all():
                offset, moves = local_p[0], False
        name = re.sub(r"[\s{}]+", "_", skeleton.names[i]) or f"joint{i}"
        count = "6 Xposition Yposition Zposition " if moves else "3 "
        lines += [
            f"{tab}{'ROOT' if parent < 0 else 'JOINT'} {name}",
            f"{tab}{{",
            f"{tab}  OFFSET " + " ".join(f"{x:.7g}" for x in offset),
            f"{tab}  CHANNELS {count}{rotation_channels}",
        ]
        if moves:
            columns.append(local_p)
        with catch_warnings():  # at a singularity any of the equal angles will do
            simplefilter("ignore", UserWarning)
            columns.append(Rotation.from_matrix(local_R).as_euler(order, degrees=True))
        if not children.get(i):
            tip = np.einsum("nij,ni->nj", R[:, i], ends[:, i] - p[:, i])
            tip = np.median(tip, axis=0) if np.isfinite(tip).all() else np.zeros(3)
            text = " ".join(f"{x:.7g}" for x in tip)
            lines += [f"{tab}  End Site", f"{tab}  {{", f"{tab}    OFFSET {text}", f"{tab}  }}"]
        stack.append((i, depth, True))
        stack.extend((child, depth + 1, False) for child in reversed(children.get(i, [])))
    lines += ["MOTION", f"Frames: {n}", f"Frame Time: {frame_time:.8g}"]
    table = np.concatenate(columns, axis=1)
    row = " ".join(["%.6f"] * table.shape[1])
    lines += [row % tuple(values) for values in table.tolist()]
    write_text(path, "\n".join(lines) + "\n")
    return Path(path)
