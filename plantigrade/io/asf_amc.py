r"""ASF skeletons and AMC motions (Acclaim, used by the CMU motion capture database).

The ASF file gives each bone a direction, a length, an axis frame and its free rotations; the AMC
file gives their values in every frame. With :math:`C` the rotation of the bone's axis frame and
:math:`M` the product of its rotations, both about fixed axes in the order given (so that ``XYZ``
means :math:`R_z R_y R_x`), the bone's world rotation is

.. math:: R = R_{parent} \, C \, M \, C^{-1},

and it reaches from the end of its parent to there plus :math:`R` times direction times length.

Lengths: one file unit is ``0.0254 / length`` metres, with ``length`` from the ``:units`` block,
as the CMU database defines it. Axes: y up, the rest pose facing z, x to the person's left, found
from the skeleton where it says otherwise.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.skeletons import (
    euler_rotation,
    left_axis,
    turn_to_ours,
    up_axis,
)
from plantigrade.io.text import read_text
from plantigrade.motion.recording import Recording, SkeletonMotion

CMU_RATE = 120.0  # [Hz], of the CMU database: an AMC file does not say
PLAUSIBLE_HEIGHT = (0.9, 2.3)  # [m], of a skeleton in its rest pose, ankle or toe to head
UNITS = {"m": 1.0, "cm": 0.01, "in": 0.0254, "mm": 0.001}  # [m]
MAX_BONES = 1000
MAX_BYTES = 30e6  # of an AMC file [bytes]: about 5 minutes at 120 Hz

_ROOT_CHANNELS = ("TX", "TY", "TZ", "RX", "RY", "RZ")
_BONE_CHANNELS = ("rx", "ry", "rz", "tx", "ty", "tz", "l")


@dataclass(frozen=True)
class Bone:
    """One bone of an ASF skeleton, in file axes and units, angles in radians.

    Attributes:
        name: Its name.
        parent: Index of its parent bone in the skeleton; -1 where that is the root.
        direction: Unit vector along the bone in the rest pose.
        length: Length in file units.
        axis: World rotation of its axis frame in the rest pose.
        dof: Its free channels in the order of the AMC values: ``rx ry rz tx ty tz l``.
        limits: Lower and upper limit of each channel [rad, file units].
    """

    name: str
    parent: int
    direction: Float[Array, "3"]
    length: float
    axis: Float[Array, "3 3"]
    dof: tuple[str, ...]
    limits: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class AsfSkeleton:
    """An ASF skeleton.

    Attributes:
        source: The file.
        bones: Its bones, parents before children.
        length_unit: The ``length`` of the ``:units`` block.
        radians: Whether the file's angles are radians.
        root_order: Channels of the root line of the AMC file.
        root_axis: Rotation of the root's axis frame.
        root_position: Position added to the root's translations, file units.
    """

    source: Path
    bones: tuple[Bone, ...]
    length_unit: float
    radians: bool
    root_order: tuple[str, ...]
    root_axis: Float[Array, "3 3"]
    root_rotation_order: str
    root_position: Float[Array, "3"]


# ---------------------------------------------------------------------------------------- ASF


def read_asf(path: str | Path) -> AsfSkeleton:
    """Read an ASF skeleton.

    Raises:
        FileError: If the file is not a whole ASF skeleton; the line is named.
    """
    path = Path(path)
    return _AsfParser(path, read_text(path)).parse()


class _AsfParser:
    """Reads an ASF file line by line; every error names the line."""

    def __init__(self, path: Path, text: str):
        self.path = path
        self.lines = [line.split("#", 1)[0].split() for line in text.splitlines()]
        self.n = 0

    def error(self, problem: str, line: int | None = None, remedy: str = "") -> FileError:
        where = f"line {(self.n if line is None else line) + 1}" if self.lines else ""
        return FileError(
            self.path, problem, where=where, remedy=remedy or "check the skeleton file (.asf)"
        )

    def number(self, word: str) -> float:
        try:
            value = float(word)
        except ValueError:
            raise self.error(f"{word!r} is not a number") from None
        if not np.isfinite(value):
            raise self.error(f"{word!r} is not a finite number")
        return value

    def numbers(self, words: list[str], count: int, what: str) -> np.ndarray:
        if len(words) < count:
            raise self.error(f"{what} needs {count} numbers, here are {len(words)}")
        return np.array([self.number(word) for word in words[:count]])

    def section(self) -> list[tuple[int, list[str]]]:
        """Return the lines up to the next ``:keyword`` and stand on it."""
        rows = []
        while self.n < len(self.lines):
            words = self.lines[self.n]
            if words and words[0].startswith(":"):
                break
            if words:
                rows.append((self.n, words))
            self.n += 1
        return rows

    def parse(self) -> AsfSkeleton:
        found: dict[str, list[tuple[int, list[str]]]] = {}
        self.section()
        while self.n < len(self.lines):
            keyword = self.lines[self.n][0][1:].lower()
            self.n += 1
            found.setdefault(keyword, []).extend(self.section())
        self.n = max(len(self.lines) - 1, 0)
        for needed in ("root", "bonedata", "hierarchy"):
            if not found.get(needed):
                raise self.error(
                    f"there is no :{needed} section, so this is not a whole ASF skeleton"
                )
        units = {words[0].lower(): (n, words[1:]) for n, words in found.get("units", [])}
        self.n, words = units.get("length", (0, ["1"]))
        length_unit = float(self.numbers(words, 1, "units length")[0])
        if length_unit <= 0:
            raise self.error(f"units length is {length_unit}; it must be positive")
        self.n, words = units.get("angle", (0, ["deg"]))
        radians = bool(words) and words[0].lower().startswith("rad")
        self.to_rad = 1.0 if radians else np.pi / 180
        bones = self.bones(found["bonedata"])
        bones = self.hierarchy(found["hierarchy"], bones)
        return AsfSkeleton(self.path, bones, length_unit, radians, *self.root(found["root"]))

    def root(self, rows):
        order, axis_order = _ROOT_CHANNELS, "XYZ"
        position, orientation = np.zeros(3), np.zeros(3)
        for self.n, words in rows:
            key, rest = words[0].lower(), words[1:]
            if key == "order":
                order = tuple(word.upper() for word in rest)
                if sorted(set(order)) != sorted(order) or not set(order) <= set(_ROOT_CHANNELS):
                    raise self.error(
                        f"root order is {' '.join(rest)}; allowed are {' '.join(_ROOT_CHANNELS)}"
                    )
            elif key == "axis":
                axis_order = self.axis_order(rest)
            elif key == "position":
                position = self.numbers(rest, 3, "root position")
            elif key == "orientation":
                orientation = self.numbers(rest, 3, "root orientation") * self.to_rad
        axis = _fixed_axes(axis_order, orientation[None])[0]
        return order, axis, axis_order, position

    def axis_order(self, words: list[str]) -> str:
        order = words[0].upper() if words else "XYZ"
        if sorted(order) != ["X", "Y", "Z"]:
            raise self.error(f"axis order is {order!r}; it must hold X, Y and Z once each")
        return order

    def bones(self, rows) -> dict[str, dict]:
        bones: dict[str, dict] = {}
        bone: dict | None = None
        expect_limits = 0
        for self.n, words in rows:
            key, rest = words[0].lower(), words[1:]
            if key == "begin":
                if bone is not None:
                    raise self.error("a bone begins before the last one has its end")
                bone, expect_limits = {"line": self.n}, 0
                continue
            if bone is None:
                raise self.error(f"{words[0]!r} stands outside begin … end")
            if key == "end":
                self.add(bone, bones)
                bone = None
            elif key == "name":
                bone["name"] = self.word(rest, "name")
            elif key == "direction":
                bone["direction"] = self.numbers(rest, 3, "direction")
            elif key == "length":
                bone["length"] = float(self.numbers(rest, 1, "length")[0])
            elif key == "axis":
                angles = self.numbers(rest, 3, "axis") * self.to_rad
                bone["axis"] = _fixed_axes(self.axis_order(rest[3:]), angles[None])[0]
            elif key == "dof":
                dof = tuple(word.lower() for word in rest)
                if not set(dof) <= set(_BONE_CHANNELS) or len(set(dof)) != len(dof):
                    raise self.error(
                        f"dof is {' '.join(rest)}; allowed are {' '.join(_BONE_CHANNELS)}"
                    )
                bone["dof"] = dof
            elif key == "limits" or words[0].startswith("("):
                expect_limits = 1
                line = " ".join(rest if key == "limits" else words)
                bone.setdefault("limits", []).extend(self.limits(line))
            elif expect_limits and key == "limits":
                pass
            # id, bodymass, cofmass and whatever else describe no motion
        if bone is not None:
            raise self.error("the last bone has no end: the file is cut off", bone["line"])
        if not bones:
            raise self.error("there are no bones in :bonedata")
        return bones

    def limits(self, line: str) -> list[tuple[float, float]]:
        pairs = []
        for text in re.findall(r"\(([^()]*)\)", line):
            words = text.replace(",", " ").split()
            try:
                low, high = (float(word) for word in words)
            except ValueError:
                raise self.error(f"limits ({text}) are not two numbers") from None
            pairs.append((low, high))
        return pairs

    def word(self, words: list[str], what: str) -> str:
        if not words:
            raise self.error(f"{what} is empty")
        return words[0]

    def add(self, bone: dict, bones: dict[str, dict]) -> None:
        for field in ("name", "direction", "length"):
            if field not in bone:
                raise self.error(f"this bone has no {field}", bone["line"])
        size = np.linalg.norm(bone["direction"])
        if size < 1e-6 and bone["length"] > 0:
            raise self.error(f"bone {bone['name']!r} has no direction (0 0 0)", bone["line"])
        bone["direction"] = bone["direction"] / (size or 1.0)
        if bone["name"] in bones or bone["name"] == "root":
            raise self.error(f"there are two bones named {bone['name']!r}", bone["line"])
        if len(bones) >= MAX_BONES:
            raise self.error(f"there are more than {MAX_BONES} bones: no human skeleton")
        bones[bone["name"]] = bone

    def hierarchy(self, rows, bones: dict[str, dict]) -> tuple[Bone, ...]:
        parent_of: dict[str, str] = {}
        for self.n, words in rows:
            if words[0].lower() in ("begin", "end") and len(words) == 1:
                continue
            for child in words[1:]:
                for name in (words[0], child):
                    if name != "root" and name not in bones:
                        raise self.error(
                            f"the hierarchy names bone {name!r}, which is not in :bonedata"
                        )
                if child in parent_of or child == "root":
                    raise self.error(f"bone {child!r} has two parents")
                parent_of[child] = words[0]
        children: dict[str, list[str]] = {}
        for child, parent in parent_of.items():
            children.setdefault(parent, []).append(child)
        order, stack = [], list(reversed(children.get("root", [])))
        while stack:
            name = stack.pop()
            order.append(name)
            stack.extend(reversed(children.get(name, [])))
        lost = [name for name in bones if name not in order]
        if lost:
            raise self.error(f"these bones do not hang on the root: {', '.join(lost[:8])}")
        index = {name: i for i, name in enumerate(order)} | {"root": -1}
        return tuple(
            Bone(
                name,
                index[parent_of[name]],
                bones[name]["direction"],
                bones[name]["length"],
                bones[name].get("axis", np.eye(3)),
                bones[name].get("dof", ()),
                tuple(
                    (low * self.to_rad, high * self.to_rad)
                    if channel.startswith("r")
                    else (low, high)
                    for channel, (low, high) in zip(
                        bones[name].get("dof", ()), bones[name].get("limits", []), strict=False
                    )
                ),
            )
            for name in order
        )


def _fixed_axes(order: str, angles: Float[Array, "n k"]) -> Float[Array, "n 3 3"]:
    """Return rotations about fixed axes, the first letter of ``order`` first; angles in xyz."""
    columns = ["XYZ".index(letter) for letter in reversed(order)]
    return euler_rotation(order[::-1], angles[:, columns])


# ---------------------------------------------------------------------------------------- AMC


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
        skeleton: The ``.asf`` file; where absent, the one of the same name, of the part before the
            first underscore (``07.asf`` for ``07_01.amc``), or the only one in the folder.
        rate: Frames per second [Hz]; an AMC file does not say. 120, the CMU database's, if absent.
        unit: ``m``, ``cm``, ``mm`` or ``in``: what one unit divided by the skeleton's ``length``
            is; inches (CMU) if absent and plausible.

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
        warnings.append("an AMC file does not say its rate: 120 Hz taken (option rate)")
    to_rad = 1.0 if (asf.radians if radians is None else radians) else np.pi / 180
    scale = _scale(asf, unit, warnings)
    time = (numbers - numbers[0]) / rate
    return Recording(
        source=path,
        skeleton=_motion(asf, values, to_rad, scale, time),
        warnings=tuple(warnings),
    )


def find_asf(path: Path) -> Path:
    """Return the skeleton file beside the motion ``path``.

    Raises:
        FileError: If there is none, or several and none by its name.
    """
    try:
        beside = sorted(p for p in path.parent.iterdir() if p.suffix.lower() == ".asf")
    except OSError as error:
        raise FileError(path.parent, f"cannot be searched ({error.strerror})") from error
    stem = path.stem.lower()
    for wanted in (stem, stem.split("_")[0], re.split(r"[_\-. ]", stem)[0]):
        for candidate in beside:
            if candidate.stem.lower() == wanted:
                return candidate
    if len(beside) == 1:
        return beside[0]
    problem = (
        "there is no skeleton file (.asf) beside it"
        if not beside
        else f"which skeleton is its own? Beside it lie {', '.join(p.name for p in beside[:8])}"
    )
    raise FileError(path, problem, remedy="name it with the option skeleton=FILE.asf")


def _read_frames(
    path: Path, text: str, widths: dict[str, int], asf: AsfSkeleton, warnings: list[str]
) -> tuple[np.ndarray, dict[str, np.ndarray], bool | None]:
    """Return frame numbers, each bone's values over the frames, and whether they are radians."""
    first = re.search(r"^[ \t]*\d+[ \t]*\r?$", text, re.MULTILINE)
    if first is None:
        raise FileError(
            path,
            "there is no frame in it (a line with the frame's number)",
            remedy="check that this is an AMC motion file and whole",
        )
    header = text[: first.start()].upper()
    words = {w for line in header.splitlines() for w in line.split() if w.startswith(":")}
    radians = True if ":RADIANS" in words else False if ":DEGREES" in words else None
    fast = _regular_frames(text[first.start() :], widths)
    if fast is None:
        n_lines = text.count("\n", 0, first.start())
        fast = _irregular_frames(path, text[first.start() :], n_lines, widths, asf, warnings)
    numbers, values = fast
    still = [name for name in widths if name not in values]
    if "root" in still:
        raise FileError(path, "no frame has a root line", remedy="check the motion file")
    if still:
        warnings.append(f"bones without values stay in the rest pose: {', '.join(still)}")
    return numbers, values, radians


