"""Required forces of a motion and the geometry of its supports."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import SIDES
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.contact.intervals import ContactInterval
from plantigrade.contact.site import contact_sites
from plantigrade.dynamics.centroid import root_wrench_at
from plantigrade.dynamics.loading import Support
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human
from plantigrade.motion.motion import Motion
from plantigrade.motion.recording import even_clock
from plantigrade.spatial.conventions import rotation_matrix, unit_vectors

# [1] reduction of the sole's limits per height above MAX_SOLE_HEIGHT. Chosen
HEIGHT_REDUCTION = 4.0
MAX_SOLE_HEIGHT = 0.010  # [m] height above the lowest point up to which a point supports fully
SOLE_MARGIN = 0.005  # [m] flesh and shoe beyond the points of the sole
PER_FRAME = (
    *("com", "force", "moment", "base", "heading"),
    *("joints", "arms", "sole", "lean", "pelvis", "rotation"),
)  # fields of RequiredForces per frame, besides the time
MIN_LEVEL_DIFFERENCE = 0.04  # [m] distance from the common floor of a stance on another level


@dataclass(frozen=True)
class RequiredForces:
    """Required forces at the frames of the program, in axes of the ground.

    Supports are the right and the left foot, then others such as a seat. The wrench of a foot is
    its force and its moment about ``base``, a point of the floor below its ankle; that of another
    support refers to the middle of its contact.
    """

    time: Float[Array, " n"]  #: [s]
    weight: float  #: Body weight [N]
    com: Float[Array, "n 3"]  #: Centre of mass of the model [m]
    force: Float[Array, "n 3"]  #: Required net force [BW]
    moment: Float[Array, "n 3"]  #: Required moment about the centre of mass [BW m]
    base: Float[Array, "n k 3"]  #: Reference point of each support's moment [m]
    heading: Float[Array, "n k 2"]  #: Horizontal unit vector of each support's direction
    #: Joint moments of each leg without ground reaction [BW m]
    joints: Float[Array, "n 2 n_joints"]
    #: Generalised force of each joint per unit wrench, which is subtracted from ``joints``
    arms: Float[Array, "n 2 n_joints 6"]
    strength: Float[Array, "2 n_joints"]  #: Maximum moment of each joint [BW m]
    columns: tuple[
        tuple[int, ...], tuple[int, ...]
    ]  #: Indices of these joints in ``qvel``, by side
    #: Limits of the centre of pressure from ``base``: [m] backward, forward, right and left end,
    #: in the support's heading
    sole: Float[Array, "n k 4"]
    #: Forward lean of each shank from gravity's vertical in the heading of its foot [rad]
    lean: Float[Array, "n 2"]
    pelvis: Float[Array, "n 3"]  #: Origin of the pelvis [m]
    rotation: Float[Array, "n 3 3"]  #: Axes of the pelvis
    to_world: Float[Array, "3 3"]  #: Rotation from the axes of the ground to world

    def held(self, before: int, after: int) -> "RequiredForces":
        """Return a copy padded by repetitions of the first and the last frame."""
        n = len(self.time)
        time = self.time[0] + (self.time[1] - self.time[0]) * np.arange(-before, n + after)
        frames = np.clip(np.arange(-before, n + after), 0, n - 1)
        return replace(self.frames(frames), time=time)

    def frames(self, chosen: slice | Int[Array, " m"]) -> "RequiredForces":
        """Return a copy at selected frames."""
        per_frame = {name: getattr(self, name)[chosen] for name in ("time", *PER_FRAME)}
        return replace(self, **per_frame)


def _swept(
    human: Human, motion: Motion, qacc: Float[Array, "n nv"], supports: tuple[Support, ...]
) -> tuple[tuple[Array, ...], tuple[tuple[int, ...], ...]]:
    """Return what every frame says, in world axes, and the columns of the joints of each leg.

    That is the root's force and moment, centre of mass, joint torques of the legs, axes and arms of
    these joints, ankles, their forward axes and knees, supports and their forward axes, and the
    spheres.
    """
    n = motion.n_frames
    feet = human.both("foot")
    points = PointSet(human, [f"foot_{side}" for side in SIDES], np.zeros((2, 3)))
    columns = tuple(tuple(np.flatnonzero(points.moved[k, 0])[6:].tolist()) for k in (0, 1))
    root, com = np.empty((n, 6)), np.empty((n, 3))
    joints = np.empty((n, 2, len(columns[0])))
    axes, arms = np.empty((n, 2, 3, len(columns[0]))), np.empty((n, 2, 3, len(columns[0])))
    ankle, forward, knee = (np.empty((n, 2, 3)) for _ in range(3))
    shanks = human.both("tibia")
    others = [human.body(support.body) for support in supports]
    place = PointSet.of(human, [_Place(s.body, s.point) for s in supports])
    held, ahead = np.empty((n, len(others), 3)), np.empty((n, len(others), 3))
    sites = SitePoints(human, contact_sites(human))
    soles = np.empty((n, len(sites), 3))
    for f, state in enumerate(sweep(human, motion.qpos, motion.qvel)):
        soles[f] = state.position(sites)
        tau = state.inverse_dynamics(qacc[f])
        root[f], com[f] = tau[:6], state.com
        J = state.jacobian(points)
        for k, body in enumerate(feet):
            own = list(columns[k])
            joints[f, k] = tau[own]
            axes[f, k] = state.angular_jacobian(body)[:, own]
            arms[f, k] = J[k][:, own]
            ankle[f, k] = state.origin(body)
            forward[f, k] = state.rotation(body)[:, 0]
            knee[f, k] = state.origin(shanks[k])
        if others:
            held[f] = state.position(place)
            ahead[f] = [state.rotation(body)[:, 0] for body in others]
    return (root, com, joints, axes, arms, ankle, forward, knee, held, ahead, soles), columns


def required_forces(
    human: Human,
    motion: Motion,
    qacc: Float[Array, "n nv"],
    contacts: tuple[ContactInterval, ...],
    supports: tuple[Support, ...] = (),
    ground: Ground = LEVEL_GROUND,
) -> RequiredForces:
    """Return the forces that a motion requires."""
    to_world = ground.to_world
    time, n = even_clock(motion.time), motion.n_frames
    weight = human.mass * human.gravity
    swept, columns = _swept(human, motion, qacc, supports)
    root, com, joints, axes, arms, ankle, forward, knee, held, ahead, soles = swept
    sites = SitePoints(human, contact_sites(human))
    force, moment = (each @ to_world for each in root_wrench_at(root, motion.qpos, com))
    shank = knee - ankle
    com, soles, ankle, held = (each @ to_world for each in (com, soles, ankle, held))
    forward, ahead = ((each @ to_world)[..., :2] for each in (forward, ahead))
    arms, axes = (np.einsum("ab,nkaj->nkbj", to_world, each) for each in (arms, axes))
    soles[..., 2] -= sites.radius
    below = {side: soles[:, [s.side == side for s in sites.sites]] for side in SIDES}
    steps = tuple(c for c in contacts if c.side)
    base = ankle.copy()
    base[..., 2] = _floor(time, below, steps)
    heading = _headings(time, forward, steps)
    at_base = arms + np.cross(axes, (base - ankle)[..., None], axis=2)
    sizes = [[-s.reach[0], s.reach[0], -s.reach[1], s.reach[1]] for s in supports]
    reach = np.tile(np.reshape(np.array(sizes, dtype=float), (1, len(supports), 4)), (n, 1, 1))
    return RequiredForces(
        time,
        weight,
        com,
        force / weight,
        moment / weight,
        np.concatenate([base, held], axis=1),
        np.concatenate([heading, unit_vectors(ahead)], axis=1),
        joints / weight,
        np.concatenate([at_base, axes], axis=2).swapaxes(2, 3),
        np.array([_strength(human, own) for own in columns]) / weight,
        columns,  # pyright: ignore[reportArgumentType]
        np.concatenate([_sole_limits(below, base, heading), reach], axis=1),
        _lean(shank, heading @ to_world[:, :2].T),
        motion.qpos[:, :3] @ to_world,
        to_world.T @ rotation_matrix(motion.qpos[:, 3:7]),
        to_world,
    )


class _Place(NamedTuple):
    body: str
    position: tuple[float, float, float]


def _lean(shank: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Return the forward lean of shanks, from ankle to knee, in the direction of the feet."""
    return np.arctan2((shank[..., :2] * unit_vectors(heading[..., :2])).sum(axis=-1), shank[..., 2])


