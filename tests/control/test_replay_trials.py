"""Replays of a motion: outcomes and certificates."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.control.replay import Replay, trials
from plantigrade.control.replay.trials import ReplayOutcome, certified, largest_push, replay_once
from plantigrade.record import Run
from plantigrade.world.model_mismatch import ModelMismatch

STORED = Path(__file__).parents[1] / "stored"


@pytest.fixture(scope="module")
def controller() -> Replay:
    return Replay(Run.load(STORED / "side-step").record)


def test_a_replay_is_the_same_again_and_another_start_another_one(controller):
    one, same, other = (replay_once(controller, 0.02, seed=s) for s in (1, 1, 2))
    assert one == same and one.survived
    assert one.error != other.error


def test_model_mismatch_reaches_the_world(controller):
    plain = replay_once(controller, 0.02)
    cases = (
        ModelMismatch(mass=1.1),
        ModelMismatch(delay=0.01),
        ModelMismatch(sensors=0.01),
    )
    for how in cases:
        assert replay_once(controller, 0.02, mismatch=how).error != plain.error


def test_the_largest_push_is_found_by_bisection_and_legs_stay_solid(controller, monkeypatch):
    tried = []

    def once(controller, duration, *, seed, acting):
        force = float(acting[0].force)
        tried.append(force)
        return ReplayOutcome(force < 330.0, 1.0, 0.0, 0.0, {}, 0.05 if force > 270.0 else 0.015)

    monkeypatch.setattr(trials, "replay_once", once)
    forces = tuple(float(f) for f in range(50, 501, 50))
    assert largest_push(controller, 0.0, 0.0, forces) == 250.0  # deeper legs are no survival
    assert len(tried) <= 4
    assert largest_push(controller, 0.0, 0.0, (400.0, 500.0)) == 0.0


@pytest.mark.slow
def test_a_walk_that_is_repeated_keeps_to_its_path_with_even_steps():
    walk = Replay(pg.synthesize("walk", periodic=True, speed=1.3).record)
    found = replay_once(walk, 10.0, seed=1)
    assert found.survived
    assert found.off_path < 0.03
    assert found.error < np.deg2rad(3.0)
    touchdowns = walk.gait.touchdowns
    longer = {"r": [], "l": []}
    for before, after in pairwise(touchdowns[len(touchdowns) // 2 :]):
        longer[after.side].append((after.offset - before.offset)[:2] @ after.axes[:, 0])
    assert np.abs([np.mean(each) for each in longer.values()]).max() < 0.015


@pytest.mark.slow
def test_a_walk_uphill_keeps_to_its_path():
    uphill = pg.synthesize("walk", periodic=True, slope=np.deg2rad(8.0)).record
    found = replay_once(uphill, 10.0, seed=1)
    assert found.survived
    assert found.off_path < 0.05
    assert found.error < np.deg2rad(4.0)


@pytest.mark.slow
def test_a_push_that_throws_anybody_over_is_not_survived(controller):
    assert largest_push(controller, 0.0, 0.0, (3000.0, 6000.0), after=1.0) == 0.0


def test_a_certificate_is_one_sentence():
    held = {
        "replay_survived": True,
        "replay_seconds": 2.0,
        "replay_error_rms_deg": 1.23,
        "replay_off_path_end_m": 0.04,
        "replay_push_left_n": 50.0,
        "replay_push_back_n": 100.0,
    }
    assert certified(held) == (
        "In simulation the person stays upright, 1.2° off the motion and 4 cm beside its path "
        "at the end; on the way it withstands a push of 50 N for 0.2 s in every direction tried."
    )
    assert "not every push of 50 N (weakest: left)" in certified(held | {"replay_push_left_n": 0.0})
    fell = certified(held | {"replay_survived": False})
    assert fell == "In simulation the person falls after 2.00 s."
