r"""Measured ground reactions on each foot at the frames of a motion.

**Assignment.** A loading of a plate belongs to the foot with its sole at the centre of pressure,
unless the plate specifies its side. One plate may carry one foot after the other. While both feet
are on the same plate, or a foot is partly off its plate, the force on each foot is unknown:
these frames are reported and excluded, as are frames in which a foot rests on the ground or on a
box off the plates, and contacts with the centre of pressure outside the sole
(:mod:`plantigrade.dynamics.plate_checks`).

**Filter.** Every loading is filtered separately: the wrench about a fixed point, force :math:`F`
and moment :math:`M`, with the cut-off of the motion, reflected at the ends of the contact so that
no force leaks out of it; centre of pressure and free moment follow from the smoothed wrench,

.. math:: c_x = \frac{z F_x - M_y}{F_z}, \quad c_y = \frac{z F_y + M_x}{F_z}, \quad
    T = M_z - c_x F_y + c_y F_x,

with :math:`z` the height of the plate's centre of pressure. Smoothing the centre of pressure
directly would bias it towards the noisy values at small forces.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.plate_checks import (
    MIN_OVERHANG,
    exclude_light,
    exclude_partial,
    exclude_shared,
    leave_out_far,
    needed_force,
)
from plantigrade.dynamics.plate_loadings import (
    PlateLoading,
    centres,
    loadings_of,
    plate_level,
    seen_frames,
)
from plantigrade.dynamics.plate_owner import (
    carried_elsewhere,
    find_owner,
    longer,
    resting_points,
    unmeasured_frames,
)
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.models import Human
from plantigrade.motion.plate_events import outside_of
from plantigrade.motion.recording import ForcePlate

MAX_LISTED = 3  # [1] contacts with the same problem that a note lists individually
MIN_REST_TIME = 0.06  # [s] minimum duration of a rest; shorter ones are low swing


@dataclass(frozen=True)
class PlateUse:
    """A loading of a plate and its foot."""

    plate: str  #: Name of the plate
    side: str  #: ``"r"`` or ``"l"``; empty if no foot was at the centre of pressure
    start: int  #: First frame
    stop: int  #: One after the last frame
    peak: float  #: Maximum vertical force [N]
    problem: str = ""  #: Reason for excluded frames; empty if all are used

    @classmethod
    def of(cls, loading: PlateLoading) -> "PlateUse":
        """Return the use of a plate in one loading."""
        return cls(
            loading.plate.name,
            "".join(side for k, side in enumerate(SIDES) if (loading.owner == k).any()),
            int(loading.frames[0]),
            int(loading.frames[-1]) + 1,
            loading.peak,
            loading.problem,
        )


@dataclass(frozen=True)
class FootForces:
    """Ground reaction on each foot, on the frames of a motion; sides in the order r, l."""

    force: Float[Array, "n_frames 2 3"]  #: Force on the foot, world [N]; zero if unloaded
    #: Centre of pressure, world [m]; NaN for zero force
    point: Float[Array, "n_frames 2 3"]
    torque: Float[Array, "n_frames 2 3"]  #: Vertical free moment at that point, world [N m]
    #: Frames with known force on each foot, including zero in swing
    valid_side: Bool[Array, "n_frames 2"]
    valid: Bool[Array, " n_frames"]  #: Frames with known forces on both feet
    uses: tuple[PlateUse, ...] = ()  #: All loadings of all plates
    warnings: tuple[str, ...] = ()  #: Warnings for the user, one sentence each
    sides: tuple[str, str] = SIDES  #: Names of the sides, in the order of the second axis
    #: Share of the frames in which each foot stands off the plates [1]
    beside_plates: tuple[float, float] = (0.0, 0.0)

    def frames(self, chosen: slice) -> "FootForces":
        """Return a copy at selected frames, without the loadings of the plates."""
        names = ("force", "point", "torque", "valid_side", "valid")
        return replace(self, uses=(), **{name: getattr(self, name)[chosen] for name in names})

    def spoiled(self, time: Float[Array, " n_frames"]) -> tuple[tuple[str, float, float], ...]:
        """Return plate name, start and end [s] of each loading with a problem."""
        return tuple(
            (use.plate, float(time[use.start]), float(time[use.stop - 1]))
            for use in self.uses
            if use.problem
        )


def assign_plates(
    plates: tuple[ForcePlate, ...],
    frame_time: Float[Array, " n_frames"],
    foot_points: Mapping[str, Float[Array, "n_frames n_points 3"]],
    *,
    cutoff: float | None = None,
    lift: Float[Array, " n_frames"] | None = None,
    mass: float | None = None,
) -> FootForces:
    """Return the ground reaction on each foot.

    Args:
        plates: Measured ground reactions, at any rate.
        frame_time: Time of each frame of the motion [s], on the plates' clock.
        foot_points: For ``"r"`` and ``"l"`` the world positions of points on that foot's sole,
            heel first, toes last (:func:`sole_points`) [m].
        cutoff: Zero-lag fourth-order low-pass of the wrenches [Hz], that of the motion; None for
            none. It is skipped for plates with too low a rate.
        lift: Vertical acceleration of the centre of mass plus gravity, smoothed like the wrenches
            [m/s²]; if given, contacts are compared with the force that the motion requires.
        mass: Body mass, if known [kg].

    Raises:
        ParameterError: If a side is missing or the points are not on the frames.
    """
    n = len(frame_time)
    points = _check(frame_time, foot_points)
    notes: list[str] = []
    loadings = [x for plate in plates for x in loadings_of(plate, frame_time, cutoff)]
    resting = resting_points(frame_time, points, plate_level(loadings))
    rests = (longer(frame_time, resting[k].any(axis=1), MIN_REST_TIME) for k in (0, 1))
    touch = np.stack(list(rests), axis=1)
    for loading in loadings:
        find_owner(frame_time, loading, points, touch)
    excluded = np.zeros((n, 2), dtype=bool)
    need = needed_force(frame_time, loadings, touch, lift, mass)
    for each in loadings:
        exclude_shared(frame_time, each, loadings, points, resting, touch, need, excluded)
        exclude_partial(each, plates, points, resting, excluded)
        leave_out_far(frame_time, each, loadings, points, touch, excluded)
        exclude_light(frame_time, each, loadings, touch, lift, need, excluded)
    force, point, torque, measured = _sums(n, loadings, excluded)
    unmeasured = unmeasured_frames(frame_time, touch, measured)
    unmeasured |= carried_elsewhere(frame_time, touch, measured, lift)[:, None]
    seen = seen_frames(plates, frame_time)
    valid_side = ~unmeasured & ~excluded & seen[:, None]
    _describe(notes, frame_time, loadings, seen)
    right, left = unmeasured.mean(axis=0) if plates and n else (0.0, 0.0)
    return FootForces(
        force,
        point,
        torque,
        valid_side,
        np.asarray(valid_side.all(axis=1)),
        tuple(map(PlateUse.of, loadings)),
        tuple(notes),
        beside_plates=(float(right), float(left)),
    )


def _sums(
    n: int, loadings: Sequence[PlateLoading], excluded: Bool[Array, "n 2"]
) -> tuple[Array, Array, Array, Array]:
    """Return force, point of application, free moment, and measured frames of each foot.

    Frames of loadings that are left out are marked as excluded.
    """
    force, moment = np.zeros((n, 2, 3)), np.zeros((n, 2, 3))
    height, weight = np.zeros((n, 2)), np.zeros((n, 2))
    measured = np.zeros((n, 2), dtype=bool)
    for loading in loadings:
        for k in (0, 1):
            mine = loading.owner == k
            at = loading.frames[mine]
            measured[at, k] = True
            if loading.left_out:  # forces on both feet are unknown
                excluded[at, k] = True
                continue
            f, c = loading.force[mine], loading.cop[mine]
            force[at, k] += f
            moment[at, k] += np.cross(c, f) + loading.free[mine, None] * [0.0, 0.0, 1.0]
            height[at, k] += f[:, 2] * c[:, 2]
            weight[at, k] += f[:, 2]
    point = np.full((n, 2, 3), np.nan)
    torque = np.zeros((n, 2, 3))
    with np.errstate(invalid="ignore", divide="ignore"):
        z = height / weight
    carried = measured & (force[..., 2] > 0)
    point[carried], torque[carried, 2] = centres(force[carried], moment[carried], z[carried])
    force[~carried] = 0.0
    return force, point, torque, measured


def over_plates(
    plates: tuple[ForcePlate, ...], foot_points: Mapping[str, Float[Array, "n_frames n_points 3"]]
) -> Bool[Array, " n_frames"]:
    """Return the frames in which both soles are entirely over plates with known corners."""
    points = np.concatenate([foot_points[side] for side in SIDES], axis=1)
    outside = [outside_of(p.corners, points) for p in plates if p.corners is not None]
    if not outside:
        return np.zeros(len(points), dtype=bool)
    return (np.min(outside, axis=0) < MIN_OVERHANG).all(axis=1)


def sole_points(
    human: Human, qpos: Float[Array, "n_frames nq"]
) -> dict[str, Float[Array, "n_frames n_points 3"]]:
    """Return the lowest points of each foot's contact spheres over a motion, heel first [m]."""
    standing = sole_paths(human, human.standing()[None])
    soles = sole_paths(human, qpos)
    result = {}
    for side in SIDES:
        own = soles.of(side)
        order = np.argsort(standing.position[0, own, 0], kind="stable")
        result[side] = soles.position[:, own[order]]
    return result


