"""The page of a live session, in a real browser: what is sent from it moves the body."""

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from viser._messages import GuiUpdateMessage

from plantigrade.contact.ground import Ground
from plantigrade.live.clock import Clock
from plantigrade.live.session import Choice, Session
from plantigrade.models import Human
from plantigrade.pages.live_parts import ARROW_PER_BODY_WEIGHT
from plantigrade.pages.live_world import LiveWorld
from plantigrade.record import Provenance
from plantigrade.workflows.beginning import Start
from plantigrade.workflows.live import Stage
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.world import Controller, Drawing, StablePD, Target
from plantigrade.world.model_mismatch import ModelMismatch
from tests.browser import wait_for

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")
SMALL = SimulateSettings(rate=300.0, control_rate=50.0)
CLICK = "[...document.querySelectorAll('button')].find(b => b.innerText === {!r}).click()"


@pytest.fixture
def page():
    """A page of a person who stands, not yet opened."""
    begin = Start(HUMAN, Ground(), "standing", Provenance("", {}))
    stage = Stage(begin, ModelMismatch(), SMALL)
    live = LiveWorld(Session(stage, stage.choice), Clock(), port=8460, can_save=True)
    yield live
    live.close()


@pytest.fixture
def opened(page, browser):
    """The same page in a browser."""
    browser.resize(1300, 800)
    browser.open_address(page.address, ready="document.body.innerText.includes('Push the trunk')")
    return page


def go(page: LiveWorld, seconds: float) -> None:
    """Simulate and draw."""
    page.session.advance(seconds)
    page.draw(page.session.frame)


class Pointing(Controller):
    """A controller that points at the left forefoot, and may be bent."""

    def __init__(self):
        self.targets = (
            Target("bend", 0.0, 30.0, 5.0, "deg"),
            Target("style", 0.0, 1.0, 0.0, names=("walk", "stroll")),
        )

    def __call__(self, state):
        return StablePD(state.human.standing()[7:])

    def drawings(self, state):
        ends = [state.body.com, [0.1, 0.1, 0.0]]
        lines = () if state.time > 0.05 else (Drawing(name="aim", lines=np.array([ends])),)
        return (*lines, Drawing(name="here", points=state.body.com[None]))


def nodes(page: LiveWorld) -> dict:
    """Return what stands in the scene, by name."""
    return dict(page.server.scene._handle_from_node_name)


def shown(page: LiveWorld) -> str:
    """Return what is said over the controls."""
    return page.panel.status


def test_what_is_drawn_is_where_it_is(page):
    go(page, 0.1)
    frame, drawn = page.session.frame, nodes(page)
    offset = np.array(drawn["/world"].position)
    np.testing.assert_allclose(offset, [*-frame.com[:2], 0.0], atol=1e-9)
    hand = HUMAN.body("forearm_r")
    place = drawn[f"/world/body/{hand}_forearm_r"].position
    np.testing.assert_allclose(place, frame.positions[hand], atol=1e-3)
    ends = np.array(drawn["/world/contact_forces"].points)
    up = frame.force[frame.force[:, 2] > 0]
    weight = HUMAN.mass * 9.81
    np.testing.assert_allclose(
        ends[:, 1] - ends[:, 0], ARROW_PER_BODY_WEIGHT * up / weight, atol=1e-5
    )
    ring = np.array(drawn["/world/support"].points)
    np.testing.assert_allclose(ring[:, 1], np.roll(ring[:, 0], -1, axis=0))
    x, y = ring[:, 0, :2].T  # the outline holds all of what presses
    assert (x.min(), x.max()) == pytest.approx(
        (frame.point[frame.force[:, 2] > 0, 0].min(), frame.point[:, 0].max()), abs=1e-6
    )
    assert y.min() < 0 < y.max()


