"""A trained policy as a controller."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.onnx_policy import OnnxPolicy, is_onnx
from plantigrade.learn.policy import Policy
from plantigrade.learn.policy_interface import PolicyInterface
from plantigrade.learn.reference import ReferenceInstant, ReferenceMotion
from plantigrade.learn.rules import Rules
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.world import Command, Controller, Rates, StablePD, State

ROWS = 100.0
"""Frame rate of the reference motion [1/s]."""

PolicyFunction = Callable[[Float[np.ndarray, "n size"]], Float[np.ndarray, "n k"]]
"""Function from observations to actions within ±1, one row each."""


class PolicyController(Controller):
    """Controls a person by a policy.

    Observations and commands are those of :class:`~plantigrade.learn.WalkEnv`. They use the state
    alone, so sensor noise and delay affect the policy as they affect other controllers.

    Args:
        policy: A :class:`~plantigrade.learn.policy.Policy` or
            :class:`~plantigrade.learn.onnx_policy.OnnxPolicy`, or any function from observations
            to actions, such as ``predict`` of a learner.
        reference: Reference walk, as in :class:`~plantigrade.learn.Rules`; that of the policy if
            absent.
        begin: Initial phase of the stride, from 0 to 1.
        rules: Fields of :class:`~plantigrade.learn.Rules` by name; those of the policy if absent.

    Raises:
        FileError: If an ONNX network has other observations or actions than the rules.

    Attributes:
        rules: Rules of the training.
        reference: Reference walk.
    """

    frame_rate = 150.0
    """Recorded frames per second [1/s]."""

    def __init__(
        self, policy: PolicyFunction, reference: Any = None, *, begin: float = 0.0, **rules: Any
    ):
        if isinstance(policy, Policy | OnnxPolicy):
            self.rules = replace(policy.rules, **rules)
        else:
            self.rules = Rules(reference=reference, **rules)
        self.reference = ReferenceMotion.of(
            self.rules.reference if reference is None else reference
        )
        human = self.reference.human
        self.passive = self.rules.passive
        self.rates = Rates(control=float(self.rules.control_rate), frames=self.frame_rate)
        self._policy, self._form = policy, PolicyInterface(human, self.rules)
        if isinstance(policy, OnnxPolicy):
            policy.require_sizes(len(self._form.observation), len(self._form.action))
        self._begin = begin * self.reference.period
        self._data = mujoco.MjData(human.model)
        self._view = BatchState(human, [(human.model, self._data)])

    @property
    def record(self) -> Record:
        """One stride of the reference from the initial phase."""
        return Record(self.reference.human, self.motion(self.reference.period))

    def motion(self, duration: float) -> Motion:
        """Return the reference from the initial phase.

        Args:
            duration: Duration [s].
        """
        human = self.reference.human
        time = np.linspace(0.0, duration, max(round(duration * ROWS), 1) + 1)
        frames = self._at(time)
        qpos = frames.qpos.copy()
        qpos[:, 2] += frames.depth
        return Motion(time, qpos, frames.qvel.copy(), human.joint_names)

    def _at(self, time: Float[Array, " n"]) -> ReferenceInstant:
        """Return the reference at times after the start [s]."""
        return self.reference.at(time + self._begin)

    def __call__(self, state: State) -> Command:
        """Return the command of the policy."""
        data, form = self._data, self._form
        data.qpos[:], data.qvel[:] = state.qpos, state.qvel
        self._view.update()
        now = np.array([state.time])
        frame, phase = self._at(now), np.asarray(self.reference.phase(now + self._begin))
        seen = form.observe(self._view, frame, phase)
        action = form.decode(np.asarray(self._policy(seen), dtype=float), phase)
        tracking = self._at(now + 1.0 / self.rates.control)
        stiffness, damping = form.action.gains_of(action)
        off = state.qpos[7:] - frame.qpos[0, 7:]
        signals: dict[str, Any] = {"tracking_error": root_mean_square(off)}
        if form.action.joints:
            signals["foot_stiffness"] = form.action.stiffness_of_joints(action)[0]
        return StablePD(
            form.action.targets(action, tracking)[0],
            tracking.qvel[0, 6:] if form.action.feed_rates else None,
            stiffness=stiffness[0],
            damping=damping[0],
            signals=signals,
        )

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints with variable stiffness in the order of signals, named by the bodies they move."""
        return self._form.action.joints


def load_controller(path: str | Path) -> PolicyController:
    """Return the controller of a policy file.

    Raises:
        FileError: If the file does not exist or is not a complete policy.
        MissingExtra: If it is an ONNX file, and the extra ``onnx`` is not installed.
    """
    return PolicyController(OnnxPolicy(path) if is_onnx(path) else Policy.load(path))
