"""Several fits as one table: a folder with a page, the table as CSV, and the figures."""

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from plantigrade import __version__
from plantigrade.printable import cell
from plantigrade.record.folder import write_folder
from plantigrade.record.provenance import source_files
from plantigrade.report.fit_table import KEYS, Fitted, row_values, table_html
from plantigrade.workflows.settings import FitSettings

PAGE, TABLE = "table.html", "table.csv"
WORDS = ("status", "subject_name", "sex", "age_years", "norm_population")


def write(
    fitted: Sequence[tuple[str, Path, Path, Mapping[str, Any]]],
    left_out: Mapping[str, str],
    out: Path,
    *,
    command: str,
    settings: FitSettings,
    overwrite: bool = False,
    numbered: bool = False,
) -> Path:
    """Write the folder of a table of fits and return it.

    Args:
        fitted: Name, recording, run folder and metrics of each.
        left_out: Recording → why it could not be fitted.
        out: The folder.
        command: The command line.
        settings: Those of all of them.
        overwrite: Replace an existing folder.
        numbered: Number the folder where ``out`` is taken.
    """
    base = out.expanduser().absolute()
    bad = len(left_out) + sum(metrics.get("status") != "ok" for *_, metrics in fitted)
    of = len(fitted) + len(left_out)
    status = f"{bad} of {of} recordings failed" if bad else "ok"
    provenance = {
        "version": __version__,
        "command": command,
        "settings": settings.plain(),
        "source_files": source_files([path for _, path, _, _ in fitted]),
    }
    rows = [
        Fitted(name, metrics, os.path.relpath(folder.expanduser().absolute(), base))
        for name, _, folder, metrics in fitted
    ]
    found = {
        "status": status,
        "recordings_count": of,
        "fitted_count": len(fitted),
        "fits": {
            name: {"file": path, "folder": folder, "status": metrics.get("status")}
            | row_values(metrics)
            for name, path, folder, metrics in fitted
        },
        "left_out": dict(left_out),
    }
    page = table_html(rows, left_out, status=status, provenance=provenance)
    return write_folder(
        out,
        metrics={**provenance, **found},
        files={PAGE: page, TABLE: table_csv(fitted, left_out)},
        overwrite=overwrite,
        numbered=numbered,
    )


def table_csv(
    fitted: Sequence[tuple[str, Path, Path, Mapping[str, Any]]], left_out: Mapping[str, str]
) -> str:
    """Return the table as CSV; what is not known is empty."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["recording", "file", *WORDS, *KEYS])
    for name, path, _, metrics in fitted:
        words = [metrics.get(key, "") for key in WORDS]
        values = row_values(metrics)
        writer.writerow([name, path, *words, *(cell(values.get(key)) for key in KEYS)])
    for path, why in left_out.items():
        writer.writerow([Path(path).stem, path, why, *[""] * (len(WORDS) - 1 + len(KEYS))])
    return stream.getvalue()
