"""Learning to walk: a Gymnasium environment over the world.

Importing this room registers ``plantigrade/Walk-v0``. It needs the extra ``learn``.
"""

from plantigrade.extras import require
from plantigrade.learn.action import PAPER_GAINS, Gains
from plantigrade.learn.environment import Walk, Walks
from plantigrade.learn.following import Rules
from plantigrade.learn.reference import Reference
from plantigrade.learn.reward import Weights

__all__ = ["PAPER_GAINS", "WALK", "Gains", "Reference", "Rules", "Walk", "Walks", "Weights"]

WALK = "plantigrade/Walk-v0"
"""Name of the environment for ``gymnasium.make``."""

_gymnasium = require("gymnasium", "learn")
if WALK not in _gymnasium.registry:
    _gymnasium.register(
        WALK,
        entry_point="plantigrade.learn.environment:Walk",
        vector_entry_point="plantigrade.learn.environment:Walks",
    )
