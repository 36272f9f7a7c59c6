r"""AMC motions on ASF skeletons (Acclaim, used by the CMU motion capture database).

The ASF file (:mod:`plantigrade.io.asf`) describes the bones, the AMC file gives their rotations in
every frame. With :math:`C` the rotation of the bone's axis frame and :math:`M` the product of its
rotations, both about fixed axes in the order given (so that ``XYZ`` means :math:`R_z R_y R_x`), the
bone's world rotation is

.. math:: R = R_{parent} \, C \, M \, C^{-1},

and the bone extends from the end of its parent by :math:`R` times direction times length.

Lengths: one file unit is ``0.0254 / length`` metres, with ``length`` from the ``:units`` block,
as the CMU database defines it. Axes: y up, the rest pose facing z, x to the person's left, unless
the skeleton shows otherwise.
"""

import re
from array import array
from math import isfinite
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.asf import AsfSkeleton, find_asf, fixed_axes, read_asf
from plantigrade.io.skeletons import euler_rotation, left_axis, turn_to_ours, up_axis
from plantigrade.io.text import read_text
from plantigrade.motion.recording import Recording, SkeletonMotion

CMU_RATE = 120.0  # [Hz], of the CMU database: an AMC file does not say
PLAUSIBLE_HEIGHT = (0.9, 2.3)  # [m], of a skeleton in its rest pose, ankle or toe to head
UNITS = {"m": 1.0, "cm": 0.01, "in": 0.0254, "mm": 0.001}  # [m]
MAX_BYTES = 70e6  # of an AMC file [bytes]: about 12 minutes at 120 Hz


def read_amc(
    path: str | Path,
    *,
    skeleton: str | Path | None = None,
    rate: float | None = None,
    unit: str | None = None,
) -> Recording:
    """Read an AMC motion on its ASF skeleton.

    Args:
        path: The ``.amc`` file.
        skeleton: The ``.asf`` file; by default the one of the same name, of the part before the
            first underscore (``07.asf`` for ``07_01.amc``), or the only one in the folder.
        rate: Frames per second [Hz], which AMC files do not store; by default 120, as in the CMU
            database.
        unit: ``m``, ``cm``, ``mm`` or ``in``: the unit of a length divided by the skeleton's
            ``length``; by default inches (CMU) if plausible.

    Returns:
        A recording with a ``skeleton``: bones start at ``positions`` and end at ``ends``.

    Raises:
        FileError: If a file cannot be read; file and line are named.
        ParameterError: If an option is out of range.
    """
    path = Path(path)
    if rate is not None and not (np.isfinite(rate) and rate > 0):
        raise ParameterError(f"{rate=} [Hz] must be positive")
    if unit is not None and unit not in UNITS:
        raise ParameterError(f"{unit=} is not one of {', '.join(UNITS)}")
    text = read_text(path, MAX_BYTES)
    warnings: list[str] = []
    asf = read_asf(find_asf(path) if skeleton is None else skeleton)
    widths = {"root": len(asf.root_order)} | {b.name: len(b.dof) for b in asf.bones if b.dof}
    numbers, values, radians = _read_frames(path, text, widths, asf, warnings)
    if rate is None:
        rate = CMU_RATE
        warnings.append("AMC files do not store the frame rate: 120 Hz was assumed (option rate)")
    to_rad = 1.0 if (asf.radians if radians is None else radians) else np.pi / 180
    scale = _scale(asf, unit, warnings)
    time = (numbers - numbers[0]) / rate
    return Recording(
        source=path, skeleton=_motion(asf, values, to_rad, scale, time), warnings=tuple(warnings)
    )


def _read_frames(
    path: Path, text: str, widths: dict[str, int], asf: AsfSkeleton, warnings: list[str]
) -> tuple[np.ndarray, dict[str, np.ndarray], bool | None]:
    """Return frame numbers, each bone's values over the frames, and whether they are radians."""
    first = re.search(r"^[ \t]*\d+[ \t]*\r?$", text, re.MULTILINE)
    if first is None:
        remedy = "check that this is a complete AMC motion file"
        raise FileError(path, "has no frames (lines with a frame number)", remedy=remedy)
    header = text[: first.start()].upper()
    words = {w for line in header.splitlines() for w in line.split() if w.startswith(":")}
    radians = True if ":RADIANS" in words else False if ":DEGREES" in words else None
    n_lines = header.count("\n")
    numbers, values = _frames(path, text[first.start() :], n_lines, widths, asf, warnings)
    still = [name for name in widths if name not in values]
    if "root" in still:
        problem = "no frame has a root line of finite numbers"
        raise FileError(path, problem, remedy="correct the motion file")
    if still:
        warnings.append(f"bones without values were kept in the rest pose: {', '.join(still)}")
    _fill_ends(values, asf, warnings)
    return numbers, values, radians


