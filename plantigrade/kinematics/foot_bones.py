r"""Motion of the bones of a foot, from the motion of a foot without bones and its ground contact.

Recordings that show a foot as one piece, or as a foot and toes, say nothing of its segments. Where
they are follows from the ankle and from what presses the ground
(:mod:`plantigrade.kinematics.foot_pose`):

* *heel alone*: the foot keeps the direction it was recorded in;
* *heel and ball*: all segments lie on the ground, until the ankle begins to rise;
* *ball and toes*: the toes lie on the ground and the ankle's height turns the foot about their
  joints; where they would bend further than toes do in walking they roll onto their tips, and a
  foot whose pitch was recorded keeps it;
* *nothing*: the foot as it was recorded, its joints straight; the toes are bent as long as they
  would be in the ground otherwise.

What no longer presses the paper leaves in line with the rest of the foot. People's heels are not:
once the heel is up the forefoot bends against it as the foot does against the shank, both ways,
first upwards and, as the foot pushes off, downwards. In the mean curves of the Oxford Foot Model
the two go together in stance (r = 0.96), by :data:`MIDFOOT`.

The segments that press change from one frame to the next; the poses of two sets are mixed for
:data:`MIXED` around the change by weights that rise and fall smoothly, so that no joint jumps.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.kinematics.body_paths import body_paths
from plantigrade.kinematics.foot_pose import BEND, SEGMENTS, FootPoser, marks
from plantigrade.kinematics.normal_seen import hinge_angles, hinge_turn
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.rests import ContactFrames, find_rests
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.models import Human
from plantigrade.motion.recording import rate_of

MIXED = 0.12  # as long as a foot takes to come to its spot on the ground [s]
MIDFOOT = 0.38
"""Dorsiflexion of the forefoot against the heel that comes with each degree of it against the
shank: least squares on mean curves of walking from foot flat to toe off (12 to 62 % of the cycle;
those that :mod:`plantigrade.models.textbook_gait` is made from, method of [Stebbins2006]_)."""
NONE, EDGE, FLAT, TOES, TIPS, LEAVING = range(6)
"""What presses: nothing, the edge of the heel, the whole foot, the toes, their tips; or nothing
any more, but straight toes would."""
_TOES = marks(*SEGMENTS[2:])
HEADS = "contact_medial_phalanges_metatarsal_3", "contact_lateral_phalanges_metatarsal_4"
_SETS = np.array([marks(), marks("heel_edge"), marks(*SEGMENTS), _TOES, marks("toe_tips"), _TOES])
_HEEL, _CUBOID, _MTP, _MTP4 = (slice(k, k + 3) for k in (0, 3, 6, 9))  # hinges of a foot
_STEPS = 6  # of Gauss-Newton
_STANDS = 0.25  # quantile of the ankle's height over a resting foot that is its standing height


@dataclass(frozen=True)
class FootPath:
    """A foot over a motion.

    Attributes:
        rotation: From the foot to the world.
        angles: Of the hinges within it, in the order of :attr:`FootPoser.coordinates` [rad].
        pressing: What presses: :data:`NONE`, :data:`EDGE`, :data:`FLAT`, :data:`TOES`,
            :data:`TIPS`, :data:`LEAVING`.
        shift: How far the ankle was out of reach of what presses, along the ground's normal [m].
    """

    rotation: Float[Array, "n_frames 3 3"]
    angles: Float[Array, "n_frames 12"]
    pressing: np.ndarray
    shift: Float[Array, " n_frames"]


def pressing(
    rests: Sequence[ContactFrames],
    side: str,
    height: Float[Array, " n_frames"],
    standing: float,
) -> np.ndarray:
    """Return which parts of a foot press the ground in every frame, without the tips of the toes.

    Args:
        rests: When which region of the soles rests.
        side: ``"r"`` or ``"l"``.
        height: Height of the ankle above the ground [m].
        standing: The same of a foot that stands [m].
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
    ground: Ground | None = None,
    *,
    turns: bool = True,
    pitched: bool = False,
) -> FootPath:
    """Return a foot's pose over a motion; smooth where what presses changes.

    Args:
        poser: The foot.
        time: Time of each frame [s].
        ankle: Ankle joint centre [m].
        facing: Rotation from the foot to the world in the motion without bones.
        shank: Rotation from the tibia to the world.
        presses: What presses in every frame (:func:`pressing`).
        ground: The ground; level at height zero if not given.
        pitched: Whether ``facing`` tells the pitch of the foot too: then it stays as it faces while
            it rolls over its heel or the tips of its toes, of which the ankle's height tells less.
        turns: Whether the foot may turn; else only the segments within it do, which then lie as
            they would but not quite where.
    """
    n = len(time)
    air, flat = (
        poser.pose(ankle, facing, _SETS[np.full(n, kind)], ground) for kind in (NONE, TOES)
    )
    heel = poser.segment == SEGMENTS.index("heel")
    low = air.clearance[:, ~heel].min(axis=1)
    sunk = (low < 0) & (low < air.clearance[:, heel].min(axis=1))
    presses = np.where((presses == NONE) & sunk, LEAVING, presses)
    rolls = (presses == TOES) & (flat.angles[:, _MTP.start] > BEND)
    presses = np.where(rolls, LEAVING if pitched else TIPS, presses)
    if pitched:
        presses[presses == EDGE] = NONE
    # Toes of a foot that may not turn reach down from where their joints are.
    heads = [poser.spheres.index(f"{head}_{poser.side}") for head in HEADS]
    dip = np.arcsin(np.clip(air.clearance[:, heads] / poser.toes, 0.0, 1.0))
    turn, angles, shift = np.zeros((n, 3)), np.zeros((n, 12)), np.zeros(n)
    for kind, weight in _weights(time, presses).items():
        rows = np.flatnonzero(weight > 0)
        pose = poser.pose(ankle[rows], facing[rows], _SETS[np.full(len(rows), kind)], ground)
        inner = pose.angles
        if kind in (TOES, TIPS, LEAVING):
            foot = pose.rotation if turns and kind != LEAVING else facing[rows]
            forward = (shank[rows].swapaxes(1, 2) @ foot[:, :, :1])[:, 2, 0]
            inner[:, 0] -= MIDFOOT * np.arcsin(np.clip(forward, -1.0, 1.0))
        w = weight[rows, None]
        may = turns and kind != LEAVING
        if not may:
            inner = _upon(facing[rows], pose.rotation, inner, kind, poser.sign, dip[rows])
        turned = Rotation.from_matrix(pose.rotation @ facing[rows].swapaxes(1, 2)).as_rotvec()
        turn[rows] += w * turned * may
        angles[rows] += w * inner
        shift[rows] += weight[rows] * pose.shift * may
    rotation = Rotation.from_rotvec(turn).as_matrix() @ facing
    return FootPath(rotation, angles, presses, shift)


