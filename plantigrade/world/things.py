"""Ropes that pull at a person, and boxes that are dropped or thrown."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.constants import GRAVITY
from plantigrade.contact.thing import Thing
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world.disturbance import (
    LATEST,
    STRONGEST,
    TURNS,
    Disturbance,
    trunk,
    written_numbers,
)
from plantigrade.world.scene import LIMBS

if TYPE_CHECKING:
    import plantigrade.world.world

FLIGHT, DROP = 1.5, 0.5
"""How far a box flies, and falls [m]."""
HEAD = 0.15
"""Height of the crown above the head's centre of mass [m]."""
PARCEL = 250.0
"""Density of a box [kg/m³]."""
AWAY = 50.0
"""Height at which a box waits until it is thrown [m]."""
FARTHEST, FASTEST = 1e3, 50.0
"""Farthest place and greatest speed of a thing [m, m/s]."""


@dataclass(frozen=True, kw_only=True)
class Rope(Disturbance):
    """A rope that pulls a body towards a fixed point with a constant force.

    Attributes:
        force: Tension [N].
        anchor: Where it leads to, world [m].
        time: When it begins to pull [s].
        duration: How long it pulls; without end if absent [s].
        body: Name of the body at whose centre of mass it is tied; the upper trunk if empty.

    Raises:
        ParameterError: If a number is out of range.
    """

    interval = 0.01
    force: float
    anchor: tuple[float, float, float]
    time: float = 0.0
    duration: float = np.inf
    body: str = ""

    def __post_init__(self):
        """Refuse what is no rope."""
        number("force", self.force, 0, STRONGEST, "N", "a rope, which only pulls")
        for place in self.anchor:
            number("anchor", place, -FARTHEST, FARTHEST, "m", "a rope")
        number("time", self.time, 0, LATEST, "s", "a rope")
        number("duration", self.duration, 1e-3, np.inf, "s", "a rope")

    @staticmethod
    def written(word: str) -> "Rope":
        """Return the rope of a word: newtons, where it leads to [m], when, and how long [s].

        Raises:
            ParameterError: If it is none.

        Example:
            >>> Rope.written("80,2,0,1,0.5").anchor
            (2.0, 0.0, 1.0)
        """
        form = "NEWTON,X,Y,Z,AT_S[,SECONDS] such as 80,2,0,1,0.5,1: towards 2 m ahead, 1 m high"
        force, x, y, z, at, *lasts = written_numbers(word, "rope", form, 5, 6)
        return Rope(force=force, anchor=(x, y, z), time=at, duration=lasts[0] if lasts else np.inf)

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Refuse a body that is not there."""
        trunk(world.human, self.body)

    def edges(self) -> tuple[float, ...]:
        """Return when it begins and ends to pull [s]."""
        return tuple(t for t in (self.time, self.time + self.duration) if np.isfinite(t))

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Pull while it lasts."""
        if self.time - 1e-9 <= world.time < self.time + self.duration - 1e-9:
            body = trunk(world.human, self.body)
            way = np.array(self.anchor) - world.data.xipos[body]
            far = float(np.linalg.norm(way))
            if far > 1e-6:
                world.push(body, self.force / far * way)


