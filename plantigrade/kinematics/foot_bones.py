r"""Motion of the bones of a foot, from the motion of a rigid foot and its ground contact.

Recordings of a foot as one piece, or as a foot and toes, lack its segments. Their poses follow from
the ankle and the loaded segments
(:mod:`plantigrade.kinematics.foot_pose`):

* *heel alone*: the foot keeps its recorded orientation;
* *heel and ball*: all segments lie on the ground, until the ankle begins to rise;
* *ball and toes*: the toes lie on the ground and the ankle's height turns the foot about their
  joints; where they would bend further than toes do in walking they roll onto their tips, and a
  foot whose pitch was recorded keeps it;
* *nothing*: the foot as recorded, with straight joints; the toes are extended as long as they would
  otherwise penetrate the ground.

In the paper, unloaded segments stay aligned with the rest of the foot. Human heels do not: after
heel rise the forefoot dorsiflexes relative to the hindfoot together with the ankle and
plantarflexes in push-off. In the mean curves of the Oxford Foot Model both angles are correlated in
stance (r = 0.96), with the ratio :data:`MIDFOOT_RATIO`.

The loaded segments change between frames; the poses of two sets are blended for :data:`BLEND_TIME`
around the change with smooth weights, so that joint angles are continuous.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.foot_pose import MAX_TOE_BEND, SEGMENTS, FootPoser, marks
from plantigrade.kinematics.ground_normal import hinge_angles, hinge_turn
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import ContactFrames, find_rests
from plantigrade.kinematics.state import body_paths
from plantigrade.models import Human
from plantigrade.motion.recording import rate_of

BLEND_TIME = 0.12  # [s] blend between poses, the time of a foot to settle
MIDFOOT_RATIO = 0.38
"""Dorsiflexion of the forefoot relative to the hindfoot per ankle dorsiflexion [1]; least squares
on mean curves of walking from foot flat to toe-off (12 to 62 % of the cycle, curves of
:mod:`plantigrade.models.textbook_gait`, method of [Stebbins2006]_)."""
NONE, EDGE, FLAT, TOES, TIPS, LEAVING = range(6)
"""Loaded parts: none, the edge of the heel, the whole foot, the toes, their tips; or none, while
straight toes would be in the ground."""
_TOES = marks(*SEGMENTS[2:])
METATARSAL_HEADS = "contact_medial_phalanges_metatarsal_3", "contact_lateral_phalanges_metatarsal_4"
_SETS = np.array([marks(), marks("heel_edge"), marks(*SEGMENTS), _TOES, marks("toe_tips"), _TOES])
_HEEL, _CUBOID, _MTP, _MTP4 = (slice(k, k + 3) for k in (0, 3, 6, 9))  # hinges of a foot
_N_STEPS = 6  # [1] Gauss-Newton steps
# [1] quantile of the ankle's height over a flat foot taken as standing height
_STANDING_QUANTILE = 0.25


@dataclass(frozen=True)
class FootBoneMotion:
    """A foot over a motion."""

    rotation: Float[Array, "n_frames 3 3"]  #: Rotation from the foot to the world
    #: Angles of the hinges within the foot, in the order of :attr:`FootPoser.coordinates` [rad]
    angles: Float[Array, "n_frames 12"]
    #: Loaded parts: :data:`NONE`, :data:`EDGE`, :data:`FLAT`, :data:`TOES`, :data:`TIPS`,
    #: :data:`LEAVING`
    pressing: np.ndarray
    #: Shift of an ankle out of reach of the loaded parts, along the ground's normal [m]
    shift: Float[Array, " n_frames"]


def pressing(
    rests: Sequence[ContactFrames], side: str, height: Float[Array, " n_frames"], standing: float
) -> np.ndarray:
    """Return the loaded parts of a foot in every frame, without the tips of the toes.

    Args:
        rests: Rests of the regions of the soles.
        side: ``"r"`` or ``"l"``.
        height: Height of the ankle above the ground [m].
        standing: Height of the ankle in stance [m].
    """
    resting = {region: np.zeros(len(height), bool) for region in ("heel", "ball", "toes")}
    for rest in rests:
        if rest.side == side:
            resting[rest.region][rest.start : rest.stop] = True
    fore = resting["ball"] | resting["toes"]
    out = np.full(len(height), NONE)
    out[resting["heel"]] = EDGE
    out[resting["heel"] & resting["ball"]] = FLAT
    out[fore & (~resting["heel"] | (height > standing))] = TOES
    return out


def foot_path(
    poser: FootPoser,
    time: Float[Array, " n_frames"],
    ankle: Float[Array, "n_frames 3"],
    facing: Float[Array, "n_frames 3 3"],
    shank: Float[Array, "n_frames 3 3"],
    presses: np.ndarray,
    *,
    turns: bool = True,
    pitched: bool = False,
) -> FootBoneMotion:
    """Return a foot's pose over a motion, smooth at changes of the loaded parts.

    Args:
        time: Time of each frame [s].
        ankle: Ankle joint centre [m].
        facing: Rotation from the foot to the world in the motion of the rigid foot.
        shank: Rotation from the tibia to the world.
        presses: Loaded parts in every frame (:func:`pressing`).
        pitched: Whether ``facing`` includes a recorded pitch, which is then kept while the foot
            rolls over its heel or the tips of its toes.
        turns: Whether the foot may rotate; otherwise only the segments within it do, with correct
            orientations but approximate positions.
    """
    n = len(time)
    air, flat = (poser.pose(ankle, facing, _SETS[np.full(n, kind)]) for kind in (NONE, TOES))
    heel = poser.segment == SEGMENTS.index("heel")
    low = air.clearance[:, ~heel].min(axis=1)
    sunk = (low < 0) & (low < air.clearance[:, heel].min(axis=1))
    presses = np.where((presses == NONE) & sunk, LEAVING, presses)
    rolls = (presses == TOES) & (flat.angles[:, _MTP.start] > MAX_TOE_BEND)
    presses = np.where(rolls, LEAVING if pitched else TIPS, presses)
    if pitched:
        presses[presses == EDGE] = NONE
    # toes of a foot with fixed orientation point down from their joints
    heads = [poser.spheres.index(f"{head}_{poser.side}") for head in METATARSAL_HEADS]
    dip = np.arcsin(np.clip(air.clearance[:, heads] / poser.toes, 0.0, 1.0))
    turn, angles, shift = np.zeros((n, 3)), np.zeros((n, 12)), np.zeros(n)
    for kind, weight in _weights(time, presses).items():
        rows = np.flatnonzero(weight > 0)
        pose = poser.pose(ankle[rows], facing[rows], _SETS[np.full(len(rows), kind)])
        inner = pose.angles
        if kind in (TOES, TIPS, LEAVING):
            foot = pose.rotation if turns and kind != LEAVING else facing[rows]
            forward = (shank[rows].swapaxes(1, 2) @ foot[:, :, :1])[:, 2, 0]
            inner[:, 0] -= MIDFOOT_RATIO * np.arcsin(np.clip(forward, -1.0, 1.0))
        w = weight[rows, None]
        may = turns and kind != LEAVING
        if not may:
            inner = _upon(facing[rows], pose.rotation, inner, kind, poser.sign, dip[rows])
        turned = Rotation.from_matrix(pose.rotation @ facing[rows].swapaxes(1, 2)).as_rotvec()
        turn[rows] += w * turned * may
        angles[rows] += w * inner
        shift[rows] += weight[rows] * pose.shift * may
    rotation = Rotation.from_rotvec(turn).as_matrix() @ facing
    return FootBoneMotion(rotation, angles, presses, shift)


def _upon(facing, rotation, angles, kind: int, sign: float, dip) -> np.ndarray:
    """Return the hinges that keep loaded segments in place for the recorded foot orientation.

    Loaded toes point down by ``dip``, but not below the foot [rad].
    """
    back, out = facing.swapaxes(1, 2) @ rotation, angles.copy()
    heel, cuboid, toes, lateral = (
        hinge_turn(angles[:, part], sign) for part in (_HEEL, _CUBOID, _MTP, _MTP4)
    )
    if kind == FLAT:
        out[:, _HEEL], out[:, _CUBOID] = (
            hinge_angles(back @ part, sign) for part in (heel, cuboid)
        )
    if kind in (TOES, TIPS, LEAVING):
        out[:, _CUBOID] = 0.0
        out[:, _MTP4] = hinge_angles(back @ cuboid @ lateral, sign)
    if kind in (FLAT, TOES, TIPS, LEAVING):
        out[:, _MTP] = hinge_angles(back @ toes, sign)
    if kind in (TOES, TIPS, LEAVING):
        for toe, down in zip((_MTP, _MTP4), dip.T, strict=True):
            down = 0.0 if kind == LEAVING else down
            out[:, toe.start] = np.clip(out[:, toe.start] - down, 0.0, MAX_TOE_BEND)
    return out


def _weights(time, presses) -> dict[int, np.ndarray]:
    """Return loaded parts → weight in every frame, smooth in time with unit sum."""
    step = (time[-1] - time[0]) / max(len(time) - 1, 1)
    half = max(1, round(0.5 * BLEND_TIME / step)) if step > 0 else 1
    bell = 1 + np.cos(np.pi * np.arange(-half, half + 1) / (half + 1))
    out = {}
    for kind in np.unique(presses):
        padded = np.pad((presses == kind).astype(float), half, mode="edge")
        out[int(kind)] = np.convolve(padded, bell / bell.sum(), "valid")
    return out


def standing_height(
    rests: Sequence[ContactFrames], side: str, height: Float[Array, " n_frames"], usual: float
) -> float:
    """Return the height of the ankle above the ground in stance [m].

    It is the lower quartile over the frames with heel and ball at rest; ``usual`` without any.
    """
    presses = pressing(rests, side, np.full(len(height), -np.inf), 0.0)
    stands = presses == FLAT
    return float(np.quantile(height[stands], _STANDING_QUANTILE)) if stands.any() else usual


def with_bones(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    rests: Sequence[ContactFrames],
    *,
    known: Sequence[str] = (),
    turns: bool = True,
) -> tuple[Float[Array, "n_frames nq"], dict[str, float]]:
    """Return a motion whose foot bones follow from contact with level ground, and figures.

    Legs and ankle positions are unchanged, including small distances between feet and ground
    (:func:`plantigrade.kinematics.planting.plant_feet` removes them).

    Args:
        human: The person, on multi-segment feet.
        time: Time of each frame [s].
        qpos: The motion; of the feet its hinges of the ankle are used, none within them.
        rests: Rests of the regions of the soles.
        known: Recorded coordinates within the feet, which are unchanged.
        turns: Whether the feet may rotate in the ankles.
    """
    qpos = np.array(qpos)
    low, high = human.limits
    out_of_reach = 0.0
    for side in SIDES:
        poser = FootPoser(human, side)
        own, shank = human.body(f"foot_{side}"), human.body(f"tibia_{side}")
        origins, turned = body_paths(human, qpos, (own, shank))
        ankle, facing, tibia = origins[:, 0], turned[:, 0], turned[:, 1]
        height = ankle[:, 2].copy()
        standing = standing_height(rests, side, height, poser.standing)
        ankle[:, 2] += poser.standing - standing  # as if its foot stood on the ground
        presses = pressing(rests, side, height, standing)
        path = foot_path(poser, time, ankle, facing, tibia, presses, turns=turns, pitched=True)
        if turns:
            hinges = next(b.hinges for b in human.skeleton.bodies if b.name == f"foot_{side}")
            index = [7 + human.hinge(h.name) for h in hinges]
            qpos[:, index] = ankle_angles(human, side, tibia, path.rotation)
        for column, name in zip(path.angles.T, poser.coordinates, strict=True):
            if name not in known:
                qpos[:, 7 + human.hinge(name)] = column
        out_of_reach = max(out_of_reach, float(np.abs(path.shift).max()))
    qpos[:, 7:] = np.clip(qpos[:, 7:], low, high)
    return qpos, {"ankle_out_of_reach_max_mm": 1e3 * out_of_reach}


def on_feet_with_bones(
    human: Human, time: Float[Array, " n_frames"], qpos: Float[Array, "n_frames nq"]
) -> tuple[Human, Float[Array, "n_frames nq_bones"], dict[str, float]]:
    """Return person and motion with multi-segment feet that stand where the original feet did.

    The motion on level ground may be recorded, reproduced or optimised. Hinges keep their angles
    except those of the feet and small changes of the legs for planted feet.

    Args:
        human: The person, on feet of any kind.
        time: Time of each frame, evenly spaced [s].

    Returns:
        The person on multi-segment feet, the motion, and figures.
    """
    rate = rate_of(time)
    rests = find_rests(sole_paths(human, qpos), rate)
    bony = Human.from_dict({**human.to_dict(), "feet": "multi-segment", "soles": {}})
    out = np.tile(bony.standing(), (len(qpos), 1))
    out[:, :7] = qpos[:, :7]
    inner = {c for side in SIDES for c in FootPoser(bony, side).coordinates}
    for k, name in enumerate(human.coordinates):
        if name in bony.coordinates and name not in inner:
            out[:, 7 + bony.hinge(name)] = qpos[:, 7 + k]
    out, figures = with_bones(bony, time, out, rests)
    return bony, plant_feet(bony, out, rate=rate, rests=rests), figures


def hinges_towards(axes: Float[Array, "k 3"], target: Float[Array, "n 3 3"]) -> Float[Array, "n k"]:
    """Return the angles of hinges in a row that come closest to a rotation [rad].

    Three hinges reach it; two minimise the remaining angle.
    """
    angles = np.zeros((len(target), len(axes)))
    for _ in range(_N_STEPS):
        turned, J = np.broadcast_to(np.eye(3), target.shape), np.empty((*angles.shape, 3))
        for k, axis in enumerate(axes):
            J[:, k] = turned @ axis
            turned = turned @ Rotation.from_rotvec(angles[:, k, None] * axis).as_matrix()
        error = Rotation.from_matrix(target @ turned.swapaxes(1, 2)).as_rotvec()
        angles += np.linalg.solve(J @ J.swapaxes(1, 2), J @ error[..., None])[..., 0]
    return angles


def ankle_angles(
    human: Human, side: str, shank: Float[Array, "n 3 3"], foot: Float[Array, "n 3 3"]
) -> Float[Array, "n k"]:
    """Return the ankle angles between shank and foot [rad].

    Args:
        side: ``"r"`` or ``"l"``.
        shank: Rotation from the tibia to the world.
        foot: Rotation from the foot to the world.
    """
    body = next(b for b in human.skeleton.bodies if b.name == f"foot_{side}")
    return hinges_towards(np.array([h.axis for h in body.hinges]), shank.swapaxes(1, 2) @ foot)
