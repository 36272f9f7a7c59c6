"""The whole-body program: physics, limits, optimality, and which tasks it serves."""

import mujoco
import numpy as np
import pytest
from scipy.optimize import nnls

from plantigrade.constants import GRAVITY
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.wbc import PointRows, Rows, Touching, WholeBody, torque_limits
from plantigrade.wbc.rows import cost
from plantigrade.wbc.shares import ShareProgram, ShareSolver
from plantigrade.wbc.touching import N_EDGES


@pytest.fixture(scope="module", params=["42", "66"])
def human(request):
    return Human.create(joints=request.param)


@pytest.fixture
def state(human):
    rng = np.random.default_rng(1)
    qpos = human.standing()
    qpos[7:] += rng.uniform(-0.1, 0.1, len(human.coordinates))
    return BodyState(human, qpos, rng.uniform(-0.3, 0.3, human.model.nv))


def touching(state, sites=None, normal=(0.0, 0.0, 1.0)):
    points = PointSet.of(state.human, contact_sites(state.human) if sites is None else sites)
    normals = np.tile(np.array(normal) / np.linalg.norm(normal), (len(points), 1))
    return Touching(points.body, state.position(points), normals)


def centre_of_mass(state, desired, weight=1000.0):
    return Rows(state.com_jacobian, np.asarray(desired) - state.com_bias_acceleration, weight)


def test_touched_places_move_as_the_engine_says(state):
    where = touching(state)
    J, velocity, bias = state.touched(where.body, where.place)
    points = PointSet.of(state.human, contact_sites(state.human))
    assert np.allclose(J, state.jacobian(points), atol=1e-12)
    assert np.allclose(velocity, state.velocity(points), atol=1e-12)
    assert np.allclose(bias, state.bias_acceleration(points), atol=1e-10)


@pytest.mark.parametrize("way", [0.0, 0.4, 2.0])
def test_a_pyramid_has_the_whole_friction_along_its_corners(way):
    normal, ahead = np.array([[0.0, 0.0, 1.0]]), np.array([np.cos(way), np.sin(way), 0.0])
    for n in (normal, np.repeat([[0.6, 0.0, 0.8], [0.0, 0.0, 1.0]], [1, 1], axis=0)):
        where = Touching(np.ones(len(n), dtype=int), np.zeros((len(n), 3)), n, 0.5, along=way)
        flat = where.edges()[-1]
        assert (ahead @ flat).max() == pytest.approx(0.5)
        assert np.allclose(np.linalg.norm(flat[:2], axis=0), 0.5)
        steep = where.edges()[0]
        assert np.allclose(n[0] @ steep, 1.0)
        assert np.allclose(np.linalg.norm(steep - n[0][:, None], axis=0), 0.5)
    between = Touching(np.ones(1, dtype=int), np.zeros((1, 3)), normal, 0.5).edges()[0]
    assert between[0].max() == pytest.approx(0.5 / np.sqrt(2.0))


def test_torques_and_forces_give_the_accelerations(state):
    human, where = state.human, touching(state)
    program = WholeBody(human, armature=0.01)
    passive = np.full(len(human.coordinates), 0.5)
    desired = np.random.default_rng(2).uniform(-2, 2, human.model.nv)
    answer = program.solve(
        state, where, [centre_of_mass(state, [0.3, 0.2, 0.1])], desired=desired, passive=passive
    )
    assert answer.ok
    needed = state.inverse_dynamics(answer.qacc)
    for body, place, force in zip(where.body, where.place, answer.force, strict=True):
        needed -= state.generalised_force(int(body), place, force, np.zeros(3))
    assert np.allclose(needed[:6], 0.0, atol=1e-6)
    assert np.allclose(answer.torque, needed[6:] + 0.01 * answer.qacc[6:] - passive, atol=1e-6)
    acceleration = state.com_jacobian @ answer.qacc + state.com_bias_acceleration
    assert np.allclose(acceleration, [0.3, 0.2, 0.1], atol=0.05)
    weight = answer.force.sum(axis=0) - human.mass * (acceleration + [0, 0, GRAVITY])
    assert np.allclose(weight, 0.0, atol=1e-6)


