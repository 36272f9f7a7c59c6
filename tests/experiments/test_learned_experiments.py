"""What is measured of learned walks: strikes, cycles, pushes; and the tables of it."""

import numpy as np
import pytest

from experiments import learned, learned_disturbed, learned_feet
from experiments.cached_results import CachedResults
from experiments.learned import Walk
from experiments.learned_disturbed import PUSHED, ROUGH
from experiments.learned_level import ANKLE, GAINS, WALK
from plantigrade.errors import FileError
from plantigrade.learn.policy import shipped

FOOT = "multi-segment"
SPECIFICATIONS = (WALK, GAINS, ANKLE, ROUGH, PUSHED)


@pytest.fixture(scope="module")
def measured():
    return learned.measure(Walk(foot=FOOT), 4.5)


def cached(results: dict) -> CachedResults:
    found = CachedResults()
    found.results = results
    return found


def test_a_walk_is_measured(measured):
    """Bounds wide enough for another policy, and for another machine."""
    assert measured["stood"] and measured["body_rms"] < 5.0 and measured["heel_first"] > 0.3
    assert measured["speed"] == pytest.approx(measured["speed_wanted"], rel=0.1)
    assert 0.85 < measured["weight"] < 1.15 < measured["peak_force"]
    assert 0.9 < measured["foot_peak"] < measured["peak_force"]
    # Both feet are down where their stances overlap.
    overlap = 2.0 * measured["stance"] / np.diff(measured["strikes"]["r"]).mean() - 1.0
    assert measured["double"] == pytest.approx(overlap, abs=0.05) and overlap > 0.05
    assert measured["begins"]["heel"] <= measured["begins"]["toes"] < 0.3
    assert 0.35 < measured["stance"] < 0.75
    strikes = measured["strikes"]
    assert all(0.8 < d < 1.2 for side in "rl" for d in np.diff(strikes[side]))
    moment, stiffness = np.array(measured["moment"]), measured["stiffness"]
    assert moment.shape[1] == learned.POINTS and -2.5 < moment.mean(axis=0).min() < -0.8
    assert set(stiffness) == {
        "foot", "medial_phalanges", "lateral_metatarsal", "lateral_phalanges", "heel"
    }  # fmt: skip
    assert 100.0 < np.mean(stiffness["foot"]) < 1000.0 and 10.0 < np.mean(stiffness["heel"]) < 300.0
    mean, sd = learned.ankle_norm(FOOT, measured["speed"])
    assert np.corrcoef(moment.mean(axis=0), mean)[0, 1] > 0.7 and (sd >= 0.0).all()


def test_tables_show_what_was_measured(measured):
    found = cached({f"strides/{FOOT}": measured, f"curves/{FOOT}": measured,
                  f"ankle/{FOOT}": measured, f"starts/{FOOT}/0": {"stood": True, "time": 20.0},
                  f"long/{FOOT}": {"stood": False, "time": 31.0},
                  f"push/{FOOT}/left/0.0": {"force": 60.0},
                  f"push/{FOOT}/front/0.0": {"force": 20.0},
                  f"held/{FOOT}/level/learned/0": {"stood": True, "time": 10.0},
                  f"held/{FOOT}/level/held/0": {"stood": False, "time": 3.0},
                  **{f"rough/{FOOT}/3/{i}": {"stood": i > 0, "time": 2.0} for i in range(10)},
                  "rough/rigid/3/0": {"error": "no"}})  # fmt: skip
    figures = {}
    for specification in SPECIFICATIONS:
        assert all(grid.lines for grid in specification.grids(found))
        figures |= {f"{row.subject} {row.quantity}": row for row in specification.rows(found)}
        assert FOOT in specification.tables(found)[0].text()
    assert figures[f"{FOOT} 3 cm walked of 10"].met and not figures[f"{FOOT} walks on"].met
    assert figures[f"{FOOT} side push, least"].value == 60.0
    assert figures[f"{FOOT} all around, mean"].value == 40.0
    assert figures[f"{FOOT} level held walked"].value == 0.0
    assert figures[f"{FOOT} joints off the reference"].met
    assert WALK.summary({"stood": False, "time": 2.0}) == "fell after 2.0 s"


