"""A first guess whose hands are where their supports are, by inverse kinematics of the arms."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.batched import BatchedFunction
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import ContactSite
from plantigrade.trajopt.guess.postures import smooth_step
from plantigrade.trajopt.problem.contact_body import ContactBody

ARM_COORDINATES = ("arm_flex", "arm_add", "arm_rot", "elbow_flex", "pro_sup", "wrist_flex")
BENT_ELBOW = float(np.deg2rad(45.0))  # [rad] elbow to start from; a straight arm is singular
REACHING_TIME = 0.5  # [s] from hanging to the support, and back
MAX_STEP = 0.3  # [rad] largest change of an angle in an iteration
ITERATIONS = 40
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
            side = support.site.name[-1]
            columns = [
                6 + body.human.hinge(f"{name}_{side}")
                for name in ARM_COORDINATES
                if f"{name}_{side}" in body.human.coordinates
            ]
            if support.site.part != "hand" or not columns:
                continue
            early, late = support.start - times, times - support.stop
            share = smooth_step(1.0 - np.maximum(np.maximum(early, late), 0.0) / REACHING_TIME)
            near = share > 0.0
            there = _reached(body, support.site, q[near], columns, np.array(support.position))
            q[near] += share[near, None] * (there - q[near])
        return q


def _reached(
    body: ContactBody,
    site: ContactSite,
    q: Float[Array, "n nv"],
    columns: list[int],
    place: Float[Array, " 3"],
) -> Float[Array, "n nv"]:
    """Return coordinates with an arm whose site is as near to a place as limits allow."""
    at = BatchedFunction(body.symbolic.positions([site]))
    low, high = body.human.limits[:, [c - 6 for c in columns]]
    q = q.copy()
    q[:, columns[3]] = np.maximum(q[:, columns[3]], BENT_ELBOW)

    def where(x: Array) -> Array:
        return at(x)[0].reshape(len(x), 3)

    for _ in range(ITERATIONS):
        here = where(q)
        J = np.zeros((len(q), 3, len(columns)))
        for i, column in enumerate(columns):
            moved = q.copy()
            moved[:, column] += _DIFFERENCE
            J[:, :, i] = (where(moved) - here) / _DIFFERENCE
        A = J @ J.swapaxes(1, 2) + _DAMPING * np.eye(3)
        step = (J.swapaxes(1, 2) @ np.linalg.solve(A, (place - here)[..., None]))[..., 0]
        q[:, columns] = np.clip(q[:, columns] + np.clip(step, -MAX_STEP, MAX_STEP), low, high)
    return q
