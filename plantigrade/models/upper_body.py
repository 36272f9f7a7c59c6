r"""Posture and motion of trunk, head and arms in walking, from published means.

The model serves recordings of the legs alone. Angles of the trunk are relative to the world,
because people keep trunk and head steady above a moving pelvis. With the phase :math:`\varphi` of
the right foot's cycle (0 at its heel strike, :math:`2\pi` at the next) and a swing scale :math:`s`,
1 at free speed,

.. math::
    \begin{aligned}
    \text{tilt} &= -2° + s\, 1.3° \cos(2\varphi - 123°), \\
    \text{list} &= s\, [1.65° \cos(\varphi - 93°) + 0.5° \cos(3\varphi - 185°)], \\
    \text{rotation} &= s\, 3.45° \cos(\varphi - 172°).
    \end{aligned}

These are the harmonics of one adult's eleven walks, pelvis and lumbar joint added [Falisse2019]_,
with list and rotation brought to the ranges of 20 adults at 1.2 m/s [Chung2010]_; the phases of
rotation and of the small wave of list are the same in children [Schwartz2008]_. The head stays
upright and faces forward.

The arm swings opposite to the ipsilateral leg, 32 degrees at free speed [Murray1967]_; the elbow
flexes in forward swing from 12 to 36 degrees at free speed [Falisse2019]_. All amplitudes increase
with the dimensionless speed up to :data:`MAX_SWING_SCALE` and vanish in standing, with an upright
trunk and hanging arms. Runners flex the elbow to 90 degrees [Yegian2019]_.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.models.textbook_gait import FREE_SPEED

TRUNK_TILT = np.deg2rad(-2.0)
"""Tilt of the trunk in standing and mean tilt in walking, negative forwards [rad]."""
TRUNK_WAVES = (  # tilt, list and rotation: amplitude [deg], phase [deg], cycles per stride
    ((1.3, 123.0, 2),),
    ((1.65, 93.0, 1), (0.5, 185.0, 3)),
    ((3.45, 172.0, 1),),
)
HANGING_ARM = {"arm_flex": -5.0, "arm_add": -17.0, "arm_rot": 17.0, "elbow_flex": 12.0}
"""Angles of a hanging arm [deg]."""
ARM_SWING = 16.0  # [deg] amplitude of shoulder flexion at free speed [Murray1967]_
ELBOW_SWING = 12.0  # [deg] amplitude of elbow flexion at free speed [Falisse2019]_
RUNNING_ELBOW = 90.0  # [deg] elbow flexion of runners [Yegian2019]_
MAX_SWING_SCALE = 1.6  # [1] swing scale of the fastest walking


@dataclass(frozen=True)
class UpperBody:
    """Trunk and arms over time."""

    trunk: Float[
        Array, "n_frames 3"
    ]  #: Tilt, list, rotation relative to the walking direction [rad]
    arms: dict[str, Float[Array, " n_frames"]]  #: ``arm_flex_r``, …, ``elbow_flex_l`` [rad]


def swing_scale(speed: Float[Array, " n_frames"]) -> Float[Array, " n_frames"]:
    r"""Return the relative amplitude of trunk and arm swing, 1 at free speed.

    ``speed`` is dimensionless, :math:`v / \sqrt{g l}`, ``l`` the length of the leg.
    """
    return np.clip(speed / FREE_SPEED, 0.0, MAX_SWING_SCALE)


def upper_body(
    phase: Float[Array, " n_frames"], speed: Float[Array, " n_frames"], *, runs: bool = False
) -> UpperBody:
    """Return the motion of trunk and arms.

    Args:
        phase: Phase of the right foot's cycle [rad]; zero at its heel strike.
        speed: Dimensionless walking speed [1]; zero in standing.
        runs: Whether the person runs.
    """
    size = swing_scale(speed)
    trunk = np.zeros((len(phase), 3))
    trunk[:, 0] = TRUNK_TILT
    for axis, waves in enumerate(TRUNK_WAVES):
        for amplitude, shift, count in waves:
            wave = np.cos(count * phase - np.deg2rad(shift))
            trunk[:, axis] += size * np.deg2rad(amplitude) * wave
    arms = {}
    for side in SIDES:
        forward = -np.cos(phase + (np.pi if side == "l" else 0.0))
        hanging = {name: np.full_like(phase, angle) for name, angle in HANGING_ARM.items()}
        hanging["arm_flex"] += ARM_SWING * size * forward
        hanging["elbow_flex"] += ELBOW_SWING * size * (1.0 + forward)
        if runs:
            hanging["elbow_flex"] = np.full_like(phase, RUNNING_ELBOW)
        arms |= {f"{name}_{side}": np.deg2rad(angle) for name, angle in hanging.items()}
    return UpperBody(trunk, arms)
