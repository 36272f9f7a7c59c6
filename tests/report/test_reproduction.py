"""What the report of a reproduced gait draws, from figures made up here."""

import re
from dataclasses import replace

import numpy as np
import pytest
from plantigrade.report.reproduction import (
    FILE,
    Reproduction,
    difference,
    facts_of,
    read_reproduction,
    reproduction_sections,
    stacked,
)

from plantigrade.analyze.reproduction import ROTATIONS
from plantigrade.charts import Bar, Series, line_plot, timeline_plot
from plantigrade.errors import FileError
from plantigrade.report.strip import strip_svg
from tests.report.walker import walk, walker


def made_up(*, cycles: int = 2, forces: bool = False, measured: bool = False) -> Reproduction:
    """A second of walking with known figures."""
    n, percent = 201, np.linspace(0, 100, 101)
    time = np.arange(n) * 0.005
    names = tuple(name for _, name in ROTATIONS) + ("pelvis_tilt",)
    curve = np.sin(2 * np.pi * percent / 100)
    recorded = np.array([[10 * (i + 1) * curve] * cycles for i in range(len(names))])
    more = {}
    if forces:
        up = np.maximum(np.sin(2 * np.pi * time), 0)
        force = np.zeros((n, 2, 3))
        force[:, 0, 2] = up
        more = {
            "force_time": time,
            "force": force,
            "moment_names": ("knee_angle_r", "ankle_angle_l"),
            "moment": np.stack([up, -up], axis=1),
        }
        if measured:
            seen = force * 0.9
            seen[150:] = np.nan
            more |= {"force_measured": seen, "moment_measured": more["moment"] * 1.1}
    return Reproduction(
        tasks="default",
        names=("floor", "contact", "swing heel r", "centre of mass", "posture"),
        level=np.array([1, 2, 3, 4, 5]),
        meanings=("Keeps up.", "Holds.", "Leads.", "Carries.", "Draws."),
        time=time,
        active=np.stack([time >= 0, time >= 0, time < 0.4, time >= 0, time >= 0], axis=1),
        residual=np.outer(np.ones(n), [0.0, 1e-12, 1e-3, 1.0, 100.0]),
        phase=np.array([[0.0, 0.4], [0.4, 0.5], [0.5, 1.0]]),
        phase_kind=("single", "double", "single"),
        phase_swing=("r", "l", "l"),
        posture_end=np.array([0.2, 0.4, 0.5, 1.0]),
        contact=np.array([[0.0, 0.5], [0.4, 1.0]]),
        contact_place=("heel_l", "heel_r"),
        percent=percent,
        coordinates=names,
        simulated=recorded * 0.9 if cycles else np.zeros((len(names), 0, 101)),
        recorded=recorded if cycles else np.zeros((len(names), 0, 101)),
        rom=np.array([[18.0 * (i + 1), 20.0 * (i + 1)] for i in range(len(names))]),
        rmse=np.arange(len(names), dtype=float),
        correlation=np.array([np.nan, *np.linspace(0.5, 1, len(names) - 1)]),
        com_error=np.linspace(0, 0.004, n),
        sole=np.zeros((n, 2)),
        sole_recorded=np.zeros((n, 2)),
        **more,
    )


def sections(found):
    """Sections by title."""
    return {section.title: section for section in reproduction_sections(found)}


def test_the_table_holds_the_paper_and_the_differences():
    table = sections(made_up())["Ranges of motion"]
    assert [row[0] for row in table.rows] == [label for label, _ in ROTATIONS]
    first, knee = table.rows[0], table.rows[3]
    assert first[1:4] == ["18.0", "20.0", "−2.0"] and first[5] == "–"
    assert knee[6:] == ["56", "67", "−11"]  # as printed in the paper
    assert len(table.headers) == len(first)
    # differences are 2, 4, … 24
    assert "Mean difference 13.0°, largest 24.0°" in table.text


def test_curves_tell_reproduced_from_recorded():
    drawn = sections(made_up())["Reproduced against recorded angles"]
    assert len(drawn.figures) == len(ROTATIONS) + 1
    for figure in drawn.figures:
        lines = re.findall(r'<path d="M[^"]*" fill="none"[^>]*>', figure.svg)
        assert len(lines) == 2 and sum("dasharray" in line for line in lines) == 1
    right = drawn.figures[0].svg
    assert "--right" in right and "--recorded" in right and "--left" not in right


def test_without_whole_cycles_the_curves_are_left_out():
    found = sections(made_up(cycles=0))
    assert "no whole gait cycle" in found["Reproduced against recorded angles"].missing
    assert found["Ranges of motion"].rows


