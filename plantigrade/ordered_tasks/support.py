r"""What carries a recorded gait: ground reactions estimated from its motion, and what they move.

No measured force enters. The ground reactions come from the recorded motion alone
(:mod:`plantigrade.dynamics.ground_forces`); they are smooth and they miss the net wrench that the
motion needs by a little, since what they leave out is mostly its noise. A body that is to be moved
by them and along its recorded path at once would fight itself. So the path gives way: with
:math:`r` what the forces have more than the motion needs, by mass, the centre of mass is displaced
by :math:`\delta`,

.. math:: \min_\delta \int \frac{|\ddot\delta - r|^2}{s_a^2} + \frac{|\delta|^2}{s_\delta^2} dt ,

and the angular momentum likewise by the rate of a :math:`\delta`. What lasts longer than about a
second stays with the forces, what is shorter is followed; where the estimate finds the motion very
noisy its forces are trusted less, and :math:`s_\delta` is smaller.

The estimate also tells where the true centre of mass lies from the model's. Trunks differ most,
and markers tell least of their mass: the trunk's centre of mass is moved by as much as puts
the whole body's there (:meth:`plantigrade.models.Human.with_trunk_mass`).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solveh_banded

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.dynamics.centroid import centroid
from plantigrade.dynamics.ground_forces import GroundForces, estimate_forces
from plantigrade.dynamics.load_intervals import EARLY, LATE, LoadInterval
from plantigrade.kinematics.state import sweep
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.ordered_tasks.reference import Reference


@dataclass(frozen=True, kw_only=True)
class SupportSettings:
    """How far the recorded path gives way to the estimated forces."""

    acceleration_scale: float = 0.02
    r""":math:`s_a` of the centre of mass [g]. Chosen."""
    displacement_scale: float = 0.003
    r""":math:`s_\delta` of the centre of mass [m]. Chosen."""
    moment_scale: float = 0.01
    r""":math:`s_a` of the angular momentum [body weights m]. Chosen."""
    turn_scale: float = 0.01
    r""":math:`s_\delta` of the angular momentum [kg m² per kg of body mass]. Chosen."""
    max_noise: float = 3.0
    """Noise of the estimate above which a path gives way less. Chosen."""
    max_trunk_shift: float = 0.12
    """Greatest displacement of the trunk's centre of mass [m]. Chosen."""
    max_contact_gap: float = 0.02
    """Time between contacts of one foot up to which they are one [s]. Chosen."""
    end_margin: float = 0.03
    """Time from an end of the recording within which a stance was not seen whole [s]. Chosen."""


@dataclass(frozen=True)
class Support:
    """What carries a recorded gait.

    Attributes:
        reference: The recorded gait, on the person whose trunk's mass lies where the forces say.
        estimate: The ground reactions, on the frames of the recorded motion.
        wrench: Those of both feet, r then l: force [N] and moment about the world's origin [N m].
        com: Path of the centre of mass that they carry [m].
        momentum: Its angular momentum [kg m²/s].
        turn: What the angular momentum has more than the recorded, integrated [kg m²].
    """

    reference: Reference
    estimate: GroundForces
    wrench: Trajectory
    com: Trajectory
    momentum: Trajectory
    turn: Trajectory

    def wrench_at(self, time: float) -> Float[Array, "2 6"]:
        """Return force [N] and moment about the world's origin [N m] of both feet, r then l."""
        return self.wrench(time)[0].reshape(2, 6)


