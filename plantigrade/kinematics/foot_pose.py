r"""Pose of the bones of a foot from its ankle and its loaded segments.

Eqs. 1-5 of [Park2020]_ for the multi-segment foot of :mod:`plantigrade.models.feet`. A segment that
is *marked* lies flat on the ground, with its joint at the height of a standing foot and its sole
parallel to the ground. The ankle position is given; the foot rotates as little as possible from
*facing*, its orientation in a motion without foot bones.

With :math:`n` the normal of the ground and :math:`R` the orientation of the foot, the unknown is
:math:`u = R^T n`, the normal in the frame of the foot. A marked segment with its joint at
:math:`v_k` in the foot and at :math:`w_k` below the ankle requires

.. math:: u^T v_k = -w_k, \qquad \lVert u \rVert = 1 .

* *One* joint leaves a circle; the point of it nearest to the :math:`u` of the foot as it faces is
  the rotation about :math:`n \times v` by the angle of the paper's Eqs. 1 and 2.
* *Two* leave two points; the choice is the one with unmarked segments above the ground, or the
  nearer one if both satisfy this. (The paper does not treat several.)
* *Three* have no solution unless the ankle has exactly the height of a standing foot.

If no :math:`u` exists, the ankle is moved along :math:`n` by the minimum distance for a solution;
this distance is reported as :attr:`~FootPose.shift`.

A marked segment's orientation (Eq. 4) takes its normal to that of the ground and its direction to
that of the foot, projected on the ground (Eq. 3). As printed, Eq. 4 turns the direction the segment
had *before* it was levelled; here it is levelled first. Both rotations together are the one that
takes one pair of axes to another, so the half-turn at which Eq. 5 is undefined does not arise; in
the turn of the foot itself it does, and is made about its left axis. The fourth toe's joint hangs
on the lateral metatarsals: where these are not marked and the lateral toes are, Eqs. 1 and 2 are
applied again with the cuboid joint in the place of the ankle.

On curved ground every segment has its own plane through the ground beneath its contact spheres;
pose and planes are computed alternately.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.kinematics.ground_normal import (
    GroundNormal,
    axes_from,
    hinge_angles,
    plane_slopes,
    smallest_turn,
    sole_plane,
)
from plantigrade.models import Human
from plantigrade.models.skeleton import Body

SEGMENTS = ("heel", "lateral_metatarsal", "medial_phalanges", "lateral_phalanges")
"""Segments that can be marked. The fifth, the medial metatarsals with the tarsus, has no contact
and rotates with the ankle."""
HEEL, LATERAL, MEDIAL_TOES, LATERAL_TOES, EDGE, TIPS = range(6)
HEEL_EDGE = "heel_edge"
"""The back edge of the heel, over which a landing foot rolls with the heel aligned to the foot. An
addition to the paper, in which a marked heel is flat."""
TOE_TIPS = "toe_tips"
"""The tips of the toes, over which a leaving foot rolls with toes extended by :data:`MAX_TOE_BEND`.
An addition to the paper, in which toes stay flat at any extension."""
MARKS = (*SEGMENTS, HEEL_EDGE, TOE_TIPS)
MAX_TOE_BEND = np.deg2rad(34.0)
"""Toe extension before rolling onto the tips [rad]; mean of the hallux in level walking, from
midstance to its peak (Oxford Foot Model, method of [Stebbins2006]_, curves of
:mod:`plantigrade.models.textbook_gait`)."""

# location of the joint of the lateral toes
FOURTH_METATARSAL_HEAD = "contact_lateral_phalanges_metatarsal_4"
MAX_PLANE_ROUNDS = 4  # [1] iterations of pose and planes on curved ground


def marks(*names: str) -> Bool[Array, " 6"]:
    """Return the mask of named :data:`MARKS`."""
    wrong = set(names) - set(MARKS)
    if wrong:
        raise ParameterError(f"no segment {', '.join(sorted(wrong))}; there are {', '.join(MARKS)}")
    return np.array([name in names for name in MARKS])


@dataclass(frozen=True)
class FootPose:
    """The pose of one foot, frame by frame.

    Attributes:
        rotation: From the foot (``foot_r``: the ankle frame, free of the shank) to the world.
        angles: The hinges within the foot, in the order of :attr:`FootPoser.coordinates` [rad].
            Angles of unmarked segments are zero. Angles may exceed the joints' limits.
        shift: Displacement of the ankle along the normal for contact of the marked segments [m];
            zero within reach.
        clearance: Height of every contact sphere of :attr:`FootPoser.spheres` above the ground [m].
        undetermined: Frames with an undetermined direction: a joint vertically above or below the
            ankle, a half-turn, a foot facing along the normal.
    """

    rotation: Float[Array, "n 3 3"]
    angles: Float[Array, "n 12"]
    shift: Float[Array, " n"]
    clearance: Float[Array, "n n_spheres"]
    undetermined: Bool[Array, " n"]


class _Found(NamedTuple):
    """A pose with the centres of its contact spheres [m]."""

    rotation: np.ndarray
    angles: np.ndarray
    shift: np.ndarray
    open: np.ndarray
    spheres: np.ndarray


class FootPoser:
    """Computes poses of one foot of a person.

    Args:
        human: The person; its feet are ``multi-segment``.
        side: ``"r"`` or ``"l"``.

    Attributes:
        side: The foot.
        sign: 1 for the right foot, -1 for the left one.
        coordinates: Names of the hinges of :attr:`FootPose.angles`.
        spheres: Names of the contact spheres of :attr:`FootPose.clearance`.
        segment: Index in :data:`SEGMENTS` of each sphere.
        toes: Distances of the tips of medial and lateral toes from their joints [m].
        standing: Height of the ankle of a standing foot above level ground [m].
    """

    def __init__(self, human: Human, side: str):
        if human.feet != "multi-segment" or side not in ("r", "l"):
            raise ParameterError(
                f"{human.feet} feet, side {side!r}: only the multi-segment feet 'r' and 'l' have "
                "segments to pose"
            )
        bodies = {b.name: b for b in human.skeleton.bodies}
        parts = [bodies[f"{name}_{side}"] for name in SEGMENTS]
        self.side = side
        self.coordinates = tuple(h.name for b in parts for h in b.hinges)
        self._joint = np.array([b.position for b in parts])  # of each segment, in its parent [m]
        centres = [np.array([c.position for c in b.contacts]) for b in parts]
        self._centres = np.concatenate(centres)[:, :, None]
        self._radius = np.concatenate([[c.radius for c in b.contacts] for b in parts])
        self.spheres = tuple(name for b in parts for name in b.contact_names)
        self.segment = np.repeat(np.arange(4), [len(b.contacts) for b in parts])
        soles = [sole_plane(spheres) for spheres in _lying(parts)]
        normals = np.array([normal for normal, _ in soles])
        self._sole_axes = axes_from(normals, np.eye(3)[0])[0].swapaxes(1, 2)
        back = [c for c in parts[HEEL].contacts if c.name.startswith("heel_back")]
        edge = np.mean([c.position for c in back], axis=0) + self._joint[HEEL]
        self._bend = _bent(MAX_TOE_BEND)
        tips = [c for c in parts[MEDIAL_TOES].contacts if c.name in ("toe_1", "toe_2")]
        ends = (parts[MEDIAL_TOES], "toe_2"), (parts[LATERAL_TOES], "toe_4")
        self.toes = [c.position[0] for b, name in ends for c in b.contacts if c.name == name]
        tip = self._bend @ np.mean([c.position for c in tips], axis=0) + self._joint[MEDIAL_TOES]
        # required heights: heel, cuboid, third toe, fourth toe, edge of the heel, toe tips
        fourth = self._joint[LATERAL] + self._joint[LATERAL_TOES]
        self._pivots = np.array([*self._joint[:3], fourth, edge, tip])
        self._carries = np.array([HEEL, LATERAL, MEDIAL_TOES, LATERAL_TOES, HEEL, MEDIAL_TOES])
        self._heights = np.array([*(h for _, h in soles), back[0].radius, tips[0].radius])
        self._at_rest = np.concatenate(
            [self._origin(k) + centre for k, centre in enumerate(centres)]
        )
        self.sign = 1.0 if side == "r" else -1.0
        self._solver = lru_cache(maxsize=None)(self._prepared)
        standing = self._at_rest[self.segment == HEEL, 2] - self._radius[self.segment == HEEL]
        self.standing = float(-standing.min())

    def _origin(self, k: int) -> np.ndarray:
        """Return the position of a segment's joint in the foot at zero angles [m]."""
        return self._joint[k] + (self._joint[LATERAL] if k == LATERAL_TOES else 0.0)

    def pose(
        self,
        ankle: Float[Array, "n 3"],
        facing: Float[Array, "n 3 3"],
        marked: Bool[Array, "n n_marks"],
        ground: Ground | None = None,
    ) -> FootPose:
        """Return the pose of the foot in every frame.

        Args:
            ankle: Ankle joint centre, world [m].
            facing: Rotation from the foot to the world in a motion without foot bones, from which
                the foot deviates as little as possible and which gives the heading of the toes.
            marked: Mask of the loaded :data:`SEGMENTS` (or :data:`MARKS`).
            ground: The ground; level at height zero if not given.
        """
        ground = ground or Ground()
        if not len(SEGMENTS) <= marked.shape[1] <= len(MARKS):
            raise ParameterError(f"marked has {marked.shape[1]} columns; they are {MARKS}")
        if not (np.isfinite(ankle).all() and np.isfinite(facing).all()):
            raise ParameterError("ankle and facing must be finite numbers")
        if len(ankle) == 1 or (marked == marked[0]).all():
            return self._one_pattern(ankle, facing, tuple(marked[0].tolist()), ground)
        patterns, which = np.unique(marked, axis=0, return_inverse=True)
        out: list[np.ndarray] = []
        for i, pattern in enumerate(patterns):
            rows = np.flatnonzero(which.ravel() == i)
            pose = self._one_pattern(ankle[rows], facing[rows], tuple(pattern.tolist()), ground)
            found = (pose.rotation, pose.angles, pose.shift, pose.clearance, pose.undetermined)
            if not out:
                out = [np.zeros((len(ankle), *x.shape[1:]), x.dtype) for x in found]
            for whole, x in zip(out, found, strict=True):
                whole[rows] = x
        return FootPose(*out)

    def _one_pattern(self, ankle, facing, pattern, ground: Ground) -> FootPose:
        """Return the pose of frames with the same marked segments."""
        solve, n = self._solver(pattern), ground.normal
        if not (ground.uneven or ground.steps):
            desired = (ground.height + self._heights)[None]
            found = solve(ankle, facing, n, n[None, None], desired)
            clearance = found.spheres @ n - ground.height - self._radius
            return FootPose(found.rotation, found.angles, found.shift, clearance, found.open)
        found, aslant = None, self._radius
        spheres = ankle[:, None] + (facing @ self._at_rest.T).swapaxes(1, 2)
        for k in range(MAX_PLANE_ROUNDS):
            if k == 1:  # the spheres are near their places: the ground there is as steep as this
                aslant = self._radius / (ground.normal_at(spheres) @ n)
            normals, desired = self._planes(spheres, ankle, facing, found, aslant, ground)
            found = solve(ankle, facing, n, normals, desired)
            spheres = found.spheres
        assert found is not None
        gap = spheres @ n - ground.under(spheres)
        gap *= ground.normal_at(spheres) @ n
        clearance = gap - self._radius
        return FootPose(found.rotation, found.angles, found.shift, clearance, found.open)

    def _planes(self, spheres, ankle, facing, found, aslant, ground: Ground):
        """Return the ground normal under each segment and the required height of each joint.

        The plane of a segment is the one through the ground under its spheres that comes closest
        to all of them, raised until it lies above all.
        """
        axes = ground.to_world
        rotation = facing if found is None else found.rotation
        moved = ankle if found is None else ankle + found.shift[:, None] * ground.normal
        joints = moved[:, None] + (rotation @ self._pivots.T).swapaxes(1, 2)
        if found is not None:  # the fourth toe, as far as the lateral metatarsals are bent
            joints[:, LATERAL_TOES] = spheres[
                :, self.spheres.index(f"{FOURTH_METATARSAL_HEAD}_{self.side}")
            ]
        below = ground.under(spheres)
        near = np.array(ankle)  # of places far from the origin squares lose digits
        x, at = ((spheres - near[:, None]) @ axes)[..., :2], (joints - near[:, None]) @ axes
        share, outside = self._under
        middle, level = share @ x, (share @ below[..., None])[..., 0]
        slope = plane_slopes(share, x, below, middle, level)
        up = np.ones((len(ankle), 4, 3))
        up[..., :2] = -slope
        length = np.sqrt((up * up).sum(axis=-1))
        # on a slope the contact point of a sphere is not its lowest point
        high = (below + aslant)[:, None] - self._radius * length[..., None]
        high -= slope @ x.swapaxes(1, 2) + outside
        base = high.max(axis=2)  # of the plane, over the ankle
        k = self._carries
        desired = (
            base[:, k] + (at[..., :2] * slope[:, k]).sum(axis=-1) + self._heights * length[:, k]
        )
        return (up / length[..., None]) @ axes.T, desired

    @cached_property
    def _under(self) -> tuple[np.ndarray, np.ndarray]:
        """Weights of the spheres that determine each segment's plane, and the unused spheres.

        The lateral rays include their heads. The second array is infinite for spheres of other
        segments.
        """
        own = self.segment == np.arange(4)[:, None]
        own[LATERAL] |= own[LATERAL_TOES] & np.array(["_metatarsal_" in s for s in self.spheres])
        return own / own.sum(axis=1, keepdims=True), np.where(own, 0.0, np.inf)

    def _angles(self, R, Q):
        """Return the angles of the foot's joints, from the rotations of foot and segments [rad]."""
        inner = R.swapaxes(1, 2)[:, None] @ Q
        inner[:, LATERAL_TOES] = inner[:, LATERAL].swapaxes(1, 2) @ inner[:, LATERAL_TOES]
        return hinge_angles(inner, self.sign).reshape(-1, 12)

    def _prepared(self, pattern: tuple[bool, ...]):
        """Return the function for poses of frames with one pattern of marks.

        Its arguments are ankle, facing, ground normal, normals of the segments' planes and the
        required height of each pivot.
        """
        marked = dict(zip(MARKS, (*pattern, False, False), strict=False))
        heel, lateral, medial, toes = (marked[name] for name in SEGMENTS)
        hold = [HEEL] if heel else [EDGE] * marked[HEEL_EDGE]
        hold += [LATERAL] * lateral + [MEDIAL_TOES] * medial
        hold += [LATERAL_TOES] * (toes and not (lateral or medial))
        rolling = marked[TOE_TIPS] and not (medial or toes)
        hold += [TIPS] * rolling
        find = GroundNormal(self._pivots[hold])
        again = GroundNormal(self._joint[LATERAL_TOES][None])
        pressing = [heel or marked[HEEL_EDGE], lateral, medial or rolling, toes or rolling]
        aloft = ~np.array(pressing)[self.segment]
        others = self._at_rest[aloft], self._radius[aloft]
        down_again = toes and medial and not lateral  # the fourth toe, about the cuboid joint
        flat = _as_slice([k for k in range(4) if pattern[k]])
        moved = any(pattern[:4]) or rolling
        free = any(pattern[k] for k in (LATERAL, LATERAL_TOES))

        def solve(ankle, facing, n, normals, desired):
            high, seen = ankle @ n, n @ facing  # the second: R^T n, one row per frame
            w = high[:, None] - desired[:, hold]
            above = high - desired[:, hold[0]] + self._heights[hold[0]] if len(hold) == 2 else high
            u, down, open_ = find(w, seen, others, above)
            turn, half = smallest_turn(u, seen)
            R, open_ = facing @ turn, open_ | half
            origin = ankle - down[:, None] * n
            Q = np.empty((len(ankle), 4, 3, 3))
            Q[:] = R[:, None]
            joints = origin[:, None] + self._joint @ R.swapaxes(1, 2)
            if flat is not None:
                axes, along = axes_from(normals, facing[:, None, :, 0], R[:, None, :, 0])
                axes = axes if len(axes[0]) == 1 else axes[:, flat]
                Q[:, flat] = axes @ self._sole_axes[flat]
                open_ = open_ | along.any(axis=1)
            if down_again:
                w = joints[:, LATERAL] @ n - desired[:, LATERAL_TOES]
                v, _, lost = again(w[:, None], u)
                turn, half = smallest_turn(v, u)
                Q[:, LATERAL], open_ = R @ turn, open_ | lost | half
            if rolling:
                Q[:, MEDIAL_TOES:] = (R @ self._bend)[:, None]
            if free:
                joint = Q[:, LATERAL] @ self._joint[LATERAL_TOES]
                joints[:, LATERAL_TOES] = joints[:, LATERAL] + joint
                if not (toes or rolling):
                    Q[:, LATERAL_TOES] = Q[:, LATERAL]
            else:
                joints[:, LATERAL_TOES] += joints[:, LATERAL] - origin
            angles = self._angles(R, Q) if moved else np.zeros((len(ankle), 12))
            spheres = joints[:, self.segment] + (Q[:, self.segment] @ self._centres)[..., 0]
            return _Found(R, angles, -down, open_, spheres)

        return solve


def _as_slice(index: list[int]) -> slice | list[int] | None:
    """Return sorted indices as a slice if contiguous; None for an empty list."""
    if not index:
        return None
    whole = index == list(range(index[0], index[-1] + 1))
    return slice(index[0], index[-1] + 1) if whole else index


def _bent(angle: float) -> np.ndarray:
    """Return the rotation of toes extended by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def _lying(parts: list[Body]):
    """Return centres and radii of the contact spheres of each segment, in its axes [m].

    The lateral metatarsals include their heads, which belong to the toes.
    """
    spheres = [
        (np.array([c.position for c in b.contacts]), np.array([c.radius for c in b.contacts]))
        for b in parts
    ]
    toes = parts[LATERAL_TOES]
    heads = np.array(["metatarsal" in c.name for c in toes.contacts])
    (own, size), (centre, radius) = spheres[LATERAL], spheres[LATERAL_TOES]
    centre = np.concatenate([own, centre[heads] + toes.position])
    spheres[LATERAL] = centre, np.concatenate([size, radius[heads]])
    return spheres
