"""Small C3D files byte by byte, after the format's user guide, for any processor."""

import struct

import numpy as np

INTEL, DEC, MIPS = 84, 85, 86


def build(
    points: np.ndarray,
    analog: np.ndarray,
    parameters: dict[str, dict],
    *,
    rate: float = 100.0,
    first: int = 1,
    processor: int = INTEL,
    scale: float = -1.0,
) -> bytes:
    """Return a C3D file.

    Args:
        points: (n_frames, n_points, 3) in the file's unit, NaN where not seen.
        analog: (n_frames, samples_per_frame, n_channels), raw numbers.
        parameters: By group and name: a number, list or array (first dimension fastest).
        rate: Frames per second.
        first: Number of the first frame.
        processor: Of whose making the numbers are.
        scale: Positive: 16-bit integers of so many units; negative: floats.
    """
    end = ">" if processor == MIPS else "<"
    n_frames, n_points = points.shape[:2]
    records = b"\1\x50\0" + bytes([processor])
    for number, (group, entries) in enumerate(parameters.items(), start=1):
        records += struct.pack("bb", len(group), -number) + group.encode()
        records += struct.pack(f"{end}h", 3) + b"\0"
        for name, value in entries.items():
            body = _value(value, end, processor)
            records += struct.pack("bb", len(name), number) + name.encode()
            records += struct.pack(f"{end}h", len(body) + 3) + body + b"\0"
    records += b"\0\0"
    blocks = -(-len(records) // 512)
    records = records[:2] + bytes([blocks]) + records[3:]
    header = bytearray(512)
    header[0:2] = b"\2\x50"
    words = (n_points, analog[0].size, first, first + n_frames - 1, 0)
    struct.pack_into(f"{end}5H", header, 2, *words)
    header[12:16] = floats([scale], processor)
    struct.pack_into(f"{end}2H", header, 16, 2 + blocks, analog.shape[1])
    header[20:24] = floats([rate], processor)
    seen = np.isfinite(points).all(axis=2)
    quads = np.concatenate([np.nan_to_num(points), np.where(seen, 0, -1)[..., None]], axis=2)
    if scale > 0:
        quads[..., :3] = np.rint(quads[..., :3] / scale)
    table = np.concatenate([quads.reshape(n_frames, -1), analog.reshape(n_frames, -1)], axis=1)
    data = table.astype(f"{end}i2").tobytes() if scale > 0 else floats(table.ravel(), processor)
    return (
        bytes(header) + records.ljust(512 * blocks, b"\0") + data.ljust(-(-len(data) // 512) * 512)
    )


def floats(values, processor: int) -> bytes:
    """Return 4-byte floats as the processor has them."""
    values = np.asarray(values, dtype=float)
    if processor == DEC:
        halves = (values * 4).astype("<f4").view("<u2").reshape(-1, 2)[:, ::-1]
        return np.ascontiguousarray(halves).tobytes()
    return values.astype(">f4" if processor == MIPS else "<f4").tobytes()


def _value(value, end: str, processor: int) -> bytes:
    if isinstance(value, str):
        value = [value]
    if isinstance(value, list) and value and isinstance(value[0], str):
        width = max(map(len, value))
        raw = "".join(v.ljust(width) for v in value).encode("latin-1")
        return struct.pack("bBBB", -1, 2, width, len(value)) + raw
    array = np.asarray(value)
    head = bytes([array.ndim, *array.shape])
    flat = array.ravel(order="F")
    if array.dtype.kind == "f":
        return b"\4" + head + floats(flat, processor)
    return b"\2" + head + flat.astype(f"{end}i2").tobytes()
