"""Put a person's motion on a robot: any MuJoCo model with two legs that stand on flat feet.

:func:`retarget` keeps a strict order: joint ranges, then the feet on the ground, then pelvis and
trunk, then the directions of the limbs.
"""

from plantigrade.robots.motion import RobotMotion
from plantigrade.robots.retargeting import RetargetSettings, retarget
from plantigrade.robots.robot import Robot

__all__ = ["RetargetSettings", "Robot", "RobotMotion", "retarget"]
