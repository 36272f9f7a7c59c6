r"""Torque limits of stable PD, including its implicit part within a step.

With the armature :math:`a = h (k_d + h k_p)` of stable PD a motor applies
:math:`\tau = u - a \ddot q`, and :math:`\ddot q` is known only after the step: at touchdown an
ankle would exceed twice its strength. The law of a motor with limits is

.. math:: \tau = \min(\max(u - a \ddot q,\ \tau_{min}),\ \tau_{max}) .

The right-hand side decreases with :math:`\ddot q`, so the solution is unique for any contacts. An
active-set method finds it: a motor beyond its limit applies the limit itself, without armature, and
the step is repeated; a motor whose law is within the limit again applies its law. The active set of
one step is the initial guess for the next, so a step is repeated only when a motor reaches or
leaves its limit.
"""

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float

MAX_REPEATS = 8  # Maximum number of repetitions of a step
TOLERANCE = 1e-6  # Relative tolerance of a limit


class MotorLimits:
    """Steps a world with stable PD so that no motor exceeds its limit.

    Args:
        model: The model of the world; its first actuators are the motors of its first hinges.
        n: Number of motors.
    """

    def __init__(self, model: mujoco.MjModel, n: int):
        self._model, self._n, self._hinges = model, n, slice(6, 6 + n)
        self._at_limit, self._torque = np.zeros(n, dtype=int), np.zeros(n)
        self._any_at_limit = False
        self._bounds: Float[Array, "2 n"] | None = None

    def reset(self) -> None:
        """Clear the active set."""
        self._at_limit[:], self._any_at_limit = 0, False

    def set(
        self,
        data: mujoco.MjData,
        stiffness: Float[Array, " n"],
        damping: Float[Array, " n"],
        armature: Float[Array, " n"],
        joint_armature: Float[Array, " n"],
        bounds: Float[Array, "2 n"],
    ) -> None:
        """Set the law of the motors.

        Args:
            data: The world's data, with the constant part of the law in ``ctrl``.
            stiffness: Stiffness of the law [N m/rad].
            damping: Damping of the law [N m s/rad].
            armature: Armature of the law [kg m²].
            joint_armature: Armature of the hinges without their motors [kg m²].
            bounds: Lower and upper torque limits [N m].
        """
        self._force = np.array(data.ctrl[: self._n])
        self._stiffness, self._damping = stiffness, damping
        self._armature, self._joint_armature = armature, joint_armature
        self._active_armature = (
            np.where(self._at_limit, 0.0, armature) if self._any_at_limit else armature
        )
        self.set_bounds(bounds)

    def set_bounds(self, bounds: Float[Array, "2 n"]) -> None:
        """Set other torque limits [N m]."""
        if bounds is not self._bounds:
            self._low, self._high = low, high = bounds
            self._middle, half = 0.5 * (low + high), 0.5 * (high - low)
            self._half, self._bounds = half + TOLERANCE * half + 1e-12, bounds
        self._apply()

    @property
    def armature(self) -> Float[Array, " n"]:
        """Active armature of the motors, zero where a motor is at its limit [kg m²]."""
        return self._active_armature

    def step(self, data: mujoco.MjData, times: int) -> None:
        """Advance by a number of steps."""
        model, h = self._model, self._model.opt.timestep
        for _ in range(times):
            mujoco.mj_step(model, data)
            for _ in range(MAX_REPEATS):
                if not (self._any_at_limit or self._exceeds_limit(data)):
                    break
                # Reverse the Euler step to restore the state before it.
                qpos, qvel = data.qpos.copy(), data.qvel - h * data.qacc
                mujoco.mj_integratePos(model, qpos, data.qvel, -h)
                if not self._update(data, qpos, qvel):
                    break
                data.qpos[:], data.qvel[:] = qpos, qvel
                data.time -= h
                mujoco.mj_step(model, data)

    def forward(self, data: mujoco.MjData) -> None:
        """Evaluate the present state without a step."""
        mujoco.mj_forward(self._model, data)
        for _ in range(MAX_REPEATS):
            if not self._update(data, data.qpos, data.qvel):
                break
            mujoco.mj_forward(self._model, data)

    def _exceeds_limit(self, data: mujoco.MjData) -> bool:
        """Compute the torques and return whether one exceeds its limit."""
        torque = self._torque
        np.multiply(self._active_armature, data.qacc[self._hinges], out=torque)
        np.subtract(data.qfrc_actuator[self._hinges], torque, out=torque)
        return bool(np.count_nonzero(np.abs(torque - self._middle) > self._half))

    def _update(self, data: mujoco.MjData, qpos: Array, qvel: Array) -> bool:
        """Update the active set after a step and return whether it has changed."""
        exceeds, at_limit = self._exceeds_limit(data), self._at_limit
        if self._any_at_limit:
            law = self._force - self._stiffness * qpos[7 : 7 + self._n]
            law -= self._damping * qvel[self._hinges] + self._armature * data.qacc[self._hinges]
            within = ((at_limit > 0) & (law < self._high)) | ((at_limit < 0) & (law > self._low))
            if not (exceeds or within.any()):
                return False
            at_limit[within] = 0
        elif not exceeds:
            return False
        excess = self._torque - self._middle
        at_limit[excess > self._half], at_limit[excess < -self._half] = 1, -1
        self._any_at_limit = bool(at_limit.any())
        self._active_armature = np.where(at_limit, 0.0, self._armature)
        self._apply()
        return True

    def _apply(self) -> None:
        """Set MuJoCo's force ranges and armature for the active set."""
        at_limit, ranges = self._at_limit, self._model.actuator_forcerange
        if self._any_at_limit:
            limit = np.where(at_limit > 0, self._high, self._low)
            ranges[: self._n, 0] = np.where(at_limit, limit, -np.inf)
            ranges[: self._n, 1] = np.where(at_limit, limit, np.inf)
        else:
            ranges[: self._n] = -np.inf, np.inf
        self._model.dof_armature[self._hinges] = self._joint_armature + self._active_armature
