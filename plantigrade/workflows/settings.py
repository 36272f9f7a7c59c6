"""The settings of jobs: dataclasses whose fields are options of the commands."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from plantigrade.bounds import AGES, SEEDS, shown, word
from plantigrade.constants import GRAVITY
from plantigrade.errors import ParameterError, known_names
from plantigrade.models.person import Person
from plantigrade.options import (
    Flag,
    Number,
    OptionalPath,
    OptionalWord,
    Seconds,
    Years,
    optional,
    refuse_unknown,
)
from plantigrade.trajopt.tasks.free_time import FreeTime
from plantigrade.trajopt.tasks.impairments import Impairments
from plantigrade.trajopt.tasks.task_settings import Basis, TaskSettings
from plantigrade.vaulting.approach import Approach
from plantigrade.vaulting.table import VaultingTable

if TYPE_CHECKING:
    from plantigrade.models.human import Human

TRACK, PAPER = "track", "zhakatayev2023"
"""Motions that ``synthesize`` makes from something other than a task."""
OF_RECORDINGS = ("static", "skeleton", "forces", "marker_set", "swap_sides", "mirror_axis",
                 "cutoff", "without_plates")  # fmt: skip
"""Options that say how a recording is read and fitted."""
DEFAULT_JOINTS = "43"  # Joint set of a person who does a task
MIN_CUTOFF = 0.5
"""Least allowed cut-off frequency [Hz]; a stride takes about a second."""
MAX_CUTOFF = 500.0
"""Greatest allowed cut-off frequency [Hz]."""


@dataclass(frozen=True, kw_only=True)
class Settings(Person):
    """Settings that a command inherits."""

    ranges = {"age": AGES}

    age: Years = None
    """Age [years]; selects adult or children's norms."""

    @classmethod
    def of(cls, options: Any) -> Any:
        """Return the settings among the options of a command, which inherits them."""
        return cls(**{f.name: getattr(options, f.name) for f in fields(cls)})

    @classmethod
    def given(cls, what: str, settings: Any, options: Mapping[str, Any]) -> Any:
        """Return settings with options, by name, in place of their fields.

        Raises:
            ParameterError: If there is no such option, or a value is not allowed; ``what`` has it.
        """
        if settings is not None and not isinstance(settings, cls):
            raise ParameterError(f"settings must be {cls.__name__}, not {settings!r:.80}")
        refuse_unknown(what, options, (f.name for f in fields(cls)))
        return cls(**options) if settings is None else replace(settings, **options)

    def refuse(self, names: Iterable[str], why: str) -> None:
        """Refuse options that would be ignored.

        Raises:
            ParameterError: If one of them is not at its default; the message says ``why``.
        """
        default = {f.name: f.default for f in fields(self)}
        given = [name for name in names if getattr(self, name) != default[name]]
        if given:
            has = "has" if len(given) == 1 else "have"
            raise ParameterError(f"{' and '.join(given)} {has} no effect {why}")

    def plain(self) -> dict[str, Any]:
        """Return the settings as ``metrics.json`` holds them."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {k: str(v) if isinstance(v, Path) else v for k, v in values.items()}


@dataclass(frozen=True, kw_only=True)
class RecordingSettings(Settings):
    """How a recording is read, fitted and analysed.

    Raises:
        ParameterError: If the cut-off frequency is out of range.
    """

    activity = "motion (6 suits walking, 15 running)"
    ranges = {"cutoff": (MIN_CUTOFF, MAX_CUTOFF, "Hz")}

    static: OptionalPath = None
    """Standing trial of the same person."""
    skeleton: OptionalPath = None
    """Skeleton (.asf) of an AMC file, or body model (.npz) for the betas of an SMPL file."""
    forces: OptionalPath = None
    """Ground reaction file of the same trial (.mot, .sto, .forces)."""
    marker_set: OptionalPath = None
    """Your own marker set (.toml)."""
    swap_sides: Flag = False
    """Swap left and right in marker and event names, for a mirrored file."""
    mirror_axis: Flag = False
    """Reverse the mediolateral axis of a mirrored file; names are kept."""
    norms: OptionalPath = None
    """Your own norms to compare with: a .csv file or a folder of runs."""
    cutoff: Number = None
    """Low-pass cut-off for motion and forces [Hz]; by default 6 for walking, 15 for running."""
    without_plates: Flag = False
    """Ignore the force plates: estimate forces from the motion and compare with the plates."""
    companions: tyro.conf.Suppress[bool] = True
    """Look for companion files in the folder of the recording."""

    def __post_init__(self):
        super().__post_init__()
        if self.swap_sides and self.mirror_axis:
            raise ParameterError(
                "swap_sides and mirror_axis each correct a mirrored file and cancel out together: "
                "give only one"
            )

    def refuse_person(self) -> None:
        """Refuse a person for a run, which has its own."""
        if self.known:
            raise ParameterError(
                f"a run defines its own person: leave out {', '.join(self.known)}, or name the "
                "recording"
            )


@dataclass(frozen=True, kw_only=True)
class FitSettings(RecordingSettings):
    """Everything that decides the result of a fit, as written into ``metrics.json``."""

    activity = "the frames of a file"
    ranges = {"rate": (1, 1000, "Hz")}

    model: OptionalPath = None
    """Your own scaled OpenSim model (.osim), in place of a scaled human: angles and moments of its
    coordinates."""
    ground: OptionalWord = None
    """Ground under the feet: slope:DEG (up along the way, negative down), slope:DEG,HEADING (up to
    the left of it), steps:CM (height of each step)."""
    rate: Number = None
    """Frame rate of an SMPL or AMC file that does not store it [Hz]; by default 30 and 120."""


@dataclass(frozen=True, kw_only=True)
class ReproduceSettings(RecordingSettings):
    """Everything that decides how a recorded gait is reproduced."""

    tasks: Literal[
        "default", "paper", "six-phases", "no-rates", "two-phases", "split-com", "no-posture"
    ] = "default"
    """Task set: the default, the paper's, or one of the paper's ablations."""
    no_dynamics: Flag = False
    """Compute the motion only: no ground reactions, no joint moments."""


@dataclass(frozen=True, kw_only=True)
class TrainSettings(RecordingSettings):
    """Everything that decides a training, including the fit of a recording."""

    activity = "a training"
    ranges = {
        "steps": (1, 10**10, ""),
        "goal": (0, 600, "s"),
        "terrain": (0, 20, "cm"),
        "clearance": (0, 20, "cm"),
        "pushes": (0, 1000, "N"),
        "seeds": (1, 1000, ""),
        "seed": SEEDS,
        "jobs": (-1, 1024, ""),
    }

    norms: tyro.conf.Suppress[OptionalPath] = None
    """Without use here; refused."""
    age: tyro.conf.Suppress[Years] = None
    """Without use here; refused."""
    gains: Literal["variable", "fixed"] = "variable"
    """Learn the stiffness of ankles and feet, or keep it fixed."""
    form: Literal["lean", "paper"] = "lean"
    """State and action: a lean form that learns in minutes, or the paper's."""
    ground: OptionalWord = None
    """Training ground: flat, bumps:CM, … as for simulate."""
    terrain: float = 0.0
    """Height of random terrain, new in every episode [cm]."""
    clearance: Number = None
    """Least height of the reference's soles in mid-swing [cm]; by default 3 with --terrain,
    otherwise as it is."""
    pushes: float = 0.0
    """Maximum force of random pushes during training [N]."""
    landing: Flag = False
    """Penalise hard landings, and load and inclination of feet that differ from the reference."""
    start: OptionalWord = None
    """Policy to start from, with any feet: a policy.npz, or learned for a bundled one."""
    steps: int = 3_000_000
    """Maximum number of decisions; 30 make a second of walking."""
    goal: float = 20.0
    """Stop once all 16 test walks last this long without a fall [s]; 0: never."""
    seeds: int = 1
    """Number of policies, with consecutive seeds from --seed on."""
    seed: int = 0
    """Random seed."""
    device: str = "cpu"
    """torch device, such as cpu or cuda."""
    jobs: int = 1
    """Number of processes that simulate, -1 for one per core; the policy does not depend on it."""

    def __post_init__(self):
        super().__post_init__()
        if self.jobs == 0:
            raise ParameterError("jobs must be 1, 2, … or -1 for one per core, not 0")
        self.refuse(("norms", "age"), "on a training")


