"""Walking by an inverted pendulum and joint velocities, after [Tsai2010]_."""

from plantigrade.control.pendulum.controller import Pendulum
from plantigrade.control.pendulum.cycle import walk_of
from plantigrade.control.pendulum.walker import Walker, Wish

__all__ = ["Pendulum", "Walker", "Wish", "walk_of"]
