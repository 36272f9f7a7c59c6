"""The page of a task that is solved again: what is sent to it, and what it may ask for."""

import json
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.live.task_controls import controls_of
from plantigrade.live.task_session import TaskSession
from plantigrade.pages.live_task import LiveTask
from plantigrade.record import Run
from plantigrade.trajopt.tasks.gait_settings import WalkSettings
from tests.browser import wait_for
from tests.pages.walker import walk, walker

RECORD = walk(walker(), duration=2.0)
MOVE = (
    "(c => {{ c.value = {1!r}; c.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
    "(document.querySelector('#panel [name=\"{0}\"]'))"
)


class Clock:
    """A time that the test sets."""

    now = 0.0

    def __call__(self):
        self.now += 1.0
        return self.now


def solved(values, warm, progress) -> Run:
    """A walk whose speed is a figure, and whose trunk is as low as the speed is high."""
    qpos = RECORD.motion.qpos.copy()
    qpos[:, 2] -= 0.1 * (values["speed"] - 1.3)
    record = replace(RECORD, motion=replace(RECORD.motion, qpos=qpos), references={})
    figures = {"walking_speed_m_s": values["speed"], "binding_limits": ["knee at 0.30 s"]}
    status = "ok" if values["speed"] < 2.0 else "the foot slips"
    return Run(record, "synthesize", "Walk", "", status, figures)


@pytest.fixture
def session():
    """A walk that has been solved once."""
    made = TaskSession(controls_of(WalkSettings()), solved, Clock())
    made.advance()
    return made


@pytest.fixture
def page(session):
    """Its page, not yet opened."""
    made = LiveTask(session, task="walk", port=8470, title="Walk", can_save=True)
    yield made
    made.close()


@pytest.fixture
def opened(page, browser):
    """The page in a browser."""
    browser.resize(300, 200)  # the first picture is drawn in full, by software
    browser.open_address(page.address, ready="document.body.dataset.ready === '1'")
    browser.evaluate("plantigrade.setQuality('simple'); plantigrade.pause()")
    browser.resize(1300, 800)
    wait_for(page.session.changed.is_set)
    page.send()
    browser.wait_for("document.getElementById('verdict').textContent")
    return page


def follow(page: LiveTask, browser) -> None:
    """Solve what was changed, and wait for the page to have it."""
    wait_for(lambda: page.session.advance() or None)
    before = int(browser.evaluate("+(document.body.dataset.motions || 0)"))
    page.send()
    browser.wait_for(f"+(document.body.dataset.motions || 0) > {before}")


def text(browser, name: str) -> str:
    return browser.evaluate(f"document.getElementById({name!r}).innerText")


def test_a_slider_changes_the_motion_without_a_new_page(opened, browser):
    browser.evaluate("window.same = true")
    low = browser.evaluate("com[2]")
    browser.evaluate(MOVE.format("speed", "1.8"))
    wait_for(lambda: opened.session.values["speed"] == 1.8)
    follow(opened, browser)
    assert browser.evaluate("window.same") and text(browser, "figures").split() == [
        "Walking", "speed", "[m/s]", "1.80",
    ]  # fmt: skip
    assert browser.evaluate("com[2]") == pytest.approx(low - 0.05, abs=2e-3)
    assert "knee at 0.30 s" in text(browser, "limits")
    assert browser.errors == []


def test_a_motion_that_fails_is_said_and_the_last_one_stays(opened, browser):
    browser.evaluate(MOVE.format("speed", "2.1"))
    wait_for(lambda: opened.session.values["speed"] == 2.1)
    wait_for(lambda: opened.session.advance() or None)
    opened.send()
    browser.wait_for("document.getElementById('verdict').className === 'wrong'")
    assert text(browser, "verdict") == "the foot slips"
    assert "1.30" in text(browser, "figures")


def test_a_handle_is_dragged_along_its_axis(opened, browser):
    browser.evaluate("plantigrade.setView('right'); zoom(2.5)")
    browser.settle()
    handle = "D.handles.find((h) => h.name === 'step_length')"
    x, y = browser.evaluate(f"onScreen({handle}.at)")
    to = browser.evaluate(f"onScreen({handle}.at.map((v, k) => v + 0.4 * {handle}.axis[k]))")
    before = browser.evaluate(f"{handle}.value")
    browser.drag((x, y), (to[0], to[1]))
    wait_for(lambda: opened.session.values["step_length"] is not None)
    length = opened.session.values["step_length"]
    assert length == pytest.approx(before + 0.4 / 4, abs=0.02)  # of four steps, in steps of 1 cm
    assert browser.errors == []


def test_motions_are_kept_and_compared(opened, browser):
    browser.evaluate("document.getElementById('keep').click()")
    wait_for(lambda: len(opened.session.kept) == 1)
    browser.evaluate(MOVE.format("speed", "1.5"))
    wait_for(lambda: opened.session.values["speed"] == 1.5)
    follow(opened, browser)
    assert text(browser, "kept").startswith("as at the start")
    browser.evaluate("document.querySelector('#kept button').click()")
    wait_for(lambda: opened.session.compared is not None)
    opened.send()
    browser.wait_for("ref !== null")
    assert text(browser, "figures").split() == [
        "this", "kept", "Walking", "speed", "[m/s]", "1.50", "1.30",
    ]  # fmt: skip
    assert browser.evaluate("ref.p[5] - body.p[5]") == pytest.approx(0.02, abs=2e-3)


def test_the_button_asks_to_save(opened, browser):
    browser.evaluate("document.getElementById('save').click()")
    wait_for(opened.save_requested.is_set)
    opened.say("Saved: runs/walk")
    opened.send()
    browser.wait_for("document.getElementById('status').textContent.includes('Saved: runs/walk')")


@pytest.mark.parametrize(
    "message",
    [
        "", "[]", "{", '{"do": "format"}', '{"do": "set", "name": "speed"}',
        '{"do": "set", "name": "speed", "value": 99}',
        '{"do": "set", "name": "speed", "value": NaN}',
        '{"do": "set", "name": "speed", "value": {"a": 1}}',
        '{"do": "set", "name": ["speed"], "value": 1}', '{"do": "set", "name": "x", "value": 1}',
        '{"do": "restore", "value": 0}', '{"do": "compare", "value": 7}',
        '{"do": "compare", "value": true}', '{"do": "restore", "value": -1}',
    ],
)  # fmt: skip
def test_damaged_messages_are_refused(session, page, message):
    before = dict(session.values)
    page.receive(message)
    assert session.values == before and session.compared is None
    assert page.panel()["note"]


def test_handles_lie_where_their_parameters_show(page):
    handles = {h["name"]: h for h in page.data["handles"]}
    feet = RECORD.motion.qpos[-1, 0]
    assert abs(handles["step_length"]["at"][0] - feet) < 0.6
    assert handles["step_length"]["axis"] == (1.0, 0.0, 0.0)
    json.dumps(handles)
    assert np.isfinite(handles["step_length"]["value"])
