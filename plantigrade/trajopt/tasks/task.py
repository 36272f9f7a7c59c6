"""A task: contacts, terms and a first guess; everything a motion is made from but the person."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import TIME_TOLERANCE, ContactPlan
from plantigrade.contact.scene import SceneObject
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.mirror import mirror_sign, mirrored_name
from plantigrade.record.conditions import Condition
from plantigrade.record.scene_objects import PLACES, object_signals
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.nlp import PeriodicClosure, Problem
from plantigrade.trajopt.splines.basis import Basis
from plantigrade.trajopt.splines.knots import clamped_knots, periodic_knots
from plantigrade.trajopt.splines.polynomial import PolynomialBasis
from plantigrade.trajopt.splines.trigonometric import TrigonometricBasis
from plantigrade.trajopt.terms.device import Device
from plantigrade.trajopt.terms.external import Wrench
from plantigrade.trajopt.terms.impairment import Brace
from plantigrade.trajopt.terms.term import Term, one_sided, repeated
from plantigrade.trajopt.transcription.mesh import nodes_of, split

BASES = {"trigonometric": TrigonometricBasis, "polynomial": PolynomialBasis}
Guess = Callable[[ContactBody, ContactPlan, Array], Array]
"""Coordinates (n_times, nv) at times, for a body and a plan."""
ForceGuess = Callable[[ContactBody, Array, Array], Array]
"""Forces (n_times, 3 n_sites) at times [body weights], for a body and where a site may carry."""


ObjectPath = Callable[[Array], Array]
"""Middle (n_times, 3) of an object at times."""


@dataclass(frozen=True)
class MotionTask:
    """Definition of a movement.

    A periodic plan of half a stride, mirrored, becomes one of a whole stride where a term is about
    one side only, because the term would otherwise also apply to the other side.
    """

    name: str  #: Name
    plan: ContactPlan  #: Contacts
    terms: tuple[Term, ...]  #: Conditions and costs
    guess: Guess  #: Coordinates to start from
    nodes_per_second: float = 20.0  #: Nodes a second
    #: Nodes a second below which a mesh tells another motion: no coarser one is solved before
    least_nodes_per_second: float = 0.0
    basis: str = "trigonometric"  #: ``"trigonometric"`` or ``"polynomial"``
    #: Contact forces to start from; body weight shared by what stands if absent
    force_guess: ForceGuess | None = None
    #: Whether the check refuses parts of the body inside each other or inside the ground; false
    #: where a recording is tracked, whose limbs are not as thick as the person's
    solid: bool = True
    #: What is drawn beside the person: an object, and its place [m] at times
    objects: tuple[tuple[SceneObject, ObjectPath], ...] = ()
    tolerance: float = 1e-3  #: Largest scaled error of the optimality conditions at the end

    def __post_init__(self):
        if self.plan.periodic and self.plan.mirrored and one_sided(self.terms):
            object.__setattr__(self, "plan", self.plan.full_stride())

    def with_terms(self, *terms: Term) -> "MotionTask":
        """Return the task with more terms."""
        return replace(self, terms=(*self.terms, *terms))

    def body_of(self, human: Human) -> ContactBody:
        """Return the body of a person who does it: sites of the plan, what terms put on it."""
        return ContactBody.for_plan(human, self.plan, self.braces, self.wrenches, self.devices)

    @property
    def braces(self) -> tuple[Brace, ...]:
        """Braces among the terms."""
        return tuple(term for term in self.terms if isinstance(term, Brace))

    @property
    def wrenches(self) -> tuple[Wrench, ...]:
        """Wrenches among the terms."""
        return tuple(term for term in self.terms if isinstance(term, Wrench))

    @property
    def devices(self) -> tuple[Device, ...]:
        """Devices among the terms."""
        return tuple(term for term in self.terms if isinstance(term, Device))

    def conditions(self, body: ContactBody, periods: int = 1) -> tuple[Condition, ...]:
        """Return what must hold of the motion over some periods, as the checker judges it."""
        plan = self.plan
        found = [c for term in self.terms for c in term.conditions(body, plan)]
        out = repeated(tuple(found), plan, periods if plan.periodic else 1)
        if plan.periodic:
            when = (0.0, periods * plan.duration)
            ways = {"pelvis_tx": plan.advance * float(np.cos(plan.slope))}
            if plan.aside:
                ways["pelvis_tz"] = -plan.aside
            for of, way in ways.items():
                exact, name = (periods * way, periods * way), "distance walked"
                out = (*out, Condition(name, "displacement", when, exact, exact, of))
        return out

    def object_signals(self, times: Float[Array, " n"]) -> dict[str, Array]:
        """Return the signals of what is drawn beside the person, at times [s]."""
        if not self.objects:
            return {}
        upright = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
        poses = [np.hstack([path(times), upright]) for _, path in self.objects]
        return {
            **object_signals([each for each, _ in self.objects]),
            PLACES: np.stack(poses, axis=1),
        }

    def nodes(self, given: Float[Array, " n"] | None = None) -> Float[Array, " n_nodes"]:
        """Return the times of the nodes, with one wherever a term requires it.

        Args:
            given: Nodes to keep to, start, end and all changes of contact among them [s]; spaced by
                ``nodes_per_second`` if absent. The nearest one that may move does.

        Raises:
            ParameterError: If a term names a time outside the motion.
        """
        nodes = self._spaced() if given is None else given.copy()
        instants = sorted({float(t) for term in self.terms for t in term.instants})
        fixed = [*self.plan.switches, *instants]
        for t in instants:
            if not -TIME_TOLERANCE <= t <= self.plan.duration + TIME_TOLERANCE:
                raise ParameterError(
                    f"{t:g} s is outside the motion, which lasts {self.plan.duration:g} s"
                )
            k = int(np.argmin(np.abs(nodes - t)))
            if abs(nodes[k] - t) <= TIME_TOLERANCE:
                continue
            if np.min(np.abs(np.subtract(fixed, nodes[k]))) > TIME_TOLERANCE:
                nodes[k] = t
            else:
                nodes = np.sort(np.append(nodes, t))
        return nodes

    def _spaced(self) -> Float[Array, " n_nodes"]:
        """Return evenly spaced nodes, halved where a term requires a finer mesh."""
        nodes = nodes_of(self.plan, self.nodes_per_second)
        for start, stop, most in (x for term in self.terms for x in term.spaced(self.plan)):
            middle, step = (nodes[1:] + nodes[:-1]) / 2, np.diff(nodes)
            nodes = split(nodes, middle[(step > most) & (nodes[1:] > start) & (nodes[:-1] < stop)])
        return nodes

    def problem(self, body: ContactBody, nodes: Float[Array, " n_nodes"] | None = None) -> Problem:
        """Return the problem of a person who does it, on the given or the task's own nodes [s]."""
        nodes = self.nodes(nodes)
        plan, names, sites = self.plan, body.symbolic.names, [s.name for s in body.sites]
        basis, closure = spline_basis(self.basis, nodes, plan.periodic), None
        if plan.periodic:
            nodes = nodes[:-1]
            closure = closure_of(
                names, sites, mirrored=plan.mirrored, way=(plan.advance, plan.aside)
            )
        builder = ProblemBuilder(body, self.plan, nodes)
        for term in self.terms:
            term.add_to(builder)
        return builder.problem(basis, closure)

    def start(
        self, body: ContactBody, problem: Problem
    ) -> tuple[Float[Array, "n_coefficients nv"], Float[Array, "n_nodes n_unknowns"]]:
        """Return coefficients and forces of the first guess."""
        times = sample_times(problem)
        c = coefficients(problem, times, self.guess(body, self.plan, times))
        if self.force_guess is None:
            return c, shared_weight(problem)
        u = np.zeros((len(problem.nodes), problem.n_unknowns))
        u[:] = self.force_guess(body, problem.nodes, problem.u_active)
        return c, np.clip(u, problem.u_lower, problem.u_upper)


