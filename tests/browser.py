"""A real headless Chromium, driven over the DevTools protocol, for looking at the pages we write.

Install it with ``apt-get install chromium`` (Debian); any Chromium or Chrome on the path is found,
or the one that the environment variable ``CHROMIUM`` names. Where there is none,
:func:`~plantigrade.pages.pdf.find_browser` returns None and a test that needs it skips, saying so.

The flags that make it draw WebGL without a graphics card, as root in a container:

- ``--headless --no-sandbox``: no window; the sandbox needs privileges a container does not give.
- ``--use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader``: WebGL by software; with
  ``CHROMIUM_GRAPHICS=card`` in the environment the graphics card draws instead.
- ``--disable-background-networking``: no request that the page did not make.
- ``--user-data-dir``: a fresh folder each time, or a second start waits for the first one's lock.
- ``--remote-debugging-port=0``: a free port, written to ``DevToolsActivePort`` in that folder.
- ``--disable-dev-shm-usage``: ``/dev/shm`` is small in containers.
"""

import atexit
import base64
import io
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from plantigrade.pages.pdf import find_browser

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-background-networking",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--no-first-run",
    "--hide-scrollbars",
    "--remote-debugging-port=0",
)
SOFTWARE = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
CARD = ("--use-gl=angle", "--ignore-gpu-blocklist")


