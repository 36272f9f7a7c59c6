"""Experiments on standing: what they measure is kept, and said beside the paper's numbers."""

import numpy as np
import pytest

from experiments import foot_motions, push_table, sensitivity, standing_grounds
from experiments.cached_results import CachedResults
from experiments.chosen_numbers import chosen_numbers
from experiments.standing import Standing, stand, summary
from plantigrade.control.balance import MOTIONS
from plantigrade.errors import FileError, ParameterError
from plantigrade.models import FEET
from plantigrade.world import Push


def refuse():
    """Fail, as a case may."""
    raise ValueError("no")


def test_what_fails_is_a_result_and_what_is_there_is_not_made_again(tmp_path):
    path = tmp_path / "cached.json"
    found = CachedResults(path).get_all({"a": lambda: {"x": 1.0}, "b": refuse})
    assert found["a"]["x"] == 1.0 and "no" in found["b"]["error"]
    again = CachedResults(path).get_all({"a": refuse, "c": lambda: {"x": 2.0}})
    assert again["a"]["x"] == 1.0 and again["c"]["x"] == 2.0


def test_everybody_stands_alike():
    worlds = [Standing(feet)()[0] for feet in FEET]
    for world in worlds[1:]:
        np.testing.assert_allclose(world.data.qpos[:3], worlds[0].data.qpos[:3], atol=2e-3)
        np.testing.assert_allclose(
            world.data.subtree_com[1], worlds[0].data.subtree_com[1], atol=2e-3
        )


def made_up(standing, towards):
    """A limit that is the same for all but the paper's foot."""
    force = 80.0 if standing.feet == "multi-segment" else 70.0
    if standing.formulation == "stepping":
        force *= 3.5 if towards > 0 else 2.0
    return {"force": force, "sure": 40.0, "gaps": [50.0], "tried": 8, "pendulum": 75.0}


def test_the_table_of_pushes(monkeypatch, tmp_path):
    monkeypatch.setattr(push_table, "measure", made_up)
    table = push_table.EXPERIMENT.run(parts=("paper", "stances", "map"), quick=True, out=tmp_path)
    metrics, text = table.metrics(), table.text()
    assert (metrics["goals"], metrics["goals_met"]) == (8, 7)  # forward, steps only double it
    assert metrics["torque_multi_segment_sum_n"] == 240.0
    assert "paper, two-segment" in text and "Not monotone: paper/torque/two-segment/front" in text
    page = (tmp_path / push_table.EXPERIMENT.page).read_text("utf-8")
    assert "Map of pushes" in page
    monkeypatch.setattr(push_table, "measure", refuse)  # all that is asked for is there
    assert push_table.EXPERIMENT.run(quick=True, out=tmp_path).metrics() == metrics


def stood(standing, disturbances, duration):
    """All feet stand but the rigid one."""
    return {
        "stood": standing.feet != "rigid",
        "time": 1.5,
        "slip": 2.0,
        "points": 20.0,
        "wobble": 3.0,
        "sway": 4.0,
    }


@pytest.mark.parametrize(
    ("experiment", "goals"), [(standing_grounds.UNEVEN, 4), (standing_grounds.MOVING, 1)]
)
def test_the_tables_of_standing(experiment, goals, monkeypatch, tmp_path):
    monkeypatch.setattr(standing_grounds, "stand", stood)
    table = experiment.run(quick=True, out=tmp_path)
    metrics, text = table.metrics(), table.text()
    assert metrics["goals"] == metrics["goals_met"] == goals
    assert "torque rigid" in text and "1.5" in text
    assert (tmp_path / experiment.page).exists()


def test_outcomes_of_standing():
    found = stand(Standing("rigid", "posture"), (), 0.2)
    assert found["stood"] and found["points"] > 8 and found["wobble"] < 1.0
    fell = stand(Standing("rigid", "posture"), (Push(force=2000.0, duration=0.1),), 2.0)
    assert not fell["stood"] and fell["time"] < 2.0 and "fell at" in summary(fell)


