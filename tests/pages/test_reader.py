"""What a reader of the pages meets: phone, paper, plain words, the right norms."""

import base64
import html
import io
import re
import unicodedata
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import compare_runs, gait_curves, norms, study
from plantigrade.analyze.clinical import clinical_figures
from plantigrade.analyze.foot_progression import foot_progression
from plantigrade.contact.ground import Ground, GroundStep, Seat
from plantigrade.contact.relief import Bump
from plantigrade.models import Human
from plantigrade.pages.compare import compare_html
from plantigrade.pages.run_pages import report_html
from plantigrade.pages.scene import scene_model
from plantigrade.pages.section import ReportedRun, draw_all
from plantigrade.pages.sections import SECTIONS
from plantigrade.pages.strip import strip_svg
from plantigrade.pages.study import TABLE, StudyGait, study_html
from plantigrade.record import Provenance
from plantigrade.record.batch import Row
from plantigrade.workflows.batch_work import figures_of
from tests.pages.runs import estimated, fitted, from_tasks, solved
from tests.pages.test_batch_page import batch_page
from tests.pages.test_study import comparison
from tests.pages.walker import walk

LONG = Provenance(
    "plantigrade fit " + "a" * 90 + ".c3d",
    {"marker_set": "m" * 80},
    {"walk_of_a_person.c3d": "0123456789abcdef" * 4},
)


def study_page(n: int) -> str:
    """The page of a study of so many gaits."""
    gaits = [
        StudyGait(f"walk {k}", "", {"cycles_count": 1}, comparison(k), f"w{k}") for k in range(n)
    ]
    found = study([g.name for g in gaits], [g.comparison for g in gaits])
    return study_html(found, gaits, {}, tasks="paper", provenance={"command": "c" * 120})


@pytest.fixture(scope="module")
def every_page(record, tmp_path_factory) -> dict[str, str]:
    """One page of every kind; names, hashes and words as long as they come."""
    made = {
        "fit": fitted(record, height_m=1.75, residual_force_rms_n=20.1, length_thigh_m=0.42),
        "reproduce": from_tasks(record, forces=True, measured=True),
        "synthesize": solved(record),
        "failed": solved(record, bad=True),
        "estimated": estimated(record, beside="withheld"),
    }
    pages = {name: report_html(replace(run, provenance=LONG)) for name, run in made.items()}
    runs = [replace(made["fit"], name=name) for name in ("before-the-operation", "after-it")]
    compared = compare_runs(runs, [run.name for run in runs])
    figures = figures_of(made["fit"].metrics)
    fits = [Row(name, status="ok", figures=figures) for name in ("a" * 40, "b")]
    return pages | {
        "study": study_page(4),
        "small study": study_page(2),
        "compare": compare_html(compared, {"runs": ["x" * 64]}),
        "sides": compare_html(compare_runs(runs[:1], ["one"]), {"version": "1"}),
        "batch": batch_page(tmp_path_factory.mktemp("batch") / "many", fits),
    }


def sections(run):
    """Sections by title."""
    return {section.title: section for section in draw_all(SECTIONS, ReportedRun(run))}


def words_of(page: str) -> str:
    """What is to be read on a page, but where it comes from."""
    body = page[page.index("<body>") : page.index("<script>")]
    body = re.sub(r'<dl id="provenance".*?</dl>', "", body, flags=re.S)
    return re.sub(r"<[^>]*>", " ", body)


# Phone and paper ----------------------------------------------------------------------------------


def test_every_page_is_as_wide_as_a_phone(browser, tmp_path, every_page):
    browser.resize(400, 800)
    for name, page in every_page.items():
        path = tmp_path / f"{name}.html"
        path.write_text(page, encoding="utf-8")
        browser.open(path)
        assert browser.evaluate("innerWidth") == 400
        wide = "document.documentElement.scrollWidth"
        assert browser.evaluate(wide) <= 400, f"{name}, folded"
        browser.evaluate("document.getElementById('unfold').click()")
        assert browser.evaluate("[...document.querySelectorAll('details')].every(d => d.open)")
        assert browser.evaluate(wide) <= 400, f"{name}, open"
        assert browser.errors == [] and browser.requests == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["fit", "reproduce", "failed", "study", "compare"])
