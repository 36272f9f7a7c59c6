"""Download of a public file over HTTPS, with resumption, retries and checksum.

A partial download is kept in ``NAME.part`` next to the file, and the next
one requests the rest (``Range``, RFC 9110). A server that sends the whole file again is
read from the beginning. Contents with a wrong checksum are deleted.

The standard library suffices. Pooch, the usual choice for scientific data, checks hashes and
retries, but does not resume a transfer, and brings three libraries with it.
"""

import contextlib
import hashlib
import os
import ssl
import time
from collections.abc import Callable, Iterator
from functools import cache
from http.client import HTTPException, HTTPResponse, responses
from io import BufferedRandom
from pathlib import Path
from urllib.error import HTTPError, URLError
from urllib.parse import urlsplit
from urllib.request import (
    HTTPDefaultErrorHandler,
    HTTPErrorProcessor,
    HTTPHandler,
    HTTPRedirectHandler,
    HTTPSHandler,
    OpenerDirector,
    ProxyHandler,
    Request,
    UnknownHandler,
)

from plantigrade import __version__
from plantigrade.datasets.registry import PublicFile
from plantigrade.errors import DownloadError, FileError, PlantigradeError
from plantigrade.io.writing import not_written
from plantigrade.locks import lock

ATTEMPTS = 5
"""Maximum number of attempts per file: short failures of a server end within a few."""
PAUSE_S = 1.0  #: Pause before the second attempt [s]; each further one is twice as long
TIMEOUT_S = 30.0  #: Timeout of a server's answer [s]
CHUNK = 2**16
"""Size of a block [bytes]: small enough for a smooth progress bar on slow connections."""
REDIRECTS = 5  #: Maximum number of redirections per address; file stores need one or two
RETRIED_STATUS = (408, 425, 429, 500, 502, 503, 504)
"""HTTP status codes of temporary failures (RFC 9110, 6585): retried."""
LOOPBACK = ("localhost", "127.0.0.1", "::1")
"""Hosts allowed without TLS: this machine."""


class Unreachable(DownloadError):
    """No connection to the server: no network, no such host, or a firewall."""


class _Broken(Exception):
    """An attempt failed, and a retry may succeed.

    Attributes:
        restart: Whether the partial download is useless.
    """

    def __init__(self, why: str, *, restart: bool = False):
        super().__init__(why)
        self.restart = restart


def may_be_asked(url: str) -> bool:
    """Return whether an address is allowed: HTTPS, or plain HTTP on this machine.

    Example:
        >>> may_be_asked("https://example.org/a"), may_be_asked("http://example.org/a")
        (True, False)
        >>> may_be_asked("http://localhost:8000/a"), may_be_asked("file:///etc/passwd")
        (True, False)
    """
    parts = urlsplit(url)
    return bool(parts.hostname) and (
        parts.scheme == "https" or (parts.scheme == "http" and parts.hostname in LOOPBACK)
    )


def is_right(place: Path, file: PublicFile) -> bool:
    """Return whether a file exists with the registered contents."""
    if not place.is_file() or place.stat().st_size != file.n_bytes:
        return False
    with open(place, "rb") as held:
        return hashlib.file_digest(held, "sha256").hexdigest() == file.sha256


def download(
    file: PublicFile, url: str, place: Path, reached: Callable[[int], None] = lambda n_bytes: None
) -> None:
    """Download a file to a path, replacing an existing one.

    Args:
        place: Path of the download; folders above it are made.
        reached: Called with the number of bytes received.

    Raises:
        Unreachable: If there is no connection.
        DownloadError: If the server refuses, or :data:`ATTEMPTS` attempts did not bring the
            registered contents.
        FileError: If the file cannot be written.
    """
    part = place.with_name(place.name + ".part")
    why = ""
    for attempt in range(ATTEMPTS):
        if attempt:
            time.sleep(PAUSE_S * 2 ** (attempt - 1))
        try:
            _attempt(file, url, part, reached)
            _put_in_place(part, place, file)
            return
        except _Broken as broken:
            why = str(broken)
            if broken.restart:
                _remove(part)
        except PlantigradeError:
            raise
        except OSError as error:
            raise not_written(place, error) from error
        finally:
            _remove(part, only_empty=True)
    raise DownloadError(f"{why}, in {ATTEMPTS} attempts")


def _attempt(file: PublicFile, url: str, part: Path, reached: Callable[[int], None]) -> None:
    """Download the missing part of a file into ``part``, and check it."""
    there = _length(part)
    if there > file.n_bytes:
        raise _Broken("the partial download is too long", restart=True)
    whole = there == file.n_bytes
    with contextlib.nullcontext() if whole else _ask(url, there) as answer:
        start = there if answer is None else _start(answer, there)
        with _own(part, there) as kept:
            kept.truncate(start)
            kept.seek(start)
            reached(start)
            if answer is not None:
                for chunk in _chunks(answer, file.n_bytes - start):
                    kept.write(chunk)
                    reached(kept.tell())
            n_bytes = kept.tell()
            if n_bytes < file.n_bytes:
                raise _Broken(f"the transfer ended after {n_bytes} of {file.n_bytes} bytes")
            kept.seek(0)
            if hashlib.file_digest(kept, "sha256").hexdigest() != file.sha256:
                problem = "the contents are not the registered ones (SHA-256 differs)"
                raise _Broken(problem, restart=True)
            kept.flush()
            os.fsync(kept.fileno())


