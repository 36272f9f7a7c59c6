"""Fixtures of the report's tests: the capsule human, its walk, and a browser."""

import pytest

from tests.browser import Browser, find_browser
from tests.report.walker import walk, walker


@pytest.fixture(scope="session")
def model():
    """The capsule human."""
    return walker()


@pytest.fixture(scope="session")
def record(model):
    """Its walk: four seconds at 100 Hz."""
    return walk(model)


@pytest.fixture
def browser():
    """A fresh headless Chromium; skips where there is none."""
    if find_browser() is None:
        pytest.skip("no Chromium here: apt-get install chromium, or set CHROMIUM to its path")
    with Browser() as opened:
        yield opened
