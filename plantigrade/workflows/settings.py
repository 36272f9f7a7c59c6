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
"""Motions that are made from something else than a task."""
LEARNED, POLICY = "learned", ".npz"
"""The controller that a trained policy of the package is, and how files of others end."""
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
"""Of a person who does a task."""
SLOWEST, FASTEST = 0.5, 500.0
"""Cut-off frequencies that are allowed [Hz]: a stride takes about a second."""


@dataclass(frozen=True, kw_only=True)
class Settings(Person):
    """Settings that a command inherits."""

    ranges = {"age": AGES}

    age: Years = None
    """Age [years]: whether adults or children are the norm."""

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
    """Ground reactions of the same trial (.mot, .sto, .forces)."""
    marker_set: OptionalPath = None
    """Your own marker set (.toml)."""
    swap_sides: Flag = False
    """Exchange left and right in the names of markers and events of a mirrored file."""
    mirror_axis: Flag = False
    """Turn the axis of a mirrored file that points the other way; names are kept."""
    norms: OptionalPath = None
    """Your own norms: a table (.csv) or a folder of runs."""
    cutoff: Number = None
    """Cut-off frequency of the low-pass filter for motion and forces [Hz]; 6, in running 15."""
    without_plates: Flag = False
    """Withhold the force plates: forces follow from the motion, measured ones are shown beside."""
    companions: tyro.conf.Suppress[bool] = True
    """Look beside the recording for files that belong to it."""

    def __post_init__(self):
        """Refuse to mirror twice."""
        super().__post_init__()
        if self.swap_sides and self.mirror_axis:
            raise ParameterError(
                "swap_sides and mirror_axis each mend a mirrored file, together they do nothing: "
                "give one"
            )


@dataclass(frozen=True, kw_only=True)
class ReproduceSettings(FitSettings):
    """Everything that decides how a recorded gait is rebuilt."""

    tasks: Literal[
        "default", "paper", "six-phases", "no-rates", "two-phases", "split-com", "no-posture"
    ] = "default"
    """The default set, the paper's own, or what the paper tried without."""
    no_dynamics: Flag = False
    """Leave out the hierarchy of forces: no ground reactions, no joint moments."""


@dataclass(frozen=True, kw_only=True)
class SimulateSettings(FitSettings):
    """Everything that decides a simulation; what a recording needs to be fitted is among it."""

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

    controller: OptionalWord = None
    """passive, posture, balance, hybrid, stable-pd, replay, pendulum, learned or a policy.npz."""
    motion: Annotated[str | None, optional("NAME|FILE")] = None
    """Foot motion: tiptoe, tilt-inside, tilt-outside, circling, one-foot, jump, or a TOML file."""
    speed: Annotated[str | None, optional("M/S[,M/S@S,…]")] = None
    """Speed of a pendulum's walk, also from a time on: 1.2,0.8@5,0@10; it stands at 0."""
    path: Annotated[str | None, optional("WAY")] = None
    """Way of a pendulum's walk: straight, bearing:DEG[,DEG@S,…] or points:X,Y/X,Y[/…]."""
    stoop: Annotated[str | None, optional("CM[,CM@S,…]")] = None
    """How much lower the head is in a pendulum's walk [cm], also from a time on: 0,25@3,0@6."""
    then: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("FILE|RUN[@S]")] = ()
    """Walk of a recording or run that a pendulum's walk goes over to at a time; repeatable."""
    upper_body: Annotated[
        tuple[str, ...], tyro.conf.UseAppendAction, optional("FILE|RUN|NAME=DEG,…|recorded[@S]")
    ] = ()
    """What spine, neck and arms do in a pendulum's walk, from a time on; repeatable."""
    stepping: Flag = False
    """Let balance take a step where standing in place can no longer succeed."""
    ground: OptionalWord = None
    """flat, slope:DEG, ramp:DEG, sphere:R, dome:CM, steps:CM, bumps:CM, tiles:CM, stones,
    tilting:DEG[,…]."""
    push: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("N,S,DEG,AT")] = ()
    """Push at the trunk: newtons, seconds, direction (0 forward, 90 left), when; repeatable."""
    rope: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("N,X,Y,Z,AT[,S]")] = ()
    """Rope from the trunk to a place: newtons, metres, from when, how long; repeatable."""
    box: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("KG,M/S,DEG,AT")] = ()
    """Box thrown at the trunk: kilograms, speed (0: dropped), direction, when; repeatable."""
    barrier: Annotated[str | None, optional("M,M")] = None
    """Bar across the way: how far ahead and how high [m]; a pendulum's walk stoops under it."""
    shift: Annotated[str | None, optional("M,S,DEG,AT")] = None
    """Sudden shift of a level floor: metres, seconds, direction, when."""
    duration: Seconds = None
    """How long; as long as the motion if absent, 5 s where there is none."""
    rate: Number = None
    """Steps of the physics per second, a multiple of control_rate; 1800, of replay 1000."""
    control_rate: Number = None
    """Commands, and frames kept, per second; 100 if absent, of replay 500 with 100 frames."""
    torque_rise: float = 0.0
    """How long a motor takes from nothing to its greatest torque [s]; at once if zero."""
    stiffness: float = 1.0
    """Stiffness of posture and stable-pd; 1 is four times the strength of a joint per radian."""
    load: float = 0.0
    """Pack on the back, of which the controller does not know [kg]."""
    mass_error_pct: float = 0.0
    """So much heavier is the person than the controller knows [%]; lighter if negative."""
    friction: Number = None
    """Coefficient of friction of the ground; as planned if absent."""
    delay: float = 0.0
    """So late comes every command [s]."""
    sensor_noise_deg: float = 0.0
    """Noise of the angles the controller sees, standard deviation [deg]; rates: 10/s times it."""
    start_noise: float = 0.0
    """Noise that every velocity of the start has, standard deviation [rad/s, m/s]."""
    seed: int = 0
    """Seed of everything random."""

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
    """Everything that decides a training; what a recording needs to be fitted is among it."""

    activity = "a training"
    ranges = {
        "steps": (1, 10**10, ""),
        "goal": (0, 600, "s"),
        "terrain": (0, 20, "cm"),
        "pushes": (0, 1000, "N"),
        "seeds": (1, 1000, ""),
        "seed": SEEDS,
    }

    gains: Literal["variable", "fixed"] = "variable"
    """Whether the stiffness of the feet is learned, too, or fixed."""
    form: Literal["lean", "paper"] = "lean"
    """State and action: those that learn in minutes, or as printed in the paper."""
    ground: OptionalWord = None
    """What is walked on while learning: flat, bumps:CM, … as for simulate."""
    terrain: float = 0.0
    """Relief up to so high and so deep while learning, another in every episode [cm]."""
    pushes: float = 0.0
    """Pushes of up to so much while learning, from anywhere, again and again [N]."""
    landing: Flag = False
    """Hard landings cost, and feet are to be inclined as those of what is followed."""
    start: OptionalWord = None
    """Policy to begin with, of any feet: a policy.npz, or learned, for the package's."""
    steps: int = 3_000_000
    """It ends after so many decisions, 30 of which are a second of walking."""
    goal: float = 20.0
    """It ends where 16 of 16 starts lead to so long a walk without a fall [s]; 0: never."""
    seeds: int = 1
    """So many policies, with seeds from that of --seed on."""
    seed: int = 0
    """Seed of everything random."""
    device: str = "cpu"
    """Of torch: cpu, cuda."""

    def __post_init__(self):
        """Refuse what a training has no use for."""
        super().__post_init__()
        self.refuse(("norms", "age"), "on a training")


