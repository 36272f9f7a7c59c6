"""The C3D container: header, parameters, points and analog samples as stored.

It is read with NumPy alone. ezc3d, an established C++ library, is the reference in the tests and
the writer in :mod:`plantigrade.io.c3d`; it does not read files here because a single changed byte
in a header can end the whole process (a segmentation fault in 2 to 3 of 100 random changes). Here
every count is checked against the size of the file before anything is allocated.

References:
    The C3D File Format, user guide, c3d.org (header words, parameter records, processor types).
"""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError

BLOCK = 512  # [bytes]
LIMIT_BYTES = 2e9
"""Largest C3D file read [bytes]."""

_INTEL, _DEC, _MIPS = 84, 85, 86
_EXPORT_AGAIN = "export the recording again; the file is damaged or cut off"


@dataclass(frozen=True)
class C3dFile:
    """Contents of a C3D file before interpretation.

    Attributes:
        path: The file.
        parameters: Values by group and name, both upper case: a list of strings or an array
            (first dimension of the file first).
        first_frame: Number of the first frame, from 1.
        rate: Frames per second [Hz].
        points: Positions in the file's unit; NaN where the file marks a point as missing.
        residuals: Reconstruction residual in the file's unit, -1 where missing.
        analog: Samples, scaled to the units of ANALOG:UNITS, one channel per column.
        analog_rate: Samples per second [Hz]; 0 without analog channels.
        header_events: Label and time [s] of the events of the header (older files).
    """

    path: Path
    parameters: dict[str, dict[str, np.ndarray | list[str]]]
    first_frame: int
    rate: float
    points: Float[Array, "n_frames n_points 3"]
    residuals: Float[Array, "n_frames n_points"]
    analog: Float[Array, "n_samples n_channels"]
    analog_rate: float
    header_events: tuple[tuple[str, float], ...] = ()

    def strings(self, group: str, name: str) -> list[str]:
        """Return a list of strings with its continuations (``LABELS``, ``LABELS2`` …)."""
        found: list[str] = []
        entries = self.parameters.get(group, {})
        for suffix in ("", *map(str, range(2, 256))):
            value = entries.get(name + suffix)
            if value is None:
                break
            found += value if isinstance(value, list) else []
        return found

    def values(self, group: str, name: str) -> np.ndarray:
        """Return numbers, one axis per dimension; empty if there are none."""
        value = self.parameters.get(group, {}).get(name)
        return value if isinstance(value, np.ndarray) else np.empty(0)

    def integers(self, group: str, name: str) -> np.ndarray:
        """Return integers; 0 replaces what is not an integer or exceeds 32 bits."""
        values = self.values(group, name).astype(float)
        return np.where(np.abs(values) < 2**31, values, 0.0).astype(int)

    def value(self, group: str, name: str) -> float:
        """Return one number, NaN if there is none."""
        values = self.values(group, name)
        return float(values.flat[0]) if values.size else float("nan")


def read_c3d_file(path: str | Path) -> C3dFile:
    """Read the container.

    Raises:
        FileError: If the file is not a C3D file, or a count does not fit its size.
    """
    path = Path(path)
    try:
        if path.is_dir():
            raise FileError(path, "is a folder, not a file", remedy="name the file inside it")
        with open(path, "rb") as file:
            size = os.fstat(file.fileno()).st_size
            if size > LIMIT_BYTES:
                raise FileError(
                    path,
                    f"has {size / 1e6:.0f} MB, more than the {LIMIT_BYTES / 1e6:.0f} MB read",
                    remedy="cut the recording to the relevant part",
                )
            return _read(path, file, size)
    except FileNotFoundError:
        raise FileError(
            path, "there is no such file", remedy="check the name and the folder"
        ) from None
    except OSError as error:
        raise FileError(
            path, f"cannot be read ({error.strerror or error})", remedy="check its permissions"
        ) from error


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
        raise FileError(
            path,
            f"the parameters should start at block {head[0]}, outside the file",
            where="header, word 1",
            remedy=_EXPORT_AGAIN,
        )
    file.seek(start)
    raw = file.read(255 * BLOCK)
    processor = raw[3]
    if processor not in (_INTEL, _DEC, _MIPS):
        raise FileError(
            path,
            f"processor type {processor} is none of 84 (Intel), 85 (DEC), 86 (MIPS)",
            where="parameter section, byte 4",
            remedy=_EXPORT_AGAIN,
        )
    n_blocks = raw[2] or 255
    parameters = _Parameters(path, raw[: n_blocks * BLOCK], processor).parse()
    header = _Header(head, processor)
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


