"""BVH motions: a hierarchy of offsets with channels per joint, then one row of numbers per frame.

A joint's rotation is the product of its rotation channels in the order they are listed, :math:`R
= R_{parent} R_{c_1} R_{c_2} R_{c_3}`, angles in degrees; its position is that of its parent plus
:math:`R_{parent}` times its offset. Position channels replace the offset or add to it: writers
disagree. On a joint below the root they replace it where their median lies nearer to the offset
than to zero; on the root, where an offset is given, the reading that brings the lowest point of the
body closer to height 0 is used.

A skeleton with joint axes along its bones does not stand upright without rotations; then an upright
frame with the feet together is taken as the rest pose.

**Unit.** BVH files do not store one. The person's height is summed along the bones from ankle to
head; of metre, centimetre, millimetre, inch and CMU's unit (0.0254 / 0.45 m), in this order, the
first is taken that makes the height lie between 1.0 and 2.2 m. The option ``unit`` overrides it.
If none fits, the skeleton is scaled to a height of 1.60 m, with a warning.

**Axes.** Up is the file axis along which the head is above the feet throughout the motion (y if the
joint names do not show it); the person's left and forward are found from the twins
``left…``/``right…`` in the rest pose (x and z by default). They are rotated to x forward, y left, z
up; the direction of walking is kept.
"""

import re
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.bvh_hierarchy import BvhJoint, read_hierarchy
from plantigrade.io.bvh_motion import read_motion
from plantigrade.io.skeletons import (
    bone_height,
    euler_rotation,
    head_and_feet,
    left_axis,
    side_pairs,
    stands,
    turn_to_ours,
    up_axis,
)
from plantigrade.io.text import read_text
from plantigrade.motion.recording import Recording, SkeletonMotion

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "cmu": 0.0254 / 0.45}  # [m]
PLAUSIBLE_HEIGHT = (1.0, 2.2)  # [m], along the bones from ankle to head
ASSUMED_HEIGHT = 1.60  # [m], ankle to head, where no unit fits
MAX_BYTES = 100e6  # of a file [bytes]: about 13 minutes of 43 joints at 120 Hz

_AT_REST = 2.0  # [deg]
_RESTING_SHARE = 0.75  # [1] of the rotations in a rest pose; a suit of sensors bends the spine
_JUMP_FACTOR = 2.0  # times the usual change between frames
MAX_PELVIS_TILT = np.deg2rad(25)  # [rad] of an upright pelvis from the axes it was made along


def read_bvh(path: str | Path, *, unit: str | None = None) -> Recording:
    """Read a BVH motion.

    Args:
        path: The ``.bvh`` file.
        unit: ``m``, ``cm``, ``mm``, ``in`` or ``cmu``; by default found from the person's height.

    Returns:
        A recording with a ``skeleton``. A rest pose in the first frame, and frames that only lead
        out of it, are removed with a warning (time is 0 in the frame after the rest pose).
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
            "has no MOTION section",
            where=f"line {text.count(chr(10)) + 1}",
            remedy="check that this is a complete BVH file",
        )
    joints, n_channels = read_hierarchy(path, text[: found.start()], warnings)
    values, frame_time = read_motion(path, text, found.end(), n_channels, warnings)
    del text  # a long motion needs the memory
    n_skipped, values = _without_rest_pose(joints, values, warnings)
    time = (np.arange(len(values)) + max(n_skipped - 1, 0)) * frame_time
    return Recording(
        source=path,
        skeleton=_kinematics(joints, values, time, unit, warnings),
        warnings=tuple(warnings),
    )


def _without_rest_pose(
    joints: list[BvhJoint], values: np.ndarray, warnings: list[str]
) -> tuple[int, np.ndarray]:
    """Return the number of initial frames that are a rest pose or lead out of it, and the others.

    The first frame is a rest pose where three in four of the rotations that change later are below
    2 degrees (conversions keep spine, thumbs and feet bent). It is left out where the motion does
    not start from it: where the mean change of the rotations to the second frame exceeds twice the
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
    if not moving.any() or np.quantile(np.abs(rotations[0, moving]), _RESTING_SHARE) > _AT_REST:
        return 0, values
    change = np.diff(rotations[:, moving], axis=0)
    change = np.abs((change + 180) % 360 - 180).mean(axis=1)
    first = 8 if len(change) > 16 else 1
    jump = _JUMP_FACTOR * max(float(change[first : first + 32].max()), 0.05)
    if change[0] <= jump:
        warnings.append("the first frame is the rest pose; it was kept: the motion starts from it")
        return 0, values
    skip = int(np.argmax(change[:8] <= jump)) or 1
    more = f", and the following {skip - 1} that lead out of it" if skip > 1 else ""
    warnings.append(f"the first frame is a rest pose; it was left out{more}")
    return skip, values[skip:]


