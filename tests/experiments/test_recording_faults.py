"""Faults are put into recordings, and outcomes are counted by halves of the people."""

from dataclasses import replace

import numpy as np
import pytest

from experiments import recording_faults
from experiments.recording_faults import FAULTS, PARTS, experiment, half_of
from tests.analyze.plated_walk import analyse, plated_walk


@pytest.fixture(scope="module")
def trial():
    fit = plated_walk().fit()
    recording = replace(fit.recording, subject=replace(fit.recording.subject, mass=None))
    return analyse(replace(fit, recording=recording))


def test_forces_are_scaled_where_the_fault_says(trial):
    recording = trial.fit.recording
    peak = max(plate.force[:, 2].max() for plate in recording.plates)
    halved = FAULTS["halved, no body mass"].make(recording, trial)
    assert halved is not None
    assert max(plate.force[:, 2].max() for plate in halved.plates) == pytest.approx(peak / 2)
    cane = FAULTS["cane of 15 %"].make(recording, trial)
    assert cane is not None
    shares = [new.force[:, 2].sum() / old.force[:, 2].sum()
              for new, old in zip(cane.plates, recording.plates, strict=True)]  # fmt: skip
    assert min(shares) == pytest.approx(0.86, abs=0.02) and max(shares) > 0.95


def test_outcomes_are_counted_for_both_halves(tmp_path, monkeypatch):
    for name in ("HC032A03", "other"):
        (tmp_path / f"{name}.c3d").touch()
    outcomes = {"": "silent", "right knee 4 cm low": "named", "both knees 4 cm low": "silent"}
    found = lambda path, name: {"outcome": outcomes.get(name, ""), "said": []}  # noqa: E731
    monkeypatch.setattr(recording_faults, "outcome", found)
    table = experiment(tmp_path).run(parts=("sound", "markers"))
    figures = {(row.subject, row.quantity): row.value for row in table.rows}
    assert half_of(tmp_path / "HC032A03.c3d") == "settled on"
    for half in ("settled on", "others"):
        assert figures[half, "sound, accused"] == 0
        assert figures[half, "right knee 4 cm low, named"] == 100
        assert figures[half, "both knees 4 cm low, named"] == 0
    assert len(FAULTS) == sum(map(len, PARTS.values())) and np.isfinite(len(table.text()))
