r"""A recorded motion as a task: near it, and on true contact forces.

A recording says where the bones were, to a centimetre or a degree; its feet slide and sink a
little, and no force of the ground explains it exactly. The task here asks for the motion nearest to
it that forces of the ground do explain, with feet that stand where the recorded ones rested:

.. math:: \min \int \sum_j w_j (q_j - \bar q_j(t))^2 dt + \text{little for torques, jerk, forces},

under the equations of motion, contact, friction and the person's limits. So a recorded motion is
repaired, and the ground reactions come out without force plates.

When the feet touch comes from gait events and from what rests
(:mod:`plantigrade.kinematics.contacts`); the motion flows in at the start and out at the end, and
feet that stand there carry.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.centroid import centroid
from plantigrade.errors import ParameterError
from plantigrade.kinematics.contacts import ContactInterval as Contact
from plantigrade.kinematics.contacts import foot_contacts
from plantigrade.kinematics.rests import find_rests
from plantigrade.kinematics.sole_paths import SolePaths as ContactPoints
from plantigrade.kinematics.sole_paths import sole_paths as contact_points
from plantigrade.kinematics.soles import on_own_soles
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import resample
from plantigrade.synthesize.problem.assembly import Assembly
from plantigrade.synthesize.problem.contact_body import ContactBody
from plantigrade.synthesize.tasks.task import MotionTask
from plantigrade.synthesize.terms.more_terms import rows_of
from plantigrade.synthesize.terms.terms import (
    Contact as OnGround,
)
from plantigrade.synthesize.terms.terms import (
    Dynamics,
    Forces,
    Jerk,
    Limits,
    Term,
    Torque,
    Track,
)

NODES_PER_SECOND = 50.0  # nodes a second
GRID = 1.0 / NODES_PER_SECOND  # contact changes at multiples of this, so that nodes are even [s]
APART = 2 * GRID  # at least this lies between two changes of one foot [s]
BEYOND = 10.0  # a change outside the motion is put this far from it [s]
DOWN = 0.01  # a part of a foot this high is not down any more, or not yet [m]
SIDES = ("r", "l")
FACTORS = {
    **dict.fromkeys(("pelvis_tx", "pelvis_ty", "pelvis_tz"), 10.0),  # a metre is more than a radian
    "ankle_angle": 0.3,  # joints of the foot give way where the recorded foot slides or sinks
    "subtalar_angle": 0.05,
    "mtp_angle": 0.05,
}

TOES = {"mtp_angle": 10.0}  # what torque of the toes costs beside that of other joints: it is weak


@dataclass(frozen=True)
class Tracking:
    """How a motion is tracked.

    Attributes:
        weight: Weight of a coordinate's squared distance [1/(s rad²), 1/(s m²)].
        joints: Factors of single coordinates, by name without or with side.
        acceleration: Weight of the squared distance of accelerations [s³/rad²].
        push: Weight of the squared distance of the ground's force from the one that the recorded
            motion of the centre of mass asks for [1/s, forces in body weights].
        turning: The same of its moment about the centre of mass [1/(s m²)].
        torque: Weight of squared torques.
        jerk: Weight of squared jerk.
        force_size: Weight of squared contact forces.
        force_rate: Weight of their squared rates.
    """

    weight: float = 100.0
    joints: Mapping[str, float] = field(default_factory=lambda: dict(FACTORS))
    acceleration: float = 3e-5
    push: float = 1000.0
    turning: float = 1000.0
    torque: float = 0.2
    jerk: float = 1e-9
    force_size: float = 1e-3
    force_rate: float = 2e-2

    def terms(self, times: Array, q: Array, force: Array, moment: Array) -> tuple[Term, ...]:
        """Return conditions and costs of being near a motion."""
        return (
            Dynamics(),
            OnGround(),
            Limits(ranges={}),
            Track(times, q, self.weight, self.joints),
            TrackAcceleration(times, q, self.acceleration),
            TrackWrench(times, force, moment, self.push, self.turning),
            Torque(self.torque, TOES),
            Jerk(self.jerk),
            Forces(self.force_size, self.force_rate),
        )


@dataclass(frozen=True)
class TrackAcceleration:
    r"""Cost :math:`\int w \sum_j (\ddot q_j - \bar{\ddot q}_j(t))^2 dt`: as swift as recorded.

    Where feet are moved to their footprints, that is done gently.

    Attributes:
        times: Times of the motion [s].
        q: Its coordinates, in the order of the person's.
        weight: Weight of every joint [s³/rad²].
    """

    times: Float[Array, " n_times"]
    q: Float[Array, "n_times nv"]
    weight: float = 1e-4

    def put(self, a: Assembly) -> None:
        """Weigh the distance."""
        from scipy.interpolate import CubicSpline

        rows = a.rows("accelerations")
        target = CubicSpline(self.times, self.q)(a.nodes, 2)
        a.pull(rows, np.full(rows.weight.shape, 2.0 * self.weight), target)


@dataclass(frozen=True)
class TrackWrench:
    r"""Cost :math:`\int w_f |F - \bar F(t)|^2 + w_m |M - \bar M(t)|^2 dt` of the ground's wrench.

    :math:`F = \sum_k f_k` and :math:`M = \sum_k (p_k - c) \times f_k`, about the centre of mass
    :math:`c`. By Newton and Euler these are how the centre of mass accelerates and the angular
    momentum changes: what a recording shows best, while single joints may give way where the
    recorded feet slide.

    Attributes:
        times: Times [s].
        force: :math:`\bar F`, world [body weights].
        moment: :math:`\bar M`, world [body weights · m].
        weight: :math:`w_f`.
        turning: :math:`w_m`.
    """

    times: Float[Array, " n_times"]
    force: Float[Array, "n_times 3"]
    moment: Float[Array, "n_times 3"]
    weight: float = 300.0
    turning: float = 300.0

    def put(self, a: Assembly) -> None:
        """Weigh the distance."""
        import casadi as ca

        sym, points = a.body.symbolic, list(a.body.sites)
        names = tuple(f"{what} of the ground {x}" for what in ("push", "moment") for x in "xyz")

        def wrench(q, v, acc, u):
            arm, com = sym.positions(points)(q), sym.com()(q)
            f = ca.reshape(u, 3, len(points))
            turn = sum(ca.cross(arm[:, k] - com, f[:, k]) for k in range(len(points)))
            return ca.vertcat(ca.sum2(f), turn)

        rows = rows_of(a, "wrench", names, wrench, "body weights")
        both = np.hstack([self.force, self.moment])
        target = np.stack([np.interp(a.nodes, self.times, x) for x in both.T], axis=1)
        w = np.repeat([2.0 * self.weight, 2.0 * self.turning], 3)
        a.pull(rows, np.broadcast_to(w, rows.weight.shape), target)


def track(
    human: Human,
    motion: Motion,
    *,
    contacts: Sequence[Contact] | None = None,
    start: float | None = None,
    stop: float | None = None,
    tracking: Tracking | None = None,
    name: str = "track",
) -> MotionTask:
    """Return the task of moving as a motion does, as far as forces of the ground allow.

    Args:
        human: The person, on soles the motion stands on (see :func:`grounded`).
        motion: The motion, over level ground that rests at height zero.
        contacts: Which part of which foot touches when [s, as in the motion]; from the motion's
            gait events and from what rests where not given.
        start: From when [s]; its first frame if absent.
        stop: To when [s]; its last frame if absent.
        tracking: Weights.
        name: What the task is called.

    Returns:
        The task; its time zero is ``start``.

    Raises:
        ParameterError: If there are fewer frames than four between start and stop, or no foot
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
    if contacts is None:
        contacts = contacts_of(human, motion)
    steps = max(int(np.floor((stop - start) / GRID + 1e-9)), 4)
    plan = ContactPlan(steps * GRID, stances_of(human, motion, contacts, start, steps * GRID))
    if not plan.stances:
        raise ParameterError(
            "no foot touches the ground in the motion; a motion to track stands on level ground at "
            "height zero"
        )
    q = human.to_coordinates(motion.qpos)[1]
    q[:, :3] = np.unwrap(q[:, :3], axis=0)
    moved = time - start

    def guess(body: ContactBody, plan: ContactPlan, times: Array) -> Array:
        return resample(moved, q, np.clip(times, moved[0], moved[-1]))

    terms = (tracking or Tracking()).terms(moved, q, *wrenches(human, motion))
    return MotionTask(name, plan, terms, guess, nodes_per_second=NODES_PER_SECOND)


