"""Boxes that are dropped or thrown at a person."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.constants import GRAVITY
from plantigrade.contact.scene import SceneObject
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world.disturbance import (
    MAX_ANGLE,
    MAX_TIME,
    Disturbance,
    body_index,
    parse_numbers,
)
from plantigrade.world.simulated_world import SimulatedWorld
from plantigrade.world.world_model import LIMB_BIT

FLIGHT_DISTANCE = 1.5  # [m] of a thrown box: in sight, and short enough not to drop far
DROP_HEIGHT = 0.5  # [m] of a dropped box, above the crown
CROWN_HEIGHT = 0.15  # [m] of the crown above the head's centre of mass
BOX_DENSITY = 250.0  # [kg/m³] of a full parcel
PARKING_HEIGHT = 50.0  # [m] at which a box waits, out of reach, until it is thrown
MAX_POSITION = 1e3  # [m] from the origin, along any axis
MAX_SPEED = 50.0  # [m/s] along any axis


@dataclass(frozen=True, eq=False, kw_only=True)
class Box(Disturbance):
    """A box that is dropped or thrown.

    Attributes:
        position: Initial position of the centre, world [m].
        velocity: Initial velocity, world [m/s].
        time: Time of release [s].
        mass: Mass [kg].
        size: Lengths of the edges [m].

    Raises:
        ParameterError: If a number is out of range.
    """

    position: tuple[float, float, float]
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    time: float = 0.0
    mass: float = 2.0
    size: tuple[float, float, float] = (0.2, 0.2, 0.2)

    def __post_init__(self):
        number("mass", self.mass, 1e-3, 500, "kg", "a box")
        number("time", self.time, 0, MAX_TIME, "s", "a box")
        for name, low, high, unit in (
            ("size", 1e-3, 10, "m"),
            ("position", -MAX_POSITION, MAX_POSITION, "m"),
            ("velocity", -MAX_SPEED, MAX_SPEED, "m/s"),
        ):
            for value in getattr(self, name):
                number(name, value, low, high, unit, "a box")

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Add the box, parked out of reach."""
        number = sum(body.name.startswith("box_") for body in spec.bodies)
        body = spec.worldbody.add_body(
            name=f"box_{number}", pos=[3.0 * number, 0.0, PARKING_HEIGHT]
        )
        edge = np.array(self.size) ** 2
        body.mass, body.ipos = self.mass, [0.0, 0.0, 0.0]
        body.inertia = self.mass / 12.0 * (edge.sum() - edge)
        body.explicitinertial = True
        body.add_freejoint(name=f"box_{number}")
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.5 * x for x in self.size],
            contype=2 | LIMB_BIT,
            conaffinity=1 | 2 | LIMB_BIT,
            rgba=[0.72, 0.60, 0.45, 1.0],
            friction=[0.6, 0.005, 0.0001],
        )

    def reset(self, world: SimulatedWorld) -> None:
        """Find the joint of the box; boxes have the order of the disturbances."""
        boxes = [d for d in world.disturbances if isinstance(d, Box)]
        number = next(i for i, box in enumerate(boxes) if box is self)
        joint = world.model.joint(f"box_{number}")
        world.memory[self] = [int(joint.qposadr[0]), int(joint.dofadr[0]), False]

    def edges(self) -> tuple[float, ...]:
        """Return the time of release [s]."""
        return (self.time,)

    def act(self, world: SimulatedWorld) -> None:
        """Keep the box parked until its release."""
        q, v, thrown = world.memory[self]
        if thrown:
            return
        data = world.data
        data.qvel[v : v + 6] = 0.0
        data.qpos[q + 2] = PARKING_HEIGHT
        if world.time >= self.time - 1e-9:
            place, speed = self.flight(world)
            data.qpos[q : q + 7] = [*place, 1.0, 0.0, 0.0, 0.0]
            data.qvel[v : v + 3] = speed
            world.memory[self][2] = True

    @property
    def scene_object(self) -> SceneObject:
        """The box."""
        x, y, z = (0.5 * edge for edge in self.size)
        return SceneObject("box", "box", (x, y, z))

    def pose(self, world: SimulatedWorld) -> Float[Array, " 7"]:
        """Return the pose of the box after its release."""
        _, v, thrown = world.memory[self]
        body = int(world.model.dof_bodyid[v])
        pose = np.concatenate([world.data.xpos[body], world.data.xquat[body]])
        return pose if thrown else np.full(7, np.nan)

    def flight(self, world: SimulatedWorld) -> tuple[Float[Array, " 3"], Float[Array, " 3"]]:
        """Return the initial position [m] and velocity [m/s]."""
        return np.array(self.position), np.array(self.velocity)


