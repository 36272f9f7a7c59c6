"""The short form of every experiment: what it runs is there, and is a part of the whole."""

import pytest

from experiments import (
    fit_accuracy,
    foot_pose,
    foot_segments,
    gait_ablations,
    gait_forces,
    gait_table,
    gait_walks,
    ground_forces,
    running_table,
    spline_table,
    synthesis_tracking,
    video,
)
from experiments.gait_walks import PEOPLE, Walks, reproduce_walks
from experiments.table import Row
from plantigrade.trajopt.zhakatayev2023 import MOTIONS

OVER_TRIALS = (
    fit_accuracy,
    foot_pose,
    foot_segments,
    gait_forces,
    ground_forces,
    running_table,
    synthesis_tracking,
    video,
)


@pytest.mark.parametrize("module", OVER_TRIALS)
def test_trials_of_the_short_form_are_there(module, data):
    assert all((data / name).exists() for name in module.QUICK_TRIALS)


@pytest.mark.parametrize("module", OVER_TRIALS)
def test_the_short_form_has_its_trials_and_no_others(module, monkeypatch, tmp_path):
    for name in {*module.WALKS, *module.QUICK_TRIALS}:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for what in ("trial_rows", "skeleton_rows"):
        if hasattr(module, what):
            monkeypatch.setattr(module, what, lambda path, name, *_: [Row(name, "error", 1.0)])
    if hasattr(module, "given_rows"):  # of walks that are generated, not of trials
        monkeypatch.setattr(module, "given_rows", lambda say: [])
    if hasattr(module, "left_out_rows"):  # of all trials together
        monkeypatch.setattr(module, "walks", lambda data: {})
    whole, short = (
        [
            r.subject
            for r in module.run(tmp_path, quick=quick).rows
            if not r.subject.startswith("mean")
        ]
        for quick in (False, True)
    )
    assert short == list(module.QUICK_TRIALS) and set(short) < set(whole)


def test_people_of_the_short_form(monkeypatch, tmp_path):
    asked = []

    def walks(data, tasks, *, people=None, **_):
        asked.append(people)
        return {name: Walks([], {}, ()) for name in tasks}

    for module in (gait_table, gait_ablations):
        monkeypatch.setattr(module, "reproduce_walks", walks)
        module.run(tmp_path)
        module.run(tmp_path, quick=True)
    assert asked == [None, gait_walks.QUICK_PEOPLE] * 2
    assert set(gait_walks.QUICK_PEOPLE) < set(PEOPLE) and len(gait_walks.QUICK_PEOPLE) > 2, (
        "enough for a test"
    )


def test_walks_of_some_people_only(monkeypatch, tmp_path):
    from plantigrade.errors import FitError

    read = []

    def fit_trial(path):
        read.append(path.relative_to(tmp_path).as_posix())
        raise FitError("no person")

    monkeypatch.setattr(gait_walks, "fit_trial", fit_trial)
    for name in PEOPLE["HC038A"] + PEOPLE["CMU 49"]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    found = reproduce_walks(tmp_path, ["paper"], people=("HC038A", "walking2"))
    assert read == sorted(PEOPLE["HC038A"]) == list(found["paper"].failed)
    assert found["paper"].absent == PEOPLE["walking2"]


def test_motions_of_the_short_form_are_drawn(monkeypatch):
    assert set(spline_table.QUICK_TASKS) < set(MOTIONS)
    assert spline_table.figures({}, {}) == {}, "what was not solved is not drawn"
