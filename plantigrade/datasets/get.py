"""Download public data sets into a folder; files with the registered contents are kept."""

import contextlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import urlsplit

from plantigrade.datasets.registry import HOST, DataSet, PublicFile, data_set
from plantigrade.datasets.transfer import Unreachable, download, is_right, may_be_asked
from plantigrade.errors import DownloadError, FileError, ParameterError
from plantigrade.options import as_path

FOLDER = Path("data")  # Folder of the data, in which each set has its place
MIRROR = "PLANTIGRADE_MIRROR"  # Environment variable that names a mirror

Reached = Callable[[int], None]  # Called with the number of bytes of a file that have arrived
Shown = Callable[[str, int], contextlib.AbstractContextManager[Reached]]
"""Shows the progress of a file, given its place and its length [bytes]."""


def get_data(
    name: str, to: str | Path = FOLDER, *, overwrite: bool = False, mirror: str | None = None
) -> Path:
    """Download a public data set and return the folder of its recordings.

    Files that are there with the registered contents are not downloaded again, and no connection is
    made if all are. Broken transfers resume where they ended. ``plantigrade data get`` lists the
    sets with their licences.

    Args:
        name: Name of the set, such as ``"biomechzoo-walks"``.
        to: Folder of the data; the recordings go to a folder in it, the text of the licence to
            ``LICENSES``.
        overwrite: Replace files of other contents under the same names.
        mirror: Address that serves the same paths as ``https://raw.githubusercontent.com``; by
            default that of the environment variable ``PLANTIGRADE_MIRROR``.

    Returns:
        The folder of the recordings, in ``to``.

    Raises:
        ParameterError: If there is no such set, or the mirror is not HTTPS.
        DownloadError: If a file cannot be downloaded.
        FileError: If a file of other contents is in the way, or a file cannot be written.
    """
    chosen, root = data_set(name), as_path(to, "the folder")
    for _ in fetch(chosen, root, overwrite=overwrite, mirror=mirror):
        pass
    return root / chosen.folder


def fetch(
    chosen: DataSet,
    root: Path,
    *,
    overwrite: bool = False,
    mirror: str | None = None,
    shown: Shown = lambda name, n_bytes: contextlib.nullcontext(lambda reached: None),
) -> Iterator[tuple[PublicFile, bool]]:
    """Yield each file of a set once it is there, and whether it was downloaded.

    A file that a server refuses does not keep the others from being downloaded.

    Args:
        overwrite: As for :func:`get_data`.
        mirror: As for :func:`get_data`.
        shown: Shows the progress of a file.

    Raises:
        ParameterError: If the mirror is not HTTPS.
        DownloadError: If a file cannot be downloaded.
        FileError: If a file of other contents is in the way, or a file cannot be written.
    """
    base = mirror_of(mirror)
    there = {file for file in chosen.files if is_right(root / file.to, file)}
    for file in chosen.files:
        if file not in there:
            _refuse_foreign(root / file.to, overwrite)
    failed: list[str] = []
    for file in chosen.files:
        if file not in there:
            try:
                with shown(file.to, file.n_bytes) as reached:
                    download(file, file.url(base), root / file.to, reached)
            except Unreachable as error:  # nor will the others be reached
                failed.append(str(error))
                break
            except DownloadError as error:
                failed.append(f"{file.to}: {error}")
                continue
        yield file, file not in there
    if failed:
        n_there = sum(is_right(root / file.to, file) for file in chosen.files)
        raise DownloadError(
            f"{chosen.name}: {failed[0]}; {n_there} of {len(chosen.files)} files are in {root} — "
            f"check the network, or name a --mirror, and repeat the command, which continues; for "
            f"download by hand: plantigrade data get {chosen.name} --addresses"
        )


def mirror_of(given: str | None) -> str:
    """Return the address of the mirror: as given, of the environment, or the public one."""
    mirror = given or os.environ.get(MIRROR) or HOST
    if not isinstance(mirror, str):
        raise ParameterError(f"mirror must be an address, not {mirror!r}")
    try:
        parts = urlsplit(mirror)
        allowed = may_be_asked(mirror) and not (
            parts.query or parts.fragment or "@" in parts.netloc
        )
        _ = parts.port  # ValueError if it is no number
    except ValueError:
        allowed = False
    if not allowed:
        where = "" if given else f" of {MIRROR}"
        raise ParameterError(
            f"the mirror{where} must be an address such as https://mirror.example.org, not "
            f"{mirror!r}; plain http is allowed for this machine alone"
        )
    return mirror


def _refuse_foreign(place: Path, overwrite: bool) -> None:
    """Raise if something else has the name of a file."""
    if not os.path.lexists(place):
        return
    if place.is_dir() or not (place.is_file() or place.is_symlink()):
        raise FileError(place, "is not a regular file", remedy="move it elsewhere")
    if not overwrite:
        problem = "exists, and is not the file of the data set"
        raise FileError(place, problem, remedy="choose another --to, or add --overwrite")
