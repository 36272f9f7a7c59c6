"""Walking by an inverted pendulum and joint velocities, after [Tsai2010]_."""

from plantigrade.control.pendulum.controller import Pendulum
from plantigrade.control.pendulum.cycle import walk_of

__all__ = ["Pendulum", "walk_of"]
