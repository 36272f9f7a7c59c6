"""Motion of a Human: times and configurations of one MuJoCo model."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import Figure
from plantigrade.errors import CoordinateNotFound, known_names
from plantigrade.motion.filters import interpolate, resample
from plantigrade.motion.recording import GaitEvent, rate_of
from plantigrade.motion.views import curves_of, dataframe, plot_curves, summary, table_html
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    PELVIS,
    continuous_poses,
    quaternion_to_pelvis_angles,
)


@dataclass(frozen=True, eq=False)
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

    @property
    def duration(self) -> float:
        """Duration from the first frame to the last [s]."""
        return float(self.time[-1] - self.time[0]) if len(self.time) else 0.0

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates: OpenSim's six of the pelvis, then the hinges."""
        return (*PELVIS, *self.joint_names[1:])

    def hinge(self, name: str) -> int:
        """Return the index ``i`` of a hinge: ``qpos[:, 7 + i]``, ``qvel[:, 6 + i]``.

        Raises:
            CoordinateNotFound: If there is no such hinge.
        """
        try:
            return self.joint_names.index(name, 1) - 1
        except ValueError:
            raise CoordinateNotFound(
                f"no coordinate {name!r} in this motion; {known_names(name, self.coordinates)}"
            ) from None

    def __getitem__(self, name: str) -> Float[Array, " n_frames"]:
        """Return a coordinate by name [rad, m]; the pelvis as in OpenSim, its angles continuous.

        Raises:
            CoordinateNotFound: If there is no such coordinate.
        """
        if name not in PELVIS:
            return self.qpos[:, 7 + self.hinge(name)]
        i = PELVIS.index(name)
        if i >= 3:
            return self.qpos[:, :3] @ OPENSIM_TO_WORLD[:, i - 3]
        return np.unwrap(quaternion_to_pelvis_angles(self.qpos[:, 3:7])[:, i])

    def velocity(self, hinge: str) -> Float[Array, " n_frames"]:
        """Return the velocity of a hinge by name [rad/s].

        Raises:
            CoordinateNotFound: If there is no such hinge.
        """
        return self.qvel[:, 6 + self.hinge(hinge)]

    def frames(self, keep: slice | Array) -> "Motion":
        """Return some of the frames, with the events between the first and the last of them."""
        time = self.time[keep]
        inside = tuple(e for e in self.events if len(time) and time[0] <= e.time <= time[-1])
        qacc = None if self.qacc is None else self.qacc[keep]
        return replace(
            self, time=time, qpos=self.qpos[keep], qvel=self.qvel[keep], qacc=qacc, events=inside
        )

    def at(self, time: Float[Array, " n"]) -> "Motion":
        """Return the motion at other times [s], by cubic splines; NaN before and after it."""
        qpos = resample(self.time, continuous_poses(self.qpos), time)
        qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
        qvel = resample(self.time, self.qvel, time)
        qacc = None if self.qacc is None else resample(self.time, self.qacc, time)
        return replace(self, time=time, qpos=qpos, qvel=qvel, qacc=qacc)

    def plot(self, *names: str) -> Figure:
        """Return a figure of coordinates over time; a notebook shows it.

        Args:
            names: Coordinates, or stems that stand for both sides (``"knee_angle"``); those that
                change if none is given.

        Raises:
            CoordinateNotFound: If there is no such coordinate.
        """
        return plot_curves(curves_of(self, names), self.time, asked=bool(names))

    def to_dataframe(self) -> Any:
        """Return all coordinates [rad, m] as a pandas DataFrame indexed by time [s].

        Raises:
            MissingExtra: If pandas is not installed.
        """
        return dataframe(self.time, {name: self[name] for name in self.coordinates})

    def _repr_html_(self) -> str:
        return table_html("Motion", summary(self))

    def __repr__(self) -> str:
        rate = f" at {self.rate:.0f} Hz" if self.n_frames > 1 else ""
        return (
            f"Motion({self.n_frames} frames{rate}, {len(self.joint_names) - 1} hinges, "
            f"{len(self.events)} gait events)"
        )


def resampled(motion: Motion, time: Float[Array, " n"]) -> Motion:
    """Return a motion at other times [s], interpolated, and constant beyond its ends."""
    if np.array_equal(motion.time, time):
        return motion
    qpos = continuous_poses(motion.qpos)
    here, speed = (interpolate(time, motion.time, values) for values in (qpos, motion.qvel))
    here[:, 3:7] /= np.linalg.norm(here[:, 3:7], axis=1, keepdims=True)
    return Motion(time, here, speed, motion.joint_names, events=motion.events)
