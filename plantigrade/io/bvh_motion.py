"""The MOTION section of a BVH file: one row of numbers per frame."""

import re
from functools import partial
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError
from plantigrade.io.text import parse_numbers


def read_motion(
    path: Path, text: str, start: int, n_channels: int, warnings: list[str]
) -> tuple[Float[Array, "n k"], float]:
    """Return the numbers of the MOTION section and the time of a frame [s]."""
    head = re.compile(
        r"\s*Frames[ \t]*:[ \t]*(\S*)[ \t]*\r?\n\s*Frame[ \t]+Time[ \t]*:[ \t]*(\S*)", re.IGNORECASE
    ).match(text, start)
    line = text.count("\n", 0, start) + 1
    broken = partial(FileError, path, remedy="check that the BVH file is complete")
    if head is None:
        problem = "MOTION is not followed by 'Frames:' and 'Frame Time:'"
        raise broken(problem, where=f"line {line + 1}")
    try:
        n_frames, frame_time = int(head[1]), float(head[2])
    except ValueError:
        problem = f"Frames is {head[1][:20]!r}, Frame Time is {head[2][:20]!r}: not numbers"
        raise broken(problem, where=f"line {line + 1}") from None
    if not (np.isfinite(frame_time) and frame_time > 0):
        raise FileError(
            path,
            f"Frame Time is {head[2]} s; it must be positive",
            where=f"line {line + 2}",
            remedy="write the time between frames in seconds, as 0.00833333 for 120 Hz",
        )
    first_row = text.count("\n", 0, head.end()) + 2
    block = text[head.end() :]
    values = parse_numbers(block)
    if values is None:
        block = _whole_rows(path, block, first_row - 1, n_channels)
        values = parse_numbers(block)
    if values is None:
        raise broken("contains words that are not numbers", where="MOTION")
    rows, rest = divmod(len(values), n_channels)
    if rest or rows != n_frames:
        rows = _count_rows(path, block, first_row - 1, n_channels)
        warnings.append(f"the file announces {n_frames} frames and holds {rows} complete ones")
    if rows < 1:
        raise broken("has no complete frame in MOTION", where=f"line {first_row}")
    values = values[: rows * n_channels].reshape(rows, n_channels)
    if not np.isfinite(values).all():
        values = _filled(path, values, warnings)
    return values, frame_time


def _whole_rows(path: Path, block: str, line: int, n_channels: int) -> str:
    """Return the rows, without a last one that is truncated within a number."""
    rows = block.rstrip().split("\n")
    for n, row in enumerate(rows):
        if parse_numbers(row) is not None:
            continue
        if n == len(rows) - 1 and n > 0 and len(row.split()) <= n_channels:
            return "\n".join(rows[:-1])
        words = row.split()
        bad = next((k for k, word in enumerate(words) if parse_numbers(word) is None), 0)
        raise FileError(
            path,
            f"{words[bad][:30]!r} is not a number",
            where=f"line {line + n}, channel {bad + 1}",
            remedy="correct or delete this frame",
        )
    return block


def _count_rows(path: Path, block: str, line: int, n_channels: int) -> int:
    """Return the number of complete rows; only the last may be truncated."""
    rows = 0
    short: tuple[int, int] | None = None
    for n, row in enumerate(block.splitlines(), start=line):
        count = len(row.split())
        if not count:
            continue
        if short is not None or count > n_channels:
            n, count = short or (n, count)
            raise FileError(
                path,
                f"this frame has {count} numbers, the hierarchy has {n_channels} channels",
                where=f"line {n}",
                remedy="correct or delete this frame, or check the hierarchy",
            )
        if count < n_channels:
            short = (n, count)
        else:
            rows += 1
    return rows


def _filled(path: Path, values: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Return ``values`` with rows that are not finite replaced by the row before."""
    bad = np.asarray(~np.isfinite(values).all(axis=1))
    if bad.mean() > 0.5:
        raise FileError(
            path,
            f"{bad.sum()} of {len(bad)} frames hold values that are not finite",
            where=f"frame {np.flatnonzero(bad)[0] + 1}",
            remedy="export the motion again",
        )
    warnings.append(
        f"{bad.sum()} frames held values that are not finite; each was replaced by the frame before"
    )
    last = np.maximum.accumulate(np.where(bad, -1, np.arange(len(bad))))
    last[last < 0] = np.flatnonzero(~bad)[0]
    return values[last]
