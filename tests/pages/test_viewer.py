"""The viewer page in a real browser: its clock, keys, small screens, ground, and no graphics.

The clock is the test's own: a frame comes when the test says so, and as late as it says.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.contact.ground import Ground, GroundStep, Seat
from plantigrade.contact.relief import Bump, HeightField
from plantigrade.pages.scene import build_scene
from plantigrade.pages.viewer import viewer_html
from plantigrade.skin import Skin
from tests.conftest import open_browser

CLOCK = """(() => { let now = 0, due = [];
  window.requestAnimationFrame = (f) => due.push(f);
  window.frame = (ms) => { now += ms; const these = due; due = []; these.forEach((f) => f(now)); };
})()"""
READY = "document.body.dataset.ready === '1'"
LONG = "A very long name of a recording, " * 6 + "without_any_place_to_break_it_" * 4
CODES = {
    "Enter": 13,
    "Escape": 27,
    " ": 32,
    "End": 35,
    "Home": 36,
    "ArrowLeft": 37,
    "ArrowRight": 39,
}
STATE = "(plantigrade.state.t).toFixed(4)"
pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def path(tmp_path_factory, record):
    """The viewer of the walk, with a title that is much too long."""
    path = tmp_path_factory.mktemp("viewer") / "viewer.html"
    path.write_text(viewer_html(record, title=LONG, subtitle=LONG), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def page(path):
    """The page, on a clock that stands still."""
    with open_browser(width=700, height=420) as browser:
        browser.call("Page.addScriptToEvaluateOnNewDocument", source=CLOCK)
        browser.open(path, ready=READY)
        browser.evaluate("frame(0)")
        # By software a picture takes long: it is drawn where a test looks at it.
        browser.evaluate("window.really = draw; draw = (...a) => window.seen && really(...a); 0")
        yield browser
        assert browser.errors == []
        assert browser.requests == []


@pytest.fixture
def still(page):
    """The page at its first frame, standing still, nothing chosen."""
    page.resize(700, 420)
    page.evaluate(
        "document.activeElement.blur(); plantigrade.setQuality('full'); plantigrade.pause();"
        "plantigrade.state.speed = 1; plantigrade.state.repeat = true;"
        "plantigrade.seek(0); window.seen = false; frame(0)"
    )
    return page


def frames(browser, *late: float) -> list[float]:
    """Return the time that the page shows after each of some frames, so late [ms]."""
    browser.evaluate("frame(0)")
    shown = "parseFloat(document.getElementById('clock').textContent)"
    return [browser.evaluate(f"(frame({ms}), {shown})") for ms in late]


def press(browser, key: str, code: str = "", text: str = "") -> None:
    """Press and release a key, as the keyboard does."""
    for kind in ("keyDown", "keyUp"):
        said: dict = {"text": text} if text and kind == "keyDown" else {}
        said["windowsVirtualKeyCode"] = CODES.get(key, 0)
        browser.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key, **said)


def space(browser) -> bool:
    """Press the space bar and return whether the page plays."""
    press(browser, " ", "Space", " ")
    return browser.evaluate("plantigrade.state.playing")


def test_a_slow_machine_drops_frames_and_keeps_the_speed(still):
    still.evaluate("plantigrade.play()")
    assert frames(still, *[300] * 6) == pytest.approx([0.3, 0.6, 0.9, 1.2, 1.5, 1.8])
    still.evaluate("plantigrade.state.speed = 0.5")
    assert frames(still, 1000, 10, 90) == pytest.approx([2.3, 2.31, 2.35], abs=0.011)


def test_the_last_frame_stays_a_while_before_the_first_comes_again(still):
    still.evaluate("plantigrade.seek(3.5); plantigrade.play()")
    assert frames(still, 400, 300, 300, 300) == pytest.approx([3.9, 4.0, 4.0, 0.2], abs=0.011)
    still.evaluate("document.getElementById('repeat').click(); plantigrade.seek(3.9)")
    assert frames(still, 50, 700, 700) == pytest.approx([3.95, 4.0, 4.0], abs=0.011)
    assert still.evaluate("plantigrade.state.playing") is False
    still.evaluate("document.getElementById('repeat').click()")


def test_where_frames_are_late_the_drawing_gets_simple_and_says_so(still):
    look = "[document.body.dataset.quality, document.getElementById('slow').hidden]"
    still.evaluate("plantigrade.setQuality('auto'); plantigrade.play()")
    frames(still, *[16] * 250)
    assert still.evaluate(look) == ["full", True]
    size = "(window.seen = true, frame(0), window.seen = false, canvas.width)"
    wide = still.evaluate(size)
    frames(still, *[300] * 12)
    assert still.evaluate(look) == ["simple", False]
    assert still.evaluate(size) < wide
    assert "3.3 pictures per second" in still.evaluate(
        "document.getElementById('slow').textContent"
    )
    said = [still.evaluate(f"pictures({rate})") for rate in (0.4, 1, 1.04, 2.5, 9.97, 31.2)]
    assert said == ["0.4 pictures", "1 picture", "1 picture", "2.5 pictures", "10 pictures",
                    "31 pictures"]  # fmt: skip
    choose = "(() => {{ const s = document.getElementById('quality'); s.value = '{}';"
    choose += "s.dispatchEvent(new Event('change')); }})()"
    still.evaluate(choose.format("full"))
    frames(still, *[300] * 12)
    assert still.evaluate(look) == ["full", True]
    still.evaluate(choose.format("simple"))
    assert still.evaluate(look) == ["simple", False]
    press(still, "q", "KeyQ", "q")
    assert still.evaluate(look) == ["full", True]


@pytest.mark.parametrize(
    "focus", ["#slider", "#play", "#next", "#views button", "#follow", "#speed", "#legend summary"]
)
def test_space_plays_and_pauses_wherever_the_focus_is(still, focus):
    legend = "document.getElementById('legend').open = true"
    still.evaluate(f"{legend}; document.querySelector('{focus}').focus(); frame(0)")
    kept = "[document.getElementById('legend').open, document.getElementById('follow').checked]"
    before = still.evaluate(kept)
    assert space(still) is True
    assert space(still) is False
    assert still.evaluate(STATE) == "0.0000", "the key also pressed what had the focus"
    assert still.evaluate(kept) == before


@pytest.mark.parametrize("focus", ["body", "#slider", "#play", "#follow"])
def test_keys_find_the_first_the_last_and_the_next_frame(still, focus):
    still.evaluate(f"document.querySelector('{focus}').focus()")
    found = []
    for key in ("End", "ArrowLeft", "Home", "ArrowRight", "ArrowRight"):
        press(still, key)
        found.append(float(still.evaluate(STATE)))
    assert found == pytest.approx([4.0, 3.98, 0.0, 0.02, 0.04])


def test_enter_ticks_what_has_the_focus(still):
    still.evaluate("document.getElementById('follow').focus()")
    press(still, "Enter", text="\r")
    assert still.evaluate("plantigrade.state.follow") is False
    press(still, "Enter", text="\r")
    assert still.evaluate("plantigrade.state.follow") is True


def test_the_question_mark_shows_all_keys_until_escape(still):
    shown = "document.getElementById('help').open"
    for close in (("Escape", ""), ("?", "?")):
        press(still, "?", "Slash", "?")
        assert still.evaluate(shown) is True
        text = still.evaluate("document.getElementById('help').innerText")
        assert all(key in text for key in ("Space", "Home", "End", "?", "Esc", "Shift", "Q", "F"))
        press(still, close[0], text=close[1])
        assert still.evaluate(shown) is False


def test_percent_of_the_gait_cycle(still):
    """The right heel strikes every 1.1 s from zero on, the left half a stride later."""
    still.evaluate("plantigrade.seek(1.1 * 1.25); frame(0)")
    assert (
        still.evaluate("document.getElementById('cycle').textContent") == "right 25 % · left 75 %"
    )
    assert still.evaluate("document.getElementById('frame').textContent") == "frame 138"
    still.evaluate("plantigrade.seek(0.3); frame(0)")
    assert still.evaluate("document.getElementById('cycle').textContent") == "right 27 %"


@pytest.mark.parametrize("width", [400, 700, 1200, 1400])
def test_nothing_is_cut_off(still, width):
    still.resize(width, 800)
    still.evaluate("plantigrade.setQuality('simple'); dispatchEvent(new Event('resize')); frame(0)")
    assert still.evaluate("document.documentElement.scrollWidth") <= width
    cut = still.evaluate(
        "[...document.querySelectorAll('figcaption, figcaption *, #bar, header, #views')]"
        ".filter(e => e.getClientRects().length && e.clientWidth && e.scrollWidth > e.clientWidth)"
        ".map(e => e.textContent)"
    )
    assert cut == []
    outside = still.evaluate(
        "[...document.querySelectorAll('button, select, #slider, #clock, summary')]"
        ".filter(e => e.checkVisibility() && !e.closest('dialog') && !e.closest('#legend'))"
        ".map(e => [e.id || e.textContent, e.getBoundingClientRect()])"
        ".filter(([, r]) => r.left < 0 || r.right > innerWidth || r.bottom > innerHeight)"
        ".map(([name]) => name)"
    )
    assert outside == []
    assert still.evaluate("document.getElementById('stage').clientHeight") >= 0.5 * 800


def test_two_fingers_bring_the_body_nearer_and_move_it(still):
    look = "[plantigrade.camera.distance, plantigrade.state.follow]"
    far, follows = still.evaluate(look)
    assert follows
    still.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    for kind, at in (("touchStart", 20), ("touchMove", 50), ("touchEnd", 0)):
        points = [{"x": 350 - at, "y": 200, "id": 0}, {"x": 350 + at, "y": 200, "id": 1}]
        still.call("Input.dispatchTouchEvent", type=kind, touchPoints=points if at else [])
    still.call("Emulation.setTouchEmulationEnabled", enabled=False)
    assert still.evaluate(look)[0] < 0.8 * far
    still.evaluate("plantigrade.setView('feet'); plantigrade.setView('oblique')")
    if not still.evaluate("plantigrade.state.follow"):
        still.evaluate("document.getElementById('follow').click()")


def test_paper_gets_a_still(still):
    still.evaluate("window.seen = true; dispatchEvent(new Event('beforeprint'))")
    size, colours = still.evaluate(
        "(async () => { const i = document.getElementById('still'); await i.decode();"
        "const c = document.createElement('canvas'); c.width = c.height = 200;"
        "const g = c.getContext('2d'); g.drawImage(i, 0, 0, 200, 200);"
        "const d = new Uint32Array(g.getImageData(0, 0, 200, 200).data.buffer);"
        "return [i.naturalWidth, new Set(d).size]; })()"
    )
    assert size == 1600
    assert colours > 300, "the still is (nearly) blank"
    still.evaluate("dispatchEvent(new Event('afterprint'))")
    assert still.evaluate("document.getElementById('still').hidden") is True


def test_lost_graphics_are_reported_and_come_back(still):
    message = "!document.getElementById('nogl').hidden"
    still.evaluate("window.seen = true; window.loss = gl.getExtension('WEBGL_lose_context'); 0")
    wait = "loss.{0}Context(), new Promise(r => canvas.addEventListener('webglcontext{1}',"
    wait += "() => setTimeout(r), {{once: true}})).then(() => 1)"
    still.evaluate(wait.format("lose", "lost"))
    assert still.evaluate(message)
    still.evaluate("plantigrade.seek(1); frame(0)")
    assert still.evaluate("document.body.dataset.time") == "1.0000"
    still.evaluate(wait.format("restore", "restored"))
    still.evaluate("frame(0)")
    assert not still.evaluate(message)


def test_without_graphics_the_curves_still_play(path):
    with open_browser(width=700, height=420) as browser:
        none = "HTMLCanvasElement.prototype.getContext = () => null;"
        browser.call("Page.addScriptToEvaluateOnNewDocument", source=none + CLOCK)
        browser.open(path, ready=READY)
        cursor = "document.querySelector('.cursor').style.transform"
        browser.evaluate("plantigrade.pause(); plantigrade.seek(1); frame(0)")
        was = browser.evaluate(cursor)
        browser.evaluate("plantigrade.seek(2); frame(0)")
        assert browser.evaluate(cursor) != was
        assert "no WebGL 2" in browser.evaluate("document.getElementById('nogl').innerText")
        assert browser.errors == []


def test_who_wants_no_motion_gets_none(path):
    with open_browser(width=240, height=160) as browser:
        browser.call("Page.addScriptToEvaluateOnNewDocument", source=CLOCK)
        for wish, plays in (("reduce", False), ("no-preference", True)):
            feature = {"name": "prefers-reduced-motion", "value": wish}
            browser.call("Emulation.setEmulatedMedia", features=[feature])
            browser.open(path, ready=READY)
            assert browser.evaluate("plantigrade.state.playing") is plays
            browser.open_address("about:blank#", ready="true")


UNEVEN = {
    "slope": Ground(slope=0.1),
    "stairs": Ground(steps=(GroundStep(1.0, 0.15), GroundStep(1.3, 0.3))),
    "down": Ground(height=0.3, steps=(GroundStep(1.0, 0.15), GroundStep(1.3, 0.0))),
    "chair": Ground(seats=(Seat("a", (-0.3, -0.1, 0.45)), Seat("b", (-0.3, 0.1, 0.45)))),
    "bumps": Ground(bumps=(Bump((1.0, 0.0, -0.05), 0.1),)),
    "field": Ground(field=HeightField((0.0, -1.0), (0.5, 0.5), ((0.0, 0.1, 0.2),) * 5)),
}


@pytest.mark.parametrize("name", UNEVEN)
def test_the_ground_of_the_record_is_drawn(tmp_path, record, name):
    """Its plane, treads, relief and seats are there, and the camera looks above what is below."""
    ground = UNEVEN[name]
    path = tmp_path / "viewer.html"
    path.write_text(viewer_html(replace(record, ground=ground), title=name), encoding="utf-8")
    with open_browser(width=240, height=160) as browser:
        browser.call("Page.addScriptToEvaluateOnNewDocument", source=CLOCK)
        browser.open(path, ready=READY)
        sizes = "['fixed', 'ground'].map(k => buffers[k].count > 0)"
        seats, relief = bool(ground.seats), bool(ground.steps or ground.bumps or ground.field)
        assert browser.evaluate(f"[...{sizes}, D.ground.plane]") == [
            seats,
            relief,
            not ground.steps,
        ]
        axes = np.array(browser.evaluate("D.ground.axes")).reshape(3, 3)
        np.testing.assert_allclose(axes[2], ground.normal, atol=1e-8)
        drawn = browser.evaluate("[...floor]")
        scene = build_scene(replace(record, ground=ground))
        np.testing.assert_allclose(drawn, scene.floor, atol=1e-4)
        browser.evaluate("plantigrade.pause(); plantigrade.seek(2); frame(0)")
        look = browser.evaluate("plantigrade.camera.target[2] - plantigrade.camera.height")
        assert look == pytest.approx(scene.level[100], abs=1e-3)
        assert browser.errors == []


def test_the_page_moves_the_skin_as_python_does(still, record):
    """Vertices by the bones of the page: those of Skin, within the steps of 16 bits."""
    scene, skin = build_scene(record), Skin.of(record.human)
    still.evaluate(
        "const posed = skinPose; window.seen = true;"
        "skinPose = (d) => { const x = posed(d); window.rows ??= x; return x; }; 0"
    )
    for frame in (0, 90, 130):
        still.evaluate(f"window.rows = null; plantigrade.seek({scene.time[frame]}); frame(20); 0")
        rows = np.array(still.evaluate("Array.from(window.rows)")).reshape(-1, 8)
        turned = Rotation.from_quat(rows[:, 4:]).as_matrix()
        motions = np.concatenate([turned, rows[:, :3, None]], axis=2)
        blended = np.einsum("nk,nkij->nij", skin.surface.weights, motions[skin.surface.bones])
        seen = np.einsum("nij,nj->ni", blended[:, :, :3], skin.resting.vertices) + blended[:, :, 3]
        desired = skin.posed(scene.positions[frame], scene.quats[frame])
        assert np.abs(seen - desired).max() < 1e-3


def picture(browser) -> np.ndarray:
    """What is drawn at this instant, 240 by 160 pixels, in 0-255."""
    pixels = browser.evaluate(
        "(() => { const p = new Uint8Array(240 * 160 * 4); really({ width: 240, height: 160 });"
        "gl.bindFramebuffer(gl.FRAMEBUFFER, null);"
        "gl.readPixels(0, 0, 240, 160, gl.RGBA, gl.UNSIGNED_BYTE, p); return Array.from(p); })()"
    )
    return np.array(pixels).reshape(160, 240, 4)[..., :3]


def test_skin_solids_and_x_ray_are_one_key_away(still):
    """Each is drawn, and each differs from the others."""
    still.evaluate("plantigrade.seek(1.0); frame(20); 0")
    pictures = [picture(still)]
    for key in ("s", "x", "s"):  # the solids, through them, the skin with the solids in it
        press(still, key)
        pictures.append(picture(still))
    press(still, "x")
    for i, one in enumerate(pictures):
        for other in pictures[:i]:
            assert (np.abs(one - other).max(axis=2) > 30).sum() > 100


def test_a_page_with_skin_is_small(path):
    """Half a megabyte at most for skin, script and the walk of four seconds."""
    assert path.stat().st_size < 600e3
