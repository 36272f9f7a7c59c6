"""The settings of jobs: dataclasses whose fields are options of the commands."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from plantigrade.bounds import AGES, SEEDS, word
from plantigrade.errors import ParameterError
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
from plantigrade.synthesize.tasks.settings import Basis
from plantigrade.vault.approach import Approach
from plantigrade.vault.table import Table

TRACK, PAPER = "track", "zhakatayev2023"
"""Motions that ``synthesize`` makes from something other than a task."""
LEARNED, POLICY = "learned", ".npz"
"""Controller name of the bundled policies, and the extension of policy files."""
USED_BY = {
    "stiffness": ("posture", "stable-pd"),
    "stepping": ("balance",),
    **dict.fromkeys(("speed", "path", "stoop", "then", "upper_body"), ("pendulum",)),
}
"""Options of a simulation that only some controllers use."""
DRIVEN = ("torque_rise", "delay", "sensor_noise_deg")
"""Options of a simulation that need a controller that drives the joints."""
OF_RECORDINGS = ("static", "skeleton", "forces", "marker_set", "swap_sides", "mirror_axis",
                 "cutoff", "without_plates")  # fmt: skip
"""Options that say how a recording is read and fitted."""
DEFAULT_JOINTS = "43"
"""Joint set of a person who does a task."""
SLOWEST, FASTEST = 0.5, 500.0
"""Allowed cut-off frequencies [Hz]; a stride takes about a second."""


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
class FitSettings(Settings):
    """Everything that decides the result of a fit, as written into ``metrics.json``.

    Raises:
        ParameterError: If the cut-off frequency is out of range.
    """

    activity = "motion (6 suits walking, 15 running)"
    ranges = {"cutoff": (SLOWEST, FASTEST, "Hz")}

    static: OptionalPath = None
    """Standing trial of the same person."""
    skeleton: OptionalPath = None
    """Skeleton (.asf) of an AMC file."""
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
        """Refuse to mirror twice."""
        super().__post_init__()
        if self.swap_sides and self.mirror_axis:
            raise ParameterError(
                "swap_sides and mirror_axis each correct a mirrored file and cancel out together: "
                "give only one"
            )


@dataclass(frozen=True, kw_only=True)
class ReproduceSettings(FitSettings):
    """Everything that decides how a recorded gait is reproduced."""

    tasks: Literal[
        "default", "paper", "six-phases", "no-rates", "two-phases", "split-com", "no-posture"
    ] = "default"
    """Task set: the default, the paper's, or one of the paper's ablations."""
    no_dynamics: Flag = False
    """Compute the motion only: no ground reactions, no joint moments."""


@dataclass(frozen=True, kw_only=True)
class SimulateSettings(FitSettings):
    """Everything that decides a simulation, including the fit of a recording."""

    activity = "a simulation"
    ranges = {
        "duration": (0.01, 3600, "s"),
        "rate": (100, 20000, "1/s"),
        "control_rate": (1, 20000, "1/s"),
        "torque_rise": (0, 10, "s"),
        "stiffness": (0, 100, "times what is usual"),
        "mass_error_pct": (-50, 100, "%"),
        "friction": (0.01, 10, ""),
        "delay": (0, 0.5, "s"),
        "sensor_noise_deg": (0, 10, "deg"),
        "start_noise": (0, 10, "rad/s, m/s"),
        "load": (0, 60, "kg"),
        "seed": SEEDS,
    }

    norms: tyro.conf.Suppress[OptionalPath] = None
    """Without use here; refused."""
    controller: OptionalWord = None
    """passive, posture, balance, hybrid, stable-pd, replay, pendulum, learned or a policy.npz."""
    motion: Annotated[str | None, optional("NAME|FILE")] = None
    """Foot motion: tiptoe, tilt-inside, tilt-outside, circling, one-foot, jump, or a TOML file."""
    speed: Annotated[str | None, optional("M/S[,M/S@S,…]")] = None
    """pendulum: walking speed, with changes: 1.2,0.8@5,0@10; 0 stands."""
    path: Annotated[str | None, optional("PATH")] = None
    """pendulum: straight, bearing:DEG[,DEG@S,…] or points:X,Y/X,Y[/…]."""
    stoop: Annotated[str | None, optional("CM[,CM@S,…]")] = None
    """pendulum: by how much to lower the head [cm], with changes: 0,25@3,0@6."""
    then: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("FILE|RUN[@S]")] = ()
    """pendulum: walk of a recording or run to switch to at a time; repeatable."""
    upper_body: Annotated[
        tuple[str, ...], tyro.conf.UseAppendAction, optional("FILE|RUN|NAME=DEG,…|recorded[@S]")
    ] = ()
    """pendulum: motion of spine, neck and arms from a time on; repeatable."""
    stepping: Flag = False
    """balance: take a step when balance in place is lost."""
    ground: OptionalWord = None
    """flat, slope:DEG, ramp:DEG, sphere:R, dome:CM, steps:CM, bumps:CM, tiles:CM, stones,
    tilting:DEG[,…]."""
    push: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("N,S,DEG,AT")] = ()
    """Push on the trunk: force, duration, direction (0 forward, 90 left), time; repeatable."""
    rope: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("N,X,Y,Z,AT[,S]")] = ()
    """Rope pulling the trunk to a point: force, point, start, duration; repeatable."""
    box: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("KG,M/S,DEG,AT")] = ()
    """Box thrown at the trunk: mass, speed (0: dropped), direction, time; repeatable."""
    barrier: Annotated[str | None, optional("M,M")] = None
    """Bar across the path: distance ahead and height [m]; the pendulum walk ducks under it."""
    shift: Annotated[str | None, optional("M,S,DEG,AT")] = None
    """Sudden shift of a level floor: distance, duration, direction, time."""
    duration: Seconds = None
    """Duration [s]; by default that of the motion, or 5 s of standing."""
    rate: Number = None
    """Physics rate [Hz], a multiple of the control rate; by default 1800, for replay 1000."""
    control_rate: Number = None
    """Control and frame rate [Hz]; by default 100, for replay 500 with 100 frames."""
    torque_rise: float = 0.0
    """Time for joint torques to rise from zero to maximum [s]; 0 is instantaneous."""
    stiffness: float = 1.0
    """posture, stable-pd: joint stiffness; 1 is four times the joint's strength per radian."""
    load: float = 0.0
    """Backpack that the controller does not know of [kg]."""
    mass_error_pct: float = 0.0
    """Error of the controller's body mass [%]; positive: the person is heavier than it assumes."""
    friction: Number = None
    """Friction coefficient of the ground; by default that of the motion."""
    delay: float = 0.0
    """Delay of every command [s]."""
    sensor_noise_deg: float = 0.0
    """Standard deviation of joint angle noise [deg]; velocities get 10/s times as much."""
    start_noise: float = 0.0
    """Standard deviation of noise added to initial velocities [rad/s, m/s]."""
    seed: int = 0
    """Random seed."""

    def __post_init__(self):
        """Refuse what the world would refuse, before any work."""
        super().__post_init__()
        if self.controller is not None:
            from plantigrade.control.choices import checked

            if not (self.controller == LEARNED or self.controller.endswith(POLICY)):
                checked(self.controller)
        self.refuse(("norms",), "on a simulation; give them to plantigrade report")
        usual = ("balance",) if self.motion else ("posture", "stable-pd", "replay")
        self.refuse_unused(*((self.controller,) if self.controller else usual))
        self._check_walk()
        if (
            self.rate is not None
            and self.control_rate is not None
            and self.rate < self.control_rate
        ):
            raise ParameterError(
                f"rate={self.rate:g} must be a whole multiple of control_rate={self.control_rate:g}"
            )

    def refuse_unused(self, *controllers: str) -> None:
        """Refuse options that none of some controllers uses.

        Raises:
            ParameterError: If there is one.
        """
        for name, users in USED_BY.items():
            if not set(users) & set(controllers):
                self.refuse((name,), f"without controller={' or '.join(users)}")
        if controllers == ("passive",):
            self.refuse(DRIVEN, "with controller=passive, which drives no joint")

    def _check_walk(self) -> None:
        """Refuse words that lead no walk."""
        from plantigrade.control.pendulum.route import depths, path, speeds

        for name, read in {"speed": speeds, "path": path, "stoop": depths}.items():
            word = getattr(self, name)
            if word is not None:
                read(word)


