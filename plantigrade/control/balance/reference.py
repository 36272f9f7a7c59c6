"""References of balance: a posture held, also on a platform that moves, or a motion."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.control.balance.postures import N_ITERATIONS, posture_step
from plantigrade.control.gait.loads import LoadSettings
from plantigrade.control.gait.support import inside
from plantigrade.kinematics.state import BodyState, PointSet, sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks.point import axis_error
from plantigrade.world import SimulatedWorld

PLATFORM = "platform"  # name of the body that moves in worlds that have one


@dataclass(frozen=True, eq=False)
class ReferenceState:
    """The state of a reference at one time."""

    qpos: Float[Array, " nq"]  #: Configuration
    qvel: Float[Array, " nv"]  #: Its velocity
    qacc: Float[Array, " nv"]  #: Its acceleration
    com: Float[Array, " 3"]  #: Centre of mass [m]
    com_velocity: Float[Array, " 3"]  #: Its velocity [m/s]
    com_acceleration: Float[Array, " 3"]  #: Its acceleration [m/s²]
    spheres: Float[Array, "n_sites 3"]  #: Positions of the contact spheres of the feet [m]
    contact: Bool[Array, " n_sites"]  #: Which of them are to be on the ground
    force_cost: float | Float[Array, " n_sites"] = 1.0  #: Factor of the cost of the force of each

    def com_goal(
        self,
        spheres: Float[Array, "n_sites 3"],
        touching: Int[Array, " k"],
        shift: Float[Array, " 3"],
        centring: float,
        margin: float,
    ) -> Float[Array, " 3"]:
        """Return the goal of the centre of mass over the feet as they are [m].

        It moves with the spheres that are to be on the ground, stays inside what they span, and as
        far above those that touch as in the reference.

        Args:
            spheres: Positions of the spheres now [m].
            touching: Which of them touch.
            shift: Offset of the goal [m].
            centring: Part of the way from the reference to the middle of the support.
            margin: Least distance from the edge of the support [m].
        """
        own = self.contact.nonzero()[0]
        if not len(own):
            return self.com + shift
        support, share = spheres[own], np.full(len(own), 1.0 / len(own))
        goal = self.com + share @ (support - self.spheres[own])
        goal[:2] += centring * (share @ support[:, :2] - goal[:2])
        goal[:2] = inside(support[:, :2], goal[:2] + shift[:2], margin)
        on = touching[self.contact[touching]]
        rise = (spheres[on, 2] - self.spheres[on, 2]).sum() / len(on) if len(on) else 0.0
        goal[2] = self.com[2] + shift[2] + rise
        return goal


class Reference(ABC):
    """A state to follow, as a function of time.

    Attributes:
        flights: From when to when the body is in the air, by plan [s].
    """

    flights: Sequence[tuple[float, float]] = ()

    @abstractmethod
    def at(self, time: float) -> ReferenceState:
        """Return the state at a time since the start [s]."""


class PostureReference(Reference):
    """A posture that is held, on both feet."""

    def __init__(self, human: Human, qpos: Float[Array, " nq"]):
        spheres = PointSet.of(human, contact_sites(human))
        self._state = _at_rest(BodyState(human, qpos), np.zeros(human.model.nv), spheres)

    def at(self, time: float) -> ReferenceState:
        """Return the posture."""
        return self._state


def _at_rest(body: BodyState, qvel: Array, spheres: PointSet) -> ReferenceState:
    """Return a posture on both feet, without acceleration."""
    velocity = np.array(body.com_velocity) if qvel.any() else np.zeros(3)
    contact = np.ones(len(spheres), dtype=bool)
    qpos, qacc, positions = np.array(body.qpos), np.zeros(len(qvel)), body.position(spheres)
    return ReferenceState(qpos, qvel, qacc, body.com, velocity, np.zeros(3), positions, contact)


def posture_reference(world: SimulatedWorld, qpos: Float[Array, " nq"]) -> Reference:
    """Return the reference of a posture held in a world, on a platform if it has one."""
    if mujoco.mj_name2id(world.model, mujoco.mjtObj.mjOBJ_BODY, PLATFORM) < 0:
        return PostureReference(world.human, np.array(qpos))
    return PlatformReference(world, qpos)


@dataclass(frozen=True, kw_only=True)
class PlatformSettings:
    """Inverse kinematics on a platform; feet and centre of mass have a weight of 1."""

    pelvis_weight: float = 0.3
    """Weight of the orientation of the pelvis [1/rad]. With a fifth of it relative to the feet,
    as over posed feet, people fell from every plate that sways by 10°."""
    joint_weight: float = 0.1
    """Weight of every joint [1/rad]. From 0.03 to 0.3 people stand on all twelve plates of
    ``experiment moving-slope``; with 0.01, as over posed feet, on none."""


class PlatformReference(Reference):
    """A posture on a platform that moves: feet go with it, the body stays upright above them."""

    def __init__(
        self,
        world: SimulatedWorld,
        qpos: Float[Array, " nq"],
        settings: PlatformSettings | None = None,
    ):
        human, settings = world.human, settings or PlatformSettings()
        self._data, self._platform = world.data, world.model.body(PLATFORM).id
        self._start = self._body = body = BodyState(human, qpos)
        names = sorted({s.body for s in contact_sites(human)})
        self._segments = [human.body(name) for name in names]
        self._origins = PointSet(human, names, np.zeros((len(names), 3)))
        self._spheres = PointSet.of(human, contact_sites(human))
        position, rotation = self._pose()
        self._local = (body.origins[self._segments] - position) @ rotation
        self._rotation = rotation.T @ body.rotations[self._segments]
        self._com = (body.com - position) @ rotation * [1.0, 1.0, 0.0]
        self._height = body.com[2] - (position + rotation @ self._com)[2]
        self._own = np.full(human.model.nv, settings.joint_weight)
        self._own[:3], self._own[3:6] = 0.0, settings.pelvis_weight
        self._time, self._state = -1.0, _at_rest(body, np.zeros(human.model.nv), self._spheres)

    def at(self, time: float) -> ReferenceState:
        """Return the posture on the platform as it is now."""
        if time == self._time:
            return self._state
        before, elapsed = self._state.qpos, time - self._time
        position, rotation = self._pose()
        body, nv = self._body.moved_to(before), len(self._state.qvel)
        under = position + rotation @ self._com
        com = np.array([*under[:2], under[2] + self._height])
        desired = rotation @ self._rotation
        for _ in range(N_ITERATIONS):
            moved = position + self._local @ rotation.T - body.origins[self._segments]
            turned = axis_error(desired, body.rotations[self._segments])
            spins = np.vstack([body.angular_jacobian(i) for i in self._segments])
            rows = [
                Rows(body.jacobian(self._origins).reshape(-1, nv), moved.ravel()),
                Rows(spins, turned.ravel()),
                Rows(body.com_jacobian, com - body.com),
            ]
            body = body.moved_to(posture_step(body, rows, self._start.qpos, self._own))
        qvel = body.difference(before) / elapsed if self._time >= 0 else np.zeros(nv)
        self._time = time
        self._state = _at_rest(body.moved_to(body.qpos, qvel), qvel, self._spheres)
        return self._state

    def _pose(self) -> tuple[Float[Array, " 3"], Float[Array, "3 3"]]:
        """Return position and orientation of the platform."""
        rotation = self._data.xmat[self._platform].reshape(3, 3)
        return self._data.xpos[self._platform].copy(), rotation.copy()


class MotionReference(Reference):
    """A motion; before its first frame and after its last one the person stands still.

    Args:
        human: The person.
        motion: Their motion.
        contact: Which contact spheres of the feet are on the ground in each frame; those that are
            low and slow if absent.
        ground: Ground of the motion; level if absent.
        flights: From when to when the body is in the air, by plan [s].
        settings: Limits of low and slow.

    Attributes:
        force_cost: Factor of the cost of the force of every sphere in each frame.
    """

    def __init__(
        self,
        human: Human,
        motion: Motion,
        contact: Bool[Array, "n n_sites"] | None = None,
        ground: Ground | None = None,
        flights: Sequence[tuple[float, float]] = (),
        settings: LoadSettings | None = None,
    ):
        self.flights = tuple(flights)
        sites = contact_sites(human)
        points = PointSet.of(human, sites)
        states = [(s.com, s.position(points)) for s in sweep(human, motion.qpos)]
        self.motion, self.time = motion, motion.time - motion.time[0]
        self.com = np.array([com for com, _ in states])
        self.spheres = np.array([spheres for _, spheres in states])
        own = motion.qacc
        self.qacc = np.gradient(motion.qvel, self.time, axis=0) if own is None else own
        if contact is not None:
            self.contact: Array = contact
        else:
            ground, s = ground or Ground(), settings or LoadSettings()
            radius = np.array([site.radius for site in sites])
            gap = ground.gap(self.spheres) - radius
            speed = np.linalg.norm(np.gradient(self.spheres, self.time, axis=0), axis=2)
            self.contact = (gap < s.max_height + gap.min()) & (speed < s.max_speed)
        self.com_velocity = np.gradient(self.com, self.time, axis=0)
        self.com_acceleration = np.gradient(self.com_velocity, self.time, axis=0)
        self.force_cost = np.ones(self.contact.shape)

    def at(self, time: float) -> ReferenceState:
        """Return the motion at a time after its first frame [s]."""
        moves = time < self.time[-1]
        i = int(np.searchsorted(self.time, time, side="right")) - 1
        i = min(max(i, 0), len(self.time) - 2)
        first, last = float(self.time[i]), float(self.time[i + 1])
        u = min(max((time - first) / (last - first), 0.0), 1.0)

        def between(values: Array) -> Array:
            return (1 - u) * values[i] + u * values[i + 1]

        q = self.motion.qpos[i : i + 2]
        if q[0, 3:7] @ q[1, 3:7] < 0:
            q = q * np.where(np.isin(np.arange(q.shape[1]), range(3, 7)), [[1.0], [-1.0]], 1.0)
        qpos = (1 - u) * q[0] + u * q[1]
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        return ReferenceState(
            qpos,
            moves * between(self.motion.qvel),
            moves * between(self.qacc),
            between(self.com),
            moves * between(self.com_velocity),
            moves * between(self.com_acceleration),
            between(self.spheres),
            self.contact[i + 1 if u > 0.5 else i],
            self.force_cost[i + 1 if u > 0.5 else i],
        )
