"""The live server answers the browsers of this machine alone: real requests, real WebSockets."""

import http.client

import pytest

from plantigrade.errors import PlantigradeError
from plantigrade.pages.live import LiveViewer
from plantigrade.pages.local_only import local_only
from tests.pages.walker import walk, walker

viser = pytest.importorskip("viser")


@pytest.fixture(scope="module")
def port():
    """Port of a live viewer."""
    live = LiveViewer(walk(walker(), duration=0.1), port=18080)
    yield live.server.get_port()
    live.close()


def status(port: int, *headers: tuple[str, str]) -> int:
    """Return what the server answers to a request for its page."""
    connection = http.client.HTTPConnection("localhost", port)
    connection.putrequest("GET", "/", skip_host=True)
    for name, value in headers:
        connection.putheader(name, value)
    connection.endheaders()
    return connection.getresponse().status


@pytest.mark.parametrize(
    "host", ["localhost:{}", "127.0.0.1:{}", "[::1]:{}", "localhost:9000", "LOCALHOST", "[::1]"]
)
def test_this_machine_is_answered(port, host):
    """A forwarded port is another one at the browser."""
    host = host.format(port)
    assert status(port, ("Host", host)) == 200
    assert status(port, ("Host", host), ("Origin", f"http://{host}")) == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example:{}", "evil.example", "localhost.evil.example:{}", "127.0.0.1.nip.io:{}", "",
     "localhost:{}@evil.example", "10.0.0.1:{}", "[::2]:{}", "localhost:80:{}", "localhost:x"],
)  # fmt: skip
def test_another_name_is_refused(port, host):
    """A page of another name that leads here: DNS rebinding."""
    assert status(port, ("Host", host.format(port))) == 403


def test_requests_without_or_with_two_hosts_are_refused(port):
    assert status(port) == 403
    assert status(port, ("Host", "localhost"), ("Host", "evil.example")) == 403


def opened(port: int, origin: str | None, host: str = "localhost") -> bool:
    """Return whether a WebSocket is opened that says it comes from a page at ``origin``."""
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect
    from websockets.typing import Origin, Subprotocol

    try:
        with connect(
            f"ws://{host}:{port}/",
            origin=None if origin is None else Origin(origin),
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            open_timeout=None,
        ) as socket:
            return bool(socket.recv())
    except InvalidStatus as error:
        assert error.response.status_code == 403
        return False


def test_a_page_of_the_server_opens_its_socket(port):
    assert opened(port, f"http://localhost:{port}")
    assert opened(port, None)  # no browser


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "https://localhost:{}", "http://localhost:3000", "null", "file://",
     "http://127.0.0.1:{}", "http://localhost:{}.evil.example"],
)  # fmt: skip
def test_a_page_of_another_origin_opens_none(port, origin):
    """Another server of this machine is another origin, too."""
    assert not opened(port, origin.format(port))


def test_a_server_that_cannot_be_guarded_is_not_used():
    with pytest.raises(PlantigradeError, match="cannot be checked"):
        with local_only():
            pass
    from websockets.asyncio.server import serve

    assert serve.__module__.startswith("websockets")