@pytest.mark.parametrize("sideways", [0.0, 20.0])
def test_forces_stay_in_their_cones(state, sideways):
    where = touching(state, normal=(0.2, -0.1, 1.0))
    tasks = [centre_of_mass(state, [sideways, 0.0, 0.0])]
    answer = WholeBody(state.human).solve(
        state, where, tasks, desired=np.zeros(state.human.model.nv)
    )
    along = np.einsum("kc,kc->k", answer.force, where.normal)
    across = np.linalg.norm(answer.force - along[:, None] * where.normal, axis=1)
    assert answer.ok
    assert (answer.share >= 0).all()
    assert (across <= where.friction * along + 1e-9).all()
    if sideways:  # 20 m/s² is more than friction can give
        assert (answer.share == 0).any()


def test_shares_are_the_best_of_all_that_are_not_negative(state):
    """Against the same program written out and given to another solver."""
    human, where = state.human, touching(state)
    nv = human.model.nv
    tasks = [centre_of_mass(state, [8.0, 0.0, -3.0], 10.0)]
    desired = np.random.default_rng(3).uniform(-2, 2, nv)
    program = WholeBody(human, limits=np.array([[-1e6], [1e6]]) * np.ones(nv - 6))
    answer = program.solve(state, where, tasks, desired=desired, force_weight=1e-2)
    J, _, _ = state.touched(where.body, where.place)
    push = np.einsum("kcv,kce->vke", J, program.unit * where.edges()).reshape(nv, -1)
    M, h = state.mass_matrix, state.bias
    m = push.shape[1]
    change = np.zeros((nv, nv - 6 + m))  # of the acceleration by unknowns
    change[:6] = np.linalg.solve(M[:6, :6], np.hstack([-M[:6, 6:], push[:6]]))
    change[6:, : nv - 6] = np.eye(nv - 6)
    fixed = np.concatenate([np.linalg.solve(M[:6, :6], -h[:6]), np.zeros(nv - 6)])
    A, b = tasks[0].matrix, tasks[0].right
    rows = np.vstack([np.sqrt(10) * A @ change, change, np.eye(nv - 6 + m)[nv - 6 :] * 0.1])
    right = np.concatenate([np.sqrt(10) * (b - A @ fixed), desired - fixed, np.zeros(m)])
    joints, shares = rows[:, : nv - 6], rows[:, nv - 6 :]
    q, _ = np.linalg.qr(joints)
    best, _ = nnls(shares - q @ (q.T @ shares), right - q @ (q.T @ right))
    assert (best == 0).sum() > N_EDGES
    assert np.allclose(answer.share.ravel(), best, atol=1e-5)


def test_torques_stop_at_their_limits(state):
    human, where = state.human, touching(state)
    n = len(human.coordinates)
    desired = np.zeros(human.model.nv)
    free = WholeBody(human).solve(state, where, desired=desired)
    most = 0.6 * np.abs(free.torque).max()
    program = WholeBody(human, limits=np.array([[-most], [most]]) * np.ones(n))
    answer = program.solve(state, where, desired=desired)
    assert answer.ok
    assert answer.limited > 0
    assert np.abs(answer.torque).max() == pytest.approx(most, rel=1e-5)
    needed = state.inverse_dynamics(answer.qacc)
    for body, place, force in zip(where.body, where.place, answer.force, strict=True):
        needed -= state.generalised_force(int(body), place, force, np.zeros(3))
    assert np.allclose(needed[:6], 0.0, atol=1e-5)
    assert np.allclose(answer.torque, needed[6:], atol=1e-3)


@pytest.mark.parametrize("flies", [False, True])
@pytest.mark.parametrize("weight", [0.0, 1e-4])
def test_exchanges_find_what_the_solver_of_quadratic_programs_finds(
    state, flies, weight, monkeypatch
):
    where = Touching() if flies else touching(state)
    rng = np.random.default_rng(4)
    desired = rng.uniform(-60, 60, state.human.model.nv)
    limits, answers = 0.2 * np.array(state.human.model.jnt_actfrcrange[1:]).T, []
    for exchanges in (torque_limits.MAX_EXCHANGES, 0):
        monkeypatch.setattr(torque_limits, "MAX_EXCHANGES", exchanges)
        program = WholeBody(state.human, limits=limits)
        program.solve(state, where, desired=0.8 * desired, torque_weight=weight)
        answers.append(program.solve(state, where, desired=desired, torque_weight=weight))
    one, other = answers
    assert one.ok and other.ok
    assert one.limited == other.limited >= 2
    assert np.allclose(one.qacc, other.qacc, atol=2e-3)
    assert np.allclose(one.torque, other.torque, atol=2e-3)


