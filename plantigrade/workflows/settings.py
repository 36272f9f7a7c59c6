"""The settings of jobs on recordings: dataclasses whose fields are options of the commands."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

import tyro

from plantigrade.errors import ParameterError
from plantigrade.models.person import Person
from plantigrade.options import Flag, OptionalPath

SLOWEST, FASTEST = 0.5, 500.0
"""Cut-off frequencies that are allowed [Hz]: a stride takes about a second."""


@dataclass(frozen=True, kw_only=True)
class Settings(Person):
    """Settings that a command inherits."""

    @classmethod
    def of(cls, options: Any) -> Any:
        """Return the settings among the options of a command, which inherits them."""
        return cls(**{f.name: getattr(options, f.name) for f in fields(cls)})

    def plain(self) -> dict[str, Any]:
        """Return the settings as ``metrics.json`` holds them."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {k: str(v) if isinstance(v, Path) else v for k, v in values.items()}


@dataclass(frozen=True, kw_only=True)
class FitSettings(Settings):
    """Everything that decides the result of a fit, as written into ``metrics.json``.

    Raises:
        ParameterError: If the cut-off frequency is out of range.
    """

    static: OptionalPath = None
    """Standing trial of the same person."""
    skeleton: OptionalPath = None
    """Skeleton (.asf) of an AMC file."""
    forces: OptionalPath = None
    """Ground reactions of the same trial (.mot, .sto)."""
    marker_set: OptionalPath = None
    """Your own marker set (.toml)."""
    cutoff: float = 6.0
    """Cut-off frequency of the low-pass filter for motion and forces [Hz]."""
    companions: tyro.conf.Suppress[bool] = True
    """Look beside the recording for files that belong to it."""

    def __post_init__(self):
        """Refuse a cut-off that would leave nothing, or everything."""
        if not SLOWEST <= self.cutoff <= FASTEST:  # also catches NaN
            raise ParameterError(
                f"cutoff={self.cutoff} Hz: allowed are {SLOWEST:g} to {FASTEST:g}; 6 suits walking"
            )


@dataclass(frozen=True, kw_only=True)
class ReproduceSettings(FitSettings):
    """Everything that decides how a recorded gait is rebuilt."""

    tasks: Literal["default", "paper", "two-phases", "split-com", "no-posture"] = "default"
    """The default set, the paper's own, or what the paper tried without."""
    no_dynamics: Flag = False
    """Leave out the hierarchy of forces: no ground reactions, no joint moments."""
