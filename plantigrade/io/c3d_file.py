"""The C3D container: header, parameters, points and analog samples as stored.

It is read with NumPy alone. ezc3d, an established C++ library, is the reference in the tests; it
does not read files here because a single changed byte in a header can end the whole process (a
segmentation fault in 2 to 3 of 100 random changes). Here every count is checked against the size of
the file before anything is allocated.

References:
    The C3D File Format, user guide, c3d.org (header words, parameter records, processor types).
"""

import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError
from plantigrade.io.axes import is_seen
from plantigrade.io.length import check_length
from plantigrade.io.text import reading

BLOCK = 512  # [bytes]
LIMIT_BYTES = 2e9  # [bytes] largest C3D file read

BYTES_OF_A_POINT = 100
"""Measured memory per point of a frame while reading [bytes]; an analog sample takes that of four
numbers."""

_SUFFIXES = ("", *map(str, range(2, 256)))  # of a list and what continues it
# Codes of the processor whose numbers the file holds.
_INTEL, _DEC, _MIPS = 84, 85, 86
_EXPORT_AGAIN = "export the recording again; the file is damaged or cut off"


@dataclass(frozen=True)
class Parameters:
    """Parameters of a C3D file."""

    #: Values by group and name, both upper case: a list of strings or an array (first dimension of
    #: the file first)
    groups: dict[str, dict[str, np.ndarray | list[str]]]

    def strings(self, group: str, name: str) -> list[str]:
        """Return a list of strings with its continuations (``LABELS``, ``LABELS2`` …)."""
        found: list[str] = []
        entries = self.groups.get(group, {})
        for suffix in _SUFFIXES:
            value = entries.get(name + suffix)
            if value is None:
                break
            found += value if isinstance(value, list) else []
        return found

    def values(self, group: str, name: str) -> np.ndarray:
        """Return numbers, one axis per dimension; empty if there are none."""
        value = self.groups.get(group, {}).get(name)
        return value if isinstance(value, np.ndarray) else np.empty(0)

    def continued(self, group: str, name: str) -> np.ndarray:
        """Return numbers with their continuations, the last axis going on in ``TIMES2`` …."""
        parts = [self.values(group, name + suffix) for suffix in _SUFFIXES]
        alike = [part for part in parts if part.size and part.shape[:-1] == parts[0].shape[:-1]]
        return np.concatenate(alike, axis=-1) if len(alike) > 1 else parts[0]

    def integers(self, group: str, name: str) -> np.ndarray:
        """Return integers; 0 replaces what is not an integer or exceeds 32 bits."""
        values = self.values(group, name).astype(float)
        return np.where(np.abs(values) < 2**31, values, 0.0).astype(int)

    def value(self, group: str, name: str) -> float:
        """Return one number, NaN if there is none."""
        values = self.values(group, name)
        return float(values.flat[0]) if values.size else float("nan")


@dataclass(frozen=True)
class C3dFile(Parameters):
    """Contents of a C3D file before interpretation.

    Attributes:
        groups: As in :class:`Parameters`.
    """

    first_frame: int  #: Number of the first frame, from 1
    rate: float  #: Frames per second [Hz]
    #: Positions in the file's unit; NaN where the file marks a point as missing
    points: Float[Array, "n_frames n_points 3"]
    #: Reconstruction residual in the file's unit, -1 where missing
    residuals: Float[Array, "n_frames n_points"]
    #: Samples, scaled to the units of ANALOG:UNITS, one channel per column
    analog: Float[Array, "n_samples n_channels"]
    analog_rate: float  #: Samples per second [Hz]; 0 without analog channels
    #: Label and time [s] of the events of the header (older files)
    header_events: tuple[tuple[str, float], ...]


def read_c3d_file(path: str | Path) -> C3dFile:
    """Read the container."""
    path = Path(path)
    with reading(path), open(path, "rb") as file:
        size = os.fstat(file.fileno()).st_size
        if size > LIMIT_BYTES:
            raise FileError(
                path,
                f"has {size / 1e6:.0f} MB, more than the {LIMIT_BYTES / 1e6:.0f} MB read",
                remedy="cut the recording to the relevant part",
            )
        return _read(path, file, size)