def _ask(url: str, there: int) -> HTTPResponse:
    """Return the server's answer to a request for the bytes from ``there`` on."""
    host = urlsplit(url).hostname
    headers = {"User-Agent": f"plantigrade/{__version__}", "Accept-Encoding": "identity"}
    if there:
        headers["Range"] = f"bytes={there}-"
    try:
        opener = _opener(on_this_machine=host in LOOPBACK)
        return opener.open(Request(url, headers=headers), timeout=TIMEOUT_S)
    except HTTPError as error:
        error.close()
        if error.code == 416:  # range not satisfiable
            raise _Broken("the server has no such range", restart=True) from error
        status = responses.get(error.code, "unknown status")
        answer = f"{host} answers {error.code} ({status})"
        if error.code in RETRIED_STATUS:
            raise _Broken(answer) from error
        if 300 <= error.code < 400:
            problem = f"{host} redirects in a circle or to what is not HTTPS; neither is followed"
            raise DownloadError(problem) from error
        raise DownloadError(answer) from error
    except URLError as error:
        if isinstance(error.reason, ssl.SSLCertVerificationError):
            problem = (
                f"the certificate of {host} cannot be verified ({error.reason.verify_message})"
            )
            raise Unreachable(problem) from error
        if isinstance(error.reason, ConnectionResetError | BrokenPipeError):
            raise _Broken(f"the connection broke ({error.reason})") from error
        why = getattr(error.reason, "strerror", None) or error.reason
        raise Unreachable(f"{host} cannot be reached ({why})") from error
    except (OSError, HTTPException) as error:
        raise _Broken(f"the connection broke ({error or type(error).__name__})") from error
    except ValueError as error:  # such as a redirection to http://[
        raise DownloadError(f"{host}: the address cannot be used ({error})") from error


def _start(answer: HTTPResponse, there: int) -> int:
    """Return the first byte of the answer: ``there``, or 0 if it is the whole file."""
    if answer.status != 206:  # partial content
        return 0
    unit, _, rest = (answer.headers.get("Content-Range") or "").partition(" ")
    if unit != "bytes" or rest.partition("-")[0] != str(there):
        raise _Broken("the server sends another range than asked for", restart=True)
    return there


def _chunks(answer: HTTPResponse, most: int) -> Iterator[bytes]:
    """Yield the blocks that the server sends, up to the expected length."""
    try:
        while most and (chunk := answer.read(min(CHUNK, most))):
            most -= len(chunk)
            yield chunk
    except (OSError, HTTPException) as error:
        raise _Broken(f"the connection broke ({error or type(error).__name__})") from error


@contextlib.contextmanager
def _own(part: Path, expected: int) -> Iterator[BufferedRandom]:
    """Open the partial download exclusively for this process."""
    part.parent.mkdir(parents=True, exist_ok=True)
    part.touch()
    with open(part, "r+b") as kept:
        if not lock(kept) or os.fstat(kept.fileno()).st_size != expected:
            problem = "another process is downloading this file"
            raise FileError(part, problem, remedy="wait for it, then repeat the command")
        yield kept


def _length(part: Path) -> int:
    """Return the length of the partial download [bytes]."""
    if part.is_symlink() or (part.exists() and not part.is_file()):
        problem = "is not a regular file, and its name is needed for the download"
        raise FileError(part, problem, remedy="move it elsewhere")
    return part.stat().st_size if part.exists() else 0


def _put_in_place(part: Path, place: Path, file: PublicFile) -> None:
    """Rename a checked download to its final name."""
    try:
        part.replace(place)
    except FileNotFoundError:  # another process, with the same contents, was faster
        if not is_right(place, file):
            raise _Broken("another process took the file away") from None


def _remove(part: Path, *, only_empty: bool = False) -> None:
    with contextlib.suppress(OSError):
        if not only_empty or part.stat().st_size == 0:
            part.unlink()


class _HTTPSRedirects(HTTPRedirectHandler):
    """Follows redirections to allowed addresses only."""

    max_redirections = REDIRECTS

    def redirect_request(self, req, fp, code, msg, headers, newurl):
        """Return the request of the new address; refuse one without TLS."""
        if not may_be_asked(newurl) or (req.type == "https" and urlsplit(newurl).scheme != "https"):
            raise HTTPError(req.full_url, code, msg, headers, fp)
        return super().redirect_request(req, fp, code, msg, headers, newurl)


@cache
def _opener(*, on_this_machine: bool) -> OpenerDirector:
    """Return an opener of HTTP, and of HTTPS with verified certificates, and nothing else.

    The proxies of the environment are used, except for this machine.
    """
    opener = OpenerDirector()
    for handler in (
        ProxyHandler({} if on_this_machine else None),
        UnknownHandler(),
        HTTPHandler(),
        HTTPSHandler(context=ssl.create_default_context()),
        HTTPDefaultErrorHandler(),
        _HTTPSRedirects(),
        HTTPErrorProcessor(),
    ):
        opener.add_handler(handler)
    return opener
