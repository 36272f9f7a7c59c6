"""Conversion of commands to MuJoCo's actuator gains, armature and torque limits."""

from math import isfinite

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import SIDES
from plantigrade.dynamics.muscle_speed import OMEGA_0, velocity_factor
from plantigrade.dynamics.passive import (
    DAMPING,
    SAGITTAL,
    linear_stiffness,
    passive_moments,
    sagittal_springs,
    scale,
)
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world.command import (
    PD,
    Acceleration,
    AnyCommand,
    Command,
    Hinges,
    StablePD,
    Torque,
)
from plantigrade.world.motor_limits import MotorLimits

STIFFNESS_PER_TORQUE = 4.0
"""Default stiffness per maximum joint torque [1/rad], sufficient for quiet standing."""
DAMPING_TIME = 0.1  # Default ratio of damping to stiffness [s], as in [Park2020]_
PRESCRIBING_ARMATURE = 1000.0
"""Armature for prescribed accelerations [kg m²], far above the inertia of a limb."""
PASSIVE_RANGE_MARGIN = np.deg2rad(15.0)
"""Margin beyond the range of a joint within which its passive moment still increases [rad]."""


class Actuators:
    """The motors and the passive moments of a person in a world.

    Args:
        model: The model of the world; its actuators, armature and joint springs are set.
        passive: Whether joints have passive moments (:mod:`plantigrade.dynamics.passive`).
        rise: Rise time of a motor from zero to its maximum torque [s]; zero for none.
        slows: Whether a motor gives less torque the faster its joint turns, as a muscle does
            (:mod:`plantigrade.dynamics.muscle_speed`); against its effort it gives no more than at
            rest, as strengths are those of strong people already.
        exact: Whether torque limits include the implicit part of stable PD
            (:mod:`plantigrade.world.motor_limits`).

    Attributes:
        stiffness: Default stiffness of :class:`StablePD` [N m/rad].
        damping: Default damping of :class:`StablePD` [N m s/rad].
        armature: Armature of each hinge that the world adds for stability [kg m²].
    """

    def __init__(
        self,
        human: Human,
        model: mujoco.MjModel,
        *,
        passive: bool,
        rise: float = 0.0,
        slows: bool = False,
        exact: bool = True,
    ):
        self.model, self.n, self.rise, self.slows = model, len(human.coordinates), rise, slows
        low, high = human.model.jnt_actfrcrange[1:].T
        self._limits = np.array([low, high])
        self.stiffness = STIFFNESS_PER_TORQUE * np.maximum(-low, high)
        self.damping = DAMPING_TIME * self.stiffness
        self._dofs = slice(6, 6 + self.n)
        self._zeros, self._ones = np.zeros(self.n), np.ones(self.n)
        self.armature = model.dof_armature[self._dofs].copy()
        self._human, self._sagittal = human, np.zeros(0, dtype=int)
        self._passive_scale = scale(human.mass, human.height) if passive else 0.0
        if passive:
            self._set_passive(human)
        self._passive_damping = model.dof_damping[self._dofs].copy()
        self._passive_stiffness = model.jnt_stiffness[1 : 1 + self.n].copy()
        self._spring_rest = model.qpos_spring[7 : 7 + self.n].copy()
        self._tangent_cache: tuple[bytes, tuple[Array, Array, Array]] | None = None
        self._exact, self._motor_limits = exact, MotorLimits(model, self.n)
        self.reset()

    def reset(self) -> None:
        """Reset the motors to zero torque."""
        self._motor_armature, self._is_limited = np.zeros(self.n), True
        model, n = self.model, self.n  # remove gains of earlier commands
        model.actuator_biasprm[:n, 1:] = 0.0
        model.dof_armature[self._dofs] = self.armature
        model.jnt_stiffness[1 : 1 + n] = self._passive_stiffness
        model.qpos_spring[7 : 7 + n] = self._spring_rest
        self._bounds, self._exact_law = self._limits, False
        if self.rise:
            self._bounds = np.zeros_like(self._limits)
            self.model.actuator_forcerange[: self.n] = 0.0
        self._motor_limits.reset()

    def _set_passive(self, human: Human) -> None:
        """Set the damping of the joints, and springs where the passive moment is linear."""
        factor = self._passive_scale
        self.model.jnt_stiffness[1 : 1 + self.n] = factor * np.array(
            linear_stiffness(human.coordinates)
        )
        self.model.qpos_spring[7 : 7 + self.n] = 0.0
        for i, name in enumerate(human.coordinates):
            rate = next(d for start, d in DAMPING.items() if name.startswith(start))
            self.model.dof_damping[6 + i] = factor * rate
        names = [f"{stem}_{side}" for side in SIDES for stem in SAGITTAL]
        if set(names) <= set(human.coordinates):
            self._sagittal = np.array([human.hinge(name) for name in names])
            self._range = human.limits[:, self._sagittal] + [
                [-PASSIVE_RANGE_MARGIN],
                [PASSIVE_RANGE_MARGIN],
            ]

    def command(self, command: AnyCommand, data: mujoco.MjData) -> Command:
        """Apply a command until the next one, and return it as a :class:`Command`."""
        if command is None:
            command = Command()
        elif isinstance(command, np.ndarray):
            command = Torque(command)
        elif not isinstance(command, Command):
            raise ParameterError(
                f"a controller returned {type(command).__name__}; it may return a Command "
                "(Torque, StablePD, PD, Acceleration), torques as an array, or None"
            )
        model, n, h = self.model, self.n, self.model.opt.timestep
        stiffness = damping = armature = self._zeros
        force = stiffness
        if isinstance(command, Torque):
            force = self._numbers("torque", command.torque)
        elif isinstance(command, StablePD):
            stiffness = self._numbers("stiffness", command.stiffness, self.stiffness)
            damping = self._numbers("damping", command.damping, self.damping)
            without_stiffness = stiffness is self._zeros
            if damping.min() < 0 or (not without_stiffness and stiffness.min() < 0):
                raise ParameterError("stiffness and damping must not be negative")
            force = stiffness * self._numbers("target", command.target)
            if command.velocity is not None:
                force += damping * self._numbers("velocity", command.velocity)
            if command.torque is not None:
                force += self._numbers("torque", command.torque)
            if not isinstance(command, PD):
                damping = damping if without_stiffness else damping + h * stiffness
                armature = h * damping
        elif isinstance(command, Acceleration):
            armature = np.full(n, PRESCRIBING_ARMATURE)
            desired = self._numbers("acceleration", command.acceleration)
            mujoco.mj_forward(model, data)
            force = PRESCRIBING_ARMATURE * desired + data.qfrc_bias[self._dofs]
            model.actuator_forcerange[:n] = [-np.inf, np.inf]
        bias = model.actuator_biasprm
        np.negative(stiffness, out=bias[:n, 1])
        np.negative(damping, out=bias[:n, 2])
        data.ctrl[:n] = force
        self._set_passive_tangents(data)
        self._motor_armature, self._is_limited = armature, not isinstance(command, Acceleration)
        if self._is_limited and not self.rise:
            self._bounds = self.limits(data.qvel[self._dofs])
        # Passive damping and stiffness are implicit, too.
        if self._passive_scale:
            joint_armature = self.armature + h * (
                self._passive_damping + h * model.jnt_stiffness[1 : 1 + n]
            )
        else:
            joint_armature = self.armature + h * self._passive_damping
        self._exact_law = self._exact and self._is_limited and armature is not self._zeros
        if self._exact_law:
            self._motor_limits.set(data, stiffness, damping, armature, joint_armature, self._bounds)
        else:
            model.dof_armature[self._dofs] = joint_armature + armature
            if self._is_limited:
                model.actuator_forcerange[:n] = self._bounds.T
        return command

    @property
    def sagittal(self) -> Int[Array, " k"]:
        """Hinges with nonlinear passive moments: hips, knees and ankles of both legs, or none."""
        return self._sagittal

    @property
    def passive_damping(self) -> Hinges:
        """Passive damping of the hinges [N m s/rad]."""
        return self._passive_damping

    @property
    def passive_stiffness(self) -> Hinges:
        """Linear passive stiffness of the hinges, without that of the sagittal curves [N m/rad]."""
        return self._passive_stiffness if self._passive_scale else self._zeros

    def tangents(
        self, angles: Float[Array, "*n n_hinges"]
    ) -> tuple[Float[Array, "*n k"], Float[Array, "*n k"], Float[Array, "*n k"]]:
        """Return tangents of the passive curves: angles [rad], moments [N m], stiffness [N m/rad].

        Args:
            angles: Angles of all hinges [rad].
        """
        now = angles[..., self._sagittal]
        key = now.tobytes() + bytes(now.ndim)
        if self._tangent_cache is not None and self._tangent_cache[0] == key:
            return self._tangent_cache[1]  # used by controllers and by the next command
        q = np.minimum(np.maximum(now, self._range[0]), self._range[1])
        found = sagittal_springs(q.reshape(-1, 3).T, self._passive_scale)
        moments, stiffness = (x.T.reshape(q.shape) for x in found)
        self._tangent_cache = key, (q, moments, stiffness)
        return q, moments, stiffness

    def set_force(self, data: mujoco.MjData, force: Hinges) -> None:
        """Change the constant part of the last stable PD command and keep its gains.

        Faster than a whole command, for training; not for passive joints or exact limits.

        Args:
            force: Stiffness times target plus damping times desired rate [N m].
        """
        data.ctrl[: self.n] = force

    def step(self, data: mujoco.MjData, times: int) -> None:
        """Advance the physics by a number of steps with the present command."""
        if self._exact_law:
            self._motor_limits.step(data, times)
        else:
            mujoco.mj_step(self.model, data, times)

    def forward(self, data: mujoco.MjData) -> None:
        """Evaluate the present state with the present command."""
        if self._exact_law:
            self._motor_limits.forward(data)
        else:
            mujoco.mj_forward(self.model, data)

    def limits(self, rates: Hinges) -> Float[Array, "2 n_hinges"]:
        """Return the least and the greatest torque of the motors at some rates [N m].

        Args:
            rates: Rates of the hinges [rad/s].
        """
        if not self.slows:
            return self._limits
        ratio = rates / OMEGA_0
        return self._limits * np.minimum(velocity_factor(np.array([-ratio, ratio])), 1.0)

    def update_limits(self, data: mujoco.MjData, time: float) -> None:
        """Limit torques for the next steps, by rate and rise.

        Args:
            time: Time until the next call [s].
        """
        if not ((self.rise or self.slows) and self._is_limited):
            return
        bounds = self.limits(data.qvel[self._dofs])
        if self.rise:
            torque, step = self._limited_torques(data), time / self.rise
            bounds = np.array([np.clip(torque + step * x, *bounds) for x in self._limits])
        self._bounds = bounds
        if self._exact_law:
            self._motor_limits.set_bounds(bounds)
        else:
            self.model.actuator_forcerange[: self.n] = bounds.T

    def resistance(self, angles: Hinges) -> Hinges:
        """Return the passive moments of hinges at rest [N m].

        Args:
            angles: Angles of the hinges [rad].
        """
        names = self._human.coordinates
        rest = np.zeros(self.n)
        return np.array(passive_moments(names, angles, rest, self._passive_scale))

    def passive(self, angles: Hinges, rates: Hinges) -> Hinges:
        """Return the passive moments of the hinges, with damping, as the world applies them [N m].

        Args:
            angles: Angles of the hinges [rad].
            rates: Rates of the hinges [rad/s].
        """
        moments = -self._passive_stiffness * angles - self._passive_damping * rates
        if len(self._sagittal):
            q, tangent, stiffness = self.tangents(angles)
            moments[self._sagittal] += tangent - stiffness * (angles[self._sagittal] - q)
        return moments

    def _set_passive_tangents(self, data: mujoco.MjData) -> None:
        """Set joint springs to the tangents of the passive moments of hips, knees and ankles."""
        if not len(self._sagittal):
            return
        hinges = self._sagittal
        q, moments, stiffness = self.tangents(data.qpos[7 : 7 + self.n])
        self.model.jnt_stiffness[1:][hinges] = stiffness
        self.model.qpos_spring[7:][hinges] = q
        data.qfrc_applied[6:][hinges] = moments

    def joint_forces(
        self, data: mujoco.MjData, constraint: Float[Array, " nv"] | None
    ) -> Float[Array, " n_hinges"]:
        """Return the net internal joint torques, without armature [N m].

        They are the sum of motors, passive moments, joint stops and contact of the body with
        itself.
        """
        given = data.qfrc_actuator + data.qfrc_passive + data.qfrc_applied
        if constraint is not None:
            given += constraint
        return (given - self.model.dof_armature * data.qacc)[self._dofs]

    def motor_torques(self, data: mujoco.MjData) -> Float[Array, " n_hinges"]:
        """Return the torques of the motors alone [N m]."""
        hinges = self._dofs
        motor = self._motor_limits.armature if self._exact_law else self._motor_armature
        return data.qfrc_actuator[hinges] - motor * data.qacc[hinges]

    def _limited_torques(self, data: mujoco.MjData) -> Float[Array, " n_hinges"]:
        """Return the motor torques of the last step to which the limits apply [N m]."""
        return self.motor_torques(data) if self._exact_law else data.qfrc_actuator[self._dofs]

    def _numbers(self, name: str, value, default=None) -> Float[Array, " n_hinges"]:
        """Return one finite number for each hinge."""
        if value is None and default is not None:
            value = default
        elif isinstance(value, float) and value == 0.0:
            return self._zeros
        try:
            numbers = np.asarray(value, dtype=float)
            if numbers.shape != (self.n,):
                numbers = np.broadcast_to(numbers, (self.n,))
        except (TypeError, ValueError):
            numbers = None
        # A finite sum implies finite numbers, and takes a tenth of the time.
        if numbers is None or not isfinite(numbers @ self._ones):
            raise ParameterError(
                f"a command's {name} must be {self.n} finite numbers, one for each of "
                f"Human.coordinates, not {value!r:.80}"
            )
        return numbers
