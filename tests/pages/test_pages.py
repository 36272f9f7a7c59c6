"""The pages in a real browser: drawn, silent on the console, self-contained, moving."""

import numpy as np
import pytest

from plantigrade.pages.run_pages import report_html
from plantigrade.pages.viewer import viewer_html
from plantigrade.record import Record, Run
from tests.browser import colours, moved
from tests.conftest import open_browser
from tests.pages.runs import fitted, from_tasks, solved

READY = "document.body.dataset.ready === '1' && document.body.dataset.time"


@pytest.fixture(scope="module")
def viewer_page(tmp_path_factory, record):
    """The viewer of the walk in a page that stays open: drawing it first takes longest."""
    path = tmp_path_factory.mktemp("pages") / "viewer.html"
    path.write_text(viewer_html(record, title="Walk & <more>"), encoding="utf-8")
    with open_browser(width=900, height=560) as browser:
        browser.open(path, ready=READY)
        yield browser


@pytest.fixture
def still(viewer_page):
    """The same page, still a second after the start, the camera following, drawn simply."""
    viewer_page.evaluate(
        "plantigrade.pause(); plantigrade.seek(1.0); plantigrade.state.follow = true;"
        "plantigrade.setQuality('simple')"
    )
    return viewer_page


def stage(browser) -> np.ndarray:
    """Return what is drawn of the body."""
    return browser.screenshot()[60:500, :520]


def middle(browser, selector: str) -> tuple[float, float, float]:
    """Return the left end, the middle's height and the width of an element [px]."""
    left, top, width, height = browser.evaluate(
        f"(() => {{ const r = document.querySelector('{selector}').getBoundingClientRect();"
        "return [r.left, r.top, r.width, r.height]; })()"
    )
    return left, top + height / 2, width


@pytest.mark.parametrize("quality", [pytest.param("simple", marks=pytest.mark.slow), "full"])
def test_viewer_draws_and_is_silent(still, quality):
    still.evaluate(f"plantigrade.setQuality('{quality}')")
    picture = stage(still)
    assert colours(picture) > 1000, "the stage is (nearly) blank"
    blue = (picture[..., 2].astype(int) - picture[..., 0] > 40).sum()
    assert blue > 800, "the right leg's colour is not to be seen"
    assert still.evaluate("document.querySelector('h1').textContent") == "Walk & <more>"
    assert still.errors == []
    assert still.requests == []


def test_scrubbing_moves_body_and_cursor(still):
    still.evaluate("plantigrade.state.follow = false")
    before = stage(still)
    cursor = "document.querySelector('.cursor').style.transform"
    was = still.evaluate(cursor)
    left, y, width = middle(still, "#slider")
    still.drag((left + 0.3 * width, y), (left + 0.6 * width, y))
    assert still.evaluate("plantigrade.state.t") == pytest.approx(0.6 * 4.0, abs=0.15)
    assert moved(before, stage(still)) > 0.01
    assert still.evaluate(cursor) != was
    assert still.errors == []


def test_dragging_on_a_curve_scrubs(still):
    left, y, width = middle(still, ".plot svg")
    still.drag((left + 0.2 * width, y), (left + 0.75 * width, y))
    assert still.evaluate("plantigrade.state.t") == pytest.approx(3.0, abs=0.1)


def test_the_camera_follows_unless_it_is_fixed(still):
    # the body walks 1.25 m/s: with the camera following it stays put in the picture
    still.evaluate("plantigrade.seek(0.0)")
    still.settle()
    target = still.evaluate("plantigrade.camera.target[0]")
    still.evaluate("plantigrade.seek(2.0)")
    still.settle()
    assert still.evaluate("plantigrade.camera.target[0]") - target == pytest.approx(2.5, abs=0.1)
    still.evaluate("document.getElementById('follow').click()")
    still.evaluate("plantigrade.seek(0.0)")
    still.settle()
    assert still.evaluate("plantigrade.camera.target[0]") - target == pytest.approx(2.5, abs=0.1)
    still.evaluate("document.getElementById('follow').click()")


@pytest.mark.slow
def test_every_layer_can_be_hidden(still):
    still.evaluate("plantigrade.seek(1.3); plantigrade.setView('right')")
    still.evaluate("plantigrade.show.beside = true")
    shown, kept = stage(still), []
    for name in ("com", "cop", "force", "fitted", "recorded", "ref", "body"):
        still.evaluate(f"document.querySelector('#legend input[name={name}]').click()")
        hidden = stage(still)
        if (shown != hidden).any(axis=2).sum() <= 10:
            kept.append(name)
        shown = hidden
    assert kept == [], "these were clicked away and are still drawn"
    assert still.errors == []


@pytest.mark.parametrize(
    "make", [fitted, *(pytest.param(each, marks=pytest.mark.slow) for each in (from_tasks, solved))]
)
def test_report_renders_and_is_silent(browser, tmp_path, record, make):
    path = tmp_path / "report.html"
    path.write_text(report_html(make(record)), encoding="utf-8")
    browser.open(path)
    assert browser.evaluate("document.documentElement.scrollHeight") > 1500
    for at in (0, 700):
        browser.evaluate(f"window.scrollTo(0, {at})")
        assert colours(browser.screenshot()) > 100, f"nearly nothing is drawn {at} px down"
    broken = browser.evaluate(
        "[...document.querySelectorAll('svg path')].filter(p => !p.getAttribute('d')"
        " || /NaN|Infinity/.test(p.getAttribute('d'))).length"
    )
    assert broken == 0
    # no drawing is wider than the page
    assert browser.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert browser.errors == []
    assert browser.requests == []


def test_a_report_fits_a_phone(browser, tmp_path, record):
    path = tmp_path / "report.html"
    path.write_text(report_html(solved(record)), encoding="utf-8")
    browser.resize(500, 800)
    browser.open(path)
    assert browser.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_bare_report_renders(browser, tmp_path, record):
    path = tmp_path / "report.html"
    bare = Run(Record(record.human, record.motion), "other", title="Bare")
    path.write_text(report_html(bare), encoding="utf-8")
    browser.open(path)
    assert browser.evaluate("document.querySelectorAll('svg.plot').length") > 5
    assert browser.errors == []