@dataclass(frozen=True, kw_only=True)
class SolveSettings(Impairments, Settings):
    """The person who does a task, and the solver.

    Raises:
        ParameterError: If a number is out of range or a word unknown.
    """

    activity = "a synthesis"
    ranges = {
        "gravity": (0.15, 1.5, "of the earth's"),
        "nodes_per_second": (2, 500, "1/s"),
        "restarts": (1, 1000, ""),
        "seed": SEEDS,
    }

    gravity: float = 1.0
    """Gravity relative to the earth's: 0.165 on the moon, 0.38 on Mars."""

    solver: Literal["interior-point", "ipopt"] = "interior-point"
    """Built-in banded interior-point solver, or IPOPT as a reference."""
    basis: Basis = None
    """Spline basis; by default that of the task."""
    nodes_per_second: Number = None
    """Mesh nodes per second; by default those of the task."""
    warm: OptionalPath = None
    """Run folder of a similar motion as the initial guess."""
    restarts: int = 1
    """Number of initial guesses, all but the first with noise; the lowest cost wins."""
    seed: int = 0
    """Random seed of the restarts."""
    free_time: Annotated[
        tuple[str, ...], tyro.conf.UseAppendAction, optional("NAME=LEAST:MOST")
    ] = ()
    """Parameter of the task that sets times, and the bounds between which the one that costs least
    is searched, such as duration=1:3; repeatable."""
    replay: Flag = False
    """Also simulate the motion with a controller, with and without pushes (half a minute)."""

    def __post_init__(self):
        super().__post_init__()
        word("solver", self.solver, ("interior-point", "ipopt"))
        if self.basis is not None:
            word("basis", self.basis, ("trigonometric", "polynomial"))
        if self.seed and self.restarts == 1:
            raise ParameterError("seed has no effect without restarts")
        for name in ("gravity", "wrench", "device"):
            if self.replay and getattr(self, name) != getattr(type(self), name):
                raise ParameterError(f"replay has no {name}: leave out one of both")
        named = [_bounds_of_time(word)[0] for word in self.free_time]
        if twice := {name for name in named if named.count(name) > 1}:
            raise ParameterError(f"free_time {min(twice)} is given twice; give its bounds once")

    def free_times(self, parameters: TaskSettings) -> tuple[FreeTime, ...]:
        """Return the free times among the parameters of a task; each guess is its value.

        Raises:
            ParameterError: If one is no time of the task, or its bounds are not allowed.
        """
        allowed = list(parameters.times)
        found = []
        for name, (least, most) in map(_bounds_of_time, self.free_time):
            if name not in allowed:
                raise ParameterError(f"free_time: no time {name!r}; {known_names(name, allowed)}")
            for bound in (least, most):
                replace(parameters, **{name: bound})  # refuses what is out of range
            value = getattr(parameters, name)
            found.append(
                FreeTime(name, least, most, (least + most) / 2 if value is None else value)
            )
        return tuple(found)

    @property
    def words(self) -> list[str]:
        """What differs from an able person on the earth, in words."""
        elsewhere = [] if self.gravity == 1.0 else [f"{self.gravity:g} g"]
        return [*elsewhere, *super().words]

    def person(self, human: "Human") -> "Human":
        """Return the person with these loads and soles, where gravity is as given."""
        human = super().person(human)
        return human if self.gravity == 1.0 else human.with_gravity(self.gravity * GRAVITY)


