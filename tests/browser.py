"""A real headless Chromium, driven over the DevTools protocol, for looking at the pages we write.

Install it with ``apt-get install chromium`` (Debian); any Chromium or Chrome on the path is found,
or the one that the environment variable ``CHROMIUM`` names. Where there is none,
:func:`find_browser` returns None and a test that needs it skips, saying so.

The flags that make it draw WebGL without a graphics card, as root in a container:

- ``--headless --no-sandbox``: no window; the sandbox needs privileges a container does not give.
- ``--use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader``: WebGL by software.
- ``--disable-background-networking``: no request that the page did not make.
- ``--user-data-dir``: a fresh folder each time, or a second start waits for the first one's lock.
- ``--remote-debugging-port=0``: a free port, written to ``DevToolsActivePort`` in that folder.
- ``--disable-dev-shm-usage``: ``/dev/shm`` is small in containers.
"""

import base64
import io
import json
import os
import shutil
import subprocess
import tempfile
import time
import urllib.request
from pathlib import Path

import numpy as np

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--no-first-run",
    "--hide-scrollbars",
    "--remote-debugging-port=0",
)
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


def find_browser() -> str | None:
    """Return the path of a Chromium, or None."""
    named = os.environ.get("CHROMIUM")
    return named or next((path for name in NAMES if (path := shutil.which(name))), None)


class Browser:
    """One headless browser with one page; a context manager.

    Attributes:
        errors: Console errors, uncaught exceptions and failed requests of the page so far.
        requests: Every address the page asked for, other than itself and ``data:``.
    """

    def __init__(self, *, width: int = 1280, height: int = 800, dark: bool = False):
        """Start the browser.

        Args:
            width: Of the page [px].
            height: Of the page [px].
            dark: Whether the reader prefers dark pages.
        """
        self.errors: list[str] = []
        self.requests: list[str] = []
        self._size, self._dark, self._next = (width, height), dark, 0

    def __enter__(self) -> "Browser":
        """Start the process and connect to its page."""
        from websockets.sync.client import connect

        path = find_browser()
        if path is None:
            raise RuntimeError("no Chromium found: apt-get install chromium")
        self._folder = tempfile.mkdtemp(prefix="chromium-")
        self._process = subprocess.Popen(
            [path, *FLAGS, f"--user-data-dir={self._folder}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            port_file = Path(self._folder) / "DevToolsActivePort"
            _wait(lambda: port_file.exists() and port_file.read_text().count("\n"), 60)
            port = int(port_file.read_text().splitlines()[0])
            opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))

            def page():
                with opener.open(f"http://127.0.0.1:{port}/json") as answer:
                    found = [t for t in json.load(answer) if t["type"] == "page"]
                return found[0] if found else None

            address = _wait(page, 30)["webSocketDebuggerUrl"]
            self._socket = connect(address, max_size=None, proxy=None)
            for domain in ("Page", "Runtime", "Log", "Network"):
                self.call(f"{domain}.enable")
            width, height = self._size
            self.call(
                "Emulation.setDeviceMetricsOverride",
                width=width,
                height=height,
                deviceScaleFactor=1,
                mobile=False,
            )
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
        """Stop the process and remove its folder."""
        if hasattr(self, "_socket"):
            self._socket.close()
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        shutil.rmtree(self._folder, ignore_errors=True)

    def call(self, method: str, **params):
        """Send one DevTools command and return its result."""
        self._next += 1
        self._socket.send(json.dumps({"id": self._next, "method": method, "params": params}))
        while True:
            message = json.loads(self._socket.recv(timeout=60))
            self._note(message)
            if message.get("id") == self._next:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message["result"]

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
        _wait(lambda: self.evaluate(probe), 60)

    def evaluate(self, expression: str):
        """Return the value of a JavaScript ``expression`` (a promise is awaited)."""
        answer = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def settle(self) -> None:
        """Wait for two animation frames, so that what was asked for is drawn."""
        self.evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag with the left button from ``start`` to ``end`` [px]."""
        for kind, (x, y), buttons in (
            ("mousePressed", start, 1),
            ("mouseMoved", end, 1),
            ("mouseReleased", end, 0),
        ):
            self.call(
                "Input.dispatchMouseEvent",
                type=kind,
                x=x,
                y=y,
                button="left",
                buttons=buttons,
                clickCount=1,
            )

    def screenshot(self, path: Path | None = None, *, whole: bool = False) -> np.ndarray:
        """Return what is seen, ``(height, width, 3)`` in 0–255, and write it to ``path`` as PNG.

        Args:
            path: Where to write it, if anywhere.
            whole: The whole page, not only the part in the window.
        """
        import matplotlib.image

        self.settle()
        picture = base64.b64decode(
            self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        )
        if path is not None:
            Path(path).write_bytes(picture)
        pixels = matplotlib.image.imread(io.BytesIO(picture), format="png")
        return np.round(255 * pixels[..., :3]).astype(np.uint8)


def _wait(condition, seconds: float):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        try:
            if value := condition():
                return value
        except (OSError, ValueError, IndexError):
            pass
        time.sleep(0.05)
    raise TimeoutError(f"the browser was not ready within {seconds:.0f} s")
