"""Pages as PDF, printed by a Chromium or Chrome that is installed."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from plantigrade.errors import PlantigradeError

NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge"),
)
"""Commands of browsers that print without a window."""
PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
)
"""Browsers that are not on the path."""
VARIABLE = "CHROMIUM"  # Environment variable that names the browser
FLAGS = (
    *("--headless", "--disable-gpu", "--no-first-run", "--disable-extensions"),
    *("--disable-background-networking", "--disable-dev-shm-usage", "--no-pdf-header-footer"),
)
MAX_SECONDS = 180  # of printing one page on a slow machine


def find_browser() -> str | None:
    """Return the path of a Chromium, Chrome or Edge, or None."""
    named = os.environ.get(VARIABLE)
    on_path = (path for name in NAMES if (path := shutil.which(name)))
    return named or next(on_path, next(filter(os.path.isfile, PLACES), None))


def browser() -> str:
    """Return the path of the browser that prints."""
    found = find_browser()
    if found is None:
        raise PlantigradeError(
            "a PDF is printed by Chromium, Chrome or Edge, and none is installed here: install "
            f"one, name it with the environment variable {VARIABLE}, or open the page in any "
            "browser and print it"
        )
    return found


def pdf_of(page: Path) -> bytes:
    """Return a page, printed."""
    with tempfile.TemporaryDirectory(prefix="plantigrade-pdf-") as folder:
        out = Path(folder) / "page.pdf"
        own = [f"--user-data-dir={folder}/profile", f"--print-to-pdf={out}"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            own.append("--no-sandbox")  # the sandbox refuses to run as root, as in containers
        words = [browser(), *FLAGS, *own, page.resolve().as_uri()]
        try:
            ended = subprocess.run(words, capture_output=True, timeout=MAX_SECONDS, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise PlantigradeError(f"{words[0]} did not print {page}: {error}") from error
        if not out.is_file():
            said = ended.stderr.decode(errors="replace").strip().splitlines()
            why = said[-1] if said else f"exit code {ended.returncode}"
            raise PlantigradeError(f"{words[0]} did not print {page}: {why}")
        return out.read_bytes()
