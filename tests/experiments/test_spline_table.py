"""The table of the spline paper's motions: measured knees, one motion on both bases."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from experiments import spline_table
from plantigrade.trajopt.zhakatayev2023 import MOTIONS


def test_measured_knees_bend_in_swing(data):
    knees = spline_table.measured_knees(data)
    assert knees
    for angle in knees.values():
        assert angle.shape == (100,)
        assert 50 < angle.max() < 80  # swing
        assert 65 < np.argmax(angle) < 80
        assert angle[:60].min() < 20  # stance


@pytest.mark.slow
def test_one_motion_on_both_bases(monkeypatch, tmp_path):
    only = {"side-step": MOTIONS["side-step"]}
    monkeypatch.setattr(spline_table, "MOTIONS", only)
    monkeypatch.setattr(spline_table, "FIGURES", {"side-step": 7})
    said = []
    table = spline_table.run(None, out=tmp_path, say=said.append)
    metrics = table.metrics()
    for basis in ("trigonometric", "polynomial"):
        assert metrics[f"side_step_{basis}_variables"] == 387
        assert metrics[f"side_step_{basis}_constraints"] == 2372
        assert metrics[f"side_step_{basis}_solved"] == 1.0
        assert metrics[f"side_step_{basis}_violation"] < 2e-5
    assert len(said) >= 6  # three stages on either basis
    assert "between them at worst" in table.text()
    for letter in "abcd":
        ET.parse(tmp_path / f"figure7{letter}.svg")
