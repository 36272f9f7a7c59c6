"""A synthesised motion: what the solver found, sampled at any time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Bool, Float
from plantigrade.synthesize.diagnose.post_mortem import values
from plantigrade.synthesize.problem.contact_body import ContactBody
from plantigrade.synthesize.problem.nlp import Problem
from plantigrade.synthesize.solvers.interior_point import Iterate, Multipliers
from plantigrade.synthesize.tasks.task import MotionTask
from plantigrade.synthesize.terms.terms import Contact
from plantigrade.synthesize.transcription.forces_between import FRICTION, explaining, remainder
from plantigrade.synthesize.transcription.linear_map import Transcription


@dataclass(frozen=True)
class Stage:
    """One run of a solver on the way to a motion.

    Attributes:
        name: What was solved: ``"first mesh"``, ``"refined"``, ``"IPOPT"``.
        solver: ``"interior-point"`` or ``"ipopt"``.
        nodes: Number of nodes.
        status: How it ended.
        seconds: How long it took [s].
        history: Its iterations.
    """

    name: str
    solver: str
    nodes: int
    status: str
    seconds: float
    history: tuple[Iterate, ...]


@dataclass(frozen=True)
class Sampled:
    """A motion at many times.

    Attributes:
        time: Times [s].
        qpos: MuJoCo's configuration (n_times, nq).
        qvel: MuJoCo's velocity (n_times, nv).
        qacc: MuJoCo's acceleration (n_times, nv).
        q: Coordinates in OpenSim's order (n_times, nv).
        force: Contact forces, world (n_times, n_sites, 3) [N].
        standing: Which sites the plan has on the ground (n_times, n_sites).
    """

    time: Float[Array, " n_times"]
    qpos: Float[Array, "n_times nq"]
    qvel: Float[Array, "n_times nv"]
    qacc: Float[Array, "n_times nv"]
    q: Float[Array, "n_times nv"]
    force: Float[Array, "n_times n_sites 3"]
    standing: Bool[Array, "n_times n_sites"]


@dataclass(frozen=True)
class Solution:
    """A motion from a task.

    Attributes:
        body: Who moves.
        task: What was asked.
        problem: The problem that was solved last.
        c: Coefficients.
        u: Contact forces at nodes [body weights].
        status: How the last solver ended.
        success: Whether every row of the problem is kept at the nodes; the checker has the last
            word on what is between them.
        stages: The way there.
        multipliers: For a warm start.
    """

    body: ContactBody
    task: MotionTask
    problem: Problem
    c: Float[Array, "n_coefficients nv"]
    u: Float[Array, "n_nodes n_unknowns"]
    status: str
    success: bool
    stages: tuple[Stage, ...]
    multipliers: Multipliers | None = None

    @cached_property
    def objective(self) -> float:
        """Cost of this motion; the last stage may have ended elsewhere."""
        p, u = self.problem, self.u[:, : self.problem.n_unknowns]
        states = p.states(self.c, p.nodes)
        transcription = Transcription(p)
        cost = transcription.smoothness(transcription.join(self.c, u))[0]
        for rows in p.rows:
            if rows.weight.any() or rows.gain.any():
                r = values(rows, *states, u)
                cost += float(np.sum(rows.gain * r + 0.5 * rows.weight * (r - rows.target) ** 2))
        return cost

    @property
    def friction(self) -> float:
        """Coefficient of friction of the task's ground."""
        return next((t.friction for t in self.task.terms if isinstance(t, Contact)), FRICTION)

    @property
    def iterations(self) -> int:
        """Iterations of all stages."""
        return sum(max(len(s.history) - 1, 0) for s in self.stages)

    @property
    def seconds(self) -> float:
        """Time of all stages [s]."""
        return sum(s.seconds for s in self.stages)

    def times(self, samples_per_interval: int = 10, laps: int = 1) -> Float[Array, " n_times"]:
        """Return the times of a grid finer than the nodes [s].

        Args:
            samples_per_interval: Intervals for each one between nodes.
            laps: Laps of a periodic motion; two are a stride.
        """
        ends = self.nodes
        part = np.arange(samples_per_interval) / samples_per_interval
        inner = (ends[:-1, None] + np.diff(ends)[:, None] * part).ravel()
        all_ = [inner + lap * self.task.plan.duration for lap in range(laps)]
        return np.concatenate([*all_, [laps * self.task.plan.duration]])

    @property
    def nodes(self) -> Float[Array, " n_nodes"]:
        """Times of the nodes, start and end among them [s]."""
        if self.problem.closure is None:
            return self.problem.nodes
        return np.append(self.problem.nodes, self.task.plan.duration)

    def unexplained(
        self, samples_per_interval: int = 6
    ) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Return times between the nodes [s], and the wrench there that no contact can give.

        Returns:
            Times, and the larger of force [body weights] and moment [body weight · m].
        """
        times = self.times(samples_per_interval)[:-1]
        p = self.problem
        q, v, a = p.states(self.c, times)
        sampled = self.sample(times)
        missing = remainder(self.body, q, v, a, sampled.force @ self.task.plan.to_world)
        return times, missing

    def sample(self, times: Float[Array, " n_times"]) -> Sampled:
        """Return the motion at times [s]; a periodic one goes on for ever.

        Contact forces are near the straight line from node to node, and explain the motion
        (:mod:`~plantigrade.synthesize.transcription.forces_between`).
        """
        p, span = self.problem, self.task.plan.duration
        n_sites = len(self.body.sites)
        lap = np.zeros(len(times), int)
        inside = np.asarray(times, float)
        if p.closure is not None:
            lap = np.floor(inside / span + 1e-12).astype(int)
            inside = np.clip(inside - lap * span, 0.0, np.nextafter(span, 0.0))
        q, v, a = p.states(self.c, inside)
        knots, values = p.nodes, self.u
        if p.closure is not None:
            knots = np.append(p.nodes, span)
            after = self.u[:1][:, p.closure.u_source] * p.closure.u_sign
            values = np.vstack([self.u, after])
        u = np.stack([np.interp(inside, knots, x) for x in values.T], axis=1)
        standing = (
            np.stack([self.task.plan.standing(s, inside) for s in self.body.sites], axis=1)
            if n_sites
            else np.zeros((len(times), 0), bool)
        )
        if p.closure is not None:
            k = p.closure
            for turn in range(1, int(lap.max(initial=0)) + 1):
                at = lap >= turn
                q[at] = q[at][:, k.source] * k.sign + k.shift
                v[at], a[at] = v[at][:, k.source] * k.sign, a[at][:, k.source] * k.sign
                u[at] = u[at][:, k.u_source] * k.u_sign
                standing[at] = standing[at][:, k.u_source[::3] // 3]
        qpos, qvel, qacc = self.body.symbolic.to_mujoco(q, v, a)
        force = u.reshape(len(times), n_sites, 3) * self.body.weight
        force = explaining(self.body, q, v, a, force, standing, self.friction)
        if self.task.plan.slope:
            qpos, qvel, qacc, force = _in_world(self.task.plan.to_world, qpos, qvel, qacc, force)
            q = self.body.human.to_coordinates(qpos)[1]
        return Sampled(np.asarray(times, float), qpos, qvel, qacc, q, force, standing)


def _in_world(R: Array, qpos: Array, qvel: Array, qacc: Array, force: Array):
    """Return a motion turned from the axes of the ground to world axes."""
    place, velocity, acceleration = (x.copy() for x in (qpos, qvel, qacc))
    for x in (place, velocity, acceleration):
        x[:, :3] = x[:, :3] @ R.T
    turned = Rotation.from_matrix(R) * Rotation.from_quat(qpos[:, 3:7], scalar_first=True)
    place[:, 3:7] = turned.as_quat(scalar_first=True)
    return place, velocity, acceleration, force @ R.T