class _Parameters:
    """Reader of the chain of parameter records, bounded by the section."""

    def __init__(self, path: Path, raw: bytes, processor: int):
        self.path, self.raw, self.processor = path, raw, processor
        self.order = ">" if processor == _MIPS else "<"

    def error(self, position: int, problem: str) -> FileError:
        return FileError(
            self.path,
            problem,
            where=f"parameter section, byte {position}",
            remedy=_EXPORT_AGAIN,
        )

    def take(self, position: int, count: int) -> bytes:
        if position < 0 or position + count > len(self.raw):
            raise self.error(position, f"{count} bytes should follow, the section ends before")
        return self.raw[position : position + count]

    def parse(self) -> dict:
        groups: dict[int, str] = {}
        records: list[tuple[int, str, np.ndarray | list[str]]] = []
        position = 4
        while position + 2 <= len(self.raw):
            n_name = abs(int(np.int8(self.raw[position] - 256 * (self.raw[position] > 127))))
            group = self.raw[position + 1]
            group = group - 256 if group > 127 else group
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
        return found

    def record(self, position: int, name: str) -> np.ndarray | list[str]:
        kind, n_dims = self.take(position, 2)
        kind = kind - 256 if kind > 127 else kind
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


def _read_data(path, file, size, header: _Header, parameters, processor) -> C3dFile:
    bare = C3dFile(path, parameters, 1, 1.0, *_nothing())
    scale = bare.value("POINT", "SCALE")
    if not np.isfinite(scale) or scale == 0:
        scale = header.scale
    if not np.isfinite(scale) or scale == 0:
        scale = -1.0  # both missing: points as floats is what today's programs write
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
    samples_per_frame, n_channels = _analog_layout(path, header)
    word = 4 if scale < 0 else 2
    frame_words = 4 * header.n_points + header.analog_per_frame
    if frame_words == 0:
        raise FileError(
            path,
            "contains neither points nor analog channels",
            where="header",
            remedy=_EXPORT_AGAIN,
        )
    start = (header.data_block - 1) * BLOCK
    if header.data_block < 2 or start > size:
        raise FileError(
            path,
            f"the data should start at block {header.data_block}, outside the file",
            where="header, word 9",
            remedy=_EXPORT_AGAIN,
        )
    first, n_frames = _frames(bare, header)
    room = (size - start) // (frame_words * word)
    if n_frames < 1 or n_frames > room:
        raise FileError(
            path,
            f"the header announces {n_frames} frames of {header.n_points} points and "
            f"{n_channels} analog channels, the file has room for {room}",
            where="header, words 2 to 5",
            remedy=_EXPORT_AGAIN,
        )
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
    return C3dFile(
        path,
        parameters,
        first,
        rate,
        points,
        residuals,
        analog,
        rate * samples_per_frame if n_channels else 0.0,
        header.events,
    )


def _nothing() -> tuple:
    return np.empty((0, 0, 3)), np.empty((0, 0)), np.empty((0, 0)), 0.0


def _analog_layout(path: Path, header: _Header) -> tuple[int, int]:
    total, per_channel = header.analog_per_frame, header.samples_per_frame
    if total == 0:
        return 0, 0
    if per_channel == 0 or total % per_channel:
        raise FileError(
            path,
            f"{total} analog numbers per frame do not divide into {per_channel} samples",
            where="header, words 3 and 10",
            remedy=_EXPORT_AGAIN,
        )
    return per_channel, total // per_channel


def _frames(bare: C3dFile, header: _Header) -> tuple[int, int]:
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
        seen = (whole >= 0) & np.isfinite(points).all(axis=2) & (points != 0).any(axis=2)
        seen &= (np.abs(points) < 1e9).all(axis=2)
    points[~seen] = np.nan
    residuals[~seen] = -1
    return points, residuals


def _scaled_analog(bare: C3dFile, raw: np.ndarray) -> np.ndarray:
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
