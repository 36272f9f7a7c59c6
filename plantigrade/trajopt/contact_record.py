"""A sampled motion with forces at contact sites as a Record."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.plan import ContactPlan, alternates, gait_events
from plantigrade.contact.site import PUSH_PART, ContactSite
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Condition, Limits, Record
from plantigrade.record.moving_ground import MOVED
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.sampling import Sampled


def contact_record(
    body: ContactBody,
    sampled: Sampled,
    plan: ContactPlan,
    *,
    friction: float,
    walks: bool,
    limits: Limits,
    conditions: tuple[Condition, ...] = (),
    signals: Mapping[str, Array] | None = None,
    notes: tuple[str, ...] = (),
) -> Record:
    """Return motion, joint torques, and forces where the sites touch the ground.

    Args:
        walks: Whether there are gait events.
        limits: As in :class:`~plantigrade.record.Record`, like what follows.
        signals: Further results by name.
    """
    s, human = sampled, body.human
    end = float(s.time[-1])
    # Lengths and speeds of steps are those on ground at rest.
    steps = walks and plan.motion is None and alternates(plan)
    events = gait_events(plan, end) if steps else ()
    motion = Motion(s.time, s.qpos, s.qvel, human.joint_names, s.qacc, events)
    ground = Ground.of_plan(plan, friction)
    pushes = _Pushes.of(body, s.time)
    sites = (*body.sites, *pushes.sites)
    force = np.concatenate([s.force, pushes.force], axis=1)
    moment = np.concatenate([np.zeros_like(s.force), pushes.moment], axis=1)
    point, torque = _points_and_torques(human, motion, sites, force, moment, ground)
    loaded = (np.linalg.norm(force, axis=2) + np.linalg.norm(moment, axis=2))[..., None] > 0
    if plan.motion is not None:
        notes = (*notes, MOVED)
    standing = np.zeros(force.shape[:2], bool)
    standing[:, : len(body.sites)] = s.standing
    return Record(
        human,
        motion,
        qfrc_actuator=torque,
        sites=sites,
        contact_force=force,
        contact_point=np.where(loaded, point, np.nan),
        contact_torque=moment if pushes.sites else None,
        contact_planned=standing,
        ground=ground,
        limits=limits,
        conditions=conditions,
        signals={**(signals or {}), **_added(body, s)},
        notes=notes,
    )


def _added(body: ContactBody, s: Sampled) -> dict[str, Array]:
    """Return the torque that devices add, as a signal."""
    if not body.external.devices:
        return {}
    torque = np.zeros_like(s.qvel)
    torque[:, 6:] = body.external.torque_at(body.symbolic.names[6:], s.time, s.q[:, 6:])
    return {"device.torque": torque}


@dataclass(frozen=True, eq=False)
class _Pushes:
    """Wrenches on the body as sites, whose forces are not the ground's."""

    sites: tuple[ContactSite, ...]
    force: Float[Array, "n k 3"]
    moment: Float[Array, "n k 3"]

    @classmethod
    def of(cls, body: ContactBody, times: Float[Array, " n"]) -> "_Pushes":
        """Return the wrenches of a body at times [s]."""
        acting, plan = body.external.wrenches, body.external.plan
        values, sites = np.zeros((len(times), len(acting), 6)), []
        for k, each in enumerate(acting):
            assert plan is not None
            values[:, k] = each.values(times, plan)
            name, place = f"{PUSH_PART}_{k + 1}_{each.point.body}", each.point.position
            sites.append(
                ContactSite(
                    body=each.point.body, position=place, name=name, part=PUSH_PART, measured=True
                )
            )
        return cls(tuple(sites), values[..., :3], values[..., 3:])


def _points_and_torques(
    human: Human,
    motion: Motion,
    sites: tuple[ContactSite, ...],
    force: Float[Array, "n k 3"],
    moment: Float[Array, "n k 3"],
    ground: Ground,
) -> tuple[Float[Array, "n k 3"], Float[Array, "n nv"]]:
    """Return the lowest point of every site, and what its forces leave to the joints.

    Seats are level; the lowest point of a foot is the one nearest to the ground.
    """
    points = PointSet(human, [s.body for s in sites], np.array([s.position for s in sites]))
    level = np.array([not s.side for s in sites], bool)[:, None]
    down = np.where(level, [0.0, 0.0, 1.0], ground.normal)
    down = down * np.array([s.radius for s in sites]).reshape(-1, 1)
    point, torque = np.empty(force.shape), np.empty_like(motion.qvel)
    assert motion.qacc is not None
    for f, state in enumerate(sweep(human, motion)):
        point[f] = state.position(points) - down
        torque[f] = state.inverse_dynamics(motion.qacc[f])
        for i in np.flatnonzero(force[f].any(axis=1) | moment[f].any(axis=1)):
            body = int(points.body[i])
            torque[f] -= state.generalised_force(body, point[f, i], force[f, i], moment[f, i])
    return point, torque
