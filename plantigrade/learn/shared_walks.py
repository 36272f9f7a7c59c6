"""Parallel environments of which several processes simulate a share each."""

import signal
from typing import Any

import numpy as np
from loky.backend import get_context

from plantigrade.errors import PlantigradeError
from plantigrade.learn.environment import Walks
from plantigrade.learn.parallel_tracking import ParallelTracking
from plantigrade.learn.reward import TERMS
from plantigrade.threads import on_one_thread

DIED = "a process of the training was killed, or ran out of memory: continue with --resume"


class SharedWalks:
    """:class:`~plantigrade.learn.environment.Walks` for training, shared among processes.

    The first share is simulated in this process, while the others are in theirs. Results do not
    depend on the number of processes, because every person has random numbers of their own.

    Args:
        num_envs: Number of environments.
        jobs: Number of processes, this one included; at most ``num_envs``.
        rules: Rules, as for :class:`~plantigrade.learn.environment.Walks`.

    Raises:
        ParameterError: As :class:`~plantigrade.learn.environment.Walks`.
    """

    def __init__(self, num_envs: int, jobs: int, **rules: Any):
        edges = np.linspace(0, num_envs, min(jobs, num_envs) + 1).round().astype(int)
        self.num_envs, self._edges = num_envs, edges
        self._own = Walks(int(edges[1]), **rules)
        self.single_observation_space = self._own.single_observation_space
        self.single_action_space = self._own.single_action_space
        rules["reference"] = self.tracking.reference
        self._others = [_Worker(int(n), rules) for n in np.diff(edges)[1:]]

    @property
    def tracking(self) -> ParallelTracking:
        """The persons of this process."""
        return self._own.tracking

    def reset(self, *, seed: int | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Start all episodes; a seed is one of random numbers from now on."""
        seeds = [None if seed is None else seed + i for i in range(self.num_envs)]
        parts = [seeds[a:b] for a, b in zip(self._edges, self._edges[1:], strict=False)]
        return np.concatenate(self._each("reset", parts)), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Apply one action per environment for one control step.

        ``infos`` has the terms of the reward, and ``final_obs``, the observations before restarts.

        Raises:
            ParameterError: As :meth:`~plantigrade.learn.environment.Walks.step`.
        """
        found = self._each("step", np.split(np.asarray(actions), self._edges[1:-1]))
        *arrays, terms = zip(*found, strict=True)
        seen, rewards, ended, over, final = (np.concatenate(each) for each in arrays)
        infos = {name: np.concatenate([each[name] for each in terms]) for name in terms[0]}
        return seen, rewards, ended, over, {**infos, "final_obs": final}

    def close(self) -> None:
        """End the other processes."""
        for worker in self._others:
            worker.close()

    def _each(self, name: str, parts: list[Any]) -> list[Any]:
        """Return what a method of every share returns."""
        for worker, part in zip(self._others, parts[1:], strict=True):
            worker.send(name, part)
        own = _CALLS[name](self._own, parts[0])
        return [own, *(worker.receive() for worker in self._others)]


class _Worker:
    """A process with a share; it ends with this one."""

    def __init__(self, n: int, rules: dict[str, Any]):
        context: Any = get_context("loky")  # unlike others it needs no guarded main module
        self._pipe, end = context.Pipe()
        self._process = context.Process(target=_serve, args=(end, n, rules), daemon=True)
        self._process.start()
        end.close()

    def send(self, name: str, part: Any) -> None:
        try:
            self._pipe.send((name, part))
        except OSError:
            raise PlantigradeError(DIED) from None

    def close(self) -> None:
        self._pipe.close()
        self._process.join()

    def receive(self) -> Any:
        try:
            found = self._pipe.recv()
        except (EOFError, OSError):
            raise PlantigradeError(DIED) from None
        if isinstance(found, Exception):
            raise found
        return found


@on_one_thread
def _serve(pipe: Any, n: int, rules: dict[str, Any]) -> None:
    """Compute what is asked through a pipe until its other end is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the other end decides what an interrupt ends
    walks = Walks(n, **rules)
    try:
        while True:
            name, part = pipe.recv()
            try:
                found = _CALLS[name](walks, part)
            except Exception as error:  # raised where the call was made
                found = error
            pipe.send(found)
    except (EOFError, OSError):
        return


def _reset(walks: Walks, seeds: list[int | None]) -> np.ndarray:
    return walks.reset(seed=seeds)[0]


def _step(walks: Walks, actions: np.ndarray) -> tuple[Any, ...]:
    seen, rewards, ended, over, infos = walks.step(actions)
    terms = {name: infos[name] for name in TERMS if name in infos}
    return seen, rewards, ended, over, infos.get("final_obs", seen), terms


_CALLS = {"reset": _reset, "step": _step}
