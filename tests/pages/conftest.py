"""Fixtures of the report's tests: a person and a walk."""

import pytest

from tests.pages.walker import walk, walker


@pytest.fixture(scope="session")
def human():
    """The person."""
    return walker()


@pytest.fixture(scope="session")
def record(human):
    """A walk of four seconds at 100 Hz."""
    return walk(human)
