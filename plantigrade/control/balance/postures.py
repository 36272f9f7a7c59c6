"""Postures over feet that are posed, with the centre of mass over its goal."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.control.gait.tasks import TRUNK
from plantigrade.kinematics.foot_pose import SEGMENTS, FootPoser
from plantigrade.kinematics.state import BodyState, integrate
from plantigrade.models import Human
from plantigrade.spatial.conventions import about_vertical
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks.point import axis_error
from plantigrade.world import standing_on

N_ITERATIONS = 3  # Gauss-Newton steps of a frame or tick; four times as many of a first frame
MAX_STEP = 0.3  # [rad, m] greatest change of a coordinate in one of them
DAMPING = 1e-6  # of a Gauss-Newton step, by squared weights: keeps it well posed


@dataclass(frozen=True, kw_only=True)
class PostureSolverSettings:
    """Weights of inverse kinematics over posed feet."""

    ankle_weight: float = 30.0
    """Weight of the positions of the ankles [1/m]. Chosen."""
    support_weight: float = 10.0
    """Weight of orientations of feet that press, and of the centre of mass [1/rad, 1/m]. Chosen."""
    pelvis_weight: float = 2.0
    """Weight of the pelvis upright [1/rad]. Chosen."""
    joint_weight: float = 0.3
    """Weight of joint angles as in standing [1/rad]. Chosen."""
    momentum_weight: float = 3.0
    """Weight of no angular momentum over body mass, for motions that fly [s/m²]. Chosen."""


class PostureSolver:
    """Finds postures of one person over feet that are posed.

    Attributes:
        com: Centre of mass in standing [m].
        side: Side of every contact sphere.
    """

    def __init__(self, human: Human, settings: PostureSolverSettings | None = None):
        self.human, self.settings = human, settings or PostureSolverSettings()
        self._posers = [FootPoser(human, side) for side in SIDES]
        self._standing = standing_on(human, Ground())
        state = BodyState(human, self._standing)
        self.com = state.com
        self._feet = human.both("foot")
        self._ankles = np.array([state.origin(foot) for foot in self._feet])
        self._ankles[:, 2] = [poser.standing for poser in self._posers]
        ahead = [state.rotation(foot)[:2, 0] for foot in self._feet]
        self._facing = about_vertical(np.array([np.arctan2(y, x) for x, y in ahead]))
        self._hinges = [np.array([human.hinge(c) for c in p.coordinates]) for p in self._posers]
        within = np.zeros(len(human.coordinates), dtype=bool)
        within[np.concatenate(self._hinges)] = True
        self._free = np.flatnonzero(np.concatenate([np.ones(6, bool), ~within]))
        names = [name for name, _, _ in human.contact_points]
        self._order = [np.array([names.index(n) for n in p.spheres]) for p in self._posers]
        self._n_sites = len(names)
        self._spine = 6 + np.flatnonzero([c.startswith(TRUNK) for c in human.coordinates])
        self.side = np.array([name[-1] for name in names])

    def spheres_of(self, marked: Bool[Array, "n 2 n_marks"]) -> Bool[Array, "n n_sites"]:
        """Return which spheres belong to segments that press."""
        on = np.zeros((len(marked), self._n_sites), dtype=bool)
        for k, poser in enumerate(self._posers):
            own = marked[:, k]
            pressing = own[:, : len(SEGMENTS)][:, poser.segment]
            edge = np.array(["heel_back" in name for name in poser.spheres])
            tips = np.array(["toe" in name.split("phalanges")[-1] for name in poser.spheres])
            on[:, self._order[k]] = pressing | (own[:, [4]] & edge) | (own[:, [5]] & tips)
        return on

    def spheres(
        self, ankle: Float[Array, "2 3"], marked: Bool[Array, "2 n_marks"]
    ) -> Float[Array, "n_sites 3"]:
        """Return the positions of the spheres by the offset of each ankle from standing [m]."""
        goal = np.array([[*self.com[:2], self.com[2] + ankle[:, 2].min()]])
        qpos = self.path(ankle[None], marked[None], goal)
        state, out = BodyState(self.human, qpos[0]), np.zeros((self._n_sites, 3))
        for i, site in enumerate(contact_sites(self.human)):
            out[i] = state.origin(site.body) + state.rotation(site.body) @ np.array(site.position)
        return out

    def path(
        self,
        ankle: Float[Array, "n 2 3"],
        marked: Bool[Array, "n 2 n_marks"],
        goal: Float[Array, "n 3"],
        flight_rate: float = 0.0,
    ) -> Float[Array, "n nq"]:
        """Return the configuration of every frame.

        Args:
            ankle: Offset of each ankle from standing [m].
            marked: Which segments press.
            goal: Goal of the centre of mass [m].
            flight_rate: Frames per second of a motion that flies and is not to turn; 0 for one that
                may [1/s].
        """
        turns, shifts, qpos = [], [], np.tile(self._standing, (len(ankle), 1))
        for k, poser in enumerate(self._posers):
            facing = np.tile(self._facing[k], (len(ankle), 1, 1))
            pose = poser.pose(self._ankles[k] + ankle[:, k], facing, marked[:, k])
            low, high = self.human.limits[:, self._hinges[k]]
            qpos[:, 7 + self._hinges[k]] = np.clip(pose.angles, low, high)
            turns.append(pose.rotation)
            shifts.append(pose.shift)
        state, stands = BodyState(self.human, self._standing), np.any(marked, axis=2)
        within = np.concatenate(self._hinges) + 7
        for i, q in enumerate(qpos):
            before = None
            if i:
                posed, q[:] = q[within].copy(), qpos[i - 1]
                q[within], before = posed, qpos[i - 1]
            feet = self._ankles + ankle[i]
            feet[:, 2] += [shift[i] for shift in shifts]
            rotations = [turn[i] if on else None for turn, on in zip(turns, stands[i], strict=True)]
            for _ in range(N_ITERATIONS if i else 4 * N_ITERATIONS):
                state = state.moved_to(q)
                q[:] = self._improved(state, feet, rotations, goal[i], before, flight_rate)
        return qpos

    def _improved(
        self,
        state: BodyState,
        feet: Array,
        rotations: list[Array | None],
        goal: Array,
        before: Array | None,
        flight_rate: float,
    ) -> Array:
        """Return a configuration nearer to its goals, by a Gauss-Newton step.

        Args:
            state: The configuration before the step.
            feet: Positions of the ankles [m].
            rotations: Orientations of the feet; None for one in the air.
            goal: Goal of the centre of mass [m].
            before: Configuration of the frame before.
            flight_rate: As for :meth:`path`.
        """
        s, pull = self.settings, self.settings.support_weight
        origins = np.array([state.origin(foot) for foot in self._feet])
        J, _, _ = state.touched(np.array(self._feet), origins)
        rows = [Rows(J.reshape(6, -1), (feet - origins).ravel(), s.ankle_weight)]
        for foot, rotation in zip(self._feet, rotations, strict=True):
            if rotation is not None:
                turn = axis_error(rotation, state.rotation(foot))
                rows.append(Rows(state.angular_jacobian(foot), turn, pull))
        rows.append(Rows(state.com_jacobian, goal - state.com, pull))
        if before is not None and flight_rate:
            spin = state.angular_momentum_jacobian * (flight_rate / state.mass)
            rows.append(Rows(spin, -spin @ state.difference(before), s.momentum_weight))
        n = len(self.human.coordinates)
        own = np.r_[np.zeros(3), np.full(3, s.pelvis_weight), np.full(n, s.joint_weight)]
        if flight_rate:
            # With the weight of other joints the spine made up for the angular momentum of the legs
            # and bent by 90°; with that of the pelvis the trunk was thrown back at take-off.
            own[self._spine] = 2.0 * s.joint_weight
        return posture_step(state, rows, self._standing, own, self._free, MAX_STEP)


def posture_step(
    state: BodyState,
    rows: Sequence[Rows],
    rest: Float[Array, " nq"],
    own: Float[Array, " nv"],
    free: Int[Array, " k"] | slice = slice(None),
    max_step: float = np.inf,
) -> Float[Array, " nq"]:
    """Return a configuration nearer to its goals, by a Gauss-Newton step within joint limits.

    Args:
        rows: Desired changes; a weight is the root of the cost of a squared unit missed.
        rest: Configuration from which deviations cost.
        own: Root of the cost of a squared deviation of each coordinate from it.
        free: Coordinates that may change.
        max_step: Greatest change of a coordinate [rad, m].
    """
    A = np.concatenate([row.weighted for row in rows])[:, free]
    b, back = np.concatenate([row.pull for row in rows]), -state.difference(rest)
    w = own[free]
    step = np.zeros(len(back))
    H = A.T @ A + np.diag(w**2 + DAMPING)
    step[free] = np.linalg.solve(H, A.T @ b + w**2 * back[free])
    q = integrate(state.model, state.qpos, np.clip(step, -max_step, max_step))
    q[7:] = np.clip(q[7:], *state.human.limits)
    return q


def velocities_of(human: Human, qpos: Float[Array, "n nq"], rate: float) -> Float[Array, "n nv"]:
    """Return the velocities of configurations that follow at a rate [1/s]."""
    state = BodyState(human, qpos[0])
    steps = np.array(
        [state.moved_to(b).difference(a) for a, b in zip(qpos[:-1], qpos[1:], strict=True)]
    )
    ends = np.vstack([steps[:1], steps, steps[-1:]])
    return rate * 0.5 * (ends[:-1] + ends[1:])
