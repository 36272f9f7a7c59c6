"""Put a person's motion on a robot: any MuJoCo model with two legs that stand on flat feet.

:func:`retarget` keeps a strict order: joint ranges, then the feet on the ground, then pelvis and
trunk, then the directions of the limbs.
"""

from plantigrade.robots.motion import RobotMotion
from plantigrade.robots.pose_solver import RetargetSettings
from plantigrade.robots.retargeting import retarget
from plantigrade.robots.robot import Robot, RobotSettings

__all__ = ["RetargetSettings", "Robot", "RobotMotion", "RobotSettings", "retarget"]
