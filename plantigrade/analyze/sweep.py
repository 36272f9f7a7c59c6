"""Kinematics and dynamics of all frames of a Record, computed by MuJoCo in one pass."""

from dataclasses import dataclass, fields, replace
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.contact.ground import Ground, Seat
from plantigrade.contact.site import contact_sites
from plantigrade.dynamics.centroid import check_motion, root_wrench_at, without_constraints
from plantigrade.errors import ParameterError
from plantigrade.record import Record
from plantigrade.record.moving_ground import GroundPath
from plantigrade.spatial.conventions import cross

STANCE_SHARE = 1e-3  # Share of body weight above which a site is in stance, if there is no plan


@dataclass(frozen=True, eq=False)
class Frames:
    """Quantities of the whole body in every frame, in world axes."""

    com: Float[Array, "n 3"]  #: Centre of mass [m]
    momentum: Float[Array, "n 6"]  #: Linear [kg m/s] and about the centre of mass [kg m²/s]
    energy: Float[Array, " n"]  #: Kinetic and potential [J]
    power: Float[Array, " n"]  #: Power of all generalised forces [W]
    position: Float[Array, "n n_bodies 3"]  #: Origins of the bodies, the world first [m]
    rotation: Float[Array, "n n_bodies 3 3"]  #: Rotations of the bodies


@dataclass(frozen=True, eq=False)
class Sweep(Frames):
    """A motion and its forces in world axes."""

    weight: float  #: Body weight [N]
    qacc: Float[Array, "n nv"]  #: Accelerations, as recorded
    force: Float[Array, "n k 3"]  #: Contact forces, zero if unknown [N]
    torque: Float[Array, "n k 3"]  #: Free moments [N m]
    #: Sites in stance, by plan or else by load
    standing: Bool[Array, "n k"]
    known: Bool[Array, " n"]  #: Frames in which all contact forces are known
    spread: Bool[Array, " k"]  #: Sites at fixed points of the body, not measured forces
    #: Required force [N] and moment about the centre of mass [N m] at the root
    root: Float[Array, "n 6"]
    #: Generalised forces from inverse dynamics [N m]; the first six entries are the residual at
    #: the root (world force [N], moment about the pelvis in body axes [N m])
    tau: Float[Array, "n nv"]
    root_force: Float[Array, "n 3"]  #: Residual force [N]
    root_moment: Float[Array, "n 3"]  #: Residual moment about the centre of mass [N m]
    point: Float[
        Array, "n k 3"
    ]  #: Lowest point of each site, or point of application of a measured force [m]
    gap: Float[Array, "n k"]  #: Height of that point above its support [m]
    #: Velocity of the material at these points, relative to moving ground [m/s]
    velocity: Float[Array, "n k 3"]
    normal: Float[Array, "n k 3"]  #: Normal of the support
    spheres: Float[Array, "n s 3"]  #: Lowest points of the contact spheres [m]
    clearance: Float[Array, "n s"]  #: Height of these points above the ground [m]
    sphere_names: tuple[str, ...]  #: Names of the contact spheres
    sphere_sides: tuple[str, ...]  #: Sides of the contact spheres


def sweep(record: Record) -> Sweep:
    """Run MuJoCo's inverse dynamics over all frames, without contacts and joint limits.

    Raises:
        ParameterError: If the motion cannot be checked: it has no accelerations, missing values,
            times that do not increase, or a site on no body.
    """
    qacc = _accelerations(record)
    motion, human, ground = record.motion, record.human, record.ground
    n, k = motion.n_frames, len(record.sites)
    force, torque, point = (
        np.nan_to_num(getattr(record, name))
        if getattr(record, name) is not None
        else np.zeros((n, k, 3))
        for name in ("contact_force", "contact_torque", "contact_point")
    )
    model = without_constraints(human)
    sites, ground_path = _Sites.of(record), GroundPath.of(record)
    frames = _inverse_dynamics(record, model, sites, ground_path, (force, torque, point))
    tau, com = frames.required - frames.contact_part, frames.com
    gap, normal = sites.support(ground, point, motion.time)
    own = frames.twist[:, sites.body]  # angular, then linear at the centre of mass of the body
    velocity = own[..., 3:] + cross(own[..., :3], point - com[:, None])
    if ground_path is not None:
        on = sites.grounded
        here = ground_path.inward(point[:, on])
        gap[:, on] = ground.gap(here)
        velocity[:, on] -= ground_path.velocity_at(point[:, on])
        normal[:, on] = (ground_path.rotation @ ground.normal)[:, None]
    for i, seat in sites.seats.items():
        velocity[:, i] -= ground.velocity(motion.time, seat)
    root_force, root_moment = root_wrench_at(tau[:, :6], motion.qpos, com)
    weight = float(model.body_subtreemass[1] * np.linalg.norm(model.opt.gravity))
    known = np.full(n, record.contact_force is not None)
    if record.contact_known is not None:
        known &= record.contact_known.all(axis=1)
    standing = record.contact_planned
    if standing is None:
        standing = np.linalg.norm(force, axis=2) > STANCE_SHARE * weight
    return Sweep(
        weight=weight,
        qacc=qacc,
        force=force,
        torque=torque,
        standing=standing & ~sites.measured,
        known=known,
        spread=~sites.measured,
        root=np.hstack(root_wrench_at(frames.required[:, :6], motion.qpos, com)),
        tau=tau,
        root_force=root_force,
        root_moment=root_moment,
        point=point,
        gap=gap,
        velocity=velocity,
        normal=normal,
        **{field.name: getattr(frames, field.name) for field in fields(Frames)},
        **_spheres(record, frames, ground_path),
    )


