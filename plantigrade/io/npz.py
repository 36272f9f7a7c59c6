"""NumPy's npz files, read safely: whole, of limited size, without pickles."""

import re
import sys
import zipfile
from collections.abc import Collection
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from plantigrade.errors import FileError, ParameterError
from plantigrade.io.text import reading
from plantigrade.motion.recording import GaitEvent, Markers, Recording, Table

MAX_BYTES = 400 * 2**20  # [bytes] all arrays of a file together
MAX_RATIO = 1000  # unpacked size over packed size; real motions stay far below

MAX_NUMBER = 1e12  # Maximum magnitude of a number of a motion [SI], to prevent overflow

_REMEDY = "name a motion.npz that plantigrade wrote"
_FREE_RATIO = 50 * 2**20  # [bytes] below this any ratio is accepted
_MAX_ARRAYS = 1000  # of one file; a run has some tens
_ADDRESS = re.compile(" at 0x[0-9a-f]+")  # of an object in an error of another library


class Arrays:
    """The arrays of one npz file, checked for kind and shape as they are read.

    Args:
        only: Names of the arrays to read; all by default.
    """

    def __init__(
        self, path: str | Path, remedy: str = _REMEDY, only: Collection[str] | None = None
    ):
        self.path, self._remedy = Path(path), remedy
        self._arrays = _load(self.path, remedy, only)

    def __contains__(self, key: str) -> bool:
        return key in self._arrays

    def keys(self, prefix: str = "") -> list[str]:
        """Return the names of all arrays that start with ``prefix``."""
        return [key for key in self._arrays if key.startswith(prefix)]

    def shape(self, key: str) -> tuple[int, ...]:
        """Return the shape of an array; the key must exist."""
        return self._arrays[key].shape

    def any(self, key: str) -> np.ndarray:
        """Return an array of numbers or words; a FileError if it is missing or anything else."""
        if key not in self._arrays:
            self.refuse("is missing", key)
        value = self._arrays[key]
        if value.dtype.kind not in "fiubUS":
            self.refuse(f"holds {value.dtype}, neither numbers nor words", key)
        self._refuse_damaged_words(key, value)
        return value

    def numbers(self, key: str, *shape: int | None) -> Any:
        """Return the array ``key`` as floats, None if missing.

        A length in ``shape`` is None if it is arbitrary.

        Raises:
            FileError: If the array is of another kind or shape.
        """
        if key not in self._arrays:
            return None
        value = self._arrays[key]
        if value.dtype.kind not in "fiub":
            self.refuse(f"holds {value.dtype}, not numbers", key)
        given = zip(shape, value.shape, strict=False)
        if len(shape) != value.ndim or any(want not in (None, have) for want, have in given):
            want = ", ".join("any" if s is None else str(s) for s in shape)
            self.refuse(f"has shape {value.shape}, not ({want})", key)
        value = np.asarray(value, dtype=float)
        largest = np.nanmax(np.abs(value), initial=0.0)
        if largest > MAX_NUMBER and not key.startswith("limit_"):  # a limit may be infinite
            self.refuse(f"reaches {largest:.0e}, which is no measurement in SI units", key)
        return value

    def finite(self, key: str, *shape: int | None) -> Any:
        """Return the array ``key`` as :meth:`numbers` does; a FileError unless all are finite."""
        value = self.numbers(key, *shape)
        if value is not None and not np.isfinite(value).all():
            self.refuse("holds numbers that are not finite", key)
        return value

    def words(self, key: str, count: int | None = None) -> tuple[str, ...]:
        """Return the words of the array ``key``, none if missing; a FileError if not ``count``."""
        if key not in self._arrays:
            return ()
        value = self._arrays[key]
        if value.ndim != 1 or (value.dtype.kind not in "US" and value.size):
            self.refuse("is not a list of words", key)
        if count is not None and len(value) != count:
            self.refuse(f"has {len(value)} words, not {count}", key)
        if value.dtype.kind == "S":
            value = np.char.decode(value, "utf-8", "replace")
        self._refuse_damaged_words(key, value)
        return tuple(str(word) for word in value)

    def _refuse_damaged_words(self, key: str, value: np.ndarray) -> None:
        """Raise a FileError for strings with invalid Unicode characters."""
        if value.dtype.kind == "U" and value.size and value.itemsize:
            native = np.ascontiguousarray(value, value.dtype.newbyteorder("="))
            if np.frombuffer(native.tobytes(), np.uint32).max() > sys.maxunicode:
                self.refuse("holds words with characters that do not exist", key)

    def time(self) -> Any:
        """Return ``time``; a FileError if it is missing or does not increase."""
        time = self.numbers("time", None)
        if time is None:
            self.refuse("is missing", "time")
        return self.increasing("time", time)

    def increasing(self, key: str, time: Any) -> Any:
        """Return ``time``, the array ``key``; a FileError if it does not increase."""
        if len(time) and (not np.isfinite(time).all() or (np.diff(time) <= 0).any()):
            self.refuse("does not increase from frame to frame", key)
        return time

    def events(self) -> tuple[GaitEvent, ...]:
        """Return the gait events; a FileError if an array of them is missing."""
        time = self.numbers("event_time", None)
        if time is None or not len(time):
            return ()
        sides, kinds = self.words("event_side", len(time)), self.words("event_kind", len(time))
        if not sides or not kinds:
            self.refuse("needs event_side and event_kind as well", "event_time")
        rows = zip(time, sides, kinds, strict=True)
        try:
            return tuple(GaitEvent(float(t), side, kind) for t, side, kind in rows)
        except ParameterError as error:
            self.refuse(str(error), "event_kind")

    def markers(self, time: Any) -> Markers | None:
        """Return the recorded markers, at ``time`` unless they have their own times."""
        names = self.words("marker_names")
        positions = self.numbers("recorded_markers", None, len(names), 3)
        if positions is None:
            return None
        own = self.numbers("marker_time", len(positions))
        clock = time if own is None else own
        if len(clock) != len(positions):
            self.refuse(
                f"has {len(positions)} frames, but marker_time is missing", "recorded_markers"
            )
        return Markers(names, self.increasing("marker_time", clock), positions)

    def refuse(self, problem: str, key: str) -> NoReturn:
        """Raise a FileError with the array ``key`` and the problem."""
        raise FileError(self.path, problem, where=key, remedy=self._remedy)