def test_no_heading_ends_a_sheet_of_paper(browser, tmp_path, every_page, kind):
    """The lowest words of an A4 page, as the PDF places them, are no heading."""
    pypdf = pytest.importorskip("pypdf")
    page = every_page[kind]
    path = tmp_path / "page.html"
    path.write_text(page, encoding="utf-8")
    browser.open(path)
    found = re.findall(r"<h[23]>(.*?)</h[23]>", page)
    headings = {unicodedata.normalize("NFKC", html.unescape(h)) for h in found}
    print_options = {"preferCSSPageSize": True, "printBackground": False}
    made = base64.b64decode(browser.call("Page.printToPDF", **print_options)["data"])
    seen = set()
    sheets = pypdf.PdfReader(io.BytesIO(made)).pages
    assert 2 <= len(sheets) <= 14
    assert tuple(map(float, sheets[0].mediabox[2:])) == pytest.approx((595.3, 841.9), abs=1)
    for sheet in sheets:
        words: list[tuple[float, str]] = []

        def visit(text, matrix, place, font, size, words=words):
            if text.strip():
                whole = unicodedata.normalize("NFKC", text.strip())
                words.append((matrix[5] + place[5] * matrix[3], whole))

        sheet.extract_text(visitor_text=visit)
        assert min(words)[1] not in headings
        seen |= {text for _, text in words}
    assert len(seen & headings) > len(headings) / 2, "the headings were not recognised"


def test_the_clinical_sheet_fills_the_first_page_of_paper(browser, tmp_path, every_page):
    """Heading, person and five levels in three planes are on one page; the next begins anew."""
    pypdf = pytest.importorskip("pypdf")
    path = tmp_path / "page.html"
    path.write_text(every_page["fit"], encoding="utf-8")
    browser.open(path)
    options = {"preferCSSPageSize": True, "printBackground": True}
    made = base64.b64decode(browser.call("Page.printToPDF", **options)["data"])
    first, second, *_ = (
        unicodedata.normalize("NFKC", sheet.extract_text())
        for sheet in pypdf.PdfReader(io.BytesIO(made)).pages
    )
    for words in ("A person walking", "Pelvis tilt", "Knee flexion", "Foot progression", "1.75 m"):
        assert words in first
    assert "Foot progression" not in second and "equally spaced instants" in second


def test_paper_is_white_and_open(browser, tmp_path, record):
    """In print all is open and light, and the colours of the key are kept."""
    path = tmp_path / "report.html"
    path.write_text(report_html(from_tasks(record, forces=True, measured=True)), encoding="utf-8")
    browser.open(path)
    folded = "document.querySelectorAll('details:not([open])').length"
    assert browser.evaluate(folded) > 3
    dark = {"name": "prefers-color-scheme", "value": "dark"}
    browser.call("Emulation.setEmulatedMedia", media="print", features=[dark])
    style = "getComputedStyle(document.querySelector('{}')).{}"
    assert browser.evaluate(style.format("html", "backgroundColor")) == "rgb(255, 255, 255)"
    assert browser.evaluate(style.format("body", "color")) == "rgb(0, 0, 0)"
    for what in ("summary", "h2", ".text"):
        assert browser.evaluate(style.format(what, "breakAfter")) == "avoid"
    for what in ("figure", "tr", ".facts"):
        assert browser.evaluate(style.format(what, "breakInside")) == "avoid"
    assert browser.evaluate(style.format(".key i", "printColorAdjust")) == "exact"
    heights = browser.evaluate(
        "[...document.querySelectorAll('details .figures')]"
        ".map(figures => figures.getBoundingClientRect().height)"
    )
    assert min(heights) > 50, "a folded section is not open on paper"
    browser.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert browser.evaluate(folded) == 0
    browser.evaluate("dispatchEvent(new Event('afterprint'))")
    assert browser.evaluate(folded) > 3


def test_a_link_opens_its_section(browser, tmp_path, record):
    path = tmp_path / "report.html"
    path.write_text(report_html(fitted(record)), encoding="utf-8")
    browser.open(path)
    part = "document.getElementById('marker-errors').closest('details').open"
    assert browser.evaluate(part) is False
    browser.evaluate("document.querySelector('nav a[href=\"#marker-errors\"]').click()")
    browser.settle()
    assert browser.evaluate(part) is True


# Words --------------------------------------------------------------------------------------------


def test_no_page_shows_a_raw_key_or_a_time_of_computation(every_page):
    for name, page in every_page.items():
        words = words_of(page)
        keys = set(re.findall(r"\b[a-z]+(?:_[a-z0-9]+)+\b", words)) - {"knee_and_hip"}
        assert not keys, f"{name}: {keys}"
        assert not re.search(r"solved in|time per gait cycle|s per cycle|microsec", words), name


def test_figures_have_names_and_units(record):
    known = {"length_thigh_m": 0.4231, "residual_force_rms_n": 20.06, "stances": 3}
    run = fitted(record, **known, ankle_angle_moment_peak_r_nm_kg=-1.54)
    groups = {g.title: g.rows for g in sections(run)["Other figures"].groups}
    assert ["thigh", "42.3 cm"] in groups["Segment lengths"]
    assert ["force, RMS", "20.1 N"] in groups["Residual force between motion and plates"]
    assert groups["Peak joint moments"] == [["Ankle dorsiflexion", "−1.54", "–", "N m/kg"]]
    assert "Other figures" not in sections(replace(run, figures={}))


