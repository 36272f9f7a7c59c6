"""Times as unknowns: the gradient from the multipliers, bounds, stopping, and what is found."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.trajopt import MotionTask, make_task, synthesize
from plantigrade.trajopt.free_times import (
    SearchSettings,
    cost_gradient,
    find_times,
    lagrangian,
    placed,
    unit_of_cost,
)
from plantigrade.trajopt.tasks.free_time import FreeTime
from plantigrade.trajopt.tasks.gait_parameters import (
    free_walking_times,
    gait_parameters,
    with_walking_times,
)
from plantigrade.trajopt.tasks.walking import periodic_walk
from tests.trajopt import coarse_walk

EXACT = 1e-6  # [1] error of the optimality conditions at which costs may be differenced
TIMES = free_walking_times(gait_parameters(coarse_walk.person(), coarse_walk.SPEED))


def walk(times: Mapping[str, float]) -> MotionTask:
    """Return a coarse walk of values of its times."""
    human = coarse_walk.person()
    p = with_walking_times(gait_parameters(human, coarse_walk.SPEED), times)
    made = periodic_walk(human, p)
    return replace(made, nodes_per_second=coarse_walk.NODES_PER_SECOND)


@pytest.mark.solver
def test_the_gradient_is_that_of_whole_solves():
    at, step = np.array([t.guess for t in TIMES]), np.array([2e-3, 5e-4, 5e-4])

    def exact(x):
        values = {t.name: float(v) for t, v in zip(TIMES, x, strict=True)}
        return replace(walk(values), tolerance=EXACT)

    body = coarse_walk.body()
    here = synthesize(body, exact(at))
    assert here.multipliers is not None
    value = lagrangian(here.problem, here.coefficients, here.forces, here.multipliers)
    assert value == pytest.approx(here.objective, rel=2e-3)  # the barrier's rest
    found = cost_gradient(here, exact, at, 1e-2 * step)
    for way in (step * [1, 0, 0], step * [0, 1, 0]):
        costs = []
        for task in (exact(at - way), exact(at + way)):
            made = synthesize(placed(body, task), task, warm=here, refinements=0)
            costs.append(made.objective / unit_of_cost(task))
        assert found @ way == pytest.approx((costs[1] - costs[0]) / 2, rel=0.05)


@pytest.mark.solver
def test_a_search_lowers_the_cost_within_its_bounds():
    found = find_times(coarse_walk.body(), walk, TIMES, settings=SearchSettings(solves=3))
    assert found.solution.success and not found.stopped
    assert min(found.costs) < found.costs[0] and len(found.costs) <= 3
    for t in TIMES:
        assert t.least <= found.times[t.name] <= t.most
    made = found.solution
    assert made.iterations > 0 and made.task.plan.duration > 0.0
    length = found.times["step_length"]
    assert made.task.plan.advance == pytest.approx(length)
    assert made.objective / length <= found.costs[0]


@pytest.mark.solver
def test_stopping_keeps_the_best_so_far():
    seen: list[str] = []

    def stop_in_the_second(stage, iterate):
        seen.append(stage)
        return stage.startswith("times 2")

    found = find_times(coarse_walk.body(), walk, TIMES, progress=stop_in_the_second)
    assert found.stopped and found.solution.success
    assert found.times == pytest.approx({t.name: t.guess for t in TIMES})
    assert sum(stage.startswith("times 2") for stage in seen) == 1
    found = find_times(coarse_walk.body(), walk, TIMES, progress=lambda stage, iterate: True)
    assert found.stopped and not found.solution.success


def test_costs_count_per_metre_where_a_motion_travels():
    human = coarse_walk.person()
    half, still = coarse_walk.task(), make_task("squat", human, {})
    assert unit_of_cost(half) == pytest.approx(half.plan.advance)
    assert unit_of_cost(still) == 1.0
    assert unit_of_cost(make_task("jump", human, {"distance": 0.3})) == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("least", "most", "guess"),
    [(2.0, 1.0, 1.5), (1.0, 1.0, 1.0), (1.0, 2.0, 3.0), (0.0, np.inf, 1)],
)
def test_bounds_that_leave_no_room_are_refused(least, most, guess):
    with pytest.raises(ParameterError, match="rise"):
        FreeTime("rise", float(least), float(most), float(guess))


def test_a_bound_at_which_the_task_cannot_be_is_refused():
    human = coarse_walk.person()
    body = make_task("sit-to-stand", human, {}).body_of(human)
    with pytest.raises(ParameterError, match="duration cannot be 0.5"):
        find_times(
            body,
            lambda times: make_task("sit-to-stand", human, dict(times)),
            [FreeTime("duration", 0.5, 3.0, 2.0)],
        )
