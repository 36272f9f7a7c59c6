"""``motion.npz``: a Record as plain NumPy arrays, one per key; no pickles in it, none read.

Keys that are always there: ``time`` (n,), ``qpos`` (n, nq), ``qvel`` (n, nv), ``joint_names``.
Where known: ``qacc``, ``qfrc_actuator`` (n, nv), ``contact_force``, ``contact_point``,
``contact_torque`` (n, k, 3), ``contact_known`` (n, k) of zeros and ones, ``contact_side``,
``contact_segment`` (k,), ``reference_qpos`` (n,
nq); gait events as ``event_time``, ``event_side``, ``event_kind``; recorded markers as
``marker_names``, ``marker_time``, ``recorded_markers`` (n, m, 3) and ``fitted_markers`` (n, m,
3); ``warnings``. The figures of a run are in ``metrics.json`` beside it.
"""

import io
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.errors import FileError
from plantigrade.motion.motion import Motion
from plantigrade.motion.record import Record
from plantigrade.motion.recording import GaitEvent, Markers

MAX_BYTES = 400 * 2**20  # [bytes] all arrays together
MAX_RATIO = 1000  # a larger file is refused where it unpacks to more than this times its size

_REMEDY = "name a motion.npz that plantigrade wrote"
_FREE_RATIO = 50 * 2**20  # [bytes] small enough not to ask for the ratio


def write_npz(record: Record, path: str | Path) -> Path:
    """Write ``record`` to ``path``, compressed.

    Raises:
        FileError: If the file cannot be written.
    """
    path = Path(path)
    try:
        path.write_bytes(npz_bytes(record))
    except OSError as error:
        raise FileError(
            path, f"cannot be written ({error.strerror or error})", remedy="choose another place"
        ) from error
    return path


def npz_bytes(record: Record) -> bytes:
    """Return what :func:`write_npz` writes."""
    motion, markers = record.motion, record.recorded_markers
    arrays: dict[str, Any] = {
        "time": motion.time,
        "qpos": motion.qpos,
        "qvel": motion.qvel,
        "joint_names": _words(motion.joint_names),
        "qacc": motion.qacc,
        "qfrc_actuator": record.qfrc_actuator,
        "contact_force": record.contact_force,
        "contact_point": record.contact_point,
        "contact_torque": record.contact_torque,
        "contact_known": record.contact_known,
        "reference_qpos": record.reference_qpos,
        "fitted_markers": record.fitted_markers,
    }
    if record.contact_side:
        arrays["contact_side"] = _words(record.contact_side)
    if record.contact_segment:
        arrays["contact_segment"] = _words(record.contact_segment)
    if motion.events:
        arrays["event_time"] = np.array([event.time for event in motion.events], dtype=float)
        arrays["event_side"] = _words([event.side for event in motion.events])
        arrays["event_kind"] = _words([event.kind for event in motion.events])
    if markers is not None:
        arrays["marker_names"] = _words(markers.names)
        arrays["marker_time"] = markers.time
        arrays["recorded_markers"] = markers.positions
    if record.warnings:
        arrays["warnings"] = _words(record.warnings)
    stream = io.BytesIO()
    np.savez_compressed(stream, **{k: v for k, v in arrays.items() if v is not None})
    return stream.getvalue()


def read_npz(path: str | Path) -> Record:
    """Read a ``motion.npz``; its ``metrics`` are empty (see :mod:`plantigrade.io.run_folder`).

    Raises:
        FileError: If the file is no such motion: the key is named.
    """
    path = Path(path)
    arrays = _load(path)

    def get(key: str, *shape: int | None) -> Any:
        """Return the numbers ``key``, None where absent."""
        if key not in arrays:
            return None
        value = arrays[key]
        if value.dtype.kind not in "fiub":
            raise FileError(path, f"holds {value.dtype}, not numbers", where=key, remedy=_REMEDY)
        if len(shape) != value.ndim or any(
            want is not None and want != have for want, have in zip(shape, value.shape, strict=True)
        ):
            want = ", ".join("any" if s is None else str(s) for s in shape)
            raise FileError(
                path, f"has shape {value.shape}, not ({want})", where=key, remedy=_REMEDY
            )
        return np.asarray(value, dtype=float)

    def words(key: str, count: int | None = None) -> tuple[str, ...]:
        """Return the words ``key``, none where absent."""
        if key not in arrays:
            return ()
        value = arrays[key]
        if value.ndim != 1 or (value.dtype.kind not in "US" and value.size):
            raise FileError(path, "is not a list of words", where=key, remedy=_REMEDY)
        if count is not None and len(value) != count:
            raise FileError(path, f"has {len(value)} words, not {count}", where=key, remedy=_REMEDY)
        if value.dtype.kind == "S":
            value = np.char.decode(value, "utf-8", "replace")
        return tuple(str(word) for word in value)

    lost = [key for key in ("time", "qpos", "qvel", "joint_names") if key not in arrays]
    if lost:
        raise FileError(path, f"there is no {', '.join(lost)} in it", where=lost[0], remedy=_REMEDY)
    time = get("time", None)
    n = len(time)
    if n and (not np.isfinite(time).all() or (np.diff(time) <= 0).any()):
        raise FileError(path, "does not increase", where="time", remedy=_REMEDY)
    qpos, qvel = get("qpos", n, None), get("qvel", n, None)
    nq, nv = qpos.shape[1], qvel.shape[1]
    contact_force = get("contact_force", n, None, 3)
    k = None if contact_force is None else contact_force.shape[1]
    known = get("contact_known", n, k)
    event_time = get("event_time", None)
    n_events = 0 if event_time is None else len(event_time)
    sides, kinds = words("event_side", n_events), words("event_kind", n_events)
    if n_events and len(sides) * len(kinds) == 0:
        raise FileError(
            path, "event_side and event_kind are needed too", where="event_time", remedy=_REMEDY
        )
    events = tuple(
        GaitEvent(float(t), side, kind)
        for t, side, kind in zip(
            () if event_time is None else event_time, sides, kinds, strict=True
        )
    )
    names, markers = words("marker_names"), None
    positions = get("recorded_markers", None, len(names), 3)
    if positions is not None:
        marker_time = get("marker_time", len(positions))
        markers = Markers(names, time if marker_time is None else marker_time, positions)
        if len(markers.time) != len(positions):
            raise FileError(
                path,
                f"has {len(positions)} frames, marker_time is missing",
                where="recorded_markers",
                remedy=_REMEDY,
            )
    return Record(
        motion=Motion(
            time=time,
            qpos=qpos,
            qvel=qvel,
            joint_names=words("joint_names"),
            qacc=get("qacc", n, nv),
            events=events,
        ),
        qfrc_actuator=get("qfrc_actuator", n, nv),
        contact_force=contact_force,
        contact_point=get("contact_point", n, k, 3),
        contact_torque=get("contact_torque", n, k, 3),
        contact_side=words("contact_side", k),
        contact_segment=words("contact_segment", k),
        contact_known=None if known is None else known > 0,
        reference_qpos=get("reference_qpos", n, nq),
        recorded_markers=markers,
        fitted_markers=get("fitted_markers", n, len(names) if names else None, 3),
        warnings=words("warnings"),
    )


def _words(words) -> np.ndarray:
    return np.array(list(words), dtype=np.str_) if len(words) else np.array([], dtype="U1")


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
