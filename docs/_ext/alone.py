"""The pages ask for nothing but themselves: a warning for each resource from elsewhere.

Links that a reader may follow are no requests.
"""

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

ASKING = {
    "link": "href", "script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src",
    "audio": "src", "embed": "src", "object": "data", "use": "href", "image": "href",
}  # fmt: skip
OUTSIDE = re.compile(r"^\s*(https?:)?//", re.IGNORECASE)
IN_STYLES = re.compile(r"""(?:url\(\s*['"]?|@import\s+['"])((?:https?:)?//[^'")\s]+)""", re.I)


class _Reader(HTMLParser):
    def __init__(self):
        super().__init__()
        self.found: list[str] = []
        self._style = False

    def handle_starttag(self, tag, attrs):
        self._style = tag == "style"
        for name, value in attrs:
            if name == "srcset" or name == ASKING.get(tag):
                self.found += [v for v in re.split(r",\s+", value or "") if OUTSIDE.match(v)]
            elif name == "style":
                self.found += IN_STYLES.findall(value or "")

    def handle_endtag(self, tag):
        self._style = False

    def handle_data(self, data):
        if self._style:
            self.found += IN_STYLES.findall(data)


def requests(html: str) -> list[str]:
    """Return the outside addresses a browser would ask for when it shows a page."""
    reader = _Reader()
    reader.feed(html)
    return reader.found


def requests_of_folder(folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield each outside address of the pages and style sheets of a folder, with its file."""
    for path in sorted(folder.rglob("*")):
        if path.suffix == ".html":
            yield from ((path, each) for each in requests(path.read_text("utf-8")))
        elif path.suffix == ".css":
            yield from ((path, each) for each in IN_STYLES.findall(path.read_text("utf-8")))


def setup(app) -> dict:
    """Look at the pages when they are built."""
    from sphinx.util import logging

    def look(app, exception) -> None:
        if exception is None and app.builder.format == "html":
            for path, address in requests_of_folder(Path(app.outdir)):
                place = path.relative_to(app.outdir)
                logging.getLogger(__name__).warning("%s asks for %s", place, address)

    app.connect("build-finished", look)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
