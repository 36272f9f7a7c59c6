"""Times of contact as unknowns: what costs least a metre, within bounds around usual ones."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.models import Human
from plantigrade.trajopt import ContactBody
from plantigrade.trajopt.optimise_timing import BOUNDS, optimise_timing
from plantigrade.trajopt.tasks.gait_parameters import gait_parameters
from plantigrade.trajopt.tasks.walking import periodic_walk

pytestmark = pytest.mark.solver


@pytest.mark.slow
def test_free_times_cost_no_more_and_stay_within_their_bounds():
    human = Human.create(height=1.7, mass=65.0, joints="42")
    start = gait_parameters(human, 1.1)

    def task(p):
        return replace(periodic_walk(human, p), nodes_per_second=12.0, basis="polynomial")

    body = ContactBody.for_plan(human, task(start).plan)
    found = optimise_timing(body, task, start, trials=5)
    assert found.solution.success
    assert min(found.costs) <= found.costs[0]
    assert len(found.costs) <= 6
    assert found.solution.iterations > 0 and found.solution.seconds > 0.0  # of every trial
    p = found.parameters
    assert abs(p.step_length / start.step_length - 1) <= BOUNDS["step_length"] + 1e-9
    assert abs(p.stance_fraction - start.stance_fraction) <= BOUNDS["stance"] + 1e-9
    np.testing.assert_allclose(p.step_length / p.step_time, start.speed)
    way = p.speed * found.solution.task.plan.duration
    assert found.solution.objective / way <= found.costs[0] * 1.05  # a finer mesh may cost more


def test_stopping_gives_the_best_so_far():
    human = Human.create(height=1.7, mass=65.0, joints="42")
    start = gait_parameters(human, 1.1)

    def task(p):
        return replace(periodic_walk(human, p), nodes_per_second=12.0, basis="polynomial")

    body = ContactBody.for_plan(human, task(start).plan)
    seen = []

    def stop(stage, iterate):
        seen.append(stage)
        return len(seen) > 3

    found = optimise_timing(body, task, start, trials=5, progress=stop)
    assert not found.solution.success
    assert len(seen) <= 12
