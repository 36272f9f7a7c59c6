"""Controllers that move a person in a world: ``controller(state) -> command``.

The world knows none of them; anything that is called with a state and returns a command is one.
"""

from plantigrade.control.choices import CONTROLLERS, Situation, controller_named
from plantigrade.control.posture import Posture, PostureSettings, passive
from plantigrade.control.tracking import Tracking, TrackingSettings

__all__ = [
    "CONTROLLERS",
    "Posture",
    "PostureSettings",
    "Situation",
    "Tracking",
    "TrackingSettings",
    "controller_named",
    "passive",
]
