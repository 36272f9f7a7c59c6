"""A served page is for the browsers of this machine alone: real requests, real WebSockets."""

import http.client
import urllib.error
import urllib.request

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from plantigrade.errors import ParameterError
from plantigrade.pages.page_server import SOCKET_PATH, PageServer
from tests.browser import wait_for

PAGE = "<!doctype html><title>A page</title>" + 100_000 * "x"


@pytest.fixture(scope="module")
def served():
    """A served page, and the messages that came to it."""
    received = []
    server = PageServer(18080, lambda: PAGE, received.append)
    yield server, received
    server.close()


@pytest.fixture(scope="module")
def port(served):
    """Port of the page."""
    return served[0].port


def test_the_page_and_nothing_else_is_served(served):
    address = served[0].address
    with urllib.request.urlopen(address) as answer:
        assert answer.read().decode() == PAGE
        assert answer.headers["Content-Type"] == "text/html; charset=utf-8"
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{address}/metrics.json")


def test_messages_go_both_ways(served):
    server, received = served
    with connect(server.address.replace("http", "ws") + SOCKET_PATH) as socket:
        socket.send("to the server")
        wait_for(lambda: received)
        assert received == ["to the server"]
        server.send("to the browser")
        assert socket.recv() == "to the browser"


def test_a_browser_that_is_behind_gets_no_further_frames(served):
    """It does not read; the frames it does without are not kept for it."""
    server, _ = served
    with connect(server.address.replace("http", "ws") + SOCKET_PATH, max_queue=1) as socket:
        for k in range(300):
            server.send(f"{k:06d}" + 50_000 * "x", droppable=True)
        server.send("last")
        numbers = []
        while (message := socket.recv()) != "last":
            numbers.append(int(message[:6]))
        assert numbers == sorted(numbers) and len(numbers) < 300


def test_the_next_free_port_is_taken(served):
    second = PageServer(served[0].port, lambda: PAGE)
    try:
        assert second.port > served[0].port
    finally:
        second.close()


def test_a_port_that_is_none():
    with pytest.raises(ParameterError, match="not a valid port"):
        PageServer(65536, lambda: PAGE)


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
    try:
        with connect(
            f"ws://{host}:{port}{SOCKET_PATH}",
            origin=None if origin is None else Origin(origin),
            open_timeout=None,
        ):
            return True
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
