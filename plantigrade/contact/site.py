"""Contact sites: spheres under the feet, or other points of the body with contact."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.data_files import csv_rows
from plantigrade.errors import ParameterError
from plantigrade.models import Human

__all__ = ["ContactSite", "Point", "contact_sites", "foot_sites"]

"""Parts of a foot with their own contact times. Heel and sole lift together, then the ball, then
the toes."""
CHAIR_PART = "chair"  #: Part name of a site that rests on a seat
PUSH_PART = "push"
"""Part name of a site with a force that is not the ground's."""
TOUCH_PART = "touch"  #: Part name of a ground contact of a body other than a foot
GEOM_PREFIX = "contact_"  #: Prefix of the names of geoms that contact the ground


@dataclass(frozen=True)
class Point:
    """A point of a body, or the lowest point of a sphere on it.

    Raises:
        ParameterError: If the position is not three finite numbers, or the radius is negative.
    """

    body: str  #: Name of the body
    #: Point, or centre of the sphere, in the body's frame [m]
    position: Sequence[float] | Float[Array, " 3"] = (0.0, 0.0, 0.0)
    #: Radius of the sphere [m]; zero for a point. The lowest point is ``radius`` below the centre
    #: in world axes, with velocity and acceleration of the material point there.
    radius: float = 0.0

    def __post_init__(self):
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
        body: Name of the body that is at rest in contact; a sphere on the toe hinge belongs to the
            toes, so that the foot rolls over it without slipping.
        name: Name, such as ``"heel_back_medial_r"``.
        side: ``"r"`` or ``"l"``; empty for a site not on a foot.
        part: ``"heel"``, ``"sole"``, ``"ball"`` or ``"toe"``; elsewhere another name,
            such as ``"chair"``, or :data:`PUSH_PART` for a force that friction does not limit.
        measured: Whether the force is measured and acts at the measured centre of pressure instead
            of ``position``.

    Raises:
        ParameterError: As :class:`Point`, or if the side is invalid.
    """

    name: str
    side: str = ""
    part: str = ""
    measured: bool = False

    def __post_init__(self):
        super().__post_init__()
        if self.side not in (*SIDES, ""):
            raise ParameterError(f"{self.name}: side={self.side!r} must be 'r', 'l' or empty")


@dataclass(frozen=True)
class _Sphere:
    """A sphere that can carry force in a plan: its body at rest in contact, its part."""

    feet: str
    sphere: str
    body: str
    part: str


_SPHERES = csv_rows("plantigrade.contact", "foot_sites.csv", _Sphere)


def contact_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return every contact sphere of a person, in the order of :attr:`Human.contact_points`.

    Each site belongs to the body in whose frame the sphere is given.
    """
    sites = []
    for name, side, _ in human.contact_points:
        geom = human.model.geom(name)
        body = human.body_names[int(geom.bodyid[0]) - 1]
        radius, plain = float(geom.size[0]), name.removeprefix(GEOM_PREFIX)
        sites.append(
            ContactSite(body=body, position=geom.pos, radius=radius, name=plain, side=side)
        )
    return tuple(sites)


def foot_sites(human: Human) -> tuple[ContactSite, ...]:
    """Return the sites of both feet that can carry force in a plan, right foot first.

    A sphere on the toe hinge is assigned to the toes, so that the foot rolls over it without
    slipping.
    """
    spheres = contact_sites(human)
    sites = []
    for side in SIDES:
        for row in (row for row in _SPHERES if row.feet == human.feet):
            name, body, part = row.sphere, row.body, row.part
            sphere = next(s for s in spheres if s.name.endswith(f"_{name}_{side}"))
            own = f"{body}_{side}"
            position = sphere.position
            if sphere.body != own:
                position = _in_child(human, sphere, own)
            full = f"{name}_{side}"
            sites.append(replace(sphere, body=own, position=position, name=full, part=part))
    return tuple(sites)


def _in_child(human: Human, point: Point, body: str) -> Float[Array, " 3"]:
    """Return the position of a point in the frame of a child body, all hinges at zero [m]."""
    child = human.model.body(human.body(body))
    if human.model.body_parentid[child.id] != human.body(point.body):
        raise ParameterError(f"{body} is not a child of {point.body}")
    return np.array(point.position) - child.pos
