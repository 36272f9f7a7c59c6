"""The motors of many worlds of one person, commanded together: for learners."""

from collections.abc import Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.world.world import World


class Together:
    """What :class:`~plantigrade.world.StablePD` does in each world, in a tenth of the time.

    Args:
        worlds: The worlds, all made alike, without ``exact_limits`` and ``torque_rise``.
    """

    def __init__(self, worlds: Sequence[World]):
        first = worlds[0]
        self._own, self._step = first.actuators, float(first.model.opt.timestep)
        self._worlds, n = worlds, len(first.human.coordinates)
        hinges = self._own.sagittal
        # MuJoCo's arrays stay where they are.
        self._rows = [
            (
                w.data.ctrl[:n],
                w.model.actuator_biasprm[:n],
                w.model.dof_armature[6 : 6 + n],
                w.model.jnt_stiffness[1 : 1 + n],
                w.model.qpos_spring[7 : 7 + n],
                w.data.qfrc_applied[6 : 6 + n],
            )
            for w in worlds
        ]
        self._hinges = hinges

    def command(
        self,
        angles: Float[Array, "n n_hinges"],
        force: Float[Array, "n n_hinges"],
        stiffness: Float[Array, "n n_hinges"],
        damping: Float[Array, "n n_hinges"],
    ) -> None:
        """Let stable PD act in all worlds from now on, as ``World.advance`` would.

        Args:
            angles: Where the hinges are now [rad].
            force: Stiffness times target, and damping times the wanted rate [N m].
            stiffness: Of the hinges [N m/rad].
            damping: Likewise [N m s/rad].
        """
        h, own, hinges = self._step, self._own, self._hinges
        damping = damping + h * stiffness
        bias = np.stack([-stiffness, -damping], axis=-1)
        springs = np.broadcast_to(own.springs, stiffness.shape)
        if len(hinges):
            q, moments, stiff = own.tangents(angles)
            springs = springs.copy()
            springs[:, hinges] = stiff
        armature = own.armature + h * (own.loose + h * springs) + h * damping
        for i, (ctrl, law, inertia, spring, rest, applied) in enumerate(self._rows):
            ctrl[:], law[:, 1:3], inertia[:] = force[i], bias[i], armature[i]
            if len(hinges):
                spring[hinges], rest[hinges], applied[hinges] = stiff[i], q[i], moments[i]
