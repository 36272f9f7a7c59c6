"""Measured forces that lean over whole strides."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze.force_tilt import force_tilt, levelled, tilt_note
from plantigrade.dynamics.inverse import inverse_dynamics
from tests.analyze.plated_walk import analyse, plated_walk


def leaning(forward: float, left: float):
    """Return the analysis of a walk whose plates lean by these shares of the load."""
    fit = plated_walk().fit()
    plates = tuple(
        replace(plate, force=plate.force + np.array([forward, left, 0.0]) * plate.force[:, 2:])
        for plate in fit.recording.plates
    )
    return analyse(replace(fit, recording=replace(fit.recording, plates=plates)))


def tilt_of(trial, forces=None):
    forces, motion = forces or trial.forces, trial.motion
    assert forces is not None and motion.qacc is not None
    moments = inverse_dynamics(trial.fit.human, motion.qpos, motion.qvel, motion.qacc, forces)
    return force_tilt(motion.time, forces, moments, trial.cycles)


@pytest.mark.parametrize(("lean", "word"), [((0.03, 0.0), "forward"), ((0.0, -0.03), "right")])
def test_forces_that_lean_are_named_and_levelled(lean, word):
    trial = leaning(*lean)
    found = tilt_of(trial)
    assert found is not None and trial.forces is not None
    np.testing.assert_allclose(found, lean, atol=4e-3)
    note = tilt_note(found)
    assert word in note and note in trial.notes
    level = tilt_of(trial, levelled(trial.forces, found))
    assert level is not None
    np.testing.assert_allclose(level, 0.0, atol=1e-9)


def test_upright_forces_are_not_named():
    trial = leaning(0.0, 0.0)
    assert not tilt_note(tilt_of(trial))


def test_nothing_is_said_without_a_whole_stride():
    trial = leaning(0.03, 0.0)
    assert trial.forces is not None
    hidden = replace(trial.forces, valid=np.zeros(len(trial.motion.time), bool))
    assert tilt_of(trial, hidden) is None and not tilt_note(None)
