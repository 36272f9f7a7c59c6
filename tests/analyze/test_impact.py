"""A force on the feet far above what people bear is a warning with both numbers."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze.impact import force_on_feet, impact_notes
from tests.pages.walker import walk, walker


@pytest.mark.parametrize(("peak", "warned"), [(4.9, False), (13.0, True)])
def test_only_forces_that_nobody_bears_are_an_impact(peak, warned):
    record = walk(walker())
    factor = peak / force_on_feet(record).max()
    record = replace(record, contact_force=factor * record.contact_force)
    notes = impact_notes(record)
    assert len(notes) == warned
    if warned:
        at = record.motion.time[np.argmax(force_on_feet(record))]
        assert f"13.0 body weights at {at:.2f} s" in notes[0] and "1.2 in walking" in notes[0]