def seen_from_ground(record: Record, s: Sweep) -> tuple[Record, Sweep]:
    """Return a record and its sweep in axes that move with planned ground, as a task has them."""
    ground, motion = record.ground, record.motion
    if ground.motion is None:
        return record, s
    away, speed = ground.displacement(motion.time), ground.velocity(motion.time)
    qpos, qvel, momentum = motion.qpos.copy(), motion.qvel.copy(), s.momentum.copy()
    qpos[:, :3] -= away
    qvel[:, :3] -= speed
    momentum[:, :3] -= record.human.mass * speed
    place = {"position": s.position - away[:, None], "com": s.com - away, "momentum": momentum}
    return replace(record, motion=replace(motion, qpos=qpos, qvel=qvel)), replace(s, **place)


@dataclass(frozen=True, eq=False)
class _Sites:
    """The contact sites of a record; those of seats have a surface of their own."""

    body: Int[Array, " k"]
    measured: Bool[Array, " k"]
    position: Float[Array, "k 3"]
    radius: Float[Array, "k 1"]
    upward: Float[Array, "k 3"]
    seats: dict[int, Seat]  #: The surfaces that carry sites, by their index

    @classmethod
    def of(cls, record: Record) -> "_Sites":
        sites, k = record.sites, len(record.sites)
        seats = {seat.site: seat for seat in record.ground.seats}
        carriers = {i: seats[site.name] for i, site in enumerate(sites) if site.name in seats}
        upward = np.tile(record.ground.normal, (k, 1))
        for i, seat in carriers.items():
            upward[i] = seat.normal
        return cls(
            body=np.array([record.human.body(site.body) for site in sites], int),
            measured=np.array([site.measured for site in sites], bool),
            position=np.array([site.position for site in sites]).reshape(k, 3),
            radius=np.array([site.radius for site in sites])[:, None],
            upward=upward,
            seats=carriers,
        )

    @property
    def grounded(self) -> list[int]:
        """Indices of the sites that the ground itself carries."""
        return [i for i in range(len(self.body)) if i not in self.seats]

    def downward(
        self, ground: Ground, centre: Float[Array, "k 3"], turned: Float[Array, "3 3"] | None
    ) -> Float[Array, "k 3"]:
        """Return vectors from the centres of sites to their lowest points [m]."""
        if ground.uneven:  # the ground pushes at the lowest point
            down = self.radius * ground.normal_at(centre)
            seated = list(self.seats)
            down[seated] = self.radius[seated] * self.upward[seated]
            return down
        upward = self.upward.copy()
        if turned is not None:
            upward[self.grounded] = turned @ ground.normal
        return self.radius * upward

    def support(
        self, ground: Ground, point: Float[Array, "n k 3"], time: Float[Array, " n"]
    ) -> tuple[Float[Array, "n k"], Float[Array, "n k 3"]]:
        """Return the height of points above ground at rest or a seat [m], and its normal."""
        height, normal = ground.under(point), ground.normal_at(point)
        for i, seat in self.seats.items():
            height[:, i] = (ground.displacement(time, seat) + seat.position) @ seat.normal
            normal[:, i] = seat.normal
        return np.einsum("nki,ki->nk", point, self.upward) - height, normal


@dataclass(frozen=True, eq=False)
class _Dynamics(Frames):
    """Quantities that MuJoCo computes in every frame."""

    required: Float[Array, "n nv"]
    contact_part: Float[Array, "n nv"]
    twist: Float[Array, "n n_bodies 6"]