def test_sources_stand_once(record):
    page = report_html(replace(fitted(record), provenance=LONG))
    assert page.count("source files") == 1 and page.count("0123456789abcdef" * 4) == 1


def test_one_marker_error_in_all_places(record):
    """What the fit says is what the table of markers says, though the motion was filtered since."""
    assert record.recorded_markers is not None
    seen = np.isfinite(record.recorded_markers.positions).all(axis=2)
    residual = np.where(seen, 0.004, np.nan)
    residual[::2] = np.where(seen[::2], 0.002, np.nan)
    shown = replace(record, signals={"markers.residual": residual})
    expected = 1e3 * np.mean(np.sqrt(np.nanmean(residual**2, axis=1)))
    text = sections(fitted(shown))["Marker errors"].text
    assert f"is {expected:.1f} mm" in text and expected == pytest.approx(3.0, abs=0.05)


def test_two_gaits_are_not_tested_and_it_says_so():
    page = words_of(study_page(2))
    assert "There is no test" in page and "95 % interval" in page
    assert "without significant difference" not in page and "Student" not in page
    one = words_of(study_page(1))
    assert "of one gait" in one and "interval" not in one and "1 recorded gait reproduced" in one
    several = words_of(study_page(4))
    assert "There is no test" not in several and "without significant difference" in several
    assert TABLE in several


# Norms --------------------------------------------------------------------------------------------


def test_adults_are_compared_with_adults_and_children_with_children(record):
    grown = sections(fitted(record))
    angles = grown["Joint angles over the gait cycle"]
    assert "42 healthy adults, 21–37 and 50–84 years" in angles.text
    assert "1.24 ± 0.16 m/s" in angles.text and "children" not in angles.text
    bands = [">adults</text>" in svg for svg in drawn(angles)]
    assert sum(bands) == 9, "the nine that are published of adults"
    assert grown["Spatio-temporal measures"].headers[-1] == "adults"
    moments = grown["Joint moments"]
    assert "83 typically developing children, 4–17 years" in moments.text
    assert ">children</text>" in moments.figures[0].svg
    child = sections(fitted(record, age_years=9.0))
    angles = child["Joint angles over the gait cycle"]
    assert "adults" not in angles.text and "4–17 years" in angles.text
    assert "healthy people" not in report_html(fitted(record))


def test_a_small_person_of_unknown_age_is_a_child():
    small = walk(Human.create(1.25, 25.0))
    assert ReportedRun(fitted(small)).population is norms.CHILDREN
    assert ReportedRun(fitted(small, age_years=30.0)).population is norms.ADULTS


def test_a_slow_walk_is_shown_with_the_speed_of_the_norm(record):
    slow = sections(fitted(record, walking_speed_m_s=0.6))["Joint angles over the gait cycle"]
    assert "Angles depend on speed, here 0.60 m/s" in slow.text
    usual = sections(fitted(record))["Joint angles over the gait cycle"]
    assert "Angles depend on speed" not in usual.text


def test_asymmetry_is_right_minus_left_of_their_mean(record):
    run = fitted(record, stride_length_l_m=1.125, step_length_l_m=0.6)  # right 1.375, unknown
    rows = {row[0]: row for row in sections(run)["Spatio-temporal measures"].rows}
    assert rows["stride length"][4] == "+20.0 %" and rows["step length"][4] == ""


def test_the_profile_is_drawn_from_the_figures_of_the_run(record):
    """Score, profile and symmetry are those of metrics.json; without them there is no section."""
    title, known = "Gait Profile Score and symmetry", fitted(record).figures
    run = fitted(record, **clinical_figures(record, known))
    section = sections(run)[title]
    (*rows, score) = section.rows
    assert len(rows) == 9 and score[0] == "Gait Profile Score"
    assert score[3] == f"{run.figures['gps_deg']:.1f}"
    assert rows[6][1] == f"{run.figures['gvs_knee_angle_r_deg']:.1f}"
    assert "42 healthy adults" in section.text and section.folded
    child = fitted(record, **clinical_figures(record, {**known, "age_years": 9.0}), age_years=9.0)
    assert "83 typically developing children" in sections(child)[title].text
    assert child.figures["gps_deg"] != run.figures["gps_deg"]
    assert title not in sections(fitted(record))
    still = replace(record, motion=replace(record.motion, events=()))
    assert clinical_figures(still, known) == {}


# Curves and pictures ------------------------------------------------------------------------------


def drawn(section) -> list[str]:
    """Return the drawings of a section's grid."""
    return [cell.svg for row in section.grid for cell in row if not isinstance(cell, str)]


