"""Stable PD to a motion."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.posture import PostureSettings
from plantigrade.motion import Motion
from plantigrade.world import Command, Controller, StablePD, State


@dataclass(frozen=True, kw_only=True)
class TrackingSettings:
    """Springs that follow a motion."""

    stiffness: float = PostureSettings.stiffness
    """Stiffness and damping of the springs; 1 is four times the joint's strength per radian."""


class Tracking(Controller):
    """Springs and dampers to a motion, joint by joint, by stable PD [Tan2011]_.

    The target is the motion at the end of the control step, with its velocities; after the last
    frame it stands still. There is no feedback of balance: a walk soon falls.

    Args:
        motion: A motion of the person in the world; its first frame is the start.
        settings: Stiffness of the springs.
    """

    def __init__(self, motion: Motion, *, settings: TrackingSettings | None = None):
        self.motion, self.settings = motion, settings or TrackingSettings()

    def __call__(self, state: State) -> Command:
        """Return springs to the next state of the motion."""
        actuators, stiffness = state.world.actuators, self.settings.stiffness
        target, velocity = self.at(state.time + 1.0 / state.world.control_rate)
        now, _ = self.at(state.time)
        return StablePD(
            target,
            velocity,
            stiffness=stiffness * actuators.stiffness,
            damping=stiffness * actuators.damping,
            signals={"tracking_error": float(np.sqrt(np.mean((state.angles - now) ** 2)))},
        )

    def at(self, time: float) -> tuple[Float[Array, " n_hinges"], Float[Array, " n_hinges"]]:
        """Return angles and rates a time after the start [rad, rad/s]."""
        own = self.motion.time
        t = own[0] + time
        if t >= own[-1]:
            return self.motion.qpos[-1, 7:], np.zeros(self.motion.qpos.shape[1] - 7)
        i = int(np.searchsorted(own, t, side="right")) - 1
        h = own[i + 1] - own[i]
        u = (t - own[i]) / h
        q, v = self.motion.qpos[:, 7:], self.motion.qvel[:, 6:]
        return (1 - u) * q[i] + u * q[i + 1], (1 - u) * v[i] + u * v[i + 1]
