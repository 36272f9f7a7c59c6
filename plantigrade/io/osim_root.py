"""The joint of a person's root to the ground: pose by coordinates, and back."""

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.io.osim import OsimJoint
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD as W
from plantigrade.spatial.conventions import about_axis, rotation_matrix, rotation_quaternion


def check_root(root: OsimJoint) -> None:
    """Refuse a root whose pose does not tell its coordinates."""
    moving = [a for a in root.axes if a.function.constant is None]
    turns = [a for a in moving if not a.slides]
    for axis in moving:
        if axis.function.line not in ((1.0, 0.0), (-1.0, 0.0)) or np.abs(axis.direction).max() < 1:
            raise ParameterError(f"axis {axis.name} of the root is not along x, y or z")
    if len({int(np.abs(a.direction).argmax()) for a in turns}) < len(turns):
        raise ParameterError(f"the root {root.name} turns twice about one axis")
    if any(a.function.constant for a in root.axes if not a.slides):
        raise ParameterError(f"the root {root.name} has a fixed rotation in its axes")


def root_pose(root: OsimJoint, column: Mapping[str, np.ndarray], n: int) -> Float[Array, "n 7"]:
    """Return position and quaternion ``wxyz`` of the root's body, our axes."""
    moved, turn = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
    for axis in root.axes:
        if axis.function.constant is not None:
            value = np.full((n, 1), axis.function.constant)
        else:
            value = axis.function.value(column[str(axis.coordinate)])[:, None]
        if axis.slides:
            moved = moved + value * axis.direction
        else:
            turn = turn @ about_axis(axis.direction, value[:, 0])
    P, C = root.parent.rotation, root.child.rotation
    R = P @ turn @ C.T
    origin = root.parent.position + moved @ P.T - R @ root.child.position
    return np.hstack([origin @ W.T, rotation_quaternion(W @ R @ W.T)])


def root_coordinates(root: OsimJoint, qpos: Float[Array, "n nq"]) -> dict[str, Float[Array, " n"]]:
    """Return the coordinates of the root from its pose, angles unwrapped over time."""
    P, C = root.parent.rotation, root.child.rotation
    R = W.T @ rotation_matrix(qpos[:, 3:7]) @ W
    place = qpos[:, :3] @ W + R @ root.child.position - root.parent.position
    moved, turn = place @ P, P.T @ R @ C
    moving = [a for a in root.axes if a.function.constant is None]
    turns = [a for a in moving if not a.slides]
    letters = [int(np.abs(a.direction).argmax()) for a in turns]
    letters += [k for k in (2, 0, 1) if k not in letters]
    found = {c.name: np.full(len(qpos), c.default) for c in root.coordinates}
    angles = Rotation.from_matrix(turn).as_euler("".join("XYZ"[k] for k in letters))
    for k, axis in enumerate(turns):
        slope = axis.function.line[0] if axis.function.line else 1.0
        found[str(axis.coordinate)] = np.unwrap(angles[:, k]) * axis.direction[letters[k]] * slope
    for axis in moving:
        if axis.slides and axis.function.line is not None:
            found[str(axis.coordinate)] = moved @ axis.direction * axis.function.line[0]
    return found