def _bounds_of_time(word: str) -> tuple[str, tuple[float, float]]:
    """Return name and bounds of a free time."""
    name, _, bounds = word.partition("=")
    low, _, high = bounds.partition(":")
    try:
        return name.strip().replace("-", "_"), (float(low), float(high))
    except ValueError:
        raise ParameterError(
            f"free_time {shown(word)}: write NAME=LEAST:MOST, such as duration=1:3"
        ) from None


@dataclass(frozen=True, kw_only=True)
class PaperSettings(Settings):
    """A motion of [Zhakatayev2023]_ solved as posed in the paper."""

    motion: Literal["walk", "sit-to-stand", "side-step", "jump"] = "walk"
    """Which of the paper's motions."""
    basis: Literal["trigonometric", "polynomial"] = "trigonometric"
    """Spline basis."""


@dataclass(frozen=True, kw_only=True)
class TrackSettings(RecordingSettings):
    """How a recording is tracked by a dynamically consistent motion."""

    activity = "tracking"
    ranges = {"start": (-1e6, 1e6, "s"), "stop": (-1e6, 1e6, "s"), "refinements": (0, 20, "")}

    start: Seconds = None
    """Start [s]; by default the first gait event, or the first frame if there is none."""
    stop: Seconds = None
    """End [s]; by default the last gait event or frame."""
    refinements: int = 5
    """Maximum number of mesh refinements where contact cannot provide the required force."""

    def __post_init__(self):
        super().__post_init__()
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            raise ParameterError(f"start={self.start:g} s must be before stop={self.stop:g} s")


@dataclass(frozen=True, kw_only=True)
class VaultSettings(VaultingTable, Approach, Settings):
    """Gymnast, approach, table and search of a vault.

    Raises:
        ParameterError: If a number is out of range, or the person has other joints or feet than
            the model.
    """

    activity = "a vault"
    ranges = {
        "activation": (0.01, 1, ""),
        "starts": (1, 1000, ""),
        "evaluations": (100, 10**6, ""),
        "seed": SEEDS,
    }

    optimiser: Literal["simplex", "evolution", "both"] = "both"
    """Downhill simplex as in the report, differential evolution, or the better of both."""
    five_segments: Flag = False
    """Fix the elbow, as in the report's second model."""
    compare: Flag = False
    """Also optimise the model with the other number of segments and show it alongside."""
    sensitivity: Flag = False
    """Vary each approach parameter by 5 % and optimise again."""
    activation: float = 1.0
    """Maximum activation of any joint; 1 is full strength."""
    starts: int = 10
    """Number of searches per optimiser, each from its own initial guess."""
    evaluations: int = 4000
    """Simulations per search; differential evolution completes its last generation."""
    seed: int = 0
    """Random seed of the initial guesses."""

    def __post_init__(self):
        super().__post_init__()
        word("optimiser", self.optimiser, ("simplex", "evolution", "both"))
        for name, only in (("joints", "42"), ("feet", "rigid"), ("age", None)):
            if getattr(self, name) not in (None, only):
                instead = f"is always {only}" if only else "has no effect"
                raise ParameterError(f"{name} {instead} in a vault: leave it out")
