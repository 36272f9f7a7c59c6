r"""C3D files written: the float format of Intel processors, after the user guide of c3d.org.

A file is a header of one block of 512 bytes, blocks of parameters, and the frames: of each point x,
y, z and a residual (-1 where it is not seen), then the analog samples of that frame.
"""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError
from plantigrade.io.force_plates import plate_axes
from plantigrade.io.writing import write_bytes
from plantigrade.motion.recording import ForcePlate, GaitEvent, Recording, Subject, rate_of

BLOCK = 512  # Bytes of a block
MAX_LIST = 255
"""Maximum length of a parameter's list, because dimensions are bytes; ``LABELS2`` … continue it."""
Parameters = dict[str, dict[str, Any]]
"""Values by group and name: strings, or numbers whose first dimension varies fastest."""


def write_c3d(recording: Recording, path: str | Path) -> None:
    """Write markers, force plates (type 2) and events; world axes z up, points in mm.

    Plates are resampled to the smallest multiple of the marker rate that is not below their own. A
    plate with unknown corners is written as 0.5 m by 0.5 m, centred on its mean centre of pressure.
    """
    markers = recording.markers
    if markers is None or markers.n_frames == 0:
        raise FileError(
            path,
            "the recording has no markers, which a C3D file needs",
            remedy="write joint angles to .mot or .npz, another skeleton to .bvh",
        )
    rate = _even_rate(markers.time, path)
    first = max(int(round(markers.time[0] * rate)) + 1, 1)
    last = first + markers.n_frames - 1
    if last > 65535:
        remedy = "shorten the recording, or write .trc or .csv"
        raise FileError(
            path, f"frame {last} exceeds 65535, the last of a C3D header", remedy=remedy
        )
    shift = (first - 1) / rate - markers.time[0]
    per_frame = _samples_per_frame(recording.plates, rate)
    samples, parameters = _plates(
        recording.plates, markers.time[0], rate, per_frame, markers.n_frames
    )
    point = {"USED": len(markers.names), "SCALE": -1.0, "RATE": rate, "DATA_START": 0}
    point |= {"FRAMES": markers.n_frames, "X_SCREEN": ["+X"], "Y_SCREEN": ["+Z"], "UNITS": ["mm"]}
    for k, more in _portions(len(markers.names)):
        names = list(markers.names[k : k + MAX_LIST])
        point |= {f"LABELS{more}": names, f"DESCRIPTIONS{more}": [""] * len(names)}
    parameters = {"POINT": point} | parameters | _events(recording.events, shift)
    parameters |= _subject(recording.subject)
    seen = np.isfinite(markers.positions).all(axis=2)
    points = np.zeros((*seen.shape, 4))
    points[seen, :3] = 1e3 * markers.positions[seen]
    points[..., 3] = np.where(seen, 0.0, -1.0)
    content = c3d_bytes(points, samples, parameters, rate, first, path)
    write_bytes(path, content)