@dataclass(frozen=True, eq=False, kw_only=True)
class Box(Disturbance):
    """A box that is dropped or thrown.

    Attributes:
        position: Where its centre starts, world [m].
        velocity: How fast, world [m/s].
        time: When [s].
        mass: Its mass [kg].
        size: Its edges [m].

    Raises:
        ParameterError: If a number is out of range.
    """

    position: tuple[float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    time: float = 0.0
    mass: float = 2.0
    size: tuple[float, float, float] = (0.2, 0.2, 0.2)

    def __post_init__(self):
        """Refuse what is no box."""
        number("mass", self.mass, 1e-3, 500, "kg", "a box")
        number("time", self.time, 0, LATEST, "s", "a box")
        for name, low, high, unit in (
            ("size", 1e-3, 10, "m"),
            ("position", -FARTHEST, FARTHEST, "m"),
            ("velocity", -FASTEST, FASTEST, "m/s"),
        ):
            for value in getattr(self, name):
                number(name, value, low, high, unit, "a box")

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Add the box, far away."""
        number = sum(body.name.startswith("box_") for body in spec.bodies)
        body = spec.worldbody.add_body(name=f"box_{number}", pos=[3.0 * number, 0.0, AWAY])
        edge = np.array(self.size) ** 2
        body.mass, body.ipos = self.mass, [0.0, 0.0, 0.0]
        body.inertia = self.mass / 12.0 * (edge.sum() - edge)
        body.explicitinertial = True
        body.add_freejoint(name=f"box_{number}")
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.5 * x for x in self.size],
            contype=2 | LIMBS,
            conaffinity=1 | 2 | LIMBS,
            rgba=[0.72, 0.60, 0.45, 1.0],
            friction=[0.6, 0.005, 0.0001],
        )

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Find its joint: boxes come in the order of the disturbances."""
        boxes = [d for d in world.disturbances if isinstance(d, Box)]
        number = next(i for i, box in enumerate(boxes) if box is self)
        joint = world.model.joint(f"box_{number}")
        world.memory[self] = [int(joint.qposadr[0]), int(joint.dofadr[0]), False]

    def edges(self) -> tuple[float, ...]:
        """Return when it is thrown [s]."""
        return (self.time,)

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Wait, then fly."""
        q, v, thrown = world.memory[self]
        if thrown:
            return
        data = world.data
        data.qvel[v : v + 6] = 0.0
        data.qpos[q + 2] = AWAY
        if world.time >= self.time - 1e-9:
            place, speed = self.flight(world)
            data.qpos[q : q + 7] = [*place, 1.0, 0.0, 0.0, 0.0]
            data.qvel[v : v + 3] = speed
            world.memory[self][2] = True

    @property
    def thing(self) -> Thing:
        """The box."""
        x, y, z = (0.5 * edge for edge in self.size)
        return Thing("box", "box", (x, y, z))

    def place(self, world: "plantigrade.world.world.World") -> Float[Array, " 7"]:
        """Return where it is once it flies."""
        _, v, thrown = world.memory[self]
        body = int(world.model.dof_bodyid[v])
        pose = np.concatenate([world.data.xpos[body], world.data.xquat[body]])
        return pose if thrown else np.full(7, np.nan)

    def flight(
        self, world: "plantigrade.world.world.World"
    ) -> tuple[Float[Array, " 3"], Float[Array, " 3"]]:
        """Return where it starts [m], and how fast [m/s]."""
        return np.array(self.position), np.array(self.velocity)


@dataclass(frozen=True, eq=False, kw_only=True)
class ThrownBox(Box):
    """A box that is thrown at the upper trunk, or dropped on the head.

    It flies :data:`FLIGHT` to where the trunk will be if it goes on as it does, or falls
    :data:`DROP` from above the head. ``position`` and ``velocity`` mean nothing.

    Attributes:
        speed: How fast it flies over the ground; zero: it is dropped [m/s].
        direction: Where to: 0 forward, a quarter turn to the left [rad].

    Raises:
        ParameterError: As :class:`Box`, or if the speed is neither zero nor from 2 to 50 m/s.
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speed: float = 0.0
    direction: float = 0.0

    def __post_init__(self):
        """Refuse what does not fly."""
        super().__post_init__()
        number("direction", self.direction, -TURNS, TURNS, "rad", "a box")
        if not (self.speed == 0 or 2 <= self.speed <= FASTEST):
            raise ParameterError(
                f"speed={self.speed:g} m/s of a box must be 0 (dropped) or from 2 to {FASTEST:g}"
            )

    @staticmethod
    def written(word: str) -> "ThrownBox":
        """Return the box of a word: kilograms, metres per second, direction in degrees, when [s].

        It is a cube of the density of a full parcel.

        Raises:
            ParameterError: If it is none.

        Example:
            >>> ThrownBox.written("2,5,180,1").size
            (0.2, 0.2, 0.2)
        """
        form = "KG,M_PER_S,DIRECTION_DEG,AT_S such as 2,5,180,1, from the front after 1 s; 0 drops"
        mass, speed, direction, at = written_numbers(word, "box", form, 4)
        edge = float(np.cbrt(max(mass, 0.0) / PARCEL).round(6))
        turned = float(np.deg2rad(direction))
        return ThrownBox(mass=mass, size=(edge, edge, edge), speed=speed, direction=turned, time=at)

    def flight(
        self, world: "plantigrade.world.world.World"
    ) -> tuple[Float[Array, " 3"], Float[Array, " 3"]]:
        """Return where it starts [m], and how fast [m/s]."""
        data, body = world.data, trunk(world.human)
        place, speed = data.xipos[body].copy(), np.zeros(6)
        mujoco.mj_objectVelocity(world.model, data, mujoco.mjtObj.mjOBJ_BODY, body, speed, 0)
        if not self.speed:
            own = slice(1, len(world.human.body_names) + 1)
            head = world.human.body_names.index("head") + 1
            place[:2] = data.xipos[head, :2]
            place[2] = float(data.xipos[own, 2].max()) + HEAD + 0.5 * self.size[2] + DROP
            return place, np.array([*speed[3:5], 0.0])
        way = np.array([np.cos(self.direction), np.sin(self.direction), 0.0])
        time = FLIGHT / self.speed
        rise = 0.5 * GRAVITY * time
        place += speed[3:] * [time, time, 0.0] - FLIGHT * way
        return place, self.speed * way + [0.0, 0.0, rise]