def support_of(reference: Reference, settings: SupportSettings | None = None) -> Support:
    """Return what carries a recorded gait.

    Raises:
        SolverError: If the forces could not be estimated.
    """
    s = settings or SupportSettings()
    reference = rolled_off(reference)
    motion, time = reference.motion, reference.motion.time
    estimate = estimate_forces(reference.human, motion, contacts=load_intervals(reference, s))
    reference = with_shift(reference, estimate.com_shift, s.max_trunk_shift)
    human, forces = reference.human, estimate.forces
    point = np.nan_to_num(forces.point)
    moment = np.cross(point, forces.force) + forces.torque
    whole = centroid(human, motion.qpos, motion.qvel, motion.qacc)
    assert whole.force is not None and whole.moment is not None
    push = forces.force.sum(axis=1)
    inside = (time >= reference.start - s.end_margin) & (time <= reference.stop + s.end_margin)
    told = (inside & (push[:, 2] > 0))[:, None]
    missed = np.where(told, push - whole.force, 0.0) / human.mass
    trust = min(1.0, (s.max_noise / estimate.noise) ** 2)
    com = whole.com + displaced(
        time, missed, s.acceleration_scale * GRAVITY, trust * s.displacement_scale
    )
    about = moment.sum(axis=1) - np.cross(com, push)
    missed = np.where(told, about - whole.moment, 0.0) / human.mass
    turn = human.mass * displaced(time, missed, s.moment_scale * GRAVITY, trust * s.turn_scale)
    turning = rates(time, turn)
    momentum = whole.angular_momentum + turning[:, 1]
    # what is left, each foot takes by its load: then all of it belongs together
    load = np.where(told[..., None], forces.force[..., 2:], 0.0)
    share = load / np.maximum(push[:, None, 2:], 1.0)
    force = human.mass * (rates(time, com)[:, 2] + [0.0, 0.0, GRAVITY])
    about = np.cross(com, force) + whole.moment + turning[:, 2]
    force = forces.force + share * (force - push)[:, None]
    moment = moment + share * (about - moment.sum(axis=1))[:, None]
    return Support(
        reference,
        estimate,
        Trajectory(time, np.concatenate([force, moment], axis=2).reshape(len(time), 12)),
        Trajectory(time, com),
        Trajectory(time, momentum),
        Trajectory(time, turn),
    )


def rolled_off(reference: Reference) -> Reference:
    """Return the gait with heels and balls that leave the ground where the recorded ones do.

    A part that begins to rise is too slow to be seen moving: when its contact ends a heel is two
    centimetres up and rises at 0.3 m/s. A foot held until then would have to catch up in no time,
    and one whose ball is held for 60 ms too long turned the ankle by 31° too much. Toes carry
    until the foot leaves.
    """
    pairs = zip(reference.contacts, reference.held, strict=True)
    contacts = [held if held.region in ("heel", "ball") else contact for contact, held in pairs]
    return replace(reference, contacts=tuple(contacts))


def load_intervals(reference: Reference, settings: SupportSettings) -> tuple[LoadInterval, ...]:
    """Return when each foot may carry load: from its first part on the ground to its last."""
    first, last = float(reference.motion.time[0]), float(reference.motion.time[-1])
    found = []
    for side in SIDES:
        merged: list[list[float]] = []
        mine = [c for c in reference.contacts if c.side == side]
        for c in sorted(mine, key=lambda c: c.start):
            if merged and c.start <= merged[-1][1] + settings.max_contact_gap:
                merged[-1][1] = max(merged[-1][1], c.stop)
            else:
                merged.append([c.start, c.stop])
        for a, b in merged:
            start, stop = max(first, a - EARLY), min(last, b + LATE)
            margin = settings.end_margin
            begins, ends = bool(a > first + margin), bool(b < last - margin)
            found.append(LoadInterval(side, float(start), float(stop), begins, ends))
    return tuple(found)


def with_shift(
    reference: Reference,
    shift: Float[Array, " 3"],
    max_shift: float = SupportSettings.max_trunk_shift,
) -> Reference:
    """Return the gait of the person whose centre of mass lies elsewhere by ``shift`` [m]."""
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


def displaced(
    time: Float[Array, " n"], wanted: Float[Array, "n k"], push: float, away: float
) -> Float[Array, "n k"]:
    """Return the displacement of this module.

    Args:
        time: Evenly spaced [s].
        wanted: Its second derivative, as far as it can be had.
        push: Scale of what is missed of it.
        away: Scale of the displacement.
    """
    n = len(time)
    if n < 3:
        return np.zeros_like(wanted)
    h2 = ((time[-1] - time[0]) / (n - 1)) ** 2
    # D' D of the second differences D, by diagonals, and its transpose on the right
    band = np.zeros((3, n))
    for first, a in enumerate((1.0, -2.0, 1.0)):
        for second, b in enumerate((1.0, -2.0, 1.0)[first:], start=first):
            band[2 - (second - first), second : n - 2 + second] += a * b
    band /= (h2 * push) ** 2
    band[2] += 1.0 / away**2
    right = np.zeros_like(wanted)
    for first, a in enumerate((1.0, -2.0, 1.0)):
        right[first : n - 2 + first] += a * wanted[1:-1]
    return solveh_banded(band, right / (h2 * push**2))
