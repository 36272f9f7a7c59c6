"""Ground forces of a long recording: in windows, alike, in the memory of one window."""

import tracemalloc
from unittest.mock import patch

import numpy as np
import pytest

from plantigrade.dynamics import force_windows
from plantigrade.dynamics.force_scales import ForceScales
from plantigrade.dynamics.force_windows import solve_in_windows, windows
from plantigrade.dynamics.loading import find_loading
from plantigrade.dynamics.required_forces import required_forces
from plantigrade.motion import Motion
from tests.analyze.plated_walk import plated_walk


def solved(length):
    """Return the forces of a walk of 340 frames in windows of a length, and the memory's peak."""
    plated = plated_walk()
    human, time = plated.walk.human, plated.walk.time
    motion = Motion(
        time, plated.qpos, plated.qvel, human.joint_names, plated.qacc, plated.walk.events
    )
    contacts = find_loading(human, motion).contacts
    needs = required_forces(human, motion, plated.qacc, contacts)
    tracemalloc.start()
    with (
        patch.object(force_windows, "MAX_WINDOW_FRAMES", length),
        patch.object(force_windows, "WINDOW_OVERLAP_S", 0.5),
    ):
        found = solve_in_windows(human, needs, contacts, (), None, ForceScales.of(walks=True))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return found, peak


def test_windows_find_the_same_forces_in_less_memory():
    (whole, all_at_once), (parts, one_window) = solved(2000), solved(180)
    assert parts.wrench.shape == whole.wrench.shape
    off = parts.wrench[..., :3] - whole.wrench[..., :3]
    assert np.sqrt(np.mean(off**2)) < 0.01  # [BW]
    assert np.abs(off).max() < 0.12
    assert parts.noise == pytest.approx(whole.noise, rel=0.2)
    np.testing.assert_allclose(parts.shift, whole.shift, atol=3e-3)
    assert parts.spread.force.mean() == pytest.approx(whole.spread.force.mean(), rel=0.2)
    assert one_window < 0.7 * all_at_once


@pytest.mark.parametrize("n", [4, 2000, 2001, 30_000])
def test_every_frame_is_kept_once(n):
    kept = [np.arange(n)[window][part] for window, part in windows(n, margin=75)]
    np.testing.assert_array_equal(np.concatenate(kept), np.arange(n))
    assert (
        max(w.stop - w.start for w, _ in windows(n, margin=75)) <= force_windows.MAX_WINDOW_FRAMES
    )
