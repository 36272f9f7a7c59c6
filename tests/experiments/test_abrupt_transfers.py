"""Walks whose load goes over abruptly."""

import numpy as np
import pytest

from experiments.abrupt_transfers import COURSES, errors
from plantigrade.analyze import analyse
from plantigrade.dynamics import force_program
from plantigrade.workflows.fit import fit_trial


@pytest.mark.slow
@pytest.mark.solver
def test_a_transfer_in_the_end_is_found_by_faster_changes(data, monkeypatch):
    fit = fit_trial(data / "opensim/rajagopal_walk/markers_walk.trc")[1].fit
    walk = analyse(fit, mass=fit.human.mass, without_plates=True)
    found = errors(walk, "in the last 40 %")
    monkeypatch.setattr(force_program, "MIN_MISFIT_GAIN", np.inf)
    smooth = errors(walk, "in the last 40 %")
    assert found is not None and smooth is not None
    assert found[2] < smooth[2] and found[0] > smooth[0]


def test_courses_go_from_all_to_nothing():
    for phases, shares in COURSES.values():
        if phases:
            assert (phases[0], phases[-1], shares[0], shares[-1]) == (0.0, 1.0, 1.0, 0.0)
            assert (np.diff(phases) > 0).all() and (np.diff(shares) <= 0).all()
