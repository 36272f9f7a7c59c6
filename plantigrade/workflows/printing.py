"""PDFs beside the pages of a folder of results."""

from collections.abc import Callable
from pathlib import Path

from plantigrade.pages.pdf import pdf_of
from plantigrade.record.folder import replace_files
from plantigrade.record.metrics import METRICS

PRINTED = ("report.html", "batch.html", "compare.html", "study.html")
"""Pages that are meant for paper; a viewer is not."""


def print_pages(folder: Path, say: Callable[[str], object] = lambda _: None) -> list[Path]:
    """Print the pages of a folder of results, and of the results in it, beside them.

    Returns:
        The PDFs.

    Raises:
        PlantigradeError: If there is no browser, or it prints nothing.
        FileError: If a PDF cannot be written.
    """
    pages = [folder / name for name in PRINTED if (folder / name).is_file()]
    inside = sorted(each for each in folder.iterdir() if (each / METRICS).is_file())
    pages += [each / name for each in inside for name in PRINTED if (each / name).is_file()]
    found = []
    for k, page in enumerate(pages, start=1):
        say(f"printing {page} ({k} of {len(pages)})")
        found += replace_files(page.parent, {page.with_suffix(".pdf").name: pdf_of(page)})
    return found
