"""``motion.npz``: a Record as plain NumPy arrays, one per key, without pickles.

Keys that are always present: ``time`` (n,), ``qpos`` (n, nq), ``qvel`` (n, nv), ``joint_names``,
``human`` and ``ground`` (JSON text), ``clock`` [s]. Where known: ``qacc``, ``qfrc_actuator``, and
with armature and damping of ``model.xml`` ``qfrc_motor`` (n, nv), ``contact_force``,
``contact_point``, ``contact_torque`` (n, k, 3), ``contact_known``,
``contact_planned`` (n, k) of zeros and ones; of the contact sites ``contact_name``,
``contact_side``, ``contact_segment`` (the body of ``model.xml`` that is touched), ``contact_part``
(k,), ``contact_position`` in that body's frame (k, 3), ``contact_radius``, ``contact_measured``
(k,); gait events as ``event_time``, ``event_side``, ``event_kind``; limits as
``limit_coordinate``, ``limit_velocity``, ``limit_torque``, ``limit_force``, ``limit_overlap``;
``conditions`` of the task (JSON text); recorded markers as ``marker_names``, ``marker_time``,
``recorded_markers`` (n, m, 3) and ``fitted_markers`` (n, m, 3); ``notes`` to the user, and in
``notes_info`` a one for each that only informs (absent: all are warnings); every signal as
``signal/NAME`` (one that this version does not know is read as ``user.NAME``); every reference as
``reference/NAME/time``, ``…/qpos``, ``…/qvel``, and the first of them on the frames of the motion
as ``reference_qpos`` (n, nq). The figures of a run are in ``metrics.json`` beside it.
"""

import io
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from plantigrade.contact.ground import Ground
from plantigrade.contact.scene import motor_forces
from plantigrade.contact.site import ContactSite
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.npz import MAX_NUMBER, Arrays
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.writing import write_bytes
from plantigrade.motion.motion import Motion
from plantigrade.notes import Info
from plantigrade.record.conditions import Condition
from plantigrade.record.record import Limits, Record
from plantigrade.record.signals import USER, signal_of

SIGNAL = "signal/"  #: Beginning of the key of a signal

_T = TypeVar("_T")
_ARRAYS = ("qfrc_actuator", "contact_force", "contact_point", "contact_torque")
_FLAGS = ("contact_known", "contact_planned")
_SITES = {
    "contact_segment" if name == "body" else f"contact_{name}": name
    for name in ("name", "side", "body", "part", "position", "radius", "measured")
}


def npz_bytes(record: Record) -> bytes:
    """Return a record as the bytes of an npz file; equal records give equal bytes."""
    stream = io.BytesIO()
    np.savez_compressed(stream, **{k: v for k, v in _arrays(record).items() if v is not None})
    return stream.getvalue()


def write_npz(record: Record, path: str | Path) -> Path:
    """Write ``record`` to ``path``, compressed.

    Raises:
        FileError: If the file cannot be written.
    """
    path = Path(path)
    write_bytes(path, npz_bytes(record))
    return path


