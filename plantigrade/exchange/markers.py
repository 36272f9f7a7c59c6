"""Virtual motion capture: the markers of a body in motion and its ground reactions, as a recording.

Whatever program reads a laboratory's files can so be given a run: C3D with force plates, TRC, and
OpenSim's coordinates with their forces.
"""

from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.exchange.clock import at_rate
from plantigrade.io.c3d_writer import write_c3d
from plantigrade.io.mot import write_mot
from plantigrade.io.trc import write_trc
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.models.markers import marker_set_of, places_of
from plantigrade.motion import ForcePlate, Markers, Motion, Recording, Subject, Table
from plantigrade.motion.filters import interpolate
from plantigrade.record import FootForce, Record, Run

DEFAULT_SET = "oxford-foot-model"
"""Marker set of a run that was not fitted to markers: Plug-in Gait's and those of the foot."""
MIN_LOAD = 1e-3  #: Vertical force above which a foot has a centre of pressure [body weights]
PLATE_MARGIN = 0.15  #: Distance from the centre of pressure to the edge of its plate, at least [m]


def write_markers_c3d(
    run: Run, path: Path, marker_set: str | None = None, rate: float | None = None
) -> tuple[str, ...]:
    """Write markers on the body, ground reactions, events and the person as C3D.

    Each foot has a force plate of its own, so long that the foot never leaves it; forces keep the
    rate of the run.

    Args:
        marker_set: Name of a marker set, or path of a TOML file; by default the recorded markers
            where the run was fitted to some, :data:`DEFAULT_SET` otherwise.
        rate: Frames per second [Hz]; those of the motion if absent.

    Raises:
        ParameterError: If marker set or rate is not allowed.
        FileError: If the file cannot be written, or the marker set cannot be read.
    """
    recording, notes = recording_of(run, marker_set, rate)
    write_c3d(recording, path)
    return notes


def write_markers_trc(
    run: Run, path: Path, marker_set: str | None = None, rate: float | None = None
) -> tuple[str, ...]:
    """Write markers on the body as TRC; ground reactions go to ``NAME_grf.mot`` beside it.

    The arguments are those of :func:`write_markers_c3d`.

    Raises:
        ParameterError: If marker set or rate is not allowed.
        FileError: If the file cannot be written, or the marker set cannot be read.
    """
    recording, notes = recording_of(run, marker_set, rate)
    write_trc(recording, path)
    return (*notes, *_forces_beside(recording, path))


def write_coordinates(run: Run, path: Path, rate: float | None = None) -> tuple[str, ...]:
    """Write OpenSim's coordinates; ground reactions go to ``NAME_grf.mot`` beside the file.

    Args:
        rate: Frames per second [Hz]; those of the motion if absent.

    Raises:
        ParameterError: If the rate is not allowed.
        FileError: If the file cannot be written.
    """
    motion = at_rate(run.record.motion, rate)
    names, values = run.record.human.file_coordinates(motion.qpos)
    write_mot(Table(names, motion.time, values), path)
    plates, notes = plates_of(run.with_forces)
    return (*notes, *_forces_beside(Recording(path, plates=plates), path))


def _forces_beside(recording: Recording, path: Path) -> tuple[str, ...]:
    if not recording.plates:
        return ()
    forces = path.with_name(f"{path.stem}_grf.mot")
    write_mot(recording.plates, forces)
    return (f"the ground reactions were written to {forces.name}",)


def recording_of(
    run: Run, marker_set: str | None = None, rate: float | None = None
) -> tuple[Recording, tuple[str, ...]]:
    """Return what a laboratory would have recorded of a run, and notes.

    The arguments are those of :func:`write_markers_c3d`.

    Raises:
        ParameterError: If marker set or rate is not allowed.
        FileError: If the marker set cannot be read.
    """
    record, human = run.record, run.record.human
    motion = at_rate(record.motion, rate)
    plates, notes = plates_of(run.with_forces)
    sex = run.figures.get("sex")
    recording = Recording(
        Path(run.name or run.kind),
        markers=_markers(record, motion, marker_set),
        plates=plates,
        events=motion.events,
        subject=Subject(
            height=human.height, mass=human.mass, sex=sex if isinstance(sex, str) else human.sex
        ),
    )
    return recording, notes