def test_rows_of_points_cost_what_they_cost_one_by_one(state):
    where, rng = touching(state), np.random.default_rng(5)
    points = state.rigid_points(where.body, where.place)
    chosen, right = rng.random(len(where)) < 0.6, rng.normal(size=(len(where), 3))
    nothing = np.zeros(state.human.model.nv)
    together = cost([PointRows(points, chosen, right, 30.0)], nothing, 0.0)
    J = points.jacobian[chosen].reshape(-1, len(nothing))
    one_by_one = cost([Rows(J, right[chosen].ravel(), 30.0)], nothing, 0.0)
    for a, b in zip(together, one_by_one, strict=True):
        assert np.allclose(a, b, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_shares_meet_the_conditions_of_their_minimum(seed):
    rng = np.random.default_rng(seed)
    solver = ShareSolver()
    for _ in range(5):  # each from the active set of another one
        K, root = rng.normal(size=(6, 40)), rng.normal(size=(6, 6))
        q, own = 30.0 * rng.normal(size=40), np.full(40, 1e-2)
        S, u = root.T @ root, rng.normal(size=6)
        program = ShareProgram(K, S, np.eye(6), u, own, q)
        share, price, found = solver.solve(program)
        assert found
        assert np.allclose(price, S @ (K @ share - u), atol=1e-5)
        slope = K.T @ S @ (K @ share - u) + own * share + q
        assert (share >= 0).all() and (slope[share > 0] < 1e-5).all() and (slope > -1e-5).all()
        assert 0 < np.count_nonzero(share) < 40


@pytest.mark.parametrize("n", [40, 80])
def test_few_shares_meet_the_conditions_as_many_do(n):
    """DAQP finds few of them, Newton's steps many; either from the active set of another one."""
    rng, solver = np.random.default_rng(3), ShareSolver()
    for _ in range(5):
        K, root = rng.normal(size=(6, n)), rng.normal(size=(6, 6))
        q, own = 30.0 * rng.normal(size=n), np.full(n, 1e-2)
        program = ShareProgram.of(K, root.T @ root, own, q)
        share, price, found = solver.solve(program)
        assert found and program.plain
        assert np.allclose(price, program.S @ (K @ share), atol=1e-5)
        slope = program.hessian() @ share + q
        assert (share >= 0).all() and (slope[share > 0] < 1e-5).all() and (slope > -1e-5).all()
        assert 0 < np.count_nonzero(share) < n


def test_desired_forces_and_torques_come_back(state):
    """Motion and forces that mechanics leaves open follow the desired values."""
    human, where = state.human, touching(state)
    program, desired = WholeBody(human), np.zeros(human.model.nv)
    first = program.solve(state, where, desired=desired)
    again = program.solve(
        state, where, desired=first.qacc, force=first.force, torque=first.torque, torque_weight=1e-4
    )
    assert np.allclose(again.qacc, first.qacc, atol=1e-4)
    assert np.allclose(again.torque, first.torque, atol=1e-2)


def test_open_accelerations_are_refused(state):
    answer = WholeBody(state.human).solve(
        state, Touching(), desired=np.zeros(state.human.model.nv), weight=0.0
    )
    assert not answer.ok
    assert "weights" in answer.status


def test_a_body_in_flight_falls(human):
    data = mujoco.MjData(human.model)
    data.qpos[:] = human.standing()
    state = BodyState(human, data.qpos)
    answer = WholeBody(human).solve(state, Touching(), desired=np.zeros(human.model.nv))
    fall = state.com_jacobian @ answer.qacc + state.com_bias_acceleration
    assert np.allclose(fall, [0.0, 0.0, -GRAVITY], atol=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_shares_that_overflow_are_not_found_and_raise_nothing(seed):
    """A body that is thrown about asks for more than numbers hold."""
    rng, huge = np.random.default_rng(seed), 1e200
    program = ShareProgram.of(
        rng.normal(size=(6, 12)), huge * np.eye(6), np.full(12, 1e-3), huge * rng.normal(size=12)
    )
    program = program.and_rows(
        rng.normal(size=(2, 12)), 1e-9 * np.eye(2), huge * rng.normal(size=2)
    )
    with np.errstate(all="ignore"):
        assert not ShareSolver().solve(program)[2]
