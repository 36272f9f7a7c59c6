"""How tasks are solved: dataclasses whose fields are options of ``plantigrade synthesize``."""

from dataclasses import dataclass
from typing import Literal

from plantigrade.errors import ParameterError
from plantigrade.options import Number, OptionalPath, Seconds
from plantigrade.synthesize.tasks.settings import Basis, number, whole, word
from plantigrade.workflows.settings import FitSettings, Settings

DEFAULT_JOINTS = "43"


@dataclass(frozen=True, kw_only=True)
class SolveSettings(Settings):
    """Who does a task, and how it is solved.

    Raises:
        ParameterError: If a number is out of range or a word unknown.
    """

    solver: Literal["interior-point", "ipopt"] = "interior-point"
    """Our banded interior point, or IPOPT as the reference."""
    basis: Basis = None
    """Splines the motion is made of; the task's own if absent."""
    nodes_per_second: Number = None
    """Nodes of the mesh per second, more are finer and slower; the task's own if absent."""
    warm: OptionalPath = None
    """Run folder of a similar motion to start from."""
    restarts: int = 1
    """First guesses, all but the first with noise; the cheapest motion is taken."""

    def __post_init__(self):
        """Refuse what cannot be."""
        word("solver", self.solver, ("interior-point", "ipopt"))
        if self.basis is not None:
            word("basis", self.basis, ("trigonometric", "polynomial"))
        if self.nodes_per_second is not None:
            number("nodes_per_second", self.nodes_per_second, 2, 500, "1/s", "a mesh")
        whole("restarts", self.restarts, 1, 1000)


@dataclass(frozen=True, kw_only=True)
class PaperSettings(Settings):
    """A motion of [Zhakatayev2023]_ solved as the paper sets it."""

    motion: Literal["walk", "sit-to-stand", "side-step", "jump"] = "walk"
    """Which of the paper's motions."""
    basis: Literal["trigonometric", "polynomial"] = "trigonometric"
    """Splines the motion is made of."""


@dataclass(frozen=True, kw_only=True)
class TrackSettings(FitSettings):
    """How a recording is moved by forces of the ground."""

    start: Seconds = None
    """From when [s]; the first gait event if absent, or the first frame where nobody walks."""
    stop: Seconds = None
    """Until when [s]; the last gait event or frame if absent."""
    refinements: int = 3
    """How often nodes are added where the motion asks for what no contact can give."""

    def __post_init__(self):
        """Refuse times out of order."""
        super().__post_init__()
        whole("refinements", self.refinements, 0, 20)
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            raise ParameterError(f"start={self.start:g} s must be before stop={self.stop:g} s")
