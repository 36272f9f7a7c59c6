"""From a task to a motion: stages, warm starts, what cannot be done, being stopped."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt import (
    ContactBody,
    InteriorPoint,
    Options,
    Solution,
    make_task,
    synthesize,
)
from plantigrade.trajopt.diagnose.violations import values, violations
from plantigrade.trajopt.solvers.interior_point import GUESS_BARRIER, NEARLY_MET
from plantigrade.trajopt.terms.contact import Contact
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.transcription.mesh import nodes_like, nodes_of, split
from tests.trajopt.coarse_walk import NODES_PER_SECOND, SPEED, body, person, solved, task

pytestmark = pytest.mark.solver


def weak():
    """A walk for which a person has a fiftieth of the strength."""
    given = task()
    terms = [replace(t, strength=0.02) if isinstance(t, Limits) else t for t in given.terms]
    return replace(given, terms=tuple(terms))


def _moved(s, far: float):
    """A solution with noise on its coefficients."""
    noise = np.random.default_rng(0).normal(size=s.coefficients.shape)
    return replace(s, coefficients=s.coefficients + far * noise)


def test_a_walk_keeps_every_row_at_its_nodes():
    s = solved()
    assert s.success and s.stages[0].name == "first try"
    assert violations(s.problem, s.coefficients, s.forces, tolerance=1e-5) == ()
    assert s.iterations == sum(len(x.history) - 1 for x in s.stages)


def test_the_objective_is_that_of_the_motion():
    s = solved()
    kept = [x.history[-1] for x in s.stages if x.nodes == len(s.problem.nodes)]
    assert s.objective == pytest.approx(kept[-1].objective, rel=1e-9)
    away = _moved(s, 0.1)
    assert away.objective > s.objective
    assert replace(s, stages=()).objective == s.objective  # as it is after it was read from a file


def test_nodes_are_added_where_contact_cannot_provide_the_wrench():
    one = synthesize(body(), task(), refinements=0)
    assert len(one.stages) == 1
    _, before = one.unexplained()
    _, after = solved().unexplained()
    assert after.max() <= max(before.max(), 1.5e-3)


def _missing(monkeypatch, wrench: float) -> np.ndarray:
    """Let every motion miss a wrench between nodes, and nothing else; it is the first element."""
    times, missing = np.array([0.1, 0.3]), np.array([wrench, 0.1])
    monkeypatch.setattr(Solution, "unexplained", lambda self: (times, missing))
    for name in ("overloaded", "beyond", "overlapping", "too_low"):
        monkeypatch.setattr(Solution, name, lambda self: (times, np.full(2, -np.inf)))
    return missing


def test_a_motion_that_holds_at_nodes_alone_is_not_refined(monkeypatch):
    missing = _missing(monkeypatch, 1.0)
    assert [x.name for x in synthesize(body(), task()).stages] == ["first try"]
    missing[0] = 0.4
    found = synthesize(body(), task(), refinements=1)
    assert [x.name for x in found.stages] == ["first try", "more nodes"]
    assert [x.status for x in found.stages] == ["paused", found.status] and found.success


def test_a_motion_whose_refinement_is_stopped_is_the_best_so_far(monkeypatch):
    _missing(monkeypatch, 0.4)
    found = synthesize(body(), task(), progress=lambda name, _: name == "more nodes")
    assert [x.status for x in found.stages] == ["paused", "stopped"]
    assert found.status == "stopped" and not found.success


def test_a_guess_nearby_has_a_smaller_barrier():
    one = synthesize(body(), task(), refinements=0).stages[0].history[0]
    far = synthesize(body(), task(), refinements=0, c0=_moved(solved(), 1.0).coefficients)
    other = far.stages[0].history[0]
    assert one.violation < other.violation and GUESS_BARRIER <= one.barrier < other.barrier


def test_the_motion_at_nodes_is_the_solution():
    s = solved()
    q, v, a = s.problem.states(s.coefficients, s.problem.nodes)
    sampled = s.sample(s.problem.nodes)
    qpos, qvel, qacc = s.body.symbolic.to_mujoco(q, v, a)
    np.testing.assert_allclose(sampled.qpos, qpos, atol=1e-12)
    np.testing.assert_allclose(sampled.qvel, qvel, atol=1e-12)
    np.testing.assert_allclose(sampled.qacc, qacc, atol=1e-12)
    force = s.forces.reshape(sampled.force.shape) * s.body.weight
    np.testing.assert_allclose(sampled.force, force, atol=1e-2)  # of 700 N


def test_a_warm_start_to_another_speed_is_quicker_and_as_good():
    other = task(SPEED + 0.1)
    cold = synthesize(body(), other, refinements=0)
    warm = synthesize(body(), other, warm=solved(), refinements=0)
    assert cold.success and warm.success
    assert [x.name for x in warm.stages] == ["warm start"]
    assert warm.iterations <= 3 * cold.iterations / 4
    assert violations(warm.problem, warm.coefficients, warm.forces, tolerance=1e-5) == ()
    way = [s.sample(np.array([0.0, s.task.plan.duration])).qpos[:, 0] for s in (warm, cold)]
    np.testing.assert_allclose(np.diff(way[0]), np.diff(way[1]), rtol=1e-9)
    if len(warm.problem.nodes) == len(cold.problem.nodes):
        assert warm.objective == pytest.approx(cold.objective, rel=2e-2)


def test_from_itself_a_motion_is_found_at_once():
    again = synthesize(body(), task(), warm=solved(), refinements=0)
    assert again.success and again.iterations <= 1
    assert again.objective == pytest.approx(solved().objective, rel=1e-3)


def test_a_warm_start_of_other_joints_is_refused_and_other_places_are_matched_by_name():
    other = Human.create(1.72, 68.0, joints="43", feet="two-segment")
    given = replace(make_task("walk", other, {"periodic": True}), nodes_per_second=NODES_PER_SECOND)
    with pytest.raises(ParameterError, match="the run has 42 coordinates, this person 43"):
        synthesize(ContactBody.for_plan(other, given.plan), given, warm=solved())
    fewer = ContactBody(person(), [s for s in body().sites if s.name[:-2] != "toe_5"])
    made = synthesize(fewer, task(), warm=solved(), refinements=0)
    assert made.success and made.forces.shape[1] == solved().forces.shape[1] - 6


def test_a_warm_start_that_leads_nowhere_is_followed_by_a_first_try():
    s = solved()
    astray = replace(_moved(s, 3.0), multipliers=None)
    options = Options(iterations=25, tolerance=task().tolerance)
    made = synthesize(body(), task(), warm=astray, refinements=0, options=options)
    assert made.success
    assert [x.name for x in made.stages] == ["warm start", "first try"]
    assert made.objective == pytest.approx(s.objective, rel=5e-3)  # that one has more nodes


def test_a_person_who_is_too_weak_does_not_walk_and_the_message_says_why():
    reported = []
    s = synthesize(
        body(), weak(), options=Options(iterations=6), progress=lambda n, i: reported.append(n)
    )
    assert not s.success
    names = [x.name for x in s.stages]
    assert names == ["first try", "coarse mesh", "smooth first"]
    assert list(dict.fromkeys(reported)) == names
    assert s.stages[1].nodes < s.stages[0].nodes
    for stage in s.stages:
        assert stage.status in ("too many iterations", "stalled")
        assert stage.history[-1].violation > 1e-3
        assert stage.history[-1].worst.endswith(" s")
    broken = violations(s.problem, s.coefficients, s.forces)
    assert broken and broken[0].relative > 1e-3
    assert broken[0].sentence().count(" s") and broken[0].advice
    assert np.isfinite(s.sample(s.times(4)).qpos).all()  # it can still be looked at


def _stalls_once(monkeypatch, violation: float) -> list[float]:
    """Let the first solve stall no nearer than this; return the tolerances of all solves."""
    tolerances = []

    class Stalling(InteriorPoint):
        def solve(self, *args, **kwargs):
            tolerances.append(self.options.tolerance)
            found = super().solve(*args, **kwargs)
            if len(tolerances) > 1:
                return found
            off = [replace(x, violation=max(x.violation, violation)) for x in found.history]
            return replace(found, status="stalled", history=tuple(off))

    monkeypatch.setattr("plantigrade.trajopt.solve.InteriorPoint", Stalling)
    return tolerances


def test_a_solver_that_stalls_near_by_goes_on_with_a_larger_barrier(monkeypatch):
    """It goes on from where it stalled, and ends at the tolerance of the task."""
    tolerances = _stalls_once(monkeypatch, 0.5 * NEARLY_MET)
    made = synthesize(body(), task(), refinements=0)
    assert made.success
    assert [x.name for x in made.stages] == ["first try", "larger barrier", "the task itself"]
    assert tolerances == [task().tolerance, pytest.approx(10.0 * task().tolerance), tolerances[0]]
    there, on = (x.history for x in made.stages[:2])
    assert on[0].objective == pytest.approx(there[-1].objective)
    assert on[0].barrier > there[-1].barrier


def test_a_solver_that_stalls_far_off_gets_no_larger_barrier(monkeypatch):
    _stalls_once(monkeypatch, 2.0 * NEARLY_MET)
    made = synthesize(body(), task(), refinements=0)
    assert [x.name for x in made.stages][:2] == ["first try", "coarse mesh"]


@pytest.mark.parametrize("kind", ["muscle torque", "joint torque", "work rate"])
def test_missing_torques_are_reported_in_newton_metres(kind):
    """Torques are scaled for this person, not for one whose torque is 100 N m in a row of 1."""
    s = solved()
    assert abs(s.body.torque - 100.0) > 3.0
    (dynamics,) = (r for r in s.problem.rows if r.name == "dynamics")
    (rows,) = (r for r in dynamics.parts if r.name == kind)
    narrow, free = np.full(rows.lower.shape, -np.inf), np.full(rows.lower.shape, np.inf)
    q, v, a = s.problem.states(s.coefficients, s.problem.nodes)
    free[3, 2] = values(rows, q, v, a, s.forces)[3, 2] - 0.25
    changed = replace(rows, lower=narrow, upper=free)  # a family of its own
    others = tuple(changed if r is dynamics else r for r in s.problem.rows)
    (broken,) = violations(replace(s.problem, rows=others), s.coefficients, s.forces)
    assert broken.family == kind
    assert broken.name == rows.names[2] and broken.time == s.problem.nodes[3]
    assert broken.amount == pytest.approx(0.25 * s.body.torque)
    assert broken.unit == ("W" if kind.startswith("work") else "N m")
    assert "more time" in broken.advice


def test_being_stopped_gives_the_best_so_far_and_tries_nothing_else():
    s = synthesize(body(), task(), progress=lambda name, it: it.number >= 3)
    assert s.status == "stopped" and not s.success
    assert len(s.stages) == 1 and len(s.stages[0].history) == 4
    assert np.isfinite(s.coefficients).all()


def test_rougher_ground_is_not_taken_for_granted():
    """Forces between nodes stay inside the friction that the task says."""
    given = task()
    terms = [replace(t, friction=0.4) if isinstance(t, Contact) else t for t in given.terms]
    s = synthesize(body(), replace(given, terms=tuple(terms)), refinements=0)
    assert s.success and s.friction == 0.4
    force = s.sample(s.times(8)).force
    side = np.hypot(force[..., 0], force[..., 1])
    assert (side - 0.4 * force[..., 2]).max() < 1e-3 * s.body.weight


def test_wrong_options_are_refused():
    with pytest.raises(ParameterError, match="the guess has coefficients"):
        synthesize(body(), task(), c0=np.zeros((3, body().symbolic.nv)))


def test_a_body_made_for_other_ground_is_refused():
    with pytest.raises(ParameterError, match=r"rises by 5.72958° .* ContactBody.for_plan"):
        make_task("walk", person(), {"periodic": True, "slope": 0.1}).problem(body())
    with pytest.raises(ParameterError, match="rests on 'seat_r', and the body has no such site"):
        make_task("sit-to-stand", person()).problem(body())


# Meshes -------------------------------------------------------------------------------------------


def test_nodes_are_even_between_changes_and_as_dense_as_requested():
    plan = task().plan
    for nodes_per_second in (5.0, 24.0, 60.0):
        nodes = nodes_of(plan, nodes_per_second)
        assert nodes[0] == 0.0 and nodes[-1] == plan.duration
        for a, b in zip(plan.switches[:-1], plan.switches[1:], strict=True):
            steps = np.diff(nodes[(nodes >= a - 1e-9) & (nodes <= b + 1e-9)])
            assert len(steps) >= 2 and steps.max() <= 1 / nodes_per_second + 1e-9
            np.testing.assert_allclose(steps, steps[0])
    for bad in (0.0, np.inf):
        with pytest.raises(ParameterError):
            nodes_of(plan, bad)


def test_nodes_of_another_walk_keep_their_places_between_changes():
    one, other = task(1.0).plan, task(1.4).plan
    nodes = nodes_of(one, 20.0)
    moved = nodes_like(other, one.switches, nodes)
    assert moved is not None and len(moved) == len(nodes)
    for a, b in zip(one.switches, other.switches, strict=True):
        assert np.abs(moved[np.argmin(np.abs(nodes - a))] - b) < 1e-9
    assert nodes_like(replace(other, stances=()), one.switches, nodes) is None


def test_only_the_requested_intervals_are_halved():
    nodes = np.array([0.0, 0.1, 0.2, 0.208, 0.3])
    finer = split(nodes, np.array([0.12, 0.15, 0.204, 0.3]), shortest=0.005)
    np.testing.assert_allclose(finer, [0.0, 0.1, 0.15, 0.2, 0.208, 0.254, 0.3])
    np.testing.assert_array_equal(split(nodes, np.zeros(0)), nodes)


def test_neighbouring_intervals_are_halved_unless_they_are_shorter():
    nodes = np.array([0.0, 0.1, 0.2, 0.25, 0.35, 0.45])
    finer = split(nodes, np.array([0.12, 0.42]), neighbours=True)
    np.testing.assert_allclose(finer, [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45])
    np.testing.assert_array_equal(split(nodes, np.zeros(0), neighbours=True), nodes)


def test_intervals_are_quartered_where_an_error_is_more_than_four_times_too_large():
    nodes = np.array([0.0, 0.1, 0.2])
    finer = split(nodes, np.array([0.05, 0.12, 0.18]), np.array([1.5, 1.5, 4.5]))
    np.testing.assert_allclose(finer, [0.0, 0.05, 0.1, 0.125, 0.15, 0.175, 0.2])


@pytest.mark.slow
def test_a_foot_that_passes_the_other_leg_keeps_to_its_side_on_the_way_to_a_solution():
    human = Human.create(joints="66", feet="multi-segment")
    asked = make_task("walk", human, {"periodic": True})
    found = synthesize(asked.body_of(human), asked, rescue=False, refinements=0)
    assert found.success and found.iterations < 60
