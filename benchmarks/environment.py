"""The Gymnasium environment: decisions per second on one core, and where the time goes.

A person of 66 coordinates on multi-segment feet, 30 decisions a second on physics at 150 Hz, once
with the reference itself as the policy, once with a random one; falls and new starts included.
Times are the processor's.
"""

import time
from collections.abc import Callable, Iterator

import mujoco
import numpy as np

from benchmarks.world import part_rows
from plantigrade.experiments.table import Row, at_least

GOAL = 2000.0  # decisions per second
STEPS, REPEATS = 400, 5
NOISE = 0.18  # of a random policy: 0.11 rad, with which walking was learned


def rows() -> Iterator[Row]:
    """Yield decisions per second of two policies, and what share of the time is MuJoCo's."""
    from plantigrade.learn import Walk

    env = Walk()
    rng = np.random.default_rng(0)
    n = len(env.action)
    policies: dict[str, Callable[[], np.ndarray]] = {
        "the reference followed": lambda: np.zeros(n),
        "a random policy": lambda: NOISE * rng.standard_normal(n),
    }
    for name, policy in policies.items():
        whole, physics = (
            min(t) for t in zip(*(timed(env, policy) for _ in range(REPEATS)), strict=True)
        )
        subject = f"66 coordinates, 30 Hz on 150 Hz, {name}"
        yield at_least(subject, "speed", 1.0 / whole, GOAL, "decisions/s")
        yield Row(subject, "one decision", 1e6 * whole, "µs")
        yield Row(subject, "of it: five steps of MuJoCo alone", 1e6 * physics, "µs")
        yield Row(subject, "of it: the same", 100.0 * physics / whole, "%")
    yield from part_rows("66 coordinates, 150 Hz", env.world)


def timed(env, policy: Callable[[], np.ndarray]) -> tuple[float, float]:
    """Return how long a decision takes, and how long its steps of MuJoCo take alone [s]."""
    env.reset(seed=0)
    model, data = env.world.model, env.world.data
    states: list[tuple[np.ndarray, ...]] = []
    spent = 0.0
    for _ in range(STEPS):
        before = data.qpos.copy(), data.qvel.copy(), data.qacc_warmstart.copy()
        began = time.process_time()
        *_, terminated, truncated, _ = env.step(policy())
        over = terminated or truncated
        if over:
            env.reset()
        spent += time.process_time() - began
        if not over:
            states.append((*before, data.ctrl.copy()))
    alone, own = 0.0, mujoco.MjData(model)
    for qpos, qvel, warm, ctrl in states:
        own.qpos[:], own.qvel[:], own.qacc_warmstart[:], own.ctrl[:] = qpos, qvel, warm, ctrl
        began = time.process_time()
        mujoco.mj_step(model, own, 5)
        alone += time.process_time() - began
    return spent / STEPS, alone / len(states)
