"""Curves of a run as CSV: what the report draws, in units that the columns name."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from plantigrade import export
from plantigrade.analyze.statistics import mean_sd
from plantigrade.errors import FileError, ParameterError
from plantigrade.motion.cycles import normalise
from plantigrade.pages.section import ReportedRun


def columns(path) -> dict[str, np.ndarray]:
    """Return a table by column; an empty field is NaN."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    found = {}
    for name in rows[0]:
        words = [row[name] for row in rows]
        found[name] = (
            np.array(words) if name == "side" else np.array([float(w or "nan") for w in words])
        )
    return found


@pytest.fixture
def standing(walk):
    """The same motion without events, hence without gait cycles."""
    record = walk.record
    return replace(walk, record=replace(record, motion=replace(record.motion, events=())))


def test_over_time_it_holds_angles_and_loads(walk, tmp_path):
    walk.export(tmp_path / "walk.csv")
    table, record = columns(tmp_path / "walk.csv"), walk.record
    motion, human = record.motion, record.human
    assert table["time_s"] == pytest.approx(motion.time, abs=1e-6)
    assert table["knee_angle_r_deg"] == pytest.approx(np.rad2deg(motion["knee_angle_r"]), abs=1e-4)
    assert table["pelvis_ty_m"] == pytest.approx(motion.qpos[:, 2], abs=1e-6)
    force = record.foot("l").force[:, 2] / record.weight
    known = np.isfinite(table["ground_force_up_l_bw"])
    assert known.mean() > 0.5
    assert table["ground_force_up_l_bw"][known] == pytest.approx(force[known], abs=1e-5)
    moment = table["knee_angle_moment_r_nm_kg"]
    known = np.isfinite(moment)
    assert moment[known] == pytest.approx(
        record.torque("knee_angle_r")[known] / human.mass, abs=1e-5
    )
    power = moment * motion.velocity("knee_angle_r")
    assert table["knee_angle_power_r_w_kg"][known] == pytest.approx(power[known], abs=1e-4)


def test_every_cycle_starts_and_ends_at_its_heel_strikes(walk, tmp_path):
    walk.export(tmp_path / "walk.csv", over="cycles")
    table, record = columns(tmp_path / "walk.csv"), walk.record
    for side in "rl":
        strikes = [
            e.time for e in record.motion.events if (e.side, e.kind) == (side, "heel_strike")
        ]
        mine = table["side"] == side
        assert table["cycle"][mine].max() == len(strikes) - 1
        first = mine & (table["cycle"] == 1)
        assert table["percent"][first] == pytest.approx(np.arange(101))
        assert table["start_s"][first] == pytest.approx(strikes[0], abs=1e-5)
        assert 50 < table["toe_off_pct"][first][0] < 70
        sign = 1 if side == "r" else -1  # left and right read alike
        for column, name, factor in (
            ("hip_flexion_deg", f"hip_flexion_{side}", 1),
            ("lumbar_bending_deg", "lumbar_bending", sign),
        ):
            angle = np.rad2deg(normalise(record.motion.time, record.motion[name], *strikes[:2]))
            assert table[column][first] == pytest.approx(factor * angle, abs=1e-4)


def test_the_mean_cycle_is_what_the_report_draws(walk, tmp_path):
    export(walk, tmp_path / "walk.csv", over="mean")
    table, subject = columns(tmp_path / "walk.csv"), ReportedRun(walk)
    drawn = subject.force_curves
    for side in "rl":
        mine = table["side"] == side
        assert mine.sum() == 101
        pairs = {
            "knee_angle_deg": subject.angle_curves.angles[f"knee_angle_{side}"],
            "pelvis_list_deg": subject.clinical_angles[f"pelvis_list_{side}"],
            "foot_progression_deg": subject.clinical_angles[f"foot_progression_{side}"],
            "ankle_angle_moment_nm_kg": drawn.moments[f"ankle_angle_{side}"],
            "hip_flexion_power_w_kg": drawn.powers[f"hip_flexion_{side}"],
            "ground_force_forward_bw": drawn.forces[f"forward_{side}"],
            "ground_force_sideways_bw": drawn.forces[f"left_{side}"],
        }
        for column, rows in pairs.items():
            mean = mean_sd(rows)[0]
            assert np.isfinite(mean).any()
            assert table[column][mine] == pytest.approx(mean, rel=1e-6, abs=1e-6, nan_ok=True)
        assert np.nanmax(table["ground_force_up_bw"][mine]) > 0.9


def test_a_motion_without_cycles_has_none_to_export(standing, tmp_path):
    with pytest.raises(FileError, match="no complete gait cycle — .*over time"):
        standing.export(tmp_path / "standing.csv", over="cycles")
    standing.export(tmp_path / "standing.csv")
    assert len(columns(tmp_path / "standing.csv")["time_s"]) == standing.record.motion.n_frames


def test_estimated_forces_are_omitted_unless_requested(walk, tmp_path):
    n = walk.record.motion.n_frames
    nothing = {"forces.measured": np.zeros((n, 2), dtype=bool)}
    bands = {
        name: np.zeros((n, *shape))
        for name, shape in (
            ("forces.band", (2, 3)),
            ("forces.point_band", (2, 2)),
            ("forces.torque_band", (2,)),
            ("forces.moment_band", (walk.record.human.model.nv,)),
        )
    }
    record = replace(walk.record, signals={**walk.record.signals, **nothing, **bands})
    estimated = replace(walk, record=record)
    estimated.export(tmp_path / "out.csv")
    assert np.isnan(columns(tmp_path / "out.csv")["ground_force_up_r_bw"]).all()
    estimated.export(tmp_path / "out.csv", estimated=True)
    assert np.nanmax(columns(tmp_path / "out.csv")["ground_force_up_r_bw"]) > 0.9


def test_options_and_names_are_checked(walk, tmp_path):
    with pytest.raises(ParameterError, match="over='stride' must be one of time, cycles, mean"):
        walk.export(tmp_path / "walk.csv", over="stride")
    with pytest.raises(ParameterError, match="no option 'rate'; .*it has over, estimated"):
        walk.export(tmp_path / "walk.csv", rate=100)
    with pytest.raises(FileError, match="there is no folder"):
        walk.export(tmp_path / "no" / "walk.csv")
    assert not list(tmp_path.iterdir())
