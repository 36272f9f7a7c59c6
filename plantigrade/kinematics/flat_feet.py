r"""Correction of feet and soles from frames in which the recorded feet stand flat.

Markers determine the bones but not the sole below them: an error of a few millimetres pitches a
foot by some degrees, and the thickness of flesh or shoe is unmeasured. The ground determines both.
While heel and forefoot rest together the sole lies on the ground; over these frames

* the way up, seen from the foot, becomes the foot's own vertical axis: its markers keep their
  places in the world, the zeros of ankle and subtalar joint (and of joints within the foot) move;
* the height of the ankle joint centre above the ground is that of the bare foot and of the shoe.
  The bare foot's is :math:`a_0 \pm \sigma_a` by the height of the lateral malleolus [Gordon2014]_,
  the shoe's thickness :math:`t \ge 0` some :math:`\sigma_t`, so of the height :math:`c`

.. math:: a = \min(c,\; a_0 + (c - a_0)\,\sigma_a^2 / (\sigma_a^2 + \sigma_t^2)), \quad t = c - a.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float, spread
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import find_rests
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.kinematics.unmeasured_toes import TOE_JOINTS
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment, attachments
from plantigrade.motion.filters import lowpass
from plantigrade.motion.recording import rate_of

# Height of the lateral malleolus over stature, and its spread, of 4,082 men and 1,986 women.
MALLEOLUS_HEIGHT = {"male": 0.0415, "female": 0.0385}
MALLEOLUS_SPREAD = 0.005  # [m] standard deviation of this height
SHOE_SPREAD = 0.025  # [m] standard deviation of sole thickness
# [m] range of the ankle height relative to a bare foot on the floor
ANKLE_DEVIATION = (-0.03, 0.07)
# Criteria of a flat foot for heel and forefoot.
MAX_FLAT_HEIGHT = 0.020  # [m] maximum height above the lowest position
MAX_FLAT_SPEED_RATIO = 0.07  # [1] maximum vertical speed relative to its peak …
MIN_FLAT_SPEED = 0.05  # [m/s] … but at least this
MAX_LEVEL_DEVIATION = 0.004  # [m] maximum deviation from the median of such frames
HEIGHT_CUTOFF = 10.0  # [Hz] low-pass of marker heights before differentiation
# Marker errors of a centimetre pitch a foot by 5° and tilt it by 12°; more than twice as much, as
# in equinus, is not flat.
MAX_PITCH = np.deg2rad(12)  # [rad] maximum pitch of a flat foot
MAX_TILT = np.deg2rad(25)  # [rad] maximum tilt of a flat foot
MIN_FLAT_FRAMES = 3  # [1] minimum number of frames with a flat foot
MAX_FLAT_FRAMES = 10  # [1] maximum number of frames used
MAX_LOADED_HEIGHT = 0.003  # [m] maximum height above the lowest point of a loaded region
MAX_SOLE_DEVIATION = 0.015  # [m] maximum deviation of flesh, toe spring and worn soles from flat
MIN_NOTED_THICKNESS = 0.010  # [m] sole thickness that is reported


@dataclass(frozen=True)
class FlatFeet:
    """A person with feet that stand flat."""

    human: Human  #: The person, with the height of the ankles and the soles found
    places: tuple[Attachment, ...]  #: Attachment of each marker
    grounded: bool = False  #: Whether a foot stood flat on the ground in some frames
    #: Height above the ground at which the feet stand, beyond what soles explain; else zero [m]
    above_ground: float = 0.0
    notes: tuple[str, ...] = ()  #: Notes for the user, one sentence each


def set_flat(
    human: Human,
    places: Sequence[Attachment],
    samples: Float[Array, "n_frames n_markers 3"],
    still: Float[Array, "n_still n_markers 3"],
    rate: float,
    start: Float[Array, " nq"],
    *,
    ground: Ground = LEVEL_GROUND,
) -> FlatFeet:
    """Return the person and marker places with feet that stand flat on the ground.

    Feet that never stand flat, or without markers that show it, are unchanged.

    Args:
        samples: Marker positions, in the order of ``places`` [m]; NaN if not visible.
        still: Marker positions in some frames of a standing trial, on level ground.
        rate: Frames per second of ``samples`` [Hz].
        start: A configuration near some frame, to solve the poses from.
    """
    n, every = len(samples), np.concatenate([samples, still])
    floor = Ground(height=0.0 if ground.slope or ground.steps else ground.height)
    above = np.concatenate([ground.above(samples), floor.above(still)])
    flat = {side: _flat_frames(human, places, above, n, rate, side) for side in SIDES}
    chosen = np.unique(np.concatenate(list(flat.values()))).astype(int)
    if not len(chosen):
        return FlatFeet(human, tuple(places))
    poses, markers = _poses(PointSet.of(human, places), every[chosen], start)
    states = [(state.rotations, state.origins) for state in sweep(human, poses)]
    rotations, origins = (np.array(column) for column in zip(*states, strict=True))
    moving = (chosen < n)[:, None]
    turned = np.where(moving[..., None], ground.to_world, np.eye(3))  # into axes of the ground
    rotations = np.einsum("fji,fbjk->fbik", turned, rotations)
    found: dict[int, np.ndarray] = {}
    heights: dict[str, float] = {}
    notes: list[str] = []
    for side in SIDES:
        own, foot = np.isin(chosen, flat[side]), human.body(f"foot_{side}")
        if not own.any():
            continue
        at, up = origins[own, foot], rotations[own, foot][:, 2].mean(axis=0)
        pitch, tilt = np.arctan2(np.abs(up[:2]), up[2])
        if pitch > MAX_PITCH or tilt > MAX_TILT:
            notes.append(
                f"the {SIDE_NAMES[side]} foot rests {np.rad2deg(pitch):.0f}° pitched and "
                f"{np.rad2deg(tilt):.0f}° tilted: it is not assumed to stand flat."
            )
            continue
        height = np.where(moving[own], ground.above(at), floor.above(at))[:, 2]
        heights[side] = float(np.median(height))
        level = _levelled(human, side, rotations[own, human.body(f"tibia_{side}")], poses[own])
        ankle = np.einsum("fji,fj->fi", turned[own], at)
        seen = np.einsum("fji,fmj->fmi", turned[own], markers[own])
        for i, place in enumerate(places):
            if place.body in _bodies(human, side):
                found[i] = np.einsum("fji,fj->fi", level, seen[:, i] - ankle).mean(axis=0)
    usual = _usual_ankle(human)
    shod = _on_soles(human, heights, usual, notes)
    moved = _moved(human, shod or human, places, found)
    above = 0.0 if shod or not heights else float(np.mean(list(heights.values()))) - usual
    return FlatFeet(shod or human, moved, shod is not None, above, tuple(notes))


def _moved(
    human: Human, shod: Human, places: Sequence[Attachment], found: Mapping[int, np.ndarray]
) -> tuple[Attachment, ...]:
    """Return the places of markers on new feet: where they were found, else as on the old feet."""
    return tuple(
        replace(p, position=found.get(i, _in_foot(human, p)) - _offset(shod, p.body))
        if p.body in _bodies(human, p.body[-1])
        else p
        for i, p in enumerate(places)
    )


def _poses(
    points: PointSet, markers: Float[Array, "n n_markers 3"], pose: Float[Array, " nq"]
) -> tuple[Float[Array, "n nq"], Float[Array, "n n_markers 3"]]:
    """Return poses that fit markers, each started from the one before, and the points there."""
    solver, poses = InverseKinematics(points), []
    for frame in markers:
        pose = solver.solve(frame, pose).qpos
        poses.append(pose)
    return np.array(poses), points.path(np.array(poses))


def _on_soles(
    human: Human, heights: Mapping[str, float], usual: float, notes: list[str]
) -> Human | None:
    """Return the person with ankles at their heights in stance, by soles of any thickness.

    None if no foot stands flat, or the ankles are not at the height of a foot on the ground.

    Args:
        heights: Height of the ankle in stance by side [m].
        usual: That on bare feet [m].
    """
    if not heights:
        return None
    mean = float(np.mean(list(heights.values())))
    excess = mean - usual
    if not ANKLE_DEVIATION[0] < excess < ANKLE_DEVIATION[1]:
        notes.append(
            f"the ankles of standing feet are {1e3 * mean:.0f} mm above the ground of the file: "
            "the floor is elsewhere, and the soles were left unchanged."
        )
        return None
    share = MALLEOLUS_SPREAD**2 / (MALLEOLUS_SPREAD**2 + SHOE_SPREAD**2)
    bare = usual + (excess if excess < 0 else share * excess)
    thick = {side: heights.get(side, mean) - bare for side in SIDES}
    shod = _with_ankles(human, bare, thick)
    thickness = float(np.mean(list(thick.values())))
    if thickness > MIN_NOTED_THICKNESS:
        notes.append(
            f"the ankles stand {1e3 * thickness:.0f} mm higher than on bare feet; soles of that "
            "thickness were added."
        )
    return shod


def with_resting_soles(
    human: Human,
    places: Sequence[Attachment],
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    *,
    ground: Ground = LEVEL_GROUND,
) -> Human:
    """Return the person with heel, ball and toes on the ground when they carry load.

    Each region of each sole is moved by its median height while it is the lowest of its foot,
    because shoe toes curve upwards and flesh under a heel deforms. Toes without a marker move with
    the ball.

    Args:
        human: The person, with feet that stand flat.
        time: Time of each frame [s].
    """
    contact = sole_paths(human, qpos, ground)
    rate = rate_of(time)
    rests = find_rests(contact, rate, way=moving_ground(time, *contact.ends))
    seen = {p.body for p in places}
    offsets: dict[str, float] = {}
    for side in SIDES:
        lowest = contact.lowest(side)
        shift = {}
        for region in ("heel", "ball", "toes"):
            height = contact.lowest(side, region)
            carries = np.zeros(len(time), dtype=bool)
            for rest in rests:
                if (rest.side, rest.region) == (side, region):
                    carries[rest.start : rest.stop] = True
            carries &= height < lowest + MAX_LOADED_HEIGHT
            if carries.sum() >= MIN_FLAT_FRAMES:
                shift[region] = float(
                    np.clip(-np.median(height[carries]), -MAX_SOLE_DEVIATION, MAX_SOLE_DEVIATION)
                )
        if not seen & {f"{part}_{side}" for part in TOE_JOINTS}:
            shift["toes"] = shift.get("ball", 0.0)
        for region, by in shift.items():
            for i in contact.of(side, region):
                offsets[human.contact_points[i][0]] = by
    return human.with_soles(offsets)


def _flat_frames(
    human: Human,
    places: Sequence[Attachment],
    samples: Float[Array, "n_all n_markers 3"],
    moving: int,
    rate: float,
    side: str,
) -> np.ndarray:
    """Return some frames with heel and forefoot at rest; frames after ``moving`` are static."""
    ahead = {
        i: float(_in_foot(human, p)[0])
        for i, p in enumerate(places)
        if p.body in _bodies(human, side)
    }
    toes = tuple(f"{part}_{side}" for part in TOE_JOINTS)
    length = human.dimensions.foot_length
    hind = [i for i, x in ahead.items() if x < 0.1 * length]
    fore = [i for i, x in ahead.items() if x > 0.25 * length and places[i].body not in toes]
    fore = fore or [i for i, x in ahead.items() if x > 0.25 * length]
    if not hind or not fore:
        return np.empty(0, dtype=int)
    heights = [_height(samples[:, group, 2], moving) for group in (hind, fore)]
    resting = np.ones(len(samples), dtype=bool)
    for height in heights:
        speed = np.abs(_speed(height, moving, rate))
        calm = max(MIN_FLAT_SPEED, MAX_FLAT_SPEED_RATIO * float(np.nanmax(speed, initial=0.0)))
        resting &= (speed < calm) & (height < MAX_FLAT_HEIGHT)
    if not resting.any():
        return np.empty(0, dtype=int)
    flat = resting
    for height, share in zip(heights, (25, 50), strict=True):  # the heel rises slowly
        flat = flat & (np.abs(height - np.percentile(height[resting], share)) < MAX_LEVEL_DEVIATION)
    frames = np.flatnonzero(flat)
    if len(frames) < MIN_FLAT_FRAMES:
        return np.empty(0, dtype=int)
    return frames[spread(len(frames), MAX_FLAT_FRAMES)]


def _height(z: Float[Array, "n_all n_group"], moving: int) -> np.ndarray:
    """Return the mean height of markers above their lowest positions [m]."""
    z = z[:, np.isfinite(z[:moving]).mean(axis=0) > 0.3]
    above, seen = np.full(len(z), np.nan), np.isfinite(z).any(axis=1)
    if z.shape[1]:
        above[seen] = np.nanmean((z - np.nanpercentile(z[:moving], 5, axis=0))[seen], axis=1)
    return above


def _speed(height: np.ndarray, moving: int, rate: float) -> np.ndarray:
    speed = np.zeros(len(height))
    if moving < 3:
        return speed
    path = height[:moving]
    if moving > 15 and rate > 2.5 * HEIGHT_CUTOFF:
        path = lowpass(np.arange(moving) / rate, path, cutoff=HEIGHT_CUTOFF)
    speed[:moving] = np.gradient(path) * rate
    return np.where(np.isfinite(height), speed, np.nan)


def _usual_ankle(human: Human) -> float:
    """Return the usual height of the ankle joint centre above a bare sole [m]."""
    marker, foot = attachments(human)["ankle_lateral_r"], human.body("foot_r")
    above = float(marker.position[2] - human.model.body_pos[foot, 2])
    return MALLEOLUS_HEIGHT[human.sex] * human.height - above


def _with_ankles(human: Human, ankle: float, thick: dict[str, float]) -> Human:
    """Return the person with given ankle height and sole thickness; the head compensates."""
    d = human.dimensions
    lengths = {n: getattr(d, n) for n in d.names() if n != "head"} | {"ankle_height": ankle}
    bare = Human.create(
        human.height, human.mass, human.sex, human.joints, human.feet, lengths=lengths
    )
    return bare.with_soles({name: -thick[side] for name, side, _ in bare.contact_points})


def _levelled(
    human: Human, side: str, tibia: Float[Array, "n_frames 3 3"], poses: Float[Array, "n_frames nq"]
) -> Float[Array, "n_frames 3 3"]:
    """Return the rotations of a foot levelled by ankle and subtalar joint.

    Two joints align one direction with the vertical; a third keeps its angle. The heading of the
    foot therefore follows the joints, as the poses can.
    """
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

    body = next(b for b in human.skeleton.bodies if b.name == f"foot_{side}")
    axes = [hinge.axis for hinge in body.hinges]
    columns = [7 + human.hinge(hinge.name) for hinge in body.hinges]

    def rotation(shank: np.ndarray, angles: np.ndarray) -> np.ndarray:
        for axis, angle in zip(axes, angles, strict=True):
            shank = shank @ Rotation.from_rotvec(angle * axis).as_matrix()
        return shank

    result = []
    for shank, pose in zip(tibia, poses, strict=True):
        angles = pose[columns]

        def tilt(first: np.ndarray, shank=shank, angles=angles) -> np.ndarray:
            return rotation(shank, np.concatenate([first, angles[2:]]))[2, :2]

        level = least_squares(tilt, angles[:2]).x
        result.append(rotation(shank, np.concatenate([level, angles[2:]])))
    return np.array(result)


def _bodies(human: Human, side: str) -> tuple[str, ...]:
    """Return the bodies of a foot."""
    heads = ("foot_", "toes_", "heel_", "medial_", "lateral_")
    return tuple(n for n in human.body_names if n.startswith(heads) and n.endswith(f"_{side}"))


def _in_foot(human: Human, place: Attachment) -> Float[Array, "3"]:
    """Return an attachment on any body of a foot in the frame of the foot, zero pose [m]."""
    return place.position + _offset(human, place.body)


def _offset(human: Human, body: str) -> Float[Array, "3"]:
    origins = human.skeleton.origins
    return origins[body] - origins[f"foot_{body[-1]}"]