def _regular_frames(text: str, widths: dict[str, int]):
    """Return the frames where every one has the same lines in the same order, else None."""
    if "#" in text or ":" in text:
        return None
    second = re.search(r"\n[ \t]*\d+[ \t]*\r?\n", text)
    head = (text if second is None else text[: second.start()]).split("\n")
    layout, position = [], 1
    for line in head[1:]:
        words = line.split()
        if not words:
            continue
        if widths.get(words[0]) != len(words) - 1:
            return None
        layout.append((words[0], position, len(words) - 1))
        position += len(words)
    tokens = text.split()
    if not layout or len(tokens) % position or len({name for name, *_ in layout}) != len(layout):
        return None
    n_frames = len(tokens) // position
    for name, column, _ in layout:
        if tokens[column::position].count(name) != n_frames:
            return None
    try:
        numbers = np.array(tokens[::position], dtype=float)
        values = {
            name: np.array(
                [tokens[column + 1 + k :: position] for k in range(width)], dtype=float
            ).T
            for name, column, width in layout
        }
    except ValueError:
        return None
    if not np.all(np.diff(numbers) > 0) or not all(np.isfinite(v).all() for v in values.values()):
        return None
    return numbers, values


def _irregular_frames(
    path: Path,
    text: str,
    first_line: int,
    widths: dict[str, int],
    asf: AsfSkeleton,
    warnings: list[str],
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the frames of a file with gaps, comments or a cut-off end; slower, line by line."""
    frames: list[tuple[float, dict[str, list[float]]]] = []
    broken: tuple[int, str] | None = None  # a bad line: forgiven in the last frame only
    remedy = "mend or delete this frame in the motion file"
    for n, line in enumerate(text.splitlines(), start=first_line + 1):
        words = line.split("#", 1)[0].split()
        if not words or words[0].startswith(":"):
            continue
        if len(words) == 1 and words[0].isdigit() and words[0].isascii():
            if broken is not None:
                raise FileError(path, broken[1], where=f"line {broken[0]}", remedy=remedy)
            number = float(words[0])
            if frames and number <= frames[-1][0]:
                raise FileError(
                    path,
                    f"frame {words[0]} comes after frame {frames[-1][0]:.0f}",
                    where=f"line {n}",
                    remedy="frames must be in order, each once",
                )
            frames.append((number, {}))
            continue
        name = words[0]
        if name not in widths:
            known = any(bone.name == name for bone in asf.bones)
            what = "has no free channel" if known else "is not a bone"
            if not frames or not _is_cut(name, widths):
                raise FileError(
                    path,
                    f"{name!r} {what} in the skeleton {asf.source.name}",
                    where=f"line {n}",
                    remedy="name the skeleton it was recorded with: option skeleton=FILE.asf",
                )
            broken = broken or (n, f"{name!r} {what} in the skeleton {asf.source.name}")
            continue
        try:
            values = [float(word) for word in words[1:]]
        except ValueError:
            broken = broken or (n, f"the values of {name!r} are not all numbers")
            continue
        if len(values) != widths[name]:
            broken = broken or (
                n,
                f"{name!r} has {len(values)} values, the skeleton {asf.source.name} wants "
                f"{widths[name]}",
            )
        elif name in frames[-1][1]:
            broken = broken or (n, f"{name!r} stands twice in frame {frames[-1][0]:.0f}")
        elif not np.all(np.isfinite(values)):
            continue  # as if it were missing
        else:
            frames[-1][1][name] = values
    if broken is not None:
        if len(frames) < 2:
            raise FileError(path, broken[1], where=f"line {broken[0]}", remedy=remedy)
        warnings.append(
            f"frame {frames[-1][0]:.0f}, the last, is cut off (line {broken[0]}) and left out"
        )
        frames.pop()
    names = [name for name in widths if any(name in frame for _, frame in frames)]
    whole = [(number, frame) for number, frame in frames if all(name in frame for name in names)]
    if not whole:
        raise FileError(
            path,
            "no frame has all its bones",
            where=f"line {first_line + 1}",
            remedy="check that the motion file is whole",
        )
    lacking = [(number, [x for x in names if x not in frame]) for number, frame in frames]
    lacking = [(number, gone) for number, gone in lacking if gone]
    if lacking:
        number, gone = lacking[0]
        more = f" (and {len(lacking) - 1} more frames)" if len(lacking) > 1 else ""
        warnings.append(f"frame {number:.0f}{more} lacks {', '.join(gone[:5])} and is left out")
    numbers = np.array([number for number, _ in whole])
    return numbers, {name: np.array([frame[name] for _, frame in whole]) for name in names}


def _is_cut(name: str, widths: dict[str, int]) -> bool:
    return any(known.startswith(name) for known in widths)


def _scale(asf: AsfSkeleton, unit: str | None, warnings: list[str]) -> float:
    """Return metres per file unit."""
    if unit is not None:
        return UNITS[unit] / asf.length_unit
    starts, ends = _rest(asf)
    points = np.concatenate([starts, ends])
    extent = float(np.ptp(points, axis=0).max())
    candidates = {"in": UNITS["in"]} | UNITS
    low, high = PLAUSIBLE_HEIGHT
    for name, metres in candidates.items():
        if low <= extent * metres / asf.length_unit <= high:
            if name != "in":
                warnings.append(
                    f"lengths taken as {name} / {asf.length_unit:g}: in inches the skeleton would "
                    f"be {extent * UNITS['in'] / asf.length_unit:.3g} m tall (option unit)"
                )
            return metres / asf.length_unit
    warnings.append(
        f"the skeleton is {extent * UNITS['in'] / asf.length_unit:.3g} m tall with lengths in "
        "inches, no other unit fits better: check the size (option unit)"
    )
    return UNITS["in"] / asf.length_unit


def _rest(asf: AsfSkeleton) -> tuple[Float[Array, "n 3"], Float[Array, "n 3"]]:
    """Return where each bone starts and ends in the rest pose, root at the origin, file axes."""
    starts, ends = np.zeros((len(asf.bones), 3)), np.zeros((len(asf.bones), 3))
    for i, bone in enumerate(asf.bones):
        starts[i] = ends[bone.parent] if bone.parent >= 0 else 0.0
        ends[i] = starts[i] + bone.direction * bone.length
    return starts, ends


def _motion(
    asf: AsfSkeleton,
    values: dict[str, np.ndarray],
    to_rad: float,
    scale: float,
    time: Float[Array, " n"],
) -> SkeletonMotion:
    """Run the forward kinematics, all frames of a bone at once, and turn it to our axes."""
    n, bones = len(time), asf.bones
    root = dict(zip(asf.root_order, values["root"].T, strict=True))
    zero = np.zeros(n)
    C = asf.root_axis
    angles = np.stack([root.get(f"R{x}", zero) for x in "XYZ"], 1) * to_rad
    # The order of the channels is that of the rotations: the first listed turns first.
    sequence = "".join(c[1] for c in asf.root_order if c[0] == "R")
    sequence += "".join(x for x in asf.root_rotation_order if x not in sequence)
    R = np.empty((n, len(bones) + 1, 3, 3))
    starts, ends = np.empty((n, len(bones) + 1, 3)), np.empty((n, len(bones) + 1, 3))
    R[:, 0] = C @ _fixed_axes(sequence, angles) @ C.T
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
    rest_starts, rest_ends = _rest(asf)
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
