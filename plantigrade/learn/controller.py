"""A policy as a controller: in any world, beside every other controller."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.learn.following import Form, Rules
from plantigrade.learn.policy import Policy
from plantigrade.learn.reference import Frame, Reference
from plantigrade.learn.view import View
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.world import Command, Controller, Rates, StablePD, State

ROWS = 100.0
"""Frames of the reference that is handed out [1/s]."""

Decide = Callable[[Float[np.ndarray, "n size"]], Float[np.ndarray, "n k"]]
"""What is seen, one row → what is done, one row, within ±1."""


class PolicyController(Controller):
    """Lets a policy move a person.

    It sees and commands as in :class:`~plantigrade.learn.Walk`, from a state alone, so that noise
    and delay reach it as they reach others.

    Args:
        policy: What is seen → action: a :class:`~plantigrade.learn.policy.Policy`, or any function
            of rows, such as the ``predict`` of a learner.
        reference: The walk that it follows, as of :class:`~plantigrade.learn.Rules`; its own if
            absent.
        begin: At which part of the stride the person begins, from 0 to 1.
        rules: Fields of :class:`~plantigrade.learn.Rules` by name; those of the policy if absent.

    Attributes:
        rules: What it was trained under.
        reference: The walk that it follows.
    """

    frame_rate = 150.0
    """Frames that a run of it keeps [1/s]."""

    def __init__(self, policy: Decide, reference: Any = None, *, begin: float = 0.0, **rules: Any):
        if isinstance(policy, Policy):
            self.rules = replace(policy.rules, **rules)
        else:
            self.rules = Rules(reference=reference, **rules)
        self.reference = Reference.of(self.rules.reference if reference is None else reference)
        human = self.reference.human
        self.passive = self.rules.passive
        self.rates = Rates(control=float(self.rules.control_rate), frames=self.frame_rate)
        self._policy, self._form = policy, Form(human, self.rules)
        self._begin = begin * self.reference.period
        self._data = mujoco.MjData(human.model)
        self._view = View(human, [(human.model, self._data)])

    @property
    def record(self) -> Record:
        """The walk from where the person begins, for one stride."""
        return Record(self.reference.human, self.motion(self.reference.period))

    def motion(self, duration: float) -> Motion:
        """Return the reference from where the person begins.

        Args:
            duration: For so long [s].
        """
        human = self.reference.human
        time = np.linspace(0.0, duration, max(round(duration * ROWS), 1) + 1)
        frames = self._at(time)
        qpos = frames.qpos.copy()
        qpos[:, 2] += frames.depth
        return Motion(time, qpos, frames.qvel.copy(), human.joint_names)

    def _at(self, time: Float[Array, " n"]) -> Frame:
        """Return the reference at times after the beginning [s]."""
        return self.reference.at(time + self._begin)

    def __call__(self, state: State) -> Command:
        """Decide."""
        data, form = self._data, self._form
        data.qpos[:], data.qvel[:] = state.qpos, state.qvel
        self._view.look()
        now = np.array([state.time])
        frame, phase = self._at(now), np.asarray(self.reference.phase(now + self._begin))
        seen = form.seen(self._view, frame, phase)
        action = form.meant(np.asarray(self._policy(seen), dtype=float), phase)
        following = self._at(now + 1.0 / self.rates.control)
        stiffness, damping = form.action.gains_of(action)
        off = state.qpos[7:] - frame.qpos[0, 7:]
        signals: dict[str, Any] = {"tracking_error": float(np.sqrt(np.mean(off**2)))}
        if form.action.joints:
            signals["foot_stiffness"] = form.action.stiffness_of_joints(action)[0]
        return StablePD(
            form.action.targets(action, following)[0],
            following.qvel[0, 6:] if form.action.lead else None,
            stiffness=stiffness[0],
            damping=damping[0],
            signals=signals,
        )

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints whose stiffness is decided: the bodies that they move, in the order of signals."""
        return self._form.action.joints


def policy_named(path: str | Path) -> PolicyController:
    """Return a policy file as a controller.

    Raises:
        FileError: If there is no such file, or it does not hold a whole policy.
    """
    return PolicyController(Policy.load(path))
