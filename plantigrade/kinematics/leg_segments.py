"""Names of the segments of pelvis and legs as a gait analysis has them."""

from plantigrade.constants import SIDE_NAMES
from plantigrade.kinematics.exchanged_labels import ARM_BODIES

# Segments whose angles are those of a gait analysis; what follows the shank belongs to the foot.
LEG = {"pelvis": "pelvis", "femur": "thigh", "tibia": "shank"}


def segment_of_leg(body: str) -> str:
    """Return the segment of pelvis and legs to which a body belongs; empty for others.

    Example:
        >>> segment_of_leg("femur_r"), segment_of_leg("calcn_l"), segment_of_leg("torso")
        ('right thigh', 'left foot', '')
    """
    stem, _, side = body.rpartition("_")
    if body == "pelvis":
        return "pelvis"
    if side not in SIDE_NAMES or stem.startswith((*ARM_BODIES, "clavicle")):
        return ""
    return f"{SIDE_NAMES[side]} {LEG.get(stem, 'foot')}"
