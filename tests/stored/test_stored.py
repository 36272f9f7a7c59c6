"""The stored motions hold what they held when they were made, and the solver still gives them."""

from dataclasses import replace

import numpy as np
import pytest

import plantigrade as pg
from tests.stored.make import MOTIONS, stored


@pytest.mark.parametrize("name", MOTIONS)
def test_a_stored_motion_passes_the_check(name):
    run = stored(name)
    assert run.ok and run.kind == "synthesize"
    verdict = pg.check(run)
    assert verdict.ok, verdict.sentences()


@pytest.mark.parametrize("name", MOTIONS)
def test_the_check_finds_what_is_wrong_with_it(name):
    """Forces a tenth smaller do not carry the body: the check has something to find."""
    record = stored(name).record
    assert record.contact_force is not None
    light = replace(record, contact_force=0.9 * record.contact_force)
    assert not pg.check(light).ok


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize("name", MOTIONS)
def test_the_solver_still_gives_it(name):
    kept, made = stored(name), MOTIONS[name]()
    assert made.ok
    assert made.figures["objective"] == pytest.approx(kept.figures["objective"], rel=1e-3)
    ours, theirs = made.record.motion.at(kept.record.motion.time), kept.record.motion
    assert ours.joint_names == theirs.joint_names
    assert np.abs(ours.qpos - theirs.qpos).max() < 0.02  # [m, rad]
