"""A task: contacts, terms and a first guess; everything a motion is made from but the person."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.synthesize.problem.assembly import Assembly
from plantigrade.synthesize.problem.contact_body import ContactBody
from plantigrade.synthesize.problem.nlp import PeriodicClosure, Problem
from plantigrade.synthesize.splines.basis import Basis
from plantigrade.synthesize.splines.knots import clamped_knots, periodic_knots
from plantigrade.synthesize.splines.polynomial import PolynomialBasis
from plantigrade.synthesize.splines.trigonometric import TrigonometricBasis
from plantigrade.synthesize.terms.terms import Term
from plantigrade.synthesize.transcription.mesh import nodes_of

BASES = {"trigonometric": TrigonometricBasis, "polynomial": PolynomialBasis}

Guess = Callable[[ContactBody, ContactPlan, Array], Array]
"""Coordinates (n_times, nv) at times, for a body and a plan."""


@dataclass(frozen=True)
class MotionTask:
    """What is to be done.

    Attributes:
        name: What it is called.
        plan: Contacts.
        terms: Conditions and costs.
        guess: Coordinates to start from.
        nodes_per_second: Nodes a second.
        basis: ``"trigonometric"`` or ``"polynomial"``.
        step: How far a periodic motion goes in one lap [m].
    """

    name: str
    plan: ContactPlan
    terms: tuple[Term, ...]
    guess: Guess
    nodes_per_second: float = 20.0
    basis: str = "trigonometric"
    step: float = 0.0

    def with_terms(self, *terms: Term) -> "MotionTask":
        """Return the task with more terms."""
        return replace(self, terms=(*self.terms, *terms))

    def problem(self, body: ContactBody, nodes: Float[Array, " n_nodes"] | None = None) -> Problem:
        """Return the problem of a person who does it.

        Args:
            body: The person.
            nodes: Times of nodes, start, end and all changes of contact among them [s]; spaced by
                ``nodes_per_second`` if absent.
        """
        nodes = nodes_of(self.plan, self.nodes_per_second) if nodes is None else nodes
        basis: Basis
        closure = None
        if self.plan.periodic:
            basis = BASES[self.basis](3, periodic_knots(nodes, 3), periodic=True)
            nodes = nodes[:-1]
            closure = mirror(body, self.step)
        else:
            basis = BASES[self.basis](3, clamped_knots(nodes, 3))
        assembly = Assembly(body, self.plan, nodes)
        for term in self.terms:
            term.put(assembly)
        return assembly.problem(basis, closure)

    def start(
        self, body: ContactBody, problem: Problem
    ) -> tuple[Float[Array, "n_coefficients nv"], Float[Array, "n_nodes n_unknowns"]]:
        """Return coefficients and forces of the first guess."""
        times = sample_times(problem)
        c = coefficients(problem, times, self.guess(body, self.plan, times))
        return c, shared_weight(problem)


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
    """Return the coefficients of a motion nearest to samples, those of its continuation with it."""
    basis = problem.basis
    if problem.closure is None:
        return basis.fit(times, q, smoothing=1e-9)
    k = problem.closure
    q = q - problem.drift(times)
    n = basis.n_coefficients
    band = basis.band(times)
    raw = band.first[:, None] + np.arange(band.values.shape[1])
    lap, index = np.divmod(raw, n)
    nv = q.shape[1]
    c = np.zeros((n, nv))
    done = np.zeros(nv, bool)
    for j in range(nv):  # a coordinate and its mirror image continue each other
        pair = sorted({j, int(k.source[j])})
        if done[j]:
            continue
        m = len(pair)
        rows = np.zeros((len(times) * m, n * m))
        wanted = np.zeros(len(times) * m)
        for a, coordinate in enumerate(pair):
            wanted[a * len(times) : (a + 1) * len(times)] = q[:, coordinate]
            for i in range(len(times)):
                r = a * len(times) + i
                for value, over, at in zip(band.values[i], lap[i], index[i], strict=True):
                    if over:
                        b = pair.index(int(k.source[coordinate]))
                        rows[r, b * n + at] += value * k.sign[coordinate]
                    else:
                        rows[r, a * n + at] += value
        found = np.linalg.lstsq(rows, wanted, rcond=None)[0]
        for b, coordinate in enumerate(pair):
            c[:, coordinate] = found[b * n : (b + 1) * n]
            done[coordinate] = True
    return c


def shared_weight(problem: Problem) -> Float[Array, "n_nodes n_unknowns"]:
    """Return body weight shared equally by the sites that may carry."""
    u = np.zeros((len(problem.nodes), problem.n_unknowns))
    vertical = slice(2, None, 3)
    free = problem.u_active[:, vertical]
    count = free.sum(axis=1, keepdims=True)
    u[:, vertical] = np.where(free, 1.0 / np.maximum(count, 1), 0.0)
    return u


def mirror(body: ContactBody, step: float) -> PeriodicClosure:
    """Return how a symmetric gait goes on after half a stride: mirrored, and a step further."""
    names = body.symbolic.names
    source = np.array([names.index(mirrored_name(n)) for n in names])
    odd = ("pelvis_list", "pelvis_rotation", "pelvis_tz")
    sign = np.array(
        [-1.0 if n in odd or n.endswith(("_bending", "_rotation")) else 1.0 for n in names]
    )
    shift = np.array([step if n == "pelvis_tx" else 0.0 for n in names])
    sites = [s.name for s in body.sites]
    pair = [sites.index(mirrored_name(s)) for s in sites]
    u_source = np.array([3 * k + i for k in pair for i in range(3)], int)
    u_sign = np.tile([1.0, -1.0, 1.0], len(sites))
    return PeriodicClosure(source, sign, shift, u_source, u_sign)


def mirrored_name(name: str) -> str:
    """Return the name on the other side; a name without side is its own."""
    if name.endswith("_r"):
        return name[:-2] + "_l"
    if name.endswith("_l"):
        return name[:-2] + "_r"
    return name
