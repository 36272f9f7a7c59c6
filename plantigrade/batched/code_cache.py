"""A cache folder of this user: machine code and tables that can always be made again.

The folder is named by the environment variable ``PLANTIGRADE_CACHE`` (empty: no cache), else it is
the operating system's cache folder for the user.

Files read here run as machine code, or say where machine code reads and writes memory. Therefore
nothing is read unless folder and file belong to the user and no other user can write to them, no
folder above them can be exchanged by another user than root, and the checksum of the file,
which covers its name, is right. In every other case the caller does without the cache; so it does
on Windows, where none of this can be seen.
"""

import contextlib
import hashlib
import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

VARIABLE = "PLANTIGRADE_CACHE"
MAX_CACHE_SIZE = 2**30
"""Size of the cache [bytes]: some hundred kinds of bodies and contacts; the least recently used are
deleted first. Chosen."""
_MARK = b"plantigrade cache\n"


def folder() -> Path | None:
    """Return the folder; None if there is to be no cache."""
    if not hasattr(os, "getuid"):
        return None
    named = os.environ.get(VARIABLE)
    if named is not None:
        return Path(named).expanduser() / "functions" if named else None
    try:
        home = Path.home()
    except RuntimeError:  # a user without a home
        return None
    if sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    return base / "plantigrade" / "functions"


def read(name: str) -> bytes | None:
    """Return the bytes stored under a name; None if there are none that can be trusted."""
    path = path_of(name)
    if path is None:
        return None
    try:
        content = _trusted_content(path)
    except OSError:
        return None
    head, body = content[: len(_MARK) + 32], content[len(_MARK) + 32 :]
    if head != _MARK + hashlib.sha256(name.encode() + body).digest():
        return None
    with contextlib.suppress(OSError):
        os.utime(path)
    return body


def write(name: str, body: bytes) -> None:
    """Store bytes under a name atomically; do nothing if that is not possible."""
    path = path_of(name)
    if path is None:
        return
    head = _MARK + hashlib.sha256(name.encode() + body).digest()
    part = None
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        _require_private(path.parent.stat())
        _require_fixed(path.parent)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
            part = Path(file.name)
            file.write(head + body)
        part.replace(path)
        _prune(path)
    except OSError:
        if part is not None:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def path_of(name: str) -> Path | None:
    """Return the file of a name; None if there is no cache."""
    base = folder()
    return None if base is None else base / (hashlib.sha256(name.encode()).hexdigest() + ".bin")


def _trusted_content(path: Path) -> bytes:
    """Return the content of a file that only this user can have written, or raise OSError.

    File and folder are examined through open descriptors, so that neither can be exchanged between
    the examination and the reading.
    """
    _require_fixed(path.parent)
    with _opened(path.parent, os.O_DIRECTORY) as folder_of_it:
        _require_private(os.fstat(folder_of_it))
        with _opened(path.name, os.O_NOFOLLOW, dir_fd=folder_of_it) as descriptor:
            status = os.fstat(descriptor)
            _require_private(status)
            if not stat.S_ISREG(status.st_mode):
                raise PermissionError(f"{path} is not a regular file")
            with open(descriptor, "rb", closefd=False) as file:
                return file.read()


@contextlib.contextmanager
def _opened(path: Path | str, flags: int, *, dir_fd: int | None = None) -> Iterator[int]:
    """Open a file or folder for reading, as a descriptor."""
    descriptor = os.open(path, os.O_RDONLY | flags, dir_fd=dir_fd)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def _require_private(status: os.stat_result) -> None:
    """Check that only this user owns a file and can write to it."""
    if status.st_uid != os.getuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise PermissionError("other users could have written this")


def _require_fixed(folder: Path) -> None:
    """Refuse a folder above which another user could rename, and so put another in its place.

    In a sticky one (/tmp) every user may write, but none rename files of others.
    """
    for above in Path(os.path.realpath(folder)).parents:
        status = above.lstat()
        writable = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
        exchangeable = writable and not status.st_mode & stat.S_ISVTX
        if status.st_uid not in (0, os.getuid()) or exchangeable:
            raise PermissionError(f"other users can exchange what is in {above}")


def _prune(newest: Path) -> None:
    """Delete the least recently used files beyond the limit."""
    with os.scandir(newest.parent) as found:
        files = [e for e in found if e.name != newest.name and e.name.endswith((".bin", ".part"))]
    facts = [(e.stat(follow_symlinks=False), Path(e.path)) for e in files]
    facts = sorted(((s.st_mtime, s.st_size, path) for s, path in facts), reverse=True)
    total = newest.stat().st_size
    for _, size, path in facts:
        total += size
        if total > MAX_CACHE_SIZE:
            path.unlink(missing_ok=True)
