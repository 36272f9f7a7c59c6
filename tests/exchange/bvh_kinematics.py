"""A reader of BVH that shares nothing with the package's own: forward kinematics in file axes."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Node:
    """A joint, or the site where one ends."""

    name: str
    parent: int
    offset: np.ndarray = field(default_factory=lambda: np.zeros(3))
    channels: list[str] = field(default_factory=list)


def turn(axis: str, degrees: float) -> np.ndarray:
    """Return the rotation about an axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return {
        "X": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "Y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "Z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def read(path: Path) -> tuple[list[Node], float, np.ndarray]:
    """Return the nodes of a file, parents first, the frame time [s], and the rows of numbers."""
    words = iter(path.read_text().split())
    nodes: list[Node] = []
    stack = [-1]
    assert next(words) == "HIERARCHY"
    for word in words:
        if word in ("ROOT", "JOINT", "End"):
            nodes.append(Node(next(words), stack[-1]))
        elif word == "{":
            stack.append(len(nodes) - 1)
        elif word == "}":
            stack.pop()
        elif word == "OFFSET":
            nodes[-1].offset = np.array([float(next(words)) for _ in range(3)])
        elif word == "CHANNELS":
            nodes[-1].channels = [next(words) for _ in range(int(next(words)))]
        elif word == "MOTION":
            break
    assert next(words) == "Frames:"
    count = int(next(words))
    assert (next(words), next(words)) == ("Frame", "Time:")
    frame_time = float(next(words))
    return nodes, frame_time, np.array([float(w) for w in words]).reshape(count, -1)


def poses(nodes: list[Node], row: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return position and rotation of every node in one frame, in file axes and unit."""
    numbers = iter(row)
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for node in nodes:
        place, rotation = node.offset.copy(), np.eye(3)
        for channel in node.channels:
            value = next(numbers)
            if channel.endswith("position"):
                place["XYZ".index(channel[0])] = value
            else:
                rotation = rotation @ turn(channel[0], value)
        if node.parent >= 0:
            at, turned = found[node.parent]
            place, rotation = at + turned @ place, turned @ rotation
        found.append((place, rotation))
    return {
        node.name if node.name != "Site" else f"{nodes[node.parent].name} end": pose
        for node, pose in zip(nodes, found, strict=True)
    }
