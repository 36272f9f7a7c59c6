"""The experiments replay and robustness: what they run, keep and print."""

import pytest

from experiments import replay, robustness
from experiments.replay import MOTIONS, QUICK_MOTIONS, WALK
from plantigrade.errors import ParameterError


@pytest.fixture
def made(monkeypatch):
    """Items that were carried out; every third falls."""
    done = []

    def carried(*item):
        done.append(item)
        fine = len(done) % 3 > 0
        return {"survived": fine, "seconds": 2.0, "error_deg": 1.5, "off_path_m": 0.04}

    def pushed(*item):
        done.append(item)
        return {"force": 100.0 + len(done)}

    monkeypatch.setattr(replay, "motion_outcome", carried)
    monkeypatch.setattr(robustness, "replayed", carried)
    for name in ("push_outcome", "phase_outcome", "middle_outcome"):
        monkeypatch.setattr(replay, name, pushed)
    return done


def test_the_short_form_is_a_part_of_the_whole():
    assert set(QUICK_MOTIONS) < set(MOTIONS)
    assert set(robustness.NAMES) < set(MOTIONS)


def test_motions_and_pushes_are_done_once_and_kept(made, tmp_path):
    table = replay.run(out=tmp_path, quick=True)
    assert len(made) == 2 * len(QUICK_MOTIONS) + 2
    figures = table.metrics()
    assert figures["all_motions_survived_pct"] == pytest.approx(100.0 * 4 / 6)
    made.clear()
    again = replay.run(out=tmp_path, quick=True)
    assert made == [] and again.metrics() == figures


def test_a_part_alone(made):
    replay.run(quick=True, parts=("pushes",))
    assert len(made) == 2


def test_who_stands_is_pushed_from_everywhere_and_motions_on_their_way(made):
    table = replay.run(parts=("standing",))
    assert len(made) == 16 and {item[2] for item in made} == set(replay.DIRECTIONS)
    worst = table.rows[-1]
    assert worst.value == 101.0 and not worst.met  # the first that was made: 200 N are asked
    made.clear()
    table = replay.run(parts=("on the way",))
    assert len(made) == 4 * len(MOTIONS) == 4 * len(table.rows)


def test_pushes_that_end_in_an_error_count_as_not_survived(made, monkeypatch):
    def broken(name, *item):
        if name in ("reach", WALK):
            raise ParameterError("no such motion")
        return {"force": 100.0}

    monkeypatch.setattr(replay, "push_outcome", broken)
    rows = replay.run(parts=("standing",)).rows
    assert rows[-1].value == 0.0 and not rows[-1].met
    assert any("no such motion" in row.note for row in rows)
    monkeypatch.setattr(replay, "middle_outcome", broken)
    (row, *_) = replay.run(quick=True, parts=("on the way",)).rows
    assert row.value == 0.0 and "no such motion" in row.note


def test_robustness_tells_survival_by_disturbance(made, tmp_path):
    table = robustness.EXPERIMENT.run(quick=True, out=tmp_path)
    assert [what for _, what, *_ in made] == list(robustness.MISMATCHES)
    falls = [row for row in table.rows if row.value == 0.0]
    assert len(falls) == len(robustness.MISMATCHES) // 3
    assert not any(row.met for row in falls)
    assert "survived, 10 % heavier" in (tmp_path / robustness.EXPERIMENT.page).read_text("utf-8")
    made.clear()
    table = robustness.EXPERIMENT.run(parts=("ground",), out=tmp_path)
    assert {what for _, what, *_ in made} == set(robustness.MISMATCHES_BY_PART["ground"])
    assert not any("ahead" in what and name == "squat" for name, what, *_ in made)
