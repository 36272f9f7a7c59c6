"""Markers of no person are refused with the likely cause; a person in any place or turn is not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.errors import FitError
from plantigrade.kinematics.plausibility import (
    lean_notes,
    require_human_size,
    require_one_person,
    verdict,
    without_far_samples,
)
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers, Recording

TRUNK = ("asis_r", "asis_l", "psis_r", "psis_l", "c7", "t10", "suprasternale", "xiphoid")


@pytest.fixture(scope="module")
def trunk():
    """Return positions of trunk markers on a standing person."""
    from plantigrade.kinematics.state import PointSet

    human = Human.create(1.7, 65.0, "female")
    table = attachments(human)
    places = [table[name] for name in TRUNK]
    points = PointSet(human, [p.body for p in places], np.array([p.position for p in places]))
    return points.path(human.standing()[None])[0]


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_wrong_unit_is_named(trunk, unit):
    with pytest.raises(FitError, match="unit of length"):
        require_human_size(unit * trunk[None], "walk.trc")


def test_out_of_reach_is_named(trunk):
    with pytest.raises(FitError, match="from the origin"):
        require_human_size(trunk[None] + 1e9, "walk.trc")


def test_two_people():
    names = [f"{who}:M{i}" for who in ("Ann", "Ben") for i in range(6)]
    with pytest.raises(FitError, match="Ann, Ben"):
        require_one_person(names, "walk.c3d")
    require_one_person(names[:6] + ["Wand:1"], "walk.c3d")


def test_one_faulty_frame_is_left_out_and_running_is_not():
    time = np.arange(50) / 50
    x = np.array([[0, 0, 1.0], [0, 0.3, 0], [0.2, 0, 1.6]])[None] + np.zeros((50, 1, 3))
    x[:, :, 0] += 10 * time[:, None]  # a sprint
    whole = Recording(Path("sprint.c3d"), markers=Markers(("a", "b", "c"), time, x))
    assert without_far_samples(whole)[1] == 0
    broken = x.copy()
    broken[20] += 1e4
    broken[30, 1] += 5
    cleaned, count = without_far_samples(
        replace(whole, markers=Markers(("a", "b", "c"), time, broken))
    )
    assert count == 4
    assert cleaned.markers is not None
    assert np.isnan(cleaned.markers.positions[20]).all()
    np.testing.assert_array_equal(cleaned.markers.positions[31], x[31])


def test_lean():
    upright = np.eye(3)[None]
    assert not lean_notes(upright)
    lying = Rotation.from_euler("y", [[90]], degrees=True).as_matrix()
    assert "lying" in lean_notes(lying)[0]
    on_the_head = Rotation.from_euler("x", [[180]], degrees=True).as_matrix()
    assert "upside down" in lean_notes(on_the_head)[0]


def test_verdict():
    assert verdict(0.01, "marker") == "ok" and verdict(None, "joint") == "ok"
    assert "355 mm" in verdict(0.3551, "marker")
    assert verdict(float("nan"), "marker") != "ok"
