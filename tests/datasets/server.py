"""A server on this machine whose transfers break in the ways that those of real ones do."""

import contextlib
import hashlib
import ssl
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote


@dataclass
class Fault:
    """Faults of one answer; none by default."""

    status: int | None = None  # answered in place of the file
    stop: int | None = None  # bytes after which the connection is closed
    body: bytes | None = None  # sent in place of the file
    ranges: bool = True  # whether parts are sent when asked for
    shift: int = 0  # bytes by which the part sent is another one
    location: str = ""  # where the client is sent instead
    then: Callable[[], object] | None = None  # called before the connection is closed


@dataclass
class Server:
    """Files served, faults of the next answers to a path, and requests received."""

    files: dict[str, bytes]
    faults: dict[str, list[Fault]] = field(default_factory=dict)
    asked: list[tuple[str, str | None]] = field(default_factory=list)  # path and Range
    base: str = ""


@contextlib.contextmanager
def serving(
    files: dict[str, bytes], certificate: tuple[Path, Path] | None = None
) -> Iterator[Server]:
    """Serve files by their path until the block ends; over TLS with a certificate and its key."""
    server = Server(files)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            path, asked = unquote(self.path), self.headers.get("Range")
            server.asked.append((path, asked))
            left = server.faults.get(path, [])
            answer(self, server.files.get(path), asked, left.pop(0) if left else Fault())

        def log_message(self, format, *args):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as http:
        server.base = f"http://127.0.0.1:{http.server_address[1]}"
        if certificate is not None:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(*certificate)
            http.socket = context.wrap_socket(http.socket, server_side=True)
            server.base = server.base.replace("http:", "https:")
        thread = threading.Thread(target=http.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield server
        finally:
            http.shutdown()
            thread.join()


def answer(to: BaseHTTPRequestHandler, body: bytes | None, asked: str | None, fault: Fault) -> None:
    """Send a file or a part of it, with the fault."""
    if fault.location:
        to.send_response(302)
        to.send_header("Location", fault.location)
        to.end_headers()
        return
    if body is None or fault.status is not None:
        to.send_error(fault.status or 404)
        return
    body = body if fault.body is None else fault.body
    start = 0
    if asked and fault.ranges:
        start = int(asked.removeprefix("bytes=").removesuffix("-")) + fault.shift
        to.send_response(206)
        to.send_header("Content-Range", f"bytes {start}-{len(body) - 1}/{len(body)}")
    else:
        to.send_response(200)
    to.send_header("Content-Length", str(len(body) - start))
    to.end_headers()
    with contextlib.suppress(OSError):  # the client may have heard enough
        to.wfile.write(body[start : None if fault.stop is None else start + fault.stop])
        if fault.then is not None:
            fault.then()
            to.rfile.read(1)  # returns when the client has closed the connection


def registry(sets: dict[str, dict[str, bytes]]) -> str:
    """Return the text of a registry of sets of files, each with its first file as licence."""
    lines = []
    for name, files in sets.items():
        lines += ["[[set]]", f'name = "{name}"', f'folder = "{name}"', 'about = "Two walks"']
        lines += ['use = "tests"', 'licence = "MIT"', 'cite = "Nobody 2026"']
        lines += [f'terms = ["{next(iter(files))}"]', "[[set.source]]"]
        lines += [f'repository = "lab/{name}"', f'commit = "{"0" * 40}"', "files = ["]
        for to, body in files.items():
            checksum = hashlib.sha256(body).hexdigest()
            lines.append(
                f'{{ to = "{to}", path = "{to}", bytes = {len(body)}, sha256 = "{checksum}" }},'
            )
        lines.append("]")
    return "\n".join(lines)


def address(name: str, to: str) -> str:
    """Return the path under which a file of such a set is served."""
    return f"/lab/{name}/{'0' * 40}/{to}"