def _strength(human: Human, columns: tuple[int, ...]) -> np.ndarray:
    """Return the mean maximum moment of joints in both directions, by column of ``qvel`` [N m]."""
    hinges = human.model.dof_jntid[list(columns)]
    return np.abs(human.model.jnt_actfrcrange[hinges]).mean(axis=1)


def _floor(time, soles, contacts) -> np.ndarray:
    """Return the height of the floor below each foot (n, 2), common or by stance [m]."""
    low = np.stack([soles[side][..., 2].min(axis=1) for side in SIDES], axis=1)
    levels = []
    for contact in contacts:
        k, share = SIDES.index(contact.side), contact.share(time, contact.stop - contact.start)
        middle = contact.frames(time) & (share > 0.2) & (share < 0.7)
        here = middle if middle.any() else contact.frames(time)
        levels.append(float(np.median(low[here, k])) if here.any() else np.nan)
    common = float(np.nanmedian(levels)) if np.isfinite(levels).any() else float(low.min())
    floor = np.full((len(time), 2), common)
    for contact, level in zip(contacts, levels, strict=True):
        if abs(level - common) > MIN_LEVEL_DIFFERENCE:
            floor[contact.frames(time), SIDES.index(contact.side)] = level
    return floor


def _headings(time, forward, contacts) -> np.ndarray:
    """Return the headings of the feet, constant in each contact."""
    heading = unit_vectors(forward)
    for contact in contacts:
        k, here = SIDES.index(contact.side), contact.frames(time)
        if contact.rolls and here.any():
            heading[here, k] = unit_vectors(forward[here, k].sum(axis=0))
    return heading


def _sole_limits(soles, base, heading) -> np.ndarray:
    limits = np.empty((len(base), 2, 4))
    for k, side in enumerate(SIDES):
        arm = soles[side][..., :2] - base[:, k, None, :2]
        h = heading[:, k, None]
        along = (arm * h).sum(axis=-1)
        left = arm[..., 1] * h[..., 0] - arm[..., 0] * h[..., 1]
        height = soles[side][..., 2]
        pull = HEIGHT_REDUCTION * np.maximum(
            height - height.min(axis=1, keepdims=True) - MAX_SOLE_HEIGHT, 0.0
        )
        for i, ways in enumerate((along, left)):
            low = (ways + pull).min(axis=1) - SOLE_MARGIN
            high = (ways - pull).max(axis=1) + SOLE_MARGIN
            limits[:, k, 2 * i] = np.minimum(low, 0.5 * (low + high))
            limits[:, k, 2 * i + 1] = np.maximum(high, 0.5 * (low + high))
    return limits