def test_the_table_of_foot_motions(monkeypatch, tmp_path):
    def made(name, height, mass):
        found = {"stood": True, "time": 9.0, "on_toes": 11.0, "air": 0.2, "rise": 12.0}
        found |= {"flight": 9.0, "sweeps": 4}
        return found | {"bones": 5, "in_order": 1.0, "most_limited": 2.0, "points": 20.0}

    monkeypatch.setattr(foot_motions, "measure", made)
    metrics = foot_motions.run(out=tmp_path).metrics()
    assert metrics["goals"] == metrics["goals_met"] == len(MOTIONS) + 4
    assert metrics["jump_least_flight_cm"] == 9.0
    assert (tmp_path / foot_motions.EXPERIMENT.page).exists()


def test_cached_results_of_another_form_are_refused_in_one_sentence(monkeypatch, tmp_path):
    monkeypatch.setattr(push_table, "measure", made_up)
    path = tmp_path / "push-table.json"
    before = '{"map/torque/in place/0": {"force": 60, "code": "of before"}}'
    path.write_text(before, "utf-8")
    with pytest.raises(FileError, match="other code.*--overwrite"):
        push_table.EXPERIMENT.run(parts=("sizes",), quick=True, out=tmp_path)
    assert path.read_text("utf-8") == before  # nothing was measured in vain
    assert push_table.EXPERIMENT.run(
        parts=("sizes",), quick=True, out=tmp_path, overwrite=True
    ).rows


@pytest.mark.parametrize(("ordered", "share"), [(True, 1.0), (False, 0.0)])
def test_pressure_that_runs_over_the_toes_is_in_order(ordered, share):
    names = [f"medial_phalanges_toe_{i}_l" for i in (1, 2, 3)]
    names += [f"lateral_phalanges_toe_{i}_l" for i in (4, 5)] + ["heel_heel_back_medial_l"]
    time = np.arange(0.0, 8.0, 1.0 / foot_motions.CONTROL_RATE)
    middle = 3.0 - 2.3 * np.cos(np.pi * time)  # from the first toe to the fifth, and back
    centres = np.array([1, 2, 3, 4, 5] if ordered else [1, 3, 2, 4, 5])
    load = np.zeros((len(time), 6))
    load[:, :5] = 50.0 * np.exp(-2.0 * (middle[:, None] - centres) ** 2)
    bones, sweeps, found = foot_motions.circled(load, names, 8.0)
    assert bones == 5 and found == share and (sweeps == 8 or not ordered)
    back = 50.0 * np.exp(-2.0 * (2.0 - np.cos(time)[:, None] - centres) ** 2)
    half = np.hstack([back, load[:, 5:]])  # from one border to the middle and back
    assert foot_motions.circled(half, names, 8.0)[2] == 0.0
    load[time < 1.5, 5] = 30.0  # the heel stands
    assert foot_motions.circled(load, names, 8.0)[1] < 8
    load[:, 5] = 30.0  # nothing circles
    assert foot_motions.circled(load, names, 8.0) == (0, 0, 0.0)


@pytest.mark.slow
def test_a_limit_is_measured_and_is_near_the_pendulums(monkeypatch):
    monkeypatch.setattr(push_table, "FORCE_STEP", 2.5)
    monkeypatch.setattr(push_table, "WATCH_TIME", 2.0)
    found = push_table.measure(Standing("two-segment"), 0.0)
    assert 0.5 < found["force"] / found["pendulum"] < 1.3


def test_every_setting_of_a_controller_is_changed_by_a_fifth(tmp_path):
    table = sensitivity.run(controllers=("posture",), quick=True, out=tmp_path)
    assert "stiffness" in table.text() and (tmp_path / "sensitivity.html").is_file()
    assert "chosen numbers: settings" in table.text()
    whole = sensitivity.cases(("posture", "replay"), None, quick=False)
    assert "posture/stiffness/+" in whole and "replay/gait.early_rate/-" in whole
    with pytest.raises(ParameterError, match="passive has no settings; name one of posture"):
        sensitivity.run(controllers=("passive",), quick=True)


def test_settings_that_follow_from_others_were_not_chosen(tmp_path):
    (tmp_path / "control").mkdir()
    (tmp_path / "control" / "one.py").write_text(
        "LIMIT = 1e-6\n"
        "class OneSettings:\n"
        "    gain: float = 2.0\n"
        "    scale: tuple[float, float] = (-1.0, 0.5 * 3.0)\n"
        "    same: float = Other.gain\n"
        "    on: bool = True\n"
        "    part: PartSettings = PartSettings(far=1.0, near=Other.near)\n"
    )
    found = chosen_numbers(tmp_path)
    assert found == {"settings": 2, "other values": 1, "constants": 1}
