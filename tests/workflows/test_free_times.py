"""Free times of ready tasks: found, checked, and said in the run."""

import pytest

from plantigrade import synthesize


@pytest.mark.slow
@pytest.mark.solver
def test_rising_from_a_chair_takes_the_time_that_costs_least():
    usual = synthesize("sit-to-stand")
    found = synthesize("sit-to-stand", free_time=("duration=1:3.5", "seat_off=0.15:0.6"))
    assert found.status == "ok"
    times, costs = found.figures["free_times"], found.figures["free_times_costs"]
    assert found.record.motion.duration == pytest.approx(times["duration"], abs=1e-6)
    assert times["duration"] != pytest.approx(usual.record.motion.duration, rel=0.01)
    assert min(costs) < costs[0]
    assert min(costs) < 0.99 * usual.figures["objective"]  # that of the usual times
    assert not found.figures["free_times_at_bounds"]
