"""The HIERARCHY section of a BVH file: joints, their offsets and channels."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plantigrade.errors import FileError
from plantigrade.io.text import count_of

MAX_JOINTS = 2000  # beyond it the file is damaged: a rig with hands and face has 163

_CHANNEL = re.compile(r"([XYZ])(position|rotation)", re.IGNORECASE)


@dataclass
class BvhJoint:
    """A joint of the hierarchy, in file axes and units."""

    name: str  #: Name of the joint
    parent: int  #: Index of the parent; -1 for the root
    offset: np.ndarray  #: Offset from the parent at rest
    channels: tuple[tuple[str, str], ...] = ()  #: Channels in file order, as ``("rotation", "z")``
    first_channel: int = 0  #: Column of the first channel
    end: np.ndarray | None = None  #: Offset of the End Site from the joint


def read_hierarchy(path: Path, text: str, warnings: list[str]) -> tuple[list[BvhJoint], int]:
    """Return the joints of the first skeleton, parents first, and the number of channels.

    Raises:
        FileError: If the hierarchy is damaged; the message names the line.
    """
    return _Hierarchy(path, text, warnings).parse()


class _Hierarchy:
    """Parser of the HIERARCHY section; every error names the line."""

    def __init__(self, path: Path, text: str, warnings: list[str]):
        self.path, self.warnings = path, warnings
        self.lines = text.replace("{", "\n{\n").replace("}", "\n}\n") if _crowded(text) else text
        self.crowded = self.lines is not text
        self.n = 0
        self.joints: list[BvhJoint] = []
        self.stack: list[int | None] = []  # open blocks: a joint, or None for an End Site
        self.pending: int | None = None  # the block that the next brace opens
        self.ended = 0  # the joint that has an End Site
        self.expect_brace = False
        self.n_channels = 0

    def error(self, problem: str) -> FileError:
        where = "HIERARCHY" if self.crowded else f"line {self.n}"
        return FileError(self.path, problem, where=where, remedy="check the BVH file's hierarchy")

    def parse(self) -> tuple[list[BvhJoint], int]:
        """Return the joints of the first root, parents first, and the number of channels."""
        for n, line in enumerate(self.lines.splitlines(), start=1):
            self.n = n
            words = line.split()
            if words and words[0].upper() != "HIERARCHY":
                self.read(words[0].upper(), words)
        joints = self.joints
        if not joints:
            raise self.error("has no ROOT")
        if self.stack or self.expect_brace:
            raise self.error("a '}' is missing: the hierarchy is truncated")
        if not self.n_channels:
            raise self.error("no joint has CHANNELS")
        roots = [i for i, joint in enumerate(joints) if joint.parent == -1]
        if len(roots) > 1:
            self.warnings.append(
                f"the file holds {len(roots)} skeletons; only the first, {joints[0].name!r}, was "
                "read"
            )
            joints = joints[: roots[1]]
        self.unique_names(joints)
        return joints, self.n_channels

    def read(self, key: str, words: list[str]) -> None:
        """Read one line."""
        if key == "{":
            if not self.expect_brace:
                raise self.error("'{' does not follow a joint")
            self.stack.append(self.pending)
            self.expect_brace = False
        elif self.expect_brace:
            raise self.error(f"'{{' is missing before {words[0]!r}")
        elif key == "}":
            if not self.stack:
                raise self.error("'}' without '{'")
            self.stack.pop()
        elif key in ("ROOT", "JOINT"):
            self.begin_joint(key, words)
        elif key == "END":
            self.ended = self.inside("End Site")
            self.pending, self.expect_brace = None, True
        elif key == "OFFSET":
            offset = self.numbers(words[1:], 3)
            if not self.stack:
                raise self.error("OFFSET is outside a joint")
            if self.stack[-1] is None:
                self.joints[self.ended].end = offset
            else:
                self.joints[self.stack[-1]].offset = offset
        elif key == "CHANNELS":
            joint = self.joints[self.inside("CHANNELS")]
            if joint.channels:
                raise self.error(f"joint {joint.name!r} has CHANNELS twice")
            joint.channels = self.channels(words[1:])
            joint.first_channel = self.n_channels
            self.n_channels += len(joint.channels)
        else:
            raise self.error(f"{words[0]!r} is not a keyword of a hierarchy")

    def begin_joint(self, key: str, words: list[str]) -> None:
        """Add the joint of a line with its name."""
        if key == "JOINT" and (not self.stack or self.stack[-1] is None):
            raise self.error("JOINT is outside a ROOT")
        if key == "ROOT" and self.stack:
            raise self.error("ROOT is inside another joint")
        if len(self.joints) >= MAX_JOINTS:
            raise self.error(f"has more than {MAX_JOINTS} joints: not a human skeleton")
        name = " ".join(words[1:]) or f"joint{len(self.joints)}"
        parent = self.stack[-1] if self.stack else -1
        self.joints.append(BvhJoint(name, -1 if parent is None else parent, np.zeros(3)))
        self.pending, self.expect_brace = len(self.joints) - 1, True

    def inside(self, what: str) -> int:
        """Return the joint whose block is open."""
        if not self.stack or self.stack[-1] is None:
            raise self.error(f"{what} is outside a joint")
        return self.stack[-1]

    def numbers(self, words: list[str], count: int) -> np.ndarray:
        try:
            numbers = np.array([float(word) for word in words])
        except ValueError:
            numbers = np.empty(0)
        if len(numbers) != count or not np.isfinite(numbers).all():
            raise self.error(f"OFFSET needs {count} numbers, not {' '.join(words)[:60]!r}")
        return numbers

    def channels(self, words: list[str]) -> tuple[tuple[str, str], ...]:
        count = count_of(words[0]) if words else None
        if count is None:
            raise self.error("CHANNELS needs a count")
        if count != len(words) - 1:
            raise self.error(f"CHANNELS announces {count} and lists {len(words) - 1}")
        channels = []
        for word in words[1:]:
            known = _CHANNEL.fullmatch(word)
            if known is None:
                raise self.error(
                    f"channel {word!r} is not Xposition … Zposition, Xrotation … Zrotation"
                )
            channels.append((known[2].lower(), known[1].lower()))
        positions = [axis for kind, axis in channels if kind == "position"]
        if len(set(positions)) != len(positions):
            raise self.error("a position channel is listed twice")
        return tuple(channels)

    def unique_names(self, joints: list[BvhJoint]) -> None:
        seen: dict[str, int] = {}
        for joint in joints:
            seen[joint.name] = seen.get(joint.name, 0) + 1
            if seen[joint.name] > 1:
                self.warnings.append(
                    f"several joints are named {joint.name!r}: numbered from the second on"
                )
                joint.name = f"{joint.name}#{seen[joint.name]}"


def _crowded(text: str) -> bool:
    """Return whether braces share a line with other words."""
    return re.search(r"[{}][ \t]*[^\s{}]|[^\s][ \t]*[{}]", text) is not None
