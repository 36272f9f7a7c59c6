"""The person of a run as an OpenSim model."""

from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from plantigrade.kinematics.state import PointSet
from plantigrade.motion import Markers
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD


def markers_of(path) -> dict[str, tuple[str, list[float]]]:
    """Return body and place of the markers of a model."""
    return {
        m.get("name"): (
            m.findtext("socket_parent_frame"),
            [float(x) for x in m.findtext("location").split()],
        )
        for m in ET.parse(path).iter("Marker")
    }


def test_markers_of_the_fit_sit_where_the_fit_put_them(walk, tmp_path):
    record = walk.record
    places = {"A1": ("tibia_r", [0.03, 0.05, -0.1]), "B2": ("torso", [0.1, 0.0, 0.2])}
    bodies, local = zip(*places.values(), strict=True)
    path = PointSet(record.human, bodies, np.array(local)).path(record.motion.qpos)
    path[:5, 1] = np.nan
    seen = Markers(tuple(places), record.motion.time, path + 0.01)
    record = replace(record, recorded_markers=seen, fitted_markers=path)
    assert replace(walk, record=record).export(tmp_path / "anna.osim") == ()
    found = markers_of(tmp_path / "anna.osim")
    for name, (body, position) in places.items():
        assert found[name][0] == f"/bodyset/{body}"
        assert OPENSIM_TO_WORLD @ found[name][1] == pytest.approx(position, abs=1e-9)


def test_a_run_without_markers_says_how_to_add_some(walk, tmp_path):
    (note,) = walk.export(tmp_path / "anna.osim")
    assert "--marker-set" in note and not markers_of(tmp_path / "anna.osim")
    assert walk.export(tmp_path / "anna.osim", marker_set="plug-in-gait") == ()
    assert "RASI" in markers_of(tmp_path / "anna.osim")