def _arrays(record: Record) -> dict[str, Any]:
    motion, markers, sites = record.motion, record.recorded_markers, record.sites
    limits = record.limits
    arrays: dict[str, Any] = {
        "time": motion.time,
        "qpos": motion.qpos,
        "qvel": motion.qvel,
        "joint_names": _words(motion.joint_names),
        "qacc": motion.qacc,
        "human": _text(record.human.to_dict()),
        "ground": _text(record.ground.to_dict()),
        "clock": np.array(record.clock),
        **{name: getattr(record, name) for name in (*_ARRAYS, *_FLAGS)},
        "fitted_markers": record.fitted_markers,
        "limit_coordinate": limits.coordinate,
        "limit_torque": limits.torque,
        "limit_velocity": None if limits.velocity is None else np.array(limits.velocity),
        "limit_force": None if limits.force is None else np.array(limits.force),
        "limit_overlap": None if limits.overlap is None else np.array(limits.overlap),
    }
    if record.qfrc_actuator is not None and motion.qacc is not None:
        arrays["qfrc_motor"] = motor_forces(
            record.human, record.qfrc_actuator, motion.qvel, motion.qacc
        )
    if sites:
        arrays |= {key: np.array([getattr(s, name) for s in sites]) for key, name in _SITES.items()}
    if record.conditions:
        arrays["conditions"] = _text([c.to_dict() for c in record.conditions])
    if motion.events:
        for name in ("time", "side", "kind"):
            arrays[f"event_{name}"] = np.array([getattr(event, name) for event in motion.events])
    if markers is not None:
        arrays["marker_names"] = _words(markers.names)
        arrays["marker_time"] = markers.time
        arrays["recorded_markers"] = markers.positions
    if record.notes:
        arrays["notes"] = _words(record.notes)
        informs = np.array([isinstance(note, Info) for note in record.notes])
        arrays["notes_info"] = informs if informs.any() else None
    for name, value in record.signals.items():
        arrays[f"{SIGNAL}{name}"] = np.asarray(value)
    for name, other in record.references.items():
        for what in ("time", "qpos", "qvel"):
            arrays[f"reference/{name}/{what}"] = getattr(other, what)
        if "reference_qpos" not in arrays:
            same = np.array_equal(other.time, motion.time)
            arrays["reference_qpos"] = other.qpos if same else other.at(motion.time).qpos
    return arrays


def read_npz(path: str | Path) -> Record:
    """Read a Record."""
    arrays = Arrays(path)
    for key in ("time", "qpos", "qvel", "joint_names", "human"):
        if key not in arrays:
            arrays.refuse("is missing", key)
    human = _described(arrays, "human", OsimHuman.from_dict)
    ground = _described(arrays, "ground", Ground.from_dict) if "ground" in arrays else Ground()
    nq, nv = human.model.nq, human.model.nv
    time = arrays.time()
    n = len(time)
    if not n:
        arrays.refuse("has no frames", "time")
    qpos, qvel = _poses(arrays, "qpos", n, nq), arrays.finite("qvel", n, nv)
    sites = _sites(arrays)
    k = len(sites)
    markers = arrays.markers(time)
    m = len(markers.names) if markers else None
    flags = {name: arrays.numbers(name, n, k) for name in _FLAGS}
    clock = arrays.numbers("clock")
    try:
        names, keys = arrays.words("joint_names"), arrays.keys(SIGNAL)
        return Record(
            human,
            Motion(time, qpos, qvel, names, arrays.numbers("qacc", n, nv), arrays.events()),
            qfrc_actuator=arrays.numbers("qfrc_actuator", n, nv),
            sites=sites,
            **{name: arrays.numbers(name, n, k, 3) for name in _ARRAYS[1:]},
            **{name: None if v is None else v > 0 for name, v in flags.items()},
            ground=ground,
            limits=_limits(arrays, nv - 6),
            conditions=_conditions(arrays),
            signals={_signal_name(key): _signal(arrays, key) for key in keys},
            references=_references(arrays, names, nq, nv),
            recorded_markers=markers,
            fitted_markers=arrays.numbers("fitted_markers", n, m, 3),
            clock=0.0 if clock is None else float(clock),
            notes=_notes(arrays),
        )
    except ParameterError as error:
        raise FileError(
            path, f"does not hold a motion of one person: {error}", remedy="run the command again"
        ) from error


def _notes(arrays: Arrays) -> tuple[str, ...]:
    notes = arrays.words("notes")
    informs = arrays.numbers("notes_info", len(notes))
    if informs is None:
        return notes
    return tuple(Info(n) if i > 0 else n for n, i in zip(notes, informs, strict=True))


def _poses(arrays: Arrays, key: str, n: int, nq: int) -> np.ndarray:
    """Return configurations; the quaternion of the root is one."""
    qpos = arrays.finite(key, n, nq)
    if not (np.abs(np.linalg.norm(qpos[:, 3:7], axis=1) - 1) < 0.1).all():
        arrays.refuse("has rotations of the root that are no unit quaternions", key)
    return qpos