def _forward(
    joints: list[BvhJoint], values: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return rotations, positions and ends of joints in file axes, and the rest positions."""
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
    return R, p, ends, rest


def _kinematics(
    joints: list[BvhJoint],
    values: np.ndarray,
    time: np.ndarray,
    unit: str | None,
    warnings: list[str],
) -> SkeletonMotion:
    """Return the forward kinematics in our axes, computed for all frames of a joint at once."""
    R, p, ends, rest = _forward(joints, values)
    names, parents = tuple(j.name for j in joints), tuple(j.parent for j in joints)
    up = up_axis(names, p)
    if up is not None and not stands(names, parents, rest, up):
        warnings.append(
            "without rotations the skeleton does not stand upright: an upright frame of the motion "
            "was taken as rest pose"
        )
        rest = _upright(names, parents, R, p, up)
    up_rest = up_axis(names, rest[None])
    left = left_axis(names, rest, up_rest if up_rest is not None else up)
    if up is None:
        warnings.append("head and feet could not be identified by name: y was taken as up")
        up = np.array([0.0, 1, 0])
    body = turn_to_ours(up_rest if up_rest is not None else up, left)
    world = body if np.array_equal(body[2], up) else turn_to_ours(up, None)
    if joints[0].offset.any() and any(kind == "position" for kind, _ in joints[0].channels):
        low = np.percentile(np.nanmin(p @ up, axis=1), 2)
        if abs(low + joints[0].offset @ up) < abs(low):
            p += joints[0].offset
            ends += joints[0].offset
    scale = _scale(bone_height(names, parents, rest), unit, warnings)
    for i in range(len(joints)):  # joint by joint: the arrays may be large
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


def _upright(
    names: tuple[str, ...],
    parents: tuple[int, ...],
    R: Float[Array, "n k 3 3"],
    p: Float[Array, "n k 3"],
    up: Float[Array, "3"],
) -> Float[Array, "k 3"]:
    """Make a frame the rest pose, with the pelvis along an axis, and return it.

    It is the frame of the upright half with the smallest distance between the feet, in walking at
    midstance. A pelvis is tilted in it; that of most rigs has axes along those of the world in the
    pose it was made in, whatever they are called, and these are then its zero.

    Args:
        parents: Parent of each joint; -1 for the root.
        R: Rotations of the joints, changed to rotations from the rest pose.
        p: Positions of the joints.
    """
    above, below = head_and_feet(names)
    rise = (p[:, above].mean(axis=1) - p[:, below].mean(axis=1)) @ up
    pairs = side_pairs(names)
    feet = [pair for pair in pairs if pair[0] in below]
    apart = sum((p[:, i] - p[:, k] for i, k in feet), np.zeros((len(p), 3)))
    apart -= (apart @ up)[:, None] * up
    wide = np.where(rise >= np.median(rise), np.linalg.norm(apart, axis=1), np.inf)
    best = int(np.argmin(wide))
    rest = p[best] - p[best, 0]
    deep, leads = np.zeros(len(names), dtype=int), set()  # depth, and what feet hang from
    for i, parent in enumerate(parents):
        deep[i] = 0 if parent < 0 else deep[parent] + 1
    for i in below:
        while (i := parents[i]) >= 0:
            leads.add(i)
    legs = [pair for pair in pairs if pair[0] in leads] or pairs
    hips = min(legs, key=lambda pair: deep[pair[0]], default=(0, 0))
    across = rest[hips[0]] - rest[hips[1]]
    left = across - (across @ up) * up
    turn = np.eye(3)
    if np.linalg.norm(left) > 0.0:
        left /= np.linalg.norm(left)
        goal = np.roll(np.abs(up), -1)
        turn = np.stack([goal, up, np.cross(goal, up)]).T @ np.stack([left, up, np.cross(left, up)])
    zero, i = turn @ R[best], parents[hips[0]]
    while i >= 0:  # pelvis and root
        zero[i] = _aligned(zero[i])
        i = parents[i]
    R[:] = R @ zero.transpose(0, 2, 1)
    return rest @ turn.T


def _aligned(R: Float[Array, "3 3"]) -> Float[Array, "3 3"]:
    """Return the rotation of axes onto axes nearest to ``R``, or ``R`` if none is near."""
    near = np.round(R)
    if not np.allclose(near @ near.T, np.eye(3)) or np.linalg.det(near) < 0:
        return R
    cosine = 0.5 * (np.trace(near.T @ R) - 1)
    return near if cosine > np.cos(MAX_PELVIS_TILT) else R


def _scale(height: float, unit: str | None, warnings: list[str]) -> float:
    """Return metres per file unit, from the person's height in file units."""
    if unit is not None:
        return UNITS[unit]
    if not (np.isfinite(height) and height > 0):
        warnings.append(
            "the person's height could not be identified: lengths were taken as cm (option unit)"
        )
        return UNITS["cm"]
    for name, metres in UNITS.items():
        if PLAUSIBLE_HEIGHT[0] <= height * metres <= PLAUSIBLE_HEIGHT[1]:
            if name != "m":
                warnings.append(
                    f"lengths were taken as {name}, so the skeleton is {height * metres:.2f} m "
                    "from ankle to head (option unit)"
                )
            return metres
    warnings.append(
        f"no unit makes the skeleton human-sized ({height:g} from ankle to head in file units): "
        f"it was scaled to {ASSUMED_HEIGHT:.2f} m (option unit)"
    )
    return ASSUMED_HEIGHT / height
