"""The page of a live session: what is sent to a browser, and what a browser may ask for."""

import json

import numpy as np
import pytest
from websockets.sync.client import connect

from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.live.clock import Clock
from plantigrade.live.session import Choice, Session
from plantigrade.models import Human
from plantigrade.pages.live_commands import Commands
from plantigrade.pages.live_scene import frame_data, world_data
from plantigrade.pages.live_world import (
    LiveWorld,
    control_values,
    curves_data,
    soles_of,
    status_lines,
)
from plantigrade.pages.page_server import SOCKET_PATH
from plantigrade.record import Provenance
from plantigrade.workflows.live import SessionWorlds
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.simulation_start import Start
from plantigrade.world import Controller, Drawing, StablePD, Target
from plantigrade.world.model_mismatch import ModelMismatch
from tests.browser import wait_for

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")
SMALL = SimulateSettings(rate=300.0, control_rate=50.0)
CLICK = "[...document.querySelectorAll('button')].find(b => b.innerText === {!r}).click()"
SET = (
    "(c => {{ c.value = {1!r}; c.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
    "(document.querySelector('#panel [name={0}]'))"
)


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


def new_session(ground: Ground | None = None, own: Controller | None = None) -> Session:
    """Return a session of a person who stands."""
    begin = Start(HUMAN, ground or Ground(), "standing", Provenance("", {}))
    stage = SessionWorlds(begin, ModelMismatch(), SMALL, own=own)
    return Session(stage, stage.choice)


@pytest.fixture
def session():
    """A session of a person who stands on level ground."""
    return new_session()


def ask(commands: Commands, what: str, **values) -> None:
    """Let a message of a browser arrive."""
    commands.receive(json.dumps({"do": what, **values}))


@pytest.fixture
def page(session):
    """The page of the session, not yet opened."""
    live = LiveWorld(session, Clock(), port=8460, can_save=True)
    yield live
    live.close()


@pytest.fixture
def opened(page, browser):
    """The same page in a browser."""
    browser.resize(300, 200)  # the first picture is drawn in full, by software
    browser.open_address(page.address, ready="document.body.dataset.time !== undefined")
    browser.evaluate("plantigrade.setQuality('simple')")
    browser.resize(1300, 800)
    return page


def go(page: LiveWorld, seconds: float) -> None:
    """Simulate and draw."""
    page.session.advance(seconds)
    page.draw(page.session.frame)


def test_a_frame_holds_body_and_forces_of_one_instant(session):
    session.advance(0.1)
    frame = session.frame
    sent, weight = frame_data(frame), HUMAN.mass * 9.81
    hand = HUMAN.body("forearm_r")
    np.testing.assert_allclose(sent["positions"][hand], frame.positions[hand], atol=1e-4)
    np.testing.assert_allclose(sent["quats"][hand], frame.quats[hand], atol=1e-4)
    np.testing.assert_allclose(sent["com"], frame.com, atol=1e-4)
    loads = [force[2] for _, _, force in sent["contacts"]]
    assert sum(loads) == pytest.approx(weight, rel=0.3)
    for side, reaction in zip("rl", sent["reactions"], strict=True):
        own = [k for k, site in enumerate(session.world.sites) if site.side == side]
        point, force = reaction
        np.testing.assert_allclose(force, frame.force[own].sum(axis=0), atol=0.1)
        assert (point[1] > 0) == (side == "l")
    corners = np.array(sent["support"])  # of all that presses
    assert corners[:, 1].min() < 0 < corners[:, 1].max()
    assert corners[:, 0].max() == pytest.approx(frame.point[:, 0].max(), abs=1e-4)
    assert sent["floor"] == pytest.approx(0.0, abs=1e-3) and sent["ground"]["plane"]


def test_the_grid_lies_on_ground_that_tilts(session):
    session.tilt(np.deg2rad(6.0), 0.0)
    session.advance(1.5)
    ground = frame_data(session.frame)["ground"]
    ahead, up = np.array(ground["axes"][:3]), np.array(ground["axes"][6:])
    assert np.rad2deg(np.arctan2(ahead[2], ahead[0])) == pytest.approx(6.0, abs=0.5)
    np.testing.assert_allclose(np.cross(ahead, ground["axes"][3:6]), up, atol=1e-5)


