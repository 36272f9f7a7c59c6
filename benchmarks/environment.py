"""The Gymnasium environment: decisions per second on one core, and where the time goes.

A person of 66 coordinates on multi-segment feet, 30 decisions a second on physics at 150 Hz, once
with the reference itself as the policy, once with a random one; falls and new starts included.
First many persons in one process, as a learner has them, then one alone. Times are the processor's.
"""

import time
from collections.abc import Iterator

import mujoco
import numpy as np

from benchmarks.world import part_rows
from experiments.table import Row, at_least

MIN_DECISION_RATE = 2000.0  # decisions per second
N_ENVIRONMENTS = 32
N_STEPS = 640
N_REPEATS = 5
NOISE = 0.18  # of a random policy: 0.11 rad, with which walking was learned


def rows() -> Iterator[Row]:
    """Yield decisions per second of two policies, and what share of the time is MuJoCo's."""
    from plantigrade.learn import ReferenceMotion, Walks

    reference = ReferenceMotion.of(None)
    for many in (N_ENVIRONMENTS, 1):
        envs = Walks(many, reference)
        for name, noise in (("the reference followed", 0.0), ("a random policy", NOISE)):
            found = [timed(envs, noise) for _ in range(N_REPEATS)]
            whole, physics = (min(each) for each in zip(*found, strict=True))
            subject = f"66 coordinates, 30 Hz on 150 Hz, {name}, {many} in a process"
            speed = 1.0 / whole
            if many == N_ENVIRONMENTS:
                yield at_least(subject, "speed", speed, MIN_DECISION_RATE, "decisions/s")
            else:
                yield Row(subject, "speed", speed, "decisions/s")
            yield Row(subject, "one decision", 1e6 * whole, "µs")
            yield Row(subject, "of it: five steps of MuJoCo alone", 1e6 * physics, "µs")
            yield Row(subject, "of it: the same", 100.0 * physics / whole, "%")
    yield from part_rows("66 coordinates, 150 Hz", envs.tracking.worlds[0])


def timed(envs, noise: float) -> tuple[float, float]:
    """Return how long a decision takes, and how long its steps of MuJoCo take alone [s]."""
    envs.reset(seed=0)
    rng, shape = np.random.default_rng(0), envs.action_space.shape
    worlds, n = envs.tracking.worlds, envs.num_envs
    states: list[tuple[np.ndarray, ...]] = []
    spent = 0.0
    for _ in range(N_STEPS // n):
        action = noise * rng.standard_normal(shape)
        before = [(d.qpos.copy(), d.qvel.copy(), d.qacc_warmstart.copy())
                  for d in (world.data for world in worlds)]  # fmt: skip
        began = time.process_time()
        _, _, terminated, truncated, _ = envs.step(action)
        spent += time.process_time() - began
        for world, state, over in zip(worlds, before, terminated | truncated, strict=True):
            if not over:
                states.append((*state, world.data.ctrl.copy()))
    alone, model, own = 0.0, worlds[0].model, mujoco.MjData(worlds[0].model)
    for qpos, qvel, warm, ctrl in states:
        own.qpos[:], own.qvel[:], own.qacc_warmstart[:], own.ctrl[:] = qpos, qvel, warm, ctrl
        began = time.process_time()
        mujoco.mj_step(model, own, 5)
        alone += time.process_time() - began
    return spent / (N_STEPS // n * n), alone / len(states)
