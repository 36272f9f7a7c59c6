"""Fixtures shared by all tests."""

import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import hypothesis
import pytest
from threadpoolctl import threadpool_limits

from plantigrade.pages.pdf import find_browser
from tests.browser import Browser, stop

# One thread per solve: idle BLAS threads slow the small matrices of this package down, up to seven
# times. The environment is for what loads later and for other processes; NumPy has been loaded by
# now, by the plugin of jaxtyping.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
threadpool_limits(1)

# The same examples in every run, however slow the machine is; HYPOTHESIS_PROFILE=default looks for
# new ones.
hypothesis.settings.register_profile(
    "same",
    derandomize=True,
    deadline=None,
    suppress_health_check=[hypothesis.HealthCheck.too_slow],
)
if "HYPOTHESIS_PROFILE" not in os.environ:
    hypothesis.settings.load_profile("same")

DATA_VARIABLE = "PLANTIGRADE_DATA"


def find_data() -> Path | None:
    """Return the folder of public recordings, or None where there is none."""
    named = os.environ.get(DATA_VARIABLE)
    if named:
        folder = Path(named).expanduser()
        if not folder.is_dir():
            raise pytest.UsageError(f"{DATA_VARIABLE}={named} is not a folder")
        return folder
    sibling = Path(__file__).resolve().parents[2] / "shared" / "data"
    return sibling if sibling.is_dir() else None


@pytest.fixture(scope="session")
def data() -> Path:
    """Folder of public recordings; the test is skipped, visibly, where it is absent."""
    folder = find_data()
    if folder is None:
        how = f"plantigrade data get --all, then set {DATA_VARIABLE} (see docs/commands/data.md)"
        pytest.skip(f"no folder of recordings: {how}")
    return folder


@pytest.fixture
def browser():
    """A fresh page of a headless Chromium; skips where there is none.

    The process is shared by all pages of a worker, and ``browser.resize`` gives the page another
    size. A page may stay open for several tests: see ``open_browser``.
    """
    with open_browser() as page:
        yield page


def open_browser(**options) -> Browser:
    """Return a page to be entered, for a fixture of wider scope than ``browser``; may skip."""
    if find_browser() is None:
        pytest.skip("no Chromium here: apt-get install chromium, or set CHROMIUM to its path")
    return Browser(**options)


# Fixture → mark of the tests that use it.
MARKS = {"data": "data", "browser": "browser", "viewer_page": "browser", "synthesized": "solver"}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what uses recordings or a browser, also through another fixture; long files first."""
    solving, long = set(), set()
    for item in items:
        for fixture, name in MARKS.items():
            if fixture in getattr(item, "fixturenames", ()):
                item.add_marker(name)
        if item.get_closest_marker("solver"):
            solving.add(item.path)
        if any(item.get_closest_marker(name) for name in ("data", "browser", "slow")):
            long.add(item.path)
    items.sort(key=lambda item: (item.path not in solving, item.path not in long))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log):
    """Run the tests of a file on one worker, since they share fixtures, and the files in order.

    The files that take longest come first, so that no worker is left with one at the end; xdist's
    own ``--dist=loadfile`` puts the files of fewest tests last, which are those of long solves.
    """
    if config.getoption("dist") != "load":  # asked for otherwise
        return None
    from xdist.scheduler import LoadFileScheduling

    config.option.loadscopereorder = False
    return LoadFileScheduling(config, log)


def pytest_sessionfinish() -> None:
    """End the browser that the pages shared."""
    stop()


@dataclass(frozen=True)
class Demo:
    """Folder in which ``plantigrade demo`` ran, and its output."""

    folder: Path  # the runs are in ``runs`` below it
    said: str

    def call(self, *words: str) -> subprocess.CompletedProcess:
        """Call the program in the same place, in a process of its own."""
        done = subprocess.run(
            [sys.executable, "-m", "plantigrade", *words],
            cwd=self.folder, capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done


@pytest.fixture(scope="session")
def demo(tmp_path_factory) -> Demo:
    """The demo, run once: a fitted and a reproduced textbook walk."""
    place = Demo(tmp_path_factory.mktemp("demo"), "")
    return replace(place, said=place.call("demo").stdout)


@dataclass(frozen=True)
class Synthesized:
    """A periodic walk made from the task alone, for many tests."""

    solution: Any
    run: Any  # saved: run.folder
    iterations: list  # stage and iterate of every iteration


@pytest.fixture(scope="session")
def synthesized(tmp_path_factory) -> Synthesized:
    """A periodic walk made from the task alone: the solution, its run, and its iterations."""
    from plantigrade.trajopt import ContactBody, parse_task_file, synthesize
    from plantigrade.trajopt.tasks.gait_settings import WalkSettings
    from plantigrade.workflows.save import save
    from plantigrade.workflows.settings import SolveSettings
    from plantigrade.workflows.synthesize import Origin, run_of
    from plantigrade.workflows.task import person, the_task

    how = SolveSettings(
        height=1.7, mass=65.0, joints="42", basis="polynomial", nodes_per_second=28.0
    )
    human, iterations = person(how), []
    task = the_task(human, WalkSettings(speed=1.0, periodic=True), how, parse_task_file(QUICK_WALK))
    body = ContactBody.for_plan(human, task.plan)
    solution = synthesize(body, task, progress=lambda stage, it: iterations.append((stage, it)))
    origin = Origin("A walk", "plantigrade synthesize walk")
    run = run_of(solution, {"task": "walk"}, origin)
    folder = tmp_path_factory.mktemp("synthesized") / "walk"
    return Synthesized(solution, save(run, folder), iterations)


QUICK_WALK = '[task]\nname = "walk"\nbase = "walk"\nwithout = ["work"]\n'
"""A walk without cost of work, which takes half the iterations."""


def pytest_report_header(config: pytest.Config) -> str:
    """Name the folder of recordings at the top of the run."""
    return f"recordings: {find_data() or f'none ({DATA_VARIABLE} is not set)'}"