def test_the_floor_is_the_step_under_the_person():
    session = new_session(Ground(steps=(GroundStep(-1.0, 0.15),)))
    session.advance(0.02)
    sent = frame_data(session.frame)
    assert sent["ground"] is None and sent["floor"] == pytest.approx(0.15)
    assert not world_data(session.world)["ground"]["plane"]


def test_pushes_and_the_pack_are_drawn_while_they_are_there(session):
    assert frame_data(session.frame)["pushes"] == []
    session.push(np.pi / 2, 0.1)
    session.advance(0.05)
    ((_, force),) = frame_data(session.frame)["pushes"]
    np.testing.assert_allclose(force, [0.0, 100.0, 0.0], atol=1e-9)
    session.advance(0.2)
    assert frame_data(session.frame)["pushes"] == []
    sizes = []
    for mass in (5.0, 20.0):
        session.set_load(mass)
        session.advance(0.02)
        sent = frame_data(session.frame)
        sizes.append(np.prod(sent["pack"]))
        torso = session.frame.positions[HUMAN.body("torso")]
        assert 0.1 < torso[0] - sent["positions"][-1][0] < 0.35
    assert sizes[1] == pytest.approx(4.0 * sizes[0], rel=1e-5)
    session.set_load(0.0)
    session.advance(0.02)
    assert frame_data(session.frame)["pack"] is None


def test_what_a_controller_draws():
    session = new_session(own=Pointing())
    session.advance(0.02)
    aim, here = frame_data(session.frame)["drawings"]
    assert np.shape(aim["lines"]) == (1, 2, 3)
    np.testing.assert_allclose(here["points"][0], session.frame.com, atol=5e-3)
    session.advance(0.1)  # the line is not offered any more
    assert [drawing["lines"] for drawing in frame_data(session.frame)["drawings"]] == [[]]


def test_a_person_has_skin_and_bones_where_the_feet_have_them():
    drawn = world_data(new_session().world)
    assert drawn["skin"] is not None and drawn["foot"] is None
    assert drawn["bodies"] == HUMAN.model.nbody + 2  # the ground that tilts, and the pack


def test_curves_name_what_they_show(session):
    session.advance(0.5)
    curves = curves_data(session.frame, soles_of(session), "ankle_angle_r")
    named = [(chart["title"], chart["unit"]) for chart in curves["charts"]]
    assert named == [
        ("Ankle dorsiflexion", "°"),
        ("Ankle dorsiflexion, torque", "N m"),
        ("Ground force, vertical", "BW"),
        ("Centre of pressure", "cm"),
    ]
    angle, _, force, _ = curves["charts"]
    assert [line["label"] for line in angle["lines"]] == ["right", "left"]
    row = [HUMAN.hinge("ankle_angle_r"), HUMAN.hinge("ankle_angle_l")]
    last = [line["values"][-1] for line in angle["lines"]]
    np.testing.assert_allclose(last, np.rad2deg(session.frame.history.angles[-1, row]), atol=1e-3)
    loads = np.array([line["values"] for line in force["lines"]])
    assert loads.sum(axis=0) == pytest.approx(1.0, abs=0.3)
    assert curves["time"][-1] == 0.0 and curves["plate"].count("<svg") == 2
    middle = curves_data(session.frame, soles_of(session), "lumbar_extension")
    assert [line["label"] for line in middle["charts"][0]["lines"]] == [""]


def test_controls_follow_the_session(session):
    clock = Clock()
    assert status_lines(session, clock, session.frame) == ["0.00 s, 1×, 100 % of real time"]
    session.submit(lambda: session.choose(Choice("passive", "two-segment", "42")))
    session.advance(0.0)
    assert control_values(session)["feet"] == "two-segment"
    assert "the recording so far is lost" in status_lines(session, clock, session.frame)[1]
    session.advance(1.5)
    assert "fell at" in status_lines(session, clock, session.frame)[1]