def _upon(facing, rotation, angles, kind: int, sign: float, dip) -> np.ndarray:
    """Return the hinges that leave pressing segments as they are, the foot turned back.

    Toes that press point down to the ground by ``dip``, but not below the foot [rad].
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
            out[:, toe.start] = np.clip(out[:, toe.start] - down, 0.0, BEND)
    return out


def _weights(time, presses) -> dict[int, np.ndarray]:
    """Return kind of press → its weight in every frame: smooth in time, adding up to one."""
    step = (time[-1] - time[0]) / max(len(time) - 1, 1)
    half = max(1, round(0.5 * MIXED / step)) if step > 0 else 1
    bell = 1 + np.cos(np.pi * np.arange(-half, half + 1) / (half + 1))
    out = {}
    for kind in np.unique(presses):
        padded = np.pad((presses == kind).astype(float), half, mode="edge")
        out[int(kind)] = np.convolve(padded, bell / bell.sum(), "valid")
    return out


def standing_height(
    rests: Sequence[ContactFrames], side: str, height: Float[Array, " n_frames"], usual: float
) -> float:
    """Return the height of the ankle above the ground while the foot stands [m].

    A quarter of the frames in which heel and ball rest show it lower; ``usual`` if there are none.
    """
    presses = pressing(rests, side, np.full(len(height), -np.inf), 0.0)
    stands = presses == FLAT
    return float(np.quantile(height[stands], _STANDS)) if stands.any() else usual


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

    The legs stay, and the ankles keep their place: a foot that was a little above the ground or in
    it still is (:func:`plantigrade.kinematics.planting.plant_feet` comes next).

    Args:
        human: The person, on multi-segment feet.
        time: Time of each frame [s].
        qpos: The motion; of the feet its hinges of the ankle are used, none within them.
        rests: When which region of the soles rests.
        known: Coordinates within the feet that the recording shows: they stay too.
        turns: Whether the feet may turn in the ankles.
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

    Any motion on level ground will do: recorded, reproduced or found by optimisation. Hinges keep
    their angles but those of the feet, and of the legs as little as planted feet ask for.

    Args:
        human: The person, on feet of any kind.
        time: Time of each frame, evenly spaced [s].
        qpos: The motion.

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


def hinges_towards(
    axes: Float[Array, "k 3"],
    target: Float[Array, "n 3 3"],
) -> Float[Array, "n k"]:
    """Return the angles of hinges in a row that come closest to a rotation [rad].

    Three hinges reach it; two leave the least angle between.

    Args:
        axes: Axes of the hinges while all are at zero, outermost first.
        target: Rotation from the body they carry to the one they hang on.
    """
    angles = np.zeros((len(target), len(axes)))
    for _ in range(_STEPS):
        turned, J = np.broadcast_to(np.eye(3), target.shape), np.empty((*angles.shape, 3))
        for k, axis in enumerate(axes):
            J[:, k] = turned @ axis
            turned = turned @ Rotation.from_rotvec(angles[:, k, None] * axis).as_matrix()
        error = Rotation.from_matrix(target @ turned.swapaxes(1, 2)).as_rotvec()
        angles += np.linalg.solve(J @ J.swapaxes(1, 2), J @ error[..., None])[..., 0]
    return angles


def ankle_angles(
    human: Human,
    side: str,
    shank: Float[Array, "n 3 3"],
    foot: Float[Array, "n 3 3"],
) -> Float[Array, "n k"]:
    """Return the hinges of the ankle that hold a foot against the shank, in their order [rad].

    Args:
        human: The person.
        side: ``"r"`` or ``"l"``.
        shank: Rotation from the tibia to the world.
        foot: Rotation from the foot to the world.
    """
    body = next(b for b in human.skeleton.bodies if b.name == f"foot_{side}")
    return hinges_towards(np.array([h.axis for h in body.hinges]), shank.swapaxes(1, 2) @ foot)
