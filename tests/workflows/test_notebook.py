"""The viewer and live sessions in a notebook: their HTML, and a real Jupyter kernel."""

import html
import re

import pytest

import plantigrade as pg
from plantigrade.errors import ParameterError
from plantigrade.record import Run
from plantigrade.trajopt.solvers.result import Iterate
from plantigrade.workflows.motions import cell_progress, iteration_text
from tests.browser import colours, wait_for
from tests.conftest import open_browser
from tests.pages.walker import walk, walker

SMALL = {"joints": "42", "feet": "rigid", "rate": 300.0, "control_rate": 50.0}
SOURCE = re.compile(r' srcdoc="(.*?)"', re.DOTALL)
CELLS = (
    "import plantigrade as pg\n"
    "from plantigrade.record import Run\n"
    "from tests.pages.walker import walk, walker\n"
    "run = Run(walk(walker(), duration=0.5), 'other', title='A <walk>')",
    "run.view(height=500)",
    "run.record.motion.plot('knee_angle')",
    f"session = pg.live_session(port=8480, controller='passive', **{SMALL})\nsession",
    "done = session.stop()\nprint(done.kind, done.status)",
    "from plantigrade.trajopt.solvers.result import Iterate\n"
    "from plantigrade.workflows.motions import cell_progress\n"
    "follow = cell_progress()\n"
    "for stage in ('coarse', 'fine'):\n"
    "    for k in range(50): follow(stage, Iterate(k, 1.0, 2e-3))",
)


@pytest.fixture(scope="module")
def run():
    """A run of a walk."""
    return Run(walk(walker(), duration=0.5), "other", title="A <walk>")


@pytest.mark.browser
def test_the_viewer_stands_in_a_cell(run, tmp_path):
    """The frame is a page of its own: what is in it is the viewer of the run."""
    shown = run.view(height=500)._repr_html_()
    assert shown.startswith('<iframe sandbox="allow-scripts" srcdoc="')
    page = html.unescape(SOURCE.findall(shown)[0])
    assert "<title>A &lt;walk&gt;</title>" in page and "height: 500px" in shown
    (tmp_path / "cell.html").write_text(f"<!doctype html><body>{shown}</body>", encoding="utf-8")
    with open_browser(width=500, height=400) as browser:
        still = [
            {"name": "prefers-reduced-motion", "value": "reduce"}
        ]  # by software it plays slowly
        browser.call("Emulation.setEmulatedMedia", features=still)
        browser.open(tmp_path / "cell.html")
        wait_for(lambda: colours(browser.screenshot()) > 500)  # it is drawn
        assert browser.errors == []


def test_a_frame_of_no_height(run):
    with pytest.raises(ParameterError, match="from 200 to 4000 pixels"):
        pg.view(run, height=3)


def test_a_live_session_runs_beside_the_notebook():
    session = pg.live_session(port=8481, controller="passive", frame_height=300, **SMALL)
    try:
        assert f'<iframe src="{session.address}"' in session._repr_html_()
        assert session.address.startswith("http://localhost:84") and session.address in repr(
            session
        )
    finally:
        run = session.stop()
    assert run.kind == "simulate" and run.status == "ok"


def test_a_session_that_cannot_start_says_so_at_once():
    with pytest.raises(ParameterError, match="stable-pd needs a motion"):
        pg.live_session(controller="stable-pd", **SMALL)


def test_outside_of_a_notebook_no_line_follows_a_solver():
    assert cell_progress() is None
    text = iteration_text("fine", Iterate(12, 1.0, 2e-3, seconds=3.4))
    assert text == "fine: iteration 12, largest violation 2.0e-03, 3 s"


@pytest.mark.slow
def test_in_a_real_kernel():
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in CELLS])
    nbclient.NotebookClient(book, kernel_name="python3").execute()
    _, viewer, plot, live, ended, solver = (cell.outputs for cell in book.cells)
    assert "srcdoc" in viewer[0].data["text/html"]
    assert plot[0].data["image/svg+xml"].lstrip().startswith("<svg")
    assert 'src="http://localhost:84' in live[0].data["text/html"]
    assert ended[0].text.strip() == "simulate ok"
    (line,) = solver  # changed in place
    assert line.data["text/plain"].startswith("fine: iteration")
