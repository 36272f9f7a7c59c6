"""One test for all controllers: a person walks and is disturbed, and should return to the gait.

::

    from experiments.walk_trial import walk
    from experiments.walkers import walker
    from plantigrade.world import PhasePush

    push = PhasePush(force=200.0, duration=0.4, direction=0.0, side="r", phase=0.3)
    found = walk(walker("pendulum", record), (push,))
    print(found.survived, found.back)
"""

import copy
import copyreg
from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from experiments.walk_outcome import Landing, WalkOutcome
from experiments.walkers import Walker
from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import GEOM_PREFIX
from plantigrade.control.gait.clearance import MAX_LEG_OVERLAP, LegOverlap
from plantigrade.models.landmarks import attachments
from plantigrade.threads import on_one_thread
from plantigrade.world import (
    Command,
    Controller,
    Disturbance,
    InitialState,
    PhasePush,
    State,
    World,
    on_ground,
    world_for,
)
from plantigrade.world.disturbance import (
    LANDED_LOAD,
    LIFTED_LOAD,
    MIN_SWING_TIME,
    StrikeTimer,
    body_index,
)

# Read-only mappings of settings are copied with their walker, which Python cannot do by itself.
copyreg.pickle(MappingProxyType, lambda fixed: (MappingProxyType, (dict(fixed),)))
WATCH_TIME = 6.0
"""Duration of a trial after the last disturbance has ended [s]. Chosen."""
MAX_WAIT_TIME = 12.0
"""Time within which the phase of a push must occur [s]; otherwise there is no gait. Chosen."""
NO_GAIT = "no gait: the phase of the push never occurred"


def tracks(walker: Walker) -> tuple[float, Float[Array, " 2"]]:
    """Return the mean height of the centre of mass of a gait [m], and its direction."""
    from plantigrade.kinematics.state import BodyState

    record = walker.record
    motion, human = record.motion, record.human
    rows = np.linspace(0, motion.n_frames - 1, min(motion.n_frames, 40)).astype(int)
    body, heights = BodyState(human, motion.qpos[0]), []
    for qpos in motion.qpos[rows]:
        com = body.moved_to(qpos, np.zeros(human.model.nv)).com
        heights.append(float(com[2]))
    way = walker.way
    far = float(np.linalg.norm(way))
    axis = way / far if far > 1e-6 else np.array([1.0, 0.0])
    return float(np.mean(heights)) - float(record.ground.height), axis


def world_of(
    walker: Walker,
    controller: Controller,
    ground: Ground | None = None,
    disturbances: Sequence[Disturbance] = (),
    *,
    seed: int = 0,
    noise: float = 0.0,
    recording: bool = False,
) -> World:
    """Return the world of a walk, with the rates and sites that its controller needs.

    Args:
        walker: The walker.
        controller: The controller.
        ground: The ground; that of the gait if None.
        disturbances: The disturbances.
        seed: Seed of the initial noise and of the world.
        noise: Standard deviation of the noise of every initial velocity [m/s, rad/s].
        recording: Whether frames are kept.
    """
    record = walker.record
    motion = record.motion
    ground = ground or record.ground
    rng = np.random.default_rng(seed)
    qvel = motion.qvel[0] + noise * rng.standard_normal(motion.qvel.shape[1])
    initial = InitialState(
        record.human, ground, on_ground(record.human, ground, motion.qpos[0]), qvel
    )
    return world_for(controller, initial, disturbances, recording=recording, seed=seed)


@on_one_thread
def walk(
    walker: Walker,
    disturbances: Sequence[Disturbance] = (),
    *,
    ground: Ground | None = None,
    duration: float | None = None,
    watch: float = WATCH_TIME,
    seed: int = 0,
    noise: float = 0.0,
) -> WalkOutcome:
    """Simulate a walk with disturbances and return the outcome.

    Args:
        walker: The walker.
        disturbances: The disturbances.
        ground: The ground; that of the gait if None.
        duration: Duration [s]; ``watch`` after the last disturbance has ended if absent, and as
            long as the gait, repeated for 10 s, where there is none.
        watch: Duration after the last disturbance [s].
        seed: Seed of the initial noise and of the world.
        noise: Standard deviation of the noise of every initial velocity [m/s, rad/s].
    """
    controller = walker.controller()
    world = world_of(walker, controller, ground, disturbances, seed=seed, noise=noise)
    going = WalkTrial(walker, controller, world)
    if duration is None and not disturbances:
        duration = max(walker.period, 10.0)
    last = np.inf if duration is None else duration
    while going.on:
        pushed = _acted(world, disturbances)
        if duration is None:
            last = MAX_WAIT_TIME if pushed is None else pushed[1] + watch
        if world.time >= last - 0.5 / world.rate:
            break
        going.step()
    pushed = _acted(world, disturbances)
    waited = duration is None and bool(disturbances) and pushed is None
    return going.walked(pushed, NO_GAIT if waited else "")


