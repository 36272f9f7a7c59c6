"""The settings of a simulation."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Annotated, Any

import tyro

from plantigrade.bounds import SEEDS
from plantigrade.errors import ParameterError
from plantigrade.options import (
    Number,
    OptionalPath,
    OptionalWord,
    Seconds,
    assignments,
    is_policy,
    optional,
    refuse_unknown,
)
from plantigrade.workflows.controller_options import CLASSES, OPTIONS, WORDS, WalkOptions, given
from plantigrade.workflows.controller_options import users as options_of
from plantigrade.workflows.settings import RecordingSettings

DRIVEN = ("torque_rise", "torque_speed", "delay", "sensor_noise_deg")
"""Options of a simulation that need a controller that drives the joints."""


@dataclass(frozen=True, kw_only=True)
class SimulateSettings(RecordingSettings):
    """Everything that decides a simulation, including the fit of a recording."""

    activity = "a simulation"
    ranges = {
        "duration": (0.01, 3600, "s"),
        "rate": (100, 20000, "1/s"),
        "control_rate": (1, 20000, "1/s"),
        "torque_rise": (0, 10, "s"),
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
    torque_speed: bool = False
    """Let joint torques fall with the speed of their joint, as those of muscles do."""
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
    own: tyro.conf.Suppress[tuple[tuple[str, Any], ...]] = ()
    """Options of the controller: name and value."""

    def __post_init__(self):
        super().__post_init__()
        if self.controller is not None:
            from plantigrade.control.choices import checked

            if not is_policy(self.controller):
                checked(self.controller)
        self.refuse(("norms",), "on a simulation; give them to plantigrade report")
        usual = ("balance",) if self.motion else ("posture", "stable-pd", "replay", "pendulum")
        self.refuse_unused(*((self.controller,) if self.controller else usual))
        if (
            self.rate is not None
            and self.control_rate is not None
            and self.rate < self.control_rate
        ):
            raise ParameterError(
                f"rate={self.rate:g} must be a whole multiple of control_rate={self.control_rate:g}"
            )

    @classmethod
    def of(cls, options: Any) -> "SimulateSettings":
        """Return the settings among the options of a command, with those of its controller."""
        plain = {f.name: getattr(options, f.name) for f in fields(cls) if f.name != "own"}
        own = {**given(options), **assignments(options.set)}
        return cls(**plain, own=tuple(sorted(own.items())))

    @classmethod
    def given(cls, what: str, settings: Any, options: Mapping[str, Any]) -> "SimulateSettings":
        """Return settings with options, by name, in place of their fields.

        Options that are none of a simulation are those of its controller, by dotted name;
        ``controller_settings`` gives many at once.

        Raises:
            ParameterError: If there is no such option, or a value is not allowed.
        """
        plain = {f.name for f in fields(cls)} - {"own"}
        own = {name: value for name, value in options.items() if name not in plain}
        of_controller = own.pop("controller_settings", None)
        if own or of_controller is not None:
            from plantigrade.control.choices import having
            from plantigrade.control.numbers import differences

            if of_controller is not None:
                if not isinstance(of_controller, Mapping):
                    of_controller = differences(of_controller)
                own = {**of_controller, **own}
            unknown = [name for name in own if name not in WORDS and not having(name)]
            refuse_unknown(what, unknown, (*sorted(plain), *WORDS))
        changed = {name: value for name, value in options.items() if name in plain}
        if own:
            before = () if settings is None else settings.own
            changed["own"] = tuple(sorted({**dict(before), **own}.items()))
        return super().given(what, settings, changed)

    @property
    def options(self) -> dict[str, Any]:
        """Options of the controller that were given: value by name."""
        return dict(self.own)

    @property
    def values(self) -> dict[str, Any]:
        """Settings of the controller that were given: value by dotted name."""
        return {name: value for name, value in self.own if name not in WORDS}

    @property
    def words(self) -> WalkOptions:
        """Return the words that command a walk."""
        return WalkOptions(**{name: value for name, value in self.own if name in WORDS})

    def plain(self) -> dict[str, Any]:
        """Return the settings as ``metrics.json`` holds them: those of the controller apart."""
        plain = super().plain()
        del plain["own"]
        return {**plain, **self.options}

    def refuse_unused(self, *controllers: str) -> None:
        """Refuse options that none of some controllers uses.

        Raises:
            ParameterError: If there is one, or it cannot have such a value.
        """
        if self.own:
            self._check_own(controllers)
        if controllers == ("passive",):
            self.refuse(DRIVEN, "with controller=passive, which drives no joint")

    def _check_own(self, controllers: tuple[str, ...]) -> None:
        """Refuse options of another controller, and values that cannot be."""
        from plantigrade.control.choices import having, nearest, typed_setting
        from plantigrade.control.pendulum.path import depths_of, path_of, speeds_of

        own = self.options
        for name, value in self.own:
            users = ("pendulum",) if name in WORDS else having(name)
            if not users:
                raise ParameterError(f"no controller has a setting {name!r}{nearest(name)}")
            if not set(users) & set(controllers):
                raise ParameterError(
                    f"{name} has no effect without controller={' or '.join(users)}"
                )
            if name not in WORDS:
                word = next(word for word in controllers if word in users)
                own[name] = value = typed_setting(word, name, value)
            if name in OPTIONS:
                CLASSES[options_of(name)[0]](**{name: value})  # within its bounds
        object.__setattr__(self, "own", tuple(sorted(own.items())))
        words = self.words
        for word, read in (
            (words.speed, speeds_of),
            (words.path, path_of),
            (words.stoop, depths_of),
        ):
            if word is not None:
                read(word)
