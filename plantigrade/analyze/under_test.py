"""What a motion must bring to be checked: states, contact forces, the plan of contact, limits.

Nothing here knows how the motion was made. A motion comes from any engine, or from a run folder
that somebody else wrote (:func:`motion_of_run`); the model is the compiled MuJoCo model itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import ParameterError
from plantigrade.record.folder import read_run
from plantigrade.record.record import Record

SPHERE = "contact_"
"""What the names of the geoms begin with that must not sink into the ground."""

_MATCH = 0.01  # a recorded point of contact this near to a sphere is the sphere's [m]
_CARRIES = 1e-3  # a contact with less of the body weight is taken not to stand


@dataclass(frozen=True, eq=False)
class ContactSite:
    """A sphere (or point) of a body that may carry force at its lowest point.

    The lowest point is ``radius`` below the centre, against the normal of what it stands on.

    Attributes:
        name: Its name: ``"heel_back_medial_r"``.
        side: ``"r"`` or ``"l"``; empty for a support that is no foot (a seat): it counts in the
            balance of forces, not for the feet.
        body: Name of the body that carries the force and stands still with the site.
        position: Centre in that body's frame [m].
        radius: Radius [m]; zero for a point.
        height: Height of what it stands on, along the normal, constant or of every frame [m];
            None: of the ground.
        normal: Normal of what it stands on; None: of the ground.
    """

    name: str
    side: str
    body: str
    position: tuple[float, ...]
    radius: float = 0.0
    height: float | Float[Array, " n_frames"] | None = None
    normal: tuple[float, ...] | None = None

    def __post_init__(self):
        """Refuse what is no place."""
        object.__setattr__(self, "position", tuple(float(x) for x in self.position))
        if len(self.position) != 3 or not np.isfinite(self.position).all():
            raise ParameterError(f"{self.name} needs three finite numbers [m], not {self.position}")
        if not 0.0 <= self.radius < np.inf:
            raise ParameterError(f"{self.name}: radius={self.radius} [m] must be zero or more")
        if self.side not in ("r", "l", ""):
            raise ParameterError(f"{self.name}: side={self.side!r} must be 'r', 'l' or empty")


@dataclass(frozen=True, eq=False)
class Ground:
    r"""What the feet stand on: all :math:`x` with :math:`n^T x = h(x)`.

    Attributes:
        normal: Direction :math:`n` in which the ground pushes, world; made a unit vector.
        height: Height :math:`h` along the normal [m]: a number, or a function of world points
            (…, 3) that returns the heights (…) under them.
        friction: Coefficient of friction.
    """

    normal: tuple[float, ...] = (0.0, 0.0, 1.0)
    height: float | Callable[[np.ndarray], np.ndarray] = 0.0
    friction: float = 0.5

    def __post_init__(self):
        """Make the normal a unit vector."""
        object.__setattr__(self, "normal", unit(self.normal))
        if not self.friction >= 0.0:
            raise ParameterError(f"friction={self.friction} must be zero or more")

    def under(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n"]:
        """Return the height of the ground, along its normal, under points [m]."""
        if callable(self.height):
            return np.broadcast_to(np.asarray(self.height(points), float), points.shape[:-1])
        return np.full(points.shape[:-1], float(self.height))


@dataclass(frozen=True, eq=False)
class Limits:
    """What a motion must keep to; None where the model says it, or where nothing limits.

    Attributes:
        coordinate: Lower and upper limits of the hinges [rad]; None: the model's own.
        velocity: Greatest speed of the hinges, one number or one each [rad/s]; None: no limit.
        torque: Lower and upper limits of the hinges' torques [N m]; None: the model's own
            (``jnt_actfrcrange``).
        force: Greatest normal force at one site [N]; None: no limit.
    """

    coordinate: Float[Array, "2 n_hinges"] | None = None
    velocity: float | Float[Array, " n_hinges"] | None = None
    torque: Float[Array, "2 n_hinges"] | None = None
    force: float | None = None


@dataclass(frozen=True, eq=False)
class MotionUnderTest:
    """A motion, the forces said to cause it, and what was planned.

    Attributes:
        model: The compiled model: ``human.model``, or that of a run's ``model.xml``. Its first
            joint is the free joint of the body, the others are hinges.
        time: Time of each frame [s], increasing.
        qpos: Configurations.
        qvel: Velocities.
        qacc: Accelerations, from the same formula as the velocities, not from differences.
        sites: Where forces act.
        contact_force: Force on the body at each site, world [N].
        standing: Whether the plan says that the site stands.
        ground: What the feet stand on.
        limits: What joints, torques and forces must keep to.
    """

    model: "mujoco.MjModel"
    time: Float[Array, " n_frames"]
    qpos: Float[Array, "n_frames nq"]
    qvel: Float[Array, "n_frames nv"]
    qacc: Float[Array, "n_frames nv"]
    sites: tuple[ContactSite, ...]
    contact_force: Float[Array, "n_frames n_sites 3"]
    standing: Bool[Array, "n_frames n_sites"]
    ground: Ground = field(default_factory=Ground)
    limits: Limits = field(default_factory=Limits)

    def __post_init__(self):
        """Refuse arrays that do not belong together."""
        model, n, k = self.model, len(self.time), len(self.sites)
        shapes = {
            "qpos": (n, model.nq),
            "qvel": (n, model.nv),
            "qacc": (n, model.nv),
            "contact_force": (n, k, 3),
            "standing": (n, k),
        }
        if n == 0 or not (np.isfinite(self.time).all() and np.all(np.diff(self.time) > 0)):
            raise ParameterError("a motion to check needs frames at finite, increasing times [s]")
        for name, shape in shapes.items():
            values = getattr(self, name)
            if values.shape != shape:
                raise ParameterError(f"{name} has shape {values.shape}; here it must be {shape}")
            if not np.isfinite(values).all():
                bad = ~np.isfinite(values).reshape(n, -1).all(axis=1)
                frame = int(np.flatnonzero(bad)[0])
                raise ParameterError(f"{name} has missing values (first in frame {frame})")
        hinge = int(mujoco.mjtJoint.mjJNT_HINGE)
        free = int(mujoco.mjtJoint.mjJNT_FREE)
        if model.njnt < 1 or model.jnt_type[0] != free or np.any(model.jnt_type[1:] != hinge):
            raise ParameterError("the model must be one free body with hinges and nothing else")
        if np.any(np.abs(np.linalg.norm(self.qpos[:, 3:7], axis=1) - 1.0) > 1e-6):
            raise ParameterError("the quaternions in qpos[:, 3:7] must have length one")
        for site in self.sites:
            if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, site.body) < 1:
                known = ", ".join(model.body(b).name for b in range(1, model.nbody))
                raise ParameterError(f"{site.name}: no body {site.body!r}; there are {known}")
            if isinstance(site.height, np.ndarray) and site.height.shape != (n,):
                raise ParameterError(
                    f"{site.name}: height has shape {site.height.shape}; it must be one number or "
                    f"one for each of the {n} frames"
                )
        for name, width in (("coordinate", (2, model.nv - 6)), ("torque", (2, model.nv - 6))):
            values = getattr(self.limits, name)
            if values is not None and values.shape != width:
                raise ParameterError(f"limits.{name} has shape {values.shape}, not {width}")

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the hinges, in the order of ``qpos[7:]``."""
        return tuple(self.model.joint(j).name for j in range(1, self.model.njnt))