def read_npz(path: str | Path) -> Recording:
    """Read the parts of a run's ``motion.npz`` that a recording has too.

    These are recorded markers, gait events and joint angles [rad]. The pose of the pelvis is left
    out: load the run for it (:class:`plantigrade.record.Run`).

    Raises:
        FileError: If the file is not a motion of this package.
    """
    arrays = Arrays(path)
    time, names = arrays.time(), arrays.words("joint_names")[1:]
    qpos = arrays.numbers("qpos", len(time), None)
    coordinates = None
    if qpos is None:
        arrays.refuse("is missing", "qpos")
    if len(set(names)) < len(names):
        arrays.refuse("names a joint twice", "joint_names")
    if qpos.shape[1] - 7 == len(names) > 0:  # the root has a position and a quaternion
        coordinates = Table(tuple(names), time, qpos[:, 7:])
    markers = arrays.markers(time)
    if markers is None and coordinates is None:
        arrays.refuse("names no joints that fit qpos, and there are no markers", "joint_names")
    return Recording(
        source=Path(path),
        markers=markers,
        coordinates=coordinates,
        events=arrays.events(),
        warnings=(
            *arrays.words("notes"),
            "the pose of the pelvis was omitted: open the run folder instead to keep it",
        ),
    )


def _load(path: Path, remedy: str, only: Collection[str] | None) -> dict[str, np.ndarray]:
    """Return the arrays of a whole npz file of allowed size."""
    try:
        with reading(path):
            size = path.stat().st_size
            with zipfile.ZipFile(path) as archive:
                infos = archive.infolist()
            total = sum(info.file_size for info in infos)
            bomb = total > _FREE_RATIO and total > MAX_RATIO * size
            if len(infos) > _MAX_ARRAYS or total > MAX_BYTES or bomb:
                raise FileError(
                    path,
                    f"would decompress to {total / 2**20:.0f} MiB in {len(infos)} arrays; allowed "
                    f"are {MAX_BYTES / 2**20:.0f} MiB, {_MAX_ARRAYS} arrays and {MAX_RATIO} times "
                    "the size of the file",
                    remedy="cut the motion into shorter ones",
                )
            with np.load(path, allow_pickle=False) as archive:
                names = [key for key in archive.files if only is None or key in only]
                arrays = {key: archive[key] for key in names}
    except FileError:
        raise
    except Exception as error:  # damaged bytes make zipfile and NumPy raise almost anything
        reason = _ADDRESS.sub("", str(error))[:100] or type(error).__name__
        problem = f"is not a whole npz file of plain arrays ({reason})"
        raise FileError(path, problem, remedy=remedy) from error
    for key, value in arrays.items():
        if not isinstance(value, np.ndarray):
            raise FileError(path, "is not an array", where=key, remedy=remedy)
    return arrays
