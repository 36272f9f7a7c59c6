"""A finished drawing: part of a page, shown in a notebook, or saved as a file."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from plantigrade.errors import FileError

MAX_THIRD_WIDTH = 400  # [px] maximum width of a drawing that fits a third of a page

_SIZE = re.compile(r'width="(\d+)" height="(\d+)"')


@dataclass(frozen=True)
class Figure:
    """A drawing and its caption; a notebook shows it."""

    svg: str = field(repr=False)  #: The drawing
    caption: str = ""  #: One or two sentences; empty for none
    wide: bool = False  #: Whether it takes the full width of a page

    @property
    def half(self) -> bool:
        """Whether it takes half the width of a page: too wide for a third, without scaling."""
        found = _SIZE.search(self.svg)
        return not self.wide and found is not None and int(found[1]) > MAX_THIRD_WIDTH

    def _repr_svg_(self) -> str:
        return self.svg

    def _repr_html_(self) -> str:
        return self.svg

    def save(self, path: str | Path) -> Path:
        """Write the drawing as an SVG file.

        Raises:
            FileError: If the name does not end in ``.svg``, or the file cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() != ".svg":
            raise FileError(path, "is not an SVG file", remedy="end its name in .svg")
        try:
            path.write_text(self.svg, encoding="utf-8")
        except OSError as error:
            raise FileError(path, f"cannot be written ({error.strerror or error})") from error
        return path


def grid(drawings: Sequence[str], columns: int = 2) -> Figure:
    """Return several drawings as one, row by row."""
    sizes = [tuple(map(int, found.groups())) for d in drawings if (found := _SIZE.search(d))]
    rows = [sizes[i : i + columns] for i in range(0, len(sizes), columns)]
    parts, y, k = [], 0, 0
    for row in rows:
        x = 0
        for width, _ in row:
            parts.append(drawings[k].replace("<svg ", f'<svg x="{x}" y="{y}" ', 1))
            x, k = x + width + 10, k + 1
        y += max(height for _, height in row) + 8
    width = max((sum(w + 10 for w, _ in row) - 10 for row in rows), default=1)
    return Figure(
        f'<svg class="plot" xmlns="http://www.w3.org/2000/svg" width="{width}" '
        f'height="{max(y, 1)}" viewBox="0 0 {width} {max(y, 1)}">{"".join(parts)}</svg>'
    )
