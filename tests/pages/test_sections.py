"""The sections of a report on runs whose figures are known."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import compare
from plantigrade.analyze.quantities import QUANTITY
from plantigrade.analyze.reproduction import ROTATIONS
from plantigrade.contact.site import PUSH_PART, ContactSite
from plantigrade.motion.motion import resampled
from plantigrade.pages.headline import headline_figures
from plantigrade.pages.run_pages import run_viewer
from plantigrade.pages.scene import build_scene
from plantigrade.pages.section import ReportedRun, draw_all
from plantigrade.pages.sections import SECTIONS
from plantigrade.pages.sections.contacts import centre_of_pressure, inside_support, site_points
from plantigrade.pages.text import sided_title
from plantigrade.record.signals import SIGNALS
from tests.nasty.runs import whole_run
from tests.pages.runs import CHECKED, estimated, fitted, from_tasks, solved


def sections(run):
    """Sections by title."""
    return {section.title: section for section in draw_all(SECTIONS, ReportedRun(run))}


def with_signals(run, **signals):
    """The run with some of its signals replaced."""
    named = {name.replace("__", "."): value for name, value in signals.items()}
    return replace(run, record=replace(run.record, signals={**run.record.signals, **named}))


# A verdict ----------------------------------------------------------------------------------------


def test_every_quantity_of_the_checker_has_words():
    assert all(each.label and each.words and each.advice for each in QUANTITY.values())


def test_the_verdict_s_table_says_what_where_and_when(record):
    rows = sections(solved(record))["Check"].rows
    assert len(rows) == len(CHECKED)
    assert rows[0][1:4] == ["0.40", "1.00", "% of body weight"] and rows[0][5:] == ["0.31 s", "yes"]
    assert rows[1][4] == "right foot heel back medial" and rows[1][5] == ""
    assert rows[2][0] == "knee and hip"  # unknown to the table: by its own name
    assert rows[3][2] == "–" and rows[3][6] == "–", "without a limit nothing is judged"


def test_a_fault_is_marked_and_described(record):
    found = sections(solved(record, bad=True))
    assert found["Check"].rows[2][-1] == "no"
    assert found["Findings of the check"].rows == [["1", "the knee bends too far"]]
    assert "3 mm off" in found["Constraints the solver did not satisfy"].rows[0][1]
    assert "Findings of the check" not in sections(solved(record))
    subject = ReportedRun(solved(record, bad=True))
    assert headline_figures(subject)["verdict"] == "failed"
    assert headline_figures(ReportedRun(solved(record))) == {
        "verdict": "passed", "walking speed": "1.25 m/s",
    }  # fmt: skip


def test_a_simulation_begins_with_what_became_of_it(record):
    figures = {"speed_m_s": 1.234, "landings": 7, "astray_max_m": 0.861, "points_passed": 1}
    run = replace(fitted(record), kind="simulate", figures={**figures, "fell_at_s": 2.5})
    facts = headline_figures(ReportedRun(run))
    assert facts == {
        "fell": "at 2.50 s", "speed": "1.23 m/s", "steps": "7",
        "distance from path, maximum": "0.86 m",
    }  # fmt: skip
    (group,) = (g for g in sections(run)["Other figures"].groups if g.title == "Simulation")
    assert ["waypoints passed", "1"] in group.rows


# Beside the recorded motion -----------------------------------------------------------------------


def test_a_motion_and_a_scaled_one(record):
    """The reference's right knee moves 0.7 times as far and is in phase; the left is the same."""
    found = compare(record)
    ours, theirs = found.rom["knee_angle_r"]
    assert theirs == pytest.approx(0.7 * ours)
    assert found.correlation["knee_angle_r"] == pytest.approx(1) and found.rmse["knee_angle_r"] > 3
    assert found.rmse["knee_angle_l"] == 0 and found.rom_error["knee_angle_l"] == 0
    assert found.curves_simulated["knee_angle_r"].shape == (3, len(found.percent))
    assert found.com_error.max() > 1e-3
    assert found.soles.min() == pytest.approx(0, abs=1e-9)
    assert np.any(found.soles != found.soles_reference)


def test_resampling_keeps_the_rotation(record):
    """A quaternion and its negative are one rotation: a flip of sign is no turn."""
    motion = record.references["recorded"]
    qpos = motion.qpos.copy()
    qpos[1::2, 3:7] *= -1
    between = (motion.time[1:] + motion.time[:-1]) / 2
    plain, flipped = (resampled(m, between) for m in (motion, replace(motion, qpos=qpos)))
    same = np.abs(np.sum(plain.qpos[:, 3:7] * flipped.qpos[:, 3:7], axis=1))
    np.testing.assert_allclose(same, 1, atol=1e-12)
    assert resampled(motion, motion.time) is motion


