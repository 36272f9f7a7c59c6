"""Joint coordinates: angles stay, stature and path follow from the feet."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plantigrade.errors import FileError, FitError
from plantigrade.io.mot import read_mot
from plantigrade.kinematics.coordinate_fit import fit_coordinates
from plantigrade.kinematics.sole_paths import lowest
from plantigrade.models import Human
from plantigrade.motion import Recording, Table


def own(height: float, drop: tuple[str, ...] = ()) -> tuple[Recording, np.ndarray]:
    """Return knee bends of a person of this height as a table of coordinates."""
    human = Human.create(height)
    n = 80
    q = np.tile(human.standing(), (n, 1))
    bend = 0.5 * np.sin(np.linspace(0, np.pi, n)) ** 2
    for side in "rl":
        q[:, 7 + human.hinge(f"hip_flexion_{side}")] = bend
        q[:, 7 + human.hinge(f"knee_angle_{side}")] = 2 * bend
        q[:, 7 + human.hinge(f"ankle_angle_{side}")] = bend
    q[:, 2] -= lowest(human, q)
    names, values = human.to_coordinates(q)
    keep = [i for i, name in enumerate(names) if name not in drop]
    table = Table(tuple(names[i] for i in keep), np.arange(n) / 50, values[:, keep])
    return Recording(Path("own.mot"), coordinates=table), q


@pytest.mark.parametrize("height", [1.45, 1.74, 1.95])
def test_stature_follows_from_the_pelvis_height(height):
    recording, q = own(height)
    fit = fit_coordinates(recording)
    assert abs(fit.human.height - height) < 0.01
    np.testing.assert_allclose(fit.qpos[:, 7:], q[:, 7:], atol=1e-9)
    assert fit.metrics["penetration_max_mm"] < 5


def test_without_translation_the_feet_tell_the_path():
    recording, q = own(1.74, ("pelvis_tx", "pelvis_ty", "pelvis_tz"))
    fit = fit_coordinates(recording)
    np.testing.assert_allclose(fit.qpos[:, 2], q[:, 2], atol=0.005)
    assert np.ptp(fit.qpos[:, 0] - q[:, 0]) < 0.01


def test_angles_beyond_the_limits_are_clipped_with_a_note():
    recording, _ = own(1.74)
    table = recording.coordinates
    table.values[:, table.names.index("knee_angle_r")] = np.deg2rad(-35)
    fit = fit_coordinates(recording)
    assert any("knee_angle_r by up to 20.0°" in w for w in fit.warnings)


def test_forces_are_no_motion(data):
    for file in (
        "gait2392_subject01/subject01_walk1_grf.mot",
        "moco_2d_walking/referenceGRF.sto",
        "rajagopal_walk/id_walk.sto",
    ):
        with pytest.raises((FitError, FileError), match="coordinates"):
            fit_coordinates(read_mot(data / "opensim" / file))


@pytest.mark.parametrize(
    ("file", "low", "high"),
    [
        ("gait2392_subject01/std_subject01_walk1_ik.mot", 1.72, 1.88),  # the subject is 1.80 m
        ("gait2392_subject01/subject01_walk_IK_10dof.mot", 1.72, 1.88),
        ("gait2392_subject01/normal_gait.mot", 1.4, 2.0),
        ("gait2392_subject01/crouch_gait.mot", 1.4, 2.0),
        ("moco_2d_walking/referenceCoordinates.sto", 1.4, 2.0),
        ("opencap_squat/squats1_videoAndMocap.mot", 1.5, 2.1),
        ("rajagopal_walk/coordinates.sto", 1.5, 2.0),
    ],
)
def test_coordinate_files_stand_on_the_ground(data, file, low, high):
    fit = fit_coordinates(read_mot(data / "opensim" / file))
    assert low < fit.human.height < high
    bottom = lowest(fit.human, fit.qpos)
    assert np.abs(np.median(bottom)) < 0.015
    assert bottom.min() > -0.05
    limits = fit.human.limits
    assert (fit.qpos[:, 7:] >= limits[0]).all() and (fit.qpos[:, 7:] <= limits[1]).all()


def test_gait_without_translation_walks_forward(data):
    """A stride of normal walking is between one and one and a half metres long."""
    fit = fit_coordinates(read_mot(data / "opensim" / "gait2392_subject01" / "normal_gait.mot"))
    assert 0.7 < fit.qpos[-1, 0] - fit.qpos[0, 0] < 1.7


def test_angles_that_wrap_are_led_on(data):
    """A hip that steps by a whole turn is the hip it was, not one at its limit."""
    whole = read_mot(data / "opensim" / "gait2392_subject01" / "normal_gait.mot")
    table = whole.coordinates
    assert table is not None
    values = table.values.copy()
    column = table.names.index("hip_rotation_r")
    values[40:60, column] += 2 * np.pi
    wrapped = replace(whole, coordinates=replace(table, values=values))
    fit, good = fit_coordinates(wrapped), fit_coordinates(whole)
    np.testing.assert_allclose(fit.qpos, good.qpos, atol=1e-9)
    assert any("hip_rotation_r" in w and "full turn" in w for w in fit.warnings)
