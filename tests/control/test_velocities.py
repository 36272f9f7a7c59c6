"""Velocities that are wanted, and the boxed program of motors and contacts that gives them."""

import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.contact.site import contact_sites
from plantigrade.control.pendulum.velocities import BoxProgram, bell
from plantigrade.control.pendulum.wanted import FREE, Weights
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human
from plantigrade.wbc.whole_body import Rows, Touching


def test_the_bell_is_steep_near_its_goal_and_falls_far_off():
    error = np.linspace(-2.5, 2.5, 501)
    rate = bell(error)
    np.testing.assert_allclose(rate, -rate[::-1])
    assert np.all(error * rate >= 0.0)
    near = bell(np.array([0.01, 0.02]))
    assert near[1] == pytest.approx(2 * near[0])
    np.testing.assert_allclose(bell(error[np.abs(error) < 0.5]), bell(error)[np.abs(error) < 0.5])
    assert 0.5 < abs(error[np.argmax(rate)]) < 1.5 and rate[-1] < 0.6 * rate.max()
    assert rate[-1] > 0.0


@pytest.fixture(scope="module")
def boxed():
    """A person who stands and is asked to bow: program, state, points, rows."""
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    state = BodyState(human, human.standing())
    sites = [s for s in contact_sites(human) if s.side]
    points = PointSet.of(human, sites)
    place = state.position(points).copy()
    place[:, 2] -= [s.radius for s in sites]
    touching = Touching(points.body, place, np.tile([0.0, 0.0, 1.0], (len(sites), 1)), 0.6)
    J, _, bias = state.touched(points.body, place)
    nv = human.model.nv
    wanted = np.zeros(nv)
    wanted[6 + human.hinge("lumbar_extension")] = -3.0
    asked = {
        "rows": [Rows(J.reshape(-1, nv), -bias.ravel(), 900.0)],
        "wanted": wanted,
        "weight": np.repeat([0.0, 0.4], [3, nv - 3]),
    }
    return BoxProgram(human, 0.02), state, touching, asked


def test_the_boxed_program_is_the_complementarity_problem_of_motors_and_contacts(boxed):
    program, state, touching, asked = boxed
    problem = program.matrices(state, touching, **asked)
    x, status = problem.daqp()
    assert status == "ok"
    slack = problem.H @ x + problem.g
    free = (x > problem.low + 1e-9) & (x < problem.high - 1e-9)
    assert free.any() and (~free).any()  # some edges of friction pyramids carry nothing
    scale = np.abs(problem.g).max()
    assert np.abs(slack[free]).max() < 1e-6 * scale
    assert slack[x <= problem.low + 1e-9].min() > -1e-6 * scale
    answer = program.solve(state, touching, **asked)
    # Accelerations, torques and forces are one solution of the equations of motion.
    M, J = state.mass_matrix.copy(), state.touched(touching.body, touching.place)[0]
    M[np.arange(6, len(M)), np.arange(6, len(M))] += 0.02
    given = np.einsum("kcv,kc->v", J, answer.force)
    given[6:] += answer.torque
    np.testing.assert_allclose(M @ answer.qacc + state.bias, given, atol=1e-6)
    assert answer.force[:, 2].sum() == pytest.approx(65.0 * GRAVITY, rel=0.1)


def test_projected_gauss_seidel_agrees_with_the_active_set_method(boxed):
    program, state, touching, _ = boxed
    rates = np.zeros(len(program.low))
    rates[program.human.hinge("lumbar_extension")] = -1.0
    some = [0, len(touching) - 1]  # one point of each foot
    few_points = Touching(touching.body[some], touching.place[some], touching.normal[some], 0.6)
    problem = program.motors(state, few_points, rates)
    exact, status = problem.daqp()
    found, sweeps = problem.gauss_seidel()
    assert status == "ok" and sweeps > 1
    cost = [0.5 * x @ problem.H @ x + problem.g @ x for x in (exact, found)]
    assert cost[1] == pytest.approx(cost[0], rel=1e-6)
    # What several points could carry alike, they do; the motion is the same.
    np.testing.assert_allclose(problem.X @ found, problem.X @ exact, atol=0.02)
    again, few = problem.gauss_seidel(exact)
    assert few < sweeps
    # Motors have their rates: this one is as strong as it must be.
    answer, projected = problem.answer(), problem.answer("gauss-seidel")
    assert answer.limited == projected.limited == 0
    np.testing.assert_allclose(projected.qacc, answer.qacc, atol=0.02)
    with pytest.raises(ParameterError, match="no solver 'cg'; there are daqp, gauss-seidel"):
        problem.answer("cg")


def test_a_torque_at_its_limit_gives_what_it_can_and_the_others_know_it(boxed):
    program, state, touching, asked = boxed
    few = np.clip([program.low, program.high], -5.0, 5.0)
    weak = BoxProgram(program.human, 0.02, few)
    answer = weak.solve(state, touching, **asked)
    assert answer.ok and answer.limited > 0
    assert np.abs(answer.torque).max() <= 5.0 + 1e-9


@pytest.mark.parametrize("strength", [1.0, 0.03])
def test_what_walks_solves_the_boxed_program(boxed, strength):
    program, state, touching, asked = boxed
    limits = strength * np.array([program.low, program.high])
    same = BoxProgram(program.human, 0.02, limits)
    held = np.arange(len(touching)) % 3 > 0
    gap = np.where(np.arange(len(touching)) == 4, 0.0012, 0.0)
    exact = same.matrices(state, touching, held=held, gap=gap, **asked).answer()
    answer = same.solve(state, touching, held=held, gap=gap, **asked)
    assert answer.ok and exact.ok
    assert (answer.limited > 0) == (strength < 1.0) and answer.limited == exact.limited
    np.testing.assert_allclose(answer.torque, exact.torque, atol=1e-4)
    np.testing.assert_allclose(answer.qacc, exact.qacc, atol=1e-4)
    np.testing.assert_allclose(answer.force, exact.force, atol=1e-2)


def test_a_point_that_hangs_over_the_ground_carries_nothing(boxed):
    program, state, touching, asked = boxed
    on = program.solve(state, touching, gap=np.zeros(len(touching)), **asked)
    without = program.solve(state, touching, **asked)
    np.testing.assert_allclose(on.force, without.force, atol=1e-2)
    i = int(np.argmax(on.force[:, 2]))
    gap = np.where(np.arange(len(touching)) == i, 0.003, 0.0)
    over = program.solve(state, touching, gap=gap, **asked)
    assert over.force[i, 2] < 0.05 * on.force[i, 2]
    assert over.force[:, 2].sum() == pytest.approx(on.force[:, 2].sum(), rel=0.02)


def test_a_neck_that_is_off_is_dearer_than_one_that_is_not():
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    weights, names = Weights.of(human), human.coordinates
    neck = [i for i, name in enumerate(names) if "neck_" in name]
    assert neck and weights.at(np.zeros(len(names))) == pytest.approx(weights.weight)
    thrown = weights.at(np.full(len(names), 4 * FREE)) / np.maximum(weights.weight, 1e-9)
    assert thrown[6:][neck] == pytest.approx(17.0)
    assert np.delete(thrown[6:], neck) == pytest.approx(1.0)
