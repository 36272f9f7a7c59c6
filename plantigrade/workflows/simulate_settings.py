"""The settings of a simulation."""

from dataclasses import dataclass
from typing import Annotated

import tyro

from plantigrade.bounds import SEEDS
from plantigrade.errors import ParameterError
from plantigrade.options import (
    Flag,
    Number,
    OptionalPath,
    OptionalWord,
    Seconds,
    optional,
)
from plantigrade.workflows.settings import RecordingSettings

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


@dataclass(frozen=True, kw_only=True)
class SimulateSettings(RecordingSettings):
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
        from plantigrade.control.pendulum.path import depths_of, path_of, speeds_of

        for name, read in {"speed": speeds_of, "path": path_of, "stoop": depths_of}.items():
            word = getattr(self, name)
            if word is not None:
                read(word)
