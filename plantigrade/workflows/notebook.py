"""The viewer of a run and live sessions in the cells of a notebook."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from threading import Event, Thread
from typing import Any

from plantigrade.errors import ParameterError
from plantigrade.pages.run_pages import run_viewer
from plantigrade.record import Run
from plantigrade.signatures import takes
from plantigrade.workflows.live import live
from plantigrade.workflows.simulate import SIMULATION_OPTIONS
from plantigrade.world import AnyController, Disturbance

HEIGHT = 640  # [px] of a frame in a cell; chosen
MIN_HEIGHT, MAX_HEIGHT = 200, 4000  # [px] allowed heights; chosen


@dataclass(frozen=True)
class PageFrame:
    """A page in a cell: what a notebook shows of it."""

    source: str  #: Attribute of the frame that holds the page or names its address, as HTML
    height: int  #: Height of the frame [px]

    def __post_init__(self):
        if not MIN_HEIGHT <= self.height <= MAX_HEIGHT:
            limits = f"from {MIN_HEIGHT} to {MAX_HEIGHT} pixels"
            raise ParameterError(f"height={self.height} must be {limits}")

    def _repr_html_(self) -> str:
        style = (
            f"width: 100%; height: {self.height}px; border: 1px solid #dde2e9; border-radius: 6px"
        )
        return f'<iframe {self.source} style="{style}"></iframe>'

    def __repr__(self) -> str:
        return f"<a page of {self.height} pixels; the last line of a notebook's cell shows it>"


def view(run: Run, *, height: int = HEIGHT) -> PageFrame:
    """Return the viewer of a run for a cell of a notebook: the moving person, forces and curves.

    The page is in the notebook itself, needs no server, and stays when the notebook is saved.

    Args:
        run: The run.
        height: Height of the frame [px].

    Raises:
        ParameterError: If the record cannot be drawn, or the height is out of range.
    """
    page = escape(run_viewer(run), quote=True)
    return PageFrame(f'sandbox="allow-scripts" srcdoc="{page}"', height)


class LiveSession:
    """A live simulation that runs beside a notebook until :meth:`stop`.

    Attributes:
        address: URL of its page.
    """

    def __init__(self, source: str | Path | Run | None, height: int, options: dict[str, Any]):
        self._height, self._stop, self._opened = height, Event(), Event()
        self._run: Run | None = None
        self._error: BaseException | None = None
        self.address = ""

        def opened(address: str) -> None:
            self.address = address
            self._opened.set()

        def work() -> None:
            try:
                self._run = live(source, show=opened, tell=_quiet, stop=self._stop, **options)
            except BaseException as error:
                self._error = error
            finally:
                self._opened.set()

        self._thread = Thread(target=work, name="live session", daemon=True)
        self._thread.start()
        self._opened.wait()
        if self._error is not None:
            raise self._error

    def stop(self) -> Run:
        """End the session, and return it as a run.

        Raises:
            Exception: What ended it before.
        """
        self._stop.set()
        self._thread.join()
        if self._run is None:
            raise self._error or RuntimeError("the session has not started")
        return self._run

    def _repr_html_(self) -> str:
        return PageFrame(f'src="{self.address}"', self._height)._repr_html_()

    def __repr__(self) -> str:
        return f"<live session at {self.address}; stop() ends it and returns the run>"


@takes(more=SIMULATION_OPTIONS)
def live_session(
    source: str | Path | Run | None = None,
    *,
    frame_height: int = HEIGHT,
    port: int = 8080,
    controller: str | AnyController | None = None,
    disturbances: Sequence[Disturbance] = (),
    **options: Any,
) -> LiveSession:
    """Start a live simulation whose page is shown in a cell of a notebook.

    It runs in threads of its own; further cells can be used meanwhile. The browser must run on the
    machine of the kernel, or the port of the page must be forwarded.

    Args:
        source: As of :func:`plantigrade.simulate`.
        frame_height: Height of the frame [px].
        port: Port to listen on; the next free one is taken where it is in use.
        controller: As of :func:`plantigrade.simulate`.
        disturbances: As of :func:`plantigrade.simulate`.
        options: As of :func:`plantigrade.simulate`.

    Raises:
        PlantigradeError: As :func:`plantigrade.simulate` does.

    Example:
        >>> session = pg.live_session(controller="balance")  # doctest: +SKIP
        >>> run = session.stop()  # doctest: +SKIP
    """
    own = {"port": port, "controller": controller, "disturbances": disturbances}
    return LiveSession(source, frame_height, {**own, **options})


def _quiet(_: str) -> None:
    """Say nothing: the page does."""