def test_trainings_of_a_foot_are_held_against_those_of_another(measured):
    mean, _ = learned.ankle_norm(FOOT, measured["speed"])
    own = {
        "stood": True,
        "off": 1.5,
        "peak": 2.0,
        "heel": None,
        **learned.moment_agreement(mean, mean),
    }
    assert own["r"] == pytest.approx(1.0) and own["ratio"] == 1.0 and own["apart"] == 0.0
    found = cached({f"level/{FOOT}/a/": own, f"level/{FOOT}/b/": {**own, "off": 2.5},
                  f"level/{FOOT}/c/": {"error": "no"},
                  f"rough/{FOOT}/a/0": {"stood": True, "time": 20.0},
                  f"rough/{FOOT}/a/1": {"stood": False, "time": 2.0},
                  f"rougher/{FOOT}/a/0": {"stood": False, "time": 2.0},
                  "pushed/rigid/d/left/0.0": {"force": 40.0},
                  "pushed/rigid/d/left/0.5": {"force": 80.0}})  # fmt: skip
    figures = learned_feet.figures(found)
    assert figures[FOOT]["off"] == [1.5, 2.5] and figures[FOOT]["rough"] == [50.0]
    assert figures[FOOT]["rougher"] == [0.0]
    assert figures["rigid"]["least"] == [40.0] and figures["rigid"]["push"] == [60.0]
    (grid,) = learned_feet.EXPERIMENT.grids(found)
    off = next(line for line in grid.lines if line[0].startswith("joints"))
    assert off[1:] == ["2 ± 6.4", "-"]  # Student's t of one degree of freedom is 12.7
    assert grid.header == ("", f"{FOOT}, 2", "rigid, 1")
    by_name = {f"{row.subject} {row.quantity}": row for row in learned_feet.EXPERIMENT.rows(found)}
    assert by_name[f"{FOOT} joints off the reference"].value == 2.0


def test_a_policy_of_your_own_is_named_by_its_file(tmp_path):
    mine = tmp_path / "mine.npz"
    mine.write_bytes(shipped(FOOT).read_bytes())
    cases = learned_feet.experiment([str(mine)]).parts["pushed"](True)
    assert [key.split("/")[1] for key in cases] == [FOOT, FOOT]
    own, shown = (Walk(foot=foot).controller().record for foot in (str(mine), FOOT))
    np.testing.assert_array_equal(own.motion.qpos, shown.motion.qpos)
    with pytest.raises(FileError, match="nothing"):
        learned_feet.run(controllers=[str(tmp_path / "nothing.npz")])


def test_pushes_grow_until_a_fall(monkeypatch):
    forces = []

    def endure(walk, duration, disturbances):
        forces.append(disturbances[0].force)
        return {"stood": disturbances[0].force < 50.0}

    monkeypatch.setattr(learned_disturbed, "endure", endure)
    assert learned_disturbed.limit(Walk(foot=FOOT), 90) == {"force": 40.0}
    assert forces == [20.0, 40.0, 60.0]


def test_held_stiffness_is_held_and_ground_is_walked_on():
    walk = Walk(foot=FOOT, ground="bumps:2", seed=1, held=True)
    controller = walk.controller()
    world = walk.world(controller)
    command = controller(world.reset())
    np.testing.assert_allclose(command.signals["foot_stiffness"][[0, 1]], [400.0, 60.0])
    assert world.ground.uneven and learned.endure(walk, 0.5)["stood"]


def test_every_policy_of_the_package_is_measured():
    feet = list(learned.available_feet())
    assert FOOT in feet
    for specification in SPECIFICATIONS:
        keys = [k for part in specification.parts.values() for k in part(True)]
        assert {key.split("/")[1] for key in keys} == set(feet)
