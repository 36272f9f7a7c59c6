r"""Limits of torque that hold for all of stable PD, its part within the step included.

With the armature :math:`a = h (k_d + h k_p)` of stable PD a motor gives
:math:`\tau = u - a \ddot q`, and :math:`\ddot q` is known only after the step: where a foot
strikes, it takes an ankle to more than twice its strength. The law of a motor with limits is

.. math:: \tau = \min(\max(u - a \ddot q,\ \tau_{min}),\ \tau_{max}) .

Its right-hand side falls with :math:`\ddot q`, so it has one solution with any contacts. It is
found by active sets: a motor beyond its limit gives the limit itself, without an armature, and the
step is done again; one whose law has come back within the limit gets its law back. The set of one
step is the guess for the next, so that a step is repeated only where a motor meets its limit or
leaves it.
"""

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float

TRIES = 8
"""So often a step is repeated at most."""
NEAR = 1e-6
"""So much beyond a limit is on it, of the limit."""


class MotorLimits:
    """Steps a world whose motors are stable PD, none beyond its limit.

    Args:
        model: The model of the world; its first actuators are the motors of its first hinges.
        n: How many there are.
    """

    def __init__(self, model: mujoco.MjModel, n: int):
        self._model, self._n, self._hinges = model, n, slice(6, 6 + n)
        self._held, self._torque = np.zeros(n, dtype=int), np.zeros(n)
        self._any = False
        self._bounds: Float[Array, "2 n"] | None = None

    def reset(self) -> None:
        """Forget which motors are at a limit."""
        self._held[:], self._any = 0, False

    def set(
        self,
        data: mujoco.MjData,
        stiffness: Float[Array, " n"],
        damping: Float[Array, " n"],
        armature: Float[Array, " n"],
        own: Float[Array, " n"],
        bounds: Float[Array, "2 n"],
    ) -> None:
        """Take a law, from now on.

        Args:
            data: The world, whose ``ctrl`` is the law's constant part.
            stiffness: What the law takes off per angle [N m/rad].
            damping: Per rate [N m s/rad].
            armature: Per acceleration [kg m²].
            own: Armature of the hinges without their motors [kg m²].
            bounds: Limits [N m].
        """
        self._force = np.array(data.ctrl[: self._n])
        self._stiffness, self._damping = stiffness, damping
        self._armature, self._own = armature, own
        self._active = np.where(self._held, 0.0, armature) if self._any else armature
        self.bound(bounds)

    def bound(self, bounds: Float[Array, "2 n"]) -> None:
        """Take other limits [N m]."""
        if bounds is not self._bounds:
            self._low, self._high = low, high = bounds
            self._middle, half = 0.5 * (low + high), 0.5 * (high - low)
            self._half, self._bounds = half + NEAR * half + 1e-12, bounds
        self._apply()

    @property
    def armature(self) -> Float[Array, " n"]:
        """What acts as armature of the motors: none where one is at its limit [kg m²]."""
        return self._active

    def step(self, data: mujoco.MjData, times: int) -> None:
        """Do so many steps."""
        model, h = self._model, self._model.opt.timestep
        for _ in range(times):
            mujoco.mj_step(model, data)
            for _ in range(TRIES):
                if not (self._any or self._beyond(data)):
                    break
                # Euler's step the other way: back to the state before it.
                qpos, qvel = data.qpos.copy(), data.qvel - h * data.qacc
                mujoco.mj_integratePos(model, qpos, data.qvel, -h)
                if not self._changed(data, qpos, qvel):
                    break
                data.qpos[:], data.qvel[:] = qpos, qvel
                data.time -= h
                mujoco.mj_step(model, data)

    def forward(self, data: mujoco.MjData) -> None:
        """Evaluate the present state, and do no step."""
        mujoco.mj_forward(self._model, data)
        for _ in range(TRIES):
            if not self._changed(data, data.qpos, data.qvel):
                break
            mujoco.mj_forward(self._model, data)

    def _beyond(self, data: mujoco.MjData) -> bool:
        """Return whether a motor is beyond its limit; takes the torques."""
        torque = self._torque
        np.multiply(self._active, data.qacc[self._hinges], out=torque)
        np.subtract(data.qfrc_actuator[self._hinges], torque, out=torque)
        return bool(np.count_nonzero(np.abs(torque - self._middle) > self._half))

    def _changed(self, data: mujoco.MjData, qpos: Array, qvel: Array) -> bool:
        """Return whether a motor has met or left its limit in the step just done, and obey."""
        beyond, held = self._beyond(data), self._held
        if self._any:
            law = self._force - self._stiffness * qpos[7 : 7 + self._n]
            law -= self._damping * qvel[self._hinges] + self._armature * data.qacc[self._hinges]
            back = ((held > 0) & (law < self._high)) | ((held < 0) & (law > self._low))
            if not (beyond or back.any()):
                return False
            held[back] = 0
        elif not beyond:
            return False
        off = self._torque - self._middle
        held[off > self._half], held[off < -self._half] = 1, -1
        self._any = bool(held.any())
        self._active = np.where(held, 0.0, self._armature)
        self._apply()
        return True

    def _apply(self) -> None:
        """Let MuJoCo know which motors give their limit."""
        held, ranges = self._held, self._model.actuator_forcerange
        if self._any:
            limit = np.where(held > 0, self._high, self._low)
            ranges[: self._n, 0] = np.where(held, limit, -np.inf)
            ranges[: self._n, 1] = np.where(held, limit, np.inf)
        else:
            ranges[: self._n] = -np.inf, np.inf
        self._model.dof_armature[self._hinges] = self._own + self._active
