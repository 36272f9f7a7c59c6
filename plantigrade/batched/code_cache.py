"""A folder of files that can be made again: found by name, believed only if whole.

The folder is named by the environment variable ``PLANTIGRADE_CACHE`` (empty: nothing is kept),
else it is where the operating system wants such files of a user.
"""

import contextlib
import hashlib
import os
import sys
import tempfile
from pathlib import Path

VARIABLE = "PLANTIGRADE_CACHE"
LIMIT = 256 * 2**20  # bytes; the files not used for longest go first
_MARK = b"plantigrade cache\n"


def folder() -> Path | None:
    """Return the folder; None if nothing is to be kept."""
    named = os.environ.get(VARIABLE)
    if named is not None:
        return Path(named).expanduser() / "functions" if named else None
    try:
        home = Path.home()
    except RuntimeError:  # a user without a home
        return None
    if sys.platform == "darwin":
        base = home / "Library" / "Caches"
    elif sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    return base / "plantigrade" / "functions"


def read(name: str) -> bytes | None:
    """Return what was written under a name; None if there is nothing, or nothing to be believed."""
    path = _path(name)
    if path is None:
        return None
    try:
        content = path.read_bytes()
    except OSError:
        return None
    head, body = content[: len(_MARK) + 32], content[len(_MARK) + 32 :]
    if head != _MARK + hashlib.sha256(name.encode() + body).digest():
        return None
    with contextlib.suppress(OSError):
        os.utime(path)
    return body


def write(name: str, body: bytes) -> None:
    """Keep bytes under a name, all or nothing; where that is impossible, keep nothing."""
    path = _path(name)
    if path is None:
        return
    head = _MARK + hashlib.sha256(name.encode() + body).digest()
    part = None
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
            part = Path(file.name)
            file.write(head + body)
        part.replace(path)
        _prune(path)
    except OSError:
        if part is not None:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def _path(name: str) -> Path | None:
    base = folder()
    return None if base is None else base / (hashlib.sha256(name.encode()).hexdigest() + ".bin")


def _prune(newest: Path) -> None:
    files = [p for p in newest.parent.iterdir() if p != newest and p.suffix in (".bin", ".part")]
    facts = sorted(((p.stat().st_mtime, p.stat().st_size, p) for p in files), reverse=True)
    total = newest.stat().st_size
    for _, size, path in facts:
        total += size
        if total > LIMIT:
            path.unlink(missing_ok=True)
