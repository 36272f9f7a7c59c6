r"""Ground reactions estimated from a recorded gait, and paths that are consistent with them.

No measured force is used. The ground reactions are estimated from the recorded motion
(:mod:`plantigrade.dynamics.ground_forces`); they are smooth and differ slightly from the net wrench
of the motion, mostly by its noise. The estimated forces and the recorded path would therefore
contradict each other. With the residual :math:`r`, estimated minus required force per mass, the
centre of mass is displaced by :math:`\delta`,

.. math:: \min_\delta \int \frac{|\ddot\delta - r|^2}{s_a^2} + \frac{|\delta|^2}{s_\delta^2} dt ,

and the angular momentum likewise by the rate of a :math:`\delta`. Residuals longer than about a
second change the forces, shorter ones the path. For a very noisy motion the forces get less weight,
through a smaller :math:`s_\delta`.

The estimate also includes the offset between the true centre of mass and the model's. Trunks differ
most between people, and markers show little of their mass, so the trunk's centre of mass is moved
until the whole body's agrees (:meth:`plantigrade.models.Human.with_trunk_mass`).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solveh_banded

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.intervals import ContactInterval, grouped
from plantigrade.dynamics.centroid import centroid
from plantigrade.dynamics.ground_forces import GroundForces, estimate_forces
from plantigrade.dynamics.loading import EARLY_LOAD, LATE_LOAD
from plantigrade.kinematics.state import sweep
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.ordered_tasks.gait_reference import GaitReference


@dataclass(frozen=True, kw_only=True)
class SupportSettings:
    """Trade-off between the recorded path and the estimated forces."""

    acceleration_scale: float = 0.02
    r""":math:`s_a` of the centre of mass [g]. Chosen."""
    displacement_scale: float = 0.003
    r""":math:`s_\delta` of the centre of mass [m]. Chosen."""
    moment_scale: float = 0.01
    r""":math:`s_a` of the angular momentum [body weights m]. Chosen."""
    turn_scale: float = 0.01
    r""":math:`s_\delta` of the angular momentum [kg m² per kg of body mass]. Chosen."""
    max_noise: float = 3.0
    """Noise of the estimate above which the displacement of the path is reduced. Chosen."""
    max_trunk_shift: float = 0.12
    """Maximum displacement of the trunk's centre of mass [m]. Chosen."""
    max_contact_gap: float = 0.02
    """Maximum gap between contacts of one foot that are merged [s]. Chosen."""
    end_margin: float = 0.03
    """Time from an end of the recording within which a stance counts as incomplete [s]. Chosen."""


@dataclass(frozen=True)
class GaitSupport:
    """Ground reactions of a recorded gait and paths consistent with them."""

    #: The recorded gait of the person with the corrected centre of mass of the trunk
    reference: GaitReference
    estimate: GroundForces  #: Estimated ground reactions at the frames of the recorded motion
    #: Wrench of both feet, r then l: force [N] and moment about the world's origin [N m]
    wrench: Trajectory
    com: Trajectory  #: Path of the centre of mass consistent with the forces [m]
    momentum: Trajectory  #: Angular momentum about the centre of mass [kg m²/s]
    turn: Trajectory  #: Time integral of the added angular momentum [kg m²]

    def wrench_at(self, time: float) -> Float[Array, "2 6"]:
        """Return force [N] and moment about the world's origin [N m] of both feet, r then l."""
        return self.wrench(time)[0].reshape(2, 6)


def gait_support(reference: GaitReference, settings: SupportSettings | None = None) -> GaitSupport:
    """Return the ground reactions of a recorded gait and the consistent paths.

    Raises:
        SolverError: If the estimation of forces fails.
    """
    s = settings or SupportSettings()
    reference = with_recorded_heel_rise(reference)
    motion, time = reference.motion, reference.motion.time
    estimate = estimate_forces(reference.human, motion, contacts=load_intervals(reference, s))
    reference = with_shifted_com(reference, estimate.com_shift, s.max_trunk_shift)
    human, forces = reference.human, estimate.forces
    point = np.nan_to_num(forces.point)
    moment = np.cross(point, forces.force) + forces.torque
    whole = centroid(human, motion.qpos, motion.qvel, motion.qacc)
    assert whole.force is not None and whole.moment is not None
    net_force = forces.force.sum(axis=1)
    inside = (time >= reference.start - s.end_margin) & (time <= reference.stop + s.end_margin)
    estimated = (inside & (net_force[:, 2] > 0))[:, None]
    residual = np.where(estimated, net_force - whole.force, 0.0) / human.mass
    trust = min(1.0, (s.max_noise / estimate.noise) ** 2)
    com = whole.com + consistent_displacement(
        time, residual, s.acceleration_scale * GRAVITY, trust * s.displacement_scale
    )
    net_moment = moment.sum(axis=1) - np.cross(com, net_force)
    residual = np.where(estimated, net_moment - whole.moment, 0.0) / human.mass
    turn = human.mass * consistent_displacement(
        time, residual, s.moment_scale * GRAVITY, trust * s.turn_scale
    )
    turn_rates = rates(time, turn)
    momentum = whole.angular_momentum + turn_rates[:, 1]
    # the remaining residual is distributed to the feet in proportion to their load
    load = np.where(estimated[..., None], forces.force[..., 2:], 0.0)
    share = load / np.maximum(net_force[:, None, 2:], 1.0)
    force = human.mass * (rates(time, com)[:, 2] + [0.0, 0.0, GRAVITY])
    net_moment = np.cross(com, force) + whole.moment + turn_rates[:, 2]
    force = forces.force + share * (force - net_force)[:, None]
    moment = moment + share * (net_moment - moment.sum(axis=1))[:, None]
    return GaitSupport(
        reference,
        estimate,
        Trajectory(time, np.concatenate([force, moment], axis=2).reshape(len(time), 12)),
        Trajectory(time, com),
        Trajectory(time, momentum),
        Trajectory(time, turn),
    )