class _Chromium:
    """One process for all pages of a test run: starting one costs as much as many pages."""

    def __init__(self):
        path = find_browser()
        if path is None:
            raise RuntimeError("no Chromium found: apt-get install chromium")
        self._folder = tempfile.mkdtemp(prefix="chromium-")
        graphics = CARD if os.environ.get("CHROMIUM_GRAPHICS") == "card" else SOFTWARE
        self._process = subprocess.Popen(
            [path, *FLAGS, *graphics, f"--user-data-dir={self._folder}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            port_file = Path(self._folder) / "DevToolsActivePort"
            wait_for(lambda: port_file.exists() and port_file.read_text().count("\n"))
            port, path = port_file.read_text().splitlines()[:2]
            self._host = f"ws://127.0.0.1:{port}"
            self.session = _Session(f"{self._host}{path}")
        except BaseException:
            self.stop()
            raise

    def page(self, target: str) -> "_Session":
        """Connect to the page ``target``."""
        return _Session(f"{self._host}/devtools/page/{target}")

    def stop(self) -> None:
        """Stop the process and remove its folder."""
        if hasattr(self, "session"):
            self.session.close()
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        shutil.rmtree(self._folder, ignore_errors=True)


class _Session:
    """A connection to the browser or to one page for commands, answers and events."""

    def __init__(self, address: str, note=lambda message: None):
        from websockets.sync.client import connect

        self._socket, self._next, self.note = (
            connect(address, max_size=None, proxy=None).__enter__(),
            0,
            note,
        )
        self.close = self._socket.close

    def call(self, method: str, **params):
        """Send one DevTools command and return its result."""
        self._next += 1
        self._socket.send(json.dumps({"id": self._next, "method": method, "params": params}))
        while True:
            message = json.loads(self._socket.recv())
            self.note(message)
            if message.get("id") == self._next:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message["result"]


_running: list[_Chromium] = []


def stop() -> None:
    """Stop the process that the pages share, if one runs."""
    while _running:
        _running.pop().stop()


atexit.register(stop)


class Browser:
    """One page of a headless browser, with a profile of its own; a context manager.

    All pages share one process, which the first of them starts and :func:`stop` ends.

    Attributes:
        errors: Console errors, uncaught exceptions and failed requests of the page so far.
        requests: Every address the page asked for, other than itself and ``data:``.
    """

    def __init__(self, *, width: int = 1280, height: int = 800, dark: bool = False):
        """Set the properties of the page.

        Args:
            width: Of the page [px].
            height: Of the page [px].
            dark: Whether the reader prefers dark pages.
        """
        self.errors: list[str] = []
        self.requests: list[str] = []
        self._size, self._dark = (width, height), dark

    def __enter__(self) -> "Browser":
        """Open the page and connect to it."""
        if not _running:
            _running.append(_Chromium())
        ask = _running[-1].session.call
        width, height = self._size
        self._profile = ask("Target.createBrowserContext")["browserContextId"]
        try:
            target = ask(
                "Target.createTarget",
                url="about:blank",
                browserContextId=self._profile,
                newWindow=True,  # a page behind another is not drawn
                width=width,
                height=height,
            )["targetId"]
            self._page = _running[-1].page(target)
            self._page.note = self._note
            for domain in ("Page", "Runtime", "Log", "Network"):
                self.call(f"{domain}.enable")
            self.resize(width, height)
            scheme = "dark" if self._dark else "light"
            self.call(
                "Emulation.setEmulatedMedia",
                features=[{"name": "prefers-color-scheme", "value": scheme}],
            )
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_) -> None:
        """Close the page."""
        if hasattr(self, "_page"):
            self._page.close()
        _running[-1].session.call("Target.disposeBrowserContext", browserContextId=self._profile)

    def resize(self, width: int, height: int) -> None:
        """Give the page another size [px]."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def call(self, method: str, **params):
        """Send one DevTools command to the page and return its result."""
        return self._page.call(method, **params)

    def _note(self, message: dict) -> None:
        method, params = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description") or details["text"])
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "assert"):
            self.errors.append(" ".join(str(a.get("value", a)) for a in params["args"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.errors.append(params["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            url = params["request"]["url"]
            if not url.startswith(("data:", "file:", "blob:", "about:")):
                self.requests.append(url)

    def open(self, path: Path, *, ready: str = "document.readyState === 'complete'") -> None:
        """Open the file ``path`` and wait until the expression ``ready`` is true."""
        self.open_address(Path(path).resolve().as_uri(), ready=ready)

    def open_address(self, url: str, *, ready: str = "document.readyState === 'complete'") -> None:
        """Open ``url`` and wait until the expression ``ready`` is true."""
        self.call("Page.navigate", url=url)
        probe = (
            "(() => { if (location.href === 'about:blank' || !document.body) return false;"
            f"return Boolean({ready}); }})()"
        )
        wait_for(lambda: self.evaluate(probe))

    def evaluate(self, expression: str):
        """Return the value of a JavaScript ``expression`` (a promise is awaited)."""
        answer = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait_for(self, expression: str) -> None:
        """Wait until ``expression`` is true, also of a page that is being loaded.

        Raises:
            RuntimeError: The expression fails on the page that is there in the end.
        """
        problem = None

        def is_true():
            nonlocal problem
            try:
                return self.evaluate(expression)
            except RuntimeError as error:  # its scripts have not run yet
                problem = error

        try:
            wait_for(is_true)
        except TimeoutError as error:
            raise (problem or error) from None

    def processor_time(self) -> float:
        """Return processor time of all processes of the browser so far [s]."""
        processes = _running[-1].session.call("SystemInfo.getProcessInfo")["processInfo"]
        return sum(process["cpuTime"] for process in processes)

    def settle(self) -> None:
        """Wait for two animation frames, so that what was asked for is drawn."""
        self.evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag with the left button from ``start`` to ``end`` [px]."""
        for kind, place in (("mousePressed", start), ("mouseMoved", end), ("mouseReleased", end)):
            self.mouse(kind, *place)

    def mouse(self, kind: str, x: float, y: float) -> None:
        """Send ``"mousePressed"``, ``"mouseMoved"`` or ``"mouseReleased"`` of the left button."""
        self.call(
            "Input.dispatchMouseEvent",
            type=kind,
            x=x,
            y=y,
            button="left",
            buttons=0 if kind == "mouseReleased" else 1,
            clickCount=1,
        )

    def screenshot(self, path: Path | None = None, *, whole: bool = False) -> np.ndarray:
        """Return a screenshot, ``(height, width, 3)`` in 0–255, and write it to ``path`` as PNG.

        Args:
            path: Where to write it, if anywhere.
            whole: The whole page, not only the part in the window.
        """
        from PIL import Image

        self.settle()
        picture = base64.b64decode(
            self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        )
        if path is not None:
            Path(path).write_bytes(picture)
        return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"))


def colours(picture: np.ndarray) -> int:
    """Return how many different colours a picture ``(height, width, 3)`` has: few if blank."""
    red, green, blue = np.moveaxis(picture.astype(np.uint32), -1, 0)
    return int(np.count_nonzero(np.bincount((red << 16 | green << 8 | blue).ravel())))


def moved(before: np.ndarray, after: np.ndarray) -> float:
    """Return the share of pixels that changed visibly from one picture to another."""
    return float((np.abs(before.astype(np.int16) - after).max(axis=2) > 24).mean())


def wait_for(condition):
    """Poll a condition; every poll is work for the browser, so a busy one has more time."""
    for _ in range(2000):
        try:
            if value := condition():
                return value
        except (OSError, ValueError, IndexError):
            pass
        time.sleep(0.05)
    raise TimeoutError("the browser was not ready when it was asked for the 2000th time")
