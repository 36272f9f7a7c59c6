"""What a report says about a walk: the run's own figures, beside the norms of its speed."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import norms
from plantigrade.analyze.clinical import clinical_angles
from plantigrade.analyze.curves import LOADED_JOINTS
from plantigrade.charts.theme import DOTTED
from plantigrade.pages.headline import headline_figures
from plantigrade.pages.run_pages import pages, strip_of
from plantigrade.pages.scene import assumed_bodies, build_scene
from plantigrade.pages.section import ReportedRun, draw_all
from plantigrade.pages.sections import SECTIONS
from plantigrade.pages.sections.cycles import chosen
from plantigrade.record import Limits, Run
from tests.analyze.plated_walk import analyse, plated_walk, without_plates


@pytest.fixture(scope="module")
def run():
    """The walk with plates, analysed."""
    trial = analyse(plated_walk().fit(), cutoff=None)
    return Run(trial.record(), "fit", title="T", sentence="S", figures=trial.figures)


def sections(run):
    """Sections by title."""
    return {section.title: section for section in draw_all(SECTIONS, ReportedRun(run))}


def test_the_table_holds_the_measures_of_the_run(run):
    table = sections(run)["Spatio-temporal measures"].rows
    rows = {row[0]: [cell.partition(" ±")[0] for cell in row[1:]] for row in table}
    m = run.figures
    assert float(rows["walking speed"][2]) == pytest.approx(m["walking_speed_m_s"], abs=0.01)
    assert m["walking_speed_m_s"] == pytest.approx(1.25, abs=0.03)
    assert float(rows["stance"][0]) == pytest.approx(m["stance_r_pct"], abs=0.05)
    # two steps make a stride, stance and swing a cycle
    steps = [float(cell) for cell in rows["step length"][:2]]
    assert sum(steps) == pytest.approx(float(rows["stride length"][0]), rel=0.03)
    assert float(rows["stance"][1]) + float(rows["swing"][1]) == pytest.approx(100, abs=0.1)
    assert ReportedRun(run).foot_off == {"r": m["stance_r_pct"], "l": m["stance_l_pct"]}


def test_curves_are_complete_and_in_their_units(run):
    found = sections(run)
    angles = [cell for row in found["Joint angles over the gait cycle"].grid for cell in row]
    angles = [cell for cell in angles if not isinstance(cell, str)]
    for title in ("Pelvis tilt", "Hip flexion", "Knee flexion", "Ankle dorsiflexion"):
        assert any(f">{title}</text>" in figure.svg for figure in angles)
    moments = found["Joint moments"].figures
    assert len(moments) == len(LOADED_JOINTS) and all("[N m/kg]" in f.svg for f in moments)
    assert all("[W/kg]" in f.svg for f in found["Joint powers"].figures)
    curves = ReportedRun(run).force_curves
    (up,) = (c for c in chosen(curves.percent, curves.forces, ("up",), "BW") if c.name[-1] == "r")
    assert up.name == "ground_force_up_r" and 0.9 < np.nanmax(up.values) < 1.6


def test_a_textbook_walk_lies_in_the_band_of_the_book(run):
    """The knee of the mean walk stays within two standard deviations of the published mean."""
    subject = ReportedRun(run)
    band = norms.norm("knee_angle", subject.speed_class)
    for side in ("r", "l"):
        values = subject.angle_curves.angles[f"knee_angle_{side}"]
        mean = np.interp(subject.angle_curves.percent, band.percent, band.mean)
        sd = np.interp(subject.angle_curves.percent, band.percent, band.sd)
        assert (np.abs(values.mean(axis=0) - mean) < 2 * sd).mean() > 0.9


@pytest.mark.parametrize("speed", [0.4, 0.9, 1.25, 1.8, 2.2])
def test_norms_are_those_of_the_speed(run, speed):
    d = run.record.human.dimensions
    leg = {f"length_{n}_m": getattr(d, n) for n in ("thigh", "shank", "ankle_height")}
    child = {"age_years": 9.0, "walking_speed_m_s": speed}
    walked = replace(run, figures={**run.figures, **leg, **child})
    expected = norms.speed_class(speed, sum(leg.values()))
    assert ReportedRun(walked).speed_class == expected
    off = norms.FOOT_OFF[expected]
    rows = {row[0]: row for row in sections(walked)["Spatio-temporal measures"].rows}
    assert rows["stance"][-1] == f"{off[0]} ± {off[1]}"


def test_without_forces_there_are_no_moments():
    trial = analyse(without_plates(plated_walk().fit()), cutoff=None)
    trial = replace(trial, ground=None, moments=None)  # as where forces are unknown
    found = sections(Run(trial.record(), "fit", figures=trial.figures))
    assert found["Joint angles over the gait cycle"].grid
    assert found["Joint moments"].missing and found["Joint powers"].missing
    assert "Ground reaction over the gait cycle" not in found


def test_without_a_cycle_nothing_is_said_of_walking(run):
    record = replace(run.record, motion=replace(run.record.motion, events=()))
    still = Run(record, "fit")
    found = sections(still)
    assert "Joint angles over the gait cycle" not in found
    assert found["Spatio-temporal measures"].missing
    assert found["Joint powers over time"].figures
    assert "knee" not in " ".join(headline_figures(ReportedRun(still)))


def test_missing_figures_are_left_out(run):
    """What a JSON file holds as null is no number."""
    unknown = replace(run, figures=dict.fromkeys(run.figures, None))
    assert sections(unknown)["Spatio-temporal measures"].missing
    for word in ("None", "nan"):
        assert f">{word}<" not in pages(unknown)["report.html"]


def test_pages_are_the_same_twice(run):
    assert pages(run) == pages(run)


def drawings(found) -> list[str]:
    """Return every drawing of some sections."""
    cells = [c for s in found for row in (s.figures, *s.grid) for c in row if hasattr(c, "svg")]
    return [cell.svg for cell in cells]


def test_curves_at_a_limit_are_hatched_and_assumed_ones_dotted(run):
    """Also over time, where there is no gait cycle; a sentence says what it means."""
    record, human = run.record, run.record.human
    qpos = record.motion.qpos.copy()
    k = human.hinge("knee_angle_l")
    qpos[:, 7 + k] = np.maximum(qpos[:, 7 + k], np.deg2rad(20))
    low, high = human.limits.copy()
    low[k] = np.deg2rad(20)
    record = replace(
        record,
        motion=replace(record.motion, qpos=qpos),
        limits=Limits(coordinate=np.array([low, high])),
    )
    figures = {**run.figures, "assumed_joints": ["arm_flex_r"]}
    walks = replace(run, record=record, figures=figures)
    still = replace(record, motion=replace(record.motion, events=()))
    for one, titles in (
        (walks, ("Joint angles over the gait cycle", "Trunk and arms over the gait cycle")),
        (replace(walks, record=still), ("Joint angles", "Other joint angles")),
    ):
        found = [sections(one)[title] for title in titles]
        plots = drawings(found)
        hatched = [svg for svg in plots if 'class="hatched"' in svg]
        assert len(hatched) == 1 and ">Knee flexion</text>" in hatched[0]
        dotted = [svg for svg in plots if f'stroke-dasharray="{DOTTED}"' in svg]
        assert len(dotted) == 1 and ">Shoulder flexion</text>" in dotted[0]
        words = " ".join(section.text for section in found)
        assert "Hatched: the joint is at a limit" in words and "Dotted: assumed" in words
    before = drawings(sections(run).values())
    assert not any('class="hatched"' in svg for svg in before)


def test_assumed_parts_of_the_body_are_drawn_paler(run):
    """In the strip and in the viewer: the arm with what hangs on it, and toes never."""
    names = np.array(["arm_flex_r", "arm_add_r", "arm_rot_r", "mtp_angle_r"])
    record = replace(run.record, signals={**run.record.signals, "assumed.joints": names})
    assert assumed_bodies(record) == {"humerus_r", "forearm_r", "hand_r", "fingers_r"}
    assert assumed_bodies(run.record) == set()
    before, after = (build_scene(r).shapes for r in (run.record, record))
    for plain, shape in zip(before, after, strict=True):
        paler = shape.body_name in assumed_bodies(record)
        assert (shape.paint != plain.paint) == paler
        assert all(a >= b for a, b in zip(shape.paint, plain.paint, strict=True))
    plain, paler = (
        set(re.findall(r"#[0-9a-f]{6}", strip_of(ReportedRun(each))))
        for each in (run, replace(run, record=record))
    )
    assert paler - plain, "the arm has colours of its own"


def test_the_pelvis_of_the_left_is_that_of_a_mirrored_person(run):
    """Of a walk that is alike on both sides the pelvis is the same over both feet's cycles."""
    angles = clinical_angles(run.record)
    for name in ("pelvis_tilt", "pelvis_list", "pelvis_rotation"):
        right, left = (angles[f"{name}_{side}"].mean(axis=0) for side in "rl")
        np.testing.assert_allclose(right, left, atol=1.5)
    assert np.ptp(angles["pelvis_list_r"].mean(axis=0)) > 3
