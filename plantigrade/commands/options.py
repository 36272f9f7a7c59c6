"""Options that several commands share; a command is a dataclass that inherits what it needs.

Each field is one option and the line under it is its help. Nothing here loads NumPy.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro


def optional(metavar: str):
    """Return the marker of an option that may be absent: its word in the help, no default shown."""
    return tyro.conf.arg(metavar=metavar, help_behavior_hint="")


Metres = Annotated[float | None, optional("METRES")]
Kilograms = Annotated[float | None, optional("KG")]
OptionalPath = Annotated[Path | None, optional("PATH")]
Sex = Annotated[Literal["female", "male"] | None, optional("{female,male}")]
Feet = Annotated[
    Literal["rigid", "two-segment", "multi-segment"] | None,
    optional("{rigid,two-segment,multi-segment}"),
]
Joints = Annotated[Literal["42", "43", "58", "66"] | None, optional("{42,43,58,66}")]
Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
Backend = Literal["loky", "threading", "multiprocessing", "ray", "dask"]


@dataclass(frozen=True, kw_only=True)
class PrintOptions:
    """What is printed, and where."""

    quiet: Flag = False
    """No progress on standard error, only warnings."""
    json: Flag = False
    """Print metrics.json on standard output, everything else on standard error."""


@dataclass(frozen=True, kw_only=True)
class PersonOptions:
    """Who moves; what is absent is taken from the recording, then from the average adult."""

    height: Metres = None
    """Body height [m]."""
    mass: Kilograms = None
    """Body mass [kg]."""
    sex: Sex = None
    """Sex, for the body segment parameters."""
    feet: Feet = None
    """Foot model: one box, a box with hinged toes, or 16 bones in five segments."""
    joints: Joints = None
    """Joint set, by its number of coordinates."""


@dataclass(frozen=True, kw_only=True)
class RecordingOptions:
    """What belongs to a recording, and how it is smoothed."""

    static: OptionalPath = None
    """Standing trial of the same person."""
    skeleton: OptionalPath = None
    """Skeleton (.asf) of an AMC file."""
    forces: OptionalPath = None
    """Ground reactions of the same trial (.mot, .sto)."""
    marker_set: OptionalPath = None
    """Your own marker set (.toml)."""
    cutoff: float = 6.0
    """Low-pass of motion and forces [Hz]."""


def fit_settings(options) -> dict[str, Any]:
    """Return the fields of a fit's settings that a command's options say."""
    person = ("height", "mass", "sex", "feet")
    recording = ("static", "skeleton", "forces", "marker_set", "cutoff")
    given = {name: getattr(options, name) for name in (*person, *recording)}
    return given | {"joints": options.joints or "42"}


@dataclass(frozen=True, kw_only=True)
class RunOptions(PrintOptions):
    """Where the run folder goes and how the work is done."""

    out: OptionalPath = None
    """Run folder to write; runs/<command>-<name> if absent."""
    overwrite: Flag = False
    """Replace the run folder if it exists."""
    seed: int = 0
    """Seed of everything random."""


@dataclass(frozen=True, kw_only=True)
class JobOptions:
    """How many independent runs (files, subjects, seeds) are computed side by side."""

    jobs: int = 1
    """Number of runs side by side; -1 for one per core."""
    backend: Backend = "loky"
    """Where they run: joblib's backend."""