def _read(path: Path, file, size: int) -> C3dFile:
    head = file.read(BLOCK)
    if not head:
        raise FileError(path, "is empty", remedy="export the recording again")
    if len(head) < BLOCK or head[1] != 0x50:
        raise FileError(
            path,
            "is not a C3D file (its second byte must be 0x50 and its header 512 bytes long)",
            where="header",
            remedy="check that its extension matches its format",
        )
    start = (head[0] - 1) * BLOCK
    if start < BLOCK or start + BLOCK > size:
        problem = f"the parameters should start at block {head[0]}, outside the file"
        raise FileError(path, problem, where="header, word 1", remedy=_EXPORT_AGAIN)
    file.seek(start)
    raw = file.read(255 * BLOCK)
    processor = raw[3]
    if processor not in (_INTEL, _DEC, _MIPS):
        problem = f"processor type {processor} is none of 84 (Intel), 85 (DEC), 86 (MIPS)"
        raise FileError(path, problem, where="parameter section, byte 4", remedy=_EXPORT_AGAIN)
    header = _Header(head, processor)
    # Some programs count too few blocks of parameters; the data begin where the header says.
    n_blocks = max(raw[2] or 255, header.data_block - head[0])
    parameters = _ParameterSection(path, raw[: n_blocks * BLOCK], processor).parse()
    return _read_data(path, file, size, header, parameters, processor)


class _Header:
    """The words of the header that are used."""

    def __init__(self, head: bytes, processor: int):
        order = ">" if processor == _MIPS else "<"
        words = np.frombuffer(head, dtype=f"{order}u2").astype(int)
        self.n_points, self.analog_per_frame = int(words[1]), int(words[2])
        self.first, self.last = int(words[3]), int(words[4])
        self.scale = float(_floats(head[12:16], processor)[0])
        self.data_block, self.samples_per_frame = int(words[8]), int(words[9])
        self.rate = float(_floats(head[20:24], processor)[0])
        self.events: tuple[tuple[str, float], ...] = ()
        n_events = int(words[150])
        if words[149] == 12345 and 0 < n_events <= 18:
            times = _floats(head[304 : 304 + 4 * n_events], processor)
            names = [head[396 + 4 * i : 400 + 4 * i] for i in range(n_events)]
            self.events = tuple(
                (name.decode("latin-1").strip("\0 "), float(t))
                for name, t in zip(names, times, strict=True)
                if np.isfinite(t)
            )


class _ParameterSection:
    """Reader of the chain of parameter records, bounded by the section."""

    def __init__(self, path: Path, raw: bytes, processor: int):
        self.path, self.raw, self.processor = path, raw, processor
        self.order = ">" if processor == _MIPS else "<"

    def error(self, position: int, problem: str) -> FileError:
        where = f"parameter section, byte {position}"
        return FileError(self.path, problem, where=where, remedy=_EXPORT_AGAIN)

    def take(self, position: int, count: int) -> bytes:
        if position < 0 or position + count > len(self.raw):
            raise self.error(position, f"{count} bytes should follow, the section ends before")
        return self.raw[position : position + count]

    def parse(self) -> Parameters:
        groups: dict[int, str] = {}
        records: list[tuple[int, str, np.ndarray | list[str]]] = []
        position = 4
        while position + 2 <= len(self.raw):
            n_name, group = np.frombuffer(self.raw[position : position + 2], dtype="i1").tolist()
            n_name = abs(n_name)
            if n_name == 0 or group == 0:
                break
            name = self.take(position + 2, n_name).decode("latin-1").strip("\0 ").upper()
            pointer = position + 2 + n_name
            offset = int(np.frombuffer(self.take(pointer, 2), dtype=f"{self.order}i2")[0])
            if group < 0:
                groups[-group] = name
            else:
                records.append((group, name, self.record(pointer + 2, name)))
            if offset == 0:
                break
            if offset < 2:
                raise self.error(pointer, f"the record after {name!r} should lie {offset} bytes on")
            position = pointer + offset
        found: dict[str, dict] = {name: {} for name in groups.values()}
        for group, name, value in records:
            found.setdefault(groups.get(group, f"GROUP {group}"), {})[name] = value
        return Parameters(found)

    def record(self, position: int, name: str) -> np.ndarray | list[str]:
        kind, n_dims = self.take(position, 2)
        kind -= 256 * (kind > 127)
        if kind not in (-1, 1, 2, 4) or n_dims > 7:
            raise self.error(
                position, f"{name!r} has type {kind} with {n_dims} dimensions (-1, 1, 2, 4; ≤ 7)"
            )
        dims = list(self.take(position + 2, n_dims))
        count = int(np.prod(dims, dtype=np.int64)) if dims else 1
        raw = self.take(position + 2 + n_dims, count * abs(kind))
        if kind == -1:
            text = raw.decode("latin-1")
            if len(dims) < 2:
                return [text.strip("\0 \t")]
            width = dims[0]
            n = count // width if width else 0
            return [text[i * width : (i + 1) * width].strip("\0 \t") for i in range(n)]
        if kind == 4:
            with np.errstate(invalid="ignore"):
                values = _floats(raw, self.processor).astype(float)
        else:
            values = np.frombuffer(raw, dtype="i1" if kind == 1 else f"{self.order}i2").astype(int)
        return values.reshape(dims, order="F") if dims else values


