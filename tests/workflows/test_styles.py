"""Words of other walks and upper bodies; a walk that is carried over to another body."""

from pathlib import Path

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.control.gait.reference import reference_of
from plantigrade.control.pendulum import walk_of
from plantigrade.control.pendulum.transfer import transferred_walk
from plantigrade.errors import ParameterError
from plantigrade.kinematics.stride import stride_of
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record, Run
from plantigrade.workflows.save import save
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.styles import THEN, pose_of, styles_of, timed
from tests.textbook import walk_record


@pytest.fixture(scope="module")
def walk() -> Record:
    """The textbook walk of a person with rigid feet, a stride of it closed."""
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    return walk_of(walk_record(human, speed=1.2, rate=60.0, cycles=2))


def test_words_have_a_time_behind_them():
    assert timed("a@b/stroll.c3d@4.5", "walk", THEN) == ("a@b/stroll.c3d", 4.5)
    assert timed("stroll.c3d", "walk", THEN) == ("stroll.c3d", None)
    for word in ("stroll.c3d@soon", "stroll.c3d@-1", "@3", "stroll@nan"):
        with pytest.raises(ParameterError, match="is no walk: write FILE@S"):
            timed(word, "walk", THEN)
    assert pose_of("stroll.c3d") is None
    assert pose_of("arm_flex_r=90, arm_flex_l=0") == {
        "arm_flex_r": pytest.approx(np.pi / 2),
        "arm_flex_l": 0.0,
    }
    with pytest.raises(ParameterError, match="is no upper body: write FILE, RUN, a pose"):
        pose_of("arm_flex_r=high")


def test_other_walks_are_those_of_a_pendulum_and_need_a_duration_without_a_viewer(walk):
    with pytest.raises(ParameterError, match="then has no effect without"):
        pg.simulate(then=("stroll.c3d@4",))
    with pytest.raises(ParameterError, match="upper_body has no effect without"):
        SimulateSettings.given(
            "simulate", None, {"controller": "balance", "upper_body": ("arm_flex_r=90",)}
        )
    run = Run(walk, "fit")
    with pytest.raises(ParameterError, match="needs a time"):
        pg.simulate(run, controller="pendulum", then=("stroll.c3d",))
    for words, what in (
        ({"speed": "1,0@9"}, "a speed would begin at 9 s, but the simulation lasts 1 s"),
        ({"path": "bearing:0,40@9"}, "a bearing would begin"),
        ({"stoop": "0,10@9"}, "a stoop would begin"),
        ({"upper_body": ("arms-up@9",)}, "another upper body would begin"),
    ):
        with pytest.raises(ParameterError, match=what):
            pg.simulate(run, controller="pendulum", duration=1.0, **words)
    with pytest.raises(ParameterError, match="no coordinate 'knee_angle_r' of the upper body"):
        pg.simulate(run, controller="pendulum", upper_body=("knee_angle_r=9",))


def test_a_run_of_somebody_with_other_joints_is_refused(walk, tmp_path: Path):
    human = Human.create(1.7, 65.0, "female", "42", "two-segment")
    qpos = np.tile(human.standing(), (4, 1))
    time, rest = np.arange(4.0), np.zeros((4, human.model.nv))
    stands = Record(human, Motion(time, qpos, rest, human.joint_names))
    folder = save(Run(stands, "fit", name="stands"), tmp_path / "stands").folder
    given = {"controller": "pendulum", "then": (f"{folder}@1",)}
    how = SimulateSettings.given("simulate", None, given)
    with pytest.raises(ParameterError, match="42 degrees of freedom, the one who walks has 40"):
        styles_of(walk.human, how, lambda word: pytest.fail(word))


@pytest.mark.slow
def test_a_walk_on_another_body_stands_when_and_as_heavily_as_it_did(walk):
    tall = Human.create(1.9, 90.0, "male", "42", "rigid")
    other = transferred_walk(walk, tall)
    assert stride_of(tall, other.motion).cyclic
    shares = []
    for record in (walk, other):
        reference = reference_of(record)
        own = {s: [x for x in reference.schedule.stances if x.side == s] for s in "rl"}
        assert reference.schedule.per_period == 2
        shares.append((own["r"][0].stop - own["r"][0].start) / reference.duration)
    assert shares[1] == pytest.approx(shares[0], abs=0.03)
    load = other.signals["estimated.force"]
    np.testing.assert_allclose(load.sum(axis=1)[:, 2], other.weight, rtol=1e-6)
    part = Record(walk.human, walk.motion.frames(np.arange(30)))
    with pytest.raises(ParameterError, match="the walk cannot be repeated"):
        transferred_walk(part, tall)