def c3d_bytes(
    points: Float[Array, "n_frames n_points 4"],
    samples: Float[Array, "n_frames per_frame n_channels"],
    parameters: Parameters,
    rate: float,
    first: int,
    path: str | Path,
) -> bytes:
    """Return a C3D file.

    Args:
        points: Positions in the unit of the file, and residual; -1 if not visible.
        parameters: Content of the parameter section; ``POINT:DATA_START`` is filled in.
        rate: Frames per second [Hz].
        first: Number of the first frame, from 1.
    """
    n_frames, n_points = points.shape[:2]
    per_frame, n_channels = samples.shape[1:]
    n_blocks = -(-len(_section(parameters, path)) // BLOCK)
    if n_blocks > 255 or max(n_points, per_frame * n_channels) > 65535:
        remedy = "write fewer markers, or .trc or .csv"
        raise FileError(path, f"{n_points} points are too many for a C3D file", remedy=remedy)
    parameters["POINT"]["DATA_START"] = 2 + n_blocks
    section = bytearray(_section(parameters, path).ljust(BLOCK * n_blocks, b"\0"))
    section[2] = n_blocks
    header = struct.pack(
        "<BB5HfHHf", 2, 0x50, n_points, per_frame * n_channels, first, first + n_frames - 1, 0,
        -1.0, 2 + n_blocks, per_frame, rate,
    )  # fmt: skip
    frames = [points.reshape(n_frames, -1), samples.reshape(n_frames, -1)]
    data = np.concatenate(frames, axis=1).astype("<f4").tobytes()
    whole = header.ljust(BLOCK, b"\0") + bytes(section) + data
    return whole.ljust(-(-len(whole) // BLOCK) * BLOCK, b"\0")


def _section(parameters: Parameters, path: str | Path) -> bytes:
    """Return the parameters; the processor is Intel's."""
    found = bytes([1, 0x50, 0, 84])
    for number, (group, entries) in enumerate(parameters.items(), start=1):
        found += struct.pack("<bb", len(group), -number) + group.encode("ascii")
        found += struct.pack("<hB", 3, 0)
        for name, value in entries.items():
            body = _value(value)
            if len(body) + 3 > 32767:
                remedy = "shorten the names of the markers"
                raise FileError(path, f"{name} is too long for a C3D file", remedy=remedy)
            found += struct.pack("<bb", len(name), number) + name.encode("ascii")
            found += struct.pack("<h", len(body) + 3) + body + b"\0"
    return found + b"\0\0"


def _value(value: Any) -> bytes:
    """Return kind, dimensions and content of a parameter."""
    if isinstance(value, list):
        raw = [word.encode("latin-1", "replace")[:255] for word in value]
        width = max(map(len, raw), default=0)
        return struct.pack("<bBBB", -1, 2, width, len(raw)) + b"".join(w.ljust(width) for w in raw)
    array = np.asarray(value)
    kind, form = (2, "<i2") if array.dtype.kind == "i" else (4, "<f4")
    if kind == 2:
        array = array.astype("<u2").view("<i2")  # counts above 32767 have no sign
    head = bytes([kind, array.ndim, *array.shape])
    return head + array.ravel(order="F").astype(form).tobytes()


def _plates(
    plates: tuple[ForcePlate, ...], start: float, rate: float, per_frame: int, n_frames: int
) -> tuple[Float[Array, "n_frames per_frame n_channels"], Parameters]:
    """Return the samples of force plates and their parameters."""
    clock = start + np.arange(n_frames * per_frame) / (rate * per_frame)
    n = len(plates)
    samples, corners = np.zeros((len(clock), 6 * n)), np.zeros((3, 4, n))
    for i, plate in enumerate(plates):
        force, cop, free = _on_clock(plate, clock)
        four = plate.corners if plate.corners is not None else _invented_corners(plate)
        axes = plate_axes(four)
        if axes[2, 2] > 0:  # listed the other way round: keep z into the ground
            four = four[[1, 0, 3, 2]]
            axes = plate_axes(four)
        arm = np.where(np.isfinite(cop), cop - four.mean(axis=0), 0.0)
        moment = np.cross(arm, force)
        moment[:, 2] += free
        samples[:, 6 * i : 6 * i + 3] = -force @ axes  # on the plate [N]
        samples[:, 6 * i + 3 : 6 * i + 6] = -1e3 * moment @ axes  # [N mm]
        corners[..., i] = four.T * 1e3
    names = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
    labels = [f"{axis}{i + 1}" for i in range(n) for axis in names]
    analog = {
        "USED": 6 * n, "LABELS": labels, "DESCRIPTIONS": [""] * (6 * n), "GEN_SCALE": 1.0,
        "SCALE": np.ones(6 * n), "OFFSET": np.zeros(6 * n, dtype=int),
        "UNITS": ["N", "N", "N", "Nmm", "Nmm", "Nmm"] * n, "RATE": rate * per_frame if n else 0.0,
    }  # fmt: skip
    platform = {
        "USED": n, "TYPE": np.full(n, 2), "ZERO": np.array([1, 0]), "CORNERS": corners,
        "ORIGIN": np.zeros((3, n)), "CHANNEL": np.arange(1, 6 * n + 1).reshape(n, 6).T,
    }  # fmt: skip
    shaped = samples.reshape(n_frames, per_frame, 6 * n)
    return shaped, {"ANALOG": analog, "FORCE_PLATFORM": platform}


def _events(events: tuple[GaitEvent, ...], shift: float) -> Parameters:
    if not events:
        return {}
    names = {"heel_strike": "Foot Strike", "toe_off": "Foot Off"}
    times = np.array([[(e.time + shift) // 60, (e.time + shift) % 60] for e in events]).T
    contexts = [{"l": "Left", "r": "Right"}[e.side] for e in events]
    labels = [names[e.kind] for e in events]
    event_group: dict[str, Any] = {"USED": len(events)}
    for k, more in _portions(len(events)):
        part = slice(k, k + MAX_LIST)
        event_group |= {f"CONTEXTS{more}": contexts[part], f"LABELS{more}": labels[part]}
        event_group[f"TIMES{more}"] = times[:, part]
    return {"EVENT": event_group}


def _portions(count: int) -> Iterator[tuple[int, str]]:
    """Yield start index and number of each portion of a list that fits into a parameter."""
    for k in range(0, count, MAX_LIST):
        yield k, str(k // MAX_LIST + 1) if k else ""


def _subject(subject: Subject) -> Parameters:
    mm = None if subject.height is None else 1e3 * subject.height
    leg = None if subject.leg_length is None else 1e3 * subject.leg_length
    processing = {"BODYMASS": subject.mass, "HEIGHT": mm, "LLEGLENGTH": leg, "RLEGLENGTH": leg}
    words = {"SEX": subject.sex, "NAMES": subject.name}
    subjects = {k: None if v is None else [v] for k, v in words.items()} | {"AGE": subject.age}
    trial = {"DATE": None if subject.date is None else [subject.date]}
    groups = {"PROCESSING": processing, "SUBJECTS": subjects, "TRIAL": trial}
    known = {g: {k: v for k, v in d.items() if v is not None} for g, d in groups.items()}
    return {
        group: {k: v if isinstance(v, list) else np.array([float(v)]) for k, v in entries.items()}
        for group, entries in known.items()
        if entries
    }


def _even_rate(time: np.ndarray, path: str | Path) -> float:
    if len(time) == 1:
        return 100.0
    steps = np.diff(time)
    step = float(np.median(steps))
    if not step > 0 or np.abs(steps - step).max() > 0.05 * step:
        raise FileError(
            path,
            "the markers are not evenly sampled in time, which C3D cannot store",
            remedy="resample them first, or write .trc or .csv",
        )
    rate = rate_of(time)
    return float(round(rate)) if abs(rate - round(rate)) < 1e-3 * rate else rate


def _samples_per_frame(plates: tuple[ForcePlate, ...], rate: float) -> int:
    rates = [rate_of(p.time) for p in plates if len(p.time) > 1]
    return max(1, int(np.ceil(max(rates, default=rate) / rate - 1e-3)))


def _on_clock(plate: ForcePlate, clock: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return force, centre of pressure and free moment at the times ``clock``; 0 outside."""
    if len(plate.time) == len(clock) and np.abs(plate.time - clock).max() < 1e-6:
        return plate.force, plate.cop, np.nan_to_num(plate.free_moment)

    def at(values, outside):
        return np.interp(clock, plate.time, values, left=outside, right=outside)

    force = np.stack([at(np.nan_to_num(plate.force[:, k]), 0.0) for k in range(3)], axis=1)
    seen = at(np.isfinite(plate.cop).all(axis=1).astype(float), 0.0) > 0.999
    cop = np.stack([at(np.nan_to_num(plate.cop[:, k]), np.nan) for k in range(3)], axis=1)
    cop[~seen] = np.nan
    return force, cop, at(np.nan_to_num(plate.free_moment), 0.0)


def _invented_corners(plate: ForcePlate) -> np.ndarray:
    seen = plate.cop[np.isfinite(plate.cop).all(axis=1)]
    centre = seen.mean(axis=0) if len(seen) else np.zeros(3)
    # By quadrant of axes x, -y, into the ground: clockwise seen from above.
    return centre + 0.25 * np.array([[1, -1, 0], [-1, -1, 0], [-1, 1, 0], [1, 1, 0]], dtype=float)
