"""A thing about a person that is neither ground nor seat: a bar, a box, a pack."""

from dataclasses import dataclass

from plantigrade.errors import ParameterError

KINDS = ("box", "capsule")
"""What a thing can be: MuJoCo's shapes of these names."""


@dataclass(frozen=True)
class Thing:
    """A thing of simple shape.

    Attributes:
        name: Its name.
        kind: One of :data:`KINDS`.
        size: Half edges of a box; radius and half length of a capsule along z, then zero [m].

    Raises:
        ParameterError: If there is no such kind, or a size is negative.
    """

    name: str
    kind: str
    size: tuple[float, float, float]

    def __post_init__(self):
        """Refuse what has no shape."""
        if self.kind not in KINDS:
            raise ParameterError(f"a thing is one of {', '.join(KINDS)}, not {self.kind!r}")
        if min(self.size) < 0.0 or self.size[0] <= 0.0:
            raise ParameterError(f"sizes of a thing must not be negative: {self.size}")
