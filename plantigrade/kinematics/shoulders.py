r"""The angles of a shoulder: two triples give one pose, and one of them is anatomical.

Three turns about :math:`y, x, z` give one pose of the upper arm by two triples,
:math:`(a, b, c)` and :math:`(a + 180°, 180° - b, c + 180°)`; where the arm is abducted to the
horizontal (:math:`b = -90°`) only a sum of :math:`a` and :math:`c` counts, so noise turns them as
it likes.
"""

from collections.abc import Iterator

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.models import Human

ARM = ("arm_flex", "arm_add", "arm_rot")
USUAL = np.deg2rad([(-70.0, 185.0), (-185.0, 60.0), (-110.0, 110.0)])
"""Flexion, adduction and rotation of the shoulder (with its girdle) that people reach [rad]."""
STARTS = (
    (0.0, 0.0, 0.0),
    (1.5, 0.0, 0.0),
    (0.0, -1.5, 0.0),
    (2.8, 0.0, 0.0),
    (0.0, -2.7, 0.0),
    (1.2, -1.2, 1.2),
    (1.2, -1.2, -1.2),
    (-0.8, -0.5, 0.0),
)
"""Ways to hold the arms that a solution may be begun from: flexion, adduction, rotation [rad]."""
ELBOW = 0.6  # how far the elbows are bent there [rad]
HOLD = 2e-3
"""Pull on flexion and rotation towards the frame before where an arm is horizontal, in the unit of
the pull towards rest, m²/rad². There an elbow 3° off the axis moves by 15 mm where they turn by
1 rad, which is what this weighs; elsewhere the markers are a hundred times stronger."""


def arms_of(human: Human) -> list[list[int]]:
    """Return the hinges of each shoulder, in the order of :data:`ARM`; none without arms."""
    if f"{ARM[0]}_r" not in human.coordinates:
        return []
    return [[human.hinge(f"{name}_{side}") for name in ARM] for side in SIDES]


def in_range(angles: Float[Array, " *n 3"]) -> Float[Array, " *n 3"]:
    """Return angles [rad] by whole turns as near as can be to the middle of the usual range."""
    return angles - 2 * np.pi * np.round((angles - USUAL.mean(axis=1)) / (2 * np.pi))


def other_triple(angles: Float[Array, " *n 3"]) -> Float[Array, " *n 3"]:
    """Return the equivalent triple [rad], by whole turns as near as can be to the usual range."""
    a, b, c = np.moveaxis(np.asarray(angles), -1, 0)
    return in_range(np.stack([a + np.pi, np.pi - b, c + np.pi], axis=-1))


def astray(angles: Float[Array, " *n 3"]) -> Float[Array, " *n"]:
    """Return how far a shoulder is out of its usual range [rad]."""
    low, high = USUAL.T
    beyond = np.maximum(low - angles, 0) + np.maximum(angles - high, 0)
    return np.asarray(np.linalg.norm(beyond, axis=-1))


def in_branch(human: Human, qpos: Float[Array, " nq"]) -> Float[Array, " nq"]:
    """Return a configuration with that triple of each shoulder which is less astray."""
    q = np.array(qpos)
    low, high = human.limits
    for hinges in arms_of(human):
        other = np.clip(other_triple(q[7:][hinges]), low[hinges], high[hinges])
        if astray(other) < astray(q[7:][hinges]):
            q[7:][hinges] = other
    return q


def held_otherwise(
    human: Human, qpos: Float[Array, " nq"], sides: str = "rl"
) -> Iterator[Float[Array, " nq"]]:
    """Return configurations with the arms held otherwise: down, forward, sideways, up, behind."""
    for angles in STARTS if arms_of(human) else ():
        q = np.array(qpos)
        for side, hinges in zip(SIDES, arms_of(human), strict=True):
            if side in sides:
                q[7:][hinges] = angles
                q[7 + human.hinge(f"elbow_flex_{side}")] = ELBOW
        yield q


class Hold:
    """The pull that keeps horizontal arms from turning as noise likes.

    Args:
        human: The person.
        posture: The usual pull on each hinge towards rest [m²/rad²].
        rest: The rest posture [rad].
    """

    def __init__(
        self, human: Human, posture: Float[Array, " n_hinges"], rest: Float[Array, " n_hinges"]
    ):
        self._arms, self._posture, self._rest = arms_of(human), posture, rest

    def after(
        self, hinges: Float[Array, " n_hinges"]
    ) -> tuple[Float[Array, " n_hinges"], Float[Array, " n_hinges"]]:
        """Return pull and rest posture for the frame after one with these angles [rad]."""
        posture, rest = self._posture.copy(), self._rest.copy()
        for flex, add, turn in self._arms:
            pull = HOLD * np.sin(hinges[add]) ** 8
            for k in (flex, turn):
                posture[k] += pull
                rest[k] += pull / posture[k] * (hinges[k] - rest[k])
        return posture, rest
