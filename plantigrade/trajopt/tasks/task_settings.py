"""What the parameters of every task have in common."""

from dataclasses import dataclass, fields
from typing import Annotated, Any, ClassVar, Literal

from plantigrade.bounds import Bounded, word
from plantigrade.options import optional

Side = Literal["r", "l"]
Heights = Annotated[tuple[float, ...] | None, optional("METRES [METRES ...]")]
Target = Annotated[tuple[float, float, float] | None, optional("X Y Z")]
Basis = Annotated[
    Literal["trigonometric", "polynomial"] | None, optional("{trigonometric,polynomial}")
]

MIN_WALKING_SPEED = 0.3  #: Minimum walking speed [m/s]
MAX_WALKING_SPEED = 2.2  #: Maximum walking speed [m/s]
MAX_DURATION = 20.0  #: Maximum duration of a movement in place [s]


@dataclass(frozen=True, kw_only=True)
class TaskSettings(Bounded):
    """Parameters of a task; values out of range raise a ParameterError."""

    times: ClassVar[tuple[str, ...]] = ("duration",)
    """Parameters that set times, which may be free."""

    def __post_init__(self):
        super().__post_init__()
        if "side" in (f.name for f in fields(self)):
            word("side", getattr(self, "side"), ("r", "l"))  # noqa: B009

    @property
    def changed(self) -> dict[str, Any]:
        """Parameters that differ from their defaults, by name."""
        given = ((f, getattr(self, f.name)) for f in fields(self))
        return {f.name: value for f, value in given if value != f.default}
