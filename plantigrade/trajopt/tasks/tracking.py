r"""A recorded motion as a task: near it, and on true contact forces.

A recording gives the bones to about a centimetre or a degree; its feet slide and sink a little, and
no ground reaction explains it exactly. The task finds the nearest motion that ground reactions do
explain, with feet that stand where the recorded ones rested:

.. math:: \min \int \sum_j w_j (q_j - \bar q_j(t))^2
    + w \sum_i \left(\frac{r_i - \bar r_i(t)}{\sigma_i(t)}\right)^2 dt
    + \text{little for torques, jerk, forces},

subject to the equations of motion, contact, friction and the person's limits. The :math:`r_i` are
wrenches on the feet and moments of hip, knee and ankle; the expected ones :math:`\bar r_i` with
their standard errors :math:`\sigma_i` are those of the whole recording's quadratic program
(:mod:`plantigrade.dynamics.ground_forces`), from the motion alone. It gives the forces to start
from, too. Shoulders pass the singularity of their angles as fast as a joint can
(:mod:`plantigrade.trajopt.tasks.recorded_shoulders`). When the feet touch comes from gait events
and from what rests (:mod:`plantigrade.kinematics.contacts`), in runs and jumps from the heights of
the parts of the feet; when a seat carries from :mod:`plantigrade.dynamics.loading`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.ground_forces import GroundForces, estimate_forces
from plantigrade.errors import ParameterError
from plantigrade.kinematics.fitted_soles import on_own_soles
from plantigrade.kinematics.shoulders import arms_of, counted_on
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import find_rests
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import interpolate, resample
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.tasks.recorded_flights import flying_contacts
from plantigrade.trajopt.tasks.recorded_forces import (
    expected_moments,
    expected_wrenches,
    forces_at_sites,
    seat_share,
)
from plantigrade.trajopt.tasks.recorded_seat import supports_of
from plantigrade.trajopt.tasks.recorded_shoulders import ShoulderPath
from plantigrade.trajopt.tasks.recorded_stances import (
    GRID,
    NODES_PER_SECOND,
    contacts_of,
    recorded_stances,
)
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import Contact as OnGround
from plantigrade.trajopt.terms.contact import Dynamics, Forces
from plantigrade.trajopt.terms.effort import Jerk, Torque
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.terms.term import Term
from plantigrade.trajopt.terms.tracking import (
    FootWrenches,
    JointMoments,
    PartLegs,
    Track,
    TrackAcceleration,
    TrackFeet,
    TrackMoments,
)

TRACKING_WEIGHTS = {
    **dict.fromkeys(("pelvis_tx", "pelvis_ty", "pelvis_tz"), 10.0),  # a metre is more than a radian
    "ankle_angle": 8.0,  # pitch of the foot: its range is up to 5.5° too large with 4
    "hip_flexion": 3.0,  # gives way to the ankle: its range is up to 6° too large with 1
    "subtalar_angle": 1.0,  # joints within the foot give way where the recorded one slides or sinks
    "mtp_angle": 0.5,
}

FLYING_NODES_PER_SECOND = 100.0
"""Nodes of runs and jumps [1/s]; the task of running has 120. With 60 and with 150, a run at 3 m/s
is as near to the recording (3.9°) and has the same peak of force."""

COUNTED_ROOM = 0.2
"""How far a shoulder angle that counts on past the person's limits may go beyond its path [rad];
chosen, as tracked arms are a few degrees off."""

# [1] weight of toe torque relative to other joints, because toes are weak
TOE_TORQUE_WEIGHTS = {"mtp_angle": 10.0}


@dataclass(frozen=True)
class TrackingWeights:
    """Weights of the squares of what is penalised.

    Attributes:
        weight: Weight of the distance of a coordinate [1/(s rad²), 1/(s m²)].
        joints: Factors of single coordinates, by name without or with side.
        acceleration: Weight of the distance of accelerations [s³/rad²].
        feet: Weight of the distance of the wrenches on the feet from the estimated ones, in their
            standard errors [1/s].
        moments: Weight of the distance of hip, knee and ankle moments, likewise [1/s].
        torque: Weight of torques.
        jerk: Weight of jerk.
        force_size: Weight of contact forces.
        force_rate: Weight of their rates.
    """

    weight: float = 100.0
    joints: Mapping[str, float] = field(default_factory=lambda: dict(TRACKING_WEIGHTS))
    acceleration: float = 3e-5
    feet: float = 0.6
    moments: float = 0.3
    torque: float = 0.2
    jerk: float = 1e-9
    force_size: float = 1e-3
    force_rate: float = 2e-2

    def terms(
        self,
        times: Array,
        q: Array,
        feet: FootWrenches,
        moments: JointMoments,
        counted: Mapping[str, tuple[float, float]] | None = None,
        *,
        soft_landing: bool = False,
    ) -> tuple[Term, ...]:
        """Return conditions and costs of tracking a motion with the forces expected of it.

        Feet of walks do not land at rest: they would slow down, and be down, too early. After a
        flight they land faster, and a rigid foot would stop within a step of the nodes, the harder
        the finer the mesh: with ``soft_landing`` they are at rest. ``counted`` are ranges of
        shoulder angles beyond the person's [rad].
        """
        return (
            Dynamics(),
            OnGround(soft_landing=soft_landing),
            Limits(ranges={}, counted=counted or {}),
            PartLegs(times, q),
            Track(times, q, self.weight, self.joints),
            TrackAcceleration(times, q, self.acceleration),
            TrackFeet(feet, self.feet),
            TrackMoments(moments, self.moments),
            Torque(self.torque, TOE_TORQUE_WEIGHTS),
            Jerk(self.jerk),
            Forces(self.force_size, self.force_rate),
        )


def track(
    human: Human,
    motion: Motion,
    *,
    forces: GroundForces | None = None,
    start: float | None = None,
    stop: float | None = None,
) -> MotionTask:
    """Return the task of tracking a motion as far as ground reactions allow.

    Args:
        human: The person, on soles the motion stands on (see :func:`grounded`).
        motion: The motion, over level ground at height zero.
        forces: Ground reactions on its frames, with their bands, to start from and to stay near;
            estimated from the motion if absent.
        start: From when [s], time zero of the task; the first frame if absent.
        stop: To when [s]; the last frame if absent.

    Raises:
        ParameterError: If there are fewer than four frames between start and stop, or no foot
            touches the ground.
    """
    time = np.asarray(motion.time, float)
    start = float(time[0]) if start is None else max(float(start), float(time[0]))
    stop = float(time[-1]) if stop is None else min(float(stop), float(time[-1]))
    if not (np.isfinite(motion.qpos).all() and ((time >= start) & (time <= stop)).sum() >= 4):
        raise ParameterError(
            f"{len(time)} frames from {time[0]:g} to {time[-1]:g} s hold nothing to track from "
            f"{start:g} to {stop:g} s: at least four are needed, without gaps"
        )
    forces = estimate_forces(human, motion) if forces is None else forces
    plan = _plan(human, motion, forces, start, stop)
    motion = counted_on(human, motion)
    q = human.to_coordinates(ShoulderPath().of(human, motion))[1]
    q[:, :3] = np.unwrap(q[:, :3], axis=0)
    moved = time - start

    def guess(body: ContactBody, plan: ContactPlan, times: Array) -> Array:
        return resample(moved, q, np.clip(times, moved[0], moved[-1]))

    feet = expected_wrenches(human, forces, moved)
    seat_force = seat_share(human, forces)

    def force_guess(body: ContactBody, nodes: Array, active: Array) -> Array:
        q, seated = guess(body, plan, nodes), interpolate(nodes, moved, seat_force)
        return forces_at_sites(body, feet.at(nodes), seated, q, active[:, 2::3])

    moments = expected_moments(human, motion, forces, moved)
    flies = forces.flies
    ranges = _counted(human, q)
    terms = TrackingWeights().terms(moved, q, feet, moments, ranges, soft_landing=flies)
    return MotionTask(
        "track",
        plan,
        terms,
        guess,
        nodes_per_second=FLYING_NODES_PER_SECOND if flies else NODES_PER_SECOND,
        force_guess=force_guess,
        least_nodes_per_second=NODES_PER_SECOND if flies else 0.0,
        solid=False,
    )


def _counted(human: Human, q: Float[Array, "n_frames nv"]) -> dict[str, tuple[float, float]]:
    """Return the ranges of shoulder angles that count on past the person's limits [rad]."""
    found = {}
    for i in (hinge for arm in arms_of(human) for hinge in arm):
        path, (low, high) = q[:, 6 + i], human.limits[:, i]
        if path.min() < low or path.max() > high:
            least, most = path.min() - COUNTED_ROOM, path.max() + COUNTED_ROOM
            found[human.coordinates[i]] = float(min(low, least)), float(max(high, most))
    return found


