"""A folder of results, written whole or not at all.

Everything is written to a temporary sibling that is renamed once complete, so a folder under its
final name is whole; if the default name is taken, the folder is numbered.
``metrics.json`` marks a folder as ours: it holds the ``format`` and lists the other ``files``, and
the ``folders`` in it that are folders of results themselves. With ``overwrite`` an existing folder
of results is moved aside, the new one takes its name, and only then is the old one deleted; a
folder that holds anything else is never replaced.
"""

import contextlib
import hashlib
import os
import platform
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping
from itertools import count
from pathlib import Path
from typing import Any

from plantigrade.errors import FileError, RunExists
from plantigrade.io.writing import write_bytes
from plantigrade.printable import UNSAFE, printable, short_name
from plantigrade.record.metrics import METRICS, metrics_json, read_metrics

FORMAT = 2  #: Version of the folder; results of another one are not read

_CLUTTER = {".DS_Store", "Thumbs.db", "desktop.ini"}  # left by file browsers
_REMEDY = "choose another folder with --out, or free disk space"
_OWNER = "-{host}-{pid}-"  # machine and process that write a part
_PART = re.compile(r"-(?P<host>[0-9a-f]{8})-(?P<pid>\d+)-[^-]*\.part$")
_NAME = re.compile(r"[A-Za-z0-9][\w.+ -]*")


def write_folder(
    out: str | Path,
    *,
    metrics: Mapping[str, Any],
    files: Mapping[str, str | bytes],
    overwrite: bool = False,
    numbered: bool = False,
    beside: str = "",
    more: Callable[[Path], None] | None = None,
) -> Path:
    """Write a folder of results, whole or not at all: ``metrics.json`` and other files.

    Args:
        metrics: Figures and settings; NaN and infinity become null. ``format`` and ``files`` are
            added.
        files: The other files, by name.
        overwrite: Replace an existing folder of results.
        numbered: Write ``out-2``, ``out-3``, … where ``out`` is taken.
        beside: Ending of the name of a second folder that will be written beside this one; a number
            is passed over if that is taken.
        more: Writes further files into the folder it is given.

    Returns:
        The folder.

    Raises:
        RunExists: If the folder exists and ``overwrite`` is false, or it holds anything that this
            package did not write.
        FileError: If the folder cannot be written.
    """
    out = _refuse_names(_place(out), files)
    if not numbered:
        refuse_existing(out, overwrite)
    metrics_json(metrics)  # fails before anything is written
    temporary = None
    try:
        temporary = _new_part(out)
        if more is not None:
            more(temporary)
        _fill(temporary, metrics, files)
        os.chmod(temporary, 0o777 & ~_umask())  # mkdtemp makes it private
        if numbered:
            out = _put_in_next_place(temporary, out, beside)
        else:
            refuse_existing(out, overwrite)  # another run may have finished meanwhile
            _put_in_place(temporary, out)
        temporary = None
    except RunExists:
        raise
    except FileError as error:
        if temporary is None or not error.path.is_relative_to(temporary):
            raise
        path = out / error.path.relative_to(temporary)
        raise FileError(path, error.problem, remedy=_REMEDY) from error
    except OSError as error:
        raise _unwritable(out, str(error.strerror or error)) from error
    finally:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)
    return out


def _fill(folder: Path, metrics: Mapping[str, Any], files: Mapping[str, str | bytes]) -> None:
    """Write files and ``metrics.json`` into a folder; a FileError names the file that failed."""
    for name, content in files.items():
        write_bytes(folder / name, _encoded(content) if isinstance(content, str) else content)
    marked = {"format": FORMAT, **metrics, "files": sorted(_contents(folder))}
    write_bytes(folder / METRICS, (metrics_json(marked) + "\n").encode())


def remove_stale_parts(folder: Path) -> None:
    """Remove unfinished runs of processes of this machine that have ended."""
    for place in folder.glob(".*.part"):
        found = _PART.search(place.name)
        if found is None or found["host"] != _host() or place.is_symlink() or not place.is_dir():
            continue
        if not _is_alive(int(found["pid"])):
            shutil.rmtree(place, ignore_errors=True)


def replace_files(folder: str | Path, files: Mapping[str, str | bytes]) -> list[Path]:
    """Replace single files of a folder, each whole or not at all; return their paths.

    Files that are new to the folder join the list in its ``metrics.json``.

    Raises:
        FileError: If a file cannot be written, or ``metrics.json`` cannot be read.
    """
    metrics = read_metrics(folder)
    known = metrics.get("files")
    known = set(map(str, known)) if isinstance(known, list) else None
    if known is not None and not known >= set(files):
        known = sorted({*known, *files})
        files = {**files, METRICS: metrics_json({**metrics, "files": known}) + "\n"}
    written = []
    for name, content in files.items():
        path = replace_file(Path(folder) / name, content)
        if name != METRICS:
            written.append(path)
    return written


def replace_file(path: Path, content: str | bytes) -> Path:
    """Write a file, whole or not at all, and return its path.

    Raises:
        FileError: If it cannot be written.
    """
    write_bytes(path, _encoded(content) if isinstance(content, str) else content)
    return path


def refuse_unwritable(out: str | Path) -> None:
    """Raise if a folder of results cannot be written there.

    Raises:
        FileError: If the nearest folder above it that exists is no folder, or may not be written.
    """
    out = _place(out)
    above = next(place for place in out.absolute().parents if os.path.lexists(place))
    if not above.is_dir():
        raise _unwritable(out, f"{above} is no folder")
    if not os.access(above, os.W_OK | os.X_OK):
        raise _unwritable(out, f"no permission to write to {above}")