def test_pushes_and_the_pack_are_seen_while_they_are_there(page):
    session = page.session
    go(page, 0.05)
    assert "/world/pack" not in nodes(page) and not page._pushing
    session.push(np.pi / 2, 0.1)
    go(page, 0.05)
    (arrow,), trunk = page._pushing, session.frame.pushes[0, 0]
    assert arrow.shaft.visible and not arrow.disc.visible
    np.testing.assert_allclose(session.frame.pushes[0, 1], [0.0, 100.0, 0.0], atol=1e-9)
    start, weight = np.array(arrow.shaft.position), HUMAN.mass * 9.81
    assert trunk[1] - start[1] == pytest.approx(0.3 + 0.5 * 60.0 / weight, abs=0.05)
    go(page, 0.2)
    assert not arrow.shaft.visible and not len(session.frame.pushes)
    sizes = []
    for mass in (5.0, 20.0, 0.0):
        session.set_load(mass)
        go(page, 0.02)
        if mass:
            box = nodes(page)["/world/pack"]
            sizes.append(np.prod(box.dimensions))
            behind = session.frame.positions[HUMAN.body("torso")][0] - box.position[0]
            assert 0.1 < behind < 0.35
    assert sizes[1] == pytest.approx(4.0 * sizes[0], rel=1e-5)
    assert "/world/pack" not in nodes(page)


def test_controls_follow_the_session(page):
    page.panel.update(page.session.frame)
    assert "0.00 s" in shown(page) and "100 % of real time" in shown(page)
    page.session.submit(lambda: page.session.choose(Choice("passive", "two-segment", "42")))
    go(page, 0.0)
    page.panel.update(page.session.frame)
    assert "the recording so far is lost" in shown(page)
    assert any(name.startswith("/world/body/") and "toes_r" in name for name in nodes(page))
    go(page, 1.5)
    page.panel.update(page.session.frame)
    assert "fell at" in shown(page)


def test_what_is_set_on_the_page_is_not_taken_back_before_it_is_done(page):
    """Somebody moves sliders and ticks a box while figures of a moment ago are still shown."""
    panel, session = page.panel, page.session
    panel.update(session.frame)
    for handle, value in (
        (panel._slope, 4.0),
        (panel._friction, 0.3),
        (panel._pause, True),
    ):
        handle._impl.value = value  # as viser does with what a browser sends
        for told in handle._impl.update_cb:
            told(SimpleNamespace(client="a browser", target=handle))
        panel.update(session.frame)
        assert handle.value == value
    session.advance(0.0)
    np.testing.assert_allclose(session.desired_slope, np.deg2rad([4.0, 0.0]))
    assert session.friction == 0.3 and session.paused
    session.restart()
    panel.update(session.frame)
    assert (panel._slope.value, panel._friction.value) == (0.0, Ground().friction)


def test_ground_of_any_friction_has_a_page():
    ice = Ground(friction=0.01)
    stage = Stage(Start(HUMAN, ice, "standing", Provenance("", {})), ModelMismatch(), SMALL)
    page = LiveWorld(Session(stage, stage.choice), Clock(), port=8462)
    page.close()


def test_targets_and_drawings_of_a_controller_are_on_the_page():
    begin = Start(HUMAN, Ground(), "standing", Provenance("", {}))
    how = SMALL
    stage = Stage(begin, ModelMismatch(), how, own=Pointing())
    page = LiveWorld(Session(stage, stage.choice), Clock(), port=8461)
    try:
        page.panel.update(page.session.frame)
        slider, box = page.panel.targets
        assert (slider.label, slider.min, slider.max, slider.value) == ("bend [deg]", 0, 30, 5)
        assert (tuple(box.options), box.value) == (("walk", "stroll"), "walk")
        box._impl.value = "stroll"  # as viser does with what a browser sends
        for told in box._impl.update_cb:
            told(SimpleNamespace(client="a browser", target=box))
        go(page, 0.02)
        bend, style = page.session.targets
        assert style.value == 1.0
        bend.set(25.0)  # by the controller itself
        page.panel.update(page.session.frame)
        assert (slider.value, box.value) == (25.0, "stroll")
        drawn = nodes(page)
        assert drawn["/world/offered/aim/lines"].visible
        np.testing.assert_allclose(
            drawn["/world/offered/here/points"].points[0], page.session.frame.com, atol=5e-3
        )
        go(page, 0.1)  # it is not offered any more
        assert not drawn["/world/offered/aim/lines"].visible
    finally:
        page.close()


