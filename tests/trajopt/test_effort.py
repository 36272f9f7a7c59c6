"""Costs of effort agree with mechanics."""

import numpy as np
import pytest

from plantigrade.kinematics.state import BodyState
from plantigrade.trajopt import ProblemBuilder, make_task
from plantigrade.trajopt.problem.contact_body import TORQUE_SCALE
from plantigrade.trajopt.tasks.gait_parameters import gait_parameters
from plantigrade.trajopt.terms.effort import (
    MIN_INERTIA_SHARE,
    REFERENCE_STRENGTH,
    Acceleration,
    AnklePower,
    Jerk,
    Torque,
    Work,
    relative_inertia,
)
from tests.trajopt.coarse_walk import body, person, task


def builder() -> ProblemBuilder:
    return ProblemBuilder(body(), task().plan, np.linspace(0.0, 0.5, 6))


def test_inertia_is_that_of_the_energy_of_each_coordinate_alone():
    """Twice the kinetic energy at unit rate: of the body in flight, of leg and shank that turn."""
    human, names = person(), body().symbolic.names
    state = BodyState(human, human.model.qpos0)

    def twice_the_energy(i):
        rate = np.eye(human.model.nv)[i]
        return rate @ state.mass_matrix @ rate

    knee = twice_the_energy(6 + human.coordinates.index("knee_angle_r"))
    found = relative_inertia(human)
    assert found[names.index("pelvis_tx")] == pytest.approx(human.mass / knee)
    for name in ("knee_angle_l", "hip_flexion_r", "hip_adduction_l", "lumbar_extension"):
        own = twice_the_energy(6 + human.coordinates.index(name))
        assert found[names.index(name)] == pytest.approx(max(own / knee, MIN_INERTIA_SHARE))
    assert found.min() == MIN_INERTIA_SHARE
    # A body upright turns more easily about its long axis than it tilts or lists.
    assert found[names.index("pelvis_rotation")] < 0.3 * found[names.index("pelvis_tilt")]


def test_jerk_is_weighted_by_inertia_if_requested():
    plain, weighed = builder(), builder()
    Jerk(1e-9).add_to(plain)
    Jerk(1e-9, by_inertia=True).add_to(weighed)
    np.testing.assert_allclose(plain.jerk, 2e-9)
    np.testing.assert_allclose(weighed.jerk, 2e-9 * relative_inertia(person()))


def test_all_joints_cost_as_much_at_their_strength():
    made, human = builder(), person()
    Torque(3.0, by_strength=True).add_to(made)
    strength = np.abs(human.model.jnt_actfrcrange[1:]).max(axis=1)
    weight = made.family("muscle torque").weight[1] / made.weights[1]
    cost = 0.5 * weight * (strength / body().torque) ** 2
    np.testing.assert_allclose(cost, 3.0 * (REFERENCE_STRENGTH / TORQUE_SCALE) ** 2)


def test_power_of_the_ankle_costs_by_its_fourth_power_and_work_in_proportion():
    """Twice the power, 200 and 400 W, far above the rounding: 16 times the cost, and twice."""
    cost = {}
    for term in (Work(1.0), AnklePower(1.0)):
        b = builder()
        term.add_to(b)
        rate, square = b.family("work rate").gain[1, 0], b.family("squared power").weight[1, 0]
        cost[type(term)] = [rate * p + 0.5 * square * (p**2) ** 2 for p in (2.0, 4.0)]
    assert cost[Work][1] == pytest.approx(2.0 * cost[Work][0])
    assert cost[AnklePower][1] == pytest.approx(16.0 * cost[AnklePower][0])


def test_only_the_joints_that_are_named_cost_where_others_do_not():
    b = builder()
    Acceleration(1.0, {"pelvis_rotation": 2.0}, others=0.0).add_to(b)
    weight = b.family("accelerations").weight
    assert np.flatnonzero(weight.any(axis=0)).tolist() == [b.column("pelvis_rotation")]


def test_a_walk_is_as_smooth_for_its_steps_at_every_speed():
    """Jerk by the sixth power of the time of a step has the dimension of angles alone."""
    by_time = []
    for speed in (0.7, 1.3, 1.9):
        walk = make_task("walk", person(), {"speed": speed, "periodic": True})
        (jerk,) = (t for t in walk.terms if isinstance(t, Jerk))
        by_time.append(jerk.weight / gait_parameters(person(), speed).step_time ** 6)
    np.testing.assert_allclose(by_time, by_time[0])