def _read_data(path, file, size, header: _Header, bare: Parameters, processor) -> C3dFile:
    broken = partial(FileError, path, remedy=_EXPORT_AGAIN)
    scale = bare.value("POINT", "SCALE")
    if not np.isfinite(scale) or scale == 0:
        scale = header.scale
    if not np.isfinite(scale) or scale == 0:
        scale = -1.0  # if both are missing, points are floats, as in files of current programs
    rate = bare.value("POINT", "RATE")
    if not 0 < rate < 1e5:
        rate = header.rate
    if not 0 < rate < 1e5:
        raise FileError(
            path,
            f"{rate} frames per second",
            where="header, words 11 and 12, and POINT:RATE",
            remedy="correct the frame rate and export again",
        )
    total, samples_per_frame = header.analog_per_frame, header.samples_per_frame
    if samples_per_frame > 1 and total == bare.value("ANALOG", "USED"):
        total *= samples_per_frame  # some programs count the channels alone
    if total and (samples_per_frame == 0 or total % samples_per_frame):
        raise broken(
            f"{total} analog numbers per frame do not divide into {samples_per_frame} samples",
            where="header, words 3 and 10",
        )
    n_channels = total // samples_per_frame if total else 0
    word = 4 if scale < 0 else 2
    frame_words = 4 * header.n_points + total
    if frame_words == 0:
        raise broken("contains neither points nor analog channels", where="header")
    start = (header.data_block - 1) * BLOCK
    if header.data_block < 2 or start > size:
        raise broken(
            f"the data should start at block {header.data_block}, outside the file",
            where="header, word 9",
        )
    first, n_frames = _frames(bare, header)
    room = (size - start) // (frame_words * word)
    if n_frames < 1 or n_frames > room:
        raise broken(
            f"the header announces {n_frames} frames of {header.n_points} points and "
            f"{n_channels} analog channels, the file has room for {room}",
            where="header, words 2 to 5",
        )
    check_length(path, n_frames, n_frames * (BYTES_OF_A_POINT * header.n_points + 8 * 4 * total))
    file.seek(start)
    count = n_frames * frame_words
    raw = file.read(count * word)
    order = ">" if processor == _MIPS else "<"
    unsigned = "UNSIGNED" in "".join(bare.strings("ANALOG", "FORMAT")).upper()
    if word == 4:
        table = _floats(raw, processor).reshape(n_frames, frame_words)
    else:
        table = np.frombuffer(raw, dtype=f"{order}i2").reshape(n_frames, frame_words)
    points, residuals = _points(table[:, : 4 * header.n_points], scale, n_frames)
    analog = table[:, 4 * header.n_points :]
    if word == 2 and unsigned:
        analog = analog.astype(np.int64) & 0xFFFF
    analog = _scaled_analog(bare, analog.reshape(-1, n_channels) if n_channels else analog)
    analog_rate = rate * samples_per_frame if n_channels else 0.0
    return C3dFile(bare.groups, first, rate, points, residuals, analog, analog_rate, header.events)