@pytest.mark.slow
def send(page: LiveWorld, control, updates: dict) -> None:
    """Let a message of a client arrive."""
    interface = page.server.gui._websock_interface
    message = GuiUpdateMessage(control._impl.uuid, updates)
    asyncio.run(interface._handle_incoming_message(0, message))


def test_a_message_that_sets_what_the_page_does_not_offer_is_refused(page):
    panel, session = page.panel, page.session
    for control, updates in (
        (panel._controller, {"value": "hope"}),
        (panel._feet, {"value": 3}),
        (panel._friction, {"value": float("nan")}),
        (panel._friction, {"value": 1e9}),
        (panel._friction, {"value": "slippery"}),
        (panel._pause, {"removed": True}),
        (panel._pause, {"value": "yes"}),
        (panel._force, {"value": 50.0, "visible": False}),
    ):
        before, session.message = control.value, ""
        send(page, control, updates)
        assert control.value == before and "refused" in session.message, updates
    send(page, panel._force, {"value": 50.0})
    assert panel._force.value == 50.0
    go(page, 0.05)
    panel.update(session.frame)  # nothing that was refused is met here


def test_no_client_can_open_a_tunnel(page):
    handlers = page.server._websock_server._incoming_handlers
    assert not any("Share" in kind.__name__ for kind in handlers)


def test_restarts_do_not_make_the_page_grow():
    made = []

    def pointing(*_):
        made.append(Pointing())
        return made[-1]

    begin = Start(HUMAN, Ground(), "standing", Provenance("", {}))
    stage = Stage(begin, ModelMismatch(), SMALL)

    def director(choice, hand, place):
        return replace(stage(choice, hand, place), controller=pointing)

    live = LiveWorld(Session(director, stage.choice), Clock(), port=8462)
    try:
        buffer = live.server._websock_server.get_message_buffer()
        sizes = []
        for _ in range(6):
            live.session.restart()
            go(live, 0.05)
            live.panel.update(live.session.frame)
            sizes.append(len(buffer.message_from_id))
        assert sizes[-1] == sizes[1]
        send(live, live.panel.targets[0], {"value": 12.0})
        assert live.panel._of is made[-1].targets, "the controls set the new controller"
    finally:
        live.close()


def test_a_push_sent_from_the_page_moves_the_body(opened, browser):
    session = opened.session
    before = session.frame.com
    browser.evaluate(CLICK.format("Push the trunk"))
    wait_for(lambda: len(session.pending))
    go(opened, 0.3)
    assert (session.frame.com - before)[0] > 0.005
    record = session.record()
    assert [s.name for s in record.sites if s.part == "push"] == ["push_torso"]
    assert browser.errors == []
    assert browser.requests == [f"{opened.address}/"]


@pytest.mark.slow
def test_a_body_is_dragged_with_the_mouse(opened, browser):
    session = opened.session
    wait_for(lambda: browser.evaluate("document.querySelector('canvas') !== null"))
    browser.settle()
    box = browser.evaluate(
        "(r => [r.x, r.y, r.width, r.height])"
        "(document.querySelector('canvas').getBoundingClientRect())"
    )
    x, y = box[0] + box[2] / 2, box[1] + box[3] / 2  # where the camera looks: at the person

    def held() -> bool:
        browser.mouse("mousePressed", x, y)
        for k in range(1, 6):
            browser.mouse("mouseMoved", x + 12 * k, y)
        session.advance(0.0)
        if session.hand.rope is None:  # not yet drawn
            browser.mouse("mouseReleased", x, y)
        return session.hand.rope is not None

    wait_for(held)
    rope, before = session.hand.rope, session.frame.com
    pulled = rope.end - rope.position(session.world.data)
    assert np.linalg.norm(pulled) > 0.01
    go(opened, 0.3)
    assert (session.frame.com - before) @ pulled > 1e-4
    assert session.frame.rope is not None
    browser.mouse("mouseReleased", x + 60, y)
    wait_for(lambda: session.advance(0.0) == 0.0 and session.frame.rope is None)
