"""Random people on random grounds, disturbed and moved at random: does the physics ever break?

Every world has its seed: a person of any size, joint set and foot, a ground, up to four
disturbances far beyond what anyone withstands, and a controller that does nothing, holds the
posture, or throws the joints about with targets or torques. Nobody is expected to stand; every
number is expected to be one.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.cached_results import CachedResults
from experiments.table import ResultTable, Row, at_most
from plantigrade.contact.ground import Ground
from plantigrade.control import Posture, PostureSettings, passive
from plantigrade.models import FEET, JOINT_SETS, Human
from plantigrade.record.jobs import run_jobs
from plantigrade.world import (
    AnyController,
    Box,
    Disturbance,
    FloorShift,
    Push,
    Rope,
    StablePD,
    State,
    Tilting,
    World,
)
from plantigrade.world.grounds import ground_named

N_WORLDS = 1000  # number of worlds
N_QUICK_WORLDS = 20  # number of worlds in the short form
DURATION = 2.0  # [s] of one world
WORLDS_PER_RESULT = 50  # number of worlds of one kept result
RESULT_FILE = "worlds.json"
RATES = (300.0, 600.0, 1800.0)  # steps of the physics [1/s]
CONTROL_RATE = 30.0  # [1/s]
GROUNDS = ("flat", "slope", "sphere", "dome", "steps", "bumps", "stones", "moving")


@dataclass(frozen=True)
class Outcome:
    """What became of a random world.

    Attributes:
        seed: Its seed.
        broken: Whether it diverged, or a number is missing.
        fell: Whether the person fell.
        speed: Greatest speed of a joint [rad/s].
    """

    seed: int
    broken: bool
    fell: bool
    speed: float


def random_world(seed: int) -> tuple[World, AnyController]:
    """Return the world of a seed, and what moves the person."""
    rng = np.random.default_rng(seed)
    height = rng.uniform(1.2, 2.0)
    human = Human.create(
        height,
        float(rng.uniform(16.0, 32.0) * height**2),
        str(rng.choice(["female", "male"])),
        str(rng.choice(JOINT_SETS)),
        str(rng.choice(FEET)),
    )
    name = str(rng.choice(GROUNDS))
    ground, disturbances = Ground(), _disturbances(rng)
    if name == "moving":
        way, when = float(rng.uniform(-0.3, 0.3)), float(rng.uniform(0.0, 1.5))
        shift = FloorShift(distance=way, time=when, direction=float(rng.uniform(0, 2 * np.pi)))
        tilt = Tilting(amplitude=float(rng.uniform(0.0, 0.4)), period=float(rng.uniform(0.5, 4.0)))
        disturbances.append(tilt if rng.random() < 0.5 else shift)
    else:
        ground = ground_named(name + _number(name, rng), seed=seed)
    rate = float(rng.choice(RATES))
    world = World(human, ground, disturbances, rate=rate, control_rate=CONTROL_RATE, seed=seed)
    return world, _controller(rng)


def _number(name: str, rng: np.random.Generator) -> str:
    ranges = {"slope": (-25, 25), "sphere": (0.4, 5), "dome": (0.5, 4), "steps": (-20, 20),
              "bumps": (0.5, 8)}  # fmt: skip
    return f":{rng.uniform(*ranges[name]):.3f}" if name in ranges else ""


def _disturbances(rng: np.random.Generator) -> list[Disturbance]:
    """Return up to three pushes, ropes and boxes."""
    found: list[Disturbance] = []
    for _ in range(rng.integers(0, 4)):
        time, turn = float(rng.uniform(0.0, 1.5)), float(rng.uniform(0.0, 2 * np.pi))
        way = np.array([np.cos(turn), np.sin(turn)])
        kind = rng.integers(3)
        if kind == 0:
            force, lasts = float(rng.uniform(0, 1000)), float(rng.uniform(0.02, 0.5))
            found.append(Push(force=force, duration=lasts, direction=turn, time=time))
        elif kind == 1:
            anchor = (float(3 * way[0]), float(3 * way[1]), float(rng.uniform(0.0, 2.0)))
            found.append(Rope(force=float(rng.uniform(0, 500)), anchor=anchor, time=time))
        else:
            place = (float(1.5 * way[0]), float(1.5 * way[1]), float(rng.uniform(0.5, 2.0)))
            speed = -float(rng.uniform(0, 12))
            throw = (float(speed * way[0]), float(speed * way[1]), float(rng.uniform(-1, 3)))
            mass = float(rng.uniform(0.2, 15))
            found.append(Box(position=place, velocity=throw, time=time, mass=mass))
    return found


def _controller(rng: np.random.Generator) -> AnyController:
    kind, size = rng.integers(4), float(rng.uniform(0.1, 1.0))

    def targets(state: State) -> StablePD:
        low, high = state.human.limits
        noise = state.world.random.uniform(-1.0, 1.0, len(low))
        return StablePD(state.angles + size * noise * (high - low) / 2)

    def torques(state: State) -> np.ndarray:
        low, high = np.array(state.human.model.jnt_actfrcrange[1:]).T
        return np.asarray(size * state.world.random.uniform(low, high))

    return (passive, Posture(settings=PostureSettings(stiffness=size)), targets, torques)[kind]


def outcome(seed: int, duration: float = DURATION) -> Outcome:
    """Return what becomes of the world of a seed."""
    world, controller = random_world(seed)
    record = world.simulate(controller, duration)
    arrays = (record.motion.qpos, record.motion.qvel, record.qfrc_actuator, record.contact_force)
    whole = all(a is not None and np.isfinite(a).all() for a in arrays)
    speed = float(np.abs(record.motion.qvel).max())
    return Outcome(seed, world.diverged is not None or not whole, world.fall is not None, speed)


def piece(seeds: Sequence[int], jobs: int) -> dict[str, Any]:
    """Return what becomes of several worlds, as it is cached."""
    outcomes, faults = [], []
    for done in run_jobs(outcome, seeds, jobs=jobs):
        if done.result is None:
            faults.append(f"seed {done.item}: {done.problem}")
        else:
            outcomes.append(asdict(done.result))
    return {"outcomes": outcomes, "faults": faults}


def run(
    *,
    quick: bool = False,
    say: Callable[[str], None] = lambda _: None,
    out: Path | None = None,
    overwrite: bool = False,
) -> ResultTable:
    """Simulate random worlds, on all cores in the long form.

    Args:
        quick: Only :data:`N_QUICK_WORLDS` of them, without cached results.
        say: Called with a line for what is done.
        out: Folder for the cached outcomes, so that an interrupted run continues. Outcomes of
            earlier code are computed again.
        overwrite: Whether to discard cached outcomes.
    """
    n = N_QUICK_WORLDS if quick else N_WORLDS
    path = None if quick or out is None else out / RESULT_FILE
    cached = CachedResults(path, say, overwrite=overwrite)
    if cached.notes():
        say("the cached results are of earlier code and are computed again")
        cached.results.clear()
    found: list[Outcome] = []
    faults: list[str] = []
    for first in range(0, n, WORLDS_PER_RESULT):
        seeds = range(first, min(first + WORLDS_PER_RESULT, n))
        make = partial(piece, seeds, jobs=1 if quick else -1)
        made = cached.get(f"seeds {first} to {seeds[-1]}", make)
        found += [Outcome(**each) for each in made["outcomes"]]
        faults += made["faults"]
    broken = [o.seed for o in found if o.broken]
    note = f"{len(found)} of {n} ran"
    if broken:
        note += f"; seeds {', '.join(map(str, broken[:10]))} broke"
    subject = f"{n} random worlds of {DURATION:g} s"
    rows = [
        Row(subject, "diverged or not a number", len(broken), "", "<= 0", not broken, note),
        at_most(subject, "could not be made or recorded", len(faults), 0),
        Row(subject, "falls", 100.0 * float(np.mean([o.fell for o in found])), "%"),
        Row(subject, "greatest speed of a joint", max(o.speed for o in found), "rad/s"),
    ]
    return ResultTable("Random worlds", rows, faults)
