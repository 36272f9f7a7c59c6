"""The virtual contact plate: which places of the feet press how hard [Park2020]_, Figure 13.

The soles are drawn as they are seen through glass from above, toes up, every place that can touch
where it is in quiet standing; a filled disc shows how hard it presses, by its area.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.charts.theme import STROKES
from plantigrade.contact.site import ContactSite
from plantigrade.models import Human

SCALE = 560.0
"""Of the drawing [px/m]."""
HEAVY = 0.5
"""A place that carries so much of the body weight has a disc of :data:`WIDE`."""
WIDE = 0.034
"""Radius of that disc [m]."""
MARGIN = 0.04
"""Around the places of a foot [m]."""


@dataclass(frozen=True, eq=False)
class Sole:
    """The places of a foot that can touch the ground, seen from above.

    Attributes:
        side: ``"r"`` or ``"l"``.
        index: Of its places, among the sites of the record or world.
        names: Of the places.
        place: Forward from the rearmost place and to the left of their middle [m].
    """

    side: str
    index: Int[Array, " k"]
    names: tuple[str, ...]
    place: Float[Array, "k 2"]

    @classmethod
    def of(cls, human: Human, sites: Sequence[ContactSite], side: str) -> "Sole":
        """Return the sole of a side, flat on the ground; measured forces have no place on it."""
        import mujoco

        own = [i for i, s in enumerate(sites) if s.side == side and not s.measured]
        data = mujoco.MjData(human.model)
        data.qpos[:] = human.standing()
        mujoco.mj_kinematics(human.model, data)
        place = np.zeros((len(own), 2))
        for row, i in enumerate(own):
            body = human.body(sites[i].body)
            turned = data.xmat[body].reshape(3, 3) @ np.array(sites[i].position)
            place[row] = (data.xpos[body] + turned)[:2]
        if own:
            place -= [place[:, 0].min(), 0.5 * (place[:, 1].min() + place[:, 1].max())]
        return cls(side, np.array(own, dtype=int), tuple(sites[i].name for i in own), place)

    @property
    def size(self) -> tuple[float, float]:
        """How long and wide it is drawn [m]."""
        if not len(self.index):
            return 0.0, 0.0
        length, width = np.ptp(self.place, axis=0) + 2 * MARGIN
        return float(length), float(width)


def plate_svg(
    soles: Sequence[Sole], load: Float[Array, " n_sites"], *, title: str = "", scale: float = SCALE
) -> str:
    """Return both soles beside each other, the left one on the left.

    Args:
        soles: The feet.
        load: What every site carries [body weights].
        title: Under the feet.
        scale: Of the drawing [px/m].
    """
    drawn = sorted((s for s in soles if len(s.index)), key=lambda s: s.side != "l")
    length = max((s.size[0] for s in drawn), default=0.0)
    width, height = scale * sum(s.size[1] for s in drawn), scale * length + 34
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{max(width, 60):.0f}" '
        f'height="{height:.0f}" viewBox="0 0 {max(width, 60):.0f} {height:.0f}" '
        f'font-family="system-ui, sans-serif" font-size="11">'
    ]
    left = 0.0
    for sole in drawn:
        parts += _foot(sole, load[sole.index], left, scale, length)
        left += scale * sole.size[1]
    if title:
        parts.append(
            f'<text x="{width / 2:.0f}" y="{height - 4:.0f}" text-anchor="middle" '
            f'style="fill:var(--soft, #64707f)">{title}</text>'
        )
    return "".join(parts) + "</svg>"


def _foot(
    sole: Sole, load: Float[Array, " k"], left: float, scale: float, length: float
) -> list[str]:
    """Return one foot: rings where it can touch, discs where it does, its centre of pressure."""
    middle, colour = left + scale * sole.size[1] / 2, STROKES[sole.side]
    x = middle - scale * sole.place[:, 1]
    y = scale * (length - MARGIN - sole.place[:, 0])
    parts = []
    for i, carried in enumerate(np.maximum(load, 0.0)):
        parts.append(
            f'<circle cx="{x[i]:.1f}" cy="{y[i]:.1f}" r="4" fill="none" '
            f'style="stroke:{colour}" stroke-opacity=".5"/>'
        )
        if carried > 0.0:
            radius = scale * WIDE * np.sqrt(carried / HEAVY)
            parts.append(
                f'<circle cx="{x[i]:.1f}" cy="{y[i]:.1f}" r="{max(radius, 1.0):.1f}" '
                f'style="fill:{colour}" fill-opacity=".7"/>'
            )
    total = float(np.maximum(load, 0.0).sum())
    if total > 0.02:
        a, b = (float(np.maximum(load, 0.0) @ v / total) for v in (x, y))
        parts.append(
            f'<path d="M{a - 5:.1f} {b:.1f}h10M{a:.1f} {b - 5:.1f}v10" fill="none" '
            'style="stroke:var(--fg, #1c2430)" stroke-width="1.6"/>'
        )
    parts.append(
        f'<text x="{middle:.1f}" y="{scale * length + 14:.1f}" text-anchor="middle" '
        f'style="fill:{colour}">{"left" if sole.side == "l" else "right"} '
        f"{100 * total:.0f} %</text>"
    )
    return parts