@dataclass(frozen=True, eq=False, kw_only=True)
class ThrownBox(Box):
    """A box that is thrown at the upper trunk, or dropped on the head.

    It flies over :data:`FLIGHT_DISTANCE` to the trunk, assumed to keep its velocity, or falls from
    :data:`DROP_HEIGHT` above the head. ``position`` and ``velocity`` are ignored.

    Attributes:
        speed: Horizontal speed [m/s]; zero drops the box.
        direction: Horizontal direction, 0 forward, a quarter turn to the left [rad].

    Raises:
        ParameterError: As :class:`Box`, or if the speed is neither zero nor from 2 to 50 m/s.
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speed: float = 0.0
    direction: float = 0.0

    def __post_init__(self):
        super().__post_init__()
        number("direction", self.direction, -MAX_ANGLE, MAX_ANGLE, "rad", "a box")
        if not (self.speed == 0 or 2 <= self.speed <= MAX_SPEED):
            raise ParameterError(
                f"speed={self.speed:g} m/s of a box must be 0 (dropped) or from 2 to {MAX_SPEED:g}"
            )

    @staticmethod
    def parse(word: str) -> "ThrownBox":
        """Return the box that a text describes: mass [kg], speed [m/s], direction [°], time [s].

        The box is a cube of :data:`BOX_DENSITY`.

        Raises:
            ParameterError: If the text has another form.

        Example:
            >>> ThrownBox.parse("2,5,180,1").size
            (0.2, 0.2, 0.2)
        """
        form = "KG,M_PER_S,DIRECTION_DEG,AT_S such as 2,5,180,1, from the front after 1 s; 0 drops"
        mass, speed, direction, at = parse_numbers(word, "box", form, 4)
        edge = float(np.cbrt(max(mass, 0.0) / BOX_DENSITY).round(6))
        turned = float(np.deg2rad(direction))
        return ThrownBox(mass=mass, size=(edge, edge, edge), speed=speed, direction=turned, time=at)

    def flight(self, world: SimulatedWorld) -> tuple[Float[Array, " 3"], Float[Array, " 3"]]:
        """Return the initial position [m] and velocity [m/s]."""
        data, body = world.data, body_index(world.human)
        place, speed = data.xipos[body].copy(), np.zeros(6)
        mujoco.mj_objectVelocity(world.model, data, mujoco.mjtObj.mjOBJ_BODY, body, speed, 0)
        if not self.speed:
            own = slice(1, len(world.human.body_names) + 1)
            head = world.human.body_names.index("head") + 1
            place[:2] = data.xipos[head, :2]
            place[2] = (
                float(data.xipos[own, 2].max()) + CROWN_HEIGHT + 0.5 * self.size[2] + DROP_HEIGHT
            )
            return place, np.array([*speed[3:5], 0.0])
        way = np.array([np.cos(self.direction), np.sin(self.direction), 0.0])
        time = FLIGHT_DISTANCE / self.speed
        rise = 0.5 * GRAVITY * time
        place += speed[3:] * [time, time, 0.0] - FLIGHT_DISTANCE * way
        return place, self.speed * way + [0.0, 0.0, rise]