def test_the_table_holds_the_paper_and_the_differences(record):
    table = sections(from_tasks(record))["Ranges of motion"]
    assert [row[0] for row in table.rows] == [sided_title(name) for _, name in ROTATIONS]
    knee = table.rows[3]
    ours, theirs = float(knee[1]), float(knee[2])
    assert knee[3] == f"{ours - theirs:+.1f}" and ours == pytest.approx(theirs / 0.7, abs=0.2)
    assert knee[6:] == ["56", "67", "−11"]  # as printed in the paper
    assert len(table.headers) == len(knee)
    plain = sections(replace(from_tasks(record), record=record))["Ranges of motion"]
    assert len(plain.headers) == len(plain.rows[0]) == 6 and "paper" not in plain.text


def test_curves_tell_reproduced_from_recorded(record):
    found = sections(from_tasks(record))
    drawn = found["Reproduced against recorded angles"]
    others = found["Toes, pelvis, trunk and arms against the recorded ones"]
    assert len(drawn.figures) == len(ROTATIONS) and len(others.figures) > 5
    assert others.folded and not drawn.folded
    for figure in [*drawn.figures, *others.figures]:
        lines = re.findall(r'<path d="M[^"]*" fill="none"[^>]*>', figure.svg)
        assert len(lines) == 2 and sum("dasharray" in line for line in lines) == 1
    right = drawn.figures[0].svg
    assert "--right" in right and "--recorded" in right and "--left" not in right


def test_without_whole_cycles_the_curves_are_left_out(record):
    run = from_tasks(record)
    still = replace(run.record, motion=replace(run.record.motion, events=()))
    found = sections(replace(run, record=still))
    assert "no complete gait cycle" in found["Reproduced against recorded angles"].missing
    assert found["Ranges of motion"].rows


# Ordered tasks ------------------------------------------------------------------------------------


def test_the_timeline_shows_when_a_task_acts(record):
    section = sections(from_tasks(record))["Tasks and when they are active"]
    assert [row[:2] for row in section.rows][:3] == [
        ["0", "limits of the joints"], ["1", "floor"], ["2", "contact"],
    ]  # fmt: skip
    svg = section.figures[0].svg
    # phases 3, contacts 2, tasks 5 bars (the swing heel's ends at 0.4 s of 4 s)
    widths = [float(w) for w in re.findall(r'<rect x="[\d.]+" y="[\d.]+" width="([\d.]+)"', svg)]
    assert len(widths) == 10
    assert sum(abs(w - 0.1 * max(widths)) < 2 for w in widths) == 2  # first phase and swing heel
    assert "right swing" in svg and "swing heel right" in svg and "“default”" in section.text


