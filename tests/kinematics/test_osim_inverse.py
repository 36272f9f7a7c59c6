"""Inverse kinematics on a person's own OpenSim model."""

import numpy as np
import pytest

from plantigrade.errors import FitError
from plantigrade.io.osim_body import OsimHuman
from plantigrade.kinematics.osim_inverse import fit_osim
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.markers import MARKER_SETS, places_of
from plantigrade.models.osim import to_osim
from plantigrade.motion import Markers


@pytest.fixture(scope="module")
def person() -> OsimHuman:
    human = Human.create(1.7, 65.0, joints="42", feet="rigid")
    return OsimHuman.of(to_osim(human, places_of(MARKER_SETS["rajagopal"], human)))


def recorded(person: OsimHuman, n: int = 5, heading: float = 2.6) -> tuple[np.ndarray, Markers]:
    """Return coordinates over time and the markers of a person in that motion."""
    time = 0.01 * np.arange(n)
    names = [c.name for c in person.every_coordinate]
    u = np.tile(person.defaults(), (n, 1))
    u[:, names.index("pelvis_rotation")] = heading
    u[:, names.index("pelvis_tx")] = 3.0 + time
    for name in ("hip_flexion_r", "knee_angle_l", "ankle_angle_r", "elbow_flex_l"):
        u[:, names.index(name)] = 0.3 + 2.0 * time
    points = PointSet.of(person, list(person.places.values()))
    return u, Markers(tuple(person.places), time, points.path(person.poses(u)))


def test_the_motion_behind_the_markers_is_found_in_any_heading(person):
    u, markers = recorded(person)
    found = fit_osim(person, markers)
    assert np.nanmax(found.residual) < 2e-4
    names = [c.name for c in person.every_coordinate]
    for name in ("hip_flexion_r", "knee_angle_l", "ankle_angle_r", "pelvis_tx", "elbow_flex_l"):
        k = names.index(name)
        assert found.u[:, k] == pytest.approx(u[:, k], abs=2e-3)


def test_gaps_are_interpolated_and_empty_ends_left_out(person):
    u, markers = recorded(person, 8)
    positions = markers.positions.copy()
    positions[[0, 4, 7]] = np.nan
    positions[:, 3] = np.nan
    found = fit_osim(person, Markers(markers.names, markers.time, positions))
    assert found.time == pytest.approx(markers.time[1:7])
    k = [c.name for c in person.every_coordinate].index("hip_flexion_r")
    assert found.u[:, k] == pytest.approx(u[1:7, k], abs=2e-3)
    assert any("interpolated" in note for note in found.notes)
    assert any("left out" in note for note in found.notes)


def test_too_few_shared_markers_are_refused_with_both_lists(person):
    _, markers = recorded(person, 2)
    names = tuple(f"my{k}" for k in range(len(markers.names)))
    with pytest.raises(FitError, match="share 0 marker names") as error:
        fit_osim(person, Markers(names, markers.time, markers.positions))
    assert "my0" in str(error.value) and "RASI" not in str(error.value)


def test_locked_and_clamped_coordinates_stay(person):
    head, tail = person.text.split('<Coordinate name="knee_angle_l">')
    tail = tail.replace("<locked>false</locked>", "<locked>true</locked>", 1)
    locked = OsimHuman.of(head + '<Coordinate name="knee_angle_l">' + tail)
    u, markers = recorded(person, 2)
    found = fit_osim(locked, markers)
    names = [c.name for c in locked.every_coordinate]
    assert np.all(found.u[:, names.index("knee_angle_l")] == 0.0)
    assert np.nanmax(found.residual) > 0.01
