"""Contents of a motion file, before any body is fitted.

Everything is in SI units and world axes: x forward (as in the file), y left, z up. Axes and units
of files are converted in :mod:`plantigrade.io`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import shown
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError, known_names


@dataclass(frozen=True)
class Markers:
    """Trajectories of named points."""

    names: tuple[str, ...]  #: Marker names as in the file, unique
    time: Float[Array, " n_frames"]  #: Time of each frame [s], increasing
    #: World positions [m]; NaN where a marker is missing
    positions: Float[Array, "n_frames n_markers 3"]

    @property
    def rate(self) -> float:
        """Frames per second [Hz]; NaN for fewer than two frames."""
        return rate_of(self.time)

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.time)

    def index(self, name: str) -> int:
        """Return the column of marker ``name``.

        Raises:
            ParameterError: If there is no such marker.
        """
        try:
            return self.names.index(name)
        except ValueError:
            raise ParameterError(
                f"no marker {name!r} in the recording; {known_names(name, self.names)}"
            ) from None

    def select(self, names: Sequence[str]) -> "Markers":
        """Return only the markers ``names``, in that order."""
        columns = [self.index(name) for name in names]
        return replace(self, names=tuple(names), positions=self.positions[:, columns])


@dataclass(frozen=True)
class ForcePlate:
    """One measured ground reaction *on the body*, as a wrench at the centre of pressure."""

    name: str  #: Name in the file (``"1"``, ``"ground_force_r"``, …)
    #: Time of each sample [s], on the clock of the markers, possibly at a higher rate
    time: Float[Array, " n_samples"]
    force: Float[Array, "n_samples 3"]  #: Ground reaction force on the body, world axes [N]
    #: Centre of pressure, world [m]; NaN where the force is too small
    cop: Float[Array, "n_samples 3"]
    #: Moment about the vertical at the centre of pressure, on the body [N m]
    free_moment: Float[Array, " n_samples"]
    corners: Float[Array, "4 3"] | None = None  #: Corners of the plate, world [m], if known
    side: str | None = None  #: ``"r"`` or ``"l"`` if the file states the foot


@dataclass(frozen=True)
class GaitEvent:
    """A heel strike or toe off.

    Raises:
        ParameterError: If side or kind are others.
    """

    time: float  #: Instant [s], on the clock of the frames
    side: str  #: ``"l"`` or ``"r"``
    kind: str  #: ``"heel_strike"`` (initial contact) or ``"toe_off"``

    def __post_init__(self):
        if self.side not in SIDES or self.kind not in ("heel_strike", "toe_off"):
            raise ParameterError(
                f"event {shown(self.kind)} of side {shown(self.side)}: sides are 'r' and 'l', "
                "kinds are 'heel_strike' and 'toe_off'"
            )


@dataclass(frozen=True)
class Subject:
    """Subject data of a file; None where unknown."""

    height: float | None = None  #: Body height [m]
    mass: float | None = None  #: Body mass [kg]
    sex: str | None = None  #: ``"male"`` or ``"female"``
    leg_length: float | None = None  #: Leg length, mean of both sides [m]
    age: float | None = None  #: Age [years]
    name: str | None = None  #: Name or code of the person
    date: str | None = None  #: Date of the recording, as written in the file

    @property
    def figures(self) -> dict[str, float | str]:
        """Known data of the person under flat keys, for the pages of a run."""
        keys = {"age": "age_years", "sex": "sex", "name": "subject_name", "date": "recorded_on"}
        found = {key: getattr(self, name) for name, key in keys.items()}
        return {key: value for key, value in found.items() if value is not None}


@dataclass(frozen=True)
class SkeletonMotion:
    """Motion of another skeleton (ASF/AMC, BVH, DeepMimic, SMPL), to be retargeted."""

    names: tuple[str, ...]  #: Joint (or bone) names as in the file, parents before children
    parents: tuple[int, ...]  #: Index of each joint's parent, -1 for the root
    time: Float[Array, " n_frames"]  #: Time of each frame [s]
    positions: Float[Array, "n_frames n_joints 3"]  #: World position of each joint [m]
    #: World rotation of each joint's bone frame (maps bone axes, which in the rest pose are
    #: parallel to the world axes x forward, y left, z up, to world axes)
    rotations: Float[Array, "n_frames n_joints 3 3"]
    #: Joint positions in the rest pose, root at the origin [m], same axes
    rest_positions: Float[Array, "n_joints 3"]
    #: World position of the end of each bone (for ASF the bone's own far end; for BVH its ``End
    #: Site`` or NaN) [m]
    ends: Float[Array, "n_frames n_joints 3"]
    #: Whether the path is measured and the bone lengths are a mean body's (AMASS without a body
    #: model); a given height then changes the bones and not the path
    lengths_assumed: bool = False


@dataclass(frozen=True)
class Table:
    """Named columns over time: OpenSim coordinates, moments, any other signal."""

    #: Column names; OpenSim paths (``/jointset/hip_r/hip_flexion_r/value``) are reduced to the
    #: coordinate's name
    names: tuple[str, ...]
    time: Float[Array, " n_rows"]  #: Time of each row [s]
    values: Float[Array, "n_rows n_columns"]  #: SI units and radians; NaN where missing

    def __getitem__(self, name: str) -> Float[Array, " n_rows"]:
        """Return the column ``name``."""
        if name not in self.names:
            raise ParameterError(f"no column {name!r}; {known_names(name, self.names)}")
        return self.values[:, self.names.index(name)]


@dataclass(frozen=True)
class Recording:
    """Contents of one motion file and its companions.

    Attributes:
        source: The file it was read from.
        markers: Marker trajectories.
        skeleton: Motion of another skeleton.
        coordinates: OpenSim coordinates over time [rad, m] (pelvis translations in OpenSim's axes:
            x forward, y up, z right; rotated when applied to a Human).
        plates: Measured ground reactions.
        events: Gait events stored in the file.
        subject: Data of the person in the file.
        outputs: Model outputs stored in the file (Plug-in Gait angles, moments, powers, …), by
            name: (n_frames, 3) on the clock of the markers, in the units of the file; points
            computed by a model (joint centres, segment axes) in world axes [m], as the markers.
        warnings: Warnings of the reader, one sentence each.
        static: A standing trial of the same person.
        companions: Files besides ``source`` that it was read from: skeleton, standing trial,
            forces.
    """

    source: Path
    markers: Markers | None = None
    skeleton: SkeletonMotion | None = None
    coordinates: Table | None = None
    plates: tuple[ForcePlate, ...] = ()
    events: tuple[GaitEvent, ...] = ()
    subject: Subject = Subject()
    outputs: dict[str, np.ndarray] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    static: "Recording | None" = None
    companions: tuple[Path, ...] = ()

    def __repr__(self) -> str:
        parts: list[str] = []
        if self.markers is not None:
            parts.append(f"{len(self.markers.names)} markers in {self.markers.n_frames} frames")
        if self.skeleton is not None:
            parts.append(f"{len(self.skeleton.names)} joints of a skeleton")
        if self.coordinates is not None:
            parts.append(f"{len(self.coordinates.names)} coordinates")
        counts = ((len(self.plates), "force plate"), (len(self.events), "gait event"))
        parts += [f"{count} {what}{'s' * (count > 1)}" for count, what in counts if count]
        return f"Recording({self.source.name}: {', '.join(parts) or 'no motion'})"


def rate_of(time: Float[Array, " n_frames"]) -> float:
    """Return frames per second [Hz] of an evenly sampled clock; NaN for fewer than two frames."""
    return float((len(time) - 1) / (time[-1] - time[0])) if len(time) > 1 else float("nan")


def even_clock(time: Float[Array, " n_frames"]) -> Float[Array, " n_frames"]:
    """Return an evenly sampled clock without the rounding errors of its file.

    At 60 Hz a time printed in milliseconds is off by up to 3 % of a step: negligible for positions,
    but several body weights in forces derived from them. An uneven clock is returned unchanged.
    """
    if len(time) < 3:
        return time
    even = np.linspace(time[0], time[-1], len(time))
    return even if np.abs(time - even).max() < 0.1 * (even[1] - even[0]) else time
