"""A solved task: sampled at any time, as a Record, and as the start of another one."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.batched import BatchedFunction
from plantigrade.constants import FRICTION
from plantigrade.contact.ground import Ground
from plantigrade.record import Limits as RecordLimits
from plantigrade.record import Record
from plantigrade.trajopt.contact_record import contact_record
from plantigrade.trajopt.diagnose.violations import Violation, pressing, values, violations
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.dynamics import asked_by
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.sampling import Sampled, sample
from plantigrade.trajopt.solvers.result import Iterate, Multipliers
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import Contact
from plantigrade.trajopt.terms.limits import Limits, PowerLimit
from plantigrade.trajopt.terms.solid import ARMS, GROUND, LEGS, ROW_SCALE
from plantigrade.trajopt.transcription.evaluation import Evaluation
from plantigrade.trajopt.transcription.forces_between import remainder

SAMPLES_PER_INTERVAL = 10  #: Frames of a Record between two nodes [1]
CHECKS_PER_INTERVAL = 6  #: Times between two nodes at which a motion is judged [1]; chosen

MAX_NOTED_VIOLATIONS = 5  #: Maximum number of violations in the notes [1]


@dataclass(frozen=True)
class Stage:
    """One run of a solver on the way to a motion.

    ``name`` is the solved stage (``"first try"``, ``"more nodes"``, ``"IPOPT"``), ``solver`` is
    ``"interior-point"`` or ``"ipopt"``, ``nodes`` the size of the mesh, ``status`` how it ended.
    """

    name: str
    solver: str
    nodes: int
    status: str
    seconds: float
    history: tuple[Iterate, ...]


@dataclass(frozen=True, eq=False)
class Solution:
    """A motion from a task."""

    body: ContactBody  #: The person
    task: MotionTask  #: The task
    problem: Problem  #: The problem that was solved last
    coefficients: Float[Array, "n_coefficients nv"]  #: Coefficients of the spline
    forces: Float[Array, "n_nodes n_unknowns"]  #: Contact forces at nodes [body weights]
    status: str  #: How the last solver ended
    success: bool  #: Whether every constraint is met at the nodes; the checker judges between them
    stages: tuple[Stage, ...]  #: Every run of a solver
    multipliers: Multipliers | None = None  #: For a warm start

    @cached_property
    def objective(self) -> float:
        """Cost of this motion; the last stage may have ended elsewhere."""
        evaluation = Evaluation(self.problem)
        u = self.forces[:, : self.problem.n_unknowns]
        x = evaluation.t.join(self.coefficients, u)
        return evaluation.objective(x, evaluation.values(x))

    @cached_property
    def violations(self) -> tuple[Violation, ...]:
        """Constraints that are violated at nodes, worst first."""
        return violations(self.problem, self.coefficients, self.forces)

    @property
    def iterations(self) -> int:
        """Iterations of all stages."""
        return sum(max(len(s.history) - 1, 0) for s in self.stages)

    @property
    def seconds(self) -> float:
        """Time of all stages [s]."""
        return sum(s.seconds for s in self.stages)

    @property
    def nodes(self) -> Float[Array, " n_nodes"]:
        """Times of the nodes, start and end among them [s]."""
        if self.problem.closure is None:
            return self.problem.nodes
        return np.append(self.problem.nodes, self.task.plan.duration)

    @property
    def switches(self) -> Float[Array, " n_switches"]:
        """Times at which contact changes [s]."""
        return self.task.plan.switches

    @property
    def friction(self) -> float:
        """Coefficient of friction of the task's ground."""
        found = (t.friction for t in self.task.terms if isinstance(t, Contact))
        return min(found, default=FRICTION)

    def times(
        self, samples_per_interval: int = SAMPLES_PER_INTERVAL, periods: int = 1
    ) -> Float[Array, " n_times"]:
        """Return the times of a grid finer than the nodes, over some periods [s]."""
        ends = self.nodes
        part = np.arange(samples_per_interval) / samples_per_interval
        inner = (ends[:-1, None] + np.diff(ends)[:, None] * part).ravel()
        every = [inner + k * self.task.plan.duration for k in range(periods)]
        return np.concatenate([*every, [periods * self.task.plan.duration]])

    @cached_property
    def _between(self) -> Float[Array, " n"]:
        """Times between the nodes at which the motion is judged [s]."""
        return self.times(CHECKS_PER_INTERVAL)[:-1]

    def sample(self, times: Float[Array, " n_times"]) -> Sampled:
        """Return the motion at times [s], also beyond the end of a periodic one."""
        spline = self.problem, self.coefficients, self.forces
        return sample(self.body, self.task.plan, *spline, times, self.friction)

    def unexplained(self) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Return times between the nodes [s], and the wrench there that no contact can provide.

        It is the larger of force [body weights] and moment [body weight · m].
        """
        times = self._between
        q, v, a = self.problem.states(self.coefficients, times)
        force = self.sample(times).force @ self.task.plan.to_world
        return times, remainder(self.body, q, v, a, force, times)

    def overloaded(self) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Return times between the nodes [s], and the largest use of a joint's limits there.

        They are those of torque, speed and power.

        A use of 1 is the limit; at nodes the solver keeps it.
        """
        times, body = self._between, self.body
        limit, speed = self.limits.torque, self.limits.velocity
        if limit is None or speed is None or not self._limited:
            return times, np.zeros(len(times))
        states = self.problem.states(self.coefficients, times)
        force = (self.sample(times).force @ self.task.plan.to_world).reshape(len(times), -1)
        _, tau = asked_by(body, *states, force / body.weight, times)
        with np.errstate(divide="ignore", invalid="ignore"):
            use = np.where(tau > 0, tau / limit[1], tau / limit[0])
        use = np.nan_to_num(use, posinf=0.0, neginf=0.0)
        use = np.maximum(use, np.abs(states[1][:, 6:]) / speed)
        powers = [t.watts(body) for t in self.task.terms if isinstance(t, PowerLimit)]
        if powers:
            q, v = states[0][:, 6:], states[1][:, 6:]
            tissue = body.tissue(list(q.T), list(v.T))
            use = np.maximum(use, np.abs((tau - np.stack(tissue, axis=1)) * v) / min(powers))
        return times, use.max(axis=1, initial=0.0)

    def beyond(self) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Return times between the nodes [s], and how far joints are beyond their ranges [rad].

        Negative where all are within them, by no more than that; -inf if nothing keeps them so.
        """
        times, limit = self._between, self.limits.coordinate
        if limit is None or not self._limited:
            return times, np.full(len(times), -np.inf)
        q = self.problem.states(self.coefficients, times)[0][:, 6:]
        return times, np.maximum(q - limit[1], limit[0] - q).max(axis=1, initial=-np.inf)

    def overlapping(self) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Return times between the nodes [s], and how deep limbs are in each other there [m].

        Negative where they are apart, by no more than that; all of it if nothing keeps them so.
        """
        times = self._between
        depth = np.full(len(times), -np.inf)
        q, v, a = self.problem.states(self.coefficients, times)
        for family in self.problem.rows:
            if (name := family.name).startswith((LEGS, ARMS, GROUND)):
                u = np.zeros((len(times), family.function.size1_in(3)))
                free = ConstraintFamily.free(name, family.function, family.names, len(times))
                depth = np.maximum(depth, -values(free, q, v, a, u).min(axis=1) / ROW_SCALE)
        return times, depth

    def too_low(self) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """Return times between the nodes [s], and how much too low a foot in the air is there [m].

        Negative where all are high enough, by no more than that; -inf for a task without
        clearance.
        """
        times, body = self._between, self.body
        low = np.full(len(times), -np.inf)
        required = [c for c in self.task.conditions(body) if c.quantity == "clearance"]
        if not required:
            return times, low
        places = body.cache.get(
            "site positions", lambda: BatchedFunction(body.symbolic.positions(list(body.sites)))
        )
        place = places(self.problem.states(self.coefficients, times)[0])[0]
        place = place.reshape(len(times), len(body.sites), 3)
        height = Ground.of_plan(self.task.plan).passed(place)
        index = {(s.body, tuple(s.position)): k for k, s in enumerate(body.sites)}
        for c in required:
            holds = c.holds_at(times)
            short = c.bounds(times[holds])[0] - height[holds, index[c.of, tuple(c.position)]]
            low[holds] = np.maximum(low[holds], short)
        return times, low

    def record(
        self, *, samples_per_interval: int = SAMPLES_PER_INTERVAL, strides: int = 2
    ) -> Record:
        """Return the motion on a grid finer than the nodes, over some strides if periodic."""
        plan, name = self.task.plan, self.task.name
        periods = strides * (2 if plan.mirrored else 1) if plan.periodic else 1
        sampled = self.sample(self.times(samples_per_interval, periods))
        return contact_record(
            self.body,
            sampled,
            plan,
            friction=self.friction,
            walks=plan.periodic or name.startswith(("walk", "track")),
            limits=self.limits,
            conditions=self.task.conditions(self.body, periods),
            signals={
                **solver_signals(self.stages, self.violations),
                **self._spline(),
                **self.task.object_signals(sampled.time),
            },
            notes=self.notes,
        )

    @property
    def limits(self) -> RecordLimits:
        """Limits of joints, forces and overlap for the check.

        Terms can change the values; a task without them has the default limits.
        """
        terms, human = self.task.terms, self.body.human
        contacts = [t for t in terms if isinstance(t, Contact)] or [Contact()]
        forces = [t.force * self.body.weight for t in contacts]
        joints = [t for t in terms if isinstance(t, Limits)] or [Limits()]
        return RecordLimits(
            coordinate=_narrowest([t.coordinates(human) for t in joints]),
            velocity=min(t.speed for t in joints),
            torque=_narrowest([t.torques(human) for t in joints]),
            force=min(forces),
            overlap=0.0 if self.task.solid else None,
        )

    @property
    def _limited(self) -> bool:
        """Whether the problem itself limits joints."""
        return any(isinstance(t, Limits) for t in self.task.terms)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for the user about an unsuccessful solve."""
        if self.success:
            return ()
        broken = [v.sentence() + "." for v in self.violations[:MAX_NOTED_VIOLATIONS]]
        if self.status == "stopped":
            return ("The solver was stopped; this is the best so far.", *broken)
        found = [f"The solver ended with “{self.status}”.", *broken]
        if pushed := pressing(self.problem, self.multipliers):
            found.append(f"Limits the solver pushed against hardest: {'; '.join(pushed)}.")
        return tuple(found)

    def _spline(self) -> dict[str, Array]:
        """Return what :class:`~plantigrade.trajopt.warm_start.WarmStart` reads."""
        p, plan = self.problem, self.task.plan
        kept: dict[str, Array] = {
            "spline.coefficients": self.coefficients,
            "spline.forces": self.forces[:, : p.n_unknowns],
            "spline.nodes": self.nodes,
            "spline.switches": self.switches,
            "spline.coordinates": np.array(p.names),
            "spline.unknowns": np.array(p.u_names, dtype=np.str_),
            "spline.basis": np.array(self.task.basis),
            "spline.status": np.array(self.status),
        }
        if plan.periodic:
            kept["spline.period"] = np.array([float(plan.mirrored), plan.advance])
            if plan.aside:
                kept["spline.aside"] = np.array([plan.aside])
        pushing = {} if self.multipliers is None else self.multipliers.rows
        return kept | {f"spline.multipliers.{name}": x for name, x in pushing.items()}


def _narrowest(limits: Sequence[Float[Array, "2 n"]]) -> Float[Array, "2 n"]:
    """Return what is within all lower and upper limits."""
    return np.stack(
        [np.max([x[0] for x in limits], axis=0), np.min([x[1] for x in limits], axis=0)]
    )


def solver_signals(stages: Sequence[Stage], broken: Sequence[Violation]) -> dict[str, Array]:
    """Return how a solver got there, as signals of a Record."""
    every = [(k, it) for k, stage in enumerate(stages) for it in stage.history]
    history = [(k, i.number, i.objective, i.violation, i.optimality) for k, i in every]
    words = {
        "stage_names": [s.name for s in stages],
        "stage_solvers": [s.solver for s in stages],
        "stage_status": [s.status for s in stages],
        "history_worst": [it.worst for _, it in every],
        "broken": [b.sentence() for b in broken],
    }
    return {f"solver.{name}": np.array(x, dtype=np.str_) for name, x in words.items()} | {
        "solver.stage_nodes": np.array([s.nodes for s in stages]),
        "solver.history": np.array(history, float).reshape(-1, 5),
    }
