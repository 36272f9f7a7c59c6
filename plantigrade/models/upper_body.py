r"""Posture and motion of trunk, head and arms in walking, from published means.

For a person of whom only the legs were recorded. Angles of the trunk are those in the room, not
against the pelvis: people keep trunk and head steady above a pelvis that turns and lists. With the
phase :math:`\varphi` of the right foot's cycle (0 at its heel strike, :math:`2\pi` at the next) and
a vigour :math:`s` that is 1 at free speed,

.. math::
    \begin{aligned}
    \text{tilt} &= -2° + s\, 1.3° \cos(2\varphi - 123°), \\
    \text{list} &= s\, [1.65° \cos(\varphi - 93°) + 0.5° \cos(3\varphi - 185°)], \\
    \text{rotation} &= s\, 3.45° \cos(\varphi - 172°).
    \end{aligned}

These are the harmonics of one adult's eleven walks, pelvis and lumbar joint added [Falisse2019]_,
with list and rotation brought to the ranges of 20 adults at 1.2 m/s [Chung2010]_; the phases of
rotation and of the small wave of list are the same in children [Schwartz2008]_. The head stays
upright and looks ahead.

The arm swings against the leg of its side, 32 degrees at free speed [Murray1967]_; the elbow bends
as the arm comes forward, from 12 to 36 degrees at free speed [Falisse2019]_. All amplitudes grow
with the dimensionless speed, as far as :data:`MOST_VIGOUR`, and vanish in standing: then the trunk
is upright and the arms hang. Runners bend the elbow to a right angle [Yegian2019]_.

References:
    [Chung2010]_, [Falisse2019]_, [Murray1967]_, [Schwartz2008]_, [Yegian2019]_.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.models.textbook_gait import FREE

LEAN = np.deg2rad(-2.0)
"""Tilt of the trunk in upright standing and on average in walking; negative is forward [rad]."""
TRUNK = (  # of tilt, list and rotation: amplitude [deg], phase [deg], waves in a stride
    ((1.3, 123.0, 2),),
    ((1.65, 93.0, 1), (0.5, 185.0, 3)),
    ((3.45, 172.0, 1),),
)
ARM = {"arm_flex": -5.0, "arm_add": -17.0, "arm_rot": 17.0, "elbow_flex": 12.0}
"""Angles of an arm that hangs [deg]."""
ARM_SWING, ELBOW_SWING = 16.0, 12.0  # amplitudes at free speed [deg]
RUNNING_ELBOW = 90.0  # [deg]
MOST_VIGOUR = 1.6  # of the fastest walking


@dataclass(frozen=True)
class UpperBody:
    """Trunk and arms over time."""

    trunk: Float[Array, "n_frames 3"]  #: Tilt, list, rotation against the way one goes [rad]
    arms: dict[str, Float[Array, " n_frames"]]  #: ``arm_flex_r``, …, ``elbow_flex_l`` [rad]


def vigour(speed: Float[Array, " n_frames"]) -> Float[Array, " n_frames"]:
    r"""Return how far trunk and arms swing, 1 at free speed.

    ``speed`` is dimensionless, :math:`v / \sqrt{g l}`, ``l`` the length of the leg.
    """
    return np.clip(speed / FREE, 0.0, MOST_VIGOUR)


def upper_body(
    phase: Float[Array, " n_frames"], speed: Float[Array, " n_frames"], *, runs: bool = False
) -> UpperBody:
    """Return how trunk and arms move.

    Args:
        phase: Of the right foot's cycle [rad]; zero at its heel strike.
        speed: Dimensionless speed of walking; zero in standing.
        runs: Whether the person runs.
    """
    size = vigour(speed)
    trunk = np.zeros((len(phase), 3))
    trunk[:, 0] = LEAN
    for axis, waves in enumerate(TRUNK):
        for amplitude, shift, count in waves:
            wave = np.cos(count * phase - np.deg2rad(shift))
            trunk[:, axis] += size * np.deg2rad(amplitude) * wave
    arms = {}
    for side in SIDES:
        forward = -np.cos(phase + (np.pi if side == "l" else 0.0))
        hanging = {name: np.full_like(phase, angle) for name, angle in ARM.items()}
        hanging["arm_flex"] += ARM_SWING * size * forward
        hanging["elbow_flex"] += ELBOW_SWING * size * (1.0 + forward)
        if runs:
            hanging["elbow_flex"] = np.full_like(phase, RUNNING_ELBOW)
        arms |= {f"{name}_{side}": np.deg2rad(angle) for name, angle in hanging.items()}
    return UpperBody(trunk, arms)
