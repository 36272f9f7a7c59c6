"""Common parts of the skeleton formats (ASF/AMC, BVH, DeepMimic, SMPL): rotations, axes, sides.

Every skeleton file has its own axes up, forward and left. Two rotations map them to ours: one for
the world (the vertical of the motion) and one for the body (the direction the person faces in the
rest pose). Both are found from the names and positions of the joints.
"""

import re
from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float

FORWARD_LEFT_UP_OF_Y_UP = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
"""Maps y-up file axes (x left, y up, z forward: CMU and most BVH) to ours (x, y left, z up)."""
MIN_UPRIGHTNESS = 0.6  # Minimum ratio of height to bone path from foot to head of a standing person
_HEAD = re.compile(r"head|neck|skull|thorax|chest|spine", re.IGNORECASE)
_FEET = re.compile(r"foot|feet|ankle|toe|heel|ball|tibia|shin|calf", re.IGNORECASE)


def axis_rotation(axis: str, angle: Float[Array, " n"]) -> Float[Array, "n 3 3"]:
    """Return rotations by ``angle`` [rad] about ``axis`` (``"x"``, ``"y"`` or ``"z"``)."""
    i = "xyz".index(axis.lower())
    j, k = (i + 1) % 3, (i + 2) % 3
    rotation = np.zeros((len(angle), 3, 3))
    rotation[:, i, i] = 1.0
    rotation[:, j, j] = rotation[:, k, k] = np.cos(angle)
    rotation[:, k, j] = np.sin(angle)
    rotation[:, j, k] = -rotation[:, k, j]
    return rotation


def euler_rotation(axes: str, angles: Float[Array, "n k"]) -> Float[Array, "n 3 3"]:
    """Return :math:`R = R_{a_1} R_{a_2} …` for the letters of ``axes``, angles in [rad]."""
    rotation = np.broadcast_to(np.eye(3), (len(angles), 3, 3))
    for column, axis in enumerate(axes):
        rotation = rotation @ axis_rotation(axis, angles[:, column])
    return rotation


def tree_kinematics(
    parents: Sequence[int],
    local: Float[Array, "n k 3 3"],
    root: Float[Array, "n 3"],
    offsets: Float[Array, "k 3"],
) -> tuple[Float[Array, "n k 3 3"], Float[Array, "n k 3"]]:
    """Return the world rotations and positions of the joints of a tree.

    Args:
        parents: Parent of each joint, before it in the order; the first joint is the root.
        local: Rotation of each joint relative to its parent; that of the root in the world.
        offsets: Offset of each joint from its parent where nothing is rotated.
    """
    R, p = np.empty_like(local), np.empty(local.shape[:3])
    R[:, 0], p[:, 0] = local[:, 0], root
    for j, parent in enumerate(parents[1:], start=1):
        R[:, j] = R[:, parent] @ local[:, j]
        p[:, j] = p[:, parent] + R[:, parent] @ offsets[j]
    return R, p


def rest_pose(parents: Sequence[int], offsets: Float[Array, "k 3"]) -> Float[Array, "k 3"]:
    """Return the joints of a tree where nothing is rotated, the root at the origin."""
    rest = np.zeros(offsets.shape)
    for j, parent in enumerate(parents[1:], start=1):
        rest[j] = rest[parent] + offsets[j]
    return rest