def wrenches(
    human: Human, motion: Motion
) -> tuple[Float[Array, "n_frames 3"], Float[Array, "n_frames 3"]]:
    """Return force [body weights] and moment about the centre of mass [body weights · m]."""
    qacc = motion.qacc
    if qacc is None:
        qacc = np.gradient(motion.qvel, motion.time, axis=0)
    found = centroid(human, motion.qpos, motion.qvel, qacc)
    weight = human.mass * float(np.linalg.norm(human.model.opt.gravity))
    assert found.force is not None and found.moment is not None
    return found.force / weight, found.moment / weight


def grounded(human: Human, motion: Motion) -> tuple[Human, Motion, float]:
    """Return the person on soles that touch the ground where the feet rest, and the motion on them.

    Soles are as in :func:`~plantigrade.kinematics.soles.on_own_soles`. A sphere on the hinge of the
    toes that went up would sink as the heel rises; where one had to, the whole motion is lifted
    instead, and all soles are that much thicker.

    Args:
        human: The person.
        motion: The motion, over ground at height zero.

    Returns:
        The person, the motion, and how far it was lifted [m].
    """
    points = contact_points(human, motion.qpos)
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


def contacts_of(human: Human, motion: Motion) -> tuple[Contact, ...]:
    """Return which part of which foot touches when, from gait events and from what rests.

    Where a motion has no gait events, what rests touches. What is slow but has already risen by
    :data:`DOWN`, as a heel that takes its time, touches no more.
    """
    points = contact_points(human, motion.qpos)
    rests = find_rests(points, motion.rate)
    time = np.asarray(motion.time, float)
    found = foot_contacts(time, motion.events, rests)
    seen = {c.side for c in found}
    found += tuple(
        Contact(r.side, r.region, float(time[r.start]), float(time[r.stop - 1]))
        for r in rests
        if r.side not in seen
    )
    return tuple(_settled(c, points, time) for c in found)


