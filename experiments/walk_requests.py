"""Random requests of walks: a recording, its person, a ground and disturbances, drawn at random.

What a person can ask of ``simulate`` is drawn in its own units, each within what people walk with,
so that a fall counts against the walker. Chosen grounds and pushes show what was thought of;
drawn ones show what was not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments.cached_results import Result
from experiments.table import Grid

PREFIX = "requests"
N_REQUESTS = 60
"""Number of requests [1]."""
DURATION = 10.0
"""Duration of a walk [s]."""
GROUNDS = ("slope:5", "slope:-5", "slope:8", "bumps:2", "tiles:2", "steps:5")
PUSH_FORCE = (80.0, 220.0)
"""Force of a push [N]; people were pushed with up to 40 N s."""
PUSH_DURATION = (0.1, 0.2)
"""Duration of a push [s]."""
PUSH_TIME = (1.5, 5.0)
"""Time of a push [s]."""
SPEED_FACTORS = (0.6, 0.8, 1.2)
"""Speeds, relative to the recorded one [1]."""


@dataclass(frozen=True)
class WalkRequest:
    """A request.

    Attributes:
        recording: File, relative to the folder of recordings.
        options: Options of ``simulate``.
        speed_factor: Speed, relative to the recorded one [1]; None as recorded.
    """

    recording: str
    options: dict[str, Any]
    speed_factor: float | None

    @property
    def title(self) -> str:
        """Recording and options."""
        speed = [] if self.speed_factor is None else [f"speed x{self.speed_factor:g}"]
        options = [f"{name} {value}" for name, value in self.options.items()]
        return ", ".join([self.recording, *options, *speed])


def random_walk(seed: int, recordings: Sequence[str]) -> WalkRequest:
    """Return a request of a walk that a healthy adult can walk.

    Every option is drawn or left out by itself: most requests have two or three.
    """
    rng = np.random.default_rng(seed)
    name = str(rng.choice(recordings))
    start, force = rng.uniform(*PUSH_TIME), rng.uniform(*PUSH_FORCE)
    push = f"{force:.0f},{rng.uniform(*PUSH_DURATION):.2f},{rng.integers(0, 360)},{start:.2f}"
    options: dict[str, tuple[float, Any]] = {
        "ground": (0.5, str(rng.choice(GROUNDS))),
        "push": (0.6, [push]),
        "load": (0.25, float(rng.integers(5, 15))),
        "delay": (0.25, 0.01),
        "mass_error_pct": (0.25, float(rng.integers(-10, 11))),
        "friction": (0.25, 0.5),
        "sensor_noise_deg": (0.25, 0.2),
        "torque_rise": (0.2, 0.02),
    }
    if not name.endswith((".c3d", ".trc")):  # files of markers know their person's size
        height = round(float(rng.uniform(1.5, 1.95)), 2)
        options["height"] = (0.2, height)
        options["mass"] = (0.0, float(round(height**2 * rng.uniform(18.0, 30.0))))
    drawn = {key: value for key, (share, value) in options.items() if rng.random() < share}
    if "height" in drawn:
        drawn["mass"] = options["mass"][1]
    factor = float(rng.choice(SPEED_FACTORS)) if rng.random() < 0.4 else None
    return WalkRequest(name, drawn, factor)


def requested(
    controller: str, data: Path, recordings: Sequence[str], seed: int, seconds: float
) -> Result:
    """Return what became of a request of the command ``simulate``."""
    import plantigrade as pg

    request = random_walk(seed, recordings)
    options = dict(request.options)
    person = {key: options.pop(key) for key in ("height", "mass") if key in options}
    record = pg.fit(data / request.recording, **person)
    asked = (request.speed_factor or 1.0) * record.metrics["walking_speed_m_s"]
    if request.speed_factor is not None:
        options["speed"] = f"{asked:.2f}"
    made = pg.simulate(record, controller=controller, duration=seconds, seed=seed, **options)
    took, status = made.metrics["duration_s"], made.metrics["status"]
    path = made.record.motion.qpos[:, :2]
    went = float(np.linalg.norm(path[-1] - path[0]))
    return {
        "request": request.title,
        "survived": status == "ok",
        "end": status,
        "seconds": took,
        "speed": went / max(took, 1e-9),
        "asked": asked,
        "rms_deg": made.metrics.get("tracking_error_rms_deg"),
    }


def falls(results: Mapping[str, Result]) -> Grid:
    """Return the table of requests that were not walked."""
    lines = [
        [str(r.get("request", key)), str(r.get("end", r.get("error")))]
        for key, r in results.items()
        if f"/{PREFIX}/" in key and not r.get("survived")
    ]
    return Grid("Requests not walked", ("request", "outcome"), lines)
