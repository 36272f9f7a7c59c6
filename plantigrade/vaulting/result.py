"""A contact phase as a Record: an ordinary Human, forces at the hands, the table as a seat."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground, Seat
from plantigrade.contact.site import contact_sites
from plantigrade.dynamics.centroid import without_constraints
from plantigrade.motion import Motion
from plantigrade.record import Record
from plantigrade.record.record import Limits
from plantigrade.vaulting.segments import JOINTS, NAMES, ROOT
from plantigrade.vaulting.simulation import Contact, Vault
from plantigrade.vaulting.strength import LENGTHENING

ENDS = (-0.4, 0.4)
"""Where the drawn table is held along x; it reaches 0.2 m beyond [m]."""


@dataclass(frozen=True, eq=False)
class Vaulted:
    """One contact phase of a gymnast, in full coordinates.

    Attributes:
        vault: Who arrived at what, and how.
        contact: What happened.
    """

    vault: Vault
    contact: Contact

    @cached_property
    def coordinates(
        self,
    ) -> tuple[Float[Array, "n 8"], Float[Array, "n 8"], Float[Array, "n 8"]]:
        """Root and joints of the six segments, their rates and accelerations; fixed ones too."""
        moving, n = list(self.vault.segments.moving), self.vault.equations.n
        size = len(self.contact.time), len(ROOT) + len(NAMES)
        theta = np.tile(np.r_[0.0, 0.0, self.vault.approach.posture], (size[0], 1))
        rate, acceleration = np.zeros(size), np.zeros(size)
        state = self.contact.state
        theta[:, moving], rate[:, moving] = state[:, :n], state[:, n : 2 * n]
        acceleration[:, moving] = self._of_state("acceleration")
        return theta, rate, acceleration

    @cached_property
    def torque(self) -> Float[Array, "n 5"]:
        """Torque of the muscles of each joint, both limbs, positive as its coordinate [N m]."""
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
        """Kinetic and potential energy as MuJoCo computes them, of the whole body [J]."""
        return self._swept[0]

    @property
    def energy_error(self) -> float:
        """Greatest difference of energy from the work done, as part of its greatest change.

        Work is integrated beside the motion from torques and forces; energy is MuJoCo's, of the
        whole Human, and knows nothing of either.
        """
        work = self.contact.state[:, -1]
        off = self.energy - self.energy[0] - (work - work[0])
        return float(np.abs(off).max() / np.ptp(work))

    @cached_property
    def _swept(self) -> tuple[Array, Array, Array]:
        """Energy, generalised forces without those at the hands, and where the hands press."""
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
            pushed = np.zeros(model.nv)
            for k, site in enumerate(sites):
                body = human.body(site.body)
                place = data.xmat[body].reshape(3, 3) @ np.array(site.position)
                point[f, k] = data.xpos[body] + place
                mujoco.mj_applyFT(model, data, force[f, k], np.zeros(3), point[f, k], body, pushed)
            tau[f] -= pushed
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
        """Torques that muscles can have: of those that are lengthened more than the Human's own."""
        human = self.vault.segments.human
        own = np.array(human.model.jnt_actfrcrange[1:]).T
        return Limits(torque=own * np.where(self._driven, LENGTHENING, np.inf))

    @cached_property
    def _driven(self) -> Array:
        """Which hinges the model drives, not holds."""
        coordinates = self.vault.segments.human.coordinates
        joints = [JOINTS[i] for i in self.vault.segments.joints]
        return np.array([name[:-2] in joints for name in coordinates])

    @property
    def held(self) -> tuple[str, float]:
        """The held joint that needs most of its strength, and how much [%].

        The report's segments are rigid, however strong the neck, the back or the wrist must be.
        """
        human = self.vault.segments.human
        low, high = np.array(human.model.jnt_actfrcrange[1:]).T
        tau = self._swept[1][:, 6:]
        share = np.where(self._driven, 0.0, tau / np.where(tau > 0, high, low)).max(axis=0)
        worst = int(np.argmax(share))
        return human.coordinates[worst], 100.0 * float(share[worst])

    @property
    def angles(self) -> Float[Array, "n 6"]:
        """Trunk above the horizontal and the five joints as angles between segments [rad]."""
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
        """Return how fast the whole body turns forward [rad/s].

        It is its angular momentum about the centre of mass over the moment of inertia that it has
        in this posture.
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
        """Return the Record, with other motions of the gymnast beside it."""
        segments, table = self.vault.segments, self.vault.table
        hands, feet = segments.sites(), contact_sites(segments.human)
        n, free = self.motion.n_frames, len(feet)
        force = np.concatenate([self.force, np.zeros((n, free, 3))], axis=1)
        point = np.concatenate([self._swept[2], np.full((n, free, 3), np.nan)], axis=1)
        point[~force.any(axis=2)] = np.nan
        top = table.table_height
        places = zip(hands, self._swept[2][0, :, 1], strict=True)
        seats = tuple(Seat(site.name, (0.0, float(y), top)) for site, y in places)
        seats += tuple(Seat("table", (x, 0.0, top)) for x in ENDS)
        return Record(
            segments.human,
            self.motion,
            qfrc_actuator=self._swept[1],
            sites=(*hands, *feet),
            contact_force=force,
            contact_point=point,
            ground=Ground(seats=seats, friction=table.grip),
            limits=self.limits,
            signals={
                "vault.joints": np.array(NAMES),
                "vault.activation": self.contact.activation,
            },
            references=dict(references or {}),
        )


def angular_difference(one: Vaulted, other: Vaulted) -> float:
    """Return by how much the angles of two vaults differ on average [% of the mean angle].

    They are compared at equal parts of the contact. The report held its model against a measured
    vault in this way and found 4.10 %, but does not say what its percent are of; here they are of
    the mean angle of trunk and joints of the first vault.
    """
    share = np.linspace(0.0, 1.0, 101)
    curves = []
    for each in (one, other):
        time = each.contact.time / each.contact.time[-1]
        curves.append(np.array([np.interp(share, time, column) for column in each.angles.T]))
    return float(100.0 * np.abs(curves[1] - curves[0]).mean() / np.abs(curves[0]).mean())
