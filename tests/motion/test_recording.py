"""A Recording is described by what its file holds."""

from pathlib import Path

import numpy as np

from plantigrade.motion import GaitEvent, Markers, Recording


def test_a_recording_is_described_in_one_line():
    markers = Markers(("LASI", "RASI"), np.array([0.0, 0.01, 0.02]), np.zeros((3, 2, 3)))
    events = (GaitEvent(0.01, "r", "heel_strike"),)
    recording = Recording(Path("trials/walk.c3d"), markers=markers, events=events)
    assert repr(recording) == "Recording(walk.c3d: 2 markers in 3 frames, 1 gait event)"
    assert repr(Recording(Path("empty.c3d"))) == "Recording(empty.c3d: no motion)"
