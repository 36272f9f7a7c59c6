"""Motion files: one module per format, :func:`read`, :func:`write` and :func:`convert` for all.

All formats are listed in :data:`FORMATS`. The format of a file is recognised by its extension and,
if that is ambiguous (``.txt``) or contradicts the content, by its content.
"""

import importlib
import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.errors import FileError, ParameterError, UnsupportedFormat
from plantigrade.io.length import check_length
from plantigrade.io.npz import MAX_NUMBER
from plantigrade.io.pickles import is_compressed
from plantigrade.io.text import reading
from plantigrade.motion.recording import Recording
from plantigrade.options import as_path
from plantigrade.signatures import takes

__all__ = ["FORMATS", "Format", "convert", "format_of", "read", "write"]

_HEAD = 65536  # bytes read to detect a format


@dataclass(frozen=True)
class Format:
    """One file format."""

    name: str  #: Name in messages
    suffixes: tuple[str, ...]  #: File extensions, lower case, with the dot
    #: ``module:function`` under :mod:`plantigrade.io`, called with the path and options
    reader: str
    #: ``module:function``, called with a Recording and the path; None if read only
    writer: str | None = None
    #: Parts of a :class:`~plantigrade.motion.recording.Recording` that the writer stores; it needs
    #: at least one of those before ``"|"``
    holds: str = ""
    #: Byte strings (lower case), one of which occurs at the start of every such file; empty if the
    #: format has none
    signature: tuple[bytes, ...] = ()

    @property
    def main_parts(self) -> list[str]:
        """Parts of a Recording, at least one of which the writer needs."""
        return self.holds.split("|")[0].split()

    @property
    def parts(self) -> list[str]:
        """Parts of a Recording that the writer stores."""
        return self.holds.replace("|", " ").split()


_TRC, _MOT, _AMC = (b"pathfiletype", b"frame#"), (b"endheader",), (b":fully-specified", b":degrees")
_KEYPOINTS = (b"keypoints", b'"instance_info"', b'"rhip"', b'"right_hip"')
_BVH = "bvh_writer:write_recording"
_LFS = b"version https://git-lfs"  # starts a pointer to a file that was not downloaded
# Keys of the SMPL family, in the headers of a zip archive and in a pickle.
_SMPL_ARRAYS = re.compile(
    rb"PK(?:\x03\x04.{26}|\x01\x02.{42})(?:poses|pose_body|body_pose|smpl_poses)\.npy", re.DOTALL
)
_SMPL_KEYS = re.compile(rb"pose|orient|trans|betas|smpl|pred_rotmat")

FORMATS = (
    Format(
        "C3D", (".c3d",), "c3d:read_c3d", "c3d_writer:write_c3d", "markers | plates events subject"
    ),
    Format("TRC", (".trc",), "trc:read_trc", "trc:write_trc", "markers", _TRC),
    Format(
        "MOT/STO", (".mot", ".sto"), "mot:read_mot", "mot:write_mot", "coordinates plates", _MOT
    ),
    Format("forces", (".forces",), "forces:read_forces", signature=(b"[force data]",)),
    Format("AMC", (".amc",), "amc:read_amc", signature=_AMC),
    Format("BVH", (".bvh",), "bvh:read_bvh", _BVH, "skeleton", (b"hierarchy",)),
    Format("keypoints", (".json",), "keypoints:read_keypoints", signature=_KEYPOINTS),
    Format("DeepMimic", (".json", ".txt"), "deepmimic:read_deepmimic", signature=(b'"frames"',)),
    Format("CSV", (".csv", ".tsv", ".txt"), "csv:read_csv", "csv:write_csv", "markers coordinates"),
    Format("npz", (".npz",), "npz:read_npz"),
    Format("SMPL", (".npz", ".pkl", ".pt"), "smpl:read_smpl"),
)
"""All formats; the first whose signature matches wins."""


@dataclass(frozen=True, kw_only=True)
class ReadOptions:
    """Options of the readers; each format has some of them."""

    skeleton: str | Path | None = None
    """AMC: its skeleton (.asf); by default the one in the folder of the file. SMPL: a body model
    (.npz) for the bone lengths of the file's betas; by default those of a mean adult."""
    unit: str | None = None
    """AMC, BVH: unit of length: m, cm, mm, in or (BVH) cmu; by default one that suits a person."""
    rate: float | None = None
    """AMC, SMPL, keypoints: frames per second [Hz]; that of the file, or 120 (AMC) or 30 (others),
    by default."""
    knee_sign: int | None = None
    """MOT: 1 if knee flexion is positive in the file, -1 if negative; by default found."""


