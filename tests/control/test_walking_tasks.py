"""Whole-body tasks of a walk: desired velocities of joints, and the cost of forces."""

import numpy as np
import pytest

from plantigrade.contact.site import contact_sites
from plantigrade.control.pendulum.tasks import WalkingTasks
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.spatial.conventions import tilt_to
from plantigrade.wbc import Rows, Touching, WholeBody

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")
TASKS = WalkingTasks(HUMAN, 0.9)


def test_a_point_that_hangs_over_the_ground_bears_nothing():
    """A person bows; the heel or toe that bore most of it is 3 mm up."""
    state = BodyState(HUMAN, HUMAN.standing())
    sites = [s for s in contact_sites(HUMAN) if s.side]
    points = PointSet.of(HUMAN, sites)
    low = state.position(points) - [[0.0, 0.0, s.radius] for s in sites]
    contacts = Touching(points.body, low, np.tile([0.0, 0.0, 1.0], (len(sites), 1)), 0.6)
    J, _, bias = state.touched(points.body, low)
    nv = HUMAN.model.nv
    rows = [Rows(J.reshape(-1, nv), -bias.ravel(), 900.0)]
    desired, weight = np.zeros(nv), np.repeat([0.0, 0.4], [3, nv - 3])
    desired[6 + HUMAN.hinge("lumbar_extension")] = -3.0

    def force(gap, limits=None):
        program = WholeBody(HUMAN, armature=0.02, limits=limits)
        cost = TASKS.force_cost(np.ones(len(gap), dtype=bool), gap)
        answer = program.solve(
            state, contacts, rows, desired=desired, weight=weight, force_weight=cost,
            torque_weight=TASKS.torque_cost,
        )  # fmt: skip
        assert answer.ok
        return answer.force[:, 2], answer

    on, _ = force(np.zeros(len(sites)))
    most = int(np.argmax(on))
    over, _ = force(np.where(np.arange(len(sites)) == most, 0.003, 0.0))
    assert over[most] < 0.05 * on[most] and over.sum() == pytest.approx(on.sum(), rel=0.02)
    few = np.clip(np.array(HUMAN.model.jnt_actfrcrange[1:]).T, -5.0, 5.0)
    _, weak = force(np.zeros(len(sites)), few)
    assert weak.limited > 0 and np.abs(weak.torque).max() <= 5.0 + 1e-9


@pytest.mark.parametrize(
    "part, scale, dcm_error, factor",
    [
        ("neck_", TASKS.settings.neck_error_scale, 0.0, 17.0),
        ("neck_", TASKS.settings.neck_error_scale, 9.0, 17.0),
        ("lumbar_", TASKS.settings.trunk_error_scale, 0.0, 1.0),
        ("lumbar_", TASKS.settings.trunk_error_scale, 9.0, 17.0),
    ],
)
def test_a_neck_that_is_off_costs_more_and_a_trunk_while_it_balances(
    part, scale, dcm_error, factor
):
    own = np.array([part in name for name in HUMAN.coordinates])
    lost, off = np.array([0.0, dcm_error]), np.where(own, 4 * scale, 0.0)
    costs = [TASKS.posture_cost(error, lost) for error in (np.zeros(len(own)), off)]
    ratio = (costs[1] / np.maximum(costs[0], 1e-9))[6:]
    assert ratio[own] == pytest.approx(factor) and ratio[~own] == pytest.approx(1.0)


def test_arms_are_free_to_balance_only_while_balance_is_lost():
    names, none = HUMAN.coordinates, np.zeros(len(HUMAN.coordinates))
    arms = np.array([name.startswith(("arm_", "elbow")) for name in names])
    full = TASKS.settings.weights.recovery_error * 0.9
    walks, hurt, lost = (
        TASKS.posture_cost(none, np.array([error, 0.0]))[6:] for error in (0.0, 0.5 * full, full)
    )
    assert (lost[arms] < hurt[arms]).all() and (hurt[arms] < walks[arms]).all()
    legs = np.array([name.startswith(("hip_", "knee_")) for name in names])
    np.testing.assert_allclose(walks[legs], lost[legs])
    np.testing.assert_allclose(TASKS.posture_cost(none, np.array([0.0, 9.0]))[6:], lost)


def test_a_foot_is_tilted_the_shortest_way_to_the_normal_of_the_ground():
    normal = np.array([0.2, -0.1, 1.0]) / np.linalg.norm([0.2, -0.1, 1.0])
    tilt, across = tilt_to(normal), np.cross([0.0, 0.0, 1.0], normal)
    np.testing.assert_allclose(tilt @ [0.0, 0.0, 1.0], normal)
    np.testing.assert_allclose(tilt @ tilt.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(tilt @ across, across, atol=1e-12)
