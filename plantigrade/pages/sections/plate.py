"""The virtual contact plate: distribution of load under each foot during one contact."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import Figure, grid
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.motion.filters import runs
from plantigrade.pages.contact_plate import MIN_LOAD, SoleOutline, centre, foot_svg
from plantigrade.pages.section import Group, ReportedRun, Section
from plantigrade.record import Record
from plantigrade.side_names import without_side

TITLE = "Virtual contact plate"
DRAWN_PHASES = (0.03, 0.2, 0.4, 0.6, 0.8, 0.97)  # Phases of a contact at which the foot is drawn
PATH_POINTS = 80  # Points of the path of the centre of pressure


def plate_section(subject: ReportedRun) -> list[Section]:
    """Return the distribution of load under the feet, if forces at the feet are known."""
    record = subject.forces
    if not record.has_forces or not any(site.side for site in record.sites):
        return []
    assert record.contact_force is not None  # implied by has_forces
    load = np.nan_to_num(record.contact_force[..., 2]) / record.weight
    if record.contact_known is not None:  # with both feet on one plate the load sharing is unknown
        load = np.where(record.contact_known, load, 0.0)
    if record.contact_point is not None:
        load = np.where(np.isfinite(record.contact_point).all(axis=2), load, 0.0)
    soles = [SoleOutline.of(record.human, record.sites, side) for side in SIDES]
    figures = [_contact(record, sole, load) for sole in soles if len(sole.index)]
    drawn = [figure for figure in figures if figure is not None]
    if not drawn:
        return [Section(TITLE, missing="no force is known for a single foot.")]
    text = (
        "The soles from above, toes up. Rings: contact sites; discs: load, by area; cross and "
        "line: centre of pressure."
    )
    if any(site.measured and site.side for site in record.sites):
        text += " Measured forces are drawn where they act on hindfoot and toes."
    groups = [group for sole in soles if (group := _group(record, sole, load)) is not None]
    return [Section(TITLE, drawn, text=text, groups=groups, folded=True)]


def longest(loaded: Array) -> tuple[int, int] | None:
    """Return first and last frame of the longest contact, preferably a complete one.

    Example:
        >>> longest(np.array([True, True, True, False, True, True, False]))
        (4, 5)
    """
    found = [(run.start, run.stop - 1) for run in runs(loaded)]
    whole = [(a, b) for a, b in found if a > 0 and b < len(loaded) - 1]
    return max(whole or found, key=lambda span: span[1] - span[0], default=None)


def _contact(record: Record, sole: SoleOutline, load: Float[Array, "n k"]) -> Figure | None:
    """Return the plate of a foot at several instants of its longest contact."""
    own = load[:, sole.index]
    span = longest(np.maximum(own, 0.0).sum(axis=1) > MIN_LOAD)
    if span is None:
        return None
    first, last = span
    time = record.motion.time
    frames = [round(first + share * (last - first)) for share in DRAWN_PHASES]
    feet = []
    for frame in dict.fromkeys(frames):
        feet.append(foot_svg(sole, sole.places(record, frame), own[frame], f"{time[frame]:.2f} s"))
    on = np.unique(np.linspace(first, last, PATH_POINTS).astype(int))
    path = np.array([centre(sole.places(record, int(frame)), own[frame]) for frame in on])
    nothing = np.zeros(len(sole.index))
    feet.append(foot_svg(sole, sole.place, nothing, "path", path=path))
    caption = (
        f"{SIDE_NAMES[sole.side].capitalize()} foot, from {time[first]:.2f} to {time[last]:.2f} s."
    )
    return Figure(grid(feet, columns=len(feet)).svg, caption)


def _group(record: Record, sole: SoleOutline, load: Float[Array, "n k"]) -> Group | None:
    """Return the load of every site; nothing for measured forces, whose points move."""
    on = np.maximum(load[:, sole.index], 0.0).sum(axis=1) > MIN_LOAD
    rows = []
    for i in sole.index:
        site = record.sites[i]
        if site.measured or not on.any():
            continue
        own = np.maximum(load[:, i], 0.0)
        name = without_side(site.name).replace("_", " ")
        share = 100.0 * float(np.mean(own[on] > 1e-3))
        rows.append((name, f"{own.max():.2f}", f"{own[on].mean():.2f}", f"{share:.0f}"))
    title = f"{SIDE_NAMES[sole.side].capitalize()} foot, while it stands"
    headers = ("place", "greatest [BW]", "mean [BW]", "time [%]")
    return Group(title, headers, rows) if rows else None