def _settled(contact: Contact, points: ContactPoints, time: Float[Array, " n_frames"]) -> Contact:
    """Return a contact without what is too high at its ends; heel strikes and toe offs stay."""
    index = points.of(contact.side, contact.region)
    inside = (time >= contact.start) & (time <= contact.stop)
    low = time[inside & (points.position[:, index, 2].min(axis=1) < DOWN)]
    if len(low) < 3:
        return contact
    first = contact.start if contact.region == "heel" else float(low[0])
    last = contact.stop if contact.region == "toes" else float(low[-1])
    return replace(contact, start=first, stop=last)


def stances_of(
    human: Human, motion: Motion, contacts: Sequence[Contact], start: float, duration: float
) -> tuple[Stance, ...]:
    """Return the stances of both feet, times from ``start`` on and on the grid of nodes.

    Args:
        human: The person.
        motion: The motion.
        contacts: Which part of which foot touches when [s].
        start: Time zero [s].
        duration: How long the motion that is asked for lasts [s].
    """
    first, last = float(motion.time[0]), float(motion.time[-1])
    paths = _Paths(human, motion)
    found = []
    for side in SIDES:
        for group in _groups([c for c in contacts if c.side == side]):
            times = _times(group, first, last)
            if times is None:
                continue
            snapped = _snapped(np.array(times) - start)
            if snapped[-1] <= APART or snapped[0] >= duration - APART:
                continue  # hardly begun, or nearly over
            strike, flat, heel_off, forefoot_off, off = (float(t) for t in snapped)
            nowhere = Footprint(side, (0.0, 0.0, 0.0))
            stance = Stance(nowhere, strike, flat, heel_off, forefoot_off, off)
            found.append(replace(stance, footprint=paths.footprint(side, stance, start)))
    return tuple(sorted(found, key=lambda s: (s.heel_strike, s.footprint.side)))


def _groups(contacts: list[Contact]) -> list[list[Contact]]:
    """Return contacts of one foot by stance: those that overlap belong together."""
    groups: list[list[Contact]] = []
    for c in sorted(contacts, key=lambda c: c.start):
        if groups and c.start <= max(x.stop for x in groups[-1]):
            groups[-1].append(c)
        else:
            groups.append([c])
    return groups


