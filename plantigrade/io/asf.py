"""ASF skeletons (Acclaim, used by the CMU motion capture database).

The file gives each bone a direction, a length, an axis frame and its free rotations;
:mod:`plantigrade.io.amc` reads their values in every frame.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError
from plantigrade.io.companions import Siblings
from plantigrade.io.skeletons import euler_rotation
from plantigrade.io.text import read_text

MAX_BONES = 1000  # beyond it the file is damaged: a rig with hands and face has 163

_ROOT_CHANNELS = ("TX", "TY", "TZ", "RX", "RY", "RZ")
_BONE_CHANNELS = ("rx", "ry", "rz", "tx", "ty", "tz", "l")


@dataclass(frozen=True)
class AsfBone:
    """One bone of an ASF skeleton, in file axes and units, angles in radians."""

    name: str  #: Its name
    parent: int  #: Index of its parent bone in the skeleton; -1 where that is the root
    direction: Float[Array, "3"]  #: Unit vector along the bone in the rest pose
    length: float  #: Length in file units
    axis: Float[Array, "3 3"]  #: World rotation of its axis frame in the rest pose
    #: Its free channels in the order of the AMC values: ``rx ry rz tx ty tz l``
    dof: tuple[str, ...]


@dataclass(frozen=True)
class AsfSkeleton:
    """An ASF skeleton."""

    source: Path  #: The file
    bones: tuple[AsfBone, ...]  #: Its bones, parents before children
    length_unit: float  #: The ``length`` of the ``:units`` block
    radians: bool  #: Whether the file's angles are radians
    root_order: tuple[str, ...]  #: Channels of the root line of the AMC file
    root_axis: Float[Array, "3 3"]  #: Rotation of the root's axis frame
    root_rotation_order: str
    root_position: Float[Array, "3"]  #: Position added to the root's translations, file units

    def rest_pose(self) -> tuple[Float[Array, "n 3"], Float[Array, "n 3"]]:
        """Return start and end of each bone at rest, root at the origin, file axes."""
        starts, ends = np.zeros((len(self.bones), 3)), np.zeros((len(self.bones), 3))
        for i, bone in enumerate(self.bones):
            starts[i] = ends[bone.parent] if bone.parent >= 0 else 0.0
            ends[i] = starts[i] + bone.direction * bone.length
        return starts, ends


def read_asf(path: str | Path) -> AsfSkeleton:
    """Read an ASF skeleton.

    Raises:
        FileError: If the file is not a complete ASF skeleton; the message names the line.
    """
    path = Path(path)
    return _AsfParser(path, read_text(path)).parse()


class _AsfParser:
    """Parser of an ASF file; every error names the line."""

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
            raise self.error(f"{what} needs {count} numbers, not {len(words)}")
        return np.array([self.number(word) for word in words[:count]])

    def section(self) -> list[tuple[int, list[str]]]:
        """Return the lines up to the next ``:keyword`` and stop there."""
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
                    f"has no :{needed} section, so this is not a complete ASF skeleton"
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
        axis = fixed_axes(axis_order, orientation[None])[0]
        return order, axis, axis_order, position

    def axis_order(self, words: list[str]) -> str:
        order = words[0].upper() if words else "XYZ"
        if sorted(order) != ["X", "Y", "Z"]:
            raise self.error(f"axis order is {order!r}; it must contain X, Y and Z once each")
        return order

    def bones(self, rows) -> dict[str, dict]:
        bones: dict[str, dict] = {}
        bone: dict | None = None
        for self.n, words in rows:
            key, rest = words[0].lower(), words[1:]
            if key == "begin":
                if bone is not None:
                    raise self.error("a bone begins before the previous one has ended")
                bone = {"line": self.n, "axis": np.eye(3), "dof": ()}
                continue
            if bone is None:
                raise self.error(f"{words[0]!r} is outside begin … end")
            if key == "end":
                self.add(bone, bones)
                bone = None
            elif key == "name":
                if not rest:
                    raise self.error("name is empty")
                bone["name"] = rest[0]
            elif key == "direction":
                bone["direction"] = self.numbers(rest, 3, "direction")
            elif key == "length":
                bone["length"] = float(self.numbers(rest, 1, "length")[0])
            elif key == "axis":
                angles = self.numbers(rest, 3, "axis") * self.to_rad
                bone["axis"] = fixed_axes(self.axis_order(rest[3:]), angles[None])[0]
            elif key == "dof":
                dof = tuple(word.lower() for word in rest)
                if not set(dof) <= set(_BONE_CHANNELS) or len(set(dof)) != len(dof):
                    raise self.error(
                        f"dof is {' '.join(rest)}; allowed are {' '.join(_BONE_CHANNELS)}"
                    )
                bone["dof"] = dof
            elif key == "limits" or words[0].startswith("("):
                self.check_limits(" ".join(words))
            # id, bodymass, cofmass and whatever else describe no motion
        if bone is not None:
            raise self.error("the last bone has no end: the file is truncated", bone["line"])
        if not bones:
            raise self.error("there are no bones in :bonedata")
        return bones

    def check_limits(self, line: str) -> None:
        """Check that joint limits are pairs of numbers; they are not used."""
        for text in re.findall(r"\(([^()]*)\)", line):
            try:
                _, _ = (float(word) for word in text.replace(",", " ").split())
            except ValueError:
                raise self.error(f"limits ({text}) are not two numbers") from None

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
            raise self.error(f"there are more than {MAX_BONES} bones: not a human skeleton")
        bones[bone["name"]] = bone

    def hierarchy(self, rows, bones: dict[str, dict]) -> tuple[AsfBone, ...]:
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
            raise self.error(f"these bones are not connected to the root: {', '.join(lost[:8])}")
        index = {name: i for i, name in enumerate(order)} | {"root": -1}
        fields = ("direction", "length", "axis", "dof")
        return tuple(
            AsfBone(name, index[parent_of[name]], *(bones[name][field] for field in fields))
            for name in order
        )


def fixed_axes(order: str, angles: Float[Array, "n k"]) -> Float[Array, "n 3 3"]:
    """Return rotations about fixed axes, the first letter of ``order`` first; angles in xyz."""
    columns = ["XYZ".index(letter) for letter in reversed(order)]
    return euler_rotation(order[::-1], angles[:, columns])


def find_asf(path: Path) -> Path:
    """Return the skeleton file of a motion, from the same folder."""
    neighbours, stem = Siblings.of(path).skeletons, path.stem.lower()
    for name_stem in (stem, stem.split("_")[0], re.split(r"[_\-. ]", stem)[0]):
        if name_stem in neighbours:
            return neighbours[name_stem]
    if len(neighbours) == 1:
        return next(iter(neighbours.values()))
    problem = "there is no skeleton file (.asf) in its folder"
    if neighbours:
        names = ", ".join(p.name for p in list(neighbours.values())[:8])
        problem = f"its folder holds several skeletons, none of its name: {names}"
    raise FileError(path, problem, remedy="give it with the option skeleton=FILE.asf")
