"""Learning to walk: a Gymnasium environment and trained policies.

Importing this package registers ``plantigrade/Walk-v0`` if Gymnasium is installed. The environments
need the extra ``learn``; a trained policy does not (in ONNX, the extra ``onnx``).
"""

from importlib.util import find_spec
from typing import TYPE_CHECKING

from plantigrade.lazy import lazy
from plantigrade.learn.action import PAPER_GAINS, Gains
from plantigrade.learn.controller import PolicyController
from plantigrade.learn.onnx_policy import OnnxPolicy, write_onnx
from plantigrade.learn.policy import Policy
from plantigrade.learn.reference import ReferenceMotion
from plantigrade.learn.reward import RewardWeights
from plantigrade.learn.rules import Rules

if TYPE_CHECKING:
    from plantigrade.learn.environment import WalkEnv, Walks

__all__ = [
    "PAPER_GAINS",
    "WALK",
    "Gains",
    "OnnxPolicy",
    "Policy",
    "PolicyController",
    "ReferenceMotion",
    "Rules",
    "WalkEnv",
    "Walks",
    "RewardWeights",
    "write_onnx",
]

WALK = "plantigrade/Walk-v0"
"""Name of the environment for ``gymnasium.make``."""

__getattr__ = lazy(__name__)  # environments need Gymnasium


def _register() -> None:
    import gymnasium

    if WALK not in gymnasium.registry:
        gymnasium.register(
            WALK,
            entry_point="plantigrade.learn.environment:WalkEnv",
            vector_entry_point="plantigrade.learn.environment:Walks",
        )


if find_spec("gymnasium") is not None:
    _register()
