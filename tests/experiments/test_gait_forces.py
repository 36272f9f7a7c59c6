"""The table of gaits rebuilt by forces, on the shortest of its walks."""

import pytest

from plantigrade.experiments import gait_forces


@pytest.mark.slow
def test_a_walk_over_plates_has_all_its_rows(data):
    name = min(gait_forces.QUICK, key=lambda name: (data / name).stat().st_size)
    rows = {row.quantity: row.value for row in gait_forces.trial_rows(data / name, name)}
    assert 0 < rows["vertical force, RMSE"] < 0.15 and rows["vertical force, r"] > 0.9
    assert rows["root residual"] < 1e-6 and rows["one tick, median"] > 0
