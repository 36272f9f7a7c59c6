r"""Motions of the SMPL family: AMASS, and the results of video tools in the same pose parameters.

A frame is a rotation vector (axis times angle [rad]) for each joint, relative to its parent, and a
translation of the pelvis [m]; all rotations zero are a T-pose that faces z with y up. Layouts that
are recognised by their keys:

======================  ==========================================  =======  ==================
layout                  keys                                        up       source
======================  ==========================================  =======  ==================
AMASS (SMPL, -H, -X)    poses (n, 66, 72, 156 or 165), trans        z        [AMASS]_
parts of SMPL-X         root_orient, pose_body, trans               z        AMASS, 2021 files
SMPL parts              global_orient, body_pose, transl            y        smplx library
GVHMR                   smpl_params_global: the three above         y        its demo
WHAM                    {person: pose_world, trans_world (hips)}    y        its demo
AIST++                  smpl_poses, smpl_trans, smpl_scaling        y        its loader
======================  ==========================================  =======  ==================

The vertical is the axis (of y and z) along which the head is above the feet; where the motion does
not say, that of the table. Frames per second come from ``mocap_framerate``, ``mocap_frame_rate`` or
``fps``; video results have none and are taken as 30 per second.

**Lengths.** The body model turns the shape numbers ``betas`` into lengths, and its licence does not
let us ship it. Without it, lengths are those of a mean adult of the file's ``gender``, with legs
such that the feet stand. A model file that is named as ``skeleton`` gives the lengths for the
file's ``betas``.

**Pelvis.** In the T-pose the pelvis is that of a standing person, whose iliac spines lie 10 degrees
forward and down; rotations of the pelvis are turned to our frame, in which zero is 3 degrees.

**Legs** from the feet that stand: meanwhile the toe base stays where it is. With the rotations of
the file and the path of the pelvis known, its position is linear in the bone lengths,

.. math:: p(t) = r(t) + f_1 \left(R_0 o_{hip} + R_{hip} o_{knee}\right)
    + f_2 \left(R_{knee} o_{ankle} + R_{ankle} o_{foot}\right),

so the factors :math:`f` on a mean body's offsets follow by least squares from the deviations from
the mean of each stance. A prior of the spread of adults holds where a motion says little.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.errors import ParameterError
from plantigrade.io.skeletons import FORWARD_LEFT_UP_OF_Y_UP, rest_pose, tree_kinematics, up_axis
from plantigrade.io.smpl_layouts import (
    RATES,
    Layout,
    check_speed,
    chosen,
    contents_of,
    is_smplx,
    motion,
    numbers,
    rate_of_file,
    sex_of,
)
from plantigrade.io.smpl_tree import MEAN_STATURE, NAMES, PARENTS, ROOT, mean_offsets, model_offsets
from plantigrade.motion.filters import runs
from plantigrade.motion.recording import Recording, SkeletonMotion, Subject
from plantigrade.notes import Info

N_ROUNDS = 4  # stances are found again with the lengths of the round before
MAX_STANCE_HEIGHT = 0.03  # [m] of ankle and toe base above their lowest while a foot stands flat
MAX_STANCE_SPEED = 0.25  # [m/s] of both while a foot stands
LEG = ("hip", "knee", "ankle", "foot")
MIN_STANCE_DURATION = 0.15  # [s] shortest stance that counts
INDEPENDENT = 3.0  # [1/stance] independent measurements in one stance: residuals vary slowly
SIZE_SD = 0.08  # [1] prior of the size of the legs; statures of adults vary by 5 %
RATIO_SD = 0.04  # [1] prior of the ratio of thigh and shank, in adults
MIN_RESIDUAL = 0.002  # [m] assumed error of the toe base at least


@dataclass(frozen=True)
class LegFactors:
    """Factors on the lengths of thigh and shank."""

    thigh: float  #: Factor on hip and knee offsets
    shank: float  #: Factor on ankle and foot offsets
    standard_errors: tuple[float, float]  #: Standard errors of both
    stances: int  #: Number of stances they follow from

    @property
    def size(self) -> float:
        """Factor on the body."""
        return 0.5 * (self.thigh + self.shank)

    def scaled(self, offsets: Float[Array, "22 3"]) -> Float[Array, "22 3"]:
        """Return the offsets of a body with these legs."""
        factor = {"hip": self.thigh, "knee": self.thigh, "ankle": self.shank, "foot": self.shank}
        each = [factor.get(name.partition("_")[2], self.size) for name in NAMES]
        return offsets * np.array(each)[:, None]


def leg_factors(
    local: Float[Array, "n 22 3 3"],
    root: Float[Array, "n 3"],
    offsets: Float[Array, "22 3"],
    rate: float,
) -> LegFactors:
    """Return the factors on leg lengths that let standing feet stand.

    Args:
        local: Rotation of each joint relative to its parent; that of the root in the world.
        root: Position of the pelvis joint, z up [m].
        offsets: Offsets of a mean body [m].
        rate: Frames per second [Hz].
    """
    found = LegFactors(1.0, 1.0, (SIZE_SD, SIZE_SD), 0)
    for _ in range(N_ROUNDS if len(root) > 2 else 0):
        R, p = tree_kinematics(PARENTS, local, root, found.scaled(offsets))
        rows: list[np.ndarray] = []
        for side in SIDES:
            chain = [NAMES.index(f"{SIDE_NAMES[side]}_{joint}") for joint in LEG]
            parts = [R[:, PARENTS[j]] @ offsets[j] for j in chain]
            columns = np.stack([parts[0] + parts[1], parts[2] + parts[3], -root], axis=-1)
            for frames in _stances(p[:, chain[2:]], rate):
                stance = columns[frames]
                rows.append((stance - stance.mean(axis=0)) / np.sqrt(len(stance)))
        found = _solved(rows)
    return found


def _stances(foot: Float[Array, "n 2 3"], rate: float) -> list[slice]:
    """Return the frames of each stance of a foot, given by ankle and toe base."""
    height = foot[:, :, 2] - np.quantile(foot[:, :, 2], 0.05, axis=0)
    speed = np.linalg.norm(np.gradient(foot, 1 / rate, axis=0), axis=2)
    flat = ((height < MAX_STANCE_HEIGHT) & (speed < MAX_STANCE_SPEED)).all(axis=1)
    return [s for s in runs(flat) if s.stop - s.start >= max(MIN_STANCE_DURATION * rate, 2)]


def _solved(rows: list[np.ndarray]) -> LegFactors:
    """Return the most probable factors; each stance counts as few independent measurements."""
    half, difference = np.array([0.5, 0.5]) / SIZE_SD, np.array([1.0, -1.0]) / RATIO_SD
    prior = np.stack([half, difference])
    target = np.array([1.0 / SIZE_SD, 0.0])
    factors, covariance = np.ones(2), np.linalg.inv(prior.T @ prior)
    if rows:
        stances = np.concatenate(rows).reshape(-1, 3)
        A, b = stances[:, :2], stances[:, 2]
        for _ in range(3):  # the residual sets the weight of the motion against the prior
            variance = np.sum((A @ factors - b) ** 2) / (3 * len(rows)) + MIN_RESIDUAL**2
            weight = INDEPENDENT / variance
            covariance = np.linalg.inv(weight * A.T @ A + prior.T @ prior)
            factors = covariance @ (weight * A.T @ b + prior.T @ target)
    factors = np.clip(factors, 0.5, 2.0)
    thigh, shank = (float(f) for f in factors)
    errors = np.sqrt(np.diag(covariance))
    return LegFactors(thigh, shank, (float(errors[0]), float(errors[1])), len(rows))


VIDEO_RATE = 30.0  # [Hz] of files without a rate: the usual one of cameras
MAX_NOTE_ERROR = 15.0  # [mm] standard error of leg lengths up to which their note is no warning
PELVIS_TILT = np.deg2rad(7.0)
"""Forward tilt of our pelvis frame in the T-pose [rad]: the iliac spines of standing people are
tilted by 10 degrees (of one AMASS sample with markers: 9.9), and by 2.9 in our frame at zero."""


def read_smpl(
    path: str | Path, *, skeleton: str | Path | None = None, rate: float | None = None
) -> Recording:
    """Read a motion in the pose parameters of SMPL, SMPL-H or SMPL-X.

    Args:
        path: The ``.npz``, ``.pkl`` or ``.pt`` file.
        skeleton: Body model (``.npz`` with ``J_regressor``, ``v_template`` and ``shapedirs``) that
            gives the bone lengths for the file's ``betas``.
        rate: Frames per second [Hz]; by default that of the file, or 30.

    Returns:
        A recording with a ``skeleton`` of 22 joints, and the person's sex where it is given.

    Raises:
        FileError: If the file is damaged, holds anything but arrays, or no motion in world axes.
        ParameterError: If ``rate`` is not allowed.
    """
    path, warnings = Path(path), list[str]()
    if rate is not None and not RATES[0] <= rate <= RATES[1]:
        raise ParameterError(f"rate is {rate:g} Hz; allowed is {RATES[0]:g} to {RATES[1]:g} Hz")
    data, layout = chosen(path, contents_of(path), warnings)
    local, trans = motion(path, data, layout)
    hz = rate or rate_of_file(path, data) or _assumed_rate(warnings)
    check_speed(path, layout, trans, hz)
    sex = sex_of(data)
    kind = "smplx" if is_smplx(data, layout) else "smpl"
    offsets, pelvis = mean_offsets(MEAN_STATURE[sex], sex), np.array(ROOT[kind])
    if skeleton is not None:
        offsets, pelvis = model_offsets(skeleton, numbers(path, data, "betas"))
    body = FORWARD_LEFT_UP_OF_Y_UP
    world = _world_axes(local, trans, offsets, layout, warnings)
    local = body @ local @ body.T
    local[:, 0] = world @ body.T @ local[:, 0]
    root = trans @ world.T + (world @ body.T @ pelvis)
    if layout.at_hips:
        root = trans @ world.T - local[:, 0] @ (0.5 * (offsets[1] + offsets[2]))
    if skeleton is None:
        legs = leg_factors(local, root, offsets, hz)
        offsets = legs.scaled(offsets)
        warnings.append(_note(legs, offsets, data))
    R, p = tree_kinematics(PARENTS, local, root, offsets)
    R[:, 0] = R[:, 0] @ Rotation.from_rotvec([0.0, PELVIS_TILT, 0.0]).as_matrix()
    moved = SkeletonMotion(
        names=NAMES,
        parents=PARENTS,
        time=np.arange(len(p)) / hz,
        positions=p,
        rotations=R,
        rest_positions=rest_pose(PARENTS, offsets),
        ends=np.full(p.shape, np.nan),
        lengths_assumed=skeleton is None and layout.name == "AMASS",
    )
    return Recording(
        source=path,
        skeleton=moved,
        subject=Subject(sex=sex),
        warnings=tuple(warnings),
        companions=() if skeleton is None else (Path(skeleton),),
    )


def _world_axes(
    local: np.ndarray,
    trans: np.ndarray,
    offsets: Float[Array, "22 3"],
    layout: Layout,
    warnings: list[str],
) -> Float[Array, "3 3"]:
    """Return the rotation from the file's world to ours."""
    body = FORWARD_LEFT_UP_OF_Y_UP
    _, p = tree_kinematics(PARENTS, local, trans, offsets @ body)
    seen = up_axis(NAMES, p)
    axes = {"y": np.array([0.0, 1, 0]), "z": np.array([0.0, 0, 1])}
    up = axes[layout.up]
    for name, axis in axes.items():
        if seen is not None and np.array_equal(seen, axis) and name != layout.up:
            up = axis
            warnings.append(
                f"{name} was taken as up: the head is above the feet along it ({layout.name} files "
                f"usually have {layout.up} up)"
            )
    return body if up[1] else np.eye(3)


def _note(legs: LegFactors, offsets: Float[Array, "22 3"], data: Mapping[Any, Any]) -> str:
    """Return a sentence on where the bone lengths come from."""
    thigh, shank = (np.linalg.norm(offsets[NAMES.index(f"left_{j}")]) for j in ("knee", "ankle"))
    shape = " (option skeleton: a body model, for its betas)" if "betas" in data else ""
    start = f"the file has no bone lengths{shape}"
    if not legs.stances:
        return f"{start}, and no foot stands long enough to tell them: they are a mean adult's"
    error = 1e3 * max(legs.standard_errors) * thigh
    note = (
        f"{start}: {legs.stances} stances of the feet give {thigh:.3f} m for the thigh and "
        f"{shank:.3f} m for the shank (standard error {error:.0f} mm)"
    )
    return Info(f"{note}.") if error < MAX_NOTE_ERROR else f"{note}; give --height if it is known"


def _assumed_rate(warnings: list[str]) -> float:
    """Return the frame rate of a file without one [Hz], with a warning."""
    warnings.append(
        f"the file has no frame rate: {VIDEO_RATE:g} Hz was assumed (set it with --rate)"
    )
    return VIDEO_RATE
