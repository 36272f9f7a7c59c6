"""Fixtures of the report's tests: a person, a walk, and a browser."""

import pytest

from tests.browser import Browser, find_browser
from tests.report.walker import walk, walker


@pytest.fixture(scope="session")
def human():
    """The person."""
    return walker()


@pytest.fixture(scope="session")
def record(human):
    """A walk of four seconds at 100 Hz."""
    return walk(human)


@pytest.fixture
def browser():
    """A fresh headless Chromium; skips where there is none."""
    if find_browser() is None:
        pytest.skip("no Chromium here: apt-get install chromium, or set CHROMIUM to its path")
    with Browser() as opened:
        yield opened
