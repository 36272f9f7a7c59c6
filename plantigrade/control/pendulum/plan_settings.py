"""Settings of the plan of a walk on the inverted pendulum."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class PlanSettings:
    """How a walk returns to its path and reaches footsteps; values were chosen."""

    max_path_error: float = 0.4
    """Greatest offset from the reference that is countered [leg lengths]: along the path, what is
    lost beyond it stays lost."""
    max_leg_length: float = 1.1
    """Greatest distance of hip and ankle, with the pelvis leant towards the foot [leg lengths]."""
    max_lowering: float = 0.2
    """Greatest lowering of the body for a far footstep [leg lengths]."""
    min_lowering: float = 0.04
    """Distance that legs of a walk give by themselves before the body is lowered [leg lengths]: a
    walk that nobody disturbs steps as much farther than the recording."""