def test_commands_set_the_session(session):
    commands = Commands(session, can_save=True)
    ask(commands, "controller", value="passive")
    session.advance(0.0)
    for name, value in {
        "slope": 4.0,
        "friction": 0.3,
        "load": 5.0,
        "pause": True,
        "speed": 0.25,
        "force": 50.0,
    }.items():
        ask(commands, name, value=value)
    session.advance(0.0)
    values = control_values(session)
    assert (values["slope"], values["cross_slope"]) == (pytest.approx(4.0), 0.0)
    assert [values[k] for k in ("friction", "load", "pause", "speed", "force", "controller")] == [
        *(0.3, 5.0, True, 0.25, 50.0, "passive")
    ]
    ask(commands, "restart")
    session.advance(0.0)
    assert control_values(session)["friction"] == Ground().friction
    ask(commands, "joint", value="knee_angle_r")
    assert commands.joint == "knee_angle_r"
    ask(commands, "save")
    assert commands.save_requested.is_set() and not session.message


def test_targets_of_a_controller_are_set_by_their_names():
    session = new_session(own=Pointing())
    commands = Commands(session, can_save=False)
    ask(commands, "target", name="style", value=1)
    ask(commands, "target", name="bend", value=12.5)
    session.advance(0.02)
    bend, style = control_values(session)["targets"]
    assert (bend["value"], style["value"], style["names"]) == (12.5, 1.0, ["walk", "stroll"])
    ask(commands, "target", name="bend", value=90.0)
    session.advance(0.02)
    assert "must be 0–30 deg" in session.message


@pytest.mark.parametrize(
    "message",
    ["", "[]", "3", "{", '{"do": []}', '{"do": "format"}', '{"do": "save"}', '{"do": "pause"}',
     '{"do": "friction", "value": NaN}', '{"do": "friction", "value": 1e9}',
     '{"do": "friction", "value": "slippery"}', '{"do": "friction", "value": true}',
     '{"do": "friction", "value": 0.5, "more": 1}', '{"do": "pause", "value": "yes"}',
     '{"do": "controller", "value": "hope"}', '{"do": "feet", "value": 3}',
     '{"do": "feet", "value": ["rigid"]}', '{"do": "joint", "value": "__class__"}',
     '{"do": "push", "force": 1e6, "direction": 0, "duration": 0.1}',
     '{"do": "hold", "body": 1.5, "at": [0, 0, 1], "end": [0, 0, 1]}',
     '{"do": "hold", "body": 1, "at": [0, 0], "end": [0, 0, 1]}',
     '{"do": "pull", "end": [0, 0, Infinity]}', "[" * 3000],
)  # fmt: skip
def test_a_message_that_the_page_does_not_send_is_refused(session, message):
    commands = Commands(session, can_save=False)
    before = control_values(session)
    commands.receive(message)
    assert "refused" in session.message
    assert not session.pending and control_values(session) == before


def test_a_body_that_is_none_cannot_be_held(session):
    ask(Commands(session, can_save=False), "hold", body=999, at=[0, 0, 1], end=[0, 0, 1])
    session.advance(0.0)
    assert "no body 999" in session.message


def test_a_browser_that_comes_later_gets_the_last_frame(page):
    go(page, 0.1)
    page.update_controls(page.session.frame)
    with connect(page.address.replace("http", "ws") + SOCKET_PATH) as socket:
        socket.send('{"do": "join"}')
        first, second = (json.loads(socket.recv()) for _ in range(2))
    assert first["kind"] == "frame" and second["kind"] == "panel"
    assert first["time"] == pytest.approx(page.session.frame.time)


def test_ground_of_any_friction_has_a_page():
    page = LiveWorld(new_session(Ground(friction=0.01)), Clock(), port=8462)
    page.close()


@pytest.mark.slow
def test_another_body_has_another_page(opened, browser):
    """The page is loaded anew; what is shown stays."""
    browser.evaluate("option('solids')")
    opened.session.choose(Choice("passive", "multi-segment", "42"))
    go(opened, 0.0)
    browser.wait_for("D.foot !== null && document.body.dataset.time")
    assert browser.evaluate("show.solids")
    assert browser.errors == []