def _times(group: list[Contact], first: float, last: float) -> tuple[float, ...] | None:
    """Return strike, foot flat, heel off, ball off and toe off of a stance [s].

    What lies outside the recording is put far beyond its ends.
    """
    near = 1e-6 + 0.5 * GRID
    when = {
        region: (
            min(c.start for c in group if c.region == region),
            max(c.stop for c in group if c.region == region),
        )
        for region in {c.region for c in group}
    }
    begun = min(a for a, _ in when.values()) <= first + near
    open_ = max(b for _, b in when.values()) >= last - near
    if not begun and "heel" not in when and "ball" not in when:
        return None
    before, after = first - BEYOND, last + BEYOND
    strike = before if begun else min(a for a, _ in when.values())
    ball = when.get("ball", when.get("toes"))
    flat = before if begun and (ball is None or ball[0] <= first + near) else None
    if flat is None:
        flat = after if ball is None else ball[0]
    off = after if open_ else max(b for _, b in when.values())

    def end(region: str, otherwise: float) -> float:
        if region not in when:
            return otherwise
        return after if when[region][1] >= last - near else when[region][1]

    heel_off = end("heel", before if begun else flat)
    forefoot_off = end("ball", before if begun and not open_ else off)
    return strike, flat, heel_off, forefoot_off, off


def _snapped(times: Float[Array, " 5"]) -> Float[Array, " 5"]:
    """Return times on the grid, in order and apart."""
    t = np.round(times / GRID) * GRID
    for i in range(1, 5):
        t[i] = max(t[i], t[i - 1] + APART)
    late = t[4] - max(np.round(times[4] / GRID) * GRID, t[0] + 4 * APART)
    if late > 0:  # the foot leaves when it leaves: what comes before is moved forward
        t[4] -= late
        for i in (3, 2, 1):
            t[i] = min(t[i], t[i + 1] - APART)
    return np.round(t / GRID) * GRID


class _Paths:
    """Where the sites of the feet were on the ground in every frame."""

    def __init__(self, human: Human, motion: Motion):
        import mujoco

        self.sites, self.time = foot_sites(human), np.asarray(motion.time, float)
        self.flat = {side: flat_sites(human, self.sites, side) for side in SIDES}
        data, at = mujoco.MjData(human.model), [human.body(s.body) for s in self.sites]
        rho = np.array([s.radius for s in self.sites])
        local = np.array([s.position for s in self.sites])
        self.place = np.empty((len(self.time), len(self.sites), 2))
        for k, qpos in enumerate(motion.qpos):
            data.qpos[:] = qpos
            mujoco.mj_kinematics(human.model, data)
            R = data.xmat[at].reshape(-1, 3, 3)
            centre = data.xpos[at] + np.einsum("kij,kj->ki", R, local)
            heading = np.arctan2(R[:, 1, 0], R[:, 0, 0])
            along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
            left = np.stack([-along[:, 1], along[:, 0]], axis=1)
            pitch, roll = np.arcsin(R[:, 2, 0]), np.arctan2(R[:, 2, 1], R[:, 2, 2])
            roll_off = pitch[:, None] * along + roll[:, None] * left
            self.place[k] = centre[:, :2] + rho[:, None] * roll_off

    def footprint(self, side: str, stance: Stance, start: float) -> Footprint:
        """Return the footprint nearest to where a foot was while it stood [m].

        The foot flat on the ground counts if it is seen so, else whatever stands.
        """
        time = self.time - start
        flat = (time >= stance.foot_flat) & (time <= stance.heel_off)
        inner = flat.copy()
        if flat.sum() >= 8:
            quarter = flat.sum() // 4
            inner[np.flatnonzero(flat)[:quarter]] = inner[np.flatnonzero(flat)[-quarter:]] = False
        target, seen = [], []
        for k, site in enumerate(self.sites):
            if site.side != side:
                continue
            a, b = stance.interval(site.part)
            frames = inner if flat.sum() >= 3 else (time >= a) & (time <= b)
            seen.append(self.place[frames, k])
            target.append(np.tile(self.flat[side][site.name][:2], (frames.sum(), 1)))
        x, y = np.concatenate(target), np.concatenate(seen)
        if not len(x):
            nearest = int(np.argmin(np.abs(time - (stance.heel_strike + stance.toe_off) / 2)))
            names = [k for k, s in enumerate(self.sites) if s.side == side]
            x = np.array([self.flat[side][self.sites[k].name][:2] for k in names])
            y = self.place[nearest, names]
        dx, dy = x - x.mean(axis=0), y - y.mean(axis=0)
        cosine, sine = (dx * dy).sum(), (dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0]).sum()
        heading = float(np.arctan2(sine, cosine))
        c, s = np.cos(heading), np.sin(heading)
        px, py = y.mean(axis=0) - np.array([[c, -s], [s, c]]) @ x.mean(axis=0)
        return Footprint(side, (float(px), float(py), 0.0), heading)