def unit(direction: Any) -> tuple[float, ...]:
    """Return a direction as a unit vector.

    Raises:
        ParameterError: If it is no direction.
    """
    vector = np.asarray(direction, float)
    length = float(np.linalg.norm(vector))
    if vector.shape != (3,) or not (np.isfinite(length) and length > 0):
        raise ParameterError(f"a normal needs three numbers that are not all zero, not {direction}")
    return tuple(float(x) for x in vector / length)


def side_of_name(name: str) -> str:
    """Return ``"r"`` or ``"l"`` from the end of a name; empty where it says neither."""
    return name[-1] if name.endswith(("_r", "_l")) else ""


def motion_of_run(
    folder: str | Path, *, ground: Ground | None = None, limits: Limits | None = None
) -> MotionUnderTest:
    """Return the motion of a run folder, from ``model.xml`` and ``motion.npz`` alone.

    Args:
        folder: The run folder.
        ground: What the feet stood on; level, with the ``friction`` among the run's settings, if
            not given.
        limits: What was to be kept to; the model's own limits if not given.

    Raises:
        FileError: If the folder is not a whole run folder.
        ParameterError: As in :func:`motion_of_record`.
    """
    model_xml, record, metrics = read_run(folder)
    if ground is None:
        settings = metrics.get("settings")
        friction = settings.get("friction") if isinstance(settings, dict) else None
        ground = Ground(friction=float(friction)) if friction is not None else Ground()
    model = mujoco.MjModel.from_xml_string(model_xml)
    return motion_of_record(model, record, ground=ground, limits=limits)


