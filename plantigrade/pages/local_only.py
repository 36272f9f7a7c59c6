"""Restriction of a live server to browsers and pages of this machine.

The server listens on the loopback interface, but any page in a local browser may send requests to
it, by its own name that resolves to 127.0.0.1 (DNS rebinding), or by a WebSocket, which browsers do
not restrict. The first is detected by the ``Host`` of the request, the second by its ``Origin``;
both are refused.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from plantigrade.errors import PlantigradeError
from plantigrade.pages.page_server import is_local

_one_at_a_time = threading.Lock()


@contextmanager
def local_only() -> Iterator[None]:
    """Restrict the server of :mod:`viser` that is started in this context to this machine.

    viser has no setting for it, so a check of every request is added to its call of
    :func:`websockets.asyncio.server.serve`.

    Raises:
        PlantigradeError: If viser started its server in another way, without the check.
    """
    import http

    from websockets.asyncio import server
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    serve, guarded = server.serve, []

    def checked(*arguments: Any, process_request: Callable | None = None, **options: Any) -> Any:
        def first(connection: Any, request: Any) -> Any:
            if not is_local(request.headers):
                status = http.HTTPStatus.FORBIDDEN
                return Response(status, status.phrase, Headers(), b"for this machine only\n")
            return None if process_request is None else process_request(connection, request)

        guarded.append(True)
        return serve(*arguments, process_request=first, **options)

    with _one_at_a_time:
        server.serve = checked  # type: ignore[assignment]
        try:
            yield
        finally:
            server.serve = serve  # type: ignore[misc]
    if not guarded:
        raise PlantigradeError(
            "requests of this version of viser cannot be checked: install viser 1.1, "
            "or open viewer.html of the run instead"
        )