@takes(ReadOptions)
def read(path: str | Path, **options: Any) -> Recording:
    """Read a motion file.

    Args:
        path: The file.
        options: Fields of ``ReadOptions``.

    Returns:
        Recording in SI units and world axes.

    Raises:
        UnsupportedFormat: If no format fits the file.
        FileError: If the file cannot be read.
        ParameterError: If the format has no such option, or ``path`` is no path.
    """
    path = as_path(path, "a recording")
    kind = format_of(path)
    function = _function(kind.reader)
    known = [name for name in inspect.signature(function).parameters if name != "path"]
    unset = [each.name for each in fields(ReadOptions) if options.get(each.name) is None]
    options = {name: value for name, value in options.items() if name not in unset}
    for name in options:
        if name not in known:
            allowed = f"it has {', '.join(known)}" if known else "it has none"
            raise ParameterError(f"{kind.name} files have no option {name!r}; {allowed}")
    try:
        with np.errstate(all="ignore"):  # what overflows is found below
            recording = function(path, **options)
    except MemoryError as error:
        remedy = "read a shorter recording"
        raise FileError(path, "does not fit into memory", remedy=remedy) from error
    except RecursionError as error:
        remedy = "check that this is a motion file"
        raise FileError(path, "is nested too deeply", remedy=remedy) from error
    for part in (recording.markers, recording.skeleton, recording.coordinates):
        if part is not None:
            check_length(path, len(part.time))
    _check_sizes(recording, path)
    return recording


def _check_sizes(recording: Recording, path: Path) -> None:
    """Raise for implausible numbers, and for gaps in formats without gaps."""
    parts = {"markers": recording.markers, "skeleton": recording.skeleton}
    parts |= {"coordinates": recording.coordinates}
    parts |= {f"force plate {plate.name}": plate for plate in recording.plates}
    for where, part in parts.items():
        for name, array in vars(part).items() if part is not None else ():
            if not isinstance(array, np.ndarray):
                continue
            if where == "skeleton" and name != "ends" and not np.isfinite(array).all():
                problem, remedy = f"{name} are not finite", "export the motion again"
                raise FileError(path, problem, where=where, remedy=remedy)
            largest = float(np.nanmax(np.abs(array), initial=0.0))
            if largest > MAX_NUMBER:
                problem = f"{name} reach {largest:.1e} in SI units, which no recording does"
                raise FileError(path, problem, where=where, remedy="check the file's units")


def write(recording: Recording, path: str | Path) -> None:
    """Write a recording in the format given by the extension of ``path``.

    Parts that the format cannot store are omitted; :func:`convert` reports them.

    Raises:
        UnsupportedFormat: If no format with this extension can be written.
        FileError: If the format can store no part of the recording, or the file cannot be written.
    """
    kind = _writable(Path(path))
    if not any(_has(recording, part) for part in kind.main_parts):
        has = [part for part in _PARTS if _has(recording, part)]
        fitting = [
            suffix
            for other in FORMATS
            if other.writer and any(part in other.main_parts for part in has)
            for suffix in other.suffixes
        ]
        raise FileError(
            path,
            f"{kind.name} files store {' or '.join(kind.main_parts)}; {recording.source} has "
            f"{', '.join(has) or 'nothing'}",
            remedy=f"write {', '.join(fitting)} instead" if fitting else "choose another recording",
        )
    _function(kind.writer or "")(recording, Path(path))


def convert(source: str | Path, target: str | Path, **options) -> tuple[str, ...]:
    """Read ``source`` and write it as ``target``; the extensions give the formats.

    Force plates that the target cannot store are written to ``NAME_grf.mot`` next to it, as OpenSim
    does. The options are those of :func:`read`.

    Returns:
        Warnings and omitted parts, one sentence each.

    Raises:
        FileError: If ``source`` cannot be read, or ``target`` cannot hold it or be written.
    """
    target = Path(target)
    kind = _writable(target)  # before a long read
    recording = read(source, **options)
    write(recording, target)
    notes = list(recording.warnings)
    left_out = [p for p in _PARTS if _has(recording, p) and p not in kind.parts]
    if kind.name == "MOT/STO" and recording.coordinates is not None and recording.plates:
        left_out.append("plates")  # coordinates went first
    if "plates" in left_out:
        from plantigrade.io.mot import write_mot

        forces = target.with_name(f"{target.stem}_grf.mot")
        write_mot(recording.plates, forces)
        notes.append(f"the force plates were written to {forces.name}")
        left_out.remove("plates")
    if left_out:
        names = ", ".join(_PARTS[part] for part in left_out)
        notes.append(f"{kind.name} files cannot store {names}: left out")
    return tuple(notes)


