"""Moving ground: a heavy plate on joints, driven along a path, with the friction of the floor.

It is a body with joints and not one that is put from place to place: what MuJoCo calls mocap has no
velocity in a contact and carries nobody along.
"""

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world.disturbance import LATEST, TURNS, Disturbance, written_numbers

if TYPE_CHECKING:
    import plantigrade.world.world

HEAVY = 2e4
"""Mass and inertia of the plate [kg, kg m²]: no foot moves it."""
THICK = 0.2
"""Half its thickness [m]."""
HALF = 10.0
"""Half its length and width [m]."""
PULL = 60.0
"""How fast it returns to its path [rad/s]."""
JOINTS = ("platform_x", "platform_y", "platform_pitch", "platform_roll")


class Platform(Disturbance):
    """A moving level floor; a subclass defines its position over time.

    Attributes:
        half: Half its length and width [m].
    """

    interval = 0.005
    half = HALF

    @abstractmethod
    def place(self, time: float) -> Float[Array, " 4"]:
        """Return shift forward and left [m], and tilt: up in front, and up on the left [rad]."""

    def add(self, spec: mujoco.MjSpec, human: Human) -> None:
        """Put a plate on joints in the place of the floor.

        Raises:
            ParameterError: If the ground is not level, or two platforms meet.
        """
        floor = next((g for g in spec.worldbody.geoms if g.name == "floor"), None)
        others = [g.name for g in spec.worldbody.geoms if g.name.startswith(("bump", "relief"))]
        if floor is None or floor.type != mujoco.mjtGeom.mjGEOM_PLANE or others:
            raise ParameterError("ground that moves must be level, and there can be only one")
        body = spec.worldbody.add_body(name="platform", gravcomp=1.0)
        body.mass, body.ipos, body.inertia = HEAVY, [0.0, 0.0, 0.0], [HEAVY] * 3
        body.explicitinertial = True
        slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
        for name, kind, axis in zip(
            JOINTS,
            (slide, slide, hinge, hinge),
            ([1, 0, 0], [0, 1, 0], [0, -1, 0], [1, 0, 0]),
            strict=True,
        ):
            body.add_joint(name=name, type=kind, axis=axis)
        body.add_geom(
            name="floor_plate",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[self.half, self.half, THICK],
            pos=[0.0, 0.0, float(floor.pos[2]) - THICK],
            contype=0,
            conaffinity=floor.conaffinity,
            condim=floor.condim,
            friction=floor.friction,
            solref=floor.solref,
            rgba=floor.rgba,
        )
        spec.delete(floor)

    def reset(self, world: "plantigrade.world.world.World") -> None:
        """Be where the path begins."""
        if world.ground != Ground(friction=world.ground.friction):
            raise ParameterError("ground that moves must be level, at height zero, without a seat")
        first = world.model.joint(JOINTS[0])
        world.memory[self] = int(first.qposadr[0]), int(first.dofadr[0])
        q, v = world.memory[self]
        world.data.qpos[q : q + 4], world.data.qvel[v : v + 4], _ = self.path(0.0)

    def act(self, world: "plantigrade.world.world.World") -> None:
        """Follow the path: with its acceleration, and back to it where it is off."""
        q, v = world.memory[self]
        data = world.data
        place, speed, acceleration = self.path(world.time)
        off, slow = place - data.qpos[q : q + 4], speed - data.qvel[v : v + 4]
        wanted = acceleration + PULL**2 * off + 2 * PULL * slow
        data.qfrc_applied[v : v + 4] = HEAVY * wanted
        world.say("ground.place", data.qpos[q : q + 4].copy())

    def path(self, time: float) -> tuple[Array, Array, Array]:
        """Return place, speed and acceleration, by differences."""
        h = 1e-3
        before, now, after = (self.place(time + k * h) for k in (-1, 0, 1))
        return now, (after - before) / (2 * h), (after - 2 * now + before) / h**2


@dataclass(frozen=True, kw_only=True)
class Tilting(Platform):
    """A plate that sways about the start position of the person.

    Attributes:
        amplitude: Greatest slope [rad].
        period: Duration of one sway [s].
        direction: Which way it rises first: 0 in front, a quarter turn on the left [rad].

    Raises:
        ParameterError: If the slope is not below 45°, the period shorter than 0.1 s, or a number
            not finite.
    """

    amplitude: float
    period: float = 4.0
    direction: float = 0.0

    def __post_init__(self):
        """Refuse what is no sway."""
        sways = abs(self.amplitude) < np.pi / 4 and 0.1 <= self.period < np.inf
        if not (sways and np.isfinite(self.direction)):
            raise ParameterError(
                f"a plate tilts by less than 45° in at least 0.1 s towards a finite direction, not "
                f"{np.rad2deg(self.amplitude):g}° in {self.period:g} s towards "
                f"{np.rad2deg(self.direction):g}°"
            )

    def place(self, time: float) -> Float[Array, " 4"]:
        """Return a sine that grows to its full size in the first period."""
        u = min(max(time, 0.0) / self.period, 1.0)
        size = self.amplitude * u * u * (3 - 2 * u)
        tilt = size * np.sin(2 * np.pi * max(time, 0.0) / self.period)
        return np.array([0.0, 0.0, tilt * np.cos(self.direction), tilt * np.sin(self.direction)])


@dataclass(frozen=True, kw_only=True)
class FloorShift(Platform):
    """A floor that suddenly shifts and stays there.

    Attributes:
        distance: How far [m].
        duration: In what time [s].
        direction: Where to: 0 forward, a quarter turn left [rad].
        time: When it begins [s].

    Raises:
        ParameterError: If a number is out of range.
    """

    distance: float
    duration: float = 0.2
    direction: float = 0.0
    time: float = 1.0

    def __post_init__(self):
        """Refuse what is no shift."""
        number("distance", self.distance, -HALF / 2, HALF / 2, "m", "a shift")
        number("duration", self.duration, 0.02, LATEST, "s", "a shift")
        number("direction", self.direction, -TURNS, TURNS, "rad", "a shift")
        number("time", self.time, 0, LATEST, "s", "a shift")

    @staticmethod
    def written(word: str) -> "FloorShift":
        """Return the shift of a word: metres, seconds, direction in degrees, when [s].

        Raises:
            ParameterError: If it is none.

        Example:
            >>> FloorShift.written("0.1,0.2,180,1").distance
            0.1
        """
        form = "METRES,SECONDS,DIRECTION_DEG,AT_S such as 0.1,0.2,180,1, back after 1 s"
        distance, lasts, direction, at = written_numbers(word, "shift", form, 4)
        turned = float(np.deg2rad(direction))
        return FloorShift(distance=distance, duration=lasts, direction=turned, time=at)

    def edges(self) -> tuple[float, ...]:
        """Return when it begins and ends [s]."""
        return (self.time, self.time + self.duration)

    def place(self, time: float) -> Float[Array, " 4"]:
        """Return the path of least jerk."""
        u = float(np.clip((time - self.time) / self.duration, 0.0, 1.0))
        way = self.distance * u**3 * (10 - 15 * u + 6 * u * u)
        return np.array([way * np.cos(self.direction), way * np.sin(self.direction), 0.0, 0.0])
