"""A server of one page, and of a WebSocket beside it, for browsers of this machine.

The server listens on the loopback interface, but any page in a local browser may send requests to
it, by its own name that resolves to 127.0.0.1 (DNS rebinding), or by a WebSocket, which browsers do
not restrict. The first is detected by the ``Host`` of the request, the second by its ``Origin``;
both are refused.
"""

import asyncio
import http
import logging
import sys
import threading
import webbrowser
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from plantigrade.errors import ParameterError, PlantigradeError

NAMES = ("localhost", "127.0.0.1", "[::1]")
"""Names of this machine; any port is allowed, because ssh may forward one to another."""
SOCKET_PATH = "/live"
N_PORTS = 100  # ports that are tried, one after the other
CLOSING_TIME = 1.0  # [s] for browsers; some keep a connection open that they never use
MAX_MESSAGE = 4096  # [bytes] of a message from a browser
MAX_BACKLOG = 65536  # [bytes] waiting to be sent; a browser that is behind gets no further frame

_log = logging.getLogger(__name__)  # of connections that browsers open and never use
_log.addHandler(logging.NullHandler())
_log.propagate = False


class ServedPage(ABC):
    """A page that changes while browsers show it.

    Attributes:
        save_requested: Set by the save button, cleared after saving.
        server: What serves it.
    """

    save_requested: threading.Event
    server: "PageServer"

    @property
    def address(self) -> str:
        """URL of the page."""
        return self.server.address

    @abstractmethod
    def show(self, stop: threading.Event) -> None:
        """Send what changes until ``stop`` is set, or saving is requested."""

    def close(self) -> None:
        """Stop the server."""
        self.server.close()


class PageServer:
    """One page at ``/`` and a WebSocket, served by a thread of their own.

    Args:
        port: First port to try.
        page: Function that returns the page.
        received: Called with every message from a browser, in the thread of the server.

    Attributes:
        port: Port on which it listens.
    """

    def __init__(
        self,
        port: int,
        page: Callable[[], str],
        received: Callable[[str], None] = lambda message: None,
    ):
        if not 0 < port < 65536:
            raise ParameterError(f"{port=} is not a valid port; choose one from 1024 to 65535")
        self._page, self._received = page, received
        self._loop = asyncio.new_event_loop()
        try:
            self.port, self._server = self._loop.run_until_complete(self._open(port))
        except BaseException:
            self._loop.close()
            raise
        self._thread = threading.Thread(target=self._loop.run_forever, name="page", daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """URL of the page."""
        return f"http://localhost:{self.port}"

    @property
    def connections(self) -> tuple[Any, ...]:
        """Browsers whose WebSocket is open."""
        return tuple(self._server.connections)

    def send(self, message: str, *, droppable: bool = False) -> None:
        """Send a message to every browser; may be called from any thread."""
        self._loop.call_soon_threadsafe(self._send, message, droppable)

    def close(self) -> None:
        """Close all connections and stop the server."""

        async def closed() -> None:
            self._server.close()
            waiting = asyncio.ensure_future(self._server.wait_closed())
            await asyncio.wait([waiting], timeout=CLOSING_TIME)

        asyncio.run_coroutine_threadsafe(closed(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _send(self, message: str, droppable: bool) -> None:
        from websockets.asyncio.server import broadcast

        behind = {c for c in self.connections if c.transport.get_write_buffer_size() > MAX_BACKLOG}
        broadcast(set(self.connections) - (behind if droppable else set()), message)

    async def _open(self, port: int) -> tuple[int, Any]:
        """Return the first free port and a server on it."""
        from websockets.asyncio.server import serve

        for candidate in range(port, min(port + N_PORTS, 65536)):
            try:
                server = await serve(
                    self._listen,
                    "localhost",
                    candidate,
                    process_request=self._answer,
                    max_size=MAX_MESSAGE,
                    compression=None,
                    logger=_log,
                )
            except OSError:
                continue
            return candidate, server
        raise PlantigradeError(f"no port from {port} to {candidate} is free; choose another --port")

    def _answer(self, connection: Any, request: Any) -> Any:
        """Return the page, an error, or None for a WebSocket to be opened."""
        if not is_local(request.headers):
            return response(http.HTTPStatus.FORBIDDEN, "for this machine only\n", "text/plain")
        if "Upgrade" in request.headers and request.path == SOCKET_PATH:
            return None
        if request.path.partition("?")[0] != "/":
            return response(http.HTTPStatus.NOT_FOUND, "there is one page, /\n", "text/plain")
        return response(http.HTTPStatus.OK, self._page(), "text/html")

    async def _listen(self, connection: Any) -> None:
        async for message in connection:
            self._received(message)


def serve_page(
    page: str,
    *,
    port: int = 8080,
    open: bool = True,  # noqa: A002 - the word of the command line's option
) -> None:
    """Serve a page on http://localhost:``port`` until interrupted.

    Works over ssh: the server has no window and no OpenGL, the browser draws.

    Args:
        port: Port to listen on, or the next free one.
        open: Whether to open the page in the default browser.

    Raises:
        ParameterError: If the port is no port.
    """
    server = PageServer(port, lambda: page)
    try:
        print(f"Viewer at {server.address} (press Ctrl-C to stop)", file=sys.stderr)
        if open:
            webbrowser.open(server.address)
        threading.Event().wait()
    except KeyboardInterrupt:
        pass
    finally:
        server.close()


def response(status: http.HTTPStatus, text: str, kind: str) -> Any:
    """Return an HTTP response with a text."""
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    body = text.encode("utf-8")
    headers = Headers(
        {
            "Content-Type": f"{kind}; charset=utf-8",
            "Content-Length": str(len(body)),
            "Cache-Control": "no-store",
            "Connection": "close",
        }
    )
    return Response(status, status.phrase, headers, body)


def is_local(headers: Any) -> bool:
    """Return whether a request is for this machine and from a page of the same server.

    Args:
        headers: Headers of the request, with ``get_all(name)``. Programs other than browsers send
            no ``Origin``.
    """
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) != 1 or len(origins) > 1:
        return False
    name, _, port = hosts[0].rpartition(":") if _has_port(hosts[0]) else (hosts[0], "", "")
    if name.lower() not in NAMES or (port and not port.isdecimal()):
        return False
    return not origins or origins[0].lower() == f"http://{hosts[0].lower()}"


def _has_port(host: str) -> bool:
    return ":" in host.rpartition("]")[2]
