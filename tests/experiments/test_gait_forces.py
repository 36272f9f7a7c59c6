"""The table of gaits rebuilt by forces, on the shortest of its walks."""

import pytest

from experiments import gait_forces
from experiments.table import Row, mean_rows


def test_means_are_held_against_the_goals_of_their_quantity():
    quantity = "centre of pressure, backward in a stance"
    rows = [Row(str(k), quantity, 10.0 * k, "mm") for k in (1, 2)]
    rows += [Row("1", "tick", 3.0, "ms"), Row("2", "tick", None)]
    near, tick = map(gait_forces.judged, mean_rows("mean", rows))
    assert (near.value, near.goal, near.met) == (15.0, "<= 20", True)
    assert (tick.value, tick.goal, tick.met) == (3.0, "", None)
    assert gait_forces.judged(Row("3", quantity, 30.0, "mm")).met is False


@pytest.mark.slow
def test_a_walk_over_plates_has_all_its_rows(data):
    name = min(gait_forces.QUICK_TRIALS, key=lambda name: (data / name).stat().st_size)
    rows = {row.quantity: row.value for row in gait_forces.trial_rows(data / name, name)}
    assert 0 < rows["vertical force, RMSE"] < 0.08 and rows["vertical force, r"] > 0.95
    # it once was .62, 75 mm, .47
    assert rows["forward force, r"] > 0.97
    assert rows["centre of pressure, backward in a stance"] < 20
    assert rows["knee_angle moment, r"] > 0.85 and rows["hip_flexion moment, r"] > 0.75
    assert rows["centre of mass, greatest error"] < 15 and rows["inside all limits"] == 1
    assert rows["root residual"] < 1e-6 and rows["one tick, median"] > 0
