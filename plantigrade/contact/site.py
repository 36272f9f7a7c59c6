"""Contact sites: spheres under the feet, or other points of the body that may be touched."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.models import Human

PARTS = ("heel", "sole", "ball", "toe")
"""Parts of a foot that stand at a time of their own. Heel and sole lift together, then the ball,
last the toes."""

PUSH = "push"
"""Part of a site at which something else than the ground pushes."""
TOUCH = "touch"
"""Part of a site at which a body that is no foot touches the ground."""

GEOM = "contact_"
"""What the names of the geoms begin with that touch the ground."""


@dataclass(frozen=True)
class Point:
    """A point of a body, or the lowest point of a sphere on it.

    Attributes:
        body: Name of the body.
        position: Point, or centre of the sphere, in the body's frame [m].
        radius: Radius of the sphere [m]; zero for a point of the body. The lowest point is that
            of level ground, ``radius`` below the centre in world axes; its velocity and
            acceleration are those of the material that is there.

    Raises:
        ParameterError: If the position is not three finite numbers, or the radius is negative.
    """

    body: str
    position: Sequence[float] | Float[Array, " 3"] = (0.0, 0.0, 0.0)
    radius: float = 0.0

    def __post_init__(self):
        """Take the position as any three numbers."""
        object.__setattr__(self, "position", tuple(float(x) for x in self.position))
        object.__setattr__(self, "radius", float(self.radius))
        if len(self.position) != 3 or not np.isfinite(self.position).all():
            raise ParameterError(f"a point needs three finite numbers [m], not {self.position}")
        if not 0.0 <= self.radius < np.inf:
            raise ParameterError(f"radius={self.radius} [m] must be zero or more")


@dataclass(frozen=True, kw_only=True)
class ContactSite(Point):
    """A point of a body that can carry contact force.

    Attributes:
        body: Name of the body that is touched and that stands still with the site: a sphere on the
            hinge of the toes belongs to the toes, so that the foot rolls over it without slipping.
        name: Its name: ``"heel_back_medial_r"``.
        side: ``"r"`` or ``"l"``; empty for a place on no foot (a seat).
        part: One of :data:`PARTS`, or another word for a place on no foot: ``"chair"``, or
            :data:`PUSH` where the force is not the ground's, so that friction does not limit it.
        measured: Whether the force is a measured one: it acts where the plate says, which moves
            about, and ``position`` means nothing.

    Raises:
        ParameterError: As :class:`Point`, or if the side is none.
    """

    name: str
    side: str = ""
    part: str = ""
    measured: bool = False

    def __post_init__(self):
        """Refuse what is no side."""
        super().__post_init__()
        if self.side not in (*SIDES, ""):
            raise ParameterError(f"{self.name}: side={self.side!r} must be 'r', 'l' or empty")


_STANDING_WITH: dict[str, tuple[tuple[str, str, str], ...]] = {
    # name of the sphere, body it stands still with, part
    "rigid": (
        ("heel_back_medial", "foot", "heel"),
        ("heel_back_lateral", "foot", "heel"),
        ("metatarsal_5", "foot", "sole"),
        ("metatarsal_1", "foot", "sole"),
        ("toe_1", "foot", "toe"),
        ("toe_3", "foot", "toe"),
    ),
    "two-segment": (
        ("heel_back_medial", "foot", "heel"),
        ("heel_back_lateral", "foot", "heel"),
        ("metatarsal_5", "foot", "sole"),  # behind the toe hinge: it lifts with the heel
        ("metatarsal_1", "toes", "ball"),  # on the toe hinge: it stands still with the toes
        ("toe_5", "toes", "ball"),  # shorter than the others: the foot rolls over it
        ("toe_1", "toes", "toe"),
        ("toe_3", "toes", "toe"),
    ),
    "multi-segment": (
        ("heel_back_medial", "heel", "heel"),
        ("heel_back_lateral", "heel", "heel"),
        ("heel_front_lateral", "heel", "sole"),
        ("base_5", "lateral_metatarsal", "sole"),
        ("metatarsal_1", "medial_phalanges", "ball"),
        ("metatarsal_5", "lateral_phalanges", "ball"),
        ("toe_1", "medial_phalanges", "toe"),
        ("toe_3", "medial_phalanges", "toe"),
        ("toe_4", "lateral_phalanges", "toe"),
        ("toe_5", "lateral_phalanges", "toe"),
    ),
}


def contact_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return every contact sphere of a person, in the order of :attr:`Human.contact_points`.

    Each is a site of the body whose frame the sphere is given in.
    """
    sites = []
    for name, side, _ in human.contact_points:
        geom = human.model.geom(name)
        body = human.body_names[int(geom.bodyid[0]) - 1]
        radius, plain = float(geom.size[0]), name.removeprefix(GEOM)
        sites.append(
            ContactSite(body=body, position=geom.pos, radius=radius, name=plain, side=side)
        )
    return tuple(sites)


def foot_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return the sites of both feet that can carry force in a plan, right foot first.

    A sphere on the hinge of the toes belongs to the hindfoot as much as to the toes; it is taken to
    stand still with the toes, so that the foot rolls over it without slipping.
    """
    spheres = contact_sites(human)
    sites = []
    for side in SIDES:
        for name, body, part in _STANDING_WITH[human.feet]:
            sphere = next(s for s in spheres if s.name.endswith(f"_{name}_{side}"))
            own = f"{body}_{side}"
            position = sphere.position
            if sphere.body != own:
                position = _in_child(human, sphere, own)
            full = f"{name}_{side}"
            sites.append(replace(sphere, body=own, position=position, name=full, part=part))
    return tuple(sites)


def _in_child(human: Human, point: Point, body: str) -> Float[Array, " 3"]:
    """Return the place of a point in the axes of a child of its body, all hinges at zero [m]."""
    child = human.model.body(human.body(body))
    if human.model.body_parentid[child.id] != human.body(point.body):
        raise ParameterError(f"{body} does not hang on {point.body}")
    return np.array(point.position) - child.pos
