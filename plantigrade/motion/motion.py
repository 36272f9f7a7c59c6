"""How a Human moves: time and configurations of one MuJoCo model."""

from dataclasses import dataclass

from plantigrade.arrays import Array, Float
from plantigrade.motion.recording import GaitEvent, rate_of


@dataclass(frozen=True)
class Motion:
    """Configurations of a Human over time.

    Attributes:
        time: Time of each frame [s].
        qpos: MuJoCo configurations: root position [m], root quaternion ``wxyz``, hinges [rad].
        qvel: MuJoCo velocities: root linear in world axes [m/s], root angular in body axes
            [rad/s], hinges [rad/s].
        joint_names: MuJoCo joint names, in model order; the first is the free joint ``root``.
        qacc: Accelerations, in the axes of ``qvel``, where known.
        events: Gait events, by time.
    """

    time: Float[Array, " n_frames"]
    qpos: Float[Array, "n_frames nq"]
    qvel: Float[Array, "n_frames nv"]
    joint_names: tuple[str, ...]
    qacc: Float[Array, "n_frames nv"] | None = None
    events: tuple[GaitEvent, ...] = ()

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.time)

    @property
    def rate(self) -> float:
        """Frames per second [Hz]; NaN for fewer than two frames."""
        return rate_of(self.time)
