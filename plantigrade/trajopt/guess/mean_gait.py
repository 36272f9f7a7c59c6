"""Published mean joint angles of walking over the time of a plan."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.models import Human
from plantigrade.models.textbook_gait import textbook_gait
from plantigrade.motion.blends import cubic_rise
from plantigrade.spatial.conventions import PELVIS
from plantigrade.trajopt.guess.foot_motion import STRIKE_ANGLES, TOE_OFF_ANGLES, FootCurves
from plantigrade.trajopt.guess.postures import standing_hinges
from plantigrade.trajopt.tasks.gait_parameters import GaitParameters

MAX_HEEL_UP_ANGLE = float(np.deg2rad(65.0))  # [rad] maximum heel-up angle in swing; chosen
SAGITTAL = ("hip_flexion", "knee_angle", "ankle_angle")


class MeanGait:
    """Published mean joint angles over the time of a plan, blended into standing at rest."""

    def __init__(
        self,
        human: Human,
        parameters: GaitParameters,
        phase: tuple[Array, Array],
        walking: tuple[Array, Array],
    ):
        similar = np.sqrt(GRAVITY * parameters.leg_length)  # where gravity is another, as slow
        speed = float(np.clip(parameters.relative_speed, 0.101, 0.799) * similar)
        gait = textbook_gait(speed, parameters.leg_length, rate=400.0, cycles=1)
        self.human, self.foot_off = human, gait.foot_off
        self.step_length = gait.stride_length / 2
        self._share = gait.time / gait.stride_time
        self._curves = gait.coordinates
        self._phase, self._walking, self._stride = phase, walking, parameters.stride_time

    def curve(self, name: str, phase: Float[Array, " n"]) -> Float[Array, " n"]:
        """Return a coordinate of the walk at phases of the right foot [rad]."""
        return np.interp(phase % 1.0, self._share, self._curves[name], period=1.0)

    def phase(self, times: Float[Array, " n"]) -> Float[Array, " n"]:
        """Return strides of the right foot at times."""
        t, p = self._phase
        before, after = np.minimum(times - t[0], 0.0), np.maximum(times - t[-1], 0.0)
        return np.interp(times, t, p) + (before + after) / self._stride

    def walking(self, times: Float[Array, " n"]) -> Float[Array, " n"]:
        """Return the share of walking at times, from 0 (standing) to 1."""
        return cubic_rise(np.interp(times, *self._walking))

    def pelvis_angles(self, times: Float[Array, " n"]) -> Float[Array, "n 3"]:
        """Return pelvis tilt, list and rotation [rad]."""
        phase, share = self.phase(times), self.walking(times)
        return np.stack([share * self.curve(name, phase) for name in PELVIS[:3]], axis=1)

    def hinges(self, times: Float[Array, " n"]) -> Float[Array, "n n_hinges"]:
        """Return all hinges of the person [rad]."""
        phase, share = self.phase(times), self.walking(times)
        hinges = standing_hinges(self.human, len(times))
        for i, name in enumerate(self.human.coordinates):
            if name in self._curves:
                hinges[:, i] += share * (self.curve(name, phase) - hinges[:, i])
        return hinges

    def foot_curves(self, parameters: GaitParameters) -> FootCurves:
        """Return how a foot moves in walking; its pitch grows with step length."""
        d = self.human.dimensions
        swing = np.linspace(self.foot_off, 1.0, 61)
        phase = np.where(swing < 1.0, swing, 0.0)
        tilt, hip, knee, ankle = (
            self.curve(name, phase) for name in ("pelvis_tilt", *(f"{n}_r" for n in SAGITTAL))
        )
        thigh, shank = hip + tilt, hip + tilt - knee  # ahead of the vertical
        heel_up = -(shank + ankle)
        heel_up *= min(
            parameters.step_length / self.step_length, MAX_HEEL_UP_ANGLE / float(heel_up.max())
        )
        forward = d.thigh * np.sin(thigh) + d.shank * np.sin(shank)
        forward += 2 * self.step_length * swing
        return FootCurves(
            strike=float(np.clip(-heel_up[-1], *STRIKE_ANGLES)),
            off=float(np.clip(heel_up[0], *TOE_OFF_ANGLES)),
            pitch=heel_up,
            forward=(forward - forward[0]) / (forward[-1] - forward[0]),
            up=-(d.thigh * np.cos(thigh) + d.shank * np.cos(shank)),
        )
