"""Passive joints, and a controller that holds a posture."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human
from plantigrade.world import Command, Controller, StablePD, State, Target, standing_on

CHANGING = 0.8
"""So long another posture takes to be reached [s]."""


class Passive(Controller):
    """Leaves every joint to its passive moments."""

    def __call__(self, state: State) -> Command:
        """Return no command."""
        return Command()


passive = Passive()
"""The one controller of its kind."""


@dataclass(frozen=True, eq=False)
class Held:
    """Angles of the hinges [rad], and torques that hold them [N m]."""

    angles: Float[Array, " n_hinges"]
    torque: Float[Array, " n_hinges"]

    def towards(self, other: "Held", share: float) -> "Held":
        """Return what lies between this and another."""
        return Held(
            (1 - share) * self.angles + share * other.angles,
            (1 - share) * self.torque + share * other.torque,
        )


class Posture(Controller):
    """Springs and dampers that hold the joints where they are at the start.

    On the ground they also give the torques that the posture needs at rest, so that it does not
    sag. Nothing looks at balance: stiff ankles alone carry the body, as long as the centre of
    pressure stays under the soles.

    Args:
        stiffness: Of the springs, by what is usual: by the strength of a joint.
        qpos: The posture, feet on the ground; that of the first state if absent.

    Attributes:
        targets: The stiffness; where the person stands, how far knees and hips bend, too.
    """

    def __init__(self, stiffness: float = 1.0, qpos: Float[Array, " nq"] | None = None):
        self.qpos = qpos
        self._stiff = Target("stiffness", 0.0, max(3.0, stiffness), stiffness)
        self._bends = (
            Target("knees bent", 0.0, 60.0, 0.0, "deg"),
            Target("bowed", 0.0, 45.0, 0.0, "deg"),
        )
        self.targets = (self._stiff, *(() if qpos is None else self._bends))
        self._held: Held | None = None

    @property
    def stiffness(self) -> float:
        """Of the springs, by what is usual."""
        return self._stiff.value

    def __call__(self, state: State) -> Command:
        """Hold the posture."""
        actuators, held = state.world.actuators, self._now(state)
        return StablePD(
            held.angles,
            torque=held.torque,
            stiffness=self.stiffness * actuators.stiffness,
            damping=self.stiffness * actuators.damping,
            signals={"posture_error": float(np.linalg.norm(state.angles - held.angles))},
        )

    def _now(self, state: State) -> Held:
        """Return what is held now: smoothly from one posture to the next."""
        bends = tuple(target.value for target in self._bends)
        if self._held is None or state.time == 0.0:
            self._held = self._from = self._to = self._at(state, bends)
            self._since, self._bent = state.time, bends
        if bends != self._bent:
            self._from, self._to = self._held, self._at(state, bends)
            self._since, self._bent = state.time, bends
        if self._held is not self._to:
            u = min((state.time - self._since) / CHANGING, 1.0)
            share = u * u * (3 - 2 * u)
            self._held = self._to if u == 1.0 else self._from.towards(self._to, share)
        return self._held

    def _at(self, state: State, bends: tuple[float, ...]) -> Held:
        """Return the posture with knees and hips bent so far [deg], and its torques."""
        human, ground = state.human, state.world.ground
        qpos = np.array(state.qpos if self.qpos is None else self.qpos)
        knee, hip = np.deg2rad(bends)
        if knee or hip:
            half = knee / 2
            bent = {"knee_angle": knee, "hip_flexion": half + hip, "ankle_angle": half - hip}
            qpos = standing_on(human, ground, bent=bent)
        torque = resting_torques(human, ground, qpos) - state.world.actuators.resistance(qpos[7:])
        return Held(qpos[7:], torque)


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
