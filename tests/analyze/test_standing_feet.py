"""Feet that stand rest: a laboratory that sways moves them."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze.standing_feet import (
    PARTS_OF_STANCE,
    standing_velocities,
    sway_doubt,
)
from plantigrade.kinematics.state import PointSet
from plantigrade.models.markers import place_markers
from plantigrade.motion import Markers
from tests.analyze.plated_walk import analyse, plated_walk

BALLS = ("RTOE", "LTOE")


@pytest.fixture(scope="module")
def trial():
    """A walk with markers at the balls of its feet."""
    found = analyse(plated_walk().fit())
    human, qpos = found.fit.human, found.motion.qpos
    placed = place_markers(BALLS, human)
    path = PointSet.of(human, [placed[name] for name in BALLS]).path(qpos)
    return replace(found, fit=replace(found.fit, markers=Markers(BALLS, found.motion.time, path)))


def moved(trial, path):
    """Return the trial with markers that all follow a path besides."""
    markers = trial.fit.markers
    positions = markers.positions + path[:, None]
    return replace(trial, fit=replace(trial.fit, markers=replace(markers, positions=positions)))


def swaying(trial, axis, frequency=0.6):
    time = trial.motion.time
    path = np.zeros((len(time), 3))
    path[:, axis] = 0.03 * np.sin(2 * np.pi * frequency * (time - time[0]))
    return moved(trial, path)


def test_standing_feet_rest(trial):
    assert len(standing_velocities(trial, PARTS_OF_STANCE[0])) >= 2
    assert not sway_doubt(trial)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_laboratory_that_sways_is_named(trial, axis):
    assert "sway" in sway_doubt(swaying(trial, axis))


def test_a_belt_that_moves_at_one_speed_does_not_sway(trial):
    time = trial.motion.time
    belt = np.outer(time, [-1.2, 0.0, 0.0])
    assert not sway_doubt(moved(trial, belt))
    assert "sway" in sway_doubt(swaying(moved(trial, belt), 0))


def test_people_who_stand_show_it_too(trial):
    markers = trial.fit.markers
    rest = replace(markers, positions=np.repeat(markers.positions[:1], len(markers.time), axis=0))
    motion = replace(trial.motion, events=())
    still = replace(trial, motion=motion, fit=replace(trial.fit, markers=rest))
    assert not sway_doubt(still)
    assert "sway" in sway_doubt(swaying(still, 0))
    unseen = replace(trial.fit, markers=None)
    assert not sway_doubt(replace(trial, fit=unseen))
