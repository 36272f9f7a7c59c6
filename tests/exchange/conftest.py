"""Runs to export."""

import pytest

from plantigrade.record import Run
from tests.analyze.plated_walk import analyse, plated_walk


@pytest.fixture(scope="session")
def walk() -> Run:
    """The textbook walk on plates, analysed."""
    return Run(analyse(plated_walk().fit(), cutoff=None).record(), "fit", name="walk")


@pytest.fixture(scope="session")
def folder(walk, tmp_path_factory):
    """The folder of that run."""
    return walk.save(tmp_path_factory.mktemp("exchange") / "walk").folder
