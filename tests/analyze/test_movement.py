"""Figures of a movement: what repeats is measured once."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze.movement import movement_figures
from tests.analyze.standing import standing_record


def test_of_several_flights_the_first_is_measured():
    record = standing_record()
    t = record.motion.time
    planned = np.ones((len(t), len(record.sites)), bool)
    assert "flight_time_s" not in movement_figures(replace(record, contact_planned=planned))
    third = len(t) // 3
    planned[third : third + 4] = planned[2 * third : 2 * third + 6] = False
    found = movement_figures(replace(record, contact_planned=planned))
    assert found["flight_time_s"] == pytest.approx(t[third + 3] - t[third - 1])