def test_the_timeline_shows_when_a_task_acts():
    section = sections(made_up())["The tasks and when they act"]
    assert [row[:2] for row in section.rows][:3] == [
        ["0", "limits of the joints"], ["1", "floor"], ["2", "contact"],
    ]  # fmt: skip
    svg = section.figures[0].svg
    # phases 3, contacts 2, tasks 5 bars (the swing heel's ends at 0.4 s of 1 s)
    widths = [float(w) for w in re.findall(r'<rect x="[\d.]+" y="[\d.]+" width="([\d.]+)"', svg)]
    assert len(widths) == 10
    whole = max(widths)
    assert sum(abs(w - 0.4 * whole) < 2 for w in widths) == 2  # first phase and swing heel
    assert "right swings" in svg and "swing heel right" in svg


def test_a_long_walk_shows_its_beginning_and_says_so():
    n = 80
    edges = np.linspace(0, 20, n + 1)
    found = replace(
        made_up(),
        time=np.linspace(0, 20, 201),
        phase=np.stack([edges[:-1], edges[1:]], axis=1),
        phase_kind=("single",) * n,
        phase_swing=("r", "l") * (n // 2),
    )
    (figure,) = sections(found)["The tasks and when they act"].figures
    assert "The first 15.0 s of 20.0 s are drawn." in figure.caption


def test_residuals_are_drawn_in_powers_of_ten():
    (figure,) = sections(made_up())["What each level missed"].figures
    for power in ("10⁻⁸", "10⁻⁴", "10²"):
        assert power in figure.svg
    assert "NaN" not in figure.svg and "inf" not in figure.svg
    assert "3 swing heel" in figure.svg


@pytest.mark.parametrize("measured", [False, True])
def test_forces_stand_beside_measured_ones(measured):
    found = sections(made_up(forces=True, measured=measured))
    for title in ("Ground reactions: computed beside measured",
                  "Joint moments: computed beside measured"):  # fmt: skip
        assert not found[title].missing
        assert any("dasharray" in f.svg for f in found[title].figures) == measured
    without = sections(made_up())
    assert "not asked for" in without["Joint moments: computed beside measured"].missing


def test_it_survives_the_run_folder(tmp_path):
    found = made_up(forces=True, measured=True)
    (tmp_path / FILE).write_bytes(found.to_npz())
    again = read_reproduction(tmp_path)
    assert again is not None and again.tasks == "default" and again.names == found.names
    np.testing.assert_array_equal(again.residual, found.residual)
    assert [s.figures for s in reproduction_sections(again)] == [
        s.figures for s in reproduction_sections(found)
    ]
    assert found.to_npz() == found.to_npz(), "the same gait gives the same file"
    assert read_reproduction(tmp_path / "elsewhere") is None


@pytest.mark.parametrize("content", [b"", b"not a zip", "cut"])
def test_a_broken_file_is_told(tmp_path, content):
    whole = made_up().to_npz()
    (tmp_path / FILE).write_bytes(whole[: len(whole) // 2] if content == "cut" else content)
    with pytest.raises(FileError, match="reproduction.npz"):
        read_reproduction(tmp_path)


def test_small_words():
    assert difference(-0.04) == "0.0" and difference(-2.0) == "−2.0" and difference(3) == "+3.0"
    facts = facts_of({"rom_error_mean_deg": 2.34, "sole_lowest_mm": -1.2, "com_error_max_mm": None})
    assert list(facts.values()) == ["2.3°", "−1.2 mm"]
    one, two = np.zeros((1, 3)), np.ones((2, 3))
    both = stacked([one, two])
    assert both.shape == (2, 2, 3) and np.isnan(both[0, 1]).all() and (both[1] == 1).all()


def test_a_logarithmic_axis_is_one():
    x = np.linspace(0, 1, 3)
    svg = line_plot(
        [Series(x, np.array([1e-4, 1e-2, 1.0]))], title="t", x_label="x", y_label="y", log=1e-8
    )
    (path,) = re.findall(r'<path d="([^"]*)" fill="none"', svg)
    heights = [float(y) for y in re.findall(r"[ML][\d.]+ ([\d.]+)", path)]
    assert heights[0] - heights[1] == pytest.approx(heights[1] - heights[2], abs=0.11)


def test_a_timeline_writes_words_only_where_there_is_room():
    rows = [("row", [Bar(0, 9, label="a long name"), Bar(9, 10, label="a long name")])]
    svg = timeline_plot(rows, title="t", x_label="time [s]", width=400)
    assert svg.count("a long name") == 1


def test_the_ghost_stands_behind_the_body():
    model = walker()
    record = walk(model)
    plain = strip_svg(model, record.motion.qpos, [10, 60])
    both = strip_svg(model, record.motion.qpos, [10, 60], behind=record.reference_qpos)
    assert both.count('<g opacity=".4">') == 2 and '<g opacity=".4">' not in plain
    first = both.index("<g transform")
    assert both.index('<g opacity=".4">') - first < 60, "the ghost is drawn first"
