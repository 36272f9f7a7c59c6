"""The pages of a run reach nothing outside of their file, whatever a script in them tries."""

import http.server
import threading

import pytest

from plantigrade.pages.run_pages import pages
from tests.browser import wait_for
from tests.conftest import open_browser
from tests.pages.runs import fitted

KINDS = ("img", "script", "iframe", "link", "object", "video")
RULES = {"connect-src", "img-src", "script-src-elem", "frame-src", "style-src-elem"}
TRIES = """(() => {{
  window.blocked = new Set();
  document.addEventListener('securitypolicyviolation', e => blocked.add(e.effectiveDirective));
  fetch('{address}/fetch', {{mode: 'no-cors'}}).catch(() => 0);
  navigator.sendBeacon('{address}/beacon', 'x');
  for (const kind of {kinds}) {{
    const element = document.createElement(kind);
    element.rel = 'stylesheet';
    element.src = element.href = element.data = '{address}/' + kind;
    document.body.appendChild(element);
  }}
}})()"""


@pytest.fixture
def outside():
    """A server that nobody should reach: its address, and what was asked of it."""
    asked = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            asked.append(self.path)
            self.send_response(200)
            self.end_headers()

        do_POST = do_GET

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}", asked
    server.shutdown()
    server.server_close()


@pytest.mark.parametrize("page", ["report.html", "viewer.html"])
def test_a_page_reaches_no_server(page, record, tmp_path, outside):
    address, asked = outside
    (tmp_path / page).write_text(pages(fitted(record))[page], encoding="utf-8")
    (tmp_path / "plain.html").write_text("<!doctype html><body></body>")
    tries = TRIES.format(address=address, kinds=list(KINDS))
    addresses = {f"/{kind}" for kind in ("fetch", "beacon", *KINDS)}
    with open_browser(width=700, height=420) as browser:
        browser.open(tmp_path / "plain.html")
        browser.evaluate(tries)
        wait_for(lambda: addresses <= set(asked))  # a page without a policy reaches it
        asked.clear()
        browser.errors.clear()
        browser.open(tmp_path / page)
        assert browser.errors == []
        browser.evaluate(tries)
        wait_for(lambda: set(browser.evaluate("[...blocked]")) >= RULES)
        assert asked == []