def format_of(path: str | Path) -> Format:
    """Return the format of a file.

    Raises:
        UnsupportedFormat: If the file has none of the known formats.
        FileError: If the file does not exist or cannot be opened.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    candidates = [kind for kind in FORMATS if suffix in kind.suffixes]
    with reading(path), open(path, "rb") as file:
        head = file.read(_HEAD)
        file.seek(max(file.tell(), path.stat().st_size - _HEAD))
        tail = file.read(_HEAD)
    if not head:
        raise FileError(path, "is empty", remedy="export the recording again")
    if head[1:2] == b"\x50" and len(head) >= 512 and 2 <= head[0] < 128 and b"\0" in head[:512]:
        return _named("C3D")
    if head.startswith(_LFS):
        problem, remedy = "is a pointer of git-lfs, not the file itself", "run: git lfs pull"
        raise FileError(path, problem, remedy=remedy)
    if head.startswith(b"PK\x03\x04") and suffix == ".npz":
        return _named("SMPL" if _SMPL_ARRAYS.search(head + tail) else "npz")
    text = head.replace(b"\0", b"").lower()  # UTF-16 too
    if suffix in (".pkl", ".pt"):
        if _SMPL_KEYS.search(text) or is_compressed(head):
            return _named("SMPL")
        problem, remedy = "holds no poses of SMPL", "give a motion file"
        raise UnsupportedFormat(path, problem, remedy=remedy)
    marked = [kind for kind in FORMATS if any(mark in text for mark in kind.signature)]
    if len(candidates) == 1 and (
        candidates[0] in marked or not candidates[0].signature or not marked
    ):
        return candidates[0]
    both = [kind for kind in candidates if kind in marked]
    if both:
        return both[0]
    if len(candidates) > 1 and not marked and _has_time_column(text):
        return _named("CSV")
    if candidates and marked:  # the content clearly is another format
        return marked[0]
    endings = ", ".join(sorted({s for kind in FORMATS for s in kind.suffixes}))
    if suffix == ".asf":
        raise UnsupportedFormat(
            path,
            "is a skeleton without motion",
            remedy="give the .amc file; its skeleton is found next to it or given as an option",
        )
    if candidates:
        kinds = " or ".join(kind.name for kind in candidates)
        raise UnsupportedFormat(
            path,
            f"is neither a {kinds} motion nor a table with a column 'time'",
            remedy="give a motion file, or add a header 'time, NAME_x, NAME_y, NAME_z, …'",
        )
    raise UnsupportedFormat(
        path,
        f"extension {path.suffix!r} is not one of {endings}",
        remedy="give it the extension of its format, or export it as C3D or TRC",
    )


_PARTS = {
    "markers": "markers",
    "skeleton": "skeleton motion",
    "coordinates": "joint coordinates",
    "plates": "force plates",
    "events": "gait events",
    "subject": "subject data",
    "outputs": "model outputs",
}


def _has(recording: Recording, part: str) -> bool:
    value = getattr(recording, part)
    if part == "subject":
        return any(v is not None for v in vars(value).values())
    return value is not None and (not hasattr(value, "__len__") or len(value) > 0)


def _has_time_column(text: bytes) -> bool:
    """Return whether the first line that is not a comment names a time column."""
    lines = text.replace(b"\r", b"\n").split(b"\n")
    header = next((line for line in lines if line.strip() and not line.startswith(b"#")), b"")
    return re.search(rb"(^|[\t,;\"])\s*(time|t)\b", header) is not None


def _named(name: str) -> Format:
    return next(kind for kind in FORMATS if kind.name == name)


def _writable(path: Path) -> Format:
    found = [k for k in FORMATS if path.suffix.lower() in k.suffixes and k.writer]
    if not found:
        endings = ", ".join(s for k in FORMATS if k.writer for s in k.suffixes)
        raise UnsupportedFormat(
            path,
            f"files with extension {path.suffix or 'none'!r} cannot be written",
            remedy=f"use one of {endings}",
        )
    return found[0]


def _function(name: str) -> Callable:
    module, function = name.split(":")
    return getattr(importlib.import_module(f"plantigrade.io.{module}"), function)