class WalkTrial:
    """A walk in progress and its record.

    Args:
        walker: The walker.
        controller: The controller.
        world: The world; it is reset.

    Attributes:
        state: State of the person.
    """

    def __init__(self, walker: Walker, controller: Controller, world: World):
        self.walker, self.controller, self.world = walker, controller, world
        self.height, axis = tracks(walker)
        self.frame = np.array([axis, [-axis[1], axis[0]]])
        self.state = world.reset()
        self.start = self.state.body.com[:2].copy()
        self._legs, self._feet, self._back = LegOverlap(world), _Feet(world), _Back(world)
        self._time: list[float] = []
        self._com: list[Array] = []
        self._error: list[float] = []

    @property
    def on(self) -> bool:
        """Whether the person has not fallen and the simulation has not diverged."""
        return self.world.fall is None and self.world.diverged is None

    @property
    def place(self) -> Array:
        """Displacement of the centre of mass along the direction of walking and to its left [m]."""
        return self._com[-1][:2] if self._com else np.zeros(2)

    def step(self) -> None:
        """Simulate one control step."""
        world = self.world
        command = self.controller(self.state)
        signals = command.signals if isinstance(command, Command) else {}
        self.state = world.step(command)
        if world.diverged is not None:
            return
        self._error.append(float(signals.get("tracking_error", np.nan)))
        place = self.state.body.com
        self._time.append(world.time)
        up = place[2] - _level(world.ground, place)
        self._com.append(np.append(self.frame @ (place[:2] - self.start), up))
        self._legs.update()
        self._feet.look(self.state, self.frame, self.start)
        self._back.look(self.state)

    def forget_peaks(self) -> None:
        """Let the greatest force on a foot, lean and bend count from now on."""
        self._feet.peak = self._back.lean = self._back.bend = 0.0

    def walked(self, pushed: tuple[float, float] | None = None, end: str = "") -> WalkOutcome:
        """Return the outcome.

        Args:
            pushed: Start and end of the disturbances [s].
            end: Reason why it does not count as survived, unless the person fell.
        """
        world = self.world
        if self._legs.deepest > MAX_LEG_OVERLAP:
            end = "one leg passed through the other"
        if world.fall is not None:
            end = str(world.fall)
        if world.diverged is not None:
            end = f"diverged at {world.diverged:.2f} s"
        return WalkOutcome(
            not end,
            end,
            np.array(self._time),
            np.array(self._com).reshape(-1, 3),
            np.array(self._error),
            tuple(self._feet.landings),
            pushed,
            self.walker.speed,
            self.height,
            self.walker.period,
            self._feet.peak,
            self._back.lean,
            self._back.bend,
        )

    def copied(self) -> "WalkTrial":
        """Return an independent copy; models and gaits are shared."""
        world, controller = self.world, self.controller
        shared = [world.model, world.human, world.ground, self.walker, self.walker.record]
        shared += controller.shared
        memo: dict[int, Any] = {id(x): x for x in shared if x is not None}
        memo[id(self._legs)] = None  # it refers to its own world
        other = copy.deepcopy(self, memo)
        other._legs = LegOverlap(other.world)
        other._legs.deepest = self._legs.deepest
        return other


