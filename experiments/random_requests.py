"""Random requests, drawn over all tasks, persons, feet and joints."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.models import FEET, JOINT_SETS, Human

PERSONS = {"height": (1.45, 1.95), "body_mass_index": (18.0, 30.0), "mass": (45.0, 110.0)}
"""Ranges of persons: stature [m], body mass index [kg/m²], mass [kg]."""
TURNS = (-90.0, 90.0)
"""How far a walk turns [deg]."""


@dataclass(frozen=True)
class Request:
    """One request.

    Attributes:
        task: Name of the task.
        options: Options of the task; angles in radians.
        height: Stature [m].
        mass: Body mass [kg].
        sex: ``"female"`` or ``"male"``.
        joints: Joint set.
        feet: Kind of foot.
    """

    task: str
    options: dict[str, Any]
    height: float
    mass: float
    sex: str
    joints: str
    feet: str

    @property
    def human(self) -> Human:
        """The person."""
        return Human.create(self.height, self.mass, self.sex, self.joints, self.feet)

    @property
    def title(self) -> str:
        """Task, options and person."""
        options = ", ".join(f"{name} {_shown(value)}" for name, value in self.options.items())
        who = f"{self.height:.2f} m, {self.mass:.0f} kg, {self.joints}, {self.feet}"
        return f"{self.task} ({options}), {who}" if options else f"{self.task}, {who}"


def random_request(seed: int) -> Request:
    """Return a request that a healthy adult can meet.

    Seeds in a row go through the tasks in turn, so that each is drawn equally often.
    """
    rng = np.random.default_rng(seed)
    height = float(rng.uniform(*PERSONS["height"]))
    mass = float(rng.uniform(*PERSONS["body_mass_index"])) * height**2
    name, options = _TASKS[seed % len(_TASKS)](rng, height)
    rounded = {k: round(float(v), 3) if isinstance(v, float) else v for k, v in options.items()}
    return Request(
        name,
        rounded,
        round(height, 2),
        round(float(np.clip(mass, *PERSONS["mass"])), 1),
        str(rng.choice(["female", "male"])),
        str(rng.choice(JOINT_SETS)),
        str(rng.choice(FEET)),
    )


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(_shown(x) for x in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


Drawn = tuple[str, dict[str, Any]]


def _periodic(rng: np.random.Generator, height: float) -> Drawn:
    return "walk", {"periodic": True, "speed": rng.uniform(0.6, 1.9)}


def _slope(rng: np.random.Generator, height: float) -> Drawn:
    slope = np.deg2rad(rng.uniform(-8.0, 8.0))
    return "walk", {"periodic": True, "speed": rng.uniform(0.8, 1.4), "slope": float(slope)}


def _walk(rng: np.random.Generator, height: float) -> Drawn:
    return "walk", {"speed": rng.uniform(0.6, 1.6), "steps": int(rng.integers(2, 7))}


def _turn(rng: np.random.Generator, height: float) -> Drawn:
    turn = float(np.deg2rad(rng.uniform(*TURNS)))
    return "walk", {"speed": rng.uniform(0.7, 1.2), "steps": int(rng.integers(4, 7)), "turn": turn}


def _step(rng: np.random.Generator, height: float) -> Drawn:
    rise = rng.uniform(0.04, 0.16) * rng.choice([-1.0, 1.0])
    return "walk", {"speed": rng.uniform(0.7, 1.2), "step_height": float(rise)}


def _chair(name: str) -> Callable[[np.random.Generator, float], Drawn]:
    def drawn(rng: np.random.Generator, height: float) -> Drawn:
        return name, {
            "chair_height": height * rng.uniform(0.22, 0.30),
            "duration": rng.uniform(1.6, 3.0),
        }

    return drawn


def _squat(rng: np.random.Generator, height: float) -> Drawn:
    return "squat", {"depth": height * rng.uniform(0.08, 0.24), "duration": rng.uniform(1.8, 3.5)}


def _reach(rng: np.random.Generator, height: float) -> Drawn:
    side = str(rng.choice(["r", "l"]))
    aside = (-1.0 if side == "r" else 1.0) * rng.uniform(0.0, 0.2)
    target = (rng.uniform(0.25, 0.4), aside, rng.uniform(0.55, 0.95))
    place = tuple(round(float(height * x), 2) for x in target)
    return "reach", {"target": place, "side": side, "duration": rng.uniform(1.2, 2.0)}


def _side_step(rng: np.random.Generator, height: float) -> Drawn:
    side = str(rng.choice(["r", "l"]))
    return "side-step", {"distance": rng.uniform(0.1, 0.45), "side": side}


def _jump(rng: np.random.Generator, height: float) -> Drawn:
    return "jump", {"jump_height": rng.uniform(0.05, 0.4), "distance": rng.uniform(0.0, 0.4)}


def _take_off(rng: np.random.Generator, height: float) -> Drawn:
    return "take-off", {"depth": height * rng.uniform(0.1, 0.2)}


_TASKS = (
    _periodic, _walk, _turn, _step, _slope, _chair("sit-to-stand"), _chair("stand-to-sit"),
    _squat, _reach, _side_step, _jump, _take_off,
)  # fmt: skip
