"""``table.html``: several fitted recordings, one line each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote

import numpy as np

from plantigrade.analyze.gait_profile import SMALLEST
from plantigrade.report.section import Section, page_html
from plantigrade.report.text import rounded_text

COLUMNS = (
    ("error [mm]", ("error_mm",), 1),
    ("speed [m/s]", ("speed_m_s",), 2),
    ("cadence [1/min]", ("cadence_steps_min",), 0),
    ("step, right / left [m]", ("step_length_r_m", "step_length_l_m"), 2),
    ("symmetry index [%]", ("symmetry_index_step_length_pct",), 1),
    ("GPS, right / left [°]", ("gps_r_deg", "gps_l_deg"), 1),
    ("GPS, both [°]", ("gps_deg",), 1),
    ("strides", ("strides_r_count", "strides_l_count"), 0),
)
"""Heading, figures (one, or right and left) and decimals of each column of numbers."""
KEYS = (
    *(key for _, keys, _ in COLUMNS for key in keys),
    *("height_m", "mass_kg", "stance_r_pct", "stance_l_pct", "running"),
)
"""Every figure of the table as CSV."""


@dataclass(frozen=True)
class Fitted:
    """A fitted recording: its figures and its folder, as seen from that of the table."""

    name: str
    metrics: Mapping[str, Any]
    folder: str


def row_values(metrics: Mapping[str, Any]) -> dict[str, Any]:
    """Return the figures of a fit that the table shows, by key; error and speed of any kind."""
    error = metrics.get("marker_rms_mean_mm", metrics.get("joint_rms_mm"))
    speed = metrics.get("walking_speed_m_s", metrics.get("running_speed_m_s"))
    every = {"error_mm": error, "speed_m_s": speed, **metrics}
    return {key: every[key] for key in KEYS if every.get(key) is not None}


def table_html(
    fitted: Sequence[Fitted],
    left_out: Mapping[str, str],
    *,
    status: str,
    provenance: Mapping[str, Any],
) -> str:
    """Return the page of several fits as one text without any outside address.

    Args:
        fitted: Those that could be fitted.
        left_out: Recording → why it could not be.
        status: ``"ok"``, or what went wrong.
        provenance: Where they came from.
    """
    from markupsafe import Markup

    values = [row_values(one.metrics) for one in fitted]
    shown = [c for c in COLUMNS if any(key in each for each in values for key in c[1])]
    rows = []
    for one, known in zip(fitted, values, strict=True):
        folder = quote(one.folder, errors="surrogateescape")
        link = Markup('<a href="{0}/report.html">{1}</a>').format(folder, one.name)
        viewer = Markup('<a href="{0}/viewer.html">viewer</a>').format(folder)
        cells = [_cell(known, keys, digits) for _, keys, digits in shown]
        rows.append([link, str(one.metrics.get("status", "")), *cells, viewer])
    if len(fitted) > 1:
        rows.append(["mean ± SD", "", *(_spread(values, keys, n) for _, keys, n in shown), ""])
    text = (
        "Error: RMS of the markers, mean over frames, or of the joint centres of a skeleton. "
        "Symmetry index: of step length (Robinson et al. 1987). GPS: Gait Profile Score; "
        f"{SMALLEST}° matter clinically (Baker et al. 2009, 2012). The same figures with all their "
        "digits are in table.csv. Mean and SD are over the recordings: give one per person for "
        "them to be those of people."
    )
    headers = ("recording", "status", *(label for label, _, _ in shown), "")
    return page_html(
        [Section("Recordings", headers=headers, rows=rows, text=text)],
        provenance=provenance,
        title="Fitted recordings",
        sentence=f"{len(fitted)} of {len(fitted) + len(left_out)} recordings fitted.",
        status=status,
        left_out=list(left_out.items()),
        key=(),
        footer="",
    )


def _cell(known: Mapping[str, Any], keys: Sequence[str], digits: int) -> str:
    shown = [rounded_text(known.get(key), digits) for key in keys]
    return "–" if set(shown) == {"–"} else " / ".join(shown)


def _spread(values: Sequence[Mapping[str, Any]], keys: Sequence[str], digits: int) -> str:
    """Return mean and SD over recordings, of the mean of both sides where there are two."""
    found = [[each[key] for key in keys] for each in values if all(key in each for key in keys)]
    if len(found) < 2:
        return ""
    known = np.array(found, dtype=float).mean(axis=1)
    return f"{rounded_text(known.mean(), digits)} ± {rounded_text(known.std(ddof=1), digits)}"