def _frames(
    path: Path, text: str, first_line: int, widths: dict[str, int], asf: AsfSkeleton, warnings: list
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return frame numbers and values, without incomplete frames."""
    frames: list[tuple[float, dict[str, array[float]]]] = []
    broken: tuple[int, str] | None = None  # a bad line, tolerated in the last frame only
    remedy = "correct or delete this frame in the motion file"
    lines = re.finditer(r"^.*$", text, re.MULTILINE)  # a list of them is larger than the file
    for n, line in enumerate(lines, start=first_line + 1):
        words = line[0].split("#", 1)[0].split()
        if not words or words[0].startswith(":"):
            continue
        if len(words) == 1 and words[0].isdigit() and words[0].isascii():
            if broken is not None:
                raise FileError(path, broken[1], where=f"line {broken[0]}", remedy=remedy)
            number = float(words[0])
            if frames and number <= frames[-1][0]:
                problem = f"frame {words[0]} comes after frame {frames[-1][0]:.0f}"
                increase = "frame numbers must increase"
                raise FileError(path, problem, where=f"line {n}", remedy=increase)
            frames.append((number, {}))
            continue
        name = words[0]
        if name not in widths:
            known = any(bone.name == name for bone in asf.bones)
            what = "has no free channel" if known else "is not a bone"
            problem = f"{name!r} {what} in the skeleton {asf.source.name}"
            if not any(known.startswith(name) for known in widths):  # no name cut off
                other = "give the skeleton it was recorded with: option skeleton=FILE.asf"
                raise FileError(path, problem, where=f"line {n}", remedy=other)
            broken = broken or (n, problem)
            continue
        try:
            values = array("d", map(float, words[1:]))
        except ValueError:
            broken = broken or (n, f"the values of {name!r} are not all numbers")
            continue
        if len(values) != widths[name]:
            broken = broken or (
                n,
                f"{name!r} has {len(values)} values, the skeleton {asf.source.name} requires "
                f"{widths[name]}",
            )
        elif name in frames[-1][1]:
            broken = broken or (n, f"{name!r} occurs twice in frame {frames[-1][0]:.0f}")
        elif not all(map(isfinite, values)):
            continue  # as if it were missing
        else:
            frames[-1][1][name] = values
    if broken is not None:
        if len(frames) < 2:
            raise FileError(path, broken[1], where=f"line {broken[0]}", remedy=remedy)
        warnings.append(
            f"the last frame, {frames[-1][0]:.0f}, is truncated (line {broken[0]}) and was left out"
        )
        frames.pop()
    return _whole_frames(path, frames, first_line, tuple(widths), warnings)


def _whole_frames(
    path: Path,
    frames: list[tuple[float, dict[str, array]]],
    first_line: int,
    channels: tuple[str, ...],
    warnings: list[str],
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return frame numbers and values of the frames with all bones that occur."""
    names = [name for name in channels if any(name in frame for _, frame in frames)]
    gaps = [(number, [x for x in names if x not in frame]) for number, frame in frames]
    whole = [one for one, (_, gone) in zip(frames, gaps, strict=True) if not gone]
    lacking = [(number, gone) for number, gone in gaps if gone]
    if not whole:
        raise FileError(
            path,
            "no frame has values for all bones",
            where=f"line {first_line + 1}",
            remedy="check that the motion file is complete",
        )
    if lacking:
        number, gone = lacking[0]
        more = f" (and {len(lacking) - 1} further frames)" if len(lacking) > 1 else ""
        warnings.append(f"frame {number:.0f}{more} lacks {', '.join(gone[:5])} and was left out")
    numbers = np.array([number for number, _ in whole])
    return numbers, {name: np.array([frame[name] for _, frame in whole]) for name in names}


def _fill_ends(values: dict[str, np.ndarray], asf: AsfSkeleton, warnings: list[str]) -> None:
    """Give bones that are not known yet, or no longer, the values of the nearest frame.

    Files of the CMU database have zeros there: an arm that is in the rest pose for two frames and
    then beside the body. A bone is unknown in the first or last frames where several channels are
    exactly zero, or its only one and its parent is unknown too. Frames in which most bones are zero
    are a rest pose that was meant.
    """
    still = {name: ~rows.any(axis=1) for name, rows in values.items()}
    posed = np.mean(list(still.values()), axis=0) < 0.5
    unknown: dict[str, np.ndarray] = {}
    for bone in (b for b in asf.bones if b.name in values):
        above = asf.bones[bone.parent].name if bone.parent >= 0 else "root"
        gone = still[bone.name] & posed
        if len(bone.dof) < 2:
            gone &= unknown.get(above, np.zeros(len(gone), dtype=bool))
        known = np.flatnonzero(~gone)
        if not len(known):
            continue
        nearest = np.clip(np.arange(len(gone)), known[0], known[-1])
        unknown[bone.name] = nearest != np.arange(len(gone))
        values[bone.name] = values[bone.name][nearest]
    if filled := [name for name, where in unknown.items() if where.any()]:
        warnings.append(
            "bones without values at the beginning or end were kept as in the nearest frame: "
            f"{', '.join(filled)}"
        )


def _scale(asf: AsfSkeleton, unit: str | None, warnings: list[str]) -> float:
    """Return metres per file unit."""
    if unit is not None:
        return UNITS[unit] / asf.length_unit
    extent = float(np.ptp(np.concatenate(asf.rest_pose()), axis=0).max())
    candidates = {"in": UNITS["in"]} | UNITS
    low, high = PLAUSIBLE_HEIGHT
    for name, metres in candidates.items():
        if low <= extent * metres / asf.length_unit <= high:
            if name != "in":
                warnings.append(
                    f"lengths were taken as {name} / {asf.length_unit:g}: in inches the skeleton "
                    f"would be {extent * UNITS['in'] / asf.length_unit:.3g} m tall (option unit)"
                )
            return metres / asf.length_unit
    warnings.append(
        f"the skeleton is {extent * UNITS['in'] / asf.length_unit:.3g} m tall with lengths in "
        "inches, and no other unit fits better: check the size (option unit)"
    )
    return UNITS["in"] / asf.length_unit


def _motion(
    asf: AsfSkeleton,
    values: dict[str, np.ndarray],
    to_rad: float,
    scale: float,
    time: Float[Array, " n"],
) -> SkeletonMotion:
    """Return the forward kinematics in our axes, computed for all frames of a bone at once."""
    n, bones = len(time), asf.bones
    root = dict(zip(asf.root_order, values["root"].T, strict=True))
    zero = np.zeros(n)
    C = asf.root_axis
    angles = np.stack([root.get(f"R{x}", zero) for x in "XYZ"], 1) * to_rad
    # Rotations have the order of the channels.
    sequence = "".join(c[1] for c in asf.root_order if c[0] == "R")
    sequence += "".join(x for x in asf.root_rotation_order if x not in sequence)
    R = np.empty((n, len(bones) + 1, 3, 3))
    starts, ends = np.empty((n, len(bones) + 1, 3)), np.empty((n, len(bones) + 1, 3))
    R[:, 0] = C @ fixed_axes(sequence, angles) @ C.T
    translation = np.stack([root.get(f"T{x}", zero) for x in "XYZ"], 1)
    starts[:, 0] = ends[:, 0] = translation + asf.root_position
    for i, bone in enumerate(bones, start=1):
        parent = bone.parent + 1
        channels = dict(
            zip(bone.dof, values.get(bone.name, np.zeros((n, len(bone.dof)))).T, strict=True)
        )
        sequence = [c[1] for c in bone.dof if c[0] == "r"]
        R[:, i] = R[:, parent]
        starts[:, i] = ends[:, parent]
        if any(c[0] == "t" for c in channels):
            shift = np.stack([channels.get(f"t{x}", zero) for x in "xyz"], 1)
            starts[:, i] += np.einsum("nij,nj->ni", R[:, parent], shift @ bone.axis.T)
        if sequence:
            M = np.broadcast_to(np.eye(3), (n, 3, 3))
            for x in sequence:
                M = euler_rotation(x, channels[f"r{x}"][:, None] * to_rad) @ M
            R[:, i] = R[:, parent] @ (bone.axis @ M @ bone.axis.T)
        length = bone.length + channels.get("l", zero)
        ends[:, i] = starts[:, i] + R[:, i] @ bone.direction * length[:, None]
    names = ("root", *(bone.name for bone in bones))
    rest_starts, rest_ends = asf.rest_pose()
    rest = np.concatenate([np.zeros((1, 3)), rest_starts])
    middle = np.concatenate([np.zeros((1, 3)), (rest_starts + rest_ends) / 2])
    up = up_axis(names, middle[None])
    T = turn_to_ours(up, left_axis(names, middle, up))
    return SkeletonMotion(
        names=names,
        parents=(-1, *(bone.parent + 1 for bone in bones)),
        time=time,
        positions=starts @ T.T * scale,
        rotations=T @ R @ T.T,
        rest_positions=rest @ T.T * scale,
        ends=ends @ T.T * scale,
    )