@dataclass(frozen=True, kw_only=True)
class SolveSettings(Settings):
    """Who does a task, and how it is solved.

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
    """Our banded interior point, or IPOPT as the reference."""
    basis: Basis = None
    """Splines the motion is made of; the task's own if absent."""
    nodes_per_second: Number = None
    """Nodes of the mesh per second, more are finer and slower; the task's own if absent."""
    warm: OptionalPath = None
    """Run folder of a similar motion to start from."""
    restarts: int = 1
    """First guesses, all but the first with noise; the cheapest motion is taken."""
    seed: int = 0
    """Seed of the noise of restarts."""
    replay: Flag = False
    """Carry the motion out in the physical world as well, pushed and not: half a minute."""

    def __post_init__(self):
        """Refuse what cannot be."""
        super().__post_init__()
        word("solver", self.solver, ("interior-point", "ipopt"))
        if self.basis is not None:
            word("basis", self.basis, ("trigonometric", "polynomial"))
        if self.seed and self.restarts == 1:
            raise ParameterError("seed is that of restarts: add restarts, or leave seed out")


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

    activity = "tracking"
    ranges = {"start": (-1e6, 1e6, "s"), "stop": (-1e6, 1e6, "s"), "refinements": (0, 20, "")}

    start: Seconds = None
    """From when [s]; the first gait event if absent, or the first frame where nobody walks."""
    stop: Seconds = None
    """Until when [s]; the last gait event or frame if absent."""
    refinements: int = 5
    """How often nodes are added where the motion asks for what no contact can give."""

    def __post_init__(self):
        """Refuse times out of order."""
        super().__post_init__()
        if self.start is not None and self.stop is not None and not self.start < self.stop:
            raise ParameterError(f"start={self.start:g} s must be before stop={self.stop:g} s")


@dataclass(frozen=True, kw_only=True)
class VaultSettings(Table, Approach, Settings):
    """Who vaults, how they arrive, on what, and how the best vault is searched.

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
    """The report's downhill simplex, differential evolution, or the best of both."""
    five_segments: Flag = False
    """Fix the elbow, as in the report's second model."""
    compare: Flag = False
    """Search the model with the other number of segments too, and show its vault beside."""
    sensitivity: Flag = False
    """Change each part of the approach by 5 % and search again: what matters most."""
    activation: float = 1.0
    """Greatest activation of any joint; 1 is all its strength."""
    starts: int = 10
    """Searches of each optimiser, each from its own first guess."""
    evaluations: int = 4000
    """Vaults that one search may try; evolution ends its generation, and tries some more."""
    seed: int = 0
    """Seed of the first guesses."""

    def __post_init__(self):
        """Refuse another body than the model's."""
        super().__post_init__()
        word("optimiser", self.optimiser, ("simplex", "evolution", "both"))
        for name, only in (("joints", "42"), ("feet", "rigid"), ("age", None)):
            if getattr(self, name) not in (None, only):
                instead = f"is always {only}" if only else "means nothing"
                raise ParameterError(f"{name} {instead} in a vault: leave it out")
