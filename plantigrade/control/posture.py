"""A body that is left alone, and one that holds its posture."""

import numpy as np
from scipy.optimize import nnls

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human
from plantigrade.world import Command, StablePD, State


def passive(state: State) -> Command:
    """Leave every joint to its passive moments."""
    return Command()


class Posture:
    """Springs and dampers that hold the joints where they are at the start.

    On the ground they also give the torques that the posture needs at rest, so that it does not
    sag. Nothing looks at balance: stiff ankles alone carry the body, as long as the centre of
    pressure stays under the soles.

    Args:
        stiffness: Of the springs, by what is usual: by the strength of a joint.
        qpos: The posture, feet on the ground; that of the first state if absent.
    """

    def __init__(self, stiffness: float = 1.0, qpos: Float[Array, " nq"] | None = None):
        self.stiffness, self.qpos = stiffness, qpos
        self._target: Float[Array, " n_hinges"] | None = None
        self._torque: Float[Array, " n_hinges"] | None = None

    def __call__(self, state: State) -> Command:
        """Hold the posture."""
        actuators = state.world.actuators
        if self._target is None or self._torque is None or state.time == 0.0:
            qpos = np.array(state.qpos if self.qpos is None else self.qpos)
            self._target = qpos[7:]
            self._torque = resting_torques(state.human, state.world.ground, qpos)
            self._torque -= actuators.resistance(self._target)
        return StablePD(
            self._target,
            torque=self._torque,
            stiffness=self.stiffness * actuators.stiffness,
            damping=self.stiffness * actuators.damping,
            signals={"posture_error": float(np.linalg.norm(state.angles - self._target))},
        )


def resting_torques(
    human: Human, ground: Ground, qpos: Float[Array, " nq"], *, near: float = 0.005
) -> Float[Array, " n_hinges"]:
    """Return the torques that hold a posture at rest on the ground [N m].

    Vertical forces of the spheres near the ground carry the weight, about the centre of mass if
    they can; no friction is needed.

    Args:
        human: The person.
        ground: What they stand on.
        qpos: The posture.
        near: What is no higher than this carries [m].
    """
    sites = contact_sites(human)
    body = BodyState(human, qpos)
    points = PointSet.of(human, sites)
    low = body.position(points) - np.array([[s.radius] for s in sites]) * ground.normal
    standing = low @ ground.normal - ground.under(low) < near
    gravity = human.mass * GRAVITY * body.com_jacobian[2]  # what holds the body up
    if not standing.any():
        return np.zeros(len(human.coordinates))
    J = body.jacobian(points)[standing, 2]  # of the heights
    weight = human.mass * GRAVITY
    # The forces that carry the weight at the centre of mass, as even as can be.
    place = (low[standing, :2] - body.com[:2]).T
    even = np.full(standing.sum(), 1e-3)
    rows = np.vstack([np.ones(len(even)), place / 0.05, np.diag(even)])
    share, _ = nnls(rows, np.r_[1.0, 0.0, 0.0, even / len(even)])
    force = weight * share / share.sum()
    return (gravity - J.T @ force)[6:]
