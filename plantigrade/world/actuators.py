"""Commands as MuJoCo's actuators: gains, armature and limits, set once for each command."""

from math import isfinite

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import SIDES
from plantigrade.dynamics.passive import (
    DAMPING,
    SAGITTAL,
    STIFFNESS,
    passive_moments,
    sagittal_springs,
    scale,
)
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world.command import PD, Acceleration, Command, Commanded, Hinges, StablePD, Torque
from plantigrade.world.limits import MotorLimits

STRENGTH_STIFFNESS = 4.0
"""Stiffness of a joint by default, by its greatest torque [1/rad]: with it a person stands."""
TIME = 0.1
"""Damping by stiffness, by default [s], as in [Park2020]_."""
RIGID = 1000.0
"""Armature that prescribes an acceleration [kg m²]."""
BEYOND = np.deg2rad(15.0)
"""So far beyond the range of a joint its passive moment grows [rad]."""


class Actuators:
    """The motors and the passive moments of a person in a world.

    Args:
        human: The person.
        model: The model of the world, whose actuators, armature and springs are set.
        passive: Whether joints resist by themselves (:mod:`plantigrade.dynamics.passive`).
        rise: How long a motor takes from nothing to its greatest torque [s]; zero: no time.
        exact: Whether limits hold for all of stable PD (:mod:`plantigrade.world.limits`), or but
            for its part within a step.

    Attributes:
        stiffness: Of :class:`StablePD` where a command names none [N m/rad].
        damping: Likewise [N m s/rad].
        armature: What the world adds to the inertia of each hinge, for stability [kg m²].
    """

    def __init__(
        self,
        human: Human,
        model: mujoco.MjModel,
        *,
        passive: bool,
        rise: float = 0.0,
        exact: bool = True,
    ):
        self.model, self.n, self.rise = model, len(human.coordinates), rise
        low, high = human.model.jnt_actfrcrange[1:].T
        self._limits = np.array([low, high])
        self.stiffness = STRENGTH_STIFFNESS * np.maximum(-low, high)
        self.damping = TIME * self.stiffness
        self._hinges = slice(6, 6 + self.n)
        self._nothing, self._ones = np.zeros(self.n), np.ones(self.n)
        self.armature = model.dof_armature[self._hinges].copy()
        self._human, self._sagittal = human, np.zeros(0, dtype=int)
        self._factor = scale(human.mass, human.height) if passive else 0.0
        if passive:
            self._resist(human)
        self._loose = model.dof_damping[self._hinges].copy()
        self._spring = model.jnt_stiffness[1 : 1 + self.n].copy()
        self._rest = model.qpos_spring[7 : 7 + self.n].copy()
        self._tangents: tuple[bytes, tuple[Array, Array, Array]] | None = None
        self._exact, self._limiting = exact, MotorLimits(model, self.n)
        self.reset()

    def reset(self) -> None:
        """Start from motors at rest."""
        self._motor, self._limited = np.zeros(self.n), True
        model, n = self.model, self.n  # as if nothing had ever been commanded
        model.actuator_biasprm[:n, 1:] = 0.0
        model.dof_armature[self._hinges] = self.armature
        model.jnt_stiffness[1 : 1 + n] = self._spring
        model.qpos_spring[7 : 7 + n] = self._rest
        self._bounds, self._law = self._limits, False
        if self.rise:
            self._bounds = np.zeros_like(self._limits)
            self.model.actuator_forcerange[: self.n] = 0.0
        self._limiting.reset()

    def _resist(self, human: Human) -> None:
        """Give the joints damping, and springs where their moment is linear."""
        factor = self._factor
        for i, name in enumerate(human.coordinates):
            stem = name[:-2] if name[-2:] in ("_r", "_l") else name
            rate = next(d for start, d in DAMPING.items() if stem.startswith(start))
            self.model.dof_damping[6 + i] = factor * rate
            self.model.jnt_stiffness[1 + i] = factor * STIFFNESS.get(stem, 0.0)
            self.model.qpos_spring[7 + i] = 0.0
        names = [f"{stem}_{side}" for side in SIDES for stem in SAGITTAL]
        if set(names) <= set(human.coordinates):
            self._sagittal = np.array([human.hinge(name) for name in names])
            self._range = human.limits[:, self._sagittal] + [[-BEYOND], [BEYOND]]

    def command(self, command: Commanded, data: mujoco.MjData) -> Command:
        """Set what a command asks for, from now on, and return it as a command.

        Raises:
            ParameterError: If it does not fit this person.
        """
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
        stiffness = damping = armature = self._nothing
        force = stiffness
        if isinstance(command, Torque):
            force = self._numbers("torque", command.torque)
        elif isinstance(command, StablePD):
            stiffness = self._numbers("stiffness", command.stiffness, self.stiffness)
            damping = self._numbers("damping", command.damping, self.damping)
            soft = stiffness is self._nothing
            if damping.min() < 0 or (not soft and stiffness.min() < 0):
                raise ParameterError("stiffness and damping must not be negative")
            force = stiffness * self._numbers("target", command.target)
            if command.velocity is not None:
                force += damping * self._numbers("velocity", command.velocity)
            if command.torque is not None:
                force += self._numbers("torque", command.torque)
            if not isinstance(command, PD):
                damping = damping if soft else damping + h * stiffness
                armature = h * damping
        elif isinstance(command, Acceleration):
            armature = np.full(n, RIGID)
            wanted = self._numbers("acceleration", command.acceleration)
            mujoco.mj_forward(model, data)
            force = RIGID * wanted + data.qfrc_bias[self._hinges]
            model.actuator_forcerange[:n] = [-np.inf, np.inf]
        bias = model.actuator_biasprm
        np.negative(stiffness, out=bias[:n, 1])
        np.negative(damping, out=bias[:n, 2])
        data.ctrl[:n] = force
        self._passive(data)
        self._motor, self._limited = armature, not isinstance(command, Acceleration)
        if self._limited and not self.rise:
            self._bounds = self._limits
        # What is damped or springs back by itself is implicit, too.
        if self._factor:
            own = self.armature + h * (self._loose + h * model.jnt_stiffness[1 : 1 + n])
        else:
            own = self.armature + h * self._loose
        self._law = self._exact and self._limited and armature is not self._nothing
        if self._law:
            self._limiting.set(data, stiffness, damping, armature, own, self._bounds)
        else:
            model.dof_armature[self._hinges] = own + armature
            if self._limited:
                model.actuator_forcerange[:n] = self._bounds.T
        return command

    @property
    def sagittal(self) -> Int[Array, " k"]:
        """Hinges whose passive moments are curves: hips, knees and ankles of both legs, or none."""
        return self._sagittal

    @property
    def loose(self) -> Hinges:
        """Passive damping of the hinges [N m s/rad]."""
        return self._loose

    @property
    def springs(self) -> Hinges:
        """Passive stiffness of the hinges, without that of the curves [N m/rad]."""
        return self._spring if self._factor else self._nothing

    def tangents(
        self, angles: Float[Array, "*n n_hinges"]
    ) -> tuple[Float[Array, "*n k"], Float[Array, "*n k"], Float[Array, "*n k"]]:
        """Return springs that are tangents of the curves: where they rest, moments, stiffness.

        Args:
            angles: Of all hinges [rad].
        """
        now = angles[..., self._sagittal]
        key = now.tobytes() + bytes(now.ndim)
        if self._tangents is not None and self._tangents[0] == key:
            return self._tangents[1]  # controllers ask, and so does the command that follows
        q = np.minimum(np.maximum(now, self._range[0]), self._range[1])
        found = sagittal_springs(q.reshape(-1, 3).T, self._factor)
        moments, stiffness = (x.T.reshape(q.shape) for x in found)
        self._tangents = key, (q, moments, stiffness)
        return q, moments, stiffness

    def retarget(self, data: mujoco.MjData, force: Hinges) -> None:
        """Give the stable PD that was commanded last another constant part, and keep its gains.

        For learners, to whom a whole command takes too long; not where joints are passive or limits
        are exact.

        Args:
            data: The world.
            force: Stiffness times target and damping times its rate [N m].
        """
        data.ctrl[: self.n] = force

    def step(self, data: mujoco.MjData, times: int) -> None:
        """Do so many steps of the physics with what was commanded."""
        if self._law:
            self._limiting.step(data, times)
        else:
            mujoco.mj_step(self.model, data, times)

    def forward(self, data: mujoco.MjData) -> None:
        """Evaluate the present state with what was commanded."""
        if self._law:
            self._limiting.forward(data)
        else:
            mujoco.mj_forward(self.model, data)

    def ease(self, data: mujoco.MjData, time: float) -> None:
        """Let torques rise in a finite time; to be called before every few steps.

        Args:
            data: The world.
            time: Until the next call [s].
        """
        if self.rise and self._limited:
            torque, step = self._given(data), time / self.rise
            bounds = [np.clip(torque + step * x, *self._limits) for x in self._limits]
            self._bounds = np.array(bounds)
            if self._law:
                self._limiting.bound(self._bounds)
            else:
                self.model.actuator_forcerange[: self.n] = self._bounds.T

    def resistance(self, angles: Hinges) -> Hinges:
        """Return the passive moments of hinges at rest [N m].

        Args:
            angles: Their angles [rad].
        """
        names = self._human.coordinates
        rest = np.zeros(self.n)
        return np.array(passive_moments(names, angles, rest, self._factor))

    def passive(self, angles: Hinges, rates: Hinges) -> Hinges:
        """Return the passive moments of the hinges as the world has them [N m].

        Like :meth:`resistance`, with damping, in the time of a tick.

        Args:
            angles: Their angles [rad].
            rates: Their rates [rad/s].
        """
        moments = -self._spring * angles - self._loose * rates
        if len(self._sagittal):
            q, tangent, stiffness = self.tangents(angles)
            moments[self._sagittal] += tangent - stiffness * (angles[self._sagittal] - q)
        return moments

    def _passive(self, data: mujoco.MjData) -> None:
        """Put tangents of the passive moments of hips, knees and ankles into springs."""
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
        """Return what acts at the hinges, of all that is not touched from outside [N m].

        Motors, passive moments, stops and contact of the body with itself, as the person without
        armature feels them.

        Args:
            data: The world, after a step.
            constraint: Generalised force of stops and contact with itself, if there is any.
        """
        given = data.qfrc_actuator + data.qfrc_passive + data.qfrc_applied
        if constraint is not None:
            given += constraint
        return (given - self.model.dof_armature * data.qacc)[self._hinges]

    def motor_torques(self, data: mujoco.MjData) -> Float[Array, " n_hinges"]:
        """Return the torques of the motors alone [N m]."""
        hinges = self._hinges
        motor = self._limiting.armature if self._law else self._motor
        return data.qfrc_actuator[hinges] - motor * data.qacc[hinges]

    def _given(self, data: mujoco.MjData) -> Float[Array, " n_hinges"]:
        """Return what the limits hold for, of the motors' torques in the last step [N m]."""
        return self.motor_torques(data) if self._law else data.qfrc_actuator[self._hinges]

    def _numbers(self, name: str, value, default=None) -> Float[Array, " n_hinges"]:
        """Return one number a hinge."""
        if value is None and default is not None:
            value = default
        elif isinstance(value, float) and value == 0.0:
            return self._nothing
        try:
            numbers = np.asarray(value, dtype=float)
            if numbers.shape != (self.n,):
                numbers = np.broadcast_to(numbers, (self.n,))
        except (TypeError, ValueError):
            numbers = None
        # A sum is finite where every number is, and asked for in a tenth of the time.
        if numbers is None or not isfinite(numbers @ self._ones):
            raise ParameterError(
                f"a command's {name} must be {self.n} finite numbers, one for each of "
                f"Human.coordinates, not {value!r:.80}"
            )
        return numbers