def test_what_is_set_on_the_page_reaches_the_session(opened, browser):
    session = opened.session
    before = session.frame.com
    browser.evaluate(SET.format("force", "300"))
    browser.evaluate(CLICK.format("Push the trunk"))
    wait_for(lambda: len(session.pending))
    go(opened, 0.3)
    assert session.hand.max_force == 300.0
    assert (session.frame.com - before)[0] > 0.005
    record = session.record()
    assert [s.name for s in record.sites if s.part == "push"] == ["push_torso"]
    browser.evaluate(SET.format("friction", "0.25"))
    wait_for(lambda: len(session.pending))
    go(opened, 0.0)
    opened.update_controls(session.frame)
    opened.update_curves(session.frame)
    browser.wait_for("document.getElementById('status').innerText.includes('0.30 s')")
    assert browser.evaluate("document.querySelector('[name=friction]').value") == "0.25"
    browser.wait_for("document.querySelectorAll('#charts figure').length === 4")
    heading = browser.evaluate("document.querySelector('#charts b').textContent")
    assert heading == "Ankle dorsiflexion [°]"
    assert browser.errors == []
    assert browser.requests == [f"{opened.address}/"]


def test_panels_leave_the_person_in_sight(opened, browser):
    shown = "['curves', 'panel'].filter(id => document.getElementById(id).checkVisibility())"
    wide = "document.getElementById('stage').clientWidth / innerWidth"
    tall = "document.getElementById('stage').clientHeight / innerHeight"
    assert browser.evaluate(shown) == ["curves", "panel"]
    for size, least in (((1000, 700), (0.6, 0.7)), ((390, 780), (0.99, 0.35))):
        browser.resize(*size)
        assert browser.evaluate(shown) == []
        browser.settle()
        assert browser.evaluate("$('legend').open") == (size[0] > 640)
        for button, panel in (("Feet and curves", "curves"), ("Controls", "panel")):
            browser.evaluate(CLICK.format(button))
            assert browser.evaluate(shown) == [panel]
            assert browser.evaluate(f"[{wide}, {tall}]") >= list(least)
            assert browser.evaluate(tall) >= least[1]
        browser.evaluate(CLICK.format("Controls"))
        assert browser.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("solids", [False, True])
def test_a_body_is_dragged_with_the_mouse(opened, browser, solids):
    """At the trunk: the middle of the picture; and the camera stays."""
    session = opened.session
    browser.evaluate(f"show.solids = {str(solids).lower()}; plantigrade.setView('front')")
    browser.settle()
    x, y = browser.evaluate(
        "(r => [r.x + r.width / 2, r.y + 0.4 * r.height])(canvas.getBoundingClientRect())"
    )
    view = browser.evaluate("camera.azimuth")
    browser.mouse("mousePressed", x, y)
    for k in range(1, 6):
        browser.mouse("mouseMoved", x + 12 * k, y)
    wait_for(lambda: len(session.pending) >= 2)
    session.advance(0.0)
    rope, before = session.hand.rope, session.frame.com
    trunk = {HUMAN.body(name) for name in ("pelvis", "lumbar", "torso") if name in bodies()}
    assert rope.body in trunk
    pulled = rope.end - rope.position(session.world.data)
    assert pulled[1] > 0.05  # to the right of the picture is the left of the person
    np.testing.assert_allclose(pulled[[0, 2]], 0.0, atol=0.03)
    go(opened, 0.3)
    assert (session.frame.com - before) @ pulled > 1e-4
    assert frame_data(session.frame)["rope"] is not None
    browser.mouse("mouseReleased", x + 60, y)
    wait_for(lambda: session.advance(0.0) == 0.0 and session.hand.rope is None)
    assert browser.evaluate("camera.azimuth") == view
    browser.drag((x + 300, y), (x + 340, y))  # beside the body: the view turns
    assert browser.evaluate("camera.azimuth") != view
    assert not session.pending


def bodies() -> set[str]:
    """Return the names of the bodies of the person."""
    return {HUMAN.model.body(k).name for k in range(HUMAN.model.nbody)}