def _describe(notes, time, loadings, seen) -> None:
    groups: dict[tuple[str, str], list[PlateLoading]] = {}  # by plate and kind of problem
    for loading in loadings:
        if loading.problem:
            kind = re.sub(r"[\d.]+", "", loading.problem)
            groups.setdefault((loading.plate.name, kind), []).append(loading)
    for (plate, _), found in groups.items():
        spans = [f"{time[each.frames[0]]:.2f} to {time[each.frames[-1]]:.2f} s" for each in found]
        left = len(spans) - MAX_LISTED
        more = "" if left <= 0 else " and once more" if left == 1 else f" and {left} times more"
        heaviest = max(found, key=lambda each: each.peak)
        notes.append(
            f"force plate {plate}, {', '.join(spans[:MAX_LISTED])}{more}: {heaviest.problem}; its "
            "frames are excluded from the moments."
        )
    if not seen.all():
        unknown = len(seen) - int(seen.sum())
        notes.append(f"forces were not measured in {unknown} of {len(seen)} frames.")


def _check(time, foot_points) -> list[np.ndarray]:
    missing = [s for s in SIDES if s not in foot_points]
    if missing:
        raise ParameterError(f"foot_points lacks side {missing[0]!r}; give 'r' and 'l'")
    points = [np.asarray(foot_points[s], dtype=float) for s in SIDES]
    for side, p in zip(SIDES, points, strict=True):
        if p.ndim != 3 or p.shape[0] != len(time) or p.shape[2] != 3 or p.shape[1] == 0:
            raise ParameterError(
                f"points of foot {side} have shape {p.shape}; {len(time)} frames need "
                f"({len(time)}, n_points, 3)"
            )
    return points