def mirrored_name(name: str) -> str | None:
    """Return the name of the right counterpart of a left joint, None for other joints.

    Example:
        >>> [mirrored_name(n) for n in ("lfemur", "LeftUpLeg", "hip_l", "hip.L", "b_l_knee")]
        ['rfemur', 'RightUpLeg', 'hip_r', 'hip.R', 'b_r_knee']
    """
    for left, right in (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT")):
        if left in name:
            return name.replace(left, right, 1)
    found = re.search(r"(?<=[ _.:-])([lL])(?=$|[ _.:-])", name) or re.search(
        r"(?:^|(?<=:))([lL])(?=.)", name
    )
    if found:
        return name[: found.start()] + ("r" if found[1] == "l" else "R") + name[found.end() :]
    return None


def side_pairs(names: Sequence[str]) -> list[tuple[int, int]]:
    """Return the (left, right) indices of joints with a counterpart on the other side."""
    index = {name: i for i, name in enumerate(names)}
    pairs = []
    for i, name in enumerate(names):
        twin = mirrored_name(name)
        if twin is not None and twin in index and index[twin] != i:
            pairs.append((i, index[twin]))
    return pairs


def head_and_feet(names: Sequence[str]) -> tuple[list[int], list[int]]:
    """Return the indices of joints above and far below the pelvis, by their names."""
    above = [i for i, name in enumerate(names) if _HEAD.search(name)]
    below = [i for i, name in enumerate(names) if _FEET.search(name) and not _HEAD.search(name)]
    return above, below


def nearest_axis(vector: Float[Array, "3"]) -> Float[Array, "3"] | None:
    """Return the signed coordinate axis nearest to ``vector``; None if ambiguous."""
    size = np.abs(vector)
    best = int(np.argmax(size))
    aside = np.hypot(*np.delete(size, best))
    if not np.isfinite(vector).all() or size[best] <= 1e-9 or size[best] < 0.7 * aside:
        return None
    axis = np.zeros(3)
    axis[best] = np.sign(vector[best])
    return axis


def up_axis(
    names: Sequence[str], positions: Float[Array, "n_frames n_joints 3"]
) -> Float[Array, "3"] | None:
    """Return the file axis along which the head lies above the feet, None where unclear."""
    above, below = head_and_feet(names)
    if not above or not below:
        return None
    rise = positions[:, above].mean(axis=1) - positions[:, below].mean(axis=1)
    return nearest_axis(np.median(rise, axis=0))


def turn_to_ours(
    up: Float[Array, "3"] | None, left: Float[Array, "3"] | None
) -> Float[Array, "3 3"]:
    """Return the rotation from file axes to ours (x forward, y left, z up).

    If ``left`` is unknown, the usual one is used: x, the person facing z in files with y up
    and facing -y in files with z up.
    """
    z = np.array([0.0, 1, 0]) if up is None else up
    y = left
    if y is None or abs(y @ z) > 0.5:
        y = np.array([0.0, 0, 1]) if abs(z[0]) > 0.5 else np.array([1.0, 0, 0])
    return np.stack([np.cross(y, z), y, z])


def left_axis(
    names: Sequence[str], rest: Float[Array, "n_joints 3"], up: Float[Array, "3"] | None
) -> Float[Array, "3"] | None:
    """Return the file axis that points to the person's left in the rest pose, None if unclear."""
    pairs = side_pairs(names)
    if not pairs:
        return None
    across = sum(rest[i] - rest[j] for i, j in pairs)
    if up is not None:
        across = across - (across @ up) * up
    return nearest_axis(np.asarray(across))


def bone_height(
    names: Sequence[str], parents: Sequence[int], rest: Float[Array, "n_joints 3"]
) -> float:
    """Return the person's height in file units, measured along the bones.

    It is the longest path from an ankle or foot to head, neck or chest, by joint names. Foot and
    top of the head are missing, so it identifies the unit but does not measure the person. NaN if
    the names are unknown.
    """
    above, below = head_and_feet(names)
    ankles = [i for i in below if not re.search(r"toe|ball", names[i], re.IGNORECASE)] or below
    if not above or not ankles:
        return float("nan")
    return max(_path(parents, rest, i, k) for i in above for k in ankles)


def _path(parents: Sequence[int], rest: Float[Array, "n_joints 3"], one: int, other: int) -> float:
    """Return the bone path from one joint to another."""
    chains: list[list[int]] = []
    for i in (one, other):
        chains.append([])
        while i >= 0:
            chains[-1].append(i)
            i = parents[i]
    own = [i for i in (*chains[0], *chains[1]) if not (i in chains[0] and i in chains[1])]
    return float(sum(np.linalg.norm(rest[i] - rest[parents[i]]) for i in own))


def stands(
    names: Sequence[str],
    parents: Sequence[int],
    rest: Float[Array, "n_joints 3"],
    up: Float[Array, "3"],
) -> bool:
    """Return whether a pose is standing, with legs and trunk nearly straight.

    The result is True if head and feet are not known by name.
    """
    above, below = head_and_feet(names)
    if not above or not below:
        return True
    head = above[int(np.argmax(rest[above] @ up))]
    rises = [float((rest[head] - rest[k]) @ up) for k in below]
    ways = [_path(parents, rest, head, k) for k in below]
    return all(rise > MIN_UPRIGHTNESS * way for rise, way in zip(rises, ways, strict=True))
