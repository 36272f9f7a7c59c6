"""What a viewer draws, taken once from a model and a record: shapes, poses, markers, forces.

Both viewers (the self-contained page and the live server) draw a :class:`Scene`.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.record import Record
from plantigrade.report.theme import side_of

VIEW_RATE = 50.0  # frames per second drawn [Hz]; between them the page interpolates
MAX_FRAMES = 6000
LOADED = 0.02  # a foot bears load above this fraction of body weight

_KINDS = {
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
    int(mujoco.mjtGeom.mjGEOM_HFIELD): "mesh",
}


@dataclass(frozen=True)
class Shape:
    """One visual geom, fixed to a body.

    Attributes:
        kind: ``"sphere"``, ``"capsule"``, ``"ellipsoid"``, ``"cylinder"``, ``"box"``, ``"mesh"``.
        size: MuJoCo's sizes: radius, half length, half axes [m].
        position: In the body's frame [m].
        quat: Rotation into the body's frame, ``wxyz``.
        colour: Red, green, blue in 0–1; None where the side's colour is to be used (sided bodies)
            or the model sets none.
        body: Index of the body.
        body_name: Its name.
        vertices: Of a mesh, in the shape's frame [m].
        faces: Of a mesh.
    """

    kind: str
    size: Float[Array, " 3"]
    position: Float[Array, " 3"]
    quat: Float[Array, " 4"]
    colour: tuple[float, float, float] | None
    body: int
    body_name: str
    vertices: Float[Array, "n_vertices 3"] | None = None
    faces: Int[Array, "n_faces 3"] | None = None

    @property
    def side(self) -> str | None:
        """``"r"``, ``"l"`` or None for the middle."""
        return side_of(self.body_name)


@dataclass(frozen=True)
class Scene:
    """Everything to draw, on the frames that are drawn.

    Attributes:
        time: Time of each drawn frame [s].
        frames: Index of each drawn frame in the record.
        shapes: Visual geoms.
        positions: World position of each body [m].
        quats: World rotation of each body, ``wxyz``.
        com: Centre of mass [m].
        weight: Body weight [N].
        reference_positions: As ``positions``, of the reference body.
        reference_quats: As ``quats``, of the reference body.
        marker_names: Names of the markers.
        recorded: Recorded markers [m]; NaN where not seen.
        fitted: Markers on the body [m].
        force: Ground reaction at each contact, on the body [N].
        point: Where it acts [m].
        contact_side: ``"l"``, ``"r"`` or ``""`` of each contact.
        total_force: Ground reaction of each side, right then left, then unknown [N].
        cop: Centre of pressure of each of them [m]; NaN where unloaded.
    """

    time: Float[Array, " n"]
    frames: Int[Array, " n"]
    shapes: tuple[Shape, ...]
    positions: Float[Array, "n nbody 3"]
    quats: Float[Array, "n nbody 4"]
    com: Float[Array, "n 3"]
    weight: float
    reference_positions: Float[Array, "n nbody 3"] | None = None
    reference_quats: Float[Array, "n nbody 4"] | None = None
    marker_names: tuple[str, ...] = ()
    recorded: Float[Array, "n m 3"] | None = None
    fitted: Float[Array, "n m 3"] | None = None
    force: Float[Array, "n k 3"] | None = None
    point: Float[Array, "n k 3"] | None = None
    contact_side: tuple[str, ...] = ()
    total_force: Float[Array, "n 3 3"] | None = None
    cop: Float[Array, "n 3 3"] | None = None


def build_scene(model: mujoco.MjModel, record: Record, *, rate: float = VIEW_RATE) -> Scene:
    """Return what to draw of ``record`` on ``model``, at most ``rate`` frames per second [Hz].

    Raises:
        ParameterError: If the record does not fit the model or has no frame.
    """
    check(model, record)
    motion = record.motion
    step = max(1, round(motion.rate / rate)) if motion.n_frames > 1 else 1
    step = max(step, -(-motion.n_frames // MAX_FRAMES))
    frames = np.arange(0, motion.n_frames, step)
    positions, quats, com = poses(model, motion.qpos[frames])
    reference = (None, None)
    if record.reference_qpos is not None:
        reference = poses(model, record.reference_qpos[frames])[:2]
    weight = body_weight(model)
    total, cop = side_forces(record, weight)
    return Scene(
        time=np.asarray(motion.time[frames], dtype=float),
        frames=frames,
        shapes=shapes_of(model),
        positions=positions,
        quats=quats,
        com=com,
        weight=weight,
        reference_positions=reference[0],
        reference_quats=reference[1],
        marker_names=record.recorded_markers.names if record.recorded_markers else (),
        recorded=_take(record.recorded_markers and record.recorded_markers.positions, frames),
        fitted=_take(record.fitted_markers, frames),
        force=_take(record.contact_force, frames),
        point=_take(record.contact_point, frames),
        contact_side=contact_sides(record),
        total_force=_take(total, frames),
        cop=_take(cop, frames),
    )


def check(model: mujoco.MjModel, record: Record) -> None:
    """Raise unless ``record`` can be drawn on ``model``.

    Raises:
        ParameterError: If sizes do not match, or a configuration is not finite.
    """
    n, nq = record.motion.qpos.shape
    if n == 0:
        raise ParameterError("the motion has no frame; there is nothing to draw")
    if nq != model.nq:
        raise ParameterError(
            f"the motion has {nq} configuration entries and the model {model.nq}; "
            "draw it on the model it was made with (model.xml of the same run)"
        )
    if not np.isfinite(record.motion.qpos).all():
        bad = int(np.flatnonzero(~np.isfinite(record.motion.qpos).all(axis=1))[0])
        raise ParameterError(f"configuration of frame {bad} is not finite; fill or cut the gap")
    arrays = {
        "reference_qpos": record.reference_qpos,
        "contact_force": record.contact_force,
        "contact_point": record.contact_point,
        "fitted_markers": record.fitted_markers,
        "recorded_markers": record.recorded_markers and record.recorded_markers.positions,
    }
    for name, array in arrays.items():
        if array is not None and len(array) != n:
            raise ParameterError(
                f"{name} has {len(array)} frames and the motion {n}; put both on one clock"
            )


def poses(
    model: mujoco.MjModel, qpos: Float[Array, "n nq"]
) -> tuple[Float[Array, "n nbody 3"], Float[Array, "n nbody 4"], Float[Array, "n 3"]]:
    """Return world positions [m] and quaternions ``wxyz`` of all bodies, and centre of mass [m]."""
    data = mujoco.MjData(model)
    positions = np.empty((len(qpos), model.nbody, 3))
    quats = np.empty((len(qpos), model.nbody, 4))
    com = np.empty((len(qpos), 3))
    moving = 1 if model.nbody > 1 else 0
    for i, q in enumerate(qpos):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        positions[i], quats[i] = data.xpos, data.xquat
        com[i] = data.subtree_com[moving]
    return positions, quats, com


def body_weight(model: mujoco.MjModel) -> float:
    """Return the weight of everything that moves [N]."""
    return float(model.body_mass[1:].sum() * np.linalg.norm(model.opt.gravity))


def contact_sides(record: Record) -> tuple[str, ...]:
    """Return the side of each contact, ``""`` where the record does not say."""
    if record.contact_force is None:
        return ()
    n = record.contact_force.shape[1]
    return tuple(record.contact_side) if len(record.contact_side) == n else ("",) * n


def side_forces(
    record: Record, weight: float
) -> tuple[Float[Array, "n 3 3"] | None, Float[Array, "n 3 3"] | None]:
    r"""Return ground reaction and centre of pressure of each side.

    The centre of pressure is the mean of the contact points, weighted with the vertical force,
    :math:`p = \sum_i f_{z,i}\, p_i / \sum_i f_{z,i}`.

    A force under a foot of which it is not known that it is all of that foot's, and of no other's
    (both feet on one plate), counts as of unknown side.

    Args:
        record: With contact forces.
        weight: Body weight [N]; below a fiftieth of it a side counts as unloaded.

    Returns:
        Forces, right, left and side unknown [N], and centres of pressure [m] (NaN where unloaded);
        None twice where the record has no forces.
    """
    if record.contact_force is None:
        return None, None
    sides = contact_sides(record)
    force = np.nan_to_num(record.contact_force)
    total = np.zeros((len(force), 3, 3))
    cop = np.full((len(force), 3, 3), np.nan)
    known = np.ones(force.shape[:2], bool) if record.contact_known is None else record.contact_known
    for row, side in enumerate(("r", "l", "")):
        own = np.array([s == side for s in sides], dtype=bool)
        mine = own & known if side else own | ~known
        if not mine.any():
            continue
        part = np.where(mine[..., None], force, 0.0)
        total[:, row] = part.sum(axis=1)
        if record.contact_point is None:
            continue
        point = record.contact_point
        share = np.where(np.isfinite(point).all(axis=2), np.maximum(part[..., 2], 0), 0)
        load = share.sum(axis=1)
        loaded = load > LOADED * weight
        mean = np.einsum("nk,nkd->nd", share, np.nan_to_num(point))
        cop[loaded, row] = mean[loaded] / load[loaded, None]
    return total, cop


def shapes_of(model: mujoco.MjModel) -> tuple[Shape, ...]:
    """Return the visual geoms (MuJoCo's groups 0 to 2, planes left out)."""
    shapes = []
    for g in range(model.ngeom):
        kind = _KINDS.get(int(model.geom_type[g]))
        rgba = model.geom_rgba[g]
        if model.geom_matid[g] >= 0:
            rgba = model.mat_rgba[model.geom_matid[g]]
        if kind is None or model.geom_group[g] > 2 or rgba[3] == 0:
            continue
        body = int(model.geom_bodyid[g])
        sided = side_of(model.body(body).name) is not None
        default = sided or bool(np.allclose(rgba[:3], 0.5))
        vertices, faces = _mesh(model, g) if kind == "mesh" else (None, None)
        shapes.append(
            Shape(
                kind=kind,
                size=np.array(model.geom_size[g], dtype=float),
                position=np.array(model.geom_pos[g], dtype=float),
                quat=np.array(model.geom_quat[g], dtype=float),
                colour=None if default else (float(rgba[0]), float(rgba[1]), float(rgba[2])),
                body=body,
                body_name=model.body(body).name,
                vertices=vertices,
                faces=faces,
            )
        )
    return tuple(shapes)


def foot_bodies(model: mujoco.MjModel, side: str) -> Bool[Array, " nbody"]:
    """Return which bodies belong to the foot of ``side``: all that the ankle joint moves."""
    inside = np.zeros(model.nbody, dtype=bool)
    roots = [
        int(model.jnt_bodyid[j])
        for j in range(model.njnt)
        if "ankle" in model.joint(j).name and side_of(model.joint(j).name) == side
    ]
    words = ("foot", "calc", "talus", "toe", "heel", "meta", "phal")
    for body in range(1, model.nbody):
        name = model.body(body).name
        by_name = not roots and side_of(name) == side and any(w in name.lower() for w in words)
        inside[body] = body in roots or by_name or inside[model.body_parentid[body]]
    return inside


def _mesh(model, geom):
    """Return vertices and faces of a mesh or height field, in the geom's frame."""
    if int(model.geom_type[geom]) == int(mujoco.mjtGeom.mjGEOM_MESH):
        mesh = int(model.geom_dataid[geom])
        v0, nv = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        f0, nf = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        vertices, faces = model.mesh_vert[v0 : v0 + nv], model.mesh_face[f0 : f0 + nf]
        return np.array(vertices, dtype=float), np.array(faces, dtype=int)
    field = int(model.geom_dataid[geom])
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    start = int(model.hfield_adr[field])
    half_x, half_y, height, _ = model.hfield_size[field]
    x, y = np.meshgrid(np.linspace(-half_x, half_x, columns), np.linspace(-half_y, half_y, rows))
    z = np.array(model.hfield_data[start : start + rows * columns], dtype=float) * height
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower = np.stack([corner, corner + 1, corner + columns], axis=1)
    upper = np.stack([corner + 1, corner + columns + 1, corner + columns], axis=1)
    return np.stack([x.ravel(), y.ravel(), z], axis=1), np.concatenate([lower, upper])


def _take(array, frames):
    return None if array is None else np.asarray(array, dtype=float)[frames]
