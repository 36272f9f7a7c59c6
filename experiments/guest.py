"""A guest: any MuJoCo model with its own controller, pushed and punched as our persons are.

A guest is a class of your own, derived from :class:`Guest`. It names the model, the trunk and the
feet, starts the walk and returns the controls; the benchmark does the rest in plain MuJoCo:
``experiments/guest_humanoid.py``, docs/push-benchmark.md.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

import mujoco
import numpy as np

from experiments.walk_outcome import Landing, WalkOutcome
from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.gait.clearance import MAX_LEG_OVERLAP
from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.world import PhasePush
from plantigrade.world.disturbance import (
    LANDED_LOAD,
    LIFTED_LOAD,
    MIN_SWING_TIME,
    StrikeTimer,
)
from plantigrade.world.falls import MIN_COM_HEIGHT, Fall

SETTLING_TIME = 5.0
"""Time after which the walk is taken as a gait [s]. Chosen."""
MEASURED_TIME = 15.0
"""Time for which it is measured then [s]. Chosen."""


class Guest(ABC):
    """A model and its controller: what a class of your own offers.

    A new one is made for every walk, without arguments.

    Attributes:
        model: The model, with the ground it walks on. Gravity is that of the model. Left and right
            leg should collide; overlap of the legs is checked in any case.
        trunk: Name of the body that is pushed, at its centre of mass.
        feet: Names of the feet by side, ``{"r": …, "l": …}``; bodies below them belong to them.
        rate: Controls per second [1/s]; a whole number of steps of the model lies between two.
    """

    model: mujoco.MjModel
    trunk: str
    feet: Mapping[str, str]
    rate: float

    @abstractmethod
    def start(self, data: mujoco.MjData) -> None:
        """Set position and velocity of the start."""

    @abstractmethod
    def __call__(self, data: mujoco.MjData) -> Sequence[float] | Float[Array, " nu"]:
        """Return the controls for a state; positions and velocities are up to date."""


@dataclass(frozen=True, eq=False)
class GuestGait:
    """The undisturbed walk of a guest.

    Attributes:
        speed: Mean speed [m/s].
        axis: Direction of walking over the ground.
        height: Mean height of the centre of mass [m].
        period: Mean duration of a stride [s].
        mass: Mass of the model [kg].
    """

    speed: float
    axis: Float[Array, " 2"]
    height: float
    period: float
    mass: float


@contextmanager
def _own_code(name: str) -> Iterator[None]:
    """Run the code of a guest, which may raise anything: as an error of this package."""
    try:
        yield
    except PlantigradeError:
        raise
    except (Exception, SystemExit) as error:
        raise ParameterError(f"guest {name} failed: {f'{error!r}'[:200]}") from error


class GuestWalk:
    """A walk of a guest in progress and its record.

    Args:
        make: Class of the guest.

    Raises:
        ParameterError: If its own code fails, or it names what its model does not have.
    """

    def __init__(self, make: Callable[[], Guest]):
        name = getattr(make, "__name__", "guest")
        with _own_code(name):
            self.guest = guest = make()
            model = guest.model
            self._parts = _Parts.of(guest, name)
            self.data = mujoco.MjData(model)
            self.n_steps = round(1.0 / (guest.rate * model.opt.timestep))
        if self.n_steps < 1 or abs(self.n_steps * model.opt.timestep * guest.rate - 1.0) > 1e-6:
            raise ParameterError(
                f"guest {name}: rate={guest.rate:g} 1/s does not divide the steps of its model, "
                f"{1.0 / model.opt.timestep:g} 1/s"
            )
        with _own_code(name):
            guest.start(self.data)
        mujoco.mj_forward(model, self.data)
        self.mass = float(model.body_subtreemass[self._parts.root])
        self.start = self.data.subtree_com[self._parts.root].copy()
        self.end, self.deepest = "", 0.0
        self.loads: dict[str, float] = dict.fromkeys(SIDES, 0.0)
        self.landings: list[Landing] = []
        self._off: dict[str, float | None] = dict.fromkeys(SIDES)
        self._time: list[float] = []
        self._com: list[Array] = []
        self._load: list[float] = []

    @property
    def time(self) -> float:
        """Time [s]."""
        return float(self.data.time)

    @property
    def on(self) -> bool:
        """Whether the guest has not fallen and the simulation has not diverged."""
        return not self.end

    @property
    def path(self) -> Float[Array, "n 3"]:
        """Displacement of the centre of mass over the ground, and its height, in the world [m]."""
        return np.array(self._com).reshape(-1, 3)

    def bodies(self) -> tuple[str, ...]:
        """Return the names of the moving bodies."""
        model = self.guest.model
        return tuple(
            model.body(b).name for b in range(1, model.nbody) if self._parts.own[b] and
            model.body(b).name
        )  # fmt: skip

    def step(self, forces: Sequence[tuple[str, Float[Array, " 3"]]] = ()) -> None:
        """Simulate one control step.

        Args:
            forces: Bodies and the forces at their centres of mass, in the world [N].
        """
        model, data = self.guest.model, self.data
        data.xfrc_applied[:] = 0.0
        for body, force in forces:
            data.xfrc_applied[model.body(body).id, :3] += force
        with _own_code(type(self.guest).__name__):
            controls = np.asarray(self.guest(data), float)
            if controls.shape != (model.nu,):
                raise ParameterError(
                    f"guest {type(self.guest).__name__} returned {controls.size} numbers; "
                    f"its model has {model.nu} controls"
                )
            data.ctrl[:] = controls
        bad = data.warning.number.sum()
        mujoco.mj_step(model, data, self.n_steps)
        mujoco.mj_forward(model, data)  # contacts and positions of this instant
        if data.warning.number.sum() > bad or not np.isfinite(data.qpos).all():
            self.end = f"diverged at {self.time:.2f} s"
            return
        com = data.subtree_com[self._parts.root]
        self._time.append(self.time)
        self._com.append(np.append(com[:2] - self.start[:2], com[2]))
        self._look()

    def _look(self) -> None:
        """Take contacts into account: loads of the feet, falls, legs in each other."""
        model, data, parts = self.guest.model, self.data, self._parts
        force = np.zeros(6)
        loads: dict[str, float] = dict.fromkeys(SIDES, 0.0)
        for i, contact in enumerate(data.contact[: data.ncon]):
            body = model.geom_bodyid[contact.geom]
            mine, ground = parts.own[body], ~parts.own[body]
            if mine.all():
                continue
            if mine.any() and ground.any():
                limb = int(body[mine][0])
                side = parts.foot.get(limb)
                mujoco.mj_contactForce(model, data, i, force)
                if side is None:
                    if force[0] > 0.0:
                        self.end = str(Fall(self.time, model.body(limb).name))
                else:
                    loads[side] += float(force[0])
        if data.subtree_com[parts.root][2] < MIN_COM_HEIGHT * self.start[2]:
            self.end = str(Fall(self.time))
        self.deepest = max(self.deepest, parts.leg_overlap(model, data))
        if self.deepest > MAX_LEG_OVERLAP:
            self.end = "one leg passed through the other"
        weight = self.mass * GRAVITY
        self.loads = {side: load / weight for side, load in loads.items()}
        self._load.append(max(self.loads.values()))
        for side, load in self.loads.items():
            off = self._off[side]
            if load < LIFTED_LOAD:
                self._off[side] = self.time if off is None else off
            elif load > LANDED_LOAD:
                if off is not None and self.time - off >= MIN_SWING_TIME:
                    place = data.xpos[model.body(self.guest.feet[side]).id] - self.start
                    at = (float(place[0]), float(place[1]))
                    self.landings.append(Landing(self.time, side, at, False))
                self._off[side] = None

    def outcome(
        self, gait: GuestGait, axis: Float[Array, " 2"], pushed: tuple[float, float] | None
    ) -> WalkOutcome:
        """Return the outcome, with the direction of walking along an axis."""
        frame = np.array([axis, [-axis[1], axis[0]]])
        com = self.path.copy()
        com[:, :2] = com[:, :2] @ frame.T
        return WalkOutcome(
            not self.end, self.end, np.array(self._time), com,
            np.full(len(com), np.nan), tuple(self.landings), pushed,
            gait.speed, gait.height, gait.period, self._peak(pushed),
        )  # fmt: skip

    def _peak(self, pushed: tuple[float, float] | None) -> float:
        """Return the greatest load of a foot since the push [body weights]."""
        since = 0.0 if pushed is None else pushed[0]
        after = np.array(self._load)[np.array(self._time) >= since]
        return float(after.max(initial=0.0))


@dataclass(frozen=True, eq=False)
class _Parts:
    """The bodies of a model: its own, its feet and its legs."""

    root: int
    own: Array
    foot: Mapping[int, str]
    legs: tuple[tuple[int, ...], tuple[int, ...]] = field(default=((), ()))

    @classmethod
    def of(cls, guest: Guest, name: str) -> "_Parts":
        model = guest.model
        ids: dict[str, int] = {}
        for what, body in {"trunk": guest.trunk, **{f"feet[{s!r}]": guest.feet.get(s, "")
                                                    for s in SIDES}}.items():  # fmt: skip
            ids[what] = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body)
            if ids[what] < 1:
                there = ", ".join(model.body(b).name for b in range(1, min(model.nbody, 40)))
                raise ParameterError(f"guest {name}: {what}={body!r} is no body; there are {there}")
        root = int(model.body_rootid[ids["trunk"]])
        chains = {s: _chain(model, ids[f"feet[{s!r}]"]) for s in SIDES}
        shared = set(chains["r"]) & set(chains["l"])
        foot: dict[int, str] = {}
        legs: list[tuple[int, ...]] = []
        for side in SIDES:
            below = [b for b in range(model.nbody) if ids[f"feet[{side!r}]"] in _chain(model, b)]
            foot |= dict.fromkeys(below, side)
            leg = {*below, *(b for b in chains[side] if b not in shared)}
            legs.append(
                tuple(g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in leg
                      and (model.geom_contype[g] or model.geom_conaffinity[g]))
            )  # fmt: skip
        own = np.array(model.body_rootid) == root
        own[0] = False
        return cls(root, own, foot, (legs[0], legs[1]))

    def leg_overlap(self, model: mujoco.MjModel, data: mujoco.MjData) -> float:
        """Return the depth to which one leg is in the other [m]."""
        right, left = (np.array(leg, dtype=int) for leg in self.legs)
        if not len(right) or not len(left):
            return 0.0
        apart = np.linalg.norm(data.geom_xpos[right][:, None] - data.geom_xpos[left][None], axis=2)
        near = apart < model.geom_rbound[right][:, None] + model.geom_rbound[left][None]
        depth = 0.0
        for i, j in np.argwhere(near):
            found = mujoco.mj_geomDistance(model, data, int(right[i]), int(left[j]), 0.0, None)
            depth = max(depth, -found)
        return depth


def _chain(model: mujoco.MjModel, body: int) -> tuple[int, ...]:
    """Return a body and those that carry it, without the world."""
    found = []
    while body > 0:
        found.append(body)
        body = int(model.body_parentid[body])
    return tuple(found)


def gait_of(make: Callable[[], Guest]) -> GuestGait:
    """Return the undisturbed gait of a guest.

    Raises:
        ParameterError: If it falls within 20 s, or makes no steps.
    """
    going = GuestWalk(make)
    while going.on and going.time < SETTLING_TIME + MEASURED_TIME:
        going.step()
    name = type(going.guest).__name__
    strikes = [x.time for x in going.landings if x.side == "r" and x.time > SETTLING_TIME]
    if not going.on or len(strikes) < 3:
        why = going.end or "its right foot makes no steps"
        raise ParameterError(
            f"guest {name} does not walk for {SETTLING_TIME + MEASURED_TIME:g} s: {why}"
        )
    n = round(MEASURED_TIME * going.guest.rate)
    com = going.path[-n:]
    way = com[-1, :2] - com[0, :2]
    far = float(np.linalg.norm(way))
    return GuestGait(
        speed=far / ((n - 1) / going.guest.rate),
        axis=way / max(far, 1e-9),
        height=float(com[:, 2].mean()),
        period=float(np.diff(strikes).mean()),
        mass=going.mass,
    )


class PushedGuest:
    """A guest that can be pushed repeatedly at one phase of its gait.

    Args:
        make: Class of the guest.
        phase: Phase of the gait cycle of the right foot, 0 to 1.

    Attributes:
        gait: The undisturbed walk.
        mass: Mass of the model [kg].
        speed: Speed of the gait [m/s].

    Raises:
        ParameterError: If the guest does not walk.
    """

    def __init__(self, make: Callable[[], Guest], phase: float):
        self.make, self.phase, self.gait = make, phase, gait_of(make)
        self.mass, self.speed = self.gait.mass, self.gait.speed

    def __call__(
        self, force: float, direction: float, duration: float, watch: float
    ) -> WalkOutcome:
        """Return the outcome of a push at the trunk.

        Args:
            force: Force [N].
            direction: Direction: 0 along the walk, a quarter turn to the left [rad].
            duration: Duration of the push [s].
            watch: Duration after the push [s].
        """
        going, timer = GuestWalk(self.make), StrikeTimer()
        push = PhasePush(force=0.0, duration=1.0, side="r", phase=self.phase, time=SETTLING_TIME)
        while going.on and (timer.push_time is None or going.time < timer.push_time - 1e-9):
            going.step()
            if timer.push_time is None:
                timer.update(going.time, going.loads["r"], push)
        axis = self._axis(going)
        begin, end = going.time, going.time + duration
        way = np.cos(direction) * axis + np.sin(direction) * np.array([-axis[1], axis[0]])
        vector = force * np.append(way, 0.0)
        half = 0.5 / going.guest.rate
        while going.on and going.time < end + watch - half:
            going.step([(going.guest.trunk, vector)] if going.time < end - half else ())
        return going.outcome(self.gait, axis, (begin, end))

    def _axis(self, going: GuestWalk) -> Float[Array, " 2"]:
        """Return the direction of the last stride."""
        n = min(round(self.gait.period * going.guest.rate), len(going.path) - 1)
        way = going.path[-1, :2] - going.path[-1 - n, :2]
        return np.asarray(way / max(float(np.linalg.norm(way)), 1e-9))
