"""The settings of the pendulum controller: every number of it that was chosen."""

from dataclasses import dataclass

from plantigrade.control.gait.phase import GaitSettings
from plantigrade.control.gait.planner import FootstepSettings
from plantigrade.control.pendulum.crouch import CrouchSettings
from plantigrade.control.pendulum.disturbance import DisturbanceSettings
from plantigrade.control.pendulum.foothold import FootholdSettings
from plantigrade.control.pendulum.landing import FOOTSTEPS
from plantigrade.control.pendulum.landing_laws import LAWS
from plantigrade.control.pendulum.path import PathSettings
from plantigrade.control.pendulum.speed import SpeedSettings
from plantigrade.control.pendulum.standing import StandingSettings
from plantigrade.control.pendulum.swing import SwingSettings
from plantigrade.control.pendulum.upper_body import UpperBodySettings
from plantigrade.errors import ParameterError

MAX_TICK = 0.1  # [s] a step has a few of them


@dataclass(frozen=True, kw_only=True)
class PendulumSettings:
    """The settings of :class:`~plantigrade.control.pendulum.Pendulum` and its ``Walker``."""

    law: str = "divergent"
    """Landing law, one of :data:`~plantigrade.control.pendulum.landing_laws.LAWS`."""
    tick: float = 0.005
    """Time for which a command holds, unless a sole touches the ground or leaves it [s]."""
    reported_shortening: float = 0.01
    """Shortening from which a footstep counts as shortened in the summary [m]. Chosen."""
    gait: GaitSettings = GaitSettings()
    footsteps: FootstepSettings = FOOTSTEPS
    speed: SpeedSettings = SpeedSettings()
    path: PathSettings = PathSettings()
    crouch: CrouchSettings = CrouchSettings()
    standing: StandingSettings = StandingSettings()
    upper_body: UpperBodySettings = UpperBodySettings()
    swing: SwingSettings = SwingSettings()
    foothold: FootholdSettings = FootholdSettings()
    disturbance: DisturbanceSettings = DisturbanceSettings()

    def __post_init__(self):
        """Refuse a law that there is not, and a tick that is no time.

        Raises:
            ParameterError: If there is one.
        """
        if self.law not in LAWS:
            raise ParameterError(f"no landing law {self.law!r}; there are {', '.join(LAWS)}")
        if not 0.0 < self.tick <= MAX_TICK:
            raise ParameterError(f"tick={self.tick:g} s must be above 0 and at most {MAX_TICK:g} s")
