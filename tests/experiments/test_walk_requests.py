"""Random requests of walks."""

import pytest

from experiments.walk_requests import falls, random_walk
from plantigrade.workflows.simulate_settings import SimulateSettings

RECORDINGS = ("walk.amc", "walk.c3d")


@pytest.mark.parametrize("seed", range(30))
def test_requests_are_what_simulate_takes(seed):
    request = random_walk(seed, RECORDINGS)

    assert request == random_walk(seed, RECORDINGS)
    assert request.recording in request.title
    options = {k: v for k, v in request.options.items() if k not in ("height", "mass")}
    SimulateSettings(**options)
    if request.recording.endswith(".c3d"):
        assert "height" not in request.options


def test_falls_are_listed_with_what_was_asked():
    results = {
        "pendulum/requests/1": {"request": "walk.amc, load 5", "survived": False, "end": "fell"},
        "pendulum/requests/2": {"request": "walk.amc", "survived": True, "end": "ok"},
        "pendulum/requests/3": {"error": "no walk"},
        "pendulum/tiles 2 cm/1": {"survived": False, "end": "fell"},
    }

    assert list(falls(results).lines) == [
        ["walk.amc, load 5", "fell"],
        ["pendulum/requests/3", "no walk"],
    ]
