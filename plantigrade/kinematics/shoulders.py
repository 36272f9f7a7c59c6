r"""The angles of a shoulder: two triples give one pose, and one of them is anatomical.

Three turns about :math:`y, x, z` give one pose of the upper arm by two triples,
:math:`(a, b, c)` and :math:`(a + 180°, 180° - b, c + 180°)`; where the arm is abducted to the
horizontal (:math:`b = -90°`) the pose depends on a sum of :math:`a` and :math:`c` alone, so noise
determines the two.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.models import Human
from plantigrade.motion import Motion

ARM = ("arm_flex", "arm_add", "arm_rot")
USUAL_RANGE = np.deg2rad([(-70.0, 185.0), (-185.0, 60.0), (-110.0, 110.0)])
"""Flexion, adduction and rotation of the shoulder (with its girdle) that people reach [rad]."""
START_ANGLES = (
    (0.0, 0.0, 0.0),
    (1.5, 0.0, 0.0),
    (0.0, -1.5, 0.0),
    (2.8, 0.0, 0.0),
    (0.0, -2.7, 0.0),
    (1.2, -1.2, 1.2),
    (1.2, -1.2, -1.2),
    (-0.8, -0.5, 0.0),
)
"""Initial guesses of an arm: flexion, adduction, rotation [rad]."""
START_ELBOW = 0.6  # [rad] elbow flexion of these initial guesses
HOLD_WEIGHT = 2e-3
"""Weight that holds flexion and rotation of a horizontal arm at their values of the frame before
[m²/rad²]. There, 1 rad of both moves an elbow 3° off the axis by 15 mm, which this weight balances;
elsewhere the markers weigh a hundred times more."""


def arms_of(human: Human) -> list[list[int]]:
    """Return the hinges of each shoulder, in the order of :data:`ARM`; none without arms."""
    if f"{ARM[0]}_r" not in human.coordinates:
        return []
    return [[human.hinge(f"{name}_{side}") for name in ARM] for side in SIDES]


def in_range(angles: Float[Array, " *n 3"]) -> Float[Array, " *n 3"]:
    """Return angles shifted by whole turns to the middle of the usual range [rad]."""
    return angles - 2 * np.pi * np.round((angles - USUAL_RANGE.mean(axis=1)) / (2 * np.pi))


def equivalent_angles(angles: Float[Array, " *n 3"]) -> Float[Array, " *n 3"]:
    """Return the other triple of the same pose, near the usual range [rad]."""
    a, b, c = np.moveaxis(np.asarray(angles), -1, 0)
    return in_range(np.stack([a + np.pi, np.pi - b, c + np.pi], axis=-1))


def range_excess(angles: Float[Array, " *n 3"]) -> Float[Array, " *n"]:
    """Return the distance of shoulder angles from their usual range [rad]."""
    low, high = USUAL_RANGE.T
    beyond = np.maximum(low - angles, 0) + np.maximum(angles - high, 0)
    return np.asarray(np.linalg.norm(beyond, axis=-1))


def in_usual_branch(human: Human, qpos: Float[Array, " nq"]) -> Float[Array, " nq"]:
    """Return a configuration with the triple of each shoulder that is nearer its usual range."""
    q = np.array(qpos)
    low, high = human.limits
    for hinges in arms_of(human):
        other = np.clip(equivalent_angles(q[7:][hinges]), low[hinges], high[hinges])
        if range_excess(other) < range_excess(q[7:][hinges]):
            q[7:][hinges] = other
    return q


def counted_on(human: Human, motion: Motion) -> Motion:
    """Return a motion of the same poses, with shoulder angles that go on from frame to frame.

    Within limits, an arm that goes up through the level sideways and comes back another way has to
    change triples somewhere, by half a turn from one frame to the next. Here each frame has the
    triple nearer to the one before, whole turns beyond the limits if it must be.
    """
    qpos, qvel = motion.qpos.copy(), motion.qvel.copy()
    qacc = None if motion.qacc is None else motion.qacc.copy()
    for hinges in arms_of(human):
        k = 7 + np.array(hinges)
        angles, changed = _counted_on(qpos[:, k], human.limits[:, hinges])
        qpos[:, k] = angles
        for rates in (qvel, qacc):  # the other triple adducts the other way
            if rates is not None:
                rates[changed, k[1] - 1] *= -1.0
    if np.array_equal(qpos, motion.qpos):
        return motion
    return replace(motion, qpos=qpos, qvel=qvel, qacc=qacc)


def _counted_on(
    angles: Float[Array, "n_frames 3"], limits: Float[Array, "2 3"]
) -> tuple[Float[Array, "n_frames 3"], Bool[Array, " n_frames"]]:
    """Return angles that go on from frame to frame, and where they are the other triple."""
    out, changed = angles.copy(), np.zeros(len(angles), bool)
    for f in range(1, len(angles)):
        choices = [
            triple - 2 * np.pi * np.round((triple - out[f - 1]) / (2 * np.pi))
            for triple in (angles[f], equivalent_angles(angles[f]))
        ]
        near = int(np.argmin([np.linalg.norm(x - out[f - 1]) for x in choices]))
        out[f], changed[f] = choices[near], bool(near)
    low, high = limits
    turned = out * (1.0, -1.0, 1.0) + np.pi
    found = []
    for path in (out, turned):
        turns = 2 * np.pi * np.arange(-2, 3)[:, None, None] + path
        beyond = (np.maximum(low - turns, 0) + np.maximum(turns - high, 0)).sum(axis=1)
        beyond[[0, 1, 3, 4]] += 1e-9  # none where it makes no difference
        best = beyond.argmin(axis=0)
        found.append((beyond.min(axis=0).sum(), path + 2 * np.pi * (best - 2)))
    other = found[1][0] < found[0][0] - 1e-6
    return found[int(other)][1], changed ^ other


def arm_starts(
    human: Human, qpos: Float[Array, " nq"], sides: str = "rl"
) -> Iterator[Float[Array, " nq"]]:
    """Yield configurations with the arms down, forward, sideways, overhead and behind."""
    for angles in START_ANGLES if arms_of(human) else ():
        q = np.array(qpos)
        for side, hinges in zip(SIDES, arms_of(human), strict=True):
            if side in sides:
                q[7:][hinges] = angles
                q[7 + human.hinge(f"elbow_flex_{side}")] = START_ELBOW
        yield q


class ShoulderHold:
    """Posture weights that keep horizontal arms from turning with the noise of their markers.

    Args:
        posture: Weight of each hinge's rest angle [m²/rad²].
        rest: The rest posture [rad].
    """

    def __init__(
        self, human: Human, posture: Float[Array, " n_hinges"], rest: Float[Array, " n_hinges"]
    ):
        self._arms, self._posture, self._rest = arms_of(human), posture, rest

    def after(
        self, hinges: Float[Array, " n_hinges"]
    ) -> tuple[Float[Array, " n_hinges"], Float[Array, " n_hinges"]]:
        """Return weights [m²/rad²] and rest angles [rad] for the frame after these angles [rad]."""
        posture, rest = self._posture.copy(), self._rest.copy()
        for flex, add, turn in self._arms:
            pull = HOLD_WEIGHT * np.sin(hinges[add]) ** 8
            for k in (flex, turn):
                posture[k] += pull
                rest[k] += pull / posture[k] * (hinges[k] - rest[k])
        return posture, rest