@dataclass(frozen=True, kw_only=True)
class TrainSettings(FitSettings):
    """Everything that decides a training, including the fit of a recording."""

    activity = "a training"
    ranges = {
        "steps": (1, 10**10, ""),
        "goal": (0, 600, "s"),
        "terrain": (0, 20, "cm"),
        "pushes": (0, 1000, "N"),
        "seeds": (1, 1000, ""),
        "seed": SEEDS,
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
    pushes: float = 0.0
    """Maximum force of random pushes during training [N]."""
    landing: Flag = False
    """Penalise hard landings and foot inclination that differs from the reference."""
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

    def __post_init__(self):
        """Refuse what a training has no use for."""
        super().__post_init__()
        self.refuse(("norms", "age"), "on a training")


@dataclass(frozen=True, kw_only=True)
class SolveSettings(Settings):
    """The person who does a task, and the solver.

    Raises:
        ParameterError: If a number is out of range or a word unknown.
    """

    activity = "a mesh"
    ranges = {
        "nodes_per_second": (2, 500, "1/s"),
        "restarts": (1, 1000, ""),
        "seed": SEEDS,
    }

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
    replay: Flag = False
    """Also simulate the motion with a controller, with and without pushes (half a minute)."""

    def __post_init__(self):
        """Refuse what cannot be."""
        super().__post_init__()
        word("solver", self.solver, ("interior-point", "ipopt"))
        if self.basis is not None:
            word("basis", self.basis, ("trigonometric", "polynomial"))
        if self.seed and self.restarts == 1:
            raise ParameterError("seed has no effect without restarts")


@dataclass(frozen=True, kw_only=True)
class PaperSettings(Settings):
    """A motion of [Zhakatayev2023]_ solved as posed in the paper."""

    motion: Literal["walk", "sit-to-stand", "side-step", "jump"] = "walk"
    """Which of the paper's motions."""
    basis: Literal["trigonometric", "polynomial"] = "trigonometric"
    """Spline basis."""


@dataclass(frozen=True, kw_only=True)
class TrackSettings(FitSettings):
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
        """Refuse times out of order."""
        super().__post_init__()
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            raise ParameterError(f"start={self.start:g} s must be before stop={self.stop:g} s")


@dataclass(frozen=True, kw_only=True)
class VaultSettings(Table, Approach, Settings):
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
        """Refuse another body than the model's."""
        super().__post_init__()
        word("optimiser", self.optimiser, ("simplex", "evolution", "both"))
        for name, only in (("joints", "42"), ("feet", "rigid"), ("age", None)):
            if getattr(self, name) not in (None, only):
                instead = f"is always {only}" if only else "has no effect"
                raise ParameterError(f"{name} {instead} in a vault: leave it out")