def _inverse_dynamics(
    record: Record,
    model: mujoco.MjModel,
    sites: _Sites,
    ground_path: GroundPath | None,
    contact: tuple[Float[Array, "n k 3"], ...],
) -> _Dynamics:
    """Return inverse dynamics, and the part of contacts: force, free moment, point.

    Points of sites whose force is not measured are set to their lowest points.
    """
    model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_INVDISCRETE)
    data, motion, (force, torque, point) = mujoco.MjData(model), record.motion, contact
    assert motion.qacc is not None
    n, nb, nv = motion.n_frames, model.nbody, model.nv
    required, contact_part = np.empty((n, nv)), np.zeros((n, nv))
    position, rotation, twist = np.empty((n, nb, 3)), np.empty((n, nb, 3, 3)), np.empty((n, nb, 6))
    com, momentum, energy, power = np.empty((n, 3)), np.empty((n, 6)), np.empty(n), np.empty(n)
    loaded = np.any(force != 0.0, axis=2) | np.any(torque != 0.0, axis=2)
    for f in range(n):
        data.qpos[:], data.qvel[:], data.qacc[:] = motion.qpos[f], motion.qvel[f], motion.qacc[f]
        mujoco.mj_inverse(model, data)
        mujoco.mj_subtreeVel(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        required[f], energy[f] = data.qfrc_inverse, data.energy.sum()
        power[f] = (data.qfrc_inverse + data.qfrc_passive) @ data.qvel
        position[f], rotation[f] = data.xpos, data.xmat.reshape(nb, 3, 3)
        twist[f], com[f] = data.cvel, data.subtree_com[1]
        momentum[f, :3] = model.body_subtreemass[1] * data.subtree_linvel[1]
        momentum[f, 3:] = data.subtree_angmom[1]
        if len(sites.body):
            turned = np.einsum("kij,kj->ki", rotation[f, sites.body], sites.position)
            centre = position[f, sites.body] + turned
            tilt = None if ground_path is None else ground_path.rotation[f]
            lowest = centre - sites.downward(record.ground, centre, tilt)
            point[f, ~sites.measured] = lowest[~sites.measured]
        for i in np.flatnonzero(loaded[f]):
            push, turn, at = force[f, i], torque[f, i], point[f, i]
            mujoco.mj_applyFT(model, data, push, turn, at, int(sites.body[i]), contact_part[f])
    return _Dynamics(
        com, momentum, energy, power, position, rotation, required, contact_part, twist
    )


def _spheres(record: Record, frames: Frames, ground_path: GroundPath | None) -> dict[str, Any]:
    """Return lowest points of the contact spheres, their clearance, names and sides."""
    ground, spheres = record.ground, contact_sites(record.human)
    size = np.array([s.radius for s in spheres]).reshape(-1, 1)
    body = [record.human.body(s.body) for s in spheres]
    inside = np.array([s.position for s in spheres]).reshape(-1, 3)
    turned = np.einsum("nsij,sj->nsi", frames.rotation[:, body], inside)
    centre = frames.position[:, body] + turned
    if ground_path is None:
        lowest = beneath = centre - size * ground.normal_at(centre)
    else:
        lowest = centre - size * (ground_path.rotation @ ground.normal)[:, None]
        beneath = ground_path.inward(lowest)
    return {
        "spheres": lowest,
        "clearance": ground.gap(beneath),
        "sphere_names": tuple(s.name for s in spheres),
        "sphere_sides": tuple(s.side for s in spheres),
    }


def _accelerations(record: Record) -> Float[Array, "n nv"]:
    """Return the accelerations of a record; raise if it cannot be checked."""
    motion, n = record.motion, record.motion.n_frames
    if motion.qacc is None:
        raise ParameterError("cannot check a record without accelerations (motion.qacc)")
    if n == 0 or not (np.isfinite(motion.time).all() and np.all(np.diff(motion.time) > 0)):
        raise ParameterError("a motion to check needs frames at finite, increasing times [s]")
    check_motion(record.human, motion.qpos, motion.qvel, motion.qacc)
    if record.contact_force is not None and not np.isfinite(record.contact_force).all():
        raise ParameterError("contact_force has missing values; mark them with contact_known")
    if np.any(np.abs(np.linalg.norm(motion.qpos[:, 3:7], axis=1) - 1.0) > 1e-6):
        raise ParameterError("the quaternions in qpos[:, 3:7] must have length one")
    for site in record.sites:
        if site.body not in record.human.body_names:
            known = ", ".join(record.human.body_names)
            raise ParameterError(f"{site.name}: no body {site.body!r}; there are {known}")
    return motion.qacc