def _plan(
    human: Human, motion: Motion, forces: GroundForces, start: float, stop: float
) -> ContactPlan:
    """Return when and where feet and seat rest between two times [s]."""
    duration = max(int(np.floor((stop - start) / GRID + 1e-9)), 4) * GRID
    if forces.flies:
        contacts = flying_contacts(human, motion, forces.contacts)
    else:
        contacts = contacts_of(human, motion)
    stances = recorded_stances(human, motion, contacts, start, duration, flies=forces.flies)
    if not stances:
        raise ParameterError(
            "no foot touches the ground in the motion; a motion to track stands on level ground at "
            "height zero"
        )
    seat = supports_of(human, motion, forces.contacts, start, duration)
    return ContactPlan(duration, stances, supports=seat)


def grounded(human: Human, motion: Motion) -> tuple[Human, Motion, float]:
    """Return the person on soles that touch the ground where the feet rest, motion, and lift [m].

    Soles are as in :func:`~plantigrade.kinematics.fitted_soles.on_own_soles`. A sphere at the hinge
    of the toes that was moved up would sink as the heel rises; where this occurs, the whole motion
    is lifted instead, and all soles are that much thicker.
    """
    points = sole_paths(human, motion.qpos)
    own = on_own_soles(human, points, find_rests(points, motion.rate))
    names = [name for name, _, _ in human.contact_points]
    up = {n: float(own.model.geom(n).pos[2] - human.model.geom(n).pos[2]) for n in names}
    hinged = [n for n in names for s in foot_sites(human) if _rolls(human, n, s.name, s.body)]
    lift = max([0.0, *(up[n] for n in hinged)])
    if not lift:
        return own, motion, 0.0
    qpos = motion.qpos.copy()
    qpos[:, 2] += lift
    return human.with_soles({n: x - lift for n, x in up.items()}), replace(motion, qpos=qpos), lift


def _rolls(human: Human, geom: str, site: str, body: str) -> bool:
    """Return whether a sphere is a site that stands still with another body than its own."""
    return geom.endswith(f"_{site}") and int(human.model.geom(geom).bodyid[0]) != human.body(body)