def spline_basis(name: str, nodes: Float[Array, " n"], periodic: bool) -> Basis:
    """Return the cubic spline on nodes, start and end among them."""
    if periodic:
        return BASES[name](3, periodic_knots(nodes, 3), periodic=True)
    return BASES[name](3, clamped_knots(nodes, 3))


def closure_of(
    names: Sequence[str], sites: Sequence[str], *, mirrored: bool, way: tuple[float, float]
) -> PeriodicClosure:
    """Return how a gait goes on after its period: further along x and y [m], mirrored or not."""
    source, sign = np.arange(len(names)), np.ones(len(names))
    pair, across = list(range(len(sites))), 1.0
    if mirrored:
        source = np.array([names.index(mirrored_name(n)) for n in names])
        sign = np.array([mirror_sign(n) for n in names])
        pair, across = [sites.index(mirrored_name(s)) for s in sites], -1.0
    moved = {"pelvis_tx": way[0], "pelvis_tz": -way[1]}
    shift = np.array([moved.get(n, 0.0) for n in names])
    u_source = np.array([3 * k + i for k in pair for i in range(3)], int)
    u_sign = np.tile([1.0, across, 1.0], len(sites))
    return PeriodicClosure(source, sign, shift, u_source, u_sign)


def sample_times(problem: Problem) -> Float[Array, " n_times"]:
    """Return nodes and the middles between them, to fit coefficients at [s]."""
    ends = problem.nodes
    if problem.closure is not None:
        ends = np.append(ends, problem.basis.stop)
    times = np.sort(np.concatenate([ends, (ends[1:] + ends[:-1]) / 2]))
    return times[:-1] if problem.closure is not None else times


def coefficients(
    problem: Problem, times: Float[Array, " n_times"], q: Float[Array, "n_times nv"]
) -> Float[Array, "n_coefficients nv"]:
    """Return the coefficients that fit samples of a motion best, its continuation included."""
    basis, k = problem.basis, problem.closure
    if k is None:
        return basis.fit(times, q, smoothing=1e-9)
    q = q - problem.drift(times)
    n, nt = basis.n_coefficients, len(times)
    band = basis.band(times)
    lap, index = np.divmod(band.first[:, None] + np.arange(band.values.shape[1]), n)
    row = np.broadcast_to(np.arange(nt)[:, None], index.shape)
    c = np.zeros((n, q.shape[1]))
    # a coordinate and its mirror image continue each other
    for pair in sorted({tuple(sorted({j, int(s)})) for j, s in enumerate(k.source)}):
        rows = np.zeros((len(pair), nt, len(pair), n))
        for a, j in enumerate(pair):
            b = np.where(lap, pair.index(int(k.source[j])), a)
            np.add.at(rows[a], (row, b, index), band.values * np.where(lap, k.sign[j], 1.0))
        targets = q[:, pair].T.ravel()
        found = np.linalg.lstsq(rows.reshape(len(targets), -1), targets, rcond=None)[0]
        c[:, pair] = found.reshape(-1, n).T
    return c


def shared_weight(problem: Problem) -> Float[Array, "n_nodes n_unknowns"]:
    """Return body weight shared equally by the sites that may carry."""
    u = np.zeros((len(problem.nodes), problem.n_unknowns))
    free = problem.u_active[:, 2::3]
    u[:, 2::3] = free / np.maximum(free.sum(axis=1, keepdims=True), 1)
    return u
