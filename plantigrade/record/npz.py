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
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.errors import FileError
from plantigrade.io.npz import Arrays
from plantigrade.motion.motion import Motion
from plantigrade.record.record import Record


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
    """Read a ``motion.npz``; its ``metrics`` are empty (see :mod:`plantigrade.record.folder`).

    Raises:
        FileError: If the file is no such motion: the key is named.
    """
    arrays = Arrays(path)
    for key in ("time", "qpos", "qvel", "joint_names"):
        if key not in arrays:
            arrays.refuse(f"there is no {key} in it", key)
    time = arrays.time()
    n = len(time)
    qpos, qvel = arrays.numbers("qpos", n, None), arrays.numbers("qvel", n, None)
    nq, nv = qpos.shape[1], qvel.shape[1]
    contact_force = arrays.numbers("contact_force", n, None, 3)
    k = None if contact_force is None else contact_force.shape[1]
    known = arrays.numbers("contact_known", n, k)
    markers = arrays.markers(time)
    m = len(markers.names) if markers else None
    return Record(
        motion=Motion(
            time=time,
            qpos=qpos,
            qvel=qvel,
            joint_names=arrays.words("joint_names"),
            qacc=arrays.numbers("qacc", n, nv),
            events=arrays.events(),
        ),
        qfrc_actuator=arrays.numbers("qfrc_actuator", n, nv),
        contact_force=contact_force,
        contact_point=arrays.numbers("contact_point", n, k, 3),
        contact_torque=arrays.numbers("contact_torque", n, k, 3),
        contact_side=arrays.words("contact_side", k),
        contact_segment=arrays.words("contact_segment", k),
        contact_known=None if known is None else known > 0,
        reference_qpos=arrays.numbers("reference_qpos", n, nq),
        recorded_markers=markers,
        fitted_markers=arrays.numbers("fitted_markers", n, m, 3),
        warnings=arrays.words("warnings"),
    )


def _words(words) -> np.ndarray:
    return np.array(list(words), dtype=np.str_) if len(words) else np.array([], dtype="U1")
