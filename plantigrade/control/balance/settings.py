"""Settings of :class:`~plantigrade.control.balance.Balance`."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.balance.flight import FlightSettings
from plantigrade.control.balance.ground_contact import GroundContactSettings
from plantigrade.control.balance.recovery import RecoverySettings
from plantigrade.control.gait.phase import GaitPhaseSettings
from plantigrade.control.gait.tasks import GaitTaskSettings, within_foot
from plantigrade.models import Human


@dataclass(frozen=True, kw_only=True)
class JointGains:
    """Stiffness about the reference, critically damped."""

    body: float = GaitTaskSettings.joint_stiffness
    """Pelvis and joints above the feet [1/s²]; as in walking. With 80, pushes to eight sides took a
    fifth more steps."""
    foot: float = GaitTaskSettings.rotation_stiffness
    """Joints within a foot [1/s²]; as of the rotation of a foot in walking."""

    def of(self, human: Human) -> Float[Array, " nv"]:
        """Return the stiffness of every coordinate [1/s²]; none of the position of the pelvis."""
        own = np.where(within_foot(human), self.foot, self.body)
        return np.r_[np.zeros(3), np.full(3, self.body), own]


@dataclass(frozen=True, kw_only=True)
class JointStopSettings:
    """Joints that slow down before the end of their range, once there were steps."""

    distance: float = 0.15
    """Distance from a stop below which a joint slows down [rad]. Chosen (±20 %: deviation 15 %)."""
    weight: float = 100.0
    """Weight at the stop [per (rad/s²)²]. Chosen (±20 %: deviation 63 %)."""
    gain: float = 400.0
    """Stiffness of the approach, critically damped [1/s²]. Chosen (±20 %: deviation 24 %)."""


@dataclass(frozen=True, kw_only=True)
class BalanceSettings:
    """Weights of squared errors of acceleration, gains, and the settings of the components.

    One set serves all motions. Weights are relative to that of a joint, which is 1. They are those
    of the "hip" setting of a study of pushes: the centre of mass counts a thousand times a joint,
    and trunk and arms give way where the centre of pressure has come to the edge of the support.
    """

    stepping: bool = False
    """Whether a step is taken where standing in place can no longer succeed."""
    recovery: RecoverySettings = RecoverySettings()
    """Recovery steps."""
    flight: FlightSettings = FlightSettings()
    """Flights of a reference."""
    contact: GroundContactSettings = GroundContactSettings()
    """Contacts of the feet."""
    joint_gains: JointGains = JointGains()
    """Stiffness about the reference."""
    joint_stops: JointStopSettings = JointStopSettings()
    """Approach of the end of the range of a joint."""

    com_weight: float = 1000.0
    """Weight of the centre of mass, and of points that stay where they are [per (m/s²)²]. From the
    study of pushes."""
    com_gain: float = 50.0
    """Stiffness of the centre of mass, critically damped [1/s²]. Chosen (a change of 20 %
    changes the deviation by 13 %)."""
    com_centring: float = 0.25
    """Goal of the centre of mass, from the reference (0) to the middle of the support (1). At 0 the
    heels have less room than the toes, for people stand with their weight behind the middle."""
    com_goal_speed: float = 0.1
    """Speed at which the goal moves to where a target has it [m/s]. Chosen (±20 %: below
    2 %)."""
    pelvis_weight: float = 0.1
    """Weight of the orientation of the pelvis [per (rad/s²)²]. Chosen (±20 %: deviation 44 %)."""
    spine_weight: float = 0.2
    """Weight of lumbar and thoracic joints [per (rad/s²)²]: what keeps balance moves. Chosen (±20
    %: deviation 22 %)."""
    arm_weight: float = GaitTaskSettings.arm_weight**2
    """Weight of the joints of the arms [per (rad/s²)²]; as in walking."""
    hip_weight: float = GaitTaskSettings.leg_weight**2
    """Weight of the hips [per (rad/s²)²]; as in walking."""
    contact_gain: float = 300.0
    """Stiffness of the height of points that stay on the ground or come to it, critically damped
    [1/s²]. From 200 to 400 people of all sizes stand on tiptoe on soles that yield; with 150 and
    800 some fall. With the 28 of [Park2020]_, and little weight, points that have left the ground
    in a sideways push come back too late."""
    landing_weight: float = 50.0
    """Weight of points that come to the ground, Eq. 7 of [Park2020]_ [per (m/s²)²]. Chosen (±20 %:
    deviation 21 %)."""
    force_weight: float = 1e-3
    """Weight of forces along an edge of a friction pyramid [per (0.1 body weights)²]. Chosen (±20
    %: deviation 17 %)."""
    idle_force_weight: float = 100.0
    """Weight of forces of points that touch and are not to [per (0.1 body weights)²]. Chosen (±20
    %: below 2 %)."""
    joint_damping: float = GaitPhaseSettings.joint_damping
    """Damping about the planned velocity of a joint, by its greatest torque [s]; as in walking."""
    foot_joint_damping: float = 0.5
    """Damping about the plan within a foot [N m s/rad]. Chosen (±20 %: deviation 33 %)."""
    foot_joint_stiffness: float = 30.0
    """Stiffness about the plan within a foot [N m/rad]. Chosen (±20 %: deviation 23 %)."""

    @property
    def com_damping(self) -> float:
        """Critical damping of the centre of mass [1/s]."""
        return 2.0 * self.com_gain**0.5

    def joint_weights(self, human: Human, *, flies: bool = False) -> Float[Array, " nv"]:
        """Return the weight of every coordinate; none of the position of the pelvis.

        Args:
            human: The person.
            flies: Whether the reference flies.
        """
        pelvis, spine, hip = self.pelvis_weight, self.spine_weight, self.hip_weight
        if flies:  # the legs move the body, and a lighter trunk bent by 75° at the landing of jumps
            pelvis = spine = hip = 1.0
        parts = {
            ("lumbar", "thorax"): spine,
            ("arm", "elbow", "clavicle"): self.arm_weight,
            "hip": hip,
        }
        joints = [
            next((weight for start, weight in parts.items() if name.startswith(start)), 1.0)
            for name in human.coordinates
        ]
        return np.array([0.0] * 3 + [pelvis] * 3 + joints)
