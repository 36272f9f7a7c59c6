"""Pictures per second of both viewers in a real Chromium, 900 pixels wide.

It draws in software (SwiftShader), the worst case; with ``CHROMIUM_GRAPHICS=card`` in the
environment, with the graphics card. ``auto`` is what a reader sees: a slow machine draws simply.
Pictures per second ask for an idle machine; processor time of the browser for a picture holds on a
busy one, too.
"""

import platform
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from threading import Event, Thread

from experiments.table import Row, at_least
from plantigrade.live.clock import Clock
from plantigrade.live.session import run
from plantigrade.pages.live_world import LiveWorld
from plantigrade.pages.viewer import viewer_html
from plantigrade.workflows.live import prepare, responsive
from tests.browser import Browser, find_browser, stop
from tests.pages.walker import walk, walker

WIDTH, HEIGHT = 900, 640  # [px] of the window; chosen
SECONDS = 6.0  # [s] of one figure; chosen
SETTLING_TIME = 8.0  # [s] in which a page finds out how fast the machine draws
MIN_PICTURE_RATE = 10.0  # [pictures/s] in software
RENDERER = "gl.getParameter(gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL)"


def rows() -> Iterator[Row]:
    """Yield pictures per second of the viewer and of the live page, in each quality."""
    if find_browser() is None:
        yield Row("viewers", "not measured", None, note="no Chromium: apt-get install chromium")
        return
    try:
        yield from viewer_rows()
        yield from live_rows()
    finally:
        stop()


def viewer_rows() -> Iterator[Row]:
    """Yield the figures of ``viewer.html``: a walk with skin, markers and forces."""
    with tempfile.TemporaryDirectory() as folder, Browser(width=WIDTH, height=HEIGHT) as browser:
        page = Path(folder) / "viewer.html"
        page.write_text(viewer_html(walk(walker()), title="A walk"), encoding="utf-8")
        browser.open(page, ready="document.body.dataset.ready")
        browser.evaluate("plantigrade.play()")
        yield from rates(browser, "viewer.html")


def live_rows() -> Iterator[Row]:
    """Yield the figures of the live page, while the simulation runs beside it."""
    session, clock, over = prepare(controller="balance").session, Clock(), Event()
    page = LiveWorld(session, clock, port=8099)
    threads = [
        Thread(target=run, args=(session, over, clock)),
        Thread(target=page.show, args=(over,)),
    ]
    try:
        with responsive(), Browser(width=WIDTH, height=HEIGHT) as browser:
            for thread in threads:
                thread.start()
            browser.open_address(page.address, ready="document.body.dataset.time")
            yield from rates(browser, "live page")
    finally:
        over.set()
        for thread in threads:
            if thread.ident is not None:
                thread.join()
        page.close()
    yield Row("live page", "behind real time", clock.time_lost, f"s in {session.world.time:.0f} s")


def rates(browser: Browser, subject: str) -> Iterator[Row]:
    """Yield pictures per second in each quality; which one ``auto`` chooses is in the note."""
    where = f"{browser.evaluate(RENDERER)}; {processor()}"
    for quality in ("full", "simple", "auto"):
        browser.evaluate(f"plantigrade.setQuality('{quality}')")
        time.sleep(SETTLING_TIME)
        drawn, spent = browser.evaluate("plantigrade.state.drawn"), browser.processor_time()
        began = time.perf_counter()
        time.sleep(SECONDS)
        count = browser.evaluate("plantigrade.state.drawn") - drawn
        rate = count / (time.perf_counter() - began)
        spent = browser.processor_time() - spent
        goal, note = (MIN_PICTURE_RATE, where) if quality == "auto" else (None, "")
        chosen = browser.evaluate("document.body.dataset.quality") if quality == "auto" else ""
        name = f"{quality}, here {chosen}" if chosen else quality
        yield at_least(subject, f"drawing: {name}", rate, goal, "pictures/s", note)
        yield Row(subject, "of processors, a picture", spent / max(count, 1), "s")


def processor() -> str:
    """Return the kind of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{len(names)} × {names[0]}" if names else platform.processor()
