"""What is wanted of the body, as velocities: joints, pelvis, feet, what touches, the mass.

Every row asks that a velocity be reached in a time, so its acceleration is what is missing by that
time, and what the recording itself has.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import sqrt

import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.constants import SIDES
from plantigrade.control.gait.instant import Instant
from plantigrade.control.gait.tasks import (
    TaskSettings,
    joint_weights,
    root_error,
    within_foot,
)
from plantigrade.control.pendulum.plan import Plan
from plantigrade.control.pendulum.velocities import REACHED, bell
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.wbc.rows import PointRows, Rows

PELVIS, SWING, SWING_TURN, STANCE_TURN, HELD = 3.0, 10.0, 2.0, 2.0, 10.0
"""Weights: turn of the pelvis, place and turn of a swinging foot, turn of a standing one, what
touches."""
PLACE, TURN, PELVIS_TURN = (10.0, 0.025), (7.0, 0.036), (5.0, 0.05)
"""Velocity by error [1/s], and in which time it is reached [s]: of a swinging foot, of the turn of
feet and of the pelvis. Together they are stiffness and damping of a critically damped spring."""
HEIGHT = 10.0
"""Weight of the height of the mass: where the body goes down, legs give way to it."""
QUICK = 2.0
"""Constant of the bell within a foot that swings: its toes are needed again soon."""
STILL = 0.025
"""In this time what touches is to be still [s]."""

VERTICAL = (5.0, 0.06)
"""The height of the mass is led back at this rate [1/s], in this time [s]."""
SINKS, RISES = -3.0, 4.0
"""The mass is let down and pressed up no faster than so, unless the recording does [m/s²]: who
falls can neither press nor step, and who is thrown up neither."""
BACK = (-3.0, 4.0)
"""Limits of the vertical acceleration that leads back to the recorded height [m/s²]: more would
throw who lands low into the air again."""
FASTEST, SOONEST = -7.0, 0.04
"""For a far foot it is let down so fast [m/s²] if it takes that to be low when it lands, in this
time or more [s]: the foot hung over its place, and the body fell over it."""

FREE = 0.3
"""Where the neck is off by so much its accelerations cost twice as much, and farther off more and
more [rad]: the head is the cheapest flywheel, but people hold it still in space [Pozzo1990]_."""

FIRM = 5.0
"""Feedback of the divergent component by the centre of pressure [1/s]."""
BEYOND = 0.35
"""So far outside of what touches the pressure may be asked for [leg lengths]: what feet cannot give
there, trunk and arms give by their angular momentum [Hof2007]_."""

_ONE = np.eye(3)


@dataclass(frozen=True)
class Weights:
    """What joints count, and how fast they go.

    Attributes:
        weight: Cost of an acceleration missed, squared: root, whose place has none, then hinges.
        neck: Coordinates of the neck.
        within: Which hinges are within the right foot, and which within the left.
        centre: Weights of the acceleration of the mass, squared.
    """

    weight: Float[Array, " nv"]
    neck: Int[Array, " k"]
    within: Bool[Array, "2 n_hinges"]
    centre: Float[Array, " 3"]

    @classmethod
    def of(cls, human: Human) -> "Weights":
        """Return those of a person."""
        joints, names = joint_weights(human, TaskSettings()), human.coordinates
        weight = np.concatenate([np.zeros(3), np.full(3, PELVIS), joints]) ** 2
        sides = np.array([[name.endswith(f"_{side}") for name in names] for side in SIDES])
        neck = 6 + np.flatnonzero(["neck_" in name for name in names])
        centre = np.array([*TaskSettings.com_weight[:2], HEIGHT]) ** 2
        return cls(weight, neck, sides & within_foot(human), centre)

    def at(self, error: Float[Array, " n_hinges"]) -> Float[Array, " nv"]:
        """Return the weights where hinges are off by so much [rad]."""
        weight = self.weight.copy()
        weight[self.neck] *= 1.0 + (error[self.neck - 6] / FREE) ** 2
        return weight

    def pace(self, swings: Sequence[bool]) -> Float[Array, " n_hinges"]:
        """Return the factor of the bell of every hinge.

        One constant a joint (``c_i`` of [Tsai2010]_, whose table the printed text lacks): one, and
        :data:`QUICK` within a foot that swings, right and left.
        """
        found = np.ones(self.within.shape[1])
        for inside, swing in zip(self.within, swings, strict=True):
            if swing:
                found[inside] = QUICK
        return found


def joint_accelerations(
    body: State,
    ref: Instant,
    rate: float,
    pace: Float[Array, " n_hinges"],
    turning: float = 0.0,
) -> Float[Array, " nv"]:
    """Return accelerations of pelvis and joints: rates along the bell, and the recording's own.

    Args:
        body: The person now.
        ref: The recording at the phase of the gait.
        rate: Of the phase.
        pace: Factor of the bell, by hinge.
        turning: How fast the walk turns to the left [rad/s].
    """
    wanted = rate * ref.v - body.qvel
    wanted[3:6] += turning * body.rotations[1, 2]  # the vertical, in the axes of the pelvis
    turn = root_error(ref.q[3:7], body.qpos[3:7])
    wanted[3:6] = (wanted[3:6] + PELVIS_TURN[0] * turn) / PELVIS_TURN[1]
    error = ref.q[7:] - body.qpos[7:]
    wanted[6:] = (wanted[6:] + pace * bell(error)) * (pace / REACHED)
    wanted += rate**2 * ref.a
    wanted[:3] = 0.0
    return wanted


def mass_acceleration(
    body: State,
    ref: Instant,
    rate: float,
    omega: float,
    plan: Plan,
    places: Float[Array, "k 2"],
    level: float,
    rise: Float[Array, " 2"],
    left: float | None = None,
) -> Float[Array, " 3"]:
    """Return the acceleration of the centre of mass that is wanted [m/s²].

    The centre of pressure goes where it stops what the divergent component is off; it is asked for
    outside of what touches, too, as far as :data:`BEYOND`.

    Args:
        body: The person now.
        ref: The recording at the phase of the gait.
        rate: Of the phase.
        omega: Root of gravity by height [1/s].
        plan: What the divergent component is off, and how far the feet are beside the recording.
        places: What touches [m].
        level: Height of the ground around [m].
        rise: How far it rises along x and y, by distance.
        left: In what time the swinging foot lands [s]; none does if absent.
    """
    shift = plan.shift[:2] + plan.beside
    moved = shift + (1.0 + FIRM / omega) * plan.error
    if len(places):
        far, pressure = BEYOND * plan.leg, ref.cop[:2]
        nominal = pressure + shift
        low = np.minimum(places.min(axis=0) - far, nominal)
        high = np.maximum(places.max(axis=0) + far, nominal)
        moved = np.minimum(np.maximum(pressure + moved, low), high) - pressure
    c, v = body.com, body.com_velocity
    wanted = np.array(ref.com_acceleration)
    wanted[:2] += omega**2 * ((c - ref.com)[:2] - moved)
    k, time = VERTICAL
    rate = min(rate, 1.0)
    off = ref.com[2] + level - plan.bent - c[2]
    pace = rate * ref.com_velocity[2] + rise @ v[:2] + k * off
    own = rate**2 * ref.com_acceleration[2]
    sinks, down = SINKS, BACK[0]
    if left is not None and plan.bent > 0.0:
        left = max(left, SOONEST)
        needs = 2.0 * (max(off, -plan.bent) - v[2] * left) / left**2
        down = min(max(needs, FASTEST), down)
        sinks = min(sinks, down)
    back = min(max((pace - v[2]) / time, down), BACK[1])
    wanted[2] = min(max(own + back, min(own, sinks)), max(own, RISES))
    return wanted


def place_rows(J, bias, speed, error, velocity, acceleration) -> Rows:
    """Return rows that lead a point."""
    size = sqrt(error @ error)
    error = error * min(1.0, TaskSettings.max_foot_error / max(size, 1e-9))
    wanted = velocity + PLACE[0] * error
    return Rows(J, acceleration + (wanted - speed) / PLACE[1] - bias, SWING**2)


def turn_rows(J, bias, spin, error, velocity, acceleration, normal=None) -> Rows:
    """Return rows that turn a foot; one that stands is left to its own heading."""
    right = acceleration + (velocity + TURN[0] * error - spin) / TURN[1] - bias
    if normal is None:
        return Rows(J, right, SWING_TURN**2)
    across = _ONE - normal[:, None] * normal
    return Rows(across @ J, across @ right, STANCE_TURN**2)


def held_rows(points: RigidPoints, held, gap, normal) -> PointRows:
    """Return rows that bring points to rest on the ground."""
    right = points.velocity / -STILL - points.bias
    right -= (10.0 / STILL) * np.maximum(gap, 0.0)[:, None] * normal
    return PointRows(points, held, right, HELD**2)


def tilted(normal: Array) -> Array:
    """Return the shortest rotation of the vertical to a normal of the ground."""
    return _tilted(*normal.tolist())


@lru_cache(maxsize=16)
def _tilted(x: float, y: float, z: float) -> Array:
    k = 1.0 / (1.0 + z)
    xx, xy, yy = k * x * x, k * x * y, k * y * y
    return np.array([[1.0 - xx, -xy, x], [-xy, 1.0 - yy, y], [-x, -y, z]])
