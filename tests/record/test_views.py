"""Figures and tables of a Motion, a Record and a Run."""

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from plantigrade.errors import CoordinateNotFound, ParameterError
from plantigrade.record import Run
from plantigrade.record.views import columns_of
from tests.pages.walker import walk, walker


@pytest.fixture(scope="module")
def record():
    """A walk with forces, torques and one signal."""
    made = walk(walker(), duration=1.2)
    return replace(
        made, signals={"controller.landing_time": np.arange(made.motion.n_frames) * 1e-6}
    )


def test_a_motion_draws_both_sides_of_a_stem(record):
    figure = record.motion.plot("knee_angle", "pelvis_tx")
    drawing = ElementTree.fromstring(figure._repr_svg_())
    assert len(drawing) == 2 and "Knee flexion" in figure.svg and "Pelvis forward" in figure.svg
    assert "right" in figure.svg and "left" in figure.svg
    one = record.motion.plot("knee_angle_r").svg
    assert "right" in one and ">left<" not in one
    assert record.motion.plot().svg.count("<svg ") > 4
    with pytest.raises(CoordinateNotFound, match="no coordinate 'knee'"):
        record.motion.plot("knee")


def test_a_record_draws_forces_moments_and_signals(record):
    svg = record.plot(
        "ground_force_up", "knee_angle_moment", "controller.landing_time", "hip_flexion"
    ).svg
    for words in (
        "Ground force, vertical",
        "Knee flexion moment",
        "Controller.landing time",
        "[s]",
        "Hip flexion",
    ):
        assert words in svg
    bare = replace(record, contact_force=None, qfrc_actuator=None)
    with pytest.raises(ParameterError, match="no ground forces"):
        bare.plot("ground_force_up")
    with pytest.raises(ParameterError, match="no joint torques"):
        bare.plot("knee_angle_moment_r")
    with pytest.raises(CoordinateNotFound, match="ground_force"):
        record.plot("ground_force_down")


def test_the_drawn_force_is_the_record_s(record):
    from plantigrade.record.views import columns_of

    columns = columns_of(record)
    np.testing.assert_array_equal(columns["ground_force_up_l"], record.foot("l").force[:, 2])
    np.testing.assert_array_equal(columns["knee_angle_r"], record.motion["knee_angle_r"])
    np.testing.assert_array_equal(columns["knee_angle_r_moment"], record.torque("knee_angle_r"))
    np.testing.assert_array_equal(
        columns["controller.landing_time"], record.signals["controller.landing_time"]
    )


def test_short_tables_for_a_notebook(record):
    run = Run(record, "fit", title="A <walk>", sentence="It was & is.", status="ok")
    for shown in (record.motion, record, run):
        ElementTree.fromstring(shown._repr_html_())
    assert "A &lt;walk&gt;" in run._repr_html_() and "1.20 s" in record._repr_html_()


def test_a_dataframe_has_a_row_per_frame(record):
    pytest.importorskip("pandas")
    table = record.to_dataframe()
    assert len(table) == record.motion.n_frames and table.index.name == "time"
    np.testing.assert_array_equal(table["knee_angle_r"], record.motion["knee_angle_r"])
    angles = record.motion.to_dataframe()
    assert list(angles.columns) == list(record.motion.coordinates)


def test_columns_say_which_forces_were_measured(record):
    (n, nv), is_measured = record.motion.qvel.shape, np.zeros((record.motion.n_frames, 2), bool)
    is_measured[: n // 2, 1] = True
    bands = {
        "forces.measured": is_measured,
        "forces.band": np.zeros((n, 2, 3)),
        "forces.point_band": np.zeros((n, 2, 2)),
        "forces.torque_band": np.zeros((n, 2)),
        "forces.moment_band": np.zeros((n, nv)),
    }
    found = columns_of(replace(record, signals=bands))
    assert not found["ground_force_measured_r"].any()
    np.testing.assert_array_equal(found["ground_force_measured_l"], is_measured[:, 1])
    assert "ground_force_measured_r" not in columns_of(record)


def test_a_dataset_has_named_dimensions(record):
    pytest.importorskip("xarray")
    data = record.to_xarray()
    knee = data["torque"].sel(hinge="knee_angle_l").values
    np.testing.assert_array_equal(knee, record.torque("knee_angle_l"))
    up = data["contact_force"].sel(site="plate_r", axis="up").values
    np.testing.assert_array_equal(up, record.contact_force[:, 0, 2])
    assert "controller.landing_time" in data and data.sizes["time"] == record.motion.n_frames