class PushedWalk:
    """A walk that can be pushed repeatedly at one phase of the gait.

    The walk before the push is simulated once for controllers of :mod:`plantigrade.control`; others
    may share state with a copy, so they start anew for every push.

    Args:
        walker: The walker.
        phase: Phase of the gait cycle of the right foot, 0 to 1.

    Attributes:
        begin: Start of the push [s]; None if there was no gait.
        mass: Mass of the person [kg].
        speed: Speed of the gait [m/s].
    """

    def __init__(self, walker: Walker, phase: float):
        self.walker, self.phase = walker, phase
        self.mass, self.speed = float(walker.record.human.mass), walker.speed
        self.begin: float | None = None
        self._fell: WalkOutcome | None = None
        self._before = self._walked()
        made = type(self._before.controller).__module__
        self._copies = made.startswith("plantigrade.control.")

    @on_one_thread
    def _walked(self) -> WalkTrial:
        """Return the walk up to the push."""
        controller = self.walker.controller()
        world = world_of(self.walker, controller)
        going, timer = WalkTrial(self.walker, controller, world), StrikeTimer()
        push = PhasePush(force=0.0, duration=1.0, side="r", phase=self.phase)
        mine = np.array([site.side == "r" for site in world.sites])
        while going.on and world.time < MAX_WAIT_TIME:
            if timer.push_time is not None and world.time >= timer.push_time - 1e-9:
                self.begin = world.time
                return going
            going.step()
            if timer.push_time is None:
                load = float(going.state.contact_force[mine, 2].sum())
                timer.update(world.time, load / (world.human.mass * GRAVITY), push)
        self._fell = going.walked(end=NO_GAIT)
        return going

    @on_one_thread
    def __call__(
        self, force: float, direction: float, duration: float, watch: float = WATCH_TIME
    ) -> WalkOutcome:
        """Return the outcome of a push at the trunk.

        Args:
            force: Force [N].
            direction: Direction: 0 forward, a quarter turn to the left [rad].
            duration: Duration of the push [s].
            watch: Duration after the push [s].
        """
        if self._fell is not None or self.begin is None:
            assert self._fell is not None
            return self._fell
        going = self._before.copied() if self._copies else self._walked()
        world, end = going.world, self.begin + duration
        going.forget_peaks()
        way = going.frame.T @ [np.cos(direction), np.sin(direction)]
        vector, body = force * np.append(way, 0.0), body_index(world.human)
        while going.on and world.time < end + watch - 0.5 / world.rate:
            if world.time < end - 1e-9:
                world.push(body, vector)
            going.step()
        return going.walked((self.begin, end))


def _acted(world: World, disturbances: Sequence[Disturbance]) -> tuple[float, float] | None:
    """Return start and end of the disturbances [s]; None if they are not known yet."""
    times: list[float] = []
    for each in disturbances:
        if isinstance(each, PhasePush):
            begin = world.memory[each].push_time
            if begin is None:
                return None
            times += [begin, begin + each.duration]
        else:
            times += each.edges()
    return (min(times), max(times)) if times else None


def _level(ground: Ground, place: Float[Array, " 3"]) -> float:
    """Return the height of the ground under a point, along the vertical [m]."""
    n = ground.normal
    return float((ground.under(place) - n[0] * place[0] - n[1] * place[1]) / n[2])


class _Feet:
    """Records the touchdowns of the feet, and the greatest force on one."""

    def __init__(self, world: World):
        human = world.human
        self._weight = human.mass * GRAVITY
        self._mine = [np.array([s.side == side for s in world.sites]) for side in SIDES]
        self._body = [f"foot_{side}" for side in SIDES]
        self._geom = np.array([world.model.geom(GEOM_PREFIX + s.name).id for s in world.sites])
        self._off: list[float | None] = [None, None]
        self.landings: list[Landing] = []
        self.peak = 0.0

    def look(self, state: State, frame: Array, start: Array) -> None:
        """Record touchdowns and the greatest force from the loads of the feet."""
        force = state.contact_force
        for i, side in enumerate(SIDES):
            load, off = float(force[self._mine[i], 2].sum()) / self._weight, self._off[i]
            self.peak = max(self.peak, load)
            if load < LIFTED_LOAD:
                self._off[i] = state.time if off is None else off
            elif load > LANDED_LOAD:
                if off is not None and state.time - off >= MIN_SWING_TIME:
                    ankle = state.body.origin(self._body[i])
                    own = force[self._mine[i], 2]
                    sole = state.world.data.geom_xpos[self._geom[self._mine[i]]]
                    centre = own @ (sole - ankle) / own.sum()
                    ahead, left = (float(x) for x in frame @ (ankle[:2] - start))
                    heel = bool(centre @ state.body.rotation(self._body[i])[:, 0] < 0.0)
                    self.landings.append(Landing(state.time, side, (ahead, left), heel))
                self._off[i] = None


class _Back:
    """Records how far the upper trunk leans, and how far the back is bent, at most [deg]."""

    def __init__(self, world: World):
        landmarks = attachments(world.human)
        self._upper, self._pelvis = landmarks["c7"].body, landmarks["asis_r"].body
        self.lean = self.bend = 0.0

    def look(self, state: State) -> None:
        """Compare the upward axes of upper trunk, pelvis and world."""
        upper, pelvis = (state.body.rotation(name)[:, 2] for name in (self._upper, self._pelvis))
        self.lean = max(self.lean, _angle(float(upper[2])))
        self.bend = max(self.bend, _angle(float(upper @ pelvis)))


def _angle(cosine: float) -> float:
    """Return the angle of a cosine [deg]."""
    return float(np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0))))
