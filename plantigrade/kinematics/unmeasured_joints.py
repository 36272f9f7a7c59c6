r"""Joints that a recording does not show: trunk, head and arms follow the legs.

Joints that no marker moves cannot be fitted. Instead of being welded at zero, those of trunk, head
and arms follow a published posture and motion of walking (:mod:`plantigrade.models.upper_body`), in
step with the legs and as far as the legs swing.

The phase of the legs comes from how far the right ankle is before the left one, :math:`d`, and its
rate: :math:`z = d - i\,\dot d/\omega` turns once in a stride, and is real and largest when the
right foot has just landed. Turned back by :math:`e^{-i\omega t}` and smoothed, its angle is the
phase and its size the length of a step; both are known in every frame, also in those before the
first and after the last heel strike. Where the legs do not swing the size vanishes, and with it all
motion: the trunk stays upright above the pelvis and the arms hang.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Bool, Float, root_mean_square
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human
from plantigrade.models.upper_body import TRUNK_TILT, swing_scale, upper_body
from plantigrade.motion.recording import rate_of
from plantigrade.printable import joined
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import (
    pelvis_angles_to_quaternion,
    quaternion_to_pelvis_angles,
    rotation_quaternion,
    wxyz_to_xyzw,
    xyzw_to_wxyz,
)

SPINE, NECK = ("lumbar", "lower_thorax", "thorax"), ("lower_neck", "upper_neck", "neck")
_TURNS = ("extension", "bending", "rotation")
PARTS = {
    "trunk": tuple(f"{joint}_{turn}" for joint in SPINE for turn in _TURNS),
    "head": tuple(f"{joint}_{turn}" for joint in NECK for turn in _TURNS),
    "arms": ("arm_flex", "arm_add", "arm_rot", "elbow_flex"),
}
"""Parts that follow the legs if they were not measured, and their coordinates without side."""
SIGNAL = "assumed.joints"
"""Signal of a Record that names the coordinates that nothing in the recording shows."""

RATE_SMOOTHING = 0.02  # [s] width of the Gaussian filter of the legs' rate, half gain at 9 Hz
# [rad] delay of the maximum of the first harmonic of the foot distance after heel strike, from mean
# curves at free speed [Schwartz2008]_; 19 degrees for an adult [Falisse2019]_
PHASE_OFFSET = np.deg2rad(15.0)
STRIDE_FREQUENCIES = 0.4, 2.0  # [Hz] range of human stride frequencies
MIN_FRAMES = 12  # [1] minimum number of frames for a phase
MAX_UPRIGHT_TILT = np.deg2rad(25.0)  # [rad] maximum pelvis tilt and list with an upright trunk
# [rad] maximum posterior pelvis tilt in sitting with an upright trunk
MAX_SITTING_TILT = np.deg2rad(40.0)
MIN_HANGING_LEAN = np.deg2rad(60.0)  # [rad] trunk lean from which an arm hangs vertically
# [1] share of the frames, with the straightest knees, used for the pelvis tilt
STRAIGHT_SHARE = 0.3
MIN_RUNNING_RISE = 0.01  # [m] amplitude of the pelvis height that separates running from walking


@dataclass(frozen=True)
class LegSwing:
    """How the legs swing."""

    #: Phase of the right foot's cycle [rad]; zero at its heel strike
    phase: Float[Array, " n_frames"]
    speed: Float[Array, " n_frames"]  #: Dimensionless speed of walking that belongs to it
    strides: float  #: Strides per second [Hz]
    runs: bool  #: Whether the pelvis is highest when the feet are furthest apart


def ankle_paths(human: Human, qpos: Float[Array, "n nq"]) -> Float[Array, "n 2 3"]:
    """Return where the joint centres of both ankles are, world [m]."""
    ankles = [human.skeleton.parts[f"foot_{side}"] for side in SIDES]
    return PointSet(human, [b for b, _ in ankles], np.array([at for _, at in ankles])).path(qpos)


def measured_hinges(points: PointSet) -> Bool[Array, " n_hinges"]:
    """Return which hinges move any of the points that are measured."""
    return np.asarray(points.moved[:, 0, 6:].any(axis=0))


def unmeasured(human: Human, seen: Bool[Array, " n_hinges"]) -> tuple[str, ...]:
    """Return the coordinates that were not seen."""
    return tuple(n for n, there in zip(human.coordinates, seen, strict=True) if not there)


def follow_the_legs(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    seen: Bool[Array, " n_hinges"],
) -> Float[Array, "n_frames nq"]:
    """Return the poses with trunk, head and arms, as far as they were not seen, as people walk.

    Args:
        time: Time of each frame [s].
        qpos: Poses; what was not seen of trunk, head and arms is replaced.
        seen: Which hinges were measured.
    """
    qpos, hidden = np.array(qpos), set(unmeasured(human, seen))
    if not any(split_side(name)[0] in every for name in hidden for every in PARTS.values()):
        return qpos
    legs = leg_swing(human, time, qpos, seen)
    usual, share = upper_body(legs.phase, legs.speed, runs=legs.runs), swing_scale(legs.speed)
    share = np.minimum(share, 1.0)
    tilt, side_lean, turned = quaternion_to_pelvis_angles(qpos[:, 3:7]).T
    ahead = _smooth(time, turned, 0.5 / legs.strides)
    # Walking people hold the trunk still above the pelvis. Others bend forward with it, and sit
    # upright on a pelvis that is turned back.
    trunk = usual.trunk.copy()
    leans = tilt - _upright_tilt(human, qpos, tilt)
    trunk[:, 0] += (1 - share) * (
        np.minimum(leans, 0.0) + np.maximum(leans - MAX_SITTING_TILT, 0.0)
    )
    trunk[:, 1] += side_lean - np.clip(side_lean, -MAX_UPRIGHT_TILT, MAX_UPRIGHT_TILT)
    trunk[:, 2] = share * (ahead + trunk[:, 2]) + (1 - share) * turned
    _turn_to(human, qpos, SPINE, hidden, trunk)
    thorax = human.body(human.skeleton.parts["thorax"][0])  # which carries the arms
    above = quaternion_to_pelvis_angles(_rotation(human, qpos, thorax))
    head = np.zeros_like(trunk)
    head[:, 2] = share * ahead + (1 - share) * above[:, 2]
    _turn_to(human, qpos, NECK, hidden, head)
    low, high = human.limits
    for name, angle in usual.arms.items():
        if name not in hidden:
            continue
        if name.startswith("arm_flex"):
            angle = angle - np.clip(above[:, 0] - TRUNK_TILT, -MIN_HANGING_LEAN, MIN_HANGING_LEAN)
        k = human.hinge(name)
        qpos[:, 7 + k] = np.clip(angle, low[k], high[k])
    return qpos


def leg_swing(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    seen: Bool[Array, " n_hinges"],
) -> LegSwing:
    """Return phase and speed of the legs' swing; still legs where there are too few frames.

    The swing of a leg that was not seen is assumed opposite to the other's.
    """
    n = len(time)
    still = LegSwing(np.zeros(n), np.zeros(n), STRIDE_FREQUENCIES[0], False)
    if n < MIN_FRAMES:
        return still
    feet = ankle_paths(human, qpos)
    turned = quaternion_to_pelvis_angles(qpos[:, 3:7])[:, 2, None]
    before = feet - qpos[:, None, :3]
    before = np.cos(turned) * before[..., 0] + np.sin(turned) * before[..., 1]
    shown = [bool(seen[human.hinge(f"hip_flexion_{side}")]) for side in SIDES]
    if sum(shown) == 1:
        one = before[:, shown.index(True)]
        before[:, shown.index(False)] = 2 * one.mean() - one
    ahead = _smooth(time, before[:, 0] - before[:, 1], RATE_SMOOTHING)
    rate = np.gradient(ahead, time)
    size = root_mean_square(ahead)
    if size < 1e-6:
        return still
    strides = float(np.clip(root_mean_square(rate) / size / (2 * np.pi), *STRIDE_FREQUENCIES))
    for _ in range(3):  # the rhythm, ever better
        omega = 2 * np.pi * strides
        turning = (ahead - 1j * rate / omega) * np.exp(-1j * omega * time)
        real, imaginary = (_smooth(time, x, 0.25 / strides) for x in (turning.real, turning.imag))
        steady = real + 1j * imaginary
        phase = omega * time + np.unwrap(np.angle(steady)) + PHASE_OFFSET
        step = np.abs(steady)
        weight = step / step.sum()
        strides = float(
            np.clip(weight @ np.gradient(phase, time) / (2 * np.pi), *STRIDE_FREQUENCIES)
        )
    d = human.dimensions
    leg = d.leg_length
    speed = 2 * step * strides / np.sqrt(GRAVITY * leg)
    height = qpos[:, 2] - weight @ qpos[:, 2]
    rise = 2 * float(weight @ (height * np.cos(2 * phase)))
    return LegSwing(phase, speed, strides, rise > MIN_RUNNING_RISE)


def bodies_of(human: Human, names: Sequence[str]) -> set[str]:
    """Return the bodies of trunk, head and arms that some of these coordinates move."""
    model, found = human.model, set()
    joints = [
        n for n in names if split_side(n)[0] in sum(PARTS.values(), ()) and n in human.coordinates
    ]
    moved = {int(model.joint(name).bodyid[0]) for name in joints}
    for body, name in enumerate(human.body_names, start=1):
        if body in moved or int(model.body_parentid[body]) in moved:
            moved.add(body)
            found.add(name)
    return found


def body_part_names(names: Sequence[str]) -> str:
    """Return the parts of the body to which coordinates belong: ``"the trunk and the arms"``."""
    there = {split_side(name)[0] for name in names}
    return joined([f"the {part}" for part, every in PARTS.items() if there & set(every)])


def note(names: Sequence[str], what: str) -> list[str]:
    """Return what the user should know where trunk, head or arms are not seen.

    ``what`` does not show them: ``"no marker"``.
    """
    parts = body_part_names(names)
    if not parts:
        return []
    return [
        f"{what} shows {parts}: assumed, not measured, from a published posture and motion of "
        "walking in step with the legs."
    ]


def _turn_to(human: Human, qpos, joints, hidden: set[str], target) -> None:
    """Turn the outermost of a chain of joints so that its last body has a target's angles.

    The joints that were not seen share the turn; those nearer to the pelvis that were seen stay.
    """
    here = [j for j in joints if f"{j}_extension" in hidden]
    if not here:
        return
    model = human.model
    first = int(model.joint(f"{here[0]}_extension").bodyid[0])
    base = Rotation.from_quat(wxyz_to_xyzw(_rotation(human, qpos, int(model.body_parentid[first]))))
    desired = Rotation.from_quat(wxyz_to_xyzw(pelvis_angles_to_quaternion(target)))
    share = Rotation.from_rotvec((base.inv() * desired).as_rotvec() / len(here))
    angles = quaternion_to_pelvis_angles(xyzw_to_wxyz(share.as_quat()))
    low, high = human.limits
    for joint in here:
        for turn, values in zip(_TURNS, angles.T, strict=True):
            k = human.hinge(f"{joint}_{turn}")
            qpos[:, 7 + k] = np.clip(values, low[k], high[k])


def _rotation(human: Human, qpos, body: int) -> Float[Array, "n_frames 4"]:
    """Return the orientation of a body in every frame, ``wxyz``."""
    turned = np.array([state.rotation(body) for state in sweep(human, qpos)])
    return rotation_quaternion(turned)


def _upright_tilt(human: Human, qpos, tilt) -> float:
    """Return the pelvis's tilt in upright standing: its median while the knees are straightest."""
    bend = sum(qpos[:, 7 + human.hinge(f"knee_angle_{side}")] for side in SIDES)
    straight = bend <= np.quantile(bend, STRAIGHT_SHARE)
    return float(np.clip(np.median(tilt[straight]), -MAX_UPRIGHT_TILT, MAX_UPRIGHT_TILT))


def _smooth(time, values, width: float) -> np.ndarray:
    """Return a signal's mean about each frame, weighted by a bell of standard deviation [s]."""
    from scipy.ndimage import gaussian_filter1d

    frames = width * rate_of(time)
    bell = partial(gaussian_filter1d, sigma=frames, mode="constant")
    return bell(np.asarray(values, float)) / bell(np.ones(len(time)))
