"""A motion of the paper as a Record: the forces that come nearest to explaining it.

The paper knows no contact forces. To be judged its motions get those that come nearest to
explaining them, at the sites its contact matrix has on the ground; what is left is what no contact
can give.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import FRICTION
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.contact.site import foot_sites
from plantigrade.models import Human
from plantigrade.record import Limits as RecordLimits
from plantigrade.record import Record
from plantigrade.synthesize.contact_record import contact_record
from plantigrade.synthesize.guess.postures import standing_feet
from plantigrade.synthesize.problem.contact_body import ContactBody
from plantigrade.synthesize.sampling import sample
from plantigrade.synthesize.solution import Stage, solver_signals
from plantigrade.synthesize.solvers.result import Iterate
from plantigrade.synthesize.terms.contact import Contact
from plantigrade.synthesize.terms.limits import Limits
from plantigrade.synthesize.zhakatayev2023.formulation import PaperProblem
from plantigrade.synthesize.zhakatayev2023.motions import PaperMotion
from plantigrade.synthesize.zhakatayev2023.staged import StagedResult

SAMPLES_PER_INTERVAL = 10


def record_of(paper: PaperProblem, result: StagedResult) -> Record:
    """Return a solution of the paper's problem as what happened, friction as everywhere."""
    human, times = paper.body.human, paper.problem.nodes
    plan = plan_of(paper.motion, human)
    body = ContactBody(human, foot_sites(human))
    standing = np.stack([plan.standing(s, times) for s in body.sites], axis=1)
    n = SAMPLES_PER_INTERVAL * (len(times) - 1) + 1
    fine = np.linspace(times[0], times[-1], n)
    shares = equal_shares(standing)
    sampled = sample(body, plan, paper.problem, result.c, shares, fine, FRICTION)
    limits, stages = Limits(), []
    for s in result.stages:  # of the last one every iteration, of the others the end
        end = Iterate(
            s.iterations, s.objective, s.violation, s.worst, np.nan, np.nan, 0.0, 1.0, s.seconds
        )
        history = (*(result.history if s is result.stages[-1] else ()), end)
        stages.append(Stage(s.name, s.solver, len(times), s.status, s.seconds, history))
    return contact_record(
        body,
        sampled,
        plan,
        friction=FRICTION,
        walks=paper.motion.name == "walk",
        limits=RecordLimits(
            velocity=limits.speed,
            torque=limits.torques(human),
            force=Contact().force * body.weight,
        ),
        signals=solver_signals(stages, []),
    )


def equal_shares(standing: Bool[Array, "n n_sites"]) -> Float[Array, "n n_unknowns"]:
    """Return body weight shared equally by what stands [body weights]; nothing in flight."""
    u = np.zeros((*standing.shape, 3))
    u[..., 2] = standing / np.maximum(standing.sum(axis=1, keepdims=True), 1)
    return u.reshape(len(standing), -1)


def plan_of(motion: PaperMotion, human: Human) -> ContactPlan:
    """Return the paper's contact matrix as stances of flat feet.

    A foot stands from the first to the last of neighbouring samples at which the matrix has it on
    the ground; between them nothing holds it there.
    """
    feet, times = standing_feet(human), motion.times
    stances = []
    for side, down in motion.contact.items():
        on = np.flatnonzero(np.diff(np.r_[0, np.asarray(down, int), 0]))
        for a, b in zip(on[::2], on[1::2] - 1, strict=True):
            x, y, z = feet[side].position
            ahead, right = motion.places[side][a]
            place = Footprint(side, (x + float(ahead), y - float(right), z), feet[side].heading)
            start = -1.0 if a == 0 else float(times[a])
            end = motion.duration + 1.0 if b == len(times) - 1 else float(times[b])
            if end > start:
                stances.append(Stance(place, start, start, end, end, end))
    return ContactPlan(motion.duration, tuple(sorted(stances, key=lambda s: s.heel_strike)))
