"""The scene of a viewer, computed once from a record: shapes, poses, markers, forces.

Both viewers (the self-contained page and the live server) draw a :class:`Scene`.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.charts import theme
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.scene import scene_xml
from plantigrade.contact.site import PUSH_PART
from plantigrade.errors import ParameterError
from plantigrade.kinematics.unmeasured_joints import SIGNAL as ASSUMED
from plantigrade.kinematics.unmeasured_joints import bodies_of
from plantigrade.models.mjcf import read_mjcf
from plantigrade.motion.motion import resampled
from plantigrade.pages.shapes import PLATE, SCENE_OBJECT, Shape, rgb, shapes_of
from plantigrade.record import Record
from plantigrade.record.moving_ground import GroundPath
from plantigrade.record.scene_objects import PlacedObject, scene_objects_of
from plantigrade.spatial.conventions import rotation_matrix, rotation_quaternion

VIEW_RATE = 50.0  # [Hz] of drawn frames; the page interpolates between them
MAX_FRAMES = 6000  # of a page; longer motions have a lower frame rate
PLATE_REACH = 0.8
"""Distance by which a plate of ground reaches beyond the centre of mass [m]."""
PLATE_HALF_THICKNESS = 0.02
"""Half of its thickness [m]."""
CAMERA_SMOOTHING = 0.3  # [s] width of the window that smooths the ground under the camera
MIN_LOAD = 0.02  # a foot bears load above this fraction of body weight


@dataclass(frozen=True)
class Scene:
    """Everything to draw, on the drawn frames."""

    time: Float[Array, " n"]  #: Time of each drawn frame [s]
    stride: int  #: Frames of the motion from one drawn frame to the next
    ground: Ground  #: What the body stood on; its steps, relief and seats are among the shapes
    floor: Float[Array, " n"]  #: Height of the ground under the centre of mass [m]
    level: Float[Array, " n"]  #: The same, smoothed, for the camera to follow [m]
    shapes: tuple[Shape, ...]  #: Visual geoms
    positions: Float[Array, "n nbody 3"]  #: World position of each body [m]
    quats: Float[Array, "n nbody 4"]  #: World rotation of each body, ``wxyz``
    com: Float[Array, "n 3"]  #: Centre of mass [m]
    weight: float  #: Body weight [N]
    #: Positions of the reference body [m]
    reference_positions: Float[Array, "n nbody 3"] | None = None
    #: Rotations of the reference body, ``wxyz``
    reference_quats: Float[Array, "n nbody 4"] | None = None
    reference_name: str = ""  #: Name of the reference
    marker_names: tuple[str, ...] = ()  #: Names of the markers
    recorded: Float[Array, "n m 3"] | None = None  #: Recorded markers [m]; NaN where not seen
    fitted: Float[Array, "n m 3"] | None = None  #: Markers on the body [m]
    force: Float[Array, "n k 3"] | None = None  #: Ground reaction at each site, on the body [N]
    point: Float[Array, "n k 3"] | None = None  #: Where it acts [m]
    site_sides: tuple[str, ...] = ()  #: ``"l"``, ``"r"`` or ``""`` of each site
    pushes: tuple[int, ...] = ()  #: Which sites are where something pushed
    #: Ground reaction of each side, right then left, then unknown [N]
    total_force: Float[Array, "n 3 3"] | None = None
    #: Centre of pressure of each of them [m]; NaN where unloaded
    cop: Float[Array, "n 3 3"] | None = None
    #: Where each of them was estimated, not measured; None where nothing was
    estimated: Bool[Array, "n 3"] | None = None
    plate: bool = False  #: Whether the ground moved, and is a plate, the last of the bodies


def assumed_bodies(record: Record) -> set[str]:
    """Return the bodies of trunk, head and arms whose motion is assumed, not measured."""
    return bodies_of(record.human, [str(n) for n in np.ravel(record.signals.get(ASSUMED, ()))])


def build_scene(record: Record, *, forces: Record | None = None, rate: float = VIEW_RATE) -> Scene:
    """Return the scene of a record with at most ``rate`` frames per second [Hz].

    If it has no forces, those of another record may be drawn.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    check(record)
    motion = record.motion
    step = max(1, round(motion.rate / rate)) if motion.n_frames > 1 else 1
    step = max(step, -(-motion.n_frames // MAX_FRAMES))
    frames = np.arange(0, motion.n_frames, step)
    model = scene_model(record)
    positions, quats, com = poses(model, motion.qpos[frames])
    shapes, moved = shapes_of(model, assumed_bodies(record)), GroundPath.of(record)
    name = next(iter(record.references), "")
    reference = (None, None)
    if name:
        reference = poses(model, resampled(record.references[name], motion.time[frames]).qpos)[:2]
    for shape, pose in _placed(record, moved, com, frames, model.nbody):
        shapes = (*shapes, shape)
        positions, quats = _with(pose, (positions, quats))
        if reference[0] is not None:
            reference = _with(pose, reference)
    source = forces if forces is not None else record
    here = frames if source is record else nearest(source.motion.time, motion.time[frames])
    total, cop = side_forces(source, pushes=False)
    estimated = estimated_sides(source)
    markers = record.recorded_markers
    floor = height_below(record.ground, com)
    if moved is not None:
        floor = floor + moved.shift[frames, 2]
    window = CAMERA_SMOOTHING * motion.rate / step if len(frames) > 1 else 1.0  # in drawn frames
    return Scene(
        time=np.asarray(motion.time[frames], dtype=float),
        stride=step,
        ground=record.ground,
        floor=floor,
        level=gaussian_filter1d(floor, window, mode="nearest"),
        shapes=shapes,
        plate=moved is not None,
        positions=positions,
        quats=quats,
        com=com,
        weight=record.weight,
        reference_positions=reference[0],
        reference_quats=reference[1],
        reference_name=name,
        marker_names=markers.names if markers else (),
        recorded=_take(markers and markers.positions, frames),
        fitted=_take(record.fitted_markers, frames),
        force=_take(source.contact_force, here),
        point=_take(source.contact_point, here),
        site_sides=tuple(site.side for site in source.sites),
        pushes=tuple(k for k, site in enumerate(source.sites) if site.part == PUSH_PART),
        total_force=_take(total, here),
        cop=_take(cop, here),
        estimated=None if estimated is None else estimated[here],
    )


def _placed(
    record: Record,
    moved: GroundPath | None,
    com: Float[Array, "n 3"],
    frames: Int[Array, " n"],
    body: int,
) -> Iterator[tuple[Shape, tuple[Array, Array]]]:
    """Yield the shape and the poses of moving ground and of objects, numbered from ``body`` on."""
    if moved is not None:
        pose = moved.shift[frames], rotation_quaternion(moved.rotation[frames])
        yield plate_shape(com, body=body), pose
        body += 1
    for k, each in enumerate(scene_objects_of(record), start=body):
        yield object_shape(each, body=k), (each.pose[frames, :3], each.pose[frames, 3:])


def plate_shape(com: Float[Array, "n 3"], *, body: int) -> Shape:
    """Return a plate of ground that moves, under all of a way.

    Args:
        com: The centre of mass [m].
        body: Index of the plate among the bodies.
    """
    low, high = com[:, :2].min(axis=0) - PLATE_REACH, com[:, :2].max(axis=0) + PLATE_REACH
    size = np.array([*(high - low) / 2, PLATE_HALF_THICKNESS])
    middle, straight = (
        np.array([*(high + low) / 2, -PLATE_HALF_THICKNESS]),
        np.array([1.0, 0.0, 0.0, 0.0]),
    )
    return Shape("box", size, middle, straight, rgb(theme.FLOOR), body, "ground", name=PLATE)


def object_shape(placed: PlacedObject, *, body: int) -> Shape:
    """Return the shape of a scene object, as a body of its own."""
    shown, size = placed.scene_object, np.array(placed.scene_object.size)
    middle, straight = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    wood, name = rgb(theme.SCENE_OBJECT), f"{SCENE_OBJECT}_{shown.name}"
    return Shape(shown.kind, size, middle, straight, wood, body, "", name=name)


def _with(pose: tuple[Array, Array], bodies: tuple) -> tuple[Array, Array]:
    """Return positions and rotations of the bodies, with those of another one last."""
    first, second = (np.concatenate([b, p[:, None]], 1) for b, p in zip(bodies, pose, strict=True))
    return first, second


def estimated_sides(record: Record) -> Bool[Array, "n 3"] | None:
    """Return where the force right, left and of no side was estimated; None where nothing was."""
    measured = record.signals.get("forces.measured")
    return (
        None
        if measured is None
        else np.column_stack([~measured, np.ones(len(measured), dtype=bool)])
    )


def scene_model(record: Record) -> mujoco.MjModel:
    """Return the body and its ground as a MuJoCo model; seats that move are objects beside it."""
    still = record.ground.at_rest
    return read_mjcf(mujoco.MjModel.from_xml_string, scene_xml(record.human, still))


def check(record: Record) -> None:
    """Raise unless ``record`` can be drawn.

    Raises:
        ParameterError: If it has no frame, or a configuration is not finite.
    """
    n, nq = record.motion.qpos.shape
    if n == 0:
        raise ParameterError("the motion has no frames: there is nothing to draw")
    if nq != record.human.model.nq:
        raise ParameterError(
            f"the motion has {nq} configuration entries and the person {record.human.model.nq}"
        )
    if not np.isfinite(record.motion.qpos).all():
        bad = int(np.flatnonzero(~np.isfinite(record.motion.qpos).all(axis=1))[0])
        raise ParameterError(f"configuration of frame {bad} is not finite; fill or cut the gap")


def poses(
    model: mujoco.MjModel, qpos: Float[Array, "n nq"]
) -> tuple[Float[Array, "n nbody 3"], Float[Array, "n nbody 4"], Float[Array, "n 3"]]:
    """Return world positions [m] and quaternions ``wxyz`` of all bodies, and centre of mass [m]."""
    data = mujoco.MjData(model)
    n, k = len(qpos), model.nbody
    positions, quats, com = np.empty((n, k, 3)), np.empty((n, k, 4)), np.empty((n, 3))
    moving = 1 if k > 1 else 0
    for i, q in enumerate(qpos):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        positions[i], quats[i], com[i] = data.xpos, data.xquat, data.subtree_com[moving]
    return positions, quats, com


def height_below(ground: Ground, points: Float[Array, "n 3"]) -> Float[Array, " n"]:
    """Return the height of the ground vertically below world points [m]."""
    below = points * [1.0, 1.0, 0.0]
    for _ in range(4):  # on a slope, the step below depends on the height
        below[:, 2] += (ground.under(below) - below @ ground.normal) / ground.normal[2]
    return below[:, 2]


def side_forces(
    record: Record, *, pushes: bool = True
) -> tuple[Float[Array, "n 3 3"] | None, Float[Array, "n 3 3"] | None]:
    r"""Return ground reaction and centre of pressure of each side.

    The centre of pressure is the mean of the contact points, weighted with the vertical force,
    :math:`p = \sum_i f_{z,i}\, p_i / \sum_i f_{z,i}`. A side that carries less than a fiftieth of
    body weight counts as unloaded. A force under a foot of which it is not known that it is all of
    that foot's, and of no other's (both feet on one plate), counts as of unknown side.

    Args:
        record: Whose forces.
        pushes: Whether what pushes, and is no ground, counts as of unknown side.

    Returns:
        Forces, right, left and side unknown [N], and centres of pressure [m] (NaN where unloaded);
        None twice where the record has no forces.
    """
    if record.contact_force is None:
        return None, None
    force = np.nan_to_num(record.contact_force)
    total = np.zeros((len(force), 3, 3))
    cop = np.full((len(force), 3, 3), np.nan)
    known = np.ones(force.shape[:2], bool) if record.contact_known is None else record.contact_known
    for row, side in enumerate((*SIDES, "")):
        own = np.array(
            [s.side == side and (pushes or s.part != PUSH_PART) for s in record.sites], bool
        )
        part = np.where((own & known if side else own | ~known)[..., None], force, 0.0)
        total[:, row] = part.sum(axis=1)
        if record.contact_point is None:
            continue
        point = record.contact_point
        share = np.where(np.isfinite(point).all(axis=2), np.maximum(part[..., 2], 0), 0)
        load = share.sum(axis=1)
        loaded = load > MIN_LOAD * record.weight
        mean = np.einsum("nk,nkd->nd", share, np.nan_to_num(point))
        cop[loaded, row] = mean[loaded] / load[loaded, None]
    return total, cop


def travel(com: Float[Array, "n 3"]) -> Float[Array, " 3"]:
    """Return the horizontal direction of travel; forward if the body moves less than 0.3 m."""
    way = (com[-1] - com[0]) * [1, 1, 0]
    length = np.linalg.norm(way)
    return way / length if length > 0.3 else np.array([1.0, 0.0, 0.0])


def heading_of(scene: Scene) -> float:
    """Return the mean heading of the body [rad]."""
    ahead = np.array([rotation_matrix(quat)[:2, 0] for quat in scene.quats[:, 1]]).mean(axis=0)
    way = ahead if np.linalg.norm(ahead) > 0.1 else travel(scene.com)[:2]
    return float(np.arctan2(way[1], way[0]))


def standing_height(scene: Scene) -> float:
    """Return the maximum height of the body above the ground [m]."""
    top = 0.0
    for shape in scene.shapes:
        if shape.body and not (shape.is_plate or shape.is_scene_object):
            reach = float(np.max(shape.size)) if shape.kind != "mesh" else 0.0
            top = max(top, float((scene.positions[:, shape.body, 2] - scene.floor).max()) + reach)
    return float(np.clip(top + 0.1, 0.4, 3.0))


def nearest(clock: Float[Array, " m"], time: Float[Array, " n"]) -> Int[Array, " n"]:
    """Return the index of the frame nearest to each instant."""
    return np.abs(np.searchsorted((clock[1:] + clock[:-1]) / 2, time))


def _take(array, frames):
    return None if array is None else np.asarray(array, dtype=float)[frames]
