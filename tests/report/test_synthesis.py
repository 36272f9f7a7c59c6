"""The report of a motion from a task: its sections, its figures, and that it can be drawn anew."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import FileError
from plantigrade.report.synthesis import (
    QUANTITIES,
    check_section,
    contact_section,
    convergence_section,
    fault_sections,
    pressure_section,
    read_drawing,
    segment_section,
)
from tests.browser import Browser, find_browser


@pytest.fixture(scope="module")
def drawn(synthesized):
    """What the report draws of the walk."""
    found = read_drawing(synthesized[1])
    assert found is not None
    return found


def test_what_is_drawn_survives_the_folder(synthesized, drawn):
    made = synthesized[0]
    np.testing.assert_array_equal(drawn.time, made.sampled.time)
    np.testing.assert_array_equal(drawn.standing, made.sampled.standing)
    assert drawn.site_names == tuple(s.name for s in made.synthesis.body.sites)
    assert drawn.weight == made.synthesis.body.weight
    assert len(drawn.history) == sum(len(s.history) for s in made.synthesis.stages)


def test_every_quantity_of_the_checker_has_a_row_in_words(drawn):
    from plantigrade.analyze.findings import QUANTITIES as LOOKED_AT

    assert set(QUANTITIES) == set(LOOKED_AT)
    section = check_section(drawn)
    assert len(section.rows) == len(drawn.check_quantity)
    assert {row[-1] for row in section.rows} <= {"yes", "–"}
    slip = next(row for row in section.rows if row[0].startswith("slip"))
    assert slip[3] == "mm" and re.match(r"(right|left) ", slip[4]) and slip[5].endswith(" s")


def test_a_fault_is_marked_and_told(drawn):
    bad = drawn.check_bad.copy()
    bad[3] = True
    other = replace(drawn, check_bad=bad, findings=("it slips",), broken=("z of toe is off",))
    assert check_section(other).rows[3][-1] == "no"
    assert [s.title for s in fault_sections(other)] == [
        "What the checker found",
        "What the solver could not keep",
    ]
    assert fault_sections(drawn) == []


def test_segments_carry_the_weight_between_them(drawn):
    section = segment_section(drawn)
    assert len(section.figures) == 2  # a plot a foot
    assert "Right foot" in section.figures[0].svg and "sum" in section.figures[0].svg


def test_the_zero_moment_point_is_inside_what_stands(drawn):
    from plantigrade.report.synthesis import _depth

    inside = np.array([_depth(drawn, k) for k in range(0, len(drawn.time), 7)])
    assert np.isfinite(inside).all() and inside.min() > -3e-3
    moved = replace(drawn, pressure=drawn.pressure + [0.0, 1.0, 0.0])
    assert _depth(moved, 5) == pytest.approx(-1.0, abs=0.2)
    assert len(pressure_section(drawn).figures) == 2


def test_flight_has_no_zero_moment_point(drawn):
    nothing = replace(drawn, pressure=np.full_like(drawn.pressure, np.nan))
    assert pressure_section(nothing).missing
    none = replace(drawn, standing=np.zeros_like(drawn.standing), force=np.zeros_like(drawn.force))
    assert contact_section(none).missing and segment_section(none).missing


def test_convergence_tells_every_stage(drawn):
    section = convergence_section(drawn)
    assert len(section.figures) == 2 and len(section.rows) == len(drawn.stage_names)
    assert convergence_section(replace(drawn, history=np.zeros((0, 6)))).missing


def test_a_folder_without_and_a_broken_one(tmp_path):
    assert read_drawing(tmp_path) is None
    (tmp_path / "synthesis.npz").write_bytes(b"nothing")
    with pytest.raises(FileError, match="make the run anew"):
        read_drawing(tmp_path)


def test_plantigrade_report_writes_the_same_pages(synthesized):
    from plantigrade.commands import main as cli

    folder = synthesized[1]
    before = {p: (folder / p).read_text("utf-8") for p in ("report.html", "viewer.html")}
    assert cli.main(["report", str(folder)]) == 0
    for page, text in before.items():
        assert (folder / page).read_text("utf-8") == text, page


def test_the_page_holds_its_sections(synthesized):
    text = (synthesized[1] / "report.html").read_text("utf-8")
    for title in (
        "Check", "Joint angles over the gait cycle", "Joint moments", "Joint powers",
        "Contact forces by segment", "Zero-moment point and support", "What stands when",
        "Strength that is used", "How it was found", "Spatio-temporal measures",
    ):  # fmt: skip
        assert f">{title}</h2>" in text, title
    assert "http://" not in text.replace("http://www.w3.org", "") and "https://" not in text


def test_its_pages_in_a_browser(synthesized):
    if find_browser() is None:
        pytest.skip("no Chromium here: apt-get install chromium, or set CHROMIUM to its path")
    with Browser() as browser:
        browser.open(synthesized[1] / "report.html")
        assert browser.evaluate("document.querySelectorAll('svg.plot').length") > 25
        assert browser.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
        assert browser.errors == [] and browser.requests == []
