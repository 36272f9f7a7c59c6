"""A first guess whose hands are where their supports are, by inverse kinematics of the arms."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.batched import BatchedFunction
from plantigrade.contact.limb_sites import HAND_PART, palm
from plantigrade.contact.plan import ContactPlan
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.motion.blends import quintic_rise
from plantigrade.spatial.conventions import PELVIS
from plantigrade.trajopt.problem.contact_body import ContactBody

ARM_COORDINATES = ("arm_flex", "arm_add", "arm_rot", "elbow_flex", "pro_sup", "wrist_flex")
BENT_ELBOW = float(np.deg2rad(45.0))  # [rad] elbow to start from; a straight arm is singular
REACHING_TIME = 0.5  # [s] from hanging to the support, and back
MAX_STEP = 0.3  # [rad] largest change of an angle in an iteration
ITERATIONS = 40  # of the inverse kinematics; it converges in about 15
_DAMPING = 1e-3  # [m²] of the least-squares step
_DIFFERENCE = 1e-6  # [rad] step of finite differences


@dataclass(frozen=True)
class HandsOnSupports:
    """A guess, changed so that arms reach for the supports of a plan."""

    guess: Callable[[ContactBody, ContactPlan, Array], Array]

    def __call__(
        self, body: ContactBody, plan: ContactPlan, times: Float[Array, " n_times"]
    ) -> Float[Array, "n_times nv"]:
        """Return coordinates at times."""
        q = self.guess(body, plan, times)
        for support in plan.supports:
            if support.site.part != HAND_PART:
                continue
            early, late = support.start - times, times - support.stop
            share = quintic_rise(1.0 - np.maximum(np.maximum(early, late), 0.0) / REACHING_TIME)
            near, at = share > 0.0, BatchedFunction(body.symbolic.positions([support.site]))
            there = reached(
                body.human,
                support.site.name[-1],
                q[near],
                support.places(times[near]),
                lambda x, at=at: at(x)[0].reshape(len(x), 3),
            )
            q[near] += share[near, None] * (there - q[near])
        return q


def palms(human: Human, q: Float[Array, "n nv"], side: str) -> Float[Array, "n 3"]:
    """Return where a palm is in postures, world [m]."""
    points = PointSet.of(human, [palm(human, side)])
    qpos = human.from_coordinates(PELVIS + human.coordinates, q)
    return np.stack([BodyState(human, x).position(points)[0] for x in qpos])


def reached(
    human: Human,
    side: str,
    q: Float[Array, "n nv"],
    place: Float[Array, "3"] | Float[Array, "n 3"],
    where: Callable[[Array], Array] | None = None,
) -> Float[Array, "n nv"]:
    """Return postures with the palm of an arm as near to a place as its limits allow.

    Args:
        side: ``"r"`` or ``"l"``.
        place: Where the palm shall be, world [m].
        where: Postures ↦ palms [m]; by MuJoCo if absent.
    """
    names = [f"{n}_{side}" for n in ARM_COORDINATES if f"{n}_{side}" in human.coordinates]
    columns = [6 + human.hinge(name) for name in names]
    low, high = human.limits[:, [c - 6 for c in columns]]
    at = where or (lambda x: palms(human, x, side))
    q = q.copy()
    elbow = 6 + human.hinge(f"elbow_flex_{side}")
    q[:, elbow] = np.maximum(q[:, elbow], BENT_ELBOW)
    for _ in range(ITERATIONS):
        here = at(q)
        J = np.zeros((len(q), 3, len(columns)))
        for i, column in enumerate(columns):
            moved = q.copy()
            moved[:, column] += _DIFFERENCE
            J[:, :, i] = (at(moved) - here) / _DIFFERENCE
        A = J @ J.swapaxes(1, 2) + _DAMPING * np.eye(3)
        step = (J.swapaxes(1, 2) @ np.linalg.solve(A, (place - here)[..., None]))[..., 0]
        q[:, columns] = np.clip(q[:, columns] + np.clip(step, -MAX_STEP, MAX_STEP), low, high)
    return q
