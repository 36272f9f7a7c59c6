"""The settings of the pendulum controller: every number of it that was chosen."""

from dataclasses import dataclass

from plantigrade.control.balance import BalanceSettings
from plantigrade.control.gait.disturbance import DisturbanceSettings
from plantigrade.control.gait.loads import LoadSettings
from plantigrade.control.gait.phase import GaitPhaseSettings
from plantigrade.control.gait.planner import FootstepSettings
from plantigrade.control.gait.reference import ReferenceSettings
from plantigrade.control.gait.swing_foot import SwingSettings
from plantigrade.control.pendulum.crouch import CrouchSettings
from plantigrade.control.pendulum.footstep import PlanSettings
from plantigrade.control.pendulum.ground import GroundSettings
from plantigrade.control.pendulum.landing_laws import LAWS
from plantigrade.control.pendulum.path import PathSettings
from plantigrade.control.pendulum.push_memory import PushSettings
from plantigrade.control.pendulum.speed import SpeedSettings
from plantigrade.control.pendulum.swing import SwingPathSettings
from plantigrade.control.pendulum.tasks import WalkingTaskSettings
from plantigrade.errors import ParameterError

WALK_DURATION = 10.0  # [s] of a walk that is repeated, where none is named
MAX_TICK = 0.02  # [s] longest for which walks were measured; 0.03 s is unstable


@dataclass(frozen=True, kw_only=True)
class PendulumSettings:
    """The settings of :class:`~plantigrade.control.pendulum.Pendulum` and its ``Walker``."""

    law: str = "divergent"
    """Landing law, one of :data:`~plantigrade.control.pendulum.landing_laws.LAWS`."""
    tick: float = 0.005
    """Time for which a command holds, unless a sole touches the ground or leaves it [s]. With the
    longest, soles are sampled at half the rate."""
    max_height_difference: float = SwingSettings.clearance
    """Greatest difference in height of the stance feet of a walk on level ground [leg lengths]: a
    foot in the air is as high."""
    reference: ReferenceSettings = ReferenceSettings(load=LoadSettings(flies=False))
    """How the recorded walk is made a reference; a walk does not fly."""
    gait: GaitPhaseSettings = GaitPhaseSettings(late_descent_speed=1.0)
    """Clock, contacts and swing offsets of the gait."""
    footsteps: FootstepSettings = FootstepSettings()
    """Footsteps."""
    plan: PlanSettings = PlanSettings()
    """The reach of footsteps, and the lowering of the body for them."""
    push: PushSettings = PushSettings()
    """How a push is recognised, and the return to the path."""
    swing: SwingPathSettings = SwingPathSettings()
    """Swing feet."""
    ground: GroundSettings = GroundSettings()
    """Slope, soles and footholds."""
    tasks: WalkingTaskSettings = WalkingTaskSettings()
    """Whole-body tasks."""
    disturbance: DisturbanceSettings = DisturbanceSettings()
    """Estimator of the disturbance."""
    speed: SpeedSettings = SpeedSettings()
    """Speed by the length of steps, and changes from walk to walk."""
    path: PathSettings = PathSettings()
    """The path, and turns to it."""
    balance: BalanceSettings = BalanceSettings(stepping=True)
    """Balance while it stands."""
    crouch: CrouchSettings = CrouchSettings()
    """Lowering of the head."""

    def __post_init__(self):
        if self.law not in LAWS:
            raise ParameterError(f"no landing law {self.law!r}; there are {', '.join(LAWS)}")
        if not 0.0 < self.tick <= MAX_TICK:
            raise ParameterError(f"tick={self.tick:g} s must be above 0 and at most {MAX_TICK:g} s")
