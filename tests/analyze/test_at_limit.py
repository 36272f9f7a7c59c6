"""Joints that lie at a limit are named with their share of the frames, and hatched."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze.at_limit import at_limit, cycles_at_limit, limit_figures, limit_notes
from plantigrade.motion.cycles import cut_cycles
from plantigrade.record import Limits
from tests.pages.walker import walk, walker


def pinned(**shares):
    """Return a walk whose joints lie at their lower limit in a share of the frames."""
    human = walker()
    record = walk(human)
    qpos = record.motion.qpos.copy()
    for name, share in shares.items():
        k = human.hinge(name)
        frames = np.arange(round(share * len(qpos)))
        qpos[frames, 7 + k] = human.limits[0, k] + np.deg2rad(0.1)
    return replace(record, motion=replace(record.motion, qpos=qpos))


def test_a_walk_within_its_limits_has_none():
    record = pinned()
    assert at_limit(record) == {} and limit_notes(record) == []
    assert limit_figures(record) == {"joints_at_limit_pct": {}}


def test_joints_at_a_limit_are_named_with_their_share_the_longest_first():
    record = pinned(elbow_flex_l=0.2, pro_sup_r=0.5, knee_angle_r=0.03)
    shares = limit_figures(record)["joints_at_limit_pct"]
    assert list(shares) == ["pro_sup_r", "elbow_flex_l"]
    assert shares["pro_sup_r"] == pytest.approx(50, abs=0.5)
    assert shares["elbow_flex_l"] == pytest.approx(20, abs=0.5)
    (note,) = limit_notes(record)
    assert "pro_sup_r (50 %), elbow_flex_l (20 %)" in note and "knee" not in note


def test_limits_that_the_motion_had_to_keep_to_come_first():
    record = pinned(elbow_flex_l=0.2)
    wide = record.human.limits + np.array([[-1.0], [1.0]])
    assert at_limit(replace(record, limits=Limits(coordinate=wide))) == {}


def test_over_the_cycle_it_is_where_most_cycles_have_it():
    record = pinned(elbow_flex_l=1.0, pro_sup_r=0.1)
    found = cycles_at_limit(record, cut_cycles(record.motion.events))
    assert found["elbow_flex_l"].all()
    assert not found["pro_sup_r"].all()
