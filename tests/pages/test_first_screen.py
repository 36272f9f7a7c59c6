"""The head of a report: the verdict on the person, the moving picture, the tiles."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.charts import Figure
from plantigrade.pages.headline import headline_figures
from plantigrade.pages.run_pages import moving_person, report_html, shown_part
from plantigrade.pages.section import ReportedRun, Section, draw_all
from plantigrade.pages.sections import SECTIONS
from plantigrade.pages.sections.clinical import grid_of
from plantigrade.pages.verdict import verdict_sentence
from plantigrade.record import Provenance, Record, Run
from tests.pages.runs import fitted, from_tasks, solved

PUSHED = slice(100, 120)  # frames


def simulated(record, force: float = 80.0, **figures):
    """A simulation with one push to the left."""
    push = np.zeros((record.motion.n_frames, 3))
    push[PUSHED, 1] = force
    run = fitted(replace(record, signals={**record.signals, "world.push": push}))
    return replace(run, kind="simulate", figures=figures)


def sentence(run) -> str:
    return verdict_sentence(ReportedRun(run))


def test_a_simulation_says_who_stayed_on_their_feet_and_what_they_withstood(record):
    stood = simulated(record)
    assert sentence(stood) == (
        "The person stayed on their feet for all 4.0 s and withstood a push of 80 N."
    )
    tiles = headline_figures(ReportedRun(stood))
    assert list(tiles.items())[:2] == [
        ("on their feet", "all 4.0 s"), ("withstood", "a push of 80 N")
    ]  # fmt: skip
    fell = simulated(record, fell_at_s=1.75)
    assert sentence(fell) == (
        "The person fell after 1.75 s, 0.75 s after the start of a push of 80 N."
    )
    tiles = headline_figures(ReportedRun(fell))
    assert list(tiles.items())[:2] == [("fell", "at 1.75 s"), ("exposed to", "a push of 80 N")]


def test_everything_that_acted_is_named(record):
    settings = {"box": ["5,3,90,1", "5,3,0,2"], "load": 12.0, "shift": "0.1,0.2,0,1"}
    run = replace(simulated(record), provenance=Provenance(settings=settings))
    assert sentence(run).endswith(
        "a push of 80 N, 2 thrown boxes, a backpack of 12 kg and a shift of the floor."
    )


def test_a_recorded_walk_is_compared_with_its_norms(record):
    known = {"gps_deg": 4.2, "gps_reference_deg": 5.0}
    assert "walks at 1.25 m/s with 109 steps per minute" in sentence(fitted(record))
    assert "no more than is usual" in sentence(fitted(record, **known))
    assert "slightly more" in sentence(fitted(record, **{**known, "gps_deg": 6.0}))
    assert "differ clearly" in sentence(fitted(record, **{**known, "gps_deg": 9.0}))


def test_generated_and_reproduced_motions_have_a_verdict(record):
    assert sentence(solved(record)).endswith("as the laws of physics allow: all 4 checks passed.")
    bad = sentence(solved(record, bad=True))
    assert bad == "No valid motion was found: a joint beyond its range."
    assert "by 2.3° on average" in sentence(from_tasks(record))


def test_the_picture_shows_the_push_and_the_fall(record):
    assert shown_part(ReportedRun(simulated(record))) == (0.5, 3.5)
    assert shown_part(ReportedRun(simulated(record, fell_at_s=3.0))) == (1.0, 3.8)
    assert shown_part(ReportedRun(fitted(record))) == (None, None)


def test_the_first_screen_moves_and_leads_to_the_viewer(record):
    page = report_html(fitted(record))
    (person,) = re.findall(r'<a href="viewer.html"><img src="(data:image/svg[^"]*)"', page)
    assert "animate" in person and len(person) < 150e3
    assert page.index('class="verdict"') < page.index('class="person"') < page.index("<nav")
    still = Record(record.human, record.motion.frames(slice(0, 1)))
    assert moving_person(ReportedRun(Run(still, "other"))) == ""


@pytest.mark.parametrize("make", [fitted, simulated])
def test_nothing_is_cut_off(record, make, browser, tmp_path):
    """No part of the page reaches beyond the window, unless it scrolls by itself."""
    page = tmp_path / "report.html"
    page.write_text(report_html(make(record)), encoding="utf-8")
    browser.open(page)
    browser.evaluate("document.querySelectorAll('details').forEach(each => each.open = true)")
    for width in (390, 1280):  # a phone, a desk
        browser.resize(width, 844)
        assert browser.evaluate(BEYOND) == []
    assert browser.evaluate("document.querySelector('.person img').naturalWidth") > 100
    assert not browser.errors and not browser.requests


BEYOND = """[...document.querySelectorAll('body *')].filter(each => {
  const box = each.getBoundingClientRect();
  if (!box.width || box.right <= document.documentElement.clientWidth + 1) return false;
  for (let p = each; p; p = p.parentElement)
    if (p !== document.body && getComputedStyle(p).overflowX !== 'visible') return false;
  return true;
}).map(each => each.outerHTML.slice(0, 80))"""
"""Elements that reach beyond the window and are not inside a box that scrolls."""


# Pushes and flat curves ---------------------------------------------------------------------------


def drawn(run) -> dict[str, Section]:
    """Return the sections of a report by title."""
    return {section.title: section for section in draw_all(SECTIONS, ReportedRun(run))}


def standing(record):
    """A person who stands for two seconds, swaying by 2°, pushed once."""
    motion = record.motion.frames(slice(0, 201))
    qpos = np.tile(record.human.standing(), (201, 1))
    qpos[:, 7 + record.human.hinge("hip_flexion_r")] += np.deg2rad(np.linspace(0.0, 2.0, 201))
    push = np.zeros((201, 3))
    push[PUSHED] = [30.0, 40.0, 0.0]
    still = replace(motion, qpos=qpos, qvel=np.zeros_like(motion.qvel), events=())
    return Run(Record(record.human, still, signals={"world.push": push}), "simulate")


def test_pushes_have_a_section_and_are_shaded_in_plots_over_time(record):
    sections = drawn(standing(record))
    assert next(iter(sections)) == "Pushes and recovery"
    (row,) = sections["Pushes and recovery"].rows
    assert row[0] == "1.00 s" and row[2].startswith("50 N") and row[4] == "forward and to the left"
    for title in ("Pushes and recovery", "Joint angles"):
        assert all('class="shade"' in figure.svg for figure in sections[title].figures), title
    assert "Pushes and recovery" not in drawn(fitted(record))


def test_flat_curves_are_folded_away(record):
    flat = drawn(standing(record))["Joint angles"]
    assert flat.folded and "None of these joints moves through more than 3°" in flat.text
    walking = replace(record, motion=replace(record.motion, events=()), references={})
    moving = drawn(Run(walking, "fit"))
    assert not moving["Joint angles"].folded
    titles = [figure.svg.split('aria-label="')[1].split(",")[0] for figure in
              moving["Joint angles"].figures]  # fmt: skip
    assert titles[:3] == ["Hip flexion", "Knee flexion", "Ankle dorsiflexion"]


def test_levels_that_the_model_lacks_are_not_drawn():
    assert [row[0] for row in grid_of({"knee_angle": Figure("<svg/>")})[1:]] == [Figure("<svg/>")]