def test_the_clinical_sheet_has_five_levels_in_three_planes(record):
    angles = sections(fitted(record))["Joint angles over the gait cycle"]
    titles = [re.findall(r'font-weight="600"[^>]*>([^<]*)<', svg)[0] for svg in drawn(angles)]
    assert titles == [
        "Pelvis tilt", "Pelvis obliquity", "Pelvis rotation",
        "Hip flexion", "Hip adduction", "Hip internal rotation",
        "Knee flexion", "Ankle dorsiflexion", "Toe dorsiflexion", "Foot progression",
    ]  # fmt: skip
    assert [len(row) for row in angles.grid] == [3] * 6
    assert angles.grid[0] == ("sagittal plane", "frontal plane", "transverse plane")
    assert angles.grid[3][1] == angles.grid[3][2] == "" and "its knee is a hinge" in angles.text
    assert angles.sheet and not angles.folded
    assert not sections(from_tasks(record))["Joint angles over the gait cycle"].sheet


@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_foot_progression_follows_the_foot_and_not_the_room(record, turn):
    """A hip turned inward by 10° turns the foot inward by about as much, wherever one walks to."""
    spin = np.deg2rad(turn)
    c, s = np.cos(spin), np.sin(spin)
    qpos = record.motion.qpos.copy()
    qpos[:, :2] = qpos[:, :2] @ np.array([[c, s], [-s, c]])
    w, x, y, z = qpos[:, 3:7].T.copy()
    a, b = np.cos(spin / 2), np.sin(spin / 2)
    qpos[:, 3:7] = np.stack([a * w - b * z, a * x - b * y, a * y + b * x, a * z + b * w], axis=1)
    inward = qpos.copy()
    for side in "rl":
        inward[:, 7 + record.human.hinge(f"hip_rotation_{side}")] += np.deg2rad(10.0)
    before, after = (
        foot_progression(replace(record, motion=replace(record.motion, qpos=each)))
        for each in (qpos, inward)
    )
    plain = foot_progression(record)
    for name, rows in before.items():
        np.testing.assert_allclose(rows, plain[name], atol=1e-6)
        stance = slice(15, 40)  # the leg is nearly upright
        assert (after[name] - rows)[:, stance].mean() == pytest.approx(10.0, abs=1.0)


def test_force_curves_go_to_the_end_of_the_cycle(record):
    """In late swing a foot beside the plates carries nothing, and the curve says so."""
    time = record.motion.time
    known = np.ones((len(time), 2), dtype=bool)
    known[(time % 1.1) > 1.05, 0] = False  # the last 4 % of every right cycle
    force = record.contact_force.copy()
    force[~known] = 0.0
    curves = gait_curves(replace(record, contact_known=known, contact_force=force))
    assert np.isfinite(curves.forces["up_r"][:-1]).all()
    assert np.isfinite(curves.moments["knee_angle_r"][:-1]).all()
    known[(time % 1.1) < 0.3, 0] = False  # unknown in stance stays unknown
    curves = gait_curves(replace(record, contact_known=known, contact_force=force))
    assert not np.isfinite(curves.forces["up_r"][:, 5:20]).any()


def test_foot_off_of_both_sides_is_seen(record):
    run = fitted(record)  # at 62.0 and 62.1 %
    svg = drawn(sections(run)["Joint angles over the gait cycle"])[6]
    lines = re.findall(r'<line [^>]*stroke-dasharray="4 4"[^>]*>', svg)
    assert len(lines) == 2 and sum("dashoffset" in line for line in lines) == 1


def strip(record, ground: Ground) -> str:
    on = replace(record, ground=ground)
    return strip_svg(scene_model(on), on.motion.qpos, [0, 5, 10], ground=ground)


def test_the_strip_draws_what_carries_the_body(record):
    level = strip(record, Ground())
    assert "<line" in level and 'opacity=".25"' not in level
    seat = Ground(seats=(Seat("seat_r", (0.0, 0.0, 0.45)),))
    chair = strip(record, seat)
    assert chair.count("#8a6d4a") == 3, "one in each picture"
    far = strip(record, Ground(seats=(Seat("seat_r", (9.0, 0.0, 0.45)),)))
    assert "#8a6d4a" not in far
    for ground, rise in (
        (Ground(slope=np.deg2rad(10.0)), 0.1),
        (Ground(steps=(GroundStep(0.1, 0.15),)), 0.15),
        (Ground(bumps=(Bump((0.1, 0.0, 0.0), 0.08),)), 0.08),
    ):
        found = re.findall(r'<path d="M([^"Z]*)" fill="none"', strip(record, ground))
        heights = [-float(point.split()[1]) for line in found for point in line.split("L")]
        assert len(found) == 3 and np.ptp(heights) >= rise - 1e-3, ground
