"""Replay: carry out a whole motion, stepping included, and stay on the feet."""

from plantigrade.control.replay.controller import Replay, ReplaySettings

__all__ = ["Replay", "ReplaySettings"]
