"""Constants settled without one source of recordings."""

import numpy as np

from experiments.left_out import CURVES, Measured, measured, settled
from plantigrade.dynamics.force_scales import PHASE, UsualStance
from tests.analyze.plated_walk import analyse, plated_walk

NOTHING = (np.empty(0), np.empty(0))


def showing(**curves) -> Measured:
    return Measured({name: curves.get(name, NOTHING) for name in CURVES})


def level(value: float) -> tuple[np.ndarray, np.ndarray]:
    place = np.repeat(PHASE, 5)
    return place, np.full(len(place), value)


def test_each_person_counts_once():
    first, second = showing(rear_share=level(0.2)), showing(rear_share=level(0.6))
    found = settled([[first, first], [second]])
    np.testing.assert_allclose(found.rear_share, 0.4)


def test_what_nobody_shows_stays_as_shipped():
    early = showing(cop_forward=tuple(x[:25] for x in level(0.3)))
    found, shipped = settled([[early]]), UsualStance()
    np.testing.assert_allclose(found.cop_forward[:5], 0.3)
    assert found.cop_forward[5:] == shipped.cop_forward[5:]
    assert found.roll_over == shipped.roll_over
    assert found.cop_forward_spread == shipped.cop_forward_spread


def test_curves_of_a_walk_are_those_its_plates_measured():
    """The load of this walk passes from foot to foot in a straight line."""
    found = measured(analyse(plated_walk().fit(), without_plates=True))
    phase, share = found.of["rear_share"]
    middle = (phase > 0.25) & (phase < 0.75)
    assert middle.sum() > 20
    slope, _ = np.polyfit(phase[middle], share[middle], 1)
    assert -2.0 < slope < -0.6
    assert np.corrcoef(phase[middle], share[middle])[0, 1] < -0.95