def _signal_name(key: str) -> str:
    """Return the name of a signal; one that this version does not know becomes the user's own."""
    name = key.removeprefix(SIGNAL)
    try:
        signal_of(name)
    except ParameterError:
        return f"{USER}{name}"
    return name


def _signal(arrays: Arrays, key: str) -> np.ndarray:
    value = arrays.any(key)
    if value.dtype.kind == "f":
        known = value[np.isfinite(value)].astype(float)  # half precision cannot hold the limit
        if (np.abs(known) > MAX_NUMBER).any():
            arrays.refuse(f"holds numbers beyond {MAX_NUMBER:.0e}", key)
    return value


def _sites(arrays: Arrays) -> tuple[ContactSite, ...]:
    k = len(arrays.words("contact_name"))
    if not k:
        return ()
    columns: dict[str, Any] = {}
    for key, name in _SITES.items():
        if key not in arrays:
            arrays.refuse("is missing, but contact_name is there", key)
        shape = {"position": (k, 3), "radius": (k,), "measured": (k,)}.get(name)
        columns[name] = arrays.numbers(key, *shape).tolist() if shape else arrays.words(key, k)
    columns["measured"] = [value > 0 for value in columns["measured"]]
    try:
        rows = zip(*columns.values(), strict=True)
        return tuple(ContactSite(**dict(zip(columns, row, strict=True))) for row in rows)
    except ParameterError as error:
        arrays.refuse(f"does not describe contact sites ({error})", "contact_name")
        raise


def _limits(arrays: Arrays, n_hinges: int) -> Limits:
    velocity: Any = None
    if "limit_velocity" in arrays:
        shape = arrays.shape("limit_velocity")
        velocity = arrays.numbers("limit_velocity", *(n_hinges,) * len(shape))
        velocity = float(velocity) if velocity.ndim == 0 else velocity
    force, overlap = arrays.numbers("limit_force"), arrays.numbers("limit_overlap")
    return Limits(
        coordinate=arrays.numbers("limit_coordinate", 2, n_hinges),
        velocity=velocity,
        torque=arrays.numbers("limit_torque", 2, n_hinges),
        force=None if force is None else float(force),
        overlap=None if overlap is None else float(overlap),
    )


def _conditions(arrays: Arrays) -> tuple[Condition, ...]:
    if "conditions" not in arrays:
        return ()
    return _described(
        arrays, "conditions", lambda held: tuple(Condition.from_dict(c) for c in held), list
    )


def _references(
    arrays: Arrays, joint_names: tuple[str, ...], nq: int, nv: int
) -> dict[str, Motion]:
    found = {}
    for key in arrays.keys("reference/"):
        place, _, what = key.rpartition("/")
        if what != "time":
            continue
        time = arrays.increasing(key, arrays.numbers(key, None))
        for part in ("qpos", "qvel"):
            if f"{place}/{part}" not in arrays:
                arrays.refuse(f"is missing, but {key} is there", f"{place}/{part}")
        qpos = _poses(arrays, f"{place}/qpos", len(time), nq)
        qvel = arrays.finite(f"{place}/qvel", len(time), nv)
        found[place.removeprefix("reference/")] = Motion(time, qpos, qvel, joint_names)
    return found


def _described(arrays: Arrays, key: str, build: Callable[[Any], _T], kind: type = dict) -> _T:
    """Return what the JSON text ``key`` describes."""
    try:
        description = json.loads(str(arrays.any(key)))
        if not isinstance(description, kind):
            arrays.refuse(f"is no JSON {'object' if kind is dict else 'list'}", key)
        return build(description)
    except (ValueError, TypeError, RecursionError) as error:
        if isinstance(error, FileError):
            raise
        arrays.refuse(f"is damaged ({error})", key)
        raise


def _text(description: Any) -> np.ndarray:
    return np.array(json.dumps(description, sort_keys=True), dtype=np.str_)


def _words(words: Sequence[str]) -> np.ndarray:
    return np.array(list(words), dtype=np.str_) if len(words) else np.array([], dtype="U1")
