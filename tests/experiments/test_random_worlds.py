"""Random worlds hold: every number of them is one."""

import numpy as np
import pytest

from experiments import cached_results, random_worlds
from experiments.random_worlds import Outcome, outcome, random_world, run
from plantigrade.record.jobs import Done


def test_a_handful_of_random_worlds_hold():
    found = [outcome(seed, 0.2) for seed in range(4)]
    assert not any(o.broken for o in found)
    assert len({o.speed for o in found}) == 4  # they are not all one


def test_a_seed_makes_the_same_world_again():
    first, second = (random_world(3) for _ in range(2))
    assert first[0].human.to_dict() == second[0].human.to_dict()
    assert first[0].ground == second[0].ground and first[0].disturbances == second[0].disturbances
    one, other = (world.simulate(controller, 0.1) for world, controller in (first, second))
    assert np.array_equal(one.motion.qpos, other.motion.qpos)


def test_the_experiment_goes_on_where_it_was_stopped(tmp_path, monkeypatch):
    done, stops = [], ["here"]

    def jobs(work, items, **_):
        for seed in items:
            done.append(seed)
            if stops and seed == 2:
                stops.clear()
                raise KeyboardInterrupt
            yield Done(seed, Outcome(seed, seed == 3, True, 10.0 + seed))

    monkeypatch.setattr(random_worlds, "run_jobs", jobs)
    monkeypatch.setattr(random_worlds, "N_WORLDS", 5)
    monkeypatch.setattr(random_worlds, "WORLDS_PER_RESULT", 2)
    with pytest.raises(KeyboardInterrupt):
        run(out=tmp_path)
    table = run(out=tmp_path)
    assert done == [0, 1, 2, 2, 3, 4]
    assert "5 of 5 ran; seeds 3 broke" in table.text()
    done.clear()
    monkeypatch.setattr(cached_results, "code_version", lambda: "of other code")
    run(out=tmp_path)
    assert done == [0, 1, 2, 3, 4]


@pytest.mark.slow
def test_the_experiment_in_its_short_form():
    table = run(quick=True)
    assert table.metrics()["goals_met"] == 2, table.text()
