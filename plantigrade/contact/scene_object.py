"""Objects of a scene other than ground and seats, such as a bar, a box or a pack."""

from dataclasses import dataclass

from plantigrade.errors import ParameterError

SHAPES = ("box", "capsule")
"""Shapes of scene objects, with MuJoCo's names."""


@dataclass(frozen=True)
class SceneObject:
    """An object of simple shape."""

    name: str  #: Name of the object
    kind: str  #: One of :data:`SHAPES`
    #: Half edges of a box; radius and half length of a capsule along z, then zero [m]
    size: tuple[float, float, float]

    def __post_init__(self):
        """Raise for an invalid shape."""
        if self.kind not in SHAPES:
            raise ParameterError(f"a scene object is one of {', '.join(SHAPES)}, not {self.kind!r}")
        if min(self.size) < 0.0 or self.size[0] <= 0.0:
            raise ParameterError(f"sizes of a scene object must not be negative: {self.size}")
