"""The pages in a real browser: drawn, silent on the console, self-contained, moving."""

import threading
import time

import pytest

from plantigrade.record import Record, Run
from plantigrade.report.live import LiveViewer
from plantigrade.report.pages import report_html
from plantigrade.report.viewer import viewer_html
from tests.browser import colours, moved
from tests.report.runs import fitted, from_tasks, solved

READY = "document.body.dataset.ready === '1' && document.body.dataset.time"


@pytest.fixture
def page(tmp_path, record):
    """The viewer page of the walk, written to a file."""
    path = tmp_path / "viewer.html"
    path.write_text(viewer_html(record, title="Walk & <more>"), encoding="utf-8")
    return path


def open_still(browser, page):
    browser.open(page, ready=READY)
    browser.evaluate("plantigrade.pause(); plantigrade.seek(1.0)")


def test_viewer_draws_and_is_silent(browser, page):
    open_still(browser, page)
    picture = browser.screenshot()
    stage = picture[60:740, :900]
    assert colours(stage) > 1000, "the stage is (nearly) blank"
    blue = (stage[..., 2].astype(int) - stage[..., 0] > 40).sum()
    assert blue > 2000, "the right leg's colour is not to be seen"
    assert browser.evaluate("document.querySelector('h1').textContent") == "Walk & <more>"
    assert browser.errors == []
    assert browser.requests == []


def test_scrubbing_moves_body_and_cursor(browser, page):
    open_still(browser, page)
    browser.evaluate("plantigrade.state.follow = false")
    before = browser.screenshot()
    cursor = "document.querySelector('.cursor').getAttribute('transform')"
    was = browser.evaluate(cursor)
    slider = browser.evaluate(
        "(() => { const r = document.getElementById('slider').getBoundingClientRect();"
        "return [r.left, r.top, r.width, r.height]; })()"
    )
    y = slider[1] + slider[3] / 2
    browser.drag((slider[0] + 0.3 * slider[2], y), (slider[0] + 0.6 * slider[2], y))
    after = browser.screenshot()
    assert browser.evaluate("plantigrade.state.t") == pytest.approx(0.6 * 4.0, abs=0.15)
    assert moved(before[60:740, :900], after[60:740, :900]) > 0.01
    assert browser.evaluate(cursor) != was
    assert browser.errors == []


def test_dragging_on_a_curve_scrubs(browser, page):
    open_still(browser, page)
    left, top, width, height = browser.evaluate(
        "(() => { const r = document.querySelector('.plot svg').getBoundingClientRect();"
        "return [r.left, r.top, r.width, r.height]; })()"
    )
    y = top + height / 2
    browser.drag((left + 0.2 * width, y), (left + 0.75 * width, y))
    browser.settle()
    assert browser.evaluate("plantigrade.state.t") == pytest.approx(3.0, abs=0.1)


def test_play_speed_and_follow(browser, page):
    open_still(browser, page)
    # the body walks 1.25 m/s: with the camera following it stays put in the picture
    browser.evaluate("plantigrade.seek(0.0)")
    browser.settle()
    target = browser.evaluate("plantigrade.camera.target[0]")
    browser.evaluate("plantigrade.seek(2.0)")
    browser.settle()
    assert browser.evaluate("plantigrade.camera.target[0]") - target == pytest.approx(2.5, abs=0.1)
    browser.evaluate("document.getElementById('follow').click()")
    browser.evaluate("plantigrade.seek(0.0)")
    browser.settle()
    assert browser.evaluate("plantigrade.camera.target[0]") - target == pytest.approx(2.5, abs=0.1)
    # a tenth of the speed: in one second of the wall the clock gains a tenth of a second
    browser.evaluate(
        "(() => { const s = document.getElementById('speed'); s.value = '0.1';"
        "s.dispatchEvent(new Event('change')); document.getElementById('play').click(); })()"
    )
    start, wall = browser.evaluate("[plantigrade.state.t, performance.now()]")
    end = start
    for _ in range(60):  # a busy machine draws a frame now and then
        time.sleep(0.5)
        end, later = browser.evaluate("[plantigrade.state.t, performance.now()]")
        if end > start:
            break
    assert 0 < end - start <= 0.1 * (later - wall) / 1000 + 0.02
    browser.evaluate("document.getElementById('play').click()")
    assert browser.evaluate("plantigrade.state.playing") is False


@pytest.mark.parametrize("name", ["body", "ref", "recorded", "fitted", "force", "cop", "com"])
def test_every_layer_can_be_hidden(browser, page, name):
    open_still(browser, page)
    browser.evaluate("plantigrade.seek(1.3); plantigrade.setView('right')")
    browser.evaluate("plantigrade.show.beside = true")
    shown = browser.screenshot()
    browser.evaluate(f"document.querySelector('#legend input[name={name}]').click()")
    hidden = browser.screenshot()
    assert (shown[60:740, 240:900] != hidden[60:740, 240:900]).any(axis=2).sum() > 20
    assert browser.errors == []


@pytest.mark.parametrize("make", [fitted, from_tasks, solved])
def test_report_renders_and_is_silent(browser, tmp_path, record, make):
    path = tmp_path / "report.html"
    path.write_text(report_html(make(record)), encoding="utf-8")
    browser.open(path)
    picture = browser.screenshot(whole=True)
    assert picture.shape[0] > 3000
    assert colours(picture) > 200
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


def test_live_viewer_serves_a_moving_body(browser, record):
    live = LiveViewer(record, port=8437)
    stop = threading.Event()
    clock = threading.Thread(target=live.play, args=(stop,))
    clock.start()
    try:
        browser.open_address(live.address, ready="document.querySelector('canvas')")
        time.sleep(4)
        before = browser.screenshot()[:, :900]
        deadline = time.monotonic() + 20
        while (share := moved(before, browser.screenshot()[:, :900])) < 0.0005:
            assert time.monotonic() < deadline, f"only {share:.5f} of the picture changed"
            time.sleep(0.5)
        assert browser.errors == []
        assert all(url.startswith(live.address) for url in browser.requests)
    finally:
        stop.set()
        clock.join()
        live.close()
