"""Observations and actions of a policy under given rules."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.learn.action import PAPER_GAINS, Action, Gains
from plantigrade.learn.batch_state import BatchState
from plantigrade.learn.mirror import Mirror
from plantigrade.learn.observation import Observation
from plantigrade.learn.reference import ReferenceInstant
from plantigrade.learn.rules import Rules
from plantigrade.models import Human


class PolicyInterface:
    """Observations and actions of a policy under given rules.

    Attributes:
        action: Layout of actions.
        observation: Layout of observations.
    """

    def __init__(self, human: Human, rules: Rules):
        lean = rules.form == "lean"
        self.action = Action(
            human,
            rules.base or (Gains() if lean else PAPER_GAINS),
            all_joints=not lean,
            variable=not lean if rules.gains is None else rules.gains,
            reach=(0.6 if lean else 1.0) if rules.reach is None else rules.reach,
            feed_rates=lean,
        )
        self.observation = Observation(human, lean=lean)
        self._mirror = Mirror(human, self.action) if rules.mirrored else None

    def observe(
        self, view: BatchState, frame: ReferenceInstant, phase: Float[Array, " n"]
    ) -> Float[np.ndarray, "n size"]:
        """Return the observations."""
        seen = self.observation.of(view, frame, phase)
        if self._mirror is not None:
            late = phase >= 0.5
            seen[late] = self._mirror.mirror_observation(seen[late])
        return seen

    def decode(
        self, action: Float[np.ndarray, "n k"], phase: Float[Array, " n"]
    ) -> Float[np.ndarray, "n k"]:
        """Return actions clipped to ±1, mirrored in the second half of the stride."""
        bounded = np.clip(np.asarray(action, dtype=float), -1.0, 1.0)
        persons, size = len(phase), len(self.action)
        if bounded.shape != (persons, size) or not np.isfinite(bounded).all():
            raise ParameterError(f"an action must be {size} finite numbers, for {persons} persons")
        if self._mirror is not None:
            late = phase >= 0.5
            bounded[late] = self._mirror.mirror_action(bounded[late])
        return bounded
