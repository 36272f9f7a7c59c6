"""Contact phase of a vault as a Record: a Human, hand forces and the table as a seat."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground, Seat
from plantigrade.contact.site import contact_sites
from plantigrade.dynamics.centroid import without_constraints
from plantigrade.dynamics.muscle_speed import MAX_ECCENTRIC_FACTOR
from plantigrade.motion import Motion
from plantigrade.motion.filters import interpolate
from plantigrade.record import Record
from plantigrade.record.record import Limits
from plantigrade.vaulting.hand_contact import HandContact, Vault
from plantigrade.vaulting.segments import COORDINATES, JOINT_NAMES, ROOT_COORDINATES

TABLE_SUPPORTS = (-0.4, 0.4)
"""Positions of the drawn table's supports along x [m]; the table extends 0.2 m beyond."""


@dataclass(frozen=True, eq=False)
class VaultResult:
    """One contact phase of a gymnast, in full coordinates."""

    vault: Vault  #: The gymnast, the table and the approach
    contact: HandContact  #: The hand contact

    @cached_property
    def coordinates(self) -> tuple[Float[Array, "n 8"], Float[Array, "n 8"], Float[Array, "n 8"]]:
        """Root and joint coordinates of the six segments with rates and accelerations."""
        moving, n = list(self.vault.segments.moving), self.vault.equations.n
        size = len(self.contact.time), len(ROOT_COORDINATES) + len(JOINT_NAMES)
        theta = np.tile(np.r_[0.0, 0.0, self.vault.approach.posture], (size[0], 1))
        rate, acceleration = np.zeros(size), np.zeros(size)
        state = self.contact.state
        theta[:, moving], rate[:, moving] = state[:, :n], state[:, n : 2 * n]
        acceleration[:, moving] = self._of_state("acceleration")
        return theta, rate, acceleration

    @cached_property
    def torque(self) -> Float[Array, "n 5"]:
        """Muscle torque of each joint, both limbs, positive as its coordinate [N m]."""
        return self._of_state("torque")

    def _of_state(self, name: str) -> Array:
        n, contact = self.vault.equations.n, self.contact
        of = self.vault.equations.function(name).map(len(contact.time))
        state = contact.state.T
        return of(state[:n], state[n : 2 * n], contact.activation.T).full().T

    @cached_property
    def motion(self) -> Motion:
        """The motion of the whole Human."""
        qpos, qvel, qacc = self.vault.segments.whole(*self.coordinates)
        human = self.vault.segments.human
        return Motion(self.contact.time, qpos, qvel, human.joint_names, qacc=qacc)

    @cached_property
    def energy(self) -> Float[Array, " n"]:
        """Kinetic plus potential energy of the whole body from MuJoCo [J]."""
        return self._inverse_dynamics[0]

    @property
    def energy_error(self) -> float:
        """Maximum difference of energy and work relative to the range of the work [1].

        The work is integrated from torques and forces; MuJoCo computes the energy of the whole
        Human independently.
        """
        work = self.contact.state[:, -1]
        error = self.energy - self.energy[0] - (work - work[0])
        return float(np.abs(error).max() / np.ptp(work))

    @cached_property
    def _inverse_dynamics(self) -> tuple[Array, Array, Array]:
        """Energy, generalised forces without those at the hands, and points of hand contact."""
        human, motion = self.vault.segments.human, self.motion
        model = without_constraints(human)
        data = mujoco.MjData(model)
        sites = self.vault.segments.sites()
        n = motion.n_frames
        energy, tau = np.empty(n), np.empty((n, model.nv))
        point = np.empty((n, len(sites), 3))
        force = self.force
        qacc = motion.qacc
        assert qacc is not None
        for f in range(n):
            data.qpos[:], data.qvel[:] = motion.qpos[f], motion.qvel[f]
            data.qacc[:] = qacc[f]
            mujoco.mj_inverse(model, data)
            mujoco.mj_energyPos(model, data)
            mujoco.mj_energyVel(model, data)
            energy[f], tau[f] = data.energy.sum(), data.qfrc_inverse
            hand_forces = np.zeros(model.nv)
            for k, site in enumerate(sites):
                body = human.body(site.body)
                place = data.xmat[body].reshape(3, 3) @ np.array(site.position)
                point[f, k] = data.xpos[body] + place
                mujoco.mj_applyFT(
                    model, data, force[f, k], np.zeros(3), point[f, k], body, hand_forces
                )
            tau[f] -= hand_forces
        return energy, tau, point

    @cached_property
    def force(self) -> Float[Array, "n 2 3"]:
        """Force on each hand, world [N]."""
        both = self.contact.extras[:, :2]
        each = np.zeros((len(both), 2, 3))
        each[:, :, 0], each[:, :, 2] = 0.5 * both[:, :1], 0.5 * both[:, 1:]
        return each

    @property
    def limits(self) -> Limits:
        """Torque limits with the eccentric factor for driven joints, none for fixed ones."""
        human = self.vault.segments.human
        own = np.array(human.model.jnt_actfrcrange[1:]).T
        return Limits(torque=own * np.where(self._driven, MAX_ECCENTRIC_FACTOR, np.inf))

    @cached_property
    def _driven(self) -> Array:
        """Mask of the hinges driven by the model; the others are fixed."""
        coordinates = self.vault.segments.human.coordinates
        joints = [COORDINATES[i] for i in self.vault.segments.joints]
        return np.array([name[:-2] in joints for name in coordinates])

    @property
    def most_loaded_fixed_joint(self) -> tuple[str, float]:
        """Fixed joint with the highest load, and its load relative to its strength [%].

        The report's segments are rigid whatever loads neck, back and wrist would carry.
        """
        human = self.vault.segments.human
        low, high = np.array(human.model.jnt_actfrcrange[1:]).T
        tau = self._inverse_dynamics[1][:, 6:]
        share = np.where(self._driven, 0.0, tau / np.where(tau > 0, high, low)).max(axis=0)
        worst = int(np.argmax(share))
        return human.coordinates[worst], 100.0 * float(share[worst])

    @property
    def angles(self) -> Float[Array, "n 6"]:
        """Trunk angle above the horizontal and the five angles between segments [rad]."""
        theta = self.coordinates[0]
        pi = np.pi
        return np.column_stack(
            [
                -theta[:, 2] - pi / 2,
                theta[:, 3],
                pi - theta[:, 4],
                pi - theta[:, 5],
                pi - theta[:, 6],
                pi / 2 - theta[:, 7],
            ]
        )

    def somersault(self, frame: int) -> float:
        """Return the forward angular velocity of the whole body [rad/s].

        It is the angular momentum about the centre of mass divided by the moment of inertia of the
        posture.
        """
        human, motion = self.vault.segments.human, self.motion
        data = mujoco.MjData(human.model)
        momentum = []
        rigid = np.zeros(human.model.nv)
        rigid[4] = 1.0  # about the left-right axis, forward
        for qvel in (motion.qvel[frame], rigid):
            data.qpos[:], data.qvel[:] = motion.qpos[frame], qvel
            mujoco.mj_fwdPosition(human.model, data)
            mujoco.mj_fwdVelocity(human.model, data)
            mujoco.mj_subtreeVel(human.model, data)
            momentum.append(data.subtree_angmom[1][1])
        return float(momentum[0] / momentum[1])

    def record(self, references: Mapping[str, Motion] | None = None) -> Record:
        """Return the Record, with reference motions of the gymnast."""
        segments, table = self.vault.segments, self.vault.table
        hands, feet = segments.sites(), contact_sites(segments.human)
        n, free = self.motion.n_frames, len(feet)
        force = np.concatenate([self.force, np.zeros((n, free, 3))], axis=1)
        point = np.concatenate([self._inverse_dynamics[2], np.full((n, free, 3), np.nan)], axis=1)
        point[~force.any(axis=2)] = np.nan
        top = table.table_height
        places = zip(hands, self._inverse_dynamics[2][0, :, 1], strict=True)
        seats = tuple(Seat(site.name, (0.0, float(y), top)) for site, y in places)
        seats += tuple(Seat("table", (x, 0.0, top)) for x in TABLE_SUPPORTS)
        return Record(
            segments.human,
            self.motion,
            qfrc_actuator=self._inverse_dynamics[1],
            sites=(*hands, *feet),
            contact_force=force,
            contact_point=point,
            ground=Ground(seats=seats, friction=table.grip),
            limits=self.limits,
            signals={
                "vault.joints": np.array(JOINT_NAMES),
                "vault.activation": self.contact.activation,
            },
            references=dict(references or {}),
        )


def angular_difference(one: VaultResult, other: VaultResult) -> float:
    """Return the mean difference of the angles of two vaults [% of the first one's mean angle].

    Both are compared over normalised contact time. The report compared its model with a measured
    vault in this way and found 4.10 %, without stating the reference of its percentage.
    """
    share = np.linspace(0.0, 1.0, 101)
    curves = []
    for each in (one, other):
        time = each.contact.time / each.contact.time[-1]
        curves.append(interpolate(share, time, each.angles))
    return float(100.0 * np.abs(curves[1] - curves[0]).mean() / np.abs(curves[0]).mean())
