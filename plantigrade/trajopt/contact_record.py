"""A sampled motion with forces at contact sites as a Record."""

from collections.abc import Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.events import alternates, gait_events
from plantigrade.contact.ground import Ground
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import ContactSite
from plantigrade.kinematics.state import PointSet, sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Condition, Limits, Record
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
        body: The person.
        sampled: The motion.
        plan: Its contacts.
        friction: Coefficient of friction.
        walks: Whether there are gait events.
        limits: As in :class:`~plantigrade.record.Record`, like what follows.
        conditions: Conditions of the task.
        signals: Further results by name.
        notes: Notes for the user.
    """
    s, human = sampled, body.human
    end = float(s.time[-1])
    events = gait_events(plan, end) if walks and alternates(plan) else ()
    motion = Motion(s.time, s.qpos, s.qvel, human.joint_names, s.qacc, events)
    ground = Ground.of_plan(plan, friction)
    point, torque = _points_and_torques(human, motion, body.sites, s.force, ground)
    loaded = np.linalg.norm(s.force, axis=2, keepdims=True) > 0
    return Record(
        human,
        motion,
        qfrc_actuator=torque,
        sites=body.sites,
        contact_force=s.force,
        contact_point=np.where(loaded, point, np.nan),
        contact_planned=s.standing,
        ground=ground,
        limits=limits,
        conditions=conditions,
        signals=dict(signals or {}),
        notes=notes,
    )


def _points_and_torques(
    human: Human,
    motion: Motion,
    sites: tuple[ContactSite, ...],
    force: Float[Array, "n k 3"],
    ground: Ground,
) -> tuple[Float[Array, "n k 3"], Float[Array, "n nv"]]:
    """Return the lowest point of every site, and what its forces leave to the joints.

    Seats are level; the lowest point of a foot is the one nearest to the ground.
    """
    points = PointSet(human, [s.body for s in sites], np.array([s.position for s in sites]))
    level = np.array([not s.side for s in sites], bool)[:, None]
    down = np.where(level, [0.0, 0.0, 1.0], ground.normal)
    down = down * np.array([s.radius for s in sites]).reshape(-1, 1)
    point, torque, none = np.empty(force.shape), np.empty_like(motion.qvel), np.zeros(3)
    assert motion.qacc is not None
    for f, state in enumerate(sweep(human, motion)):
        point[f] = state.position(points) - down
        torque[f] = state.inverse_dynamics(motion.qacc[f])
        for i in np.flatnonzero(force[f].any(axis=1)):
            body = int(points.body[i])
            torque[f] -= state.generalised_force(body, point[f, i], force[f, i], none)
    return point, torque
