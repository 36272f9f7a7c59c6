"""NumPy's npz files, read with care: whole, no larger than they may be, without pickles."""

import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.errors import FileError
from plantigrade.motion.recording import GaitEvent, Markers, Recording, Table

MAX_BYTES = 400 * 2**20  # [bytes] all arrays together
MAX_RATIO = 1000  # a larger file is refused where it unpacks to more than this times its size

_REMEDY = "name a motion.npz that plantigrade wrote"
_FREE_RATIO = 50 * 2**20  # [bytes] small enough not to ask for the ratio


class Arrays:
    """The arrays of one npz file, asked for by key, kind and shape.

    Args:
        path: The file.

    Raises:
        FileError: If the file cannot be read, is not whole, or unpacks to more than is allowed.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self._arrays = _load(self.path)

    def __contains__(self, key: str) -> bool:
        """Return whether there is an array of this name."""
        return key in self._arrays

    def keys(self, prefix: str = "") -> list[str]:
        """Return the names of all arrays that start with ``prefix``."""
        return [key for key in self._arrays if key.startswith(prefix)]

    def shape(self, key: str) -> tuple[int, ...]:
        """Return the shape of an array that is there."""
        return self._arrays[key].shape

    def any(self, key: str) -> np.ndarray:
        """Return an array of numbers or words that is there.

        Raises:
            FileError: If it holds anything else.
        """
        value = self._arrays[key]
        if value.dtype.kind not in "fiubUS":
            self.refuse(f"holds {value.dtype}, neither numbers nor words", key)
        return value

    def numbers(self, key: str, *shape: int | None) -> Any:
        """Return the numbers ``key`` as floats, None where absent.

        Args:
            key: Name of the array.
            shape: Its shape; None where any length is allowed.

        Raises:
            FileError: If the array is of another kind or shape.
        """
        if key not in self._arrays:
            return None
        value = self._arrays[key]
        if value.dtype.kind not in "fiub":
            self.refuse(f"holds {value.dtype}, not numbers", key)
        if len(shape) != value.ndim or any(
            want is not None and want != have for want, have in zip(shape, value.shape, strict=True)
        ):
            want = ", ".join("any" if s is None else str(s) for s in shape)
            self.refuse(f"has shape {value.shape}, not ({want})", key)
        return np.asarray(value, dtype=float)

    def words(self, key: str, count: int | None = None) -> tuple[str, ...]:
        """Return the words ``key``, none where absent.

        Raises:
            FileError: If they are no words, or not as many as ``count``.
        """
        if key not in self._arrays:
            return ()
        value = self._arrays[key]
        if value.ndim != 1 or (value.dtype.kind not in "US" and value.size):
            self.refuse("is not a list of words", key)
        if count is not None and len(value) != count:
            self.refuse(f"has {len(value)} words, not {count}", key)
        if value.dtype.kind == "S":
            value = np.char.decode(value, "utf-8", "replace")
        return tuple(str(word) for word in value)

    def time(self) -> Any:
        """Return ``time``; its frames increase.

        Raises:
            FileError: If there is none, or it does not increase.
        """
        time = self.numbers("time", None)
        if time is None:
            self.refuse("there is no time in it", "time")
        if len(time) and (not np.isfinite(time).all() or (np.diff(time) <= 0).any()):
            self.refuse("does not increase", "time")
        return time

    def events(self) -> tuple[GaitEvent, ...]:
        """Return the gait events.

        Raises:
            FileError: If they are incomplete.
        """
        time = self.numbers("event_time", None)
        if time is None or not len(time):
            return ()
        sides, kinds = self.words("event_side", len(time)), self.words("event_kind", len(time))
        if not sides or not kinds:
            self.refuse("event_side and event_kind are needed too", "event_time")
        return tuple(
            GaitEvent(float(t), side, kind)
            for t, side, kind in zip(time, sides, kinds, strict=True)
        )

    def markers(self, time: Any) -> Markers | None:
        """Return the recorded markers, on ``time`` where they have no clock of their own.

        Raises:
            FileError: If they are incomplete.
        """
        names = self.words("marker_names")
        positions = self.numbers("recorded_markers", None, len(names), 3)
        if positions is None:
            return None
        own = self.numbers("marker_time", len(positions))
        clock = time if own is None else own
        if len(clock) != len(positions):
            self.refuse(f"has {len(positions)} frames, marker_time is missing", "recorded_markers")
        return Markers(names, clock, positions)

    def refuse(self, problem: str, key: str) -> None:
        """Raise what is wrong with an array.

        Raises:
            FileError: Always.
        """
        raise FileError(self.path, problem, where=key, remedy=_REMEDY)


def read_npz(path: str | Path) -> Recording:
    """Read what a ``motion.npz`` of a run shares with a recording.

    Recorded markers, gait events, and the angles of the joints [rad]; where the pelvis is needs the
    body beside it (:func:`plantigrade.record.load_run`).

    Raises:
        FileError: If the file is no such motion.
    """
    arrays = Arrays(path)
    time, names = arrays.time(), arrays.words("joint_names")[1:]
    qpos, coordinates = arrays.numbers("qpos", len(time), None), None
    if qpos is None:
        arrays.refuse("there is no qpos in it", "qpos")
    if qpos.shape[1] - 7 == len(names) > 0:  # the root has a position and a quaternion
        coordinates = Table(tuple(names), time, qpos[:, 7:])
    return Recording(
        source=Path(path),
        markers=arrays.markers(time),
        coordinates=coordinates,
        events=arrays.events(),
        warnings=(
            *arrays.words("warnings"),
            "the place of the pelvis is left out; open the run's folder to have it",
        ),
    )


def _load(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays of an npz file that is whole and no larger than it may be."""
    try:
        size = path.stat().st_size
        with zipfile.ZipFile(path) as archive:
            infos = archive.infolist()
            total = sum(info.file_size for info in infos)
            if (
                len(infos) > 1000
                or total > MAX_BYTES
                or (total > _FREE_RATIO and total > MAX_RATIO * size)
            ):
                raise FileError(
                    path,
                    f"would unpack to {total / 2**20:.0f} MiB in {len(infos)} arrays; "
                    f"{MAX_BYTES / 2**20:.0f} MiB are allowed",
                    remedy="cut the motion into shorter ones",
                )
        arrays: dict[str, np.ndarray] = {}
        with np.load(path, allow_pickle=False) as archive:
            for key in archive.files:
                value = archive[key]
                if not isinstance(value, np.ndarray):
                    raise FileError(path, "is not an array", where=key, remedy=_REMEDY)
                arrays[key] = value
    except FileError:
        raise
    except FileNotFoundError as error:
        raise FileError(path, "there is no such file", remedy="check the name") from error
    except (zipfile.BadZipFile, zlib.error, EOFError) as error:
        raise FileError(path, f"is not a whole npz file ({error})", remedy=_REMEDY) from error
    except OSError as error:
        reason = error.strerror or error
        raise FileError(path, f"cannot be read ({reason})", remedy=_REMEDY) from error
    except (
        ValueError,
        KeyError,
        TypeError,
        SyntaxError,
        NotImplementedError,
        RuntimeError,
        MemoryError,
        OverflowError,
    ) as error:
        text = str(error)[:100]
        raise FileError(
            path, f"holds an array that cannot be read ({text})", remedy=_REMEDY
        ) from error
    return arrays