def _markers(record: Record, motion: Motion, marker_set: str | None) -> Markers:
    """Return markers on the body, on the frames of a motion."""
    recorded, fitted = record.recorded_markers, record.fitted_markers
    if marker_set is None and recorded is not None and fitted is not None:
        positions = fitted
        if motion.n_frames != len(fitted):
            positions = interpolate(motion.time, record.motion.time, fitted)
        there = np.asarray(np.isfinite(positions).any(axis=(0, 2)))
        names = tuple(n for n, seen in zip(recorded.names, there, strict=True) if seen)
        return Markers(names, motion.time, positions[:, there])
    return body_markers(record.human, motion, marker_set or DEFAULT_SET)


def body_markers(human: Human, motion: Motion, marker_set: str) -> Markers:
    """Return the markers of a set on a person in motion.

    Raises:
        ParameterError: If there is no such set, or it names what the body has not.
        FileError: If the file cannot be read.
    """
    places: dict[str, Attachment] = {}
    for name, place in places_of(marker_set_of(marker_set), human).items():
        if not any(_same(place, other) for other in places.values()):
            places[name] = place
    points = PointSet.of(human, list(places.values()))
    return Markers(tuple(places), motion.time, points.path(motion.qpos))


def _same(a: Attachment, b: Attachment) -> bool:
    """Return whether two markers of a set have one landmark: a file would hold one path twice."""
    return a.body == b.body and bool(np.array_equal(a.position, b.position))


def plates_of(record: Record) -> tuple[tuple[ForcePlate, ...], tuple[str, ...]]:
    """Return the ground reaction on each foot as that of a force plate, and notes.

    The plate lies at the mean height of the foot's centre of pressure; force and moment are those
    of the record to the last digit, also where it stood on a slope or on steps.
    """
    if not record.has_forces:
        return (), ("the run holds no ground reactions",)
    plates, notes = [], []
    for side in SIDES:
        foot = record.foot(side)
        plate = _plate(record, side, foot)
        if plate is not None:
            plates.append(plate)
        unknown = 1.0 - foot.known.mean()
        if plate is not None and unknown > 0:
            notes.append(
                f"the force on the {SIDE_NAMES[side]} foot is not known in {unknown:.0%} of the "
                "frames; it is zero there"
            )
    return tuple(plates), tuple(notes)


def _plate(record: Record, side: str, foot: FootForce) -> ForcePlate | None:
    force = np.where(foot.known[:, None], np.nan_to_num(foot.force), 0.0)
    loaded = np.isfinite(foot.centre_of_pressure).all(axis=1) & foot.known
    loaded &= force[:, 2] > MIN_LOAD * record.weight
    if not loaded.any():
        return None
    places = foot.centre_of_pressure[loaded]
    weights = force[loaded, 2]
    height = float(weights @ places[:, 2] / weights.sum())
    centre = np.array([*places[:, :2].mean(axis=0), height])
    force[~loaded] = 0.0
    cop = np.full_like(force, np.nan)
    moment = np.cross(places - centre, force[loaded]) + np.nan_to_num(foot.torque[loaded])
    fx, fy, fz = force[loaded].T
    x, y = -moment[:, 1] / fz, moment[:, 0] / fz
    cop[loaded] = centre + np.stack([x, y, np.zeros_like(x)], axis=1)
    free = np.zeros(len(force))
    free[loaded] = moment[:, 2] - (x * fy - y * fx)
    return ForcePlate(
        f"ground_force_{side}", record.motion.time, force, cop, free, _corners(cop), side
    )


def _corners(cop: Float[Array, "n 3"]) -> Float[Array, "4 3"]:
    """Return the corners of a plate under all centres of pressure, clockwise seen from above."""
    low, high = np.nanmin(cop, axis=0) - PLATE_MARGIN, np.nanmax(cop, axis=0) + PLATE_MARGIN
    z = float(np.nanmean(cop[:, 2]))
    return np.array([[high[0], low[1], z], [low[0], low[1], z], [low[0], high[1], z],
                     [high[0], high[1], z]])  # fmt: skip
