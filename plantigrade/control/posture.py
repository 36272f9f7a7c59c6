"""Passive joints, and a controller that holds a posture."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.control.gait.phase import FootContactSettings
from plantigrade.control.gait.step import StepSettings
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.motion.blends import cubic_rise
from plantigrade.world import Command, Controller, StablePD, State, Target, standing_on

EVENNESS = 1e-3  # weight of an even load: decides what the body weight leaves open


@dataclass(frozen=True, kw_only=True)
class PostureSettings:
    """Springs that hold a posture, and the torques it needs at rest."""

    stiffness: float = 1.0
    """Stiffness and damping of the springs; 1 is four times the joint's strength per radian."""
    transition_duration: float = 0.8
    """Time in which another posture is reached [s]. Chosen (±20 %: below 2 %)."""
    contact_height: float = FootContactSettings.max_planned_height
    """Height of a sphere above the ground up to which it carries load at rest [m]; as in
    walking."""
    cop_tolerance: float = StepSettings.sole_radius
    """Error of the centre of pressure that counts as much as the whole body weight [m]; with it
    the pressure would leave a sole."""


class Passive(Controller):
    """Leaves every joint to its passive moments."""

    def __call__(self, state: State) -> Command:
        """Return no command."""
        return Command()


passive = Passive()
"""The one controller of its kind."""


class Posture(Controller):
    """Springs and dampers that hold the joints where they are at the start.

    On the ground they also give the torques that the posture needs at rest, so that it does not
    sag. There is no feedback of balance: stiff ankles alone carry the body, as long as the centre
    of pressure stays under the soles.

    Args:
        qpos: The posture, feet on the ground; that of the first state if absent.
        settings: Stiffness of the springs, and how load is shared at rest.

    Attributes:
        targets: The stiffness; where the posture is given, also how far knees and hips bend.
    """

    def __init__(
        self, qpos: Float[Array, " nq"] | None = None, *, settings: PostureSettings | None = None
    ):
        self.qpos, self.settings = qpos, settings or PostureSettings()
        stiffness = self.settings.stiffness
        self._stiffness = Target("stiffness", 0.0, max(3.0, stiffness), stiffness)
        self._bends = (
            Target("knees flexion", 0.0, 60.0, 0.0, "deg"),
            Target("bowed", 0.0, 45.0, 0.0, "deg"),
        )
        self.targets = (self._stiffness, *(() if qpos is None else self._bends))
        self._held: Array | None = None

    def __call__(self, state: State) -> Command:
        """Hold the posture."""
        actuators, stiffness = state.world.actuators, self._stiffness.value
        angles, torque = self._now(state)
        return StablePD(
            angles,
            torque=torque,
            stiffness=stiffness * actuators.stiffness,
            damping=stiffness * actuators.damping,
            signals={"posture_error": float(np.linalg.norm(state.angles - angles))},
        )

    def _now(self, state: State) -> Float[Array, "2 n_hinges"]:
        """Return angles and torques now, which go smoothly from one posture to the next."""
        bends, held = tuple(target.value for target in self._bends), self._held
        if held is None or state.time == 0.0:
            held = self._from = self._to = self._at(state, bends)
            self._since, self._bent = state.time, bends
        if bends != self._bent:
            self._from, self._to = held, self._at(state, bends)
            self._since, self._bent = state.time, bends
        if held is not self._to:
            u = min((state.time - self._since) / self.settings.transition_duration, 1.0)
            share = cubic_rise(u)
            held = self._to if u == 1.0 else (1 - share) * self._from + share * self._to
        self._held = held
        return held

    def _at(self, state: State, bends: tuple[float, ...]) -> Float[Array, "2 n_hinges"]:
        """Return angles and torques of the posture with knees and hips bent by angles [deg]."""
        human, ground = state.human, state.world.ground
        qpos = np.array(state.qpos if self.qpos is None else self.qpos)
        knee, hip = np.deg2rad(bends)
        if knee or hip:
            half = knee / 2
            flexion = {"knee_angle": knee, "hip_flexion": half + hip, "ankle_angle": half - hip}
            qpos = standing_on(human, ground, flexion=flexion)
        torque = resting_torques(human, ground, qpos, self.settings)
        return np.stack([qpos[7:], torque - state.world.actuators.resistance(qpos[7:])])


def resting_torques(
    human: Human, ground: Ground, qpos: Float[Array, " nq"], settings: PostureSettings | None = None
) -> Float[Array, " n_hinges"]:
    """Return the torques that hold a posture at rest on the ground [N m].

    Vertical forces of the spheres near the ground carry the weight, about the centre of mass if
    they can, as even as can be; no friction is needed.
    """
    s, sites = settings or PostureSettings(), contact_sites(human)
    body = BodyState(human, qpos)
    points = PointSet.of(human, sites)
    low = body.position(points) - np.array([[site.radius] for site in sites]) * ground.normal
    loaded = ground.gap(low) < s.contact_height
    weight = human.mass * human.gravity
    if not loaded.any():
        return np.zeros(len(human.coordinates))
    offset = (low[loaded, :2] - body.com[:2]).T
    even = np.full(loaded.sum(), EVENNESS)
    rows = np.vstack([np.ones(len(even)), offset / s.cop_tolerance, np.diag(even)])
    share, _ = nnls(rows, np.r_[1.0, 0.0, 0.0, even / len(even)])
    force = weight * share / share.sum()
    J = body.jacobian(points)[loaded, 2]  # of the heights
    return (weight * body.com_jacobian[2] - J.T @ force)[6:]