def refuse_existing(out: str | Path, overwrite: bool) -> None:
    """Raise if a folder of results could not be written.

    Raises:
        RunExists: If the folder exists and ``overwrite`` is false, or it holds anything that this
            package did not write.
        FileError: If nothing may be written where it is to be.
    """
    out = _place(out)
    refuse_unwritable(out)
    if not os.path.lexists(out):
        return
    if not overwrite:
        raise RunExists(f"{out} exists; choose another --out, or add --overwrite")
    if out.is_symlink() or not out.is_dir():
        raise RunExists(f"{out} is not a folder and will not be replaced: choose another --out")
    if not _contents(out):
        return
    kept, advice = (
        f"{out} will not be replaced",
        "choose another --out, or delete the folder yourself",
    )
    try:
        foreign = foreign_files(out)
    except FileError as error:
        raise RunExists(f"{kept}: {error.problem}; {advice}") from error
    if foreign:
        names = ", ".join(foreign[:5]) + (" …" if len(foreign) > 5 else "")
        raise RunExists(f"{kept}: it also holds {names}; move these files elsewhere, or {advice}")


def foreign_files(folder: Path) -> list[str]:
    """Return what this package did not write below a folder of results, as relative paths.

    A folder in it is ours only if ``metrics.json`` lists it among its ``folders`` and it is a
    folder of results itself.
    """
    metrics = read_metrics(folder)
    listed = metrics.get("files")
    if "format" not in metrics or not isinstance(listed, list):
        raise FileError(folder, f"its {METRICS} does not mark a run of this version")
    within = metrics.get("folders")
    own = {METRICS, *map(str, listed)}
    foreign = _contents(folder) - own
    for name in map(str, within if isinstance(within, list) else ()):
        member = folder / name
        if Path(name).name != name or member.is_symlink() or not (member / METRICS).is_file():
            continue
        with contextlib.suppress(FileError):
            theirs = {f"{name}/{file}" for file in foreign_files(member)}
            foreign = {file for file in foreign if not file.startswith(f"{name}/")} | theirs
    return sorted(foreign)


def _unwritable(out: Path, why: str) -> FileError:
    return FileError(out, f"the run folder cannot be written ({why})", remedy=_REMEDY)


def _contents(folder: Path) -> set[str]:
    """Return every file below a folder, links included, and every empty folder."""
    found = set()
    for place, folders, names in os.walk(folder):
        links = [name for name in folders if os.path.islink(os.path.join(place, name))]
        inside = [*names, *links] or ([] if folders else [""])
        found |= {(Path(place) / name).relative_to(folder).as_posix() for name in inside}
    return {name for name in found if name != "." and Path(name).name not in _CLUTTER}


def _put_in_place(temporary: Path, out: Path) -> None:
    """Rename ``temporary`` to ``out``; an old ``out`` comes back if that fails."""
    if not out.exists():
        temporary.rename(out)
        return
    aside = Path(tempfile.mkdtemp(prefix=f".{out.name[:20]}-", suffix=".old", dir=out.parent))
    old = aside / out.name
    try:
        out.rename(old)
        try:
            temporary.rename(out)
        except OSError:
            old.rename(out)
            raise
    finally:
        if out.exists():  # the old one is deleted only where a whole one stands in its place
            shutil.rmtree(aside, ignore_errors=True)


def _put_in_next_place(temporary: Path, out: Path, beside: str) -> Path:
    """Rename ``temporary`` to ``out``, or to ``out-2``, ``out-3``, … where that is taken.

    A folder that is not empty cannot be renamed over: of two processes that want one name at once,
    one takes the next number.
    """
    for n in count(1):
        place = out if n == 1 else out.with_name(f"{out.name}-{n}")
        if any(os.path.lexists(p) for p in (place, place.with_name(place.name + beside))):
            continue
        try:
            temporary.rename(place)
        except OSError:
            if os.path.lexists(place):  # taken since
                continue
            raise
        return place
    raise AssertionError("numbers do not end")


def _place(out: str | Path) -> Path:
    """Return a folder as it can be made: no longer in name than file systems take."""
    out = Path(out).expanduser()
    return out.with_name(short_name(out.name)) if out.name else out


def _encoded(text: str) -> bytes:
    """Return a page as UTF-8; bytes of a file's name that are not UTF-8 are shown as escapes."""
    try:
        return text.encode()
    except UnicodeEncodeError:
        return UNSAFE.sub(lambda found: printable(found[0]), text).encode()


def _host() -> str:
    """Return a short identifier of this machine, among others that write to the same folder."""
    return hashlib.sha256(platform.node().encode()).hexdigest()[:8]


def _is_alive(pid: int) -> bool:
    """Return whether a process of this machine runs; True where that cannot be known."""
    if os.name != "posix":  # elsewhere signal 0 is not a question
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _refuse_names(out: Path, names: Iterable[str]) -> Path:
    for name in names:
        if not _NAME.fullmatch(name) or name == METRICS:
            problem = "is not allowed as the name of an extra file"
            raise FileError(out / name, problem, remedy="use letters, digits and . _ + - only")
    return out


def _new_part(out: Path) -> Path:
    """Return a new folder beside ``out``, for what is written before it takes its place."""
    out.parent.mkdir(parents=True, exist_ok=True)
    remove_stale_parts(out.parent)
    part = f".{out.name[:20]}{_OWNER.format(host=_host(), pid=os.getpid())}"
    return Path(tempfile.mkdtemp(prefix=part, suffix=".part", dir=out.parent))
