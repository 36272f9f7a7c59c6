"""Walking by an inverted pendulum and joint velocities, after [Tsai2010]_."""

from plantigrade.control.pendulum.command import WalkCommand
from plantigrade.control.pendulum.controller import Pendulum
from plantigrade.control.pendulum.reference import walk_of
from plantigrade.control.pendulum.settings import PendulumSettings
from plantigrade.control.pendulum.walker import Walker

__all__ = ["Pendulum", "PendulumSettings", "WalkCommand", "Walker", "walk_of"]