def motion_of_record(
    model: "mujoco.MjModel",
    record: Record,
    *,
    ground: Ground | None = None,
    limits: Limits | None = None,
    standing: Bool[Array, "n_frames n_contacts"] | None = None,
) -> MotionUnderTest:
    """Return the motion of a Record as something to check.

    A Record says where forces acted in the world, on which side and segment. Each contact is
    found again on the body: as the contact sphere of its segment (or of a neighbour) whose lowest
    point it is. A contact that never carries anything is left out.

    Args:
        model: The model of the run.
        record: What happened; needs accelerations, and points where there are forces.
        ground: What the feet stood on; level if not given.
        limits: What was to be kept to; the model's own limits if not given.
        standing: Which contact was planned to stand when; where it carries force, if not given.

    Raises:
        ParameterError: If something is missing, or a contact is on no contact sphere.
    """
    motion = record.motion
    ground = ground or Ground()
    if motion.qacc is None:
        raise ParameterError("the record has no accelerations (qacc), so nothing can be checked")
    n = motion.n_frames
    recorded = record.contact_force
    force = np.zeros((n, 0, 3)) if recorded is None else np.nan_to_num(recorded)
    recorded = record.contact_point
    point = np.full(force.shape, np.nan) if recorded is None else recorded
    weight = float(model.body_subtreemass[1] * np.linalg.norm(model.opt.gravity))
    carrying = np.linalg.norm(force, axis=2) > _CARRIES * weight
    stands = carrying if standing is None else standing
    spheres = _spheres(model, motion.qpos, ground)
    sites, kept = [], []
    for k in range(force.shape[1]):
        side = record.contact_side[k] if k < len(record.contact_side) else ""
        segment = record.contact_segment[k] if k < len(record.contact_segment) else ""
        carries = np.linalg.norm(force[:, k], axis=1) > 0
        known = carries & np.isfinite(point[:, k]).all(axis=1)
        if np.any(carries & ~known & stands[:, k]):
            frame = int(np.flatnonzero(carries & ~known & stands[:, k])[0])
            raise ParameterError(f"contact {k} carries force in frame {frame} but has no point")
        if not known.any() and not stands[:, k].any():
            continue
        sites.append(_site(model, k, side, segment, point[known, k], spheres, known))
        kept.append(k)
    return MotionUnderTest(
        model,
        motion.time,
        motion.qpos,
        motion.qvel,
        motion.qacc,
        tuple(sites),
        force[:, kept],
        stands[:, kept],
        ground,
        limits or Limits(),
    )


def _spheres(model: Any, qpos: np.ndarray, ground: Ground) -> dict[int, np.ndarray]:
    """Return the lowest point of every contact sphere over a motion, by geom [m]."""
    geoms = contact_geoms(model)
    data = mujoco.MjData(model)
    centre = np.empty((len(qpos), len(geoms), 3))
    for f, q in enumerate(qpos):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        centre[f] = data.geom_xpos[geoms]
    down = np.asarray(ground.normal) * model.geom_size[geoms, 0][:, None]
    return {g: centre[:, i] - down[i] for i, g in enumerate(geoms)}


def contact_geoms(model: Any) -> list[int]:
    """Return the ids of the spheres that must not sink into the ground."""
    sphere = int(mujoco.mjtGeom.mjGEOM_SPHERE)
    return [
        g
        for g in range(model.ngeom)
        if model.geom_type[g] == sphere and model.geom(g).name.startswith(SPHERE)
    ]


def _site(
    model: Any,
    k: int,
    side: str,
    segment: str,
    points: np.ndarray,
    spheres: dict[int, np.ndarray],
    frames: np.ndarray,
) -> ContactSite:
    """Return the contact sphere whose lowest point some recorded points are."""
    candidates = [g for g in spheres if not side or side_of_name(model.geom(g).name) == side]
    away = {
        g: float(np.median(np.linalg.norm(spheres[g][frames] - points, axis=1))) for g in candidates
    }
    if not len(points) or not away or min(away.values()) > _MATCH:
        nearest = f"; the nearest is {1000 * min(away.values()):.0f} mm away" if away else ""
        raise ParameterError(
            f"contact {k} ({segment or 'no segment'}, side {side or 'unknown'}) is at the lowest "
            f"point of no contact sphere{nearest}: give the sites themselves"
        )
    g = min(away, key=lambda each: away[each])
    name, body = model.geom(g).name, int(model.geom_bodyid[g])
    position = np.array(model.geom_pos[g])
    carrier = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"{segment}_{side}")
    if carrier > 0 and carrier != body and model.body_parentid[carrier] == body:
        # A sphere on the hinge of a child stands still with the child.
        position, body = position - model.body_pos[carrier], carrier
    return ContactSite(
        name.removeprefix(SPHERE),
        side,
        model.body(body).name,
        tuple(float(x) for x in position),
        float(model.geom_size[g, 0]),
    )