def with_recorded_heel_rise(reference: GaitReference) -> GaitReference:
    """Return the gait with contacts of heels and balls ending at the recorded rise.

    A region that begins to rise is too slow for detection by speed: when its contact ends, a heel
    is two centimetres up and rises at 0.3 m/s. A ball fixed for 60 ms too long rotated the ankle by
    31° too much. Toes keep their contact until the foot leaves.
    """
    pairs = zip(reference.contacts, reference.held, strict=True)
    contacts = [short if short.region in ("heel", "ball") else full for full, short in pairs]
    return replace(reference, contacts=tuple(contacts))


def load_intervals(
    reference: GaitReference, settings: SupportSettings
) -> tuple[ContactInterval, ...]:
    """Return the intervals from first to last contact in which each foot may carry load."""
    first, last = float(reference.motion.time[0]), float(reference.motion.time[-1])
    margin, intervals = settings.end_margin, []
    for side in SIDES:
        mine = [c for c in reference.contacts if c.side == side]
        for group in grouped(mine, settings.max_contact_gap):
            a, b = group[0].start, max(c.stop for c in group)
            start, stop = max(first, a - EARLY_LOAD), min(last, b + LATE_LOAD)
            begins, ends = bool(a > first + margin), bool(b < last - margin)
            intervals.append(ContactInterval(side, "foot", float(start), float(stop), begins, ends))
    return tuple(intervals)


def with_shifted_com(
    reference: GaitReference,
    shift: Float[Array, " 3"],
    max_shift: float = SupportSettings.max_trunk_shift,
) -> GaitReference:
    """Return the gait with the whole-body centre of mass shifted by ``shift`` [m]."""
    human, qpos = reference.human, reference.motion.qpos
    body = human.body(human.trunk)
    turned = np.mean([state.rotation(body) for state in sweep(human, qpos[::10])], axis=0)
    share = human.model.body_mass[body] / human.model.body_mass.sum()
    local = turned.T @ shift / share
    size = float(np.linalg.norm(local))
    human = human.with_trunk_mass(local * min(1.0, max_shift / max(size, 1e-9)))
    path = np.array([state.com for state in sweep(human, qpos)])
    return replace(reference, human=human, com=Trajectory(reference.motion.time, path))


def rates(time: Float[Array, " n"], path: Float[Array, "n k"]) -> Float[Array, "n 3 k"]:
    """Return value, first and second derivative of a path."""
    along = Trajectory(time, path)
    return np.array([along(float(t)) for t in time])


def consistent_displacement(
    time: Float[Array, " n"],
    acceleration: Float[Array, "n k"],
    acceleration_scale: float,
    displacement_scale: float,
) -> Float[Array, "n k"]:
    r"""Return the displacement :math:`\delta` of this module.

    Args:
        time: Evenly spaced times [s].
        acceleration: Residual :math:`r`, the desired second derivative.
        acceleration_scale: Scale :math:`s_a` of the acceleration error.
        displacement_scale: Scale :math:`s_\delta` of the displacement.
    """
    n = len(time)
    if n < 3:
        return np.zeros_like(acceleration)
    h2 = ((time[-1] - time[0]) / (n - 1)) ** 2
    # D' D of the second differences D, by diagonals, and its transpose on the right
    band = np.zeros((3, n))
    for first, a in enumerate((1.0, -2.0, 1.0)):
        for second, b in enumerate((1.0, -2.0, 1.0)[first:], start=first):
            band[2 - (second - first), second : n - 2 + second] += a * b
    band /= (h2 * acceleration_scale) ** 2
    band[2] += 1.0 / displacement_scale**2
    right = np.zeros_like(acceleration)
    for first, a in enumerate((1.0, -2.0, 1.0)):
        right[first : n - 2 + first] += a * acceleration[1:-1]
    return solveh_banded(band, right / (h2 * acceleration_scale**2))
