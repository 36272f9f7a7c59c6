"""Desired acceleration of the centre of mass of a replay."""

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.tasks import GaitTaskSettings
from plantigrade.control.replay.footsteps import FootstepPlanner
from plantigrade.kinematics.state import BodyState


def com_acceleration(
    settings: GaitTaskSettings,
    body: BodyState,
    ref: Instant,
    rate: float,
    footsteps: FootstepPlanner,
    contacts: Float[Array, "k 2"],
    normal: Float[Array, " 3"],
    lowering: float,
    cop_margin: float,
) -> Float[Array, " 3"]:
    """Return the desired acceleration [m/s²]; the height follows the motion.

    Args:
        contacts: Points in contact, over the ground [m].
        lowering: Lowering of the body [m].
        cop_margin: Least distance of the centre of pressure from the edge of the contacts [m].
    """
    omega, offset, error = footsteps.reference.omega, footsteps.stance_offset, footsteps.dcm_error
    c, v = body.com, body.com_velocity
    desired = settings.com_acceleration(body, ref, omega, error, offset[:2], contacts, -cop_margin)
    rate = min(rate, 1.0)
    dz = ref.com[2] + offset[2] + rise(normal, offset) - lowering - c[2]
    stiffness = settings.com_height_stiffness
    back = stiffness * dz + 2.0 * stiffness**0.5 * (rate * ref.com_velocity[2] - v[2])
    most = settings.max_vertical_acceleration
    back = min(max(back, -most), most)
    desired[2] = rate**2 * ref.com_acceleration[2] + back
    return desired


def rise(normal: Float[Array, " 3"], offset: Array) -> float:
    """Return how much higher a plane is at a horizontal offset [m]."""
    return float(-(normal[0] * offset[0] + normal[1] * offset[1]) / normal[2])