def test_a_long_walk_shows_its_beginning_and_says_so(record):
    n = 80
    edges = np.linspace(0, record.motion.time[-1], n + 1)
    run = with_signals(
        from_tasks(record),
        phase__span=np.stack([edges[:-1], edges[1:]], axis=1),
        phase__kind=np.array(["single"] * n),
        phase__swing=np.array(["r", "l"] * (n // 2)),
    )
    (figure,) = sections(run)["Tasks and when they are active"].figures
    assert "The first 3.0 s of 4.0 s are drawn." in figure.caption


def test_residuals_are_drawn_in_powers_of_ten(record):
    (figure,) = sections(from_tasks(record))["Residual of each level"].figures
    for power in ("10⁻⁸", "10⁻⁴", "10²"):
        assert power in figure.svg
    assert "NaN" not in figure.svg and "inf" not in figure.svg and "3 swing heel" in figure.svg


def test_short_figures_of_a_motion_from_tasks(record):
    assert list(headline_figures(ReportedRun(from_tasks(record))).values()) == ["2.3°", "−1.2 mm"]


# Forces -------------------------------------------------------------------------------------------


def test_forces_are_drawn_with_measured_ones(record):
    found = sections(from_tasks(record, forces=True, measured=True))
    for title in ("Ground reactions: computed beside measured",
                  "Joint moments: computed beside measured"):  # fmt: skip
        assert not found[title].missing
        assert any("dasharray" in f.svg for f in found[title].figures)
    assert len(found["Joint moments: computed beside measured"].figures) == 2


def test_where_nothing_was_measured_nothing_is_called_so(record):
    found = sections(from_tasks(record, forces=True))
    assert not any("measured" in title for title in found if not found[title].missing)
    for title, n in (("Computed ground reactions", 6), ("Computed joint moments", 8)):
        assert len(found[title].figures) == n
        assert not any("dasharray" in f.svg for f in found[title].figures)
    assert found["Ground reaction over the gait cycle"].figures
    without = sections(from_tasks(record))
    assert "computed without forces" in without["Computed joint moments"].missing
    unseen = from_tasks(record, forces=True, measured=True)
    beside = unseen.others["forces"]
    lost = {name: x * np.nan for name, x in beside.signals.items() if x.dtype.kind == "f"}
    blind = replace(beside, signals=beside.signals | lost)
    found = sections(replace(unseen, others={"forces": blind}))
    assert not any("measured" in title for title in found), "no frame was measured"


def test_of_a_body_that_fell_the_forces_end_with_the_fall(record):
    run = from_tasks(record, forces=True)
    beside = run.others["forces"]
    path = beside.references["recorded"].qpos.copy()
    path[250:, 0] += 1.0  # it left its path after 2.5 s
    lost = replace(beside.references["recorded"], qpos=path)
    fallen = replace(beside, references={"recorded": lost})
    run = replace(run, others={"forces": fallen}, figures={"dynamics_status": "the body fell"})
    found = sections(run)
    section = found["Computed ground reactions"]
    assert "until the fall of the body" in section.text
    ticks = re.findall(r'text-anchor="middle"[^>]*>([\d.]+)</text>', section.figures[0].svg)
    assert max(map(float, ticks)) == 2.0
    assert found["Ground reaction and centre of pressure"].missing, "they are not the run's"


def test_a_push_is_named_next_to_the_feet(record):
    made = solved(record).record
    pushed = ContactSite(body="torso", name="push_torso", part=PUSH_PART, measured=True)
    force = np.tile([60.0, 0.0, 0.0], (len(made.motion.time), 1, 1))
    all_forces = np.concatenate([made.contact_force, force], axis=1)
    point = None
    if made.contact_point is not None:
        point = np.concatenate([made.contact_point, np.zeros_like(force)], axis=1)
    planned = np.column_stack([made.contact_planned, np.ones(len(force), bool)])
    more = replace(
        made,
        sites=(*made.sites, pushed),
        contact_force=all_forces,
        contact_point=point,
        contact_torque=None,
        contact_planned=planned,
    )
    drawing = sections(replace(solved(record), record=more))[
        "Ground reaction and centre of pressure"
    ].figures[1]
    assert "push on the torso" in drawing.svg and "push_torso" not in drawing.svg


def test_planned_sites_carry_the_weight_between_them(record):
    run = solved(record)
    section = sections(run)["Contact forces by segment"]
    assert len(section.figures) == 2  # a plot a foot
    assert "Right foot" in section.figures[0].svg and "sum" in section.figures[0].svg
    nothing = replace(run.record, contact_force=np.zeros_like(run.record.contact_force))
    found = sections(replace(run, record=nothing))
    assert found["Contact forces by segment"].missing
    assert found["Centre of pressure and support"].missing


def test_the_centre_of_pressure_is_inside_what_stands(record):
    """Equal forces on all sites of a foot act at their mean, which is in their hull."""
    made = solved(record).record
    point, centre = site_points(made), centre_of_pressure(made)
    inside = inside_support(made, point, centre)[0:400:7]
    assert np.isfinite(inside).mean() > 0.9 and np.nanmin(inside) > 0
    apart = inside_support(made, point, centre + [0.0, 1.0, 0.0])[30]
    assert apart == pytest.approx(-1.0, abs=0.2)
    mean = point[30, made.contact_planned[30]].mean(axis=0)
    np.testing.assert_allclose(centre[30], mean, atol=1e-9)


def test_nothing_stands_where_nothing_was_planned(record):
    run = solved(record)
    never = np.zeros_like(run.record.contact_planned)
    found = sections(replace(run, record=replace(run.record, contact_planned=never)))
    assert found["Contact plan"].missing


# A solver -----------------------------------------------------------------------------------------


def test_convergence_tells_every_stage(record):
    section = sections(solved(record))["Convergence"]
    assert len(section.figures) == 2
    coarse, fine = section.rows
    assert coarse[:4] == ["coarse", "banded interior point", "21", "5"]
    assert fine[1] == "IPOPT" and fine[6] == "1.0e−9" and fine[7] == "dynamics 3"
    none = np.array([], dtype=np.str_)
    empty = with_signals(
        solved(record), solver__history=np.zeros((0, 5)), solver__history_worst=none
    )
    assert "no iterations" in sections(empty)["Convergence"].missing


def test_strength_is_torque_over_its_limit(record):
    run = solved(record)
    limits = np.array([[-100.0], [80.0]]) * np.ones(len(record.human.coordinates))
    limited = replace(run.record, limits=replace(run.record.limits, torque=limits))
    (figure,) = sections(replace(run, record=limited))["Joint strength used"].figures
    assert "+40 N m" in figure.svg  # the torques swing between -40 and 40 N m: half of 80


# The feet -----------------------------------------------------------------------------------------


def test_foot_segments_are_drawn_where_the_fit_has_them(record):
    percent = np.linspace(0, 100, 101)
    names = ("hindfoot_dorsiflexion_r", "hindfoot_dorsiflexion_l")
    run = fitted(record, foot_segments_marker_rms_mm=3.21)
    drawn = with_signals(
        run,
        foot__percent=percent,
        foot__names=np.array(names),
        **{f"foot__{name}": np.array([np.sin(percent / 16)] * 3) for name in names},
    )
    section = sections(drawn)["Foot segments"]
    assert len(section.figures) == 1 and "Hindfoot dorsiflexion" in section.figures[0].svg
    assert "3.2 mm (RMS)" in section.text and "3 right, 3 left" in section.text
    assert "Foot segments" not in sections(run)


# What no plate measured ---------------------------------------------------------------------------


def test_estimated_forces_have_sections_of_their_own(record):
    """Where nothing was measured no section of measured forces is drawn, nor said to be missing."""
    bare, found = sections(fitted(record)), sections(estimated(record))
    parts = {"Estimated ground reactions", "Estimated joint moments", "Estimated joint powers"}
    assert parts <= set(found) and not parts & set(bare)
    measured = {"Ground reaction over the gait cycle", "Joint moments", "Joint powers"}
    assert measured <= set(bare) and not measured & set(found)
    section = found["Estimated joint moments"]
    assert "not measured" in section.text and "No plate measured anything" in section.text
    assert len(section.figures) == 8 and section.folded, "four joints of two legs"
    drawn = section.figures[0].svg
    assert ">estimated<" in drawn and ">measured<" not in drawn and 'opacity="0.22"' in drawn
    assert "none were measured" in found["Ground reaction and centre of pressure"].text


def test_measured_forces_are_drawn_with_estimated_ones(record):
    withheld = sections(estimated(record, beside="withheld"))["Estimated ground reactions"]
    assert all(">measured<" in f.svg and ">estimated<" in f.svg for f in withheld.figures)
    assert "withheld" in withheld.text
    found = sections(estimated(record, beside="plate"))
    right, left = found["Estimated ground reactions"].figures[:2]
    assert ">measured<" in right.svg and ">estimated<" not in right.svg
    assert ">estimated<" in left.svg and ">measured<" not in left.svg
    assert len(found["Joint moments"].figures) == 4, "those of the measured leg"


def test_estimates_without_a_gait_cycle_are_drawn_over_time(record):
    run = estimated(replace(record, motion=replace(record.motion, events=())))
    figures = sections(run)["Estimated ground reactions"].figures
    assert len(figures) == 6 and all("time [s]" in f.svg for f in figures)


def test_arrows_of_estimated_forces_are_thin(record):
    """What is drawn of a foot on a plate is as it was."""
    is_estimated = build_scene(estimated(record, beside="plate").record).estimated
    assert is_estimated is not None and is_estimated.all(axis=0).tolist() == [False, True, True]
    assert build_scene(record).estimated is None
    words = "Thin arrow: estimated"
    assert words in run_viewer(estimated(record)) and words not in run_viewer(fitted(record))


def test_sections_of_the_registry_of_signals_are_drawn(record):
    """Each title under which a signal is said to be drawn is that of a section."""
    whole = whole_run()
    added = np.ones(whole.record.motion.qvel.shape)
    helped = replace(whole.record, signals={**whole.record.signals, "device.torque": added})
    runs = (whole, replace(whole, record=helped), fitted(record), estimated(record))
    titles = {title for run in runs for title in sections(run)}
    assert {signal.section for signal in SIGNALS.values()} - {"", "viewer"} <= titles
