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
class Joint:
    """A joint of the hierarchy, in file axes and units."""

    name: str  #: Name of the joint
    parent: int  #: Index of the parent; -1 for the root
    offset: np.ndarray  #: Offset from the parent at rest
    channels: tuple[tuple[str, str], ...] = ()  #: Channels in file order, as ``("rotation", "z")``
    first_channel: int = 0  #: Column of the first channel
    end: np.ndarray | None = None  #: Offset of the End Site from the joint


def read_hierarchy(path: Path, text: str, warnings: list[str]) -> tuple[list[Joint], int]:
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

    def error(self, problem: str) -> FileError:
        where = "HIERARCHY" if self.crowded else f"line {self.n}"
        return FileError(self.path, problem, where=where, remedy="check the BVH file's hierarchy")

    def parse(self) -> tuple[list[Joint], int]:
        """Return the joints of the first root, parents first, and the number of channels."""
        joints: list[Joint] = []
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
                    raise self.error("'{' does not follow a joint")
                stack.append(pending)
                expect_brace = False
            elif expect_brace:
                raise self.error(f"'{{' is missing before {words[0]!r}")
            elif key == "}":
                if not stack:
                    raise self.error("'}' without '{'")
                stack.pop()
            elif key in ("ROOT", "JOINT"):
                if key == "JOINT" and (not stack or stack[-1] is None):
                    raise self.error("JOINT is outside a ROOT")
                if key == "ROOT" and stack:
                    raise self.error("ROOT is inside another joint")
                n_roots += key == "ROOT"
                if len(joints) >= MAX_JOINTS:
                    raise self.error(f"has more than {MAX_JOINTS} joints: not a human skeleton")
                name = " ".join(words[1:]) or f"joint{len(joints)}"
                parent = stack[-1] if stack else -1
                joints.append(Joint(name, -1 if parent is None else parent, np.zeros(3)))
                pending, expect_brace = len(joints) - 1, True
            elif key == "END":
                if not stack or stack[-1] is None:
                    raise self.error("End Site is outside a joint")
                pending, expect_brace = None, True
                ended = stack[-1]
            elif key == "OFFSET":
                offset = self.numbers(words[1:], 3)
                if not stack:
                    raise self.error("OFFSET is outside a joint")
                if stack[-1] is None:
                    joints[ended].end = offset
                else:
                    joints[stack[-1]].offset = offset
            elif key == "CHANNELS":
                if not stack or stack[-1] is None:
                    raise self.error("CHANNELS is outside a joint")
                joint = joints[stack[-1]]
                if joint.channels:
                    raise self.error(f"joint {joint.name!r} has CHANNELS twice")
                joint.channels = self.channels(words[1:])
                joint.first_channel = n_channels
                n_channels += len(joint.channels)
            else:
                raise self.error(f"{words[0]!r} is not a keyword of a hierarchy")
        if not joints:
            raise self.error("has no ROOT")
        if stack or expect_brace:
            raise self.error("a '}' is missing: the hierarchy is truncated")
        if not n_channels:
            raise self.error("no joint has CHANNELS")
        if n_roots > 1:
            second = next(i for i, j in enumerate(joints) if i and j.parent == -1)
            self.warnings.append(
                f"the file holds {n_roots} skeletons; only the first, {joints[0].name!r}, was read"
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

    def unique_names(self, joints: list[Joint]) -> None:
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
