import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import plantigrade as pg
from plantigrade.threads import on_one_thread
from plantigrade.workflows.fit import run_fit
from plantigrade.workflows.motions import run_synthesis
from plantigrade.workflows.reproduce import run_reproduction
from plantigrade.workflows.settings import FitSettings, ReproduceSettings
from plantigrade.world import World


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info()}


def test_work_runs_on_one_thread_and_the_limits_are_restored():
    np.linalg.inv(np.eye(3))
    with threadpool_limits(2):
        before = threads()
        assert before != {1}
        assert on_one_thread(threads)() == {1}
        assert threads() == before


def test_a_world_moves_a_person_on_one_thread():
    seen = []
    with threadpool_limits(2):
        World(pg.Human.create()).simulate(lambda state: seen.append(threads()), 0.02)
    assert seen and all(each == {1} for each in seen)


@pytest.mark.parametrize("engine", ["fit", "reproduce", "synthesize"])
def test_public_functions_run_on_one_thread(engine):
    seen = []

    def step(_):
        seen.append(threads())
        raise InterruptedError

    calls = {
        "fit": lambda: run_fit("walk.c3d", FitSettings(), step=step),
        "reproduce": lambda: run_reproduction("walk.c3d", ReproduceSettings(), step=step),
        "synthesize": lambda: run_synthesis("track", None, {"recording": "walk.c3d"}, step=step),
    }
    with threadpool_limits(2), pytest.raises(InterruptedError):
        calls[engine]()
    assert seen == [{1}]
