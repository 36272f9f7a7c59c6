"""The virtual contact plate: distribution of load under the feet ([Park2020]_, Figure 13).

A sole is seen from above, toes up: rings are the places that can touch the ground, where they are
in quiet standing; discs show what presses there, by their area; a cross is the centre of pressure.
The paper's plate shows which places touch; how hard is ours. A measured force has no place of its
own: it is drawn where it acts on the segment.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.charts.theme import STROKES
from plantigrade.constants import SIDE_NAMES
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.pages.shapes import convex_hull
from plantigrade.record import Record

SCALE = 560.0  # [px/m] scale of the drawing
DISC_LOAD = 0.5
"""Load of a place whose disc has the radius :data:`DISC_RADIUS` [BW]."""
DISC_RADIUS = 0.034
"""Radius of that disc [m]."""
MARGIN = 0.034  # [m] margin around the sites of a foot
MIN_LOAD = 0.05  # [body weights] minimum load of a foot with a centre of pressure
INK, SOFT = "var(--fg, #1c2430)", "var(--soft, #64707f)"


@dataclass(frozen=True, eq=False)
class SoleOutline:
    """One foot from above, in axes forward from its rear end and left from its middle [m]."""

    side: str  #: ``"r"`` or ``"l"``
    rings: Float[Array, "n_rings 2"]  #: The spheres of the foot
    index: Int[Array, " k"]  #: Indices of its sites among those of the record or world
    #: Positions of these sites; NaN for measured forces, whose points move
    place: Float[Array, "k 2"]
    corner: Float[Array, " 2"]  #: Origin of these axes, in the world in quiet standing [m]
    #: Position and rotation of every body in quiet standing [m]
    stands: tuple[Float[Array, "nbody 3"], Float[Array, "nbody 3 3"]]

    @classmethod
    def of(cls, human: Human, sites: Sequence[ContactSite], side: str) -> "SoleOutline":
        """Return the sole of a side with its sites."""
        standing = BodyState(human, human.standing())
        stands = standing.origins, standing.rotations

        def place(site: ContactSite) -> Array:
            body = human.body(site.body)
            return (stands[0][body] + stands[1][body] @ np.array(site.position))[:2]

        rings = np.array([place(s) for s in contact_sites(human) if s.side == side])
        corner = np.array([rings[:, 0].min(), 0.5 * (rings[:, 1].min() + rings[:, 1].max())])
        own = [i for i, site in enumerate(sites) if site.side == side]
        fixed = [np.full(2, np.nan) if sites[i].measured else place(sites[i]) for i in own]
        places = np.reshape(fixed, (-1, 2)) - corner
        return cls(side, rings - corner, np.array(own, dtype=int), places, corner, stands)

    @property
    def size(self) -> tuple[float, float]:
        """Length and width of the drawing [m]."""
        length, width = np.ptp(self.rings, axis=0) + 2 * MARGIN
        return float(length), float(width)

    def places(self, record: Record, frame: int) -> Float[Array, "k 2"]:
        """Return where its sites press in a frame: measured forces where they act on the segment.

        That place goes with the segment into quiet standing.
        """
        places = np.array(self.place)
        sites = [record.sites[i] for i in self.index]
        if record.contact_point is None or not any(site.measured for site in sites):
            return places
        human = record.human
        state = BodyState(human, record.motion.qpos[frame])
        for row, site in enumerate(sites):
            if site.measured:
                body = human.body(site.body)
                point = record.contact_point[frame, self.index[row]]
                inside = state.rotation(body).T @ (point - state.origin(body))
                there = self.stands[0][body] + self.stands[1][body] @ inside
                places[row] = there[:2] - self.corner
        return places


def centre(place: Float[Array, "k 2"], load: Float[Array, " k"]) -> Float[Array, " 2"]:
    """Return the centre of pressure on a sole [m]; NaN with hardly any load."""
    up = np.where(np.isfinite(place).all(axis=1), np.maximum(load, 0.0), 0.0)
    if up.sum() <= MIN_LOAD:
        return np.full(2, np.nan)
    return up @ np.nan_to_num(place) / up.sum()


def plate_svg(soles: Sequence[SoleOutline], load: Float[Array, " n_sites"]) -> str:
    """Return both feet side by side, the left one on the left; ``load`` in body weights."""
    feet = sorted(soles, key=lambda sole: sole.side != "l")
    titles = [
        f"{SIDE_NAMES[s.side]} {100 * np.maximum(load[s.index], 0.0).sum():.0f} %" for s in feet
    ]
    drawn = [
        foot_svg(sole, sole.place, load[sole.index], title, 1.4 * SCALE)
        for sole, title in zip(feet, titles, strict=True)
    ]
    return "".join(drawn)


def foot_svg(
    sole: SoleOutline,
    place: Float[Array, "k 2"],
    load: Float[Array, " k"],
    title: str,
    scale: float = SCALE,
    path: Float[Array, "n 2"] | None = None,
) -> str:
    """Return one foot.

    Args:
        place: Positions of its sites [m].
        load: Loads of its sites [body weights].
        scale: Scale of the drawing [px/m].
        path: Path of the centre of pressure [m].
    """
    length, width = sole.size
    wide, high = round(scale * width), round(scale * length + 20)
    colour = STROKES[sole.side]

    def x(values: Any) -> Any:
        return scale * (0.5 * width - values)

    def y(values: Any) -> Any:
        return scale * (length - MARGIN - values)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{high}" '
        f'viewBox="0 0 {wide} {high}" role="img" font-family="system-ui, sans-serif" '
        f'font-size="11"><title>{escape(title)}</title>'
    ]
    parts += _outline(np.column_stack([x(sole.rings[:, 1]), y(sole.rings[:, 0])]), colour, scale)
    for (ahead, left), carried in zip(place, load, strict=True):
        if carried > 0.0 and np.isfinite([ahead, left]).all():
            radius = max(scale * DISC_RADIUS * np.sqrt(carried / DISC_LOAD), 1.0)
            parts.append(
                f'<circle cx="{x(left):.1f}" cy="{y(ahead):.1f}" r="{radius:.1f}" '
                f'style="fill:{colour}" fill-opacity=".65"/>'
            )
    if path is not None:
        seen = path[np.isfinite(path).all(axis=1)]
        points = " ".join(f"{x(b):.1f},{y(a):.1f}" for a, b in seen)
        parts.append(
            f'<polyline points="{points}" fill="none" style="stroke:{INK}" stroke-width="1.6"/>'
        )
    a, b = centre(place, load)
    if np.isfinite(a):
        parts.append(_cross(x(b), y(a)))
    parts.append(
        f'<text x="{wide / 2:.0f}" y="{high - 6}" text-anchor="middle" '
        f'style="fill:{SOFT}">{escape(title)}</text></svg>'
    )
    return "".join(parts)


def _outline(rings: Float[Array, "n 2"], colour: str, scale: float) -> list[str]:
    """Return a sole as the pale hull of its rings, and the rings."""
    around = " ".join(f"{a:.1f},{b:.1f}" for a, b in convex_hull(rings))
    hull = (
        f'<polygon points="{around}" stroke-linejoin="round" stroke-width="{0.03 * scale:.1f}" '
        f'style="fill:{colour};stroke:{colour}" opacity=".1"/>'
    )
    return [
        hull,
        *(
            f'<circle cx="{a:.1f}" cy="{b:.1f}" r="{0.007 * scale:.1f}" fill="none" '
            f'style="stroke:{colour}" stroke-opacity=".55"/>'
            for a, b in rings
        ),
    ]


def _cross(x: float, y: float) -> str:
    return (
        f'<path d="M{x - 5:.1f} {y:.1f}h10M{x:.1f} {y - 5:.1f}v10" fill="none" '
        f'style="stroke:{INK}" stroke-width="1.6"/>'
    )