def _frames(bare: Parameters, header: _Header) -> tuple[int, int]:
    """Return the number of the first frame and the number of frames.

    The header counts to 65535; longer recordings use TRIAL:ACTUAL_START_FIELD and
    ACTUAL_END_FIELD (low word, high word), POINT:LONG_FRAMES or POINT:FRAMES.
    """
    fields = []
    for name in ("ACTUAL_START_FIELD", "ACTUAL_END_FIELD"):
        low_high = bare.values("TRIAL", name).reshape(-1)
        fields.append(
            (int(low_high[0]) & 0xFFFF) + ((int(low_high[1]) & 0xFFFF) << 16)
            if low_high.size >= 2 and low_high.dtype.kind == "i"
            else 0
        )
    start, end = fields
    if header.last < 65535 and header.last >= header.first:
        return max(header.first, 1), header.last - header.first + 1
    if 0 < start <= end:
        return start, end - start + 1
    for name in ("LONG_FRAMES", "FRAMES"):
        n = bare.value("POINT", name)
        if np.isfinite(n) and n != 0:
            n = int(n) & 0xFFFF if name == "FRAMES" and n < 0 else int(n)
            return max(header.first, 1), n
    return max(header.first, 1), header.last - header.first + 1


def _points(table: np.ndarray, scale: float, n_frames: int) -> tuple[np.ndarray, np.ndarray]:
    quads = table.reshape(n_frames, -1, 4)
    with np.errstate(all="ignore"):  # a broken file may hold signalling NaN
        points = quads[..., :3].astype(float)
        fourth = quads[..., 3].astype(float)
        if scale > 0:
            points *= scale
        # low byte: residual in units of scale; high byte: which cameras saw it; negative: not seen
        whole = np.where(np.abs(fourth) < 2**31, fourth, -1.0).astype(int)
        residuals = np.where(whole < 0, -1.0, (whole & 0xFF) * abs(scale))
        seen = (whole >= 0) & is_seen(points)
        seen &= (np.abs(points) < 1e9).all(axis=2)
    points[~seen] = np.nan
    residuals[~seen] = -1
    return points, residuals


def _scaled_analog(bare: Parameters, raw: np.ndarray) -> np.ndarray:
    """Return ``(raw - OFFSET) * SCALE * GEN_SCALE``."""
    n = raw.shape[1]
    if n == 0:
        return np.empty((0, 0))

    def per_channel(name: str, default: float) -> np.ndarray:
        found = [bare.values("ANALOG", name + s).reshape(-1) for s in ("", *map(str, range(2, 9)))]
        values = np.concatenate(found)[:n].astype(float)
        return np.concatenate([values, np.full(n - len(values), default)])

    offset = per_channel("OFFSET", 0.0)
    if "UNSIGNED" in "".join(bare.strings("ANALOG", "FORMAT")).upper():
        offset = np.where(offset < 0, offset + 65536, offset)
    general = bare.value("ANALOG", "GEN_SCALE")
    with np.errstate(all="ignore"):
        scale = per_channel("SCALE", 1.0) * (general if np.isfinite(general) else 1.0)
        return (raw - offset) * scale


def _floats(raw: bytes, processor: int) -> np.ndarray:
    """Return 4-byte floats of the file's processor as native ones."""
    if processor == _DEC:  # VAX F: the two 16-bit halves exchanged, four times the value
        halves = np.frombuffer(raw, dtype="<u2").reshape(-1, 2)[:, ::-1]
        with np.errstate(all="ignore"):
            return np.ascontiguousarray(halves).view("<f4").reshape(-1) / np.float32(4)
    return np.frombuffer(raw, dtype=">f4" if processor == _MIPS else "<f4")
